//! Notes what paths have brought, for those who ask whether more is worth its while.

use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::measured::Measured;
use crate::transport::tables::paths::AnyPaths;

/// Adds what connections carry that nothing is in the way of, not even what lets them pass: in
/// polarized mode that takes another part of them than in scalar mode, which is to play alike.
///
/// From: trace_connections. To: connect_to_vertices.
/// Writes: measured. Reads: connections (blocked, value, target), paths (identity).
pub fn note_brought<const N: usize>(
    measured: &mut Measured<N>,
    connections: &ConnectionTable<N>,
    paths: &AnyPaths<N>,
) {
    for index in (0..connections.len).filter(|&index| connections.blocked[index] == 0) {
        let slot = paths.identity.slot[connections.target[index] as usize] as usize;
        let most = connections.value[index].iter().fold(0.0_f32, |most, &it| most.max(it));
        measured.add_brought(slot, most);
    }
}
