//! Applies Mueller kernels to the light side: `s <- M s` (paper, equation 8).

use std::ops::Range;

use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::polarization::kernel::{Block, SpheroidBlock};
use crate::polarization::{Rotation, Stokes};
use crate::scattering::event::Form;
use crate::scene::baked::NONE;
use crate::transport::tables::Channels;
use crate::transport::tables::carriers::{CarrierTable, LightCarriers, POLARIZED, UNPOLARIZED};
use crate::transport::tables::kernels::{KernelColumns, StoredKernel};
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::states::LightState;

/// The verbs of the light side.
pub trait LightSide<const N: usize>: CarrierTable {
    /// Folds the intensity of the rows that meet a depolarizer into their throughput.
    ///
    /// From: partition_paths. To: store_light_vertices, scatter_diffuse.
    /// Writes: carriers, beta. Reads: partition.
    fn depolarize_light(&mut self, beta: &mut Channels<N>, partition: &Partition);

    /// Extends the rows that meet polarizing events. `direction` is that of the arriving light.
    ///
    /// From: scatter_specular. To: advance_paths.
    /// Writes: carriers. Reads: kernels, direction, partition.
    fn scatter_light(
        &mut self,
        kernels: &KernelColumns<N>,
        direction: &[Vec<f32>; 3],
        partition: &Partition,
    );

    /// Appends the states of the rows that are polarized; `place` of each row is where its state
    /// went, or `NONE`.
    ///
    /// From: depolarize_light. To: connect_to_sensor, connect_to_vertices.
    /// Writes: states, place. Reads: carriers.
    fn keep_states(&self, states: &mut Vec<LightState<N>>, place: &mut [u32], rows: Range<usize>);

    /// The states of eight rows from `row` on, `live` of them in use, in the canonical frame of
    /// their `direction`: per wavelength, the factor of the intensity, and s1..s3 over it.
    fn states_about(&self, row: usize, live: usize, direction: Vector<F32s>) -> [[F32s; 4]; N];

    /// Forgets what earlier paths left: all rows start unpolarized.
    fn emit_unpolarized(&mut self, rows: usize);
}

impl<const N: usize> LightSide<N> for () {
    fn depolarize_light(&mut self, _beta: &mut Channels<N>, _partition: &Partition) {}
    fn scatter_light(
        &mut self,
        _kernels: &KernelColumns<N>,
        _direction: &[Vec<f32>; 3],
        _partition: &Partition,
    ) {
    }
    fn keep_states(
        &self,
        _states: &mut Vec<LightState<N>>,
        place: &mut [u32],
        _rows: Range<usize>,
    ) {
        place.fill(NONE);
    }
    fn states_about(&self, _row: usize, _live: usize, _direction: Vector<F32s>) -> [[F32s; 4]; N] {
        let zero = F32s::splat(0.0);
        [[F32s::splat(1.0), zero, zero, zero]; N]
    }
    fn emit_unpolarized(&mut self, _rows: usize) {}
}

impl<const N: usize> LightSide<N> for LightCarriers<N> {
    fn depolarize_light(&mut self, beta: &mut Channels<N>, partition: &Partition) {
        let depolarized = |part: &&Part| part.event.form == Form::Depolarizer;
        for part in partition.parts.iter().filter(depolarized) {
            if part.class == POLARIZED {
                for (beta, s0) in beta.iter_mut().zip(&self.stokes[0]) {
                    multiply(beta, s0, part.rows.clone());
                }
                self.class[part.rows.clone()].fill(UNPOLARIZED as u8);
            }
        }
    }

    fn scatter_light(
        &mut self,
        kernels: &KernelColumns<N>,
        direction: &[Vec<f32>; 3],
        partition: &Partition,
    ) {
        for part in &partition.parts {
            match (part.event.form, part.class) {
                (Form::Depolarizer, _) => continue,
                (_, UNPOLARIZED) => scatter_unpolarized(self, kernels, part),
                (Form::Block, _) => {
                    scatter_polarized::<N, Block<F32s>>(self, kernels, direction, part);
                }
                (Form::Spheroid, _) => {
                    scatter_polarized::<N, SpheroidBlock<F32s>>(self, kernels, direction, part);
                }
            }
            self.class[part.rows.clone()].fill(POLARIZED as u8);
        }
    }

