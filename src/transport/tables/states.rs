//! Polarized light on its way between two vertices, one row at a time: what connections carry
//! from polarizing vertices, of which there are few enough not to need columns.

use crate::math::{F32s, LANES, Vector};
use crate::polarization::kernel::{Kernel, SpheroidBlock};
use crate::polarization::{Arrival, LightCarrier, Stokes};
use crate::scattering::emitter::state::EmittedState;
use crate::scattering::vertex::{DenseKernels, Leaving, LightLanes};

/// A [`LightCarrier`] of every wavelength, with one axis.
#[derive(Clone, Copy, Debug)]
pub struct LightState<const N: usize> {
    /// States over what the scalar renderer carries, in the frame of `x`.
    pub stokes: [Stokes<f32>; N],
    /// The reference axis, perpendicular to the direction.
    pub x: Vector<f32>,
}

/// Kernels of one event.
type RowKernels<const N: usize> = [SpheroidBlock<f32>; N];

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

    /// Unpolarized light.
    #[inline(always)]
    pub fn unpolarized(x: Vector<f32>) -> Self {
        Self { stokes: [Stokes::unpolarized(); N], x }
    }

    /// Light as it leaves its emitter.
    pub fn emitted(state: &EmittedState<N>) -> Self {
        let stokes = state.stokes.map(|[s1, s2, s3]| Stokes([1.0, s1, s2, s3]));
        Self { stokes, x: Vector::from(state.x.to_array()) }
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
fn kernels_of_lanes<const N: usize>(kernels: &[SpheroidBlock<F32s>; N]) -> [RowKernels<N>; LANES] {
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

/// Says `to` what light leaves the vertices in some lanes by their kernels, which has arrived there
/// along `k_in` in a state, or unpolarized.
#[inline(always)]
pub fn scatter_states<'a, const N: usize>(
    leaving: &Leaving<N>,
    k_in: Vector<F32s>,
    lanes: impl Iterator<Item = usize> + Clone,
    state: impl Fn(usize) -> Option<&'a LightState<N>>,
    mut to: impl FnMut(usize, &LightState<N>),
) {
    let (kernels, axis) = match leaving {
        Leaving::Blocks(kernels) => kernels,
        Leaving::Dense(kernels) => {
            let mut rows =
                k_in.any_perpendicular().to_rows().map(|x| LightState::unpolarized(x.into()));
            lanes.clone().for_each(|lane| rows[lane] = *state(lane).unwrap_or(&rows[lane]));
            scatter_densely(kernels, k_in, &mut rows);
            lanes.for_each(|lane| to(lane, &rows[lane]));
            return;
        }
    };
    let kernels = kernels_of_lanes(kernels);
    let (axis, k_in) = (axis.to_rows(), k_in.to_rows());
    for lane in lanes {
        let [axis, k_in] = [axis[lane], k_in[lane]].map(Vector::from);
        let light = match state(lane) {
            None => LightState::first_event(&kernels[lane], axis),
            Some(state) => state.scatter(&kernels[lane], axis, k_in),
        };
        to(lane, &light);
    }
}

/// Eight rows of light by vertices with dense kernels: out of line, as they are few, and what they
/// do takes longer than a call.
#[inline(never)]
fn scatter_densely<const N: usize>(
    kernels: &DenseKernels<N>,
    k_in: Vector<F32s>,
    rows: &mut [LightState<N>; LANES],
) {
    let lanes = |of: &dyn Fn(&LightState<N>) -> f32| F32s::from(rows.each_ref().map(of));
    let component = |n: usize, i: usize| lanes(&|row| row.stokes[n].0[i]);
    let stokes = |n: usize| Stokes([0, 1, 2, 3].map(|i| component(n, i)));
    let x = Vector::gather(|lane| <[f32; 3]>::from(rows[lane].x));
    let mut light = LightLanes { stokes: std::array::from_fn(stokes), x };
    light.pass(k_in, kernels);
    let x = light.x.to_rows();
    let components = light.stokes.map(|Stokes(of)| of.map(F32s::to_array));
    for (lane, row) in rows.iter_mut().enumerate() {
        let stokes = components.map(|of| Stokes(of.map(|component| component[lane])));
        *row = LightState { stokes, x: x[lane].into() };
    }
}
