//! Applies Mueller kernels to the sensor side: `t <- t M` (paper, section 4).

use glam::Vec3;

use crate::math::columns::Column;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::polarization::kernel::{Block, Dense, SpheroidBlock};
use crate::polarization::{Departure, Rotation, SensorMatrix, SensorRow, film_axis};
use crate::scattering::event::Form;
use crate::transport::sides::SensorSide;
use crate::transport::tables::carriers::SensorCarriers;
use crate::transport::tables::classes::SensorClass;
use crate::transport::tables::kernels::{KernelColumns, StoredKernel};
use crate::transport::tables::partition::{Part, Partition};

/// Extends the rows that meet polarizing events. `direction` is that of the sensor's ray before
/// the event, against the light; `film_up` fixes the film's frame.
///
/// From: scatter_surfaces, scatter_medium, cross_surfaces, rescale_sensor. To: advance_paths,
/// rescale_sensor.
/// Writes: carriers. Reads: kernels, direction, film_up, partition.
pub fn collect_sensor<const N: usize, C: SensorSide<N>>(
    carriers: &mut C,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    film_up: Vec3,
    partition: &Partition,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    for part in &partition.parts {
        let rays = (direction, film_up);
        match part.event.form {
            Form::Depolarizer => {}
            Form::Block => collect::<N, Block<F32s>>(carriers, kernels, rays, part),
            Form::Spheroid => collect::<N, SpheroidBlock<F32s>>(carriers, kernels, rays, part),
            Form::Dense => collect::<N, Dense<F32s>>(carriers, kernels, rays, part),
        }
    }
}

fn collect<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    (direction, film_up): (&[Column; 3], Vec3),
    part: &Part,
) {
    let before = SensorClass::of(part);
    let after = before.extended::<N>(part.event.form, part.event.achromatic);
    match before {
        SensorClass::Fresh if after.has_event() => {
            begin_once(carriers, kernels, (direction, film_up), part, after);
        }
        SensorClass::Fresh => {
            begin_matrix::<N, K>(carriers, kernels, (direction, film_up), part, after);
        }
        SensorClass::Once | SensorClass::OnceCommon => {
            extend_once::<N, K>(carriers, kernels, direction, part, [before, after]);
        }
        SensorClass::Full | SensorClass::Common => {
            extend_matrix::<N, K>(carriers, kernels, direction, part, [before, after]);
        }
        SensorClass::Plain => begin_row::<N, K>(carriers, kernels, part),
        SensorClass::Row => {
            extend_row::<N, K>(carriers, kernels, direction, part);
        }
    }
    carriers.class[part.rows.clone()].fill(after);
}

/// `R` and `B`, whose product is not needed yet, of the class `after`.
fn begin_once<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    (direction, film_up): (&[Column; 3], Vec3),
    part: &Part,
    after: SensorClass,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let ray = Vector::load(direction, row);
        let axis = Vector::load(&kernels.axis, row);
        let departure = Departure::between(axis, film_axis(ray, Vector::splat(film_up)), -ray);
        let Rotation { cos2, sin2 } = departure.rotation();
        let [of_cos2, of_sin2] = &mut carriers.rotation;
        lanes::store(of_cos2, row, end, cos2);
        lanes::store(of_sin2, row, end, sin2);
        for channel in 0..after.wavelengths::<N>() {
            let kernel = Block::load(kernels, part.event.channel(channel), row);
            carriers.store_event(channel, row, end, kernel);
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `T = R B R' B'`, of the event that was and another.
fn extend_once<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    part: &Part,
    [before, after]: [SensorClass; 2],
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let x = Vector::load(&carriers.axis, row);
        let departure = Departure::between(axis, x, -Vector::load(direction, row));
        for channel in 0..after.wavelengths::<N>() {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let sensor = carriers.load_event(before.channel_of(channel), row, x).matrix();
            carriers.store_matrix(channel, row, end, &sensor.collect(&departure, kernel));
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `T = R B`, of the class `after`.
fn begin_matrix<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    (direction, film_up): (&[Column; 3], Vec3),
    part: &Part,
    after: SensorClass,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let ray = Vector::load(direction, row);
        let axis = Vector::load(&kernels.axis, row);
        let departure = Departure::between(axis, film_axis(ray, Vector::splat(film_up)), -ray);
        for channel in 0..after.wavelengths::<N>() {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let sensor = SensorMatrix::first_event(&departure, kernel);
            carriers.store_matrix(channel, row, end, &sensor);
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `T <- T R B`.
fn extend_matrix<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    part: &Part,
    [before, after]: [SensorClass; 2],
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let x = Vector::load(&carriers.axis, row);
        let departure = Departure::between(axis, x, -Vector::load(direction, row));
        // The first last, as the others may begin from it.
        for channel in (0..after.wavelengths::<N>()).rev() {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let sensor = carriers.load_matrix(before.channel_of(channel), row, x);
            carriers.store_matrix(channel, row, end, &sensor.collect(&departure, kernel));
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `r = e0^T B`.
fn begin_row<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    part: &Part,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        for channel in 0..N {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            carriers.store_row(channel, row, end, &SensorRow::first_event(kernel, axis));
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `r <- r R B`.
fn extend_row<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Column; 3],
    part: &Part,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let x = Vector::load(&carriers.axis, row);
        let departure = Departure::between(axis, x, -Vector::load(direction, row));
        for channel in 0..N {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let sensor = carriers.load_row(channel, row, x).collect(&departure, kernel);
            carriers.store_row(channel, row, end, &sensor);
        }
        axis.store(&mut carriers.axis, row, end);
    }
}
