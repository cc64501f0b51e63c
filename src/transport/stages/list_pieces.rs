//! Lists the pieces of segments that lie before paths in a medium.

use crate::geometry::HitColumns;
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::merged::MergedRows;
use crate::transport::tables::paths::AnyPaths;
use crate::transport::tables::pieces::{Piece, PieceTable};

/// Lists the pieces in the table's medium that the rows of a part are about to fly through, or
/// without one all rows on their last ones; but not those of rows that have `merged`, unless they
/// go on.
///
/// From: draw_distances, cross_surfaces. To: choose_lamps.
/// Writes: pieces. Reads: paths (media, rays), flights, hits, crossing, merged.
pub fn list_pieces<const N: usize>(
    pieces: &mut PieceTable,
    paths: &AnyPaths<N>,
    flights: &FlightTable<N>,
    (hits, crossing): (&HitColumns, Option<&Crossing<N>>),
    merged: &MergedRows,
) {
    pieces.len = 0;
    let mut list = |row: usize, to: f32| {
        let progress = &flights.progress[row];
        let from = progress.travelled;
        let lies_before =
            paths.media.inside[row] == pieces.medium && !progress.is_over && to > from;
        if lies_before && !merged.ends(row, &paths.rays.direction) {
            let (row, lamp, chance, place) = (row as u32, 0, 0.0, 0.0);
            pieces.push_row(Piece { row, from, to, lamp, chance, place });
        }
    };
    match crossing {
        Some(Crossing { crossings, part, .. }) => part.rows.clone().for_each(|index| {
            list(crossings.row[index] as usize, crossings.hits.t[index]);
        }),
        None => (0..paths.len).for_each(|row| list(row, hits.t[row])),
    }
}
