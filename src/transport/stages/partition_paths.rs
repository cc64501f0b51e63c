//! Groups rows by what they have met and carrier class, and drops those that end.

use crate::geometry::HitColumns;
use crate::scattering::Scene;
use crate::scattering::event::END;
use crate::transport::tables::carriers::CarrierTable;
use crate::transport::tables::gather;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;

/// Moves the rows that go on to `sorted`, grouped; rows that hit nothing, an absorber, or carry
/// nothing stay behind.
///
/// From: trace_closest, fly_through_media, collect_emission, play_roulette. To: resolve_surfaces.
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
        (event, paths.carriers.place_of_class(row))
    });
    sorted.gather(paths, partition);
    let order = &partition.order;
    gather(&mut sorted_hits.t, &hits.t, order, 0);
    gather(&mut sorted_hits.u, &hits.u, order, 0);
    gather(&mut sorted_hits.v, &hits.v, order, 0);
    gather(&mut sorted_hits.primitive, &hits.primitive, order, 0);
}
