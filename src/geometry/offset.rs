//! Where a ray may leave a surface without meeting it again.

use glam::Vec3;

use crate::math::{Real, Vector};
use crate::scene::baked::Bounds;

/// Distance off the surface relative to the largest coordinate involved: 64 times the rounding
/// error of a coordinate. A reconstructed hit point is off by about 4 of these and the distances
/// that the triangle test computes by about 5 more.
const RELATIVE_OFFSET: f64 = 32.0 / (1 << 24) as f64;

/// How far off a surface rays start in a scene whose coordinates are bound by `reach`.
#[inline(always)]
pub fn offset_distance<F: Real>(reach: F) -> F {
    reach * F::splat(RELATIVE_OFFSET)
}

/// The largest magnitude that a coordinate in a scene within `bounds` can have.
pub fn reach(bounds: &Bounds) -> f32 {
    bounds.center.abs().max_element() + bounds.radius
}

/// The origin of a ray that leaves `position` along `direction`, off the surface with the unit
/// normal `geometric_normal` to the side that `direction` points to.
///
/// `reach` is a bound for the coordinates of the *primitive*, since the errors are those of its
/// corners, however close to the world's origin the position is; [`reach`] gives one that holds
/// for the whole scene.
#[inline(always)]
pub fn offset_origin<F: Real>(
    position: Vector<F>,
    geometric_normal: Vector<F>,
    direction: Vector<F>,
    reach: F,
) -> Vector<F> {
    let distance = offset_distance(reach);
    let leaves_back = geometric_normal.dot(direction).lt(F::zero());
    let signed = F::select(leaves_back, -distance, distance);
    geometric_normal.mul_add(signed, position)
}

/// [`offset_origin`] for one point.
pub fn offset_point(position: Vec3, normal: Vec3, direction: Vec3, reach: f32) -> Vec3 {
    let [position, normal, direction] =
        [position, normal, direction].map(|vector| Vector::from(vector.to_array()));
    Vec3::from_array(offset_origin(position, normal, direction, reach).into())
}
