//! Where a ray may leave a surface without meeting it again.
//!
//! The errors are those of the surface's own primitive: of its corners, and of the distances that
//! its test computes. What else there is in the scene, and how large that is, does not matter.

use crate::math::{Real, Vector};
use crate::scene::baked::{RELATIVE_OFFSET, Triangle};

/// How far off a surface rays start whose primitive has coordinates up to `reach`; also how far
/// before it they end that come from a point of such coordinates.
#[inline(always)]
pub fn offset_distance<F: Real>(reach: F) -> F {
    reach * F::splat(RELATIVE_OFFSET)
}

/// The largest magnitude of a coordinate.
#[inline(always)]
pub fn reach<F: Real>(point: Vector<F>) -> F {
    point.x.abs().max(point.y.abs()).max(point.z.abs())
}

/// [`reach`] of a triangle.
pub fn reach_of_triangle(Triangle { corners }: &Triangle) -> f32 {
    corners.iter().fold(0.0, |reach, corner| reach.max(corner.abs().max_element()))
}

/// The origin of a ray that leaves `position` along `direction`, off the surface with the unit
/// normal `geometric_normal` to the side that `direction` points to, by [`offset_distance`].
#[inline(always)]
pub fn offset_origin<F: Real>(
    position: Vector<F>,
    geometric_normal: Vector<F>,
    direction: Vector<F>,
    distance: F,
) -> Vector<F> {
    let leaves_back = geometric_normal.dot(direction).lt(F::zero());
    let signed = F::select(leaves_back, -distance, distance);
    geometric_normal.mul_add(signed, position)
}
