//! Groups rows by material kind and carrier class, and drops those that end.

use crate::geometry::HitColumns;
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::tables::carriers::CarrierTable;
use crate::transport::tables::gather;
use crate::transport::tables::partition::Partition;
use crate::transport::tables::paths::PathTable;

/// Moves the rows that go on to `sorted`, grouped; rows that hit nothing, an absorber, or carry
/// nothing stay behind.
///
/// From: trace_closest, play_roulette. To: resolve_surfaces.
/// Writes: sorted, sorted_hits, partition. Reads: paths, hits, scene.
pub fn partition_paths<const N: usize, C: CarrierTable>(
    sorted: &mut PathTable<N, C>,
    sorted_hits: &mut HitColumns,
    partition: &mut Partition,
    paths: &PathTable<N, C>,
    hits: &HitColumns,
    scene: &Scene<N>,
) {
    partition.group(paths.len, C::CLASSES, |row| {
        let primitive = hits.primitive[row];
        let carries = paths.beta.iter().any(|beta| beta[row] != 0.0);
        (primitive != NONE && carries)
            .then(|| (scene.kind_of_primitive[primitive as usize], paths.carriers.class(row)))
    });
    sorted.gather(paths, partition);
    let order = &partition.order;
    gather(&mut sorted_hits.t, &hits.t, order, 0);
    gather(&mut sorted_hits.u, &hits.u, order, 0);
    gather(&mut sorted_hits.v, &hits.v, order, 0);
    gather(&mut sorted_hits.primitive, &hits.primitive, order, 0);
}
