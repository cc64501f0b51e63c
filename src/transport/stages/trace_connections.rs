//! Tests connections for visibility, and lets media take their share.

use crate::geometry::{Hit, TraceScratch, trace_closest, trace_visibility};
use crate::math::columns::Rows;
use crate::math::{F32s, LANES, lanes};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::flights::{Flight, FlightTable};

use crate::transport::flight::step_over;

/// Finds which connections are blocked, and attenuates the others.
///
/// From: connect_emission, connect_to_emitters, connect_to_vertices, connect_to_sensor. To:
/// gather_connections, splat_connections.
/// Writes: connections (blocked, value), flights, scratch. Reads: connections (rays), scene.
pub fn trace_connections<const N: usize>(
    connections: &mut ConnectionTable<N>,
    (flights, scratch): (&mut FlightTable<N>, &mut TraceScratch),
    scene: &Scene<N>,
) {
    if scene.has_null_boundaries {
        return cross_boundaries(connections, (flights, scratch), scene);
    }
    let ConnectionTable { len, rays, t_max, blocked, .. } = connections;
    trace_visibility(blocked, scratch, rays, t_max, 0..*len, &scene.accelerator);
    if scene.has_media() {
        attenuate(connections, scene);
    }
}

/// Bouguer's law for connections that stay in one medium.
fn attenuate<const N: usize>(connections: &mut ConnectionTable<N>, scene: &Scene<N>) {
    for row in (0..connections.len).step_by(LANES) {
        let live = LANES.min(connections.len - row);
        let inside = &connections.inside[row..row + live];
        if inside.iter().all(|&medium| medium == NONE) {
            continue;
        }
        let length = lanes::load(&connections.t_max, row).min(F32s::splat(f32::MAX));
        for n in 0..N {
            let sigma = lanes::each(|lane| {
                inside.get(lane).map_or(0.0, |&medium| scene.medium(medium).sigma_t[n])
            });
            let transmittance = (-(F32s::from(sigma) * length)).exp().to_array();
            let values = connections.value[row..row + live].iter_mut();
            for (value, transmittance) in values.zip(&transmittance) {
                value[n] *= transmittance;
            }
        }
    }
}

/// Follows every connection through boundaries that do not bend it, piece by piece.
fn cross_boundaries<const N: usize>(
    connections: &mut ConnectionTable<N>,
    (flights, scratch): (&mut FlightTable<N>, &mut TraceScratch),
    scene: &Scene<N>,
) {
    flights.clear(connections.len);
    for row in 0..connections.len {
        let rays = &connections.rays;
        flights.push_row(Flight {
            row: row as u32,
            rays: rays.get(row),
            hits: Hit::MISS,
            inside: connections.inside[row],
            travelled: 0.0,
        });
    }
    connections.blocked[..connections.len].fill(0);
    while flights.len > 0 {
        let FlightTable { hits, rays, len, .. } = &mut *flights;
        trace_closest(hits, scratch, rays, 0..*len, &scene.accelerator);
        let len = flights.len;
        flights.len = 0;
        for index in 0..len {
            let row = flights.row[index] as usize;
            let primitive = flights.hits.primitive[index];
            let left = connections.t_max[row] - flights.travelled[index];
            let arrives = flights.hits.t[index] >= left;
            let piece = left.min(flights.hits.t[index]).clamp(0.0, f32::MAX);
            let medium = scene.medium(flights.inside[index]);
            for (depth, sigma) in flights.depth[row].iter_mut().zip(&medium.sigma_t) {
                *depth += sigma * piece;
            }
            if arrives || primitive == NONE {
                continue;
            }
            if scene.material_at(primitive).kind.is_crossed() {
                step_over(flights, index, scene);
            } else {
                connections.blocked[row] = u32::MAX;
            }
        }
    }
    let values = connections.value[..connections.len].iter_mut();
    for (value, depth) in values.zip(&flights.depth) {
        for (value, depth) in value.iter_mut().zip(depth) {
            *value *= (-depth).exp();
        }
    }
}
