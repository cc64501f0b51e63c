//! Scattering by particles much smaller than the wavelength. The x axis of both frames is the
//! normal of the scattering plane, `unit(k_in x k_out)`; phase functions integrate to one.

use std::f64::consts::PI;

use super::kernel::{Block, SpheroidBlock};
use crate::math::Real;

/// Isotropic dipoles (Bohren and Huffman 1983, 5.6): `M00` in 1/sr and the kernel relative to it,
/// for the cosine of the angle between the light's directions before and after.
#[inline(always)]
pub fn rayleigh<F: Real>(cos_theta: F) -> (F, Block<F>) {
    let cos_squared = cos_theta * cos_theta;
    let scale = F::one() / (F::one() + cos_squared);
    let block = Block {
        a: (F::one() - cos_squared) * scale,
        c: (cos_theta + cos_theta) * scale,
        s: F::zero(),
    };
    (rayleigh_phase(cos_theta), block)
}

/// `M00` of [`rayleigh`], in 1/sr, and the same bits.
#[inline(always)]
pub fn rayleigh_phase<F: Real>(cos_theta: F) -> F {
    F::splat(3.0 / (16.0 * PI)) * (F::one() + cos_theta * cos_theta)
}

/// Anisotropic molecules (Hansen and Travis 1974, equations 2.15 and 2.16), with
/// `depolarization`, 0 to 1/2, the ratio of the two intensities scattered at 90 degrees from
/// unpolarized light. `M00` in 1/sr and the kernel relative to it.
#[inline(always)]
pub fn rayleigh_depolarized<F: Real>(cos_theta: F, depolarization: F) -> (F, SpheroidBlock<F>) {
    let (one, two) = (F::one(), F::splat(2.0));
    let ordered = (one - depolarization) / (one + F::splat(0.5) * depolarization);
    let circular = (one - two * depolarization) / (one - depolarization);
    let cos_squared = cos_theta * cos_theta;
    let dipole = F::splat(0.75) * ordered;
    let m00 = dipole.mul_add(one + cos_squared, one - ordered);
    let scale = dipole / m00;
    let block = SpheroidBlock {
        a: (one - cos_squared) * scale,
        b: (one + cos_squared) * scale,
        c: two * cos_theta * scale,
        d: two * cos_theta * scale * circular,
        s: F::zero(),
    };
    (F::splat(0.25 / PI) * m00, block)
}
