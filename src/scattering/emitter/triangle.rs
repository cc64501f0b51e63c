//! Emitting triangles, which meshes of an emissive material are made of.

use glam::Vec3;

use crate::math::{F32s, Vector, warp};
use crate::scattering::immersion::Immersion;
use crate::scene::baked::Shapes;
use crate::scene::emitter::Triangle;

use super::area::{self, Area};
use super::direct::{DirectLanes, Own, OwnLanes, own};
use super::{EmissionSample, Emits, MetEmission, Source};

impl Emits for Triangle {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, _: f32) -> Own {
        let [a, b, c] = shapes.triangles[self.primitive as usize].corners;
        let (b, c) = (b - a, c - a);
        let n = b.cross(c).normalize();
        let sides = if self.two_sided { 1.0 } else { 0.0 };
        own([a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, n.x, n.y, n.z, 1.0 / self.area, sides])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        &[ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, per_area, sides, ..]: &OwnLanes,
        reference: Vector<F32s>,
        radiance: [F32s; N],
        probability: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let [a, b, c] = [Vector::new(ax, ay, az), Vector::new(bx, by, bz), Vector::new(cx, cy, cz)];
        let [v, w] = warp::triangle(u);
        let point = b.mul_add(v, c.mul_add(w, a));
        let normal = Vector::new(nx, ny, nz);
        area::choose::<Self, N>((point, normal), reference, radiance, probability * per_area, sides)
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
        area_of(self).met(source, -direction.dot(front))
    }

    fn media(&self, immersion: &Immersion) -> [u32; 2] {
        let [a, b, c] = immersion.shapes().triangles[self.primitive as usize].corners;
        let front = (b - a).cross(c - a).normalize();
        immersion.of_sides(self.primitive, (a + b + c) / 3.0, front)
    }
}

/// The area that emits.
fn area_of(triangle: &Triangle) -> Area {
    Area { area: triangle.area, two_sided: triangle.two_sided }
}
