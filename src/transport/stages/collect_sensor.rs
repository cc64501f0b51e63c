//! Applies Mueller kernels to the sensor side: `t <- t M` (paper, section 4), and measures.

use std::ops::Range;

use glam::Vec3;

use crate::math::{F32s, LANES, Real, Vector, lanes};
use crate::polarization::kernel::{Block, SpheroidBlock};
use crate::polarization::{Rotation, Stokes, film_axis};
use crate::scattering::event::Form;
use crate::transport::tables::Channels;
use crate::transport::tables::carriers::{
    COLUMN, COMMON, CarrierTable, FRESH, FULL, PLAIN, RANK_ONE, ROW, SensorCarriers,
};
use crate::transport::tables::kernels::{KernelColumns, StoredKernel};
use crate::transport::tables::measured::Measured;
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::states::LightState;

use super::scatter_light::{copy_axis, multiply};

/// The verbs of the sensor side.
pub trait SensorSide<const N: usize>: CarrierTable {
    /// Starts all rows at a film of so many Stokes components: 1 or 4.
    fn start_at_film(&mut self, rows: usize, components: usize);

    /// Ends the rows that meet a depolarizer there: what they accept from now on is intensity.
    ///
    /// From: partition_paths. To: connect_to_emitters, scatter_diffuse.
    /// Writes: carriers, beta. Reads: partition.
    fn depolarize_sensor(&mut self, beta: &mut Channels<N>, partition: &Partition);

    /// Extends the rows that meet polarizing events. `direction` is that of the sensor's ray
    /// before the event, against the light; `film_up` fixes the film's frame.
    ///
    /// From: scatter_specular. To: advance_paths.
    /// Writes: carriers. Reads: kernels, direction, partition.
    fn collect_sensor(
        &mut self,
        kernels: &KernelColumns<N>,
        direction: &[Vec<f32>; 3],
        film_up: Vec3,
        partition: &Partition,
    );

    /// Adds unpolarized light of intensity `value` (throughput included) that a row meets.
    fn measure_unpolarized(
        &self,
        measured: &mut Measured<N>,
        row: usize,
        slot: usize,
        value: [f32; N],
    );

    /// Adds polarized light that a row meets: `light` is relative to the intensity `value`
    /// (throughput included) and travels along the direction of `along` into the subpath's end.
    /// `place` is the row and its slot.
    fn measure_polarized(
        &self,
        measured: &mut Measured<N>,
        place: (usize, usize),
        value: [f32; N],
        light: &LightState<N>,
        along: Along,
    );
}

/// A direction of light and the film's up, which between them name the frame of fresh rows.
pub type Along = (Vector<f32>, Vec3);

impl<const N: usize> SensorSide<N> for () {
    fn start_at_film(&mut self, _rows: usize, _components: usize) {}
    fn depolarize_sensor(&mut self, _beta: &mut Channels<N>, _partition: &Partition) {}
    fn collect_sensor(
        &mut self,
        _kernels: &KernelColumns<N>,
        _direction: &[Vec<f32>; 3],
        _film_up: Vec3,
        _partition: &Partition,
    ) {
    }
    #[inline(always)]
    fn measure_unpolarized(
        &self,
        measured: &mut Measured<N>,
        _row: usize,
        slot: usize,
        value: [f32; N],
    ) {
        measured.add_intensity(slot, value);
    }
    #[inline(always)]
    fn measure_polarized(
        &self,
        measured: &mut Measured<N>,
        (_row, slot): (usize, usize),
        value: [f32; N],
        _light: &LightState<N>,
        _along: Along,
    ) {
        measured.add_intensity(slot, value);
    }
}

impl<const N: usize> SensorSide<N> for SensorCarriers<N> {
    fn start_at_film(&mut self, rows: usize, components: usize) {
        // A film of intensities is e0 e0^T: it depolarizes.
        let class = if components == 1 { PLAIN } else { FRESH };
        self.class[..rows].fill(class as u8);
    }

    fn depolarize_sensor(&mut self, beta: &mut Channels<N>, partition: &Partition) {
        for part in partition.parts.iter().filter(|part| part.is_depolarized()) {
            let rows = part.rows.clone();
            let class = match part.class {
                FRESH | PLAIN => PLAIN,
                ROW => {
                    fold(beta, &self.row[0], rows.clone());
                    PLAIN
                }
                COLUMN => COLUMN,
                RANK_ONE => {
                    fold(beta, &self.row[0], rows.clone());
                    COLUMN
                }
                class => {
                    first_column(self, beta, rows.clone(), class);
                    COLUMN
                }
            };
            self.class[rows].fill(class as u8);
        }
    }

