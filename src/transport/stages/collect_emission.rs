//! Measures the emitters that sensor paths meet.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::HitColumns;
use crate::math::lanes;
use crate::scattering::Scene;
use crate::scattering::emission::{MetEmission, met_emission};
use crate::scene::baked::NONE;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::PathTable;

use super::collect_sensor::SensorSide;

/// How a met emitter shares the light with other ways to the same path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// Emission met by chance and next-event estimation (power heuristic).
    Unidirectional,
    /// All bidirectional strategies (balance heuristic).
    Bidirectional,
    /// Photons merged: what connections and photons find counts once by rule, and emitters count
    /// where nothing but specular events lies between them and the sensor.
    Merging,
}

/// Adds what the rows see of emitters after `path_length` segments.
///
/// From: trace_closest. To: play_roulette, partition_paths.
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
        let weight = match strategy {
            _ if path_length == 1 => 1.0,
            Strategy::Merging => 1.0,
            Strategy::Unidirectional => weight_of_chance(&met, paths.mis.pdf_w[row], hits.t[row]),
            Strategy::Bidirectional => {
                let mis = [paths.mis.d_vcm[row], paths.mis.d_vc[row]];
                weight_of_meeting(&met, mis, hits.t[row])
            }
        };
        let value = std::array::from_fn(|n| met.radiance[n] * paths.beta[n][row] * weight);
        let slot = paths.identity.slot[row] as usize;
        paths.carriers.measure_unpolarized(measured, row, slot, value);
    }
}

/// Power heuristic (Veach 1997, section 9.2.4) against choosing the point when connecting.
fn weight_of_chance<const N: usize>(met: &MetEmission<N>, pdf_w: f32, distance: f32) -> f32 {
    let measure = if distance.is_finite() { distance * distance / met.cos_at_light } else { 1.0 };
    let ratio = met.direct_pdf * measure / pdf_w;
    1.0 / (1.0 + ratio * ratio)
}

/// Balance heuristic over all strategies (Georgiev's technical report, equations 38 and 39), from
/// the partial weights on departure from the last vertex.
fn weight_of_meeting<const N: usize>(
    met: &MetEmission<N>,
    [d_vcm, d_vc]: [f32; 2],
    distance: f32,
) -> f32 {
    let square = if distance.is_finite() { distance * distance } else { 1.0 };
    let sensor = met.direct_pdf * d_vcm * square + met.emission_pdf * d_vc;
    1.0 / (1.0 + sensor / met.cos_at_light)
}
