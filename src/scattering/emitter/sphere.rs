//! Emitting spheres. A point chooses directions to one within the cone that holds it, and by that
//! points of the cap it sees, as densely by solid angle as they are seen (pbrt-4, section 6.2.4).

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::math::{F32s, Real, Vector, warp};
use crate::scattering::immersion::spread;
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Sphere;

use super::area::Area;
use super::direct::{DirectLanes, Own, OwnLanes, finite, own, reachable};
use super::infinity::any_direction;
use super::tree::Outline;
use super::{EmissionSample, Emits, MetEmission, Source};

/// Points on a sphere where its media are looked for.
const PLACES: usize = 128;

impl Emits for Sphere {
    const DELTA: bool = false;

    fn record(&self, shapes: &Shapes, probability: f32) -> Own {
        let sphere = self.shape(shapes);
        let [x, y, z] = sphere.center.to_array();
        own([x, y, z, sphere.radius, probability / self.area])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        &[x, y, z, radius, start_pdf, ..]: &OwnLanes,
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let one = F32s::splat(1.0);
        let center = Vector::new(x, y, z);
        let to_center = center - reference;
        let distance2 = to_center.length_squared().fast_max(F32s::splat(f32::MIN_POSITIVE));
        let axis = to_center * (one / distance2.sqrt());
        let Cone { sine2, spread } = Cone::about(radius * radius, distance2);
        // The cosine to the axis is less than one by `bent`; its sine over that of the edge is that
        // of the angle at the point over one.
        let bent = u[0] * spread;
        let sine2_at_light = u[0] * (F32s::splat(2.0) - bent) / (F32s::splat(2.0) - spread);
        let cos_at_light = (one - sine2_at_light).fast_max(F32s::splat(1e-12)).sqrt();
        let (sine, cosine) = warp::sin_cos_turns(u[1]);
        let tangent = axis.any_perpendicular();
        let around = tangent.mul_add(cosine, axis.cross(tangent) * sine);
        let bent_sine = (sine2_at_light * sine2).sqrt();
        let direction = around.mul_add(bent_sine, axis * (one - bent));
        // The angle at the center is that at the point less that at the reference.
        let along = sine2_at_light.mul_add(sine2.sqrt(), (one - bent) * cos_at_light);
        let across = (one - along * along).fast_max(F32s::splat(0.0)).sqrt();
        let normal = around.mul_add(across, axis * -along);
        // Nothing leaves the inside.
        let outside = distance2.simd_ge(radius * radius * F32s::splat(INSIDE));
        DirectLanes {
            direction,
            point: normal.mul_add(radius, center),
            normal,
            finite: finite::<Self>(),
            radiance: radiance.map(|radiance| outside & radiance),
            pdf_w: chance * F32s::splat(0.5 * FRAC_1_PI) / spread,
            emission_pdf: start_pdf * cos_at_light * F32s::splat(FRAC_1_PI),
            cos_at_light,
            reachable: reachable::<Self>(),
        }
    }

    fn density(&self, shapes: &Shapes, reference: Vec3, point: Vec3, direction: Vec3) -> f32 {
        let sphere = self.shape(shapes);
        let distance2 = sphere.center.distance_squared(reference).max(f32::MIN_POSITIVE);
        let Cone { spread, .. } = Cone::about(sphere.radius * sphere.radius, distance2);
        // The point may have been moved off a sphere that is as small as that.
        let normal = (point - sphere.center).normalize_or_zero();
        let cos_at_light = direction.dot(normal).abs();
        0.5 * FRAC_1_PI / spread * cos_at_light / point.distance_squared(reference)
    }

    fn outline(&self, shapes: &Shapes) -> Outline {
        let sphere = self.shape(shapes);
        let seen = 0.25 * self.area;
        let (lower, upper) = (sphere.center - sphere.radius, sphere.center + sphere.radius);
        Outline { lower, upper, even: seen, area: seen, ..Outline::at(sphere.center) }
    }

    fn gain_of_aim(&self, shapes: &Shapes, ball: &Bounds) -> Option<f32> {
        let sphere = self.shape(shapes);
        // Of the points from which the ball is seen, one halfway between the nearest and the edge.
        let to_ball = (ball.center - sphere.center).normalize_or_zero();
        let normal =
            (to_ball + to_ball.any_orthogonal_vector().normalize_or_zero()).normalize_or_zero();
        area_of(self).gain_of_aim((sphere.center + normal * sphere.radius, normal), ball)
    }

    fn sides_of_area(&self) -> f32 {
        area_of(self).sides()
    }

    fn emit<const N: usize>(
        &self,
        source: &Source<N>,
        u_position: [f32; 2],
        u_direction: [f32; 2],
    ) -> EmissionSample<N> {
        let sphere = self.shape(source.shapes);
        let normal = any_direction(u_position);
        let point = sphere.center + normal * sphere.radius;
        area_of(self).emit::<Self, N>(source, (point, normal), u_direction)
    }

    fn met<const N: usize>(
        &self,
        source: &Source<N>,
        position: Vec3,
        direction: Vec3,
    ) -> Option<MetEmission<N>> {
        let outwards = source.shapes.geometric_normal(self.primitive, position);
        area_of(self).met(source, (outwards, direction))
    }

    fn reach(&self, shapes: &Shapes) -> f32 {
        let sphere = self.shape(shapes);
        sphere.center.abs().max_element() + sphere.radius
    }

    fn primitive(&self) -> u32 {
        self.primitive
    }

    fn places(&self, shapes: &Shapes) -> Vec<(Vec3, Vec3)> {
        let sphere = self.shape(shapes);
        spread(PLACES).map(|normal| (sphere.center + normal * sphere.radius, normal)).collect()
    }
}

/// Squares of distances from the center below this, over that of the radius, are inside beyond
/// doubt; between that and one a point may well be on the sphere.
const INSIDE: f32 = 1.0 - 1e-5;

/// The cone of directions that meet a sphere.
struct Cone<F> {
    /// Squared sine of the angle at its edge.
    sine2: F,
    /// What the cosine there is less than one: the solid angle over 2 pi.
    spread: F,
}

impl<F: Real> Cone<F> {
    /// From the squares of the sphere's radius and of the distance to its center; from inside, a
    /// half space.
    #[inline(always)]
    fn about(radius2: F, distance2: F) -> Self {
        let sine2 = (radius2 / distance2).min(F::one());
        let cosine = (F::one() - sine2).sqrt();
        Self { sine2, spread: sine2 / (F::one() + cosine) }
    }
}

/// The area that emits.
fn area_of(sphere: &Sphere) -> Area {
    Area { area: sphere.area, two_sided: false }
}
