//! Polarized light on its way between two vertices, one row at a time: what connections carry
//! from polarizing vertices, of which there are few enough not to need columns.

use crate::math::{LANES, Vector};
use crate::polarization::kernel::{Kernel, SpheroidBlock};
use crate::polarization::{Rotation, Stokes};

/// The polarization of light along a known direction, relative to its scalar value.
#[derive(Clone, Copy, Debug)]
pub struct LightState<const N: usize> {
    /// S0..S3 over what the scalar renderer carries.
    pub stokes: [[f32; N]; 4],
    /// The x axis of the frame, perpendicular to the direction.
    pub axis: Vector<f32>,
}

/// Kernels of one event.
pub type RowKernels<const N: usize> = [SpheroidBlock<f32>; N];

impl<const N: usize> LightState<N> {
    /// Unpolarized light after an event whose axis is `axis`: `M e0 = (1, a, 0, 0)`.
    #[inline(always)]
    pub fn scattered_unpolarized(kernels: &RowKernels<N>, axis: Vector<f32>) -> Self {
        let mut stokes = [[1.0; N], [0.0; N], [0.0; N], [0.0; N]];
        for (s1, kernel) in stokes[1].iter_mut().zip(kernels) {
            *s1 = kernel.a;
        }
        Self { stokes, axis }
    }

    /// The light after an event whose axis is `axis`, before which it travels along `k_in`.
    #[inline(always)]
    pub fn scattered(&self, kernels: &RowKernels<N>, axis: Vector<f32>, k_in: Vector<f32>) -> Self {
        let turn = Rotation::between(self.axis, axis, k_in);
        let mut stokes = self.stokes;
        for (n, kernel) in kernels.iter().enumerate() {
            let Stokes(after) = kernel.scatter(turn.apply(self.at(n)));
            for (component, &value) in stokes.iter_mut().zip(&after) {
                component[n] = value;
            }
        }
        Self { stokes, axis }
    }

    /// The same light in the frame of another axis; `k` is where it travels.
    #[inline(always)]
    pub fn turned(&self, axis: Vector<f32>, k: Vector<f32>) -> Self {
        let turn = Rotation::between(self.axis, axis, k);
        let mut stokes = self.stokes;
        for n in 0..N {
            let Stokes(after) = turn.apply(self.at(n));
            for (component, &value) in stokes.iter_mut().zip(&after) {
                component[n] = value;
            }
        }
        Self { stokes, axis }
    }

    /// The state at one wavelength.
    #[inline(always)]
    pub fn at(&self, n: usize) -> Stokes<f32> {
        Stokes([self.stokes[0][n], self.stokes[1][n], self.stokes[2][n], self.stokes[3][n]])
    }
}

/// Eight events as rows.
#[inline(always)]
pub fn kernels_of_lanes<const N: usize>(
    kernels: &[SpheroidBlock<crate::math::F32s>; N],
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
