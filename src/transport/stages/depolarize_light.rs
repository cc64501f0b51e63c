//! Ends the polarization of light at depolarizers.

use crate::math::columns::Channels;
use crate::math::{LANES, Vector, lanes};
use crate::transport::sides::LightSide;
use crate::transport::tables::classes::LightClass;
use crate::transport::tables::partition::Partition;

/// Folds the intensity of the rows that meet a depolarizer into their throughput.
///
/// From: resolve_surfaces, weigh_arrival, weigh_choice. To: store_light_vertices, store_photons,
/// scatter_surfaces, scatter_medium.
/// Writes: carriers, beta. Reads: partition.
pub fn depolarize_light<const N: usize, C: LightSide<N>>(
    carriers: &mut C,
    beta: &mut Channels<N>,
    partition: &Partition,
) {
    let Some(carriers) = carriers.columns_mut() else { return };
    let ends = partition.parts.iter().filter(|part| part.is_depolarized());
    for part in ends.filter(|part| LightClass::of(part).has_stokes()) {
        for row in part.rows.clone().step_by(LANES) {
            let x = Vector::load(&carriers.axis, row);
            for (n, beta) in beta.iter_mut().enumerate() {
                let gain = carriers.load(n, row, x).depolarized();
                lanes::scale(beta, row, part.rows.end, gain);
            }
        }
        carriers.class[part.rows.clone()].fill(LightClass::Unpolarized);
    }
}
