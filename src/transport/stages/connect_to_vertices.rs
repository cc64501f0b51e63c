//! Connects vertices of sensor paths to those of the light path they are paired with (paper,
//! equation 12).

use std::ops::Range;

use crate::geometry::{SurfaceColumns, offset_origin};
use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::Met;
use crate::scattering::Scene;
use crate::scattering::event::{Event, Form};
use crate::scattering::vertex::VertexLanes;
use crate::transport::LightModel;
use crate::transport::mis::{self, End, PartialWeights};
use crate::transport::tables::connections::{ConnectionTable, Segment};
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::vertices::{SlotOrder, VertexTable};
use crate::transport::vertex::{departing_states, light_turn, on_surface};

/// Connects each of the rows `rows`, which have met `event`, to all vertices of its slot's light
/// path that keep the whole within the greatest path length.
///
/// Where the sensor's end is a depolarizer, the Mueller kernels reduce to their first rows, and
/// only intensity crosses the connection.
///
/// From: depolarize_sensor, store_light_vertices. To: trace_connections.
/// Writes: connections. Reads: paths, surfaces, vertices, order, scene.
pub fn connect_to_vertices<const N: usize, M: LightModel<N>>(
    connections: &mut ConnectionTable<N>,
    paths: &PathTable<N, M::Sensor>,
    surfaces: &SurfaceColumns,
    (vertices, order): (&VertexTable<N>, &SlotOrder),
    scene: &Scene<N>,
    (event, rows): (Event, Range<usize>),
    vertex_length_max: u32,
) {
    connections.clear();
    for row in rows {
        let of_path = order.rows_of(paths.identity.slot[row] as usize);
        if of_path.is_empty() {
            continue;
        }
        let sensor = SensorVertex::load(paths, surfaces, scene, event, row);
        for first in of_path.clone().step_by(LANES) {
            let some = (first, LANES.min(of_path.end - first));
            sensor.connect::<M>(connections, vertices, scene, some, vertex_length_max);
        }
    }
}

/// One sensor vertex in all lanes.
struct SensorVertex<'a, const N: usize> {
    row: u32,
    /// The medium around it.
    inside: u32,
    position: Vector<F32s>,
    normal: Vector<F32s>,
    given: Vector<F32s>,
    scatters: VertexLanes<'a, N>,
    depolarizes: bool,
    beta: [F32s; N],
    weights: PartialWeights<F32s>,
}

impl<'a, const N: usize> SensorVertex<'a, N> {
    #[inline(always)]
    fn load<C>(
        paths: &PathTable<N, C>,
        surfaces: &SurfaceColumns,
        scene: &'a Scene<N>,
        event: Event,
        row: usize,
    ) -> Self {
        let normal = lanes::row_of(&surfaces.geometric_normal, row);
        let mut beta = [F32s::splat(0.0); N];
        for (beta, column) in beta.iter_mut().zip(&paths.beta) {
            *beta = F32s::splat(column[row]);
        }
        Self {
            row: row as u32,
            inside: paths.media.inside(row),
            position: Vector::splat(lanes::row_of(&surfaces.position, row)),
            normal: Vector::splat(normal),
            given: -Vector::splat(lanes::row_of(&paths.rays.direction, row)),
            scatters: match event.met {
                Met::Medium(medium) => VertexLanes::Volume(scene.medium(medium)),
                Met::Surface(_) => on_surface(surfaces, scene, normal, row),
            },
            depolarizes: event.form == Form::Depolarizer,
            beta,
            weights: paths.mis.splat(row),
        }
    }

    /// Connects to the `live` vertices from `first` on.
    #[inline(always)]
    fn connect<M: LightModel<N>>(
        &self,
        connections: &mut ConnectionTable<N>,
        vertices: &VertexTable<N>,
        scene: &Scene<N>,
        (first, live): (usize, usize),
        vertex_length_max: u32,
    ) {
        let position = Vector::load(&vertices.position, first);
        let offset = position - self.position;
        let distance2 = offset.length_squared();
        let direction = offset * (F32s::splat(1.0) / distance2.sqrt());
        let turn = self.scatters.turn(self.given, direction);
        let light = light_turn(vertices, scene, -direction, (first, live));
        let sensor_end = End { weights: self.weights, turn: (&turn).into() };
        let light_end = End { weights: vertices.weights(first), turn: (&light).into() };
        let inverse2 = F32s::splat(1.0) / distance2;
        let factor = mis::weight_of_vertices_connected(sensor_end, light_end, inverse2);
        let mut values = [[0.0; LANES]; N];
        for (n, values) in values.iter_mut().enumerate() {
            let power = lanes::load(&vertices.power[n], first) * light.value[n];
            *values = (self.beta[n] * turn.value[n] * power * factor).to_array();
        }
        let normal = Vector::load(&vertices.geometric_normal, first);
        let reach = F32s::splat(scene.reach);
        let from = offset_origin(self.position, self.normal, direction, reach).to_rows();
        let to = offset_origin(position, normal, -direction, reach).to_rows();
        let states = departing_states::<N, M>(vertices, scene, -direction, (first, live));
        for lane in 0..live {
            let mut value = lanes::row_of_lanes(&values, lane);
            let fits = vertices.path_length[first + lane] <= vertex_length_max;
            if !fits || !value.iter().any(|&value| value > 0.0) {
                continue;
            }
            let segment = Segment::between(from[lane], to[lane], self.inside);
            match &states[lane] {
                Some(state) if !self.depolarizes => {
                    connections.push_polarized(segment, value, self.row, *state);
                    continue;
                }
                Some(state) => {
                    for (n, value) in value.iter_mut().enumerate() {
                        *value *= state.at(n).depolarized();
                    }
                }
                None => {}
            }
            connections.push(segment, value, self.row);
        }
    }
}
