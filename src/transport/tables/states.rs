//! Polarized light on its way between two vertices, one row at a time: what connections carry
//! from polarizing vertices, of which there are few enough not to need columns.

use crate::math::{F32s, LANES, Vector};
use crate::polarization::kernel::{Kernel, SpheroidBlock};
use crate::polarization::{Arrival, LightCarrier, Stokes};

/// A [`LightCarrier`] of every wavelength, with one axis.
#[derive(Clone, Copy, Debug)]
pub struct LightState<const N: usize> {
    /// States over what the scalar renderer carries, in the frame of `x`.
    pub stokes: [Stokes<f32>; N],
    /// The reference axis, perpendicular to the direction.
    pub x: Vector<f32>,
}

/// Kernels of one event.
pub type RowKernels<const N: usize> = [SpheroidBlock<f32>; N];

impl<const N: usize> LightState<N> {
    /// What every wavelength carries, for the axis `x`.
    #[inline(always)]
    pub fn of_wavelengths(x: Vector<f32>, light: impl Fn(usize) -> LightCarrier<f32>) -> Self {
        let mut stokes = [Stokes([0.0; 4]); N];
        for (n, stokes) in stokes.iter_mut().enumerate() {
            *stokes = light(n).stokes;
        }
        Self { stokes, x }
    }

    /// One wavelength.
    #[inline(always)]
    pub fn at(&self, n: usize) -> LightCarrier<f32> {
        LightCarrier { stokes: self.stokes[n], x: self.x }
    }

    /// Unpolarized light after an event whose axis is `x`.
    #[inline(always)]
    pub fn first_event<K: Kernel<f32>>(kernels: &[K; N], x: Vector<f32>) -> Self {
        Self::of_wavelengths(x, |n| LightCarrier::first_event(kernels[n], x))
    }

    /// The light after an event whose axis is `x`, before which it travels along `k_in`.
    #[inline(always)]
    pub fn scatter<K: Kernel<f32>>(
        &self,
        kernels: &[K; N],
        x: Vector<f32>,
        k_in: Vector<f32>,
    ) -> Self {
        let arrival = Arrival::between(self.x, x, k_in);
        Self::of_wavelengths(x, |n| self.at(n).scatter(&arrival, kernels[n]))
    }

    /// The same light in the frame of another axis `x`; `k` is where it travels.
    #[inline(always)]
    pub fn turned(&self, x: Vector<f32>, k: Vector<f32>) -> Self {
        let arrival = Arrival::between(self.x, x, k);
        Self::of_wavelengths(x, |n| self.at(n).turned(&arrival))
    }
}

/// Eight events as rows.
#[inline(always)]
pub fn kernels_of_lanes<const N: usize>(
    kernels: &[SpheroidBlock<F32s>; N],
) -> [RowKernels<N>; LANES] {
    let none = SpheroidBlock { a: 0.0, b: 0.0, c: 0.0, d: 0.0, s: 0.0 };
    let mut rows = [[none; N]; LANES];
    for (n, kernel) in kernels.iter().enumerate() {
        let [a, b, c, d, s] =
            [&kernel.a, &kernel.b, &kernel.c, &kernel.d, &kernel.s].map(|lanes| lanes.to_array());
        for (lane, row) in rows.iter_mut().enumerate() {
            row[n] = SpheroidBlock { a: a[lane], b: b[lane], c: c[lane], d: d[lane], s: s[lane] };
        }
    }
    rows
}
