//! Finds where connections go straight on through surfaces.

use crate::geometry::{CROSSES, Hit, TraceScratch};
use crate::math::columns::Rows;
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::crossing::{follow, step};
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::crossings::CrossingTable;
use crate::transport::tables::flights::{Flight, FlightTable};

/// Follows the connections that nothing blocks but surfaces which let them pass.
///
/// From: trace_connections. To: pass_surfaces.
/// Writes: crossings, flights, scratch. Reads: connections, scene.
pub fn follow_connections<const N: usize>(
    crossings: &mut CrossingTable<N>,
    (flights, scratch): (&mut FlightTable<N>, &mut TraceScratch),
    connections: &ConnectionTable<N>,
    scene: &Scene<N>,
) {
    crossings.clear();
    flights.start(connections.len);
    let start = Hit { t: 0.0, u: 0.0, v: 0.0, primitive: NONE };
    for row in 0..connections.len {
        if connections.blocked[row] == CROSSES {
            flights.push_row(Flight {
                row: row as u32,
                rays: connections.rays.get(row),
                hits: start,
                t_max: connections.t_max[row],
            });
        }
    }
    step(flights, scratch, scene, |_, _| {});
    follow(crossings, (flights, scratch), scene, |_, _| {});
}
