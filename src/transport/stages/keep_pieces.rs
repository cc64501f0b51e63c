//! Keeps where in a medium paths have met particles.

use crate::geometry::{HitColumns, medium_met};
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::AnyPaths;

/// Keeps the pieces of segments in which particles were met, for the weights of connections to
/// lamps.
///
/// From: fly_through_media. To: partition_paths.
/// Writes: paths (piece). Reads: hits, flights.
pub fn keep_pieces<const N: usize>(
    paths: &mut AnyPaths<N>,
    hits: &HitColumns,
    flights: &FlightTable<N>,
) {
    for row in 0..paths.len {
        if medium_met(hits.primitive[row]).is_some() {
            let progress = &flights.progress[row];
            paths.piece.from[row] = progress.from;
            paths.piece.to[row] = progress.travelled;
        }
    }
}
