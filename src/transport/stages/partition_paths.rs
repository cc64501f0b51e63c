//! Groups rows by what they have met and carrier class, and drops those that end.

use crate::geometry::HitColumns;
use crate::math::columns::Columns;
use crate::scattering::Scene;
use crate::scattering::event::END;
use crate::transport::tables::carriers::CarrierTable;
use crate::transport::tables::partition::{Next, Partition};
use crate::transport::tables::paths::PathTable;

/// Moves the rows that have arrived at vertices to `sorted`, grouped, with their odds, those that
/// have lost behind the others; rows that hit nothing, an absorber, or carry nothing stay behind.
///
/// From: trace_closest, fly_through_media, keep_pieces, collect_emission, play_roulette. To:
/// resolve_surfaces.
/// Writes: sorted, sorted_hits, partition. Reads: paths, hits, scene.
pub fn partition_paths<const N: usize, C: CarrierTable>(
    sorted: &mut PathTable<N, C>,
    sorted_hits: &mut HitColumns,
    partition: &mut Partition,
    paths: &PathTable<N, C>,
    hits: &HitColumns,
    scene: &Scene<N>,
) {
    partition.group(paths.len, &scene.events, C::CLASSES, |row| {
        // Any channel that is not +-0 carries something.
        let bits = paths.beta.iter().fold(0, |bits, beta| bits | (beta[row].to_bits() << 1));
        let event = scene.event_hit(hits.primitive[row]);
        let event = if bits == 0 { END } else { event };
        Next { event, class: paths.carriers.place_of_class(row), goes_on: paths.odds[row] > 0.0 }
    });
    sorted.take(paths, partition);
    sorted_hits.take_rows(hits, &partition.order, 0);
}
