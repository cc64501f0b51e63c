//! Ends paths at random, by what they have met scatters and by how far they have come.

use crate::geometry::{HitColumns, medium_met};
use crate::math::{F32s, LANES, lanes};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::sampler::Purpose;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::AnyPaths;

/// Segments after which even paths that lose nothing are played for.
const PATIENCE: u32 = 128;

/// Draws which paths go on behind the vertices that they have come to: their odds become the
/// probability of that, or 0 for those that lose, which have their vertices still, with all that
/// is measured and stored there. The probability is local to the event, so both modes play alike;
/// strategies are weighed without it.
///
/// Where fewer vertices do, those of paths that lose are `kept` with this probability, if the
/// paths do not go on with a greater one; the others hit nothing.
///
/// Beyond `PATIENCE` segments it is at most 1 - 1/n after n of them, so that a share of about
/// 1/n is left of any paths: neither light in a closed white room nor light caught in clear glass
/// keeps a render from ending, and a path of a length that is not extreme weighs a few times more.
///
/// From: trace_closest, fly_through_media, collect_emission. To: partition_paths, pay_out.
/// Writes: paths (odds, beta), hits. Reads: paths (identity), scene, flights.
pub fn play_roulette<const N: usize>(
    paths: &mut AnyPaths<N>,
    hits: &mut HitColumns,
    (scene, flights): (&Scene<N>, &FlightTable<N>),
    path_length: u32,
    kept: f32,
) {
    let longest = if path_length < PATIENCE { 1.0 } else { 1.0 - 1.0 / path_length as f32 };
    for row in (0..paths.len).step_by(LANES) {
        let [_, u] = paths.identity.draw(row, path_length, Purpose::Decision);
        for (lane, u) in u.to_array().into_iter().enumerate().take(paths.len - row) {
            let row = row + lane;
            let primitive = hits.primitive[row];
            if primitive == NONE {
                paths.odds[row] = 0.0;
                continue;
            }
            let survival = match medium_met(primitive) {
                Some(_) => flights.progress[row].survival,
                None => scene.material_at(primitive).survival,
            };
            let survival = survival.min(longest);
            let kept = kept.max(survival);
            // Whether one wins cannot be predicted: no branches.
            hits.primitive[row] = if u < kept { primitive } else { NONE };
            paths.beta.iter_mut().for_each(|beta| beta[row] /= kept);
            let odds = survival / kept;
            paths.odds[row] = if u < survival { odds } else { 0.0 };
        }
    }
}

/// Gives the paths that go on what those that have lost would have carried.
///
/// From: play_roulette. To: scatter_surfaces, scatter_medium.
/// Writes: paths (beta). Reads: paths (odds).
pub fn pay_out<const N: usize>(paths: &mut AnyPaths<N>) {
    for row in (0..paths.len).step_by(LANES) {
        let inverse = F32s::splat(1.0) / lanes::load(&paths.odds, row);
        for beta in &mut paths.beta {
            let paid = lanes::load(beta, row) * inverse;
            lanes::store(beta, row, paths.len, paid);
        }
    }
}