    fn collect_sensor(
        &mut self,
        kernels: &KernelColumns<N>,
        direction: &[Vec<f32>; 3],
        film_up: Vec3,
        partition: &Partition,
    ) {
        for part in &partition.parts {
            let rays = (direction, film_up);
            let class = match part.event.form {
                Form::Depolarizer => continue,
                Form::Block => collect::<N, Block<F32s>>(self, kernels, rays, part),
                Form::Spheroid => collect::<N, SpheroidBlock<F32s>>(self, kernels, rays, part),
            };
            self.class[part.rows.clone()].fill(class as u8);
        }
    }

    #[inline(always)]
    fn measure_unpolarized(
        &self,
        measured: &mut Measured<N>,
        row: usize,
        slot: usize,
        value: [f32; N],
    ) {
        let class = self.class(row);
        let gain = match class {
            ROW | RANK_ONE => Some(&self.row[0]),
            FULL | COMMON => Some(&self.matrix[0][0]),
            _ => None,
        };
        let accepted = match gain {
            Some(gain) => std::array::from_fn(|n| value[n] * gain[channel_of(class, n)][row]),
            None => value,
        };
        measured.add_intensity(slot, accepted);
        let (columns, value) = match class {
            COLUMN | RANK_ONE => (self.column.each_ref(), accepted),
            FULL | COMMON => ([1, 2, 3].map(|component: usize| &self.matrix[component][0]), value),
            _ => return,
        };
        for (sums, columns) in measured.at(slot)[1..].iter_mut().zip(columns) {
            for (n, (sum, value)) in sums.iter_mut().zip(&value).enumerate() {
                *sum += value * columns[channel_of(class, n)][row];
            }
        }
    }

    #[inline(always)]
    fn measure_polarized(
        &self,
        measured: &mut Measured<N>,
        (row, slot): (usize, usize),
        value: [f32; N],
        light: &LightState<N>,
        (k, film_up): Along,
    ) {
        let class = self.class(row);
        let light = match class {
            FRESH => light.turned(film_axis(-k, film_up.to_array().into()), k),
            FULL | COMMON | ROW | RANK_ONE => {
                light.turned(lanes::row_of(&self.axis, row).into(), k)
            }
            _ => *light,
        };
        for (n, &value) in value.iter().enumerate() {
            let stokes = self.accept(row, n, class, light.at(n));
            for (sums, &stokes) in measured.at(slot).iter_mut().zip(&stokes) {
                sums[n] += value * stokes;
            }
        }
    }
}

impl<const N: usize> SensorCarriers<N> {
    /// `T R s`: what the film's Stokes vector becomes per unit of scalar value, and the intensity
    /// that rows after a depolarizer accept.
    #[inline(always)]
    fn accept(&self, row: usize, n: usize, class: usize, stokes: Stokes<f32>) -> [f32; 4] {
        let Stokes(s) = stokes;
        match class {
            FRESH => s,
            FULL | COMMON => {
                let n = channel_of(class, n);
                let mut measured = [0.0; 4];
                for (measured, columns) in measured.iter_mut().zip(&self.matrix) {
                    *measured = columns.iter().zip(&s).map(|(m, s)| m[n][row] * s).sum();
                }
                measured
            }
            ROW | RANK_ONE => {
                let accepted: f32 = self.row.iter().zip(&s).map(|(r, s)| r[n][row] * s).sum();
                self.spread(row, n, class, accepted)
            }
            _ => self.spread(row, n, class, s[0]),
        }
    }

    #[inline(always)]
    fn spread(&self, row: usize, n: usize, class: usize, accepted: f32) -> [f32; 4] {
        let mut measured = [accepted, 0.0, 0.0, 0.0];
        if matches!(class, COLUMN | RANK_ONE) {
            for (measured, column) in measured[1..].iter_mut().zip(&self.column) {
                *measured = accepted * column[n][row];
            }
        }
        measured
    }
}

/// Wavelengths whose matrices rows of a class have.
#[inline(always)]
fn wavelengths<const N: usize>(class: usize) -> usize {
    if class == COMMON { 1 } else { N }
}

/// Where the matrix of a wavelength is.
#[inline(always)]
fn channel_of(class: usize, n: usize) -> usize {
    if class == COMMON { 0 } else { n }
}

/// Extends the rows of a part; their class from then on.
fn collect<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    (direction, film_up): (&[Vec<f32>; 3], Vec3),
    part: &Part,
) -> usize {
    match part.class {
        FRESH | FULL | COMMON => {
            let is_common = N > 1 && part.class != FULL && part.event.achromatic;
            let class = if is_common { COMMON } else { FULL };
            if part.class == FRESH {
                begin_matrix::<N, K>(carriers, kernels, direction, film_up, (part, class));
            } else {
                extend_matrix::<N, K>(carriers, kernels, direction, (part, class));
            }
            class
        }
        PLAIN => {
            begin_row(carriers, kernels, part);
            ROW
        }
        COLUMN => {
            begin_row(carriers, kernels, part);
            RANK_ONE
        }
        class => {
            extend_row::<N, K>(carriers, kernels, direction, part);
            class
        }
    }
}

