//! Chooses which lamps are looked for from the way of paths through a medium.

use crate::math::LANES;
use crate::math::columns::Rows;
use crate::scattering::Scene;
use crate::transport::piece::PieceLanes;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::tables::paths::AnyPaths;
use crate::transport::tables::pieces::PieceTable;

/// Chooses a lamp for every piece of a segment in a medium, and keeps the pieces from which it is
/// looked for.
///
/// From: list_pieces. To: connect_flights.
/// Writes: pieces. Reads: paths, scene.
pub fn choose_lamps<const N: usize>(
    pieces: &mut PieceTable,
    paths: &AnyPaths<N>,
    scene: &Scene<N>,
    path_length: u32,
) {
    let Some(lamps) = &scene.lamps else { return };
    let mut kept = 0;
    for first in (0..pieces.len).step_by(LANES) {
        let live = LANES.min(pieces.len - first);
        let rows = pieces.rows_of_paths(first);
        let piece = PieceLanes::load(pieces, paths, (scene.medium(pieces.medium), first), &rows);
        let (seed, iteration) = paths.identity.of_rows(&rows);
        let [u_lamp, u] = draw(seed, iteration, path_length, Purpose::Lamp);
        let chosen = lamps.choose(|| piece.vantages(), u_lamp, live);
        let share = piece.share(&piece.seen_by(lamps, chosen.map(|(lamp, _)| lamp)));
        let (place, looks) = ((u / share).to_array(), u.simd_lt(share).to_bitmask());
        let share = share.to_array();
        for lane in (0..live).filter(|lane| looks >> lane & 1 == 1) {
            let (lamp, chance) = chosen[lane];
            let mut row = pieces.get(first + lane);
            row.lamp = lamp as u32;
            row.chance = chance * share[lane];
            row.place = place[lane];
            pieces.set(kept, row);
            kept += 1;
        }
    }
    pieces.len = kept;
}
