//! Tests connections for visibility and adds up what they carry.

use crate::geometry::trace_visibility;
use crate::scattering::Scene;
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::measured::{Measured, Splat};
use crate::transport::tables::paths::PathTable;

use super::collect_sensor::SensorSide;

/// Finds which connections are blocked.
///
/// From: connect_*. To: gather_connections, splat_connections.
/// Writes: connections.blocked. Reads: connections.rays, scene.
pub fn trace_connections<const N: usize>(connections: &mut ConnectionTable<N>, scene: &Scene<N>) {
    let ConnectionTable { len, rays, t_max, blocked, .. } = connections;
    trace_visibility(blocked, rays, t_max, 0..*len, &scene.accelerator);
}

/// Adds open connections to the slots of the sensor paths they belong to.
///
/// From: trace_connections. To: the film.
/// Writes: measured. Reads: connections, paths.
pub fn gather_connections<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    connections: &ConnectionTable<N>,
    paths: &PathTable<N, C>,
) {
    for index in 0..connections.len {
        if connections.blocked[index] == 0 {
            let row = connections.target[index] as usize;
            let slot = paths.identity.slot[row] as usize;
            paths.carriers.measure_unpolarized(measured, row, slot, connections.value[index]);
        }
    }
}

/// Appends open connections to the sensor to the list of splats, in their order.
///
/// From: trace_connections. To: the film.
/// Writes: splats. Reads: connections.
pub fn splat_connections<const N: usize>(
    splats: &mut Vec<Splat<N>>,
    connections: &ConnectionTable<N>,
) {
    let open = (0..connections.len).filter(|&index| connections.blocked[index] == 0);
    splats.extend(
        open.map(|index| Splat {
            pixel: connections.target[index],
            value: connections.value[index],
        }),
    );
}
