//! Finds where the segments of paths go straight on through surfaces, and what they meet behind.

use crate::geometry::{HitColumns, TraceScratch};
use crate::math::columns::Rows;
use crate::scattering::Scene;
use crate::transport::crossing::follow;
use crate::transport::tables::crossings::CrossingTable;
use crate::transport::tables::flights::{Flight, FlightTable};
use crate::transport::tables::paths::AnyPaths;

/// Follows the segments that have met surfaces which let them straight on, and turns their hits
/// into what is behind; the distances are still those from the segments' starts.
///
/// From: trace_closest. To: pass_surfaces, draw_distances.
/// Writes: crossings, hits, flights, scratch. Reads: paths, scene.
pub fn follow_paths<const N: usize>(
    crossings: &mut CrossingTable<N>,
    hits: &mut HitColumns,
    (flights, scratch): (&mut FlightTable<N>, &mut TraceScratch),
    paths: &AnyPaths<N>,
    scene: &Scene<N>,
) {
    crossings.clear();
    flights.start(paths.len);
    for row in 0..paths.len {
        if scene.is_straight_on(hits.primitive[row]) {
            flights.push_row(Flight {
                row: row as u32,
                rays: paths.rays.get(row),
                hits: hits.get(row),
                t_max: f32::INFINITY,
            });
        }
    }
    follow(crossings, (flights, scratch), scene, |row, hit| hits.set(row as usize, hit));
}
