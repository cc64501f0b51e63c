//! Connects light vertices to the sensor.

use glam::Vec3;

use crate::geometry::offset_origin;
use crate::math::{F32s, LANES, Real, U32s, Vector, lanes, warp};
use crate::polarization::{film_axis, s_axis};
use crate::scattering::Scene;
use crate::scattering::diffuse::Facing;
use crate::scattering::medium::{PhaseFunction, half_sine2};
use crate::scattering::sensor::SensorConnection;
use crate::scattering::vertex::{Turn, mean};
use crate::scene::baked::NONE;
use crate::transport::mis::{self, End};
use crate::transport::sampler::{Purpose, Stream, draw, path_seed};
use crate::transport::tables::connections::{ConnectionTable, Segment};
use crate::transport::tables::states::{LightState, kernels_of_lanes};
use crate::transport::tables::vertices::VertexTable;
use crate::transport::{Chunk, LightModel, Strategy};

/// Connects all vertices, each to the pixel that sees it. `light_paths` is the number of light
/// paths an iteration. With [`Strategy::Unidirectional`] nothing else finds these paths.
///
/// From: store_light_vertices, ordered by slot, so that splats come in an order that no mode
/// changes. To: trace_connections, splat_connections.
/// Writes: connections. Reads: vertices, chunk, scene.
pub fn connect_to_sensor<const N: usize, M: LightModel<N>>(
    connections: &mut ConnectionTable<N>,
    vertices: &VertexTable<N>,
    chunk: &Chunk,
    scene: &Scene<N>,
    light_paths: f32,
    strategy: Strategy,
) {
    connections.clear();
    for row in (0..vertices.len).step_by(LANES) {
        let live = LANES.min(vertices.len - row);
        let found: [Option<SensorConnection>; LANES] = std::array::from_fn(|lane| {
            if lane >= live {
                return None;
            }
            let lens = lens_of(vertices, chunk, scene, row + lane);
            scene.sensor.connect(lanes::row_of(&vertices.position, row + lane).into(), lens)
        });
        if found.iter().all(Option::is_none) {
            continue;
        }
        let field = |of: fn(&SensorConnection) -> f32| {
            F32s::from(std::array::from_fn(|lane| found[lane].as_ref().map_or(0.0, of)))
        };
        let direction = Vector::gather(|lane| {
            found[lane].as_ref().map_or([0.0, 0.0, 1.0], |found| found.direction.to_array())
        });
        let turn = light_turn(vertices, scene, direction, (row, live));
        let importance = field(|found| found.pdf_area) * F32s::splat(1.0 / light_paths);
        let factor = importance * weight(vertices, &turn, importance, strategy, row);
        let position = Vector::load(&vertices.position, row);
        let normal = Vector::load(&vertices.geometric_normal, row);
        let reach = F32s::splat(scene.reach);
        let origin = offset_origin(position, normal, direction, reach).to_rows();
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
            let inside = vertices.inside[row + lane];
            let segment = Segment::between(origin[lane], found.lens.to_array(), inside);
            match states[lane] {
                Some(state) => {
                    let state = in_film_frame(&state, found.direction, scene.sensor.up());
                    connections.push_polarized(segment, value, found.pixel, state);
                }
                None => connections.push(segment, value, found.pixel),
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
    let path = line * scene.sensor.width + column;
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

/// Stokes vectors for the axis of the film; `direction` is where the light travels.
fn in_film_frame<const N: usize>(
    state: &LightState<N>,
    direction: Vec3,
    film_up: Vec3,
) -> LightState<N> {
    let direction = Vector::from(direction.to_array());
    state.turned(film_axis(-direction, film_up.to_array().into()), direction)
}

/// The normals of eight light vertices.
#[inline(always)]
fn facing_of_vertices<const N: usize>(vertices: &VertexTable<N>, row: usize) -> Facing {
    Facing {
        geometric: Vector::load(&vertices.geometric_normal, row),
        shading: Vector::load(&vertices.shading_normal, row),
        two_sided: lanes::load(&vertices.two_sided, row).simd_gt(F32s::splat(0.5)),
    }
}

/// What eight light vertices do to light that leaves them along `direction`. The BRDF of
/// surfaces, which is in their power, is left out.
#[inline(always)]
pub(super) fn light_turn<const N: usize>(
    vertices: &VertexTable<N>,
    scene: &Scene<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) -> Turn<N> {
    let facing = facing_of_vertices(vertices, row);
    let given = Vector::load(&vertices.given, row);
    let cosine = direction.dot(facing.shading).abs();
    let adjoint = facing.adjoint(given, direction);
    let mut turn = Turn {
        value: [facing.reflects(given, direction) & (adjoint * cosine); N],
        pdf: warp::cosine_pdf(cosine),
        pdf_reverse: warp::cosine_pdf(given.dot(facing.shading).abs()),
        measure: direction.dot(facing.geometric).abs(),
    };
    for_each_volume(vertices, (row, live), |medium, mask| {
        let medium = scene.medium(medium);
        let values = medium.phase.values(half_sine2(-given, direction));
        let pdf = mean(&values);
        for (value, &phase) in turn.value.iter_mut().zip(&values) {
            *value = Real::select(mask, phase, *value);
        }
        turn.pdf = Real::select(mask, pdf, turn.pdf);
        turn.pdf_reverse = Real::select(mask, pdf, turn.pdf_reverse);
        turn.measure = Real::select(mask, F32s::splat(medium.density), turn.measure);
    });
    turn
}

/// The light that leaves eight vertices along `direction`, where it is polarized.
#[inline(always)]
pub(super) fn departing_states<const N: usize, M: LightModel<N>>(
    vertices: &VertexTable<N>,
    scene: &Scene<N>,
    direction: Vector<F32s>,
    (row, live): (usize, usize),
) -> [Option<LightState<N>>; LANES] {
    let mut states = [None; LANES];
    if !M::POLARIZED {
        return states;
    }
    let k_in = -Vector::load(&vertices.given, row);
    for_each_volume(vertices, (row, live), |medium, mask| {
        let PhaseFunction::Table(table) = &scene.medium(medium).phase else { return };
        let kernels = kernels_of_lanes(&table.kernels(half_sine2(k_in, direction)));
        let (axis, k_in) = (s_axis(k_in, direction).to_rows(), k_in.to_rows());
        let mask = mask.to_bits().to_array();
        for lane in (0..live).filter(|&lane| mask[lane] != 0) {
            let [axis, k_in] = [axis[lane], k_in[lane]].map(Vector::from);
            states[lane] = Some(match vertices.state[row + lane] {
                NONE => LightState::first_event(&kernels[lane], axis),
                state => vertices.states[state as usize].scatter(&kernels[lane], axis, k_in),
            });
        }
    });
    states
}

/// Calls `work` once for every medium among eight vertices, with the mask of those in it.
#[inline(always)]
fn for_each_volume<const N: usize>(
    vertices: &VertexTable<N>,
    (row, live): (usize, usize),
    mut work: impl FnMut(u32, F32s),
) {
    let volumes = &vertices.volume[row..row + live];
    for (lane, &medium) in volumes.iter().enumerate() {
        if medium == NONE || volumes[..lane].contains(&medium) {
            continue;
        }
        let same = lanes::each(|lane| volumes.get(lane).is_some_and(|&other| other == medium));
        work(medium, lanes::mask_of(same));
    }
}
