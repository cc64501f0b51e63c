//! Measures the emitters that sensor paths meet.

use std::ops::Range;

use crate::geometry::HitColumns;
use crate::scattering::Scene;
use crate::transport::emission::{Finding, MetEmitter, measure_emission};
use crate::transport::sides::SensorSide;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::PathTable;

/// Adds what the rows see of the emitters that they have met.
///
/// From: trace_closest, fly_through_media, choose_passage. To: play_roulette, partition_paths,
/// the film.
/// Writes: measured. Reads: paths, hits, scene.
pub fn collect_emission<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    paths: &PathTable<N, C>,
    hits: &HitColumns,
    scene: &Scene<N>,
    finding: Finding,
) {
    let rows: Range<usize> = 0..paths.len;
    for row in rows {
        let primitive = hits.primitive[row];
        // What might have been passed has been seen on the way.
        let emitters = scene.emitters_seen(primitive);
        if emitters.is_empty() || scene.is_straight_on(primitive) {
            continue;
        }
        for emitter in emitters {
            let emitter = emitter as usize;
            let met = MetEmitter { row, t: hits.t[row], emitter, reaches: [1.0; N] };
            measure_emission(measured, paths, met, scene, finding);
        }
    }
}
