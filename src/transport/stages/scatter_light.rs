//! Applies Mueller kernels to the light side: `s <- M s` (paper, equation 8).

use std::ops::Range;

use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::kernel::{Block, Kernel};
use crate::polarization::{Rotation, Stokes};
use crate::scene::baked::MaterialKind;
use crate::transport::tables::Channels;
use crate::transport::tables::carriers::{CarrierTable, LightCarriers, POLARIZED, UNPOLARIZED};
use crate::transport::tables::kernels::KernelColumns;
use crate::transport::tables::partition::{Part, Partition};

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
    fn emit_unpolarized(&mut self, _rows: usize) {}
}

impl<const N: usize> LightSide<N> for LightCarriers<N> {
    fn depolarize_light(&mut self, beta: &mut Channels<N>, partition: &Partition) {
        let diffuse = |part: &&Part| part.kind == MaterialKind::Diffuse;
        for part in partition.parts.iter().filter(diffuse) {
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
        for part in partition.parts.iter().filter(|part| part.kind != MaterialKind::Diffuse) {
            let rows = part.rows.clone();
            if part.class == POLARIZED {
                scatter_polarized(self, kernels, direction, part);
            } else {
                scatter_unpolarized(self, kernels, part);
            }
            self.class[rows].fill(POLARIZED as u8);
        }
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
        let a = &kernels.a[coefficient_channel(part.kind, channel)];
        let rows = part.rows.clone();
        carriers.stokes[0][channel][rows.clone()].fill(1.0);
        carriers.stokes[1][channel][rows.clone()].copy_from_slice(&a[rows.clone()]);
        carriers.stokes[2][channel][rows.clone()].fill(0.0);
        carriers.stokes[3][channel][rows].fill(0.0);
    }
    copy_axis(&mut carriers.axis, &kernels.axis, part.rows.clone());
}

fn scatter_polarized<const N: usize>(
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
            let block = load_block(kernels, coefficient_channel(part.kind, channel), row);
            let stokes =
                Stokes(std::array::from_fn(|i| lanes::load(&carriers.stokes[i][channel], row)));
            let Stokes(scattered) = block.scatter(turn.apply(stokes));
            for (column, value) in carriers.stokes.iter_mut().zip(&scattered) {
                lanes::store(&mut column[channel], row, end, *value);
            }
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// Which channel of the kernel columns holds the coefficients: they are stored once where they
/// do not depend on wavelength.
#[inline(always)]
pub(super) fn coefficient_channel(kind: MaterialKind, channel: usize) -> usize {
    if kind == MaterialKind::Conductor { channel } else { 0 }
}

/// Eight kernels.
#[inline(always)]
pub(super) fn load_block<const N: usize>(
    kernels: &KernelColumns<N>,
    channel: usize,
    row: usize,
) -> Block<F32s> {
    Block {
        a: lanes::load(&kernels.a[channel], row),
        c: lanes::load(&kernels.c[channel], row),
        s: lanes::load(&kernels.s[channel], row),
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