    fn keep_states(&self, states: &mut Vec<LightState<N>>, place: &mut [u32], rows: Range<usize>) {
        for (place, row) in place.iter_mut().zip(rows) {
            if self.class(row) == UNPOLARIZED {
                *place = NONE;
                continue;
            }
            *place = states.len() as u32;
            let mut stokes = [[0.0; N]; 4];
            for (stokes, columns) in stokes.iter_mut().zip(&self.stokes) {
                for (stokes, column) in stokes.iter_mut().zip(columns) {
                    *stokes = column[row];
                }
            }
            states.push(LightState { stokes, axis: lanes::row_of(&self.axis, row).into() });
        }
    }

    fn states_about(&self, row: usize, live: usize, direction: Vector<F32s>) -> [[F32s; 4]; N] {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let mut states = [[one, zero, zero, zero]; N];
        let class = &self.class[row..row + live];
        if class.iter().all(|&class| class as usize == UNPOLARIZED) {
            return states;
        }
        let polarized =
            lanes::each(|lane| class.get(lane).is_some_and(|&class| class as usize == POLARIZED));
        let polarized = lanes::mask_of(polarized);
        let axis = Vector::load(&self.axis, row);
        let turn = Rotation::between(axis, direction.any_perpendicular(), direction);
        for (n, state) in states.iter_mut().enumerate() {
            let mut stokes = [zero; 4];
            for (stokes, column) in stokes.iter_mut().zip(&self.stokes) {
                *stokes = lanes::load(&column[n], row);
            }
            let Stokes([s0, s1, s2, s3]) = turn.apply(Stokes(stokes));
            // Where no light is left, no polarization is either.
            let lit = polarized & s0.simd_gt(zero);
            let inverse = lit & (one / s0);
            let factor = Real::select(polarized, s0, one);
            *state = [factor, s1, s2, s3];
            for value in &mut state[1..] {
                *value = lit & (*value * inverse);
            }
        }
        states
    }

    fn emit_unpolarized(&mut self, rows: usize) {
        self.class[..rows].fill(UNPOLARIZED as u8);
    }
}

/// `M e0 = (1, a, 0, 0)`.
fn scatter_unpolarized<const N: usize>(
    carriers: &mut LightCarriers<N>,
    kernels: &KernelColumns<N>,
    part: &Part,
) {
    for channel in 0..N {
        let a = &kernels.a[part.event.channel(channel)];
        let rows = part.rows.clone();
        carriers.stokes[0][channel][rows.clone()].fill(1.0);
        carriers.stokes[1][channel][rows.clone()].copy_from_slice(&a[rows.clone()]);
        carriers.stokes[2][channel][rows.clone()].fill(0.0);
        carriers.stokes[3][channel][rows].fill(0.0);
    }
    copy_axis(&mut carriers.axis, &kernels.axis, part.rows.clone());
}

fn scatter_polarized<const N: usize, K: StoredKernel>(
    carriers: &mut LightCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Vec<f32>; 3],
    part: &Part,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let turn = Rotation::between(
            Vector::load(&carriers.axis, row),
            axis,
            Vector::load(direction, row),
        );
        for channel in 0..N {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let stokes =
                Stokes(std::array::from_fn(|i| lanes::load(&carriers.stokes[i][channel], row)));
            let Stokes(scattered) = kernel.scatter(turn.apply(stokes));
            for (column, value) in carriers.stokes.iter_mut().zip(&scattered) {
                lanes::store(&mut column[channel], row, end, *value);
            }
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// Copies the rows of a vector column.
pub(super) fn copy_axis(to: &mut [Vec<f32>; 3], from: &[Vec<f32>; 3], rows: Range<usize>) {
    for (to, from) in to.iter_mut().zip(from) {
        to[rows.clone()].copy_from_slice(&from[rows.clone()]);
    }
}

/// `column *= factor` in place.
pub(super) fn multiply(column: &mut [f32], factor: &[f32], rows: Range<usize>) {
    for row in rows.clone().step_by(LANES) {
        let product = lanes::load(column, row) * lanes::load(factor, row);
        lanes::store(column, row, rows.end, product);
    }
}
