//! Keeps the light vertices that others can connect to.

use std::ops::Range;

use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::painting::SceneAt;
use crate::scattering::vertex::{Consecutive, KeptLanes, Scatterer, Vertices, for_scatterer};
use crate::scene::baked::NONE;
use crate::transport::Arrived;
use crate::transport::sides::LightSide;
use crate::transport::tables::carriers::LightCarriers;
use crate::transport::tables::states::LightState;
use crate::transport::tables::vertices::VertexTable;

/// Appends rows that have arrived.
///
/// From: depolarize_light. To: connect_to_vertices, connect_to_sensor.
/// Writes: vertices. Reads: arrived (paths, surfaces), scene.
pub fn store_light_vertices<const N: usize, C: LightSide<N>>(
    vertices: &mut VertexTable<N>,
    arrived: &Arrived<N, C>,
    scene: SceneAt<N>,
) {
    let &Arrived { paths, event, ref rows, path_length, .. } = arrived;
    let range = vertices.len..vertices.len + rows.len();
    vertices.reserve(rows.len());
    store_lanes(vertices, arrived, scene);
    vertices.slot[range.clone()].copy_from_slice(&paths.identity.slot[rows.clone()]);
    vertices.path_length[range.clone()].fill(path_length);
    for (to, row) in range.clone().zip(rows.clone()) {
        vertices.inside[to] = paths.media.inside(row);
    }
    if event.met.passes_any_way() {
        for (to, row) in range.clone().zip(rows.clone()) {
            vertices.beyond[to] = arrived.beyond(&scene, row);
        }
    }
    vertices.event[range.clone()].fill(event.met.event() as u32);
    let (states, place) = (&mut vertices.states, &mut vertices.state[range.clone()]);
    keep_states(states, place, paths.carriers.columns(), rows.clone());
    vertices.len = range.end;
}

/// The columns of floats, and the rows of models.
fn store_lanes<const N: usize, C>(
    vertices: &mut VertexTable<N>,
    arrived: &Arrived<N, C>,
    scene: SceneAt<N>,
) {
    let &Arrived { paths, surfaces, event, ref rows, .. } = arrived;
    let start = vertices.len;
    let end = start + rows.len();
    for row in rows.clone().step_by(LANES) {
        let to = start + row - rows.start;
        let live = LANES.min(rows.end - row);
        let kept = for_scatterer!(scene, event.met, all => {
            let some = all.at(surfaces, Consecutive(row, live));
            (some.keep(), some.factor())
        });
        let Some((KeptLanes { facing, rows: of_model }, factor)) = kept else { return };
        Vector::load(&surfaces.position, row).store(&mut vertices.position, to, end);
        let offset = lanes::load(&surfaces.offset, row);
        lanes::store(&mut vertices.offset, to, end, offset);
        facing.geometric.store(&mut vertices.geometric_normal, to, end);
        facing.shading.store(&mut vertices.shading_normal, to, end);
        lanes::store(&mut vertices.two_sided, to, end, facing.two_sided & F32s::splat(1.0));
        vertices.row[to..to + live].copy_from_slice(&of_model.to_array()[..live]);
        (-Vector::load(&paths.rays.direction, row)).store(&mut vertices.given, to, end);
        for (n, factor) in factor.into_iter().enumerate() {
            let power = lanes::load(&paths.beta[n], row) * factor;
            lanes::store(&mut vertices.power[n], to, end, power);
        }
        vertices.store_weights(to, end, paths.mis.load(row));
    }
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
