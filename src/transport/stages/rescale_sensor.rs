//! Keeps what sensor paths accept within the range of numbers.

use crate::math::columns::{Channels, Column};
use crate::transport::scale::{excess, scale_row};
use crate::transport::sides::SensorSide;
use crate::transport::tables::carriers::SensorCarriers;
use crate::transport::tables::classes::SensorClass;

/// Moves what the rows and matrices of the first `rows` rows have grown by into their throughput,
/// where that is much: they are relative to unpolarized light, and every sheet may double them.
///
/// From: collect_sensor. To: trace_closest, collect_sensor.
/// Writes: carriers, beta. Reads: rows.
pub fn rescale_sensor<const N: usize, C: SensorSide<N>>(
    carriers: &mut C,
    beta: &mut Channels<N>,
    rows: usize,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    for row in 0..rows {
        let class = carriers.class[row];
        for channel in 0..class.wavelengths::<N>() {
            let scale = excess(largest(carriers, class, (channel, row)));
            if scale == 1.0 {
                continue;
            }
            let wavelengths =
                if class == SensorClass::Common { 0..N } else { channel..channel + 1 };
            beta[wavelengths].iter_mut().for_each(|beta| beta[row] *= scale);
            scale_row(elements(carriers, class, channel), row, 1.0 / scale);
        }
    }
}

/// The largest magnitude of a row's elements that grow.
fn largest<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    class: SensorClass,
    (channel, row): (usize, usize),
) -> f32 {
    elements(carriers, class, channel)
        .fold(0.0, |largest: f32, column| largest.max(column[row].abs()))
}

/// The columns that grow: those of r, or of T.
fn elements<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    class: SensorClass,
    channel: usize,
) -> impl Iterator<Item = &mut Column> {
    let row = carriers.row.iter_mut().filter(move |_| class.has_row());
    let matrix = carriers.matrix.iter_mut().flatten().filter(move |_| class.has_matrix());
    row.chain(matrix).map(move |columns| &mut columns[channel])
}
