//! Measures the emitters that sensor paths go straight on through.

use crate::geometry::Hit;
use crate::math::columns::Rows;
use crate::scattering::Scene;
use crate::transport::emission::{Finding, MetEmitter, measure_emission};
use crate::transport::sides::SensorSide;
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::PathTable;

/// Adds what the rows of a part see of the surfaces before which they are.
///
/// From: fly_to_crossings. To: choose_passage, the film.
/// Writes: measured. Reads: paths, crossing, flights, scene.
pub fn collect_crossed_emission<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    paths: &PathTable<N, C>,
    crossing: &Crossing<N>,
    flights: &FlightTable<N>,
    scene: &Scene<N>,
    finding: Finding,
) {
    let &Crossing { crossings, part, .. } = crossing;
    for index in part.rows.clone() {
        let row = crossings.row[index] as usize;
        let progress = &flights.progress[row];
        if !progress.is_over {
            let Hit { t, primitive, .. } = crossings.hits.get(index);
            let reaches = paths.media.reaching(row, &progress.depth, &progress.drawn);
            for emitter in scene.emitters_seen(primitive) {
                let met = MetEmitter { row, t, emitter: emitter as usize, reaches };
                measure_emission(measured, paths, met, scene, finding);
            }
        }
    }
}
