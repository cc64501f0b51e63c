//! The phase function of Henyey and Greenstein 1941, which depolarizes.

use std::f32::consts::PI;

use crate::math::{F32s, LANES, lanes};
use crate::polarization::kernel::SpheroidBlock;
use crate::scattering::event::{Depolarizer, Elements, Form};

use super::Scatters;

/// Isotropic where the mean cosine is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein<const N: usize> {
    /// Mean cosine of the scattering angle, within (-1, 1), positive forwards.
    pub g: [f32; N],
}

impl<const N: usize> Scatters<N> for HenyeyGreenstein<N> {
    const POLARIZES: bool = false;

    fn kernel(&self) -> (Form, bool) {
        (Form::Depolarizer, true)
    }

    fn moments(&self, wavelength: usize) -> [f32; 2] {
        let g = self.g[wavelength];
        [g, (1.0 + g * g) / (1.0 - g * g).powi(2)]
    }

    #[inline(always)]
    fn values(&self, half_sine2: F32s) -> [F32s; N] {
        let value = |g: f32| {
            let back = F32s::splat((1.0 - g) * (1.0 - g));
            let base = half_sine2.mul_add(F32s::splat(4.0 * g), back);
            F32s::splat((1.0 - g * g) * (0.25 / PI)) / (base * base.sqrt())
        };
        let [first, rest @ ..] = &self.g[..] else { return [F32s::splat(0.0); N] };
        let mut values = [value(*first); N];
        if rest.iter().any(|g| g != first) {
            values.iter_mut().zip(&self.g).for_each(|(of, g)| *of = value(*g));
        }
        values
    }

    #[inline(always)]
    fn sample(&self, wavelength: [u32; LANES], u: F32s) -> F32s {
        let g = F32s::from(lanes::each(|lane| self.g[wavelength[lane] as usize]));
        let one = F32s::splat(1.0);
        let (less, more) = (one - g, one + g);
        let inverse = one / (g * u).mul_add(F32s::splat(2.0), less);
        let half = less * (one - u) * inverse * F32s::splat(0.5);
        half * (less * more).mul_add(inverse, less)
    }

    #[inline(always)]
    fn kernels(&self, _: F32s) -> [SpheroidBlock<F32s>; N] {
        [Depolarizer.spheroid(); N]
    }

    #[inline(always)]
    fn values_and_kernels(&self, half_sine2: F32s) -> ([F32s; N], [SpheroidBlock<F32s>; N]) {
        (self.values(half_sine2), self.kernels(half_sine2))
    }
}
