//! Rays, and what they hit, as columns.

use crate::math::columns::{Column, columns};
use crate::math::{F32s, Vector};
use crate::scene::baked::NONE;

/// Marks, in the place of a primitive, that a ray ended in a medium before it met one; the row of
/// the medium is added. Smaller than [`NONE`].
pub const IN_MEDIUM: u32 = 1 << 31;

/// The medium of a primitive that is marked by [`IN_MEDIUM`].
#[inline(always)]
pub fn medium_met(primitive: u32) -> Option<u32> {
    (primitive >= IN_MEDIUM && primitive != NONE).then(|| primitive - IN_MEDIUM)
}

columns! {
    /// Rays.
    #[derive(Clone, Debug, PartialEq)]
    pub struct RayColumns of Ray {
        /// Origin, already off the surface it leaves (see [`super::offset_origin`]).
        pub origin: [Column; 3],
        /// Direction, unit length.
        pub direction: [Column; 3],
    }
}

impl RayColumns {
    /// Origins and directions of the eight rays from `row` on.
    #[inline(always)]
    pub(super) fn eight(&self, row: usize) -> (Vector<F32s>, Vector<F32s>) {
        (Vector::load(&self.origin, row), Vector::load(&self.direction, row))
    }
}

columns! {
    /// The nearest hits of rays.
    #[derive(Clone, Debug, PartialEq)]
    pub struct HitColumns of Hit {
        /// Distance in lengths of the direction; infinite when nothing is hit.
        pub t: Column,
        /// Barycentric weight of corner b, within [0, 1]; 0 for spheres.
        pub u: Column,
        /// Barycentric weight of corner c, within [0, 1]; 0 for spheres.
        pub v: Column,
        /// The primitive as [`crate::scene::baked::Shapes`] numbers them, [`NONE`], or a medium
        /// ([`IN_MEDIUM`]).
        pub primitive: Vec<u32> = NONE,
    }
}

impl Hit {
    /// Nothing is hit.
    pub const MISS: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: NONE };
}
