//! The sides of a surface that reflects, and what shading normals do to them.
//!
//! With shading normals a direction counts only if it lies on the same side of the geometric and
//! of the shading normal. That rule is symmetric in the two directions, so that light and sensor
//! paths agree (Veach 1997, section 5.3).

use crate::math::{F32s, Vector};

/// The two normals of a surface point and whether its back reflects too.
#[derive(Clone, Copy)]
pub struct Facing {
    /// Geometric normal, to the front.
    pub geometric: Vector<F32s>,
    /// Shading normal, on the same side.
    pub shading: Vector<F32s>,
    /// Mask of the rows whose back scatters too.
    pub two_sided: F32s,
}

impl Facing {
    /// That of points that are on no surface.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = F32s::splat(0.0);
        let nowhere = Vector::new(zero, zero, zero);
        Self { geometric: nowhere, shading: nowhere, two_sided: zero }
    }

    /// Where light can go between the directions `given` and `drawn`, both away from the surface.
    #[inline(always)]
    pub fn reflects(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let zero = F32s::splat(0.0);
        let given_geometric = given.dot(self.geometric);
        let given_shading = given.dot(self.shading);
        let consistent = (given_geometric * given_shading).simd_gt(zero)
            & (given_geometric * drawn.dot(self.geometric)).simd_gt(zero)
            & (given_shading * drawn.dot(self.shading)).simd_gt(zero);
        consistent & (self.two_sided | given_geometric.simd_gt(zero))
    }

    /// Where light can go between the directions `given` and `drawn`, away from a surface that it
    /// may go through, too: each must be on one side by both normals.
    #[inline(always)]
    pub fn is_on_sides(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let zero = F32s::splat(0.0);
        let is_on_one =
            |v: Vector<F32s>| (v.dot(self.geometric) * v.dot(self.shading)).simd_gt(zero);
        is_on_one(given) & is_on_one(drawn)
    }

    /// The shading normal on the side of the direction `given`.
    #[inline(always)]
    pub fn shading_towards(&self, given: Vector<F32s>) -> Vector<F32s> {
        let below = given.dot(self.shading).simd_lt(F32s::splat(0.0));
        Vector::select(below, -self.shading, self.shading)
    }

    /// What a light path's throughput is multiplied by besides the sensor side's
    /// `f |cos shading|`, where light arrives from `given` and leaves along `drawn`
    /// (Veach 1997, equation 5.19). One where the normals agree.
    #[inline(always)]
    pub fn adjoint(&self, given: Vector<F32s>, drawn: Vector<F32s>) -> F32s {
        let shading = given.dot(self.shading) * drawn.dot(self.geometric);
        let geometric = given.dot(self.geometric) * drawn.dot(self.shading);
        (shading / geometric).abs()
    }
}
