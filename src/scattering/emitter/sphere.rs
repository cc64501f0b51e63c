//! Emitting spheres. A point chooses directions to one within the cone that holds it, and by that
//! points of the cap it sees, as densely by solid angle as they are seen (pbrt-4, section 6.2.4).
//! Where both sides emit, points within one choose directions all over the sphere, those on it
//! within the half that goes through it; and where light passes it straight on, directions from
//! outside stand for what they meet first and what they meet then by halves.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::geometry::offset_distance;
use crate::math::{F32s, Real, Vector, warp};
use crate::scattering::immersion::{STEPS, spread};
use crate::scene::baked::{Bounds, Shapes};
use crate::scene::emitter::Sphere;

use super::area::Area;
use super::direct::{self, DirectLanes, Own, OwnLanes, Tables, finite, own, reachable};
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
        let [sides, shown] = [self.two_sided, self.shows_inside].map(|it| f32::from(u8::from(it)));
        let [inner2, outer2] = self.shell2(shapes);
        let start_pdf = probability / self.area;
        own([x, y, z, sphere.radius, start_pdf, inner2, outer2, sides, shown])
    }

    #[inline(always)]
    fn choose<const N: usize>(
        (own, _): (&OwnLanes, &Tables),
        reference: Vector<F32s>,
        radiance: [F32s; N],
        chance: F32s,
        u: [F32s; 2],
    ) -> DirectLanes<N> {
        let outside = from_outside(own, reference, radiance, chance, u);
        let &[x, y, z, _, _, _, outer2, ..] = own;
        let is_within = (Vector::new(x, y, z) - reference).length_squared().simd_lt(outer2);
        if is_within.none() {
            return outside;
        }
        direct::select(is_within, &from_within(own, reference, radiance, chance, u), &outside)
    }

    fn density(&self, shapes: &Shapes, reference: Vec3, point: Vec3, direction: Vec3) -> f32 {
        let sphere = self.shape(shapes);
        let distance2 = sphere.center.distance_squared(reference).max(f32::MIN_POSITIVE);
        let [inner2, outer2] = self.shell2(shapes);
        // The point may have been moved off a sphere that is as small as that.
        let normal = (point - sphere.center).normalize_or_zero();
        let to_point = point - reference;
        let per_solid_angle = if distance2 >= outer2 {
            let Cone { spread, .. } = Cone::about(sphere.radius * sphere.radius, distance2);
            let far = if self.shows_inside { 0.5 } else { 0.0 };
            let is_far = self.two_sided && to_point.dot(normal) > 0.0;
            let share = if is_far { far } else { 1.0 - far };
            share * 0.5 * FRAC_1_PI / spread
        } else if distance2 <= inner2 {
            0.25 * FRAC_1_PI
        } else if to_point.dot(sphere.center - reference) > 0.0 {
            0.5 * FRAC_1_PI
        } else {
            0.0
        };
        per_solid_angle * direction.dot(normal).abs() / to_point.length_squared()
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

    fn area(&self) -> Option<f32> {
        Some(self.area)
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

    fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    fn places(&self, shapes: &Shapes) -> Vec<(Vec3, Vec3)> {
        let sphere = self.shape(shapes);
        spread(PLACES).map(|normal| (sphere.center + normal * sphere.radius, normal)).collect()
    }
}

impl Sphere {
    /// The squares of distances from the center up to which points are within what shines to its
    /// inside, and from which on they are outside; between them they are on it.
    fn shell2(&self, shapes: &Shapes) -> [f32; 2] {
        if !self.two_sided {
            return [0.0; 2];
        }
        // Rays from it start off it.
        let step = STEPS * offset_distance(self.reach(shapes));
        let radius = self.shape(shapes).radius;
        [(radius - step).max(0.0), radius + step].map(|it| it * it)
    }
}

/// [`Emits::choose`] for points outside.
#[inline(always)]
fn from_outside<const N: usize>(
    &[x, y, z, radius, start_pdf, _, _, sides, shown, ..]: &OwnLanes,
    reference: Vector<F32s>,
    radiance: [F32s; N],
    chance: F32s,
    u: [F32s; 2],
) -> DirectLanes<N> {
    let (zero, one, half) = (F32s::splat(0.0), F32s::splat(1.0), F32s::splat(0.5));
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
    let is_far = shown.simd_gt(zero) & u[1].simd_ge(half);
    let turns = u[1] * (one + shown) - (is_far & one);
    let (sine, cosine) = warp::sin_cos_turns(turns);
    let tangent = axis.any_perpendicular();
    let around = tangent.mul_add(cosine, axis.cross(tangent) * sine);
    let bent_sine = (sine2_at_light * sine2).sqrt();
    let direction = around.mul_add(bent_sine, axis * (one - bent));
    // The angle at the center is that at the point less that at the reference.
    let along = sine2_at_light.mul_add(sine2.sqrt(), (one - bent) * cos_at_light);
    let across = (one - along * along).fast_max(zero).sqrt();
    let near = around.mul_add(across, axis * -along);
    let through = is_far & (cos_at_light + cos_at_light);
    let normal = direction.mul_add(through, near);
    // Nothing leaves the inside.
    let outside = distance2.simd_ge(radius * radius * F32s::splat(INSIDE));
    let cone_pdf = F32s::splat(0.5 * FRAC_1_PI) / spread;
    DirectLanes {
        direction,
        point: normal.mul_add(radius, center),
        normal,
        finite: finite::<Sphere>(),
        radiance: radiance.map(|radiance| outside & radiance),
        pdf_w: chance * cone_pdf * (one - half * shown),
        emission_pdf: start_pdf * cos_at_light * F32s::splat(FRAC_1_PI) / (one + sides),
        cos_at_light,
        reachable: reachable::<Sphere>(),
    }
}

/// [`Emits::choose`] for points within what shines to its inside, or on it.
#[inline(always)]
fn from_within<const N: usize>(
    &[x, y, z, radius, start_pdf, inner2, _, sides, ..]: &OwnLanes,
    reference: Vector<F32s>,
    radiance: [F32s; N],
    chance: F32s,
    u: [F32s; 2],
) -> DirectLanes<N> {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let to_center = Vector::new(x, y, z) - reference;
    let distance2 = to_center.length_squared();
    let distance = distance2.sqrt();
    let off_center = distance2.simd_gt(F32s::splat(f32::MIN_POSITIVE));
    let scale = one / Real::select(off_center, distance, one);
    let axis = Vector::select(off_center, to_center * scale, Vector::splat([0.0, 0.0, 1.0]));
    // What its cosine is less than one: up to two, or one for points on the sphere.
    let spread = Real::select(distance2.simd_gt(inner2), one, F32s::splat(2.0));
    let bent = u[0] * spread;
    let along = one - bent;
    let sine2 = bent * (F32s::splat(2.0) - bent);
    let (sine, cosine) = warp::sin_cos_turns(u[1]);
    let tangent = axis.any_perpendicular();
    let around = tangent.mul_add(cosine, axis.cross(tangent) * sine);
    let direction = around.mul_add(sine2.fast_max(zero).sqrt(), axis * along);
    let inverse = one / radius;
    let sine_at_light = distance * inverse;
    let cos2_at_light = one - sine_at_light * sine_at_light * sine2;
    let cos_at_light = cos2_at_light.fast_max(F32s::splat(1e-12)).sqrt();
    let way = radius.mul_add(cos_at_light, distance * along);
    let normal = (direction * way - to_center) * inverse;
    DirectLanes {
        direction,
        point: direction.mul_add(way, reference),
        normal,
        finite: finite::<Sphere>(),
        radiance,
        pdf_w: chance * F32s::splat(0.5 * FRAC_1_PI) / spread,
        emission_pdf: start_pdf * cos_at_light * F32s::splat(FRAC_1_PI) / (one + sides),
        cos_at_light,
        reachable: reachable::<Sphere>(),
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
    Area { area: sphere.area, two_sided: sphere.two_sided }
}
