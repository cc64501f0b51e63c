//! Connects light vertices to the sensor.

use crate::geometry::offset_origin;
use crate::math::{F32s, LANES, U32s, Vector, lanes};
use crate::scattering::painting::SceneAt;
use crate::scattering::sensor::SensorConnection;
use crate::scattering::vertex::Turn;
use crate::scattering::{Scene, Side};
use crate::transport::mis::{self, End};
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};
use crate::transport::splat::pixel_of;
use crate::transport::tables::connections::{Cargo, ConnectionTable, Segment};
use crate::transport::tables::vertices::VertexTable;
use crate::transport::vertex::{departing_states, turn_of_light};
use crate::transport::{Chunk, LightModel, Strategy};

/// Connects all vertices, each to the pixel that sees it. `light_paths` is the number of light
/// paths an iteration. With [`Strategy::Unidirectional`] nothing else finds these paths.
///
/// From: store_light_vertices. To: trace_connections.
/// Writes: connections. Reads: vertices, chunk, scene.
pub fn connect_to_sensor<const N: usize, M: LightModel<N>>(
    connections: &mut ConnectionTable<N>,
    vertices: &VertexTable<N>,
    chunk: &Chunk,
    scene: SceneAt<N>,
    light_paths: f32,
    strategy: Strategy,
) {
    connections.clear();
    for row in (0..vertices.len).step_by(LANES) {
        let live = LANES.min(vertices.len - row);
        let mut found: [Option<SensorConnection>; LANES] = [None; LANES];
        for (row, found) in (row..row + live).zip(&mut found) {
            let lens = lens_of(vertices, chunk, &scene, row);
            *found = scene.sensor.connect(lanes::row_of(&vertices.position, row).into(), lens);
        }
        if found.iter().all(Option::is_none) {
            continue;
        }
        let field = |of: fn(&SensorConnection) -> f32| {
            F32s::from(lanes::each(|lane| found[lane].as_ref().map_or(0.0, of)))
        };
        let direction = Vector::gather(|lane| {
            found[lane].as_ref().map_or([0.0, 0.0, 1.0], |found| found.direction.to_array())
        });
        let turn = turn_of_light(vertices, scene, direction, (row, live));
        let importance = field(|found| found.pdf_area) * F32s::splat(1.0 / light_paths);
        let weight = weight(vertices, &turn, importance, strategy, row);
        let (factor, weights) = (importance * weight, weight.to_array());
        let position = Vector::load(&vertices.position, row);
        let normal = Vector::load(&vertices.geometric_normal, row);
        let offset = lanes::load(&vertices.offset, row);
        let origin = offset_origin(position, normal, direction, offset).to_rows();
        let mut values = [[0.0; LANES]; N];
        for (n, values) in values.iter_mut().enumerate() {
            let power = lanes::load(&vertices.power[n], row);
            *values = (power * turn.value[n] * factor).to_array();
        }
        let states = departing_states::<N, M>(vertices, scene, direction, (row, live));
        for (lane, found) in found.iter().enumerate() {
            let value = lanes::row_of_lanes(&values, lane);
            let Some(found) = found.as_ref().filter(|_| value.iter().any(|&v| v > 0.0)) else {
                continue;
            };
            let (slot, path_length) =
                (vertices.slot[row + lane] as usize, vertices.path_length[row + lane]);
            let counts = pixel_of(found, &scene.sensor, chunk, slot, path_length);
            let Some((pixel, share)) = counts else { continue };
            let inside = vertices.inside_towards(&scene, row + lane, found.direction);
            let segment =
                Segment::between(Side::Light, origin[lane], found.lens.to_array(), inside);
            let value = value.map(|value| value * share);
            let cargo = Cargo { value, weight: weights[lane] };
            match states[lane] {
                Some(state) => connections.push_polarized(segment, cargo, pixel, state),
                None => connections.push(segment, cargo, pixel),
            }
        }
    }
}

/// The point of the lens that a vertex connects to.
#[inline(always)]
fn lens_of<const N: usize>(
    vertices: &VertexTable<N>,
    chunk: &Chunk,
    scene: &Scene<N>,
    row: usize,
) -> [f32; 2] {
    if !scene.sensor.has_lens() {
        return [0.0; 2];
    }
    let (column, line, iteration) = chunk.place(vertices.slot[row] as usize);
    let path = scene.sensor.path_of([column, line]);
    let seed = path_seed(chunk.seed, Stream::Light, path);
    let [seed, iteration] = [seed, iteration].map(U32s::splat);
    draw(seed, iteration, vertices.path_length[row], Purpose::LensConnection)
        .map(|u| u.to_array()[0])
}

/// Weight against the other ways to the same paths; `importance` is the density of the sensor's ray
/// per unit of perpendicular area, over the number of light paths.
#[inline(always)]
fn weight<const N: usize>(
    vertices: &VertexTable<N>,
    turn: &Turn<N>,
    importance: F32s,
    strategy: Strategy,
    row: usize,
) -> F32s {
    if strategy != Strategy::Bidirectional {
        return F32s::splat(1.0);
    }
    let light = End { weights: vertices.weights(row), turn: turn.into() };
    mis::weight_of_sensor_connected(light, importance)
}
