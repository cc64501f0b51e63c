//! Paths that dispersion sends on at one wavelength: the first of the render's, the same for all
//! paths of an iteration, so that those of both sides meet ("hero wavelength": Wilkie et al. 2014).
//!
//! The throughput of the other wavelengths becomes negative zero where a path collapses, and stays
//! so: no product with what is not negative changes it. The sign at the second wavelength tells
//! paths that have collapsed from others, and vertices and photons keep it in their power.
//!
//! A path that goes on at one wavelength of N stands for N like it, once for all its events. Where
//! paths of both sides that have collapsed meet, one of their two factors is taken back.

use crate::math::columns::Channels;
use crate::math::{F32s, Real, U32s};

/// Mask of the lanes that have collapsed, by their throughput at the second wavelength.
#[inline(always)]
pub fn have_collapsed(second: F32s) -> F32s {
    const SIGN: u32 = 1 << 31;
    let sign = bytemuck::cast::<F32s, U32s>(second) & U32s::splat(SIGN);
    bytemuck::cast(sign.simd_eq(U32s::splat(SIGN)))
}

/// Whether a row has collapsed, by its throughput.
#[inline(always)]
pub fn has_collapsed<const N: usize>(beta: &Channels<N>, row: usize) -> bool {
    N > 1 && beta[1 % N][row].is_sign_negative()
}

/// Sends the lanes of the mask on at the first wavelength alone.
#[inline(always)]
pub fn collapse<const N: usize>(beta: &mut [F32s; N], alone: F32s) {
    let [first, others @ ..] = &mut beta[..] else { return };
    let Some(second) = others.first() else { return };
    let again = have_collapsed(*second);
    let stands_for = Real::select(again, F32s::splat(1.0), F32s::splat(N as f32));
    *first = Real::select(alone, *first * stands_for, *first);
    for other in others {
        *other = Real::select(alone, F32s::splat(-0.0), *other);
    }
}

/// The power at the first wavelength of lanes that paths meet which have collapsed, by that at the
/// second.
#[inline(always)]
pub fn met_by_collapsed<const N: usize>(first: F32s, second: F32s) -> F32s {
    Real::select(have_collapsed(second), first * F32s::splat(1.0 / N as f32), first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes;

    #[test]
    fn paths_collapse_once_and_are_known_by_it() {
        let mask = lanes::mask_of([true, true, false, false, true, false, true, false]);
        let mut beta = [F32s::splat(0.5), F32s::splat(0.25), F32s::splat(0.0)];
        for _ in 0..2 {
            collapse(&mut beta, mask);
            let known = have_collapsed(beta[1] * F32s::splat(0.0));
            assert_eq!(known.to_bitmask(), mask.to_bitmask());
            assert_eq!(beta[0].to_array(), [1.5, 1.5, 0.5, 0.5, 1.5, 0.5, 1.5, 0.5]);
            assert_eq!(beta[1].to_array(), [0.0, 0.0, 0.25, 0.25, 0.0, 0.25, 0.0, 0.25]);
        }
        let met = met_by_collapsed::<3>(beta[0], beta[1]);
        assert_eq!(met.to_array(), [0.5; 8]);
        let mut one = [F32s::splat(0.5)];
        collapse(&mut one, mask);
        assert_eq!(one[0].to_array(), [0.5; 8]);
    }
}
