//! Ends the polarization of sensor paths at depolarizers.

use crate::math::columns::Channels;
use crate::math::{LANES, Vector, lanes};
use crate::transport::sides::SensorSide;
use crate::transport::tables::carriers::SensorCarriers;
use crate::transport::tables::classes::SensorClass;
use crate::transport::tables::partition::{Part, Partition};

/// Ends the rows that meet a depolarizer there: what they accept from now on is intensity, and
/// what scales it goes into the throughput.
///
/// From: resolve_surfaces, weigh_arrival. To: connect_to_emitters, connect_to_vertices,
/// merge_photons, scatter_surfaces, scatter_medium.
/// Writes: carriers, beta. Reads: partition.
pub fn depolarize_sensor<const N: usize, C: SensorSide<N>>(
    carriers: &mut C,
    beta: &mut Channels<N>,
    partition: &Partition,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    for part in partition.parts.iter().filter(|part| part.is_depolarized()) {
        let class = SensorClass::of(part);
        match class {
            SensorClass::Fresh | SensorClass::Plain | SensorClass::Column => {}
            SensorClass::Row | SensorClass::RankOne => end_rows(carriers, beta, part),
            SensorClass::Full | SensorClass::Common => end_matrices(carriers, beta, part, class),
        }
        carriers.class[part.rows.clone()].fill(class.depolarized());
    }
}

/// `beta <- beta r e0`.
fn end_rows<const N: usize>(carriers: &SensorCarriers<N>, beta: &mut Channels<N>, part: &Part) {
    for row in part.rows.clone().step_by(LANES) {
        let x = Vector::load(&carriers.axis, row);
        for (n, beta) in beta.iter_mut().enumerate() {
            let gain = carriers.load_row(n, row, x).depolarized();
            lanes::scale(beta, row, part.rows.end, gain);
        }
    }
}

/// `c = T e0`, its first element folded into the throughput.
fn end_matrices<const N: usize>(
    carriers: &mut SensorCarriers<N>,
    beta: &mut Channels<N>,
    part: &Part,
    class: SensorClass,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let x = Vector::load(&carriers.axis, row);
        for (n, beta) in beta.iter_mut().enumerate() {
            let matrix = carriers.load_matrix(class.channel_of(n), row, x);
            let (gain, column) = matrix.depolarized().normalized();
            carriers.store_column(n, row, end, column);
            lanes::scale(beta, row, end, gain);
        }
    }
}
