//! Tests connections for visibility, and lets media take their share.

use crate::geometry::{TraceScratch, trace_visibility, trace_visibility_past};
use crate::math::{F32s, LANES, lanes};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::tables::connections::ConnectionTable;

/// Finds which connections are blocked, or cross surfaces that let them pass, and attenuates the
/// others.
///
/// From: connect_emission, connect_to_emitters, connect_to_vertices, connect_to_sensor,
/// connect_flights. To: follow_connections, note_brought, gather_connections, splat_connections.
/// Writes: connections (blocked, value), scratch. Reads: connections (rays), scene.
pub fn trace_connections<const N: usize>(
    connections: &mut ConnectionTable<N>,
    scratch: &mut TraceScratch,
    scene: &Scene<N>,
) {
    let ConnectionTable { len, rays, t_max, blocked, .. } = connections;
    let (rows, accelerator) = (0..*len, &scene.accelerator);
    if scene.has_straight_on {
        let passes = |primitive| scene.is_straight_on(primitive);
        trace_visibility_past(blocked, scratch, (rays, t_max), rows, accelerator, &passes);
    } else {
        trace_visibility(blocked, scratch, rays, t_max, rows, accelerator);
    }
    if scene.has_media() {
        attenuate(connections, scene);
    }
}

/// Bouguer's law for connections that stay in one medium.
fn attenuate<const N: usize>(connections: &mut ConnectionTable<N>, scene: &Scene<N>) {
    for row in (0..connections.len).step_by(LANES) {
        let live = LANES.min(connections.len - row);
        let inside: [u32; LANES] = lanes::each(|lane| match connections.blocked[row..].get(lane) {
            Some(0) if lane < live => connections.inside[row + lane],
            _ => NONE,
        });
        if inside.iter().all(|&medium| medium == NONE) {
            continue;
        }
        let length = lanes::load(&connections.t_max, row).min(F32s::splat(f32::MAX));
        for n in 0..N {
            let sigma = lanes::each(|lane| scene.medium(inside[lane]).sigma_t[n]);
            let transmittance = (-(F32s::from(sigma) * length)).exp().to_array();
            let values = connections.value[row..row + live].iter_mut();
            for (value, transmittance) in values.zip(&transmittance) {
                value[n] *= transmittance;
            }
        }
    }
}
