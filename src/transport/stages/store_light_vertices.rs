//! Keeps the light vertices that others can connect to.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::diffuse::BRDF;
use crate::scattering::event::Event;
use crate::scattering::{Met, Scene};
use crate::scene::baked::NONE;
use crate::transport::sides::LightSide;
use crate::transport::tables::carriers::LightCarriers;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::states::LightState;
use crate::transport::tables::vertices::VertexTable;
use crate::transport::vertex::MaterialLanes;

/// Appends the rows `rows`, which have met `event`.
///
/// From: depolarize_light. To: connect_to_vertices, connect_to_sensor.
/// Writes: vertices. Reads: paths, surfaces, scene.
pub fn store_light_vertices<const N: usize, C: LightSide<N>>(
    vertices: &mut VertexTable<N>,
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    (event, rows): (Event, Range<usize>),
    path_length: u32,
) {
    vertices.reserve(rows.len());
    let start = vertices.len;
    let end = start + rows.len();
    for row in rows.clone().step_by(LANES) {
        let to = start + row - rows.start;
        Vector::load(&surfaces.position, row).store(&mut vertices.position, to, end);
        let normal = Vector::load(&surfaces.geometric_normal, row);
        normal.store(&mut vertices.geometric_normal, to, end);
        Vector::load(&surfaces.shading_normal, row).store(&mut vertices.shading_normal, to, end);
        (-Vector::load(&paths.rays.direction, row)).store(&mut vertices.given, to, end);
        let live = LANES.min(rows.end - row);
        store_power(vertices, paths, surfaces, scene, (event, row, live), (to, end));
        vertices.store_weights(to, end, paths.mis.load(row));
    }
    vertices.slot[start..end].copy_from_slice(&paths.identity.slot[rows.clone()]);
    vertices.path_length[start..end].fill(path_length);
    for (to, row) in (start..end).zip(rows.clone()) {
        vertices.inside[to] = paths.media.inside(row);
    }
    let volume = if let Met::Medium(medium) = event.met { medium } else { NONE };
    vertices.volume[start..end].fill(volume);
    let (states, place) = (&mut vertices.states, &mut vertices.state[start..end]);
    keep_states(states, place, paths.carriers.columns(), rows);
    vertices.len = end;
}

fn store_power<const N: usize, C>(
    vertices: &mut VertexTable<N>,
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    (event, row, live): (Event, usize, usize),
    (to, end): (usize, usize),
) {
    let mut factor = [F32s::splat(1.0); N];
    let mut two_sided = F32s::splat(1.0);
    if let Met::Surface(_) = event.met {
        let material = MaterialLanes::gather(scene, surfaces, row, live);
        for (factor, &reflectance) in factor.iter_mut().zip(&material.reflectance) {
            *factor = reflectance * F32s::splat(BRDF);
        }
        two_sided = material.two_sided & F32s::splat(1.0);
    }
    for (n, &factor) in factor.iter().enumerate() {
        let power = lanes::load(&paths.beta[n], row) * factor;
        lanes::store(&mut vertices.power[n], to, end, power);
    }
    lanes::store(&mut vertices.two_sided, to, end, two_sided);
}

/// Appends the states of the rows that are polarized; `place` of each row is where its state went,
/// or `NONE`.
fn keep_states<const N: usize>(
    states: &mut Vec<LightState<N>>,
    place: &mut [u32],
    carriers: Option<&LightCarriers<N>>,
    rows: Range<usize>,
) {
    let Some(carriers) = carriers else { return place.fill(NONE) };
    for (place, row) in place.iter_mut().zip(rows) {
        if !carriers.class[row].has_stokes() {
            *place = NONE;
            continue;
        }
        *place = states.len() as u32;
        let x = lanes::row_of(&carriers.axis, row).into();
        states.push(LightState::of_wavelengths(x, |n| carriers.load(n, row, x)));
    }
}
