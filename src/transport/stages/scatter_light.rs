//! Applies Mueller kernels to the light side: `s <- M s` (paper, equation 8).

use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector};
use crate::polarization::kernel::{Block, Dense, SpheroidBlock};
use crate::polarization::{Arrival, LightCarrier};
use crate::scattering::event::Form;
use crate::transport::sides::LightSide;
use crate::transport::tables::carriers::LightCarriers;
use crate::transport::tables::classes::LightClass;
use crate::transport::tables::kernels::{KernelColumns, StoredKernel};
use crate::transport::tables::partition::{Part, Partition};

/// Extends the rows that meet polarizing events. `direction` is that of the arriving light.
///
/// From: scatter_surfaces, scatter_medium, cross_surfaces, rescale_light. To: advance_paths,
/// rescale_light.
/// Writes: carriers. Reads: kernels, direction, partition.
pub fn scatter_light<const N: usize, C: LightSide<N>>(
    carriers: &mut C,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    partition: &Partition,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    for part in &partition.parts {
        match part.event.form {
            Form::Depolarizer => {}
            Form::Block => scatter::<N, Block<F32s>>(carriers, kernels, direction, part),
            Form::Spheroid => scatter::<N, SpheroidBlock<F32s>>(carriers, kernels, direction, part),
            Form::Dense => scatter::<N, Dense<F32s>>(carriers, kernels, direction, part),
        }
    }
}

fn scatter<const N: usize, K: StoredKernel>(
    carriers: &mut LightCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    part: &Part,
) {
    match LightClass::of(part) {
        LightClass::Unpolarized => scatter_unpolarized::<N, K>(carriers, kernels, part),
        LightClass::Polarized => scatter_polarized::<N, K>(carriers, kernels, direction, part),
    }
    carriers.class[part.rows.clone()].fill(LightClass::Polarized);
}

/// `s = M e0`.
fn scatter_unpolarized<const N: usize, K: StoredKernel>(
    carriers: &mut LightCarriers<N>,
    kernels: &KernelColumns<N>,
    part: &Part,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        for channel in 0..N {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            carriers.store(channel, row, end, &LightCarrier::first_event(kernel, axis));
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `s <- M R s`.
fn scatter_polarized<const N: usize, K: StoredKernel>(
    carriers: &mut LightCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    part: &Part,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let x = Vector::load(&carriers.axis, row);
        let arrival = Arrival::between(x, axis, Vector::load(direction, row));
        for channel in 0..N {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let light = carriers.load(channel, row, x).scatter(&arrival, kernel);
            carriers.store(channel, row, end, &light);
        }
        axis.store(&mut carriers.axis, row, end);
    }
}
