//! Ends paths at random, by what they have met scatters and nothing else.

use crate::geometry::HitColumns;
use crate::math::{LANES, lanes};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::paths::PathTable;

/// Rows that lose become rows that hit nothing; the others gain what those lose. The probability
/// is local to the event, so both modes play alike; strategies are weighed without it.
///
/// From: trace_closest, fly_through_media, collect_emission. To: partition_paths.
/// Writes: paths (beta), hits. Reads: paths (identity), scene.
pub fn play_roulette<const N: usize, C>(
    paths: &mut PathTable<N, C>,
    hits: &mut HitColumns,
    scene: &Scene<N>,
    path_length: u32,
) {
    for row in (0..paths.len).step_by(LANES) {
        let seed = lanes::load_u32(&paths.identity.seed, row);
        let iteration = lanes::load_u32(&paths.identity.iteration, row);
        let [_, u] = draw(seed, iteration, path_length, Purpose::Decision);
        for (lane, u) in u.to_array().into_iter().enumerate().take(paths.len - row) {
            let primitive = hits.primitive[row + lane];
            if primitive == NONE {
                continue;
            }
            let survival = scene.survival(primitive);
            if u >= survival {
                hits.primitive[row + lane] = NONE;
            } else {
                paths.beta.iter_mut().for_each(|beta| beta[row + lane] /= survival);
            }
        }
    }
}
