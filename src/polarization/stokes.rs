//! The state of polarization of light.

use crate::math::Real;

/// Stokes parameters `(S0, S1, S2, S3)` in a frame `(x, y, k)` that the owner keeps beside them.
///
/// Physical where `S0 >= sqrt(S1^2 + S2^2 + S3^2)`. Units are those of whatever `S0` measures;
/// in a carrier they are relative to the scalar throughput and have none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stokes<F>(pub [F; 4]);

impl<F: Real> Stokes<F> {
    /// Unpolarized light of unit intensity, the same in every frame.
    #[inline(always)]
    pub fn unpolarized() -> Self {
        Self([F::one(), F::zero(), F::zero(), F::zero()])
    }

    /// The same state of polarization, `factor` times as intense.
    #[inline(always)]
    pub fn scaled(self, factor: F) -> Self {
        let [s0, s1, s2, s3] = self.0;
        Self([s0 * factor, s1 * factor, s2 * factor, s3 * factor])
    }
}
