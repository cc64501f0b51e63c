//! Decides which paths pass surfaces that scatter some.

use crate::geometry::HitColumns;
use crate::math::U32s;
use crate::math::columns::Rows;
use crate::math::hash::combine;
use crate::transport::sampler::{Purpose, draw_first};
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::AnyPaths;

/// Ends the segments of those rows of a part which do not pass: they are scattered there.
///
/// From: pass_surfaces, fly_to_crossings, collect_crossed_emission, store_crossed_photons. To:
/// cross_surfaces, collect_emission.
/// Writes: hits, flights. Reads: paths, crossing.
pub fn choose_passage<const N: usize>(
    hits: &mut HitColumns,
    flights: &mut FlightTable<N>,
    paths: &AnyPaths<N>,
    crossing: &Crossing<N>,
    path_length: u32,
) {
    let &Crossing { crossings, part, .. } = crossing;
    if !part.kind.scatters() {
        return;
    }
    for index in part.rows.clone() {
        let row = crossings.row[index] as usize;
        let progress = &mut flights.progress[row];
        if progress.is_over {
            continue;
        }
        // Every crossing of a segment has a sequence of its own.
        let seed = combine(paths.identity.seed[row], progress.crossed);
        progress.crossed += 1;
        let [seed, iteration] = [seed, paths.identity.iteration[row]].map(U32s::splat);
        let u = draw_first(seed, iteration, path_length, Purpose::Passage);
        if u.to_array()[0] >= crossings.chance[index] {
            progress.is_over = true;
            hits.set(row, crossings.hits.get(index));
        }
    }
}