/// Multiplies the throughput by a column of gains.
fn fold<const N: usize>(beta: &mut Channels<N>, gain: &Channels<N>, rows: Range<usize>) {
    for (beta, gain) in beta.iter_mut().zip(gain) {
        multiply(beta, gain, rows.clone());
    }
}

/// `c = T e0`, its first element folded into the throughput.
fn first_column<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    beta: &mut Channels<N>,
    rows: Range<usize>,
    class: usize,
) {
    for channel in 0..N {
        let from = channel_of(class, channel);
        for row in rows.clone().step_by(LANES) {
            let c0 = lanes::load(&carriers.matrix[0][0][from], row);
            // Where no light can pass, the direction of nothing is nothing.
            let positive = Real::gt(c0, F32s::splat(0.0));
            let inverse = Real::select(positive, F32s::splat(1.0) / c0, F32s::splat(0.0));
            for component in 1..4 {
                let c = lanes::load(&carriers.matrix[component][0][from], row) * inverse;
                lanes::store(&mut carriers.column[component - 1][channel], row, rows.end, c);
            }
        }
    }
    for (channel, beta) in beta.iter_mut().enumerate() {
        multiply(beta, &carriers.matrix[0][0][channel_of(class, channel)], rows.clone());
    }
}

/// `T = R B`, of the class that is named.
fn begin_matrix<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Vec<f32>; 3],
    film_up: Vec3,
    (part, class): (&Part, usize),
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let ray = Vector::load(direction, row);
        let axis = Vector::load(&kernels.axis, row);
        let turn = Rotation::between(axis, film_axis(ray, Vector::splat(film_up)), -ray);
        for channel in 0..wavelengths::<N>(class) {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            store_matrix(carriers, channel, row, end, kernel.first_event(turn));
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `T <- T R B`, of the class that is named from now on.
fn extend_matrix<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Vec<f32>; 3],
    (part, class): (&Part, usize),
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let turn = turn_to_carrier(&carriers.axis, axis, direction, row);
        // The first last, as the others may begin from it.
        for channel in (0..wavelengths::<N>(class)).rev() {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let from = channel_of(part.class, channel);
            let matrix = std::array::from_fn(|i| {
                std::array::from_fn(|j| lanes::load(&carriers.matrix[i][j][from], row))
            });
            let extended = kernel.collect_columns(turn.collect_matrix(matrix));
            store_matrix(carriers, channel, row, end, extended);
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// `e0^T B = (1, a, 0, 0)`.
fn begin_row<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    part: &Part,
) {
    let rows = part.rows.clone();
    for channel in 0..N {
        let a = &kernels.a[part.event.channel(channel)];
        carriers.row[0][channel][rows.clone()].fill(1.0);
        carriers.row[1][channel][rows.clone()].copy_from_slice(&a[rows.clone()]);
        carriers.row[2][channel][rows.clone()].fill(0.0);
        carriers.row[3][channel][rows.clone()].fill(0.0);
    }
    copy_axis(&mut carriers.axis, &kernels.axis, rows);
}

/// `r <- r R B`.
fn extend_row<const N: usize, K: StoredKernel>(
    carriers: &mut SensorCarriers<N>,
    kernels: &KernelColumns<N>,
    direction: &[Vec<f32>; 3],
    part: &Part,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let axis = Vector::load(&kernels.axis, row);
        let turn = turn_to_carrier(&carriers.axis, axis, direction, row);
        for channel in 0..N {
            let kernel = K::load(kernels, part.event.channel(channel), row);
            let old = std::array::from_fn(|i| lanes::load(&carriers.row[i][channel], row));
            let extended = kernel.collect_row(turn.collect_row(old));
            for (column, value) in carriers.row.iter_mut().zip(&extended) {
                lanes::store(&mut column[channel], row, end, *value);
            }
        }
        axis.store(&mut carriers.axis, row, end);
    }
}

/// From the event's axis to the carrier's, about the light that leaves the event.
#[inline(always)]
fn turn_to_carrier(
    carrier_axis: &[Vec<f32>; 3],
    event_axis: Vector<F32s>,
    direction: &[Vec<f32>; 3],
    row: usize,
) -> Rotation<F32s> {
    let light = -Vector::load(direction, row);
    Rotation::between(event_axis, Vector::load(carrier_axis, row), light)
}

#[inline(always)]
fn store_matrix<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    channel: usize,
    row: usize,
    end: usize,
    matrix: [[F32s; 4]; 4],
) {
    for (columns, values) in carriers.matrix.iter_mut().zip(&matrix) {
        for (column, value) in columns.iter_mut().zip(values) {
            lanes::store(&mut column[channel], row, end, *value);
        }
    }
}
