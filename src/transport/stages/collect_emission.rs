//! Measures the emitters that sensor paths meet.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::HitColumns;
use crate::math::lanes;
use crate::scattering::Scene;
use crate::scattering::emitter::{MetEmission, met_emission};
use crate::scene::baked::NONE;
use crate::transport::Strategy;
use crate::transport::measure::measure_unpolarized;
use crate::transport::mis::{self, EmitterDensities};
use crate::transport::sides::SensorSide;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::PathTable;

/// Adds what the rows see of emitters after `path_length` segments.
///
/// From: trace_closest, fly_through_media. To: play_roulette, partition_paths, the film.
/// Writes: measured. Reads: paths, hits, scene.
pub fn collect_emission<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    paths: &PathTable<N, C>,
    hits: &HitColumns,
    scene: &Scene<N>,
    path_length: u32,
    strategy: Strategy,
) {
    let rows: Range<usize> = 0..paths.len;
    for row in rows {
        let primitive = hits.primitive[row];
        if scene.emitter_seen(primitive) == NONE {
            continue;
        }
        let direction = Vec3::from(lanes::row_of(&paths.rays.direction, row));
        let position = Vec3::from(lanes::row_of(&paths.rays.origin, row)) + direction * hits.t[row];
        let Some(met) = met_emission(scene, primitive, position, direction) else { continue };
        let MetEmission { direct_pdf, emission_pdf, cos_at_light, .. } = met;
        let emitter = EmitterDensities { direct_pdf, emission_pdf, cos_at_light };
        let distance = hits.t[row];
        let distance2 = if distance.is_finite() { distance * distance } else { 1.0 };
        let weight = match strategy {
            _ if path_length == 1 => 1.0,
            Strategy::Merging => 1.0,
            Strategy::Unidirectional => {
                mis::power_of_emission_met(paths.mis.pdf_w[row], emitter, distance2)
            }
            Strategy::Bidirectional => {
                mis::weight_of_emission_met(paths.mis.row(row), emitter, distance2)
            }
        };
        let value = std::array::from_fn(|n| met.radiance[n] * paths.beta[n][row] * weight);
        let slot = paths.identity.slot[row] as usize;
        measure_unpolarized(measured, &paths.carriers, (row, slot), value);
    }
}
