//! Ends the polarization of sensor paths at depolarizers.

use crate::math::columns::Channels;
use crate::math::{LANES, Vector, lanes};
use crate::polarization::SensorColumn;
use crate::transport::sides::SensorSide;
use crate::transport::tables::carriers::SensorCarriers;
use crate::transport::tables::classes::SensorClass;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::partition::{Part, Partition};
use crate::transport::tables::paths::IdentityColumns;

/// Ends the rows that meet a depolarizer there: what they accept from now on is intensity, what
/// scales it goes into the throughput, and the state that it has on the film to their slots.
///
/// From: resolve_surfaces, weigh_arrival. To: connect_to_emitters, connect_to_vertices,
/// merge_photons, scatter_surfaces, scatter_medium.
/// Writes: carriers, beta, measured. Reads: identity, partition.
pub fn depolarize_sensor<const N: usize, C: SensorSide<N>>(
    carriers: &mut C,
    beta: &mut Channels<N>,
    measured: &mut Measured<N>,
    identity: &IdentityColumns,
    partition: &Partition,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    for part in partition.parts.iter().filter(|part| part.is_depolarized()) {
        let class = SensorClass::of(part);
        match class {
            SensorClass::Fresh | SensorClass::Plain => {}
            SensorClass::Row => end_rows(carriers, beta, part),
            SensorClass::Once | SensorClass::OnceCommon => {
                end_events(carriers, (measured, identity), part, class);
            }
            SensorClass::Full | SensorClass::Common => {
                end_matrices(carriers, beta, (measured, identity), part, class);
            }
        }
        carriers.class[part.rows.clone()].fill(SensorClass::Plain);
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

/// `c = R B e0`, whose first element is one.
fn end_events<const N: usize>(
    carriers: &SensorCarriers<N>,
    (measured, identity): (&mut Measured<N>, &IdentityColumns),
    part: &Part,
    class: SensorClass,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let x = Vector::load(&carriers.axis, row);
        let slots = &identity.slot[row..end.min(row + LANES)];
        for n in 0..N {
            let event = carriers.load_event(class.channel_of(n), row, x);
            let SensorColumn(column) = event.depolarized();
            measured.set_columns(slots, n, column);
        }
    }
}

/// `c = T e0`, its first element folded into the throughput.
fn end_matrices<const N: usize>(
    carriers: &SensorCarriers<N>,
    beta: &mut Channels<N>,
    (measured, identity): (&mut Measured<N>, &IdentityColumns),
    part: &Part,
    class: SensorClass,
) {
    let end = part.rows.end;
    for row in part.rows.clone().step_by(LANES) {
        let x = Vector::load(&carriers.axis, row);
        let slots = &identity.slot[row..end.min(row + LANES)];
        for (n, beta) in beta.iter_mut().enumerate() {
            let matrix = carriers.load_matrix(class.channel_of(n), row, x);
            let (gain, SensorColumn(column)) = matrix.depolarized().normalized();
            measured.set_columns(slots, n, column);
            lanes::scale(beta, row, end, gain);
        }
    }
}
