//! Emitting triangles, which meshes of an emissive material are made of.

use glam::Vec3;

use crate::geometry::reach_of_triangle;
use crate::math::{F32s, Real, Vector, warp};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Triangle;

use super::area::{self, Area};
use super::direct::{DirectLanes, OWN, Own, OwnLanes, Tables};
use super::spherical::SphericalTriangle;
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

/// Points along its edges where a triangle's media are looked for.
const PLACES: u32 = 12;

impl Emits for Triangle {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        let [a, b, c] = shapes.triangles[self.primitive as usize].corners;
        let (b, c) = (b - a, c - a);
        let n = b.cross(c).normalize();
        let sides = if self.two_sided { 1.0 } else { 0.0 };
        let per_area = 1.0 / self.area;
        let start_pdf = probability * per_area;
        let [a, b, c, n] = [a, b, c, n].map(|vector| vector.to_array());
        let densities = [per_area, start_pdf, sides];
        let mut own = [0.0; OWN];
        for (to, from) in own.iter_mut().zip([a, b, c, n, densities].as_flattened()) {
            *to = *from;
        }
        own
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (own, _): (&OwnLanes, &Tables),
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let &[ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, per_area, start_pdf, sides, _] = own;
        let [a, b, c] = [Vector::new(ax, ay, az), Vector::new(bx, by, bz), Vector::new(cx, cy, cz)];
        let [v, w] = warp::triangle(u);
        let mut point = b.mul_add(v, c.mul_add(w, a));
        let normal = Vector::new(nx, ny, nz);
        let corner = a - reference;
        let corners = [corner, corner + b, corner + c];
        let densities = [chance * per_area, start_pdf];
        let by_area =
            |point| area::choose::<Self, N>((point, normal), reference, radiance, densities, sides);
        if SphericalTriangle::may_be_large(corners).none() {
            return by_area(point);
        }
        let seen = SphericalTriangle::new(corners);
        let is_large = seen.is_large();
        if is_large.none() {
            return by_area(point);
        }
        let direction = seen.direction(u);
        let distance = corner.dot(normal) / direction.dot(normal);
        point = Vector::select(is_large, direction.mul_add(distance, reference), point);
        let chosen = by_area(point);
        let pdf_w = Real::select(is_large, chance / seen.solid_angle(), chosen.pdf_w);
        DirectLanes { pdf_w, ..chosen }
    }

    fn density(&self, shapes: &Shapes, reference: Vec3, point: Vec3, direction: Vec3) -> f32 {
        let corners = shapes.triangles[self.primitive as usize].corners;
        let seen = SphericalTriangle::new(corners.map(|it| (it - reference).to_array().into()));
        if !seen.is_large() {
            return 1.0 / self.area;
        }
        let [a, b, c] = corners;
        let cosine = direction.dot((b - a).cross(c - a).normalize()).abs();
        cosine / (seen.solid_angle() * point.distance_squared(reference))
    }

    fn outline(&self, shapes: &Shapes) -> Outline {
        let [a, b, c] = shapes.triangles[self.primitive as usize].corners;
        Outline {
            lower: a.min(b).min(c),
            upper: a.max(b).max(c),
            axis: (b - a).cross(c - a).normalize() * self.area,
            two_sided: self.two_sided,
            area: self.area,
            ..Outline::at(a)
        }
    }

    fn gain_of_aim(&self, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
        let [a, b, c] = shapes.triangles[self.primitive as usize].corners;
        let middle = (a + b + c) / 3.0;
        area_of(self).gain_of_aim((middle, (b - a).cross(c - a).normalize()), ball)
    }

    fn area(&self) -> Option<f32> {
        Some(self.area)
    }

    fn sides_of_area(&self) -> f32 {
        area_of(self).sides()
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        [u, v]: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let [a, b, c] = source.shapes.triangles[self.primitive as usize].corners;
        // Heitz 2019, as `math::warp::triangle`.
        let (v, w) = if u > v { (u - 0.5 * v, 0.5 * v) } else { (0.5 * u, v - 0.5 * u) };
        let point = a + (b - a) * v + (c - a) * w;
        let front = (b - a).cross(c - a).normalize();
        area_of(self).emit::<Self, N>(source, (point, front), u_direction)
    }

    fn met<const N: usize>(
        &self,
        source: &Source<N>,
        position: Vec3,
        direction: Vec3,
    ) -> Option<MetEmission<N>> {
        let front = source.shapes.geometric_normal(self.primitive, position);
        area_of(self).met(source, (front, direction))
    }

    fn reach(&self, shapes: &Shapes) -> f32 {
        reach_of_triangle(&shapes.triangles[self.primitive as usize])
    }

    fn primitive(&self) -> u32 {
        self.primitive
    }

    fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    fn places(&self, shapes: &Shapes) -> Vec<(Vec3, Vec3)> {
        let [a, b, c] = shapes.triangles[self.primitive as usize].corners;
        let front = (b - a).cross(c - a).normalize();
        let at = |[u, v]: [f32; 2]| (a + (b - a) * u + (c - a) * v, front);
        let steps = (0..=PLACES).map(|step| 0.001 + 0.998 * step as f32 / PLACES as f32);
        let inside = steps.clone().flat_map(|u| steps.clone().map(move |v| [u, v]));
        inside.filter(|[u, v]| u + v < 1.0).chain([[1.0 / 3.0; 2]]).map(at).collect()
    }
}

/// The area that emits.
fn area_of(triangle: &Triangle) -> Area {
    Area { area: triangle.area, two_sided: triangle.two_sided }
}
