//! Connects vertices of sensor paths to those of the light path they are paired with (paper,
//! equation 12).

use crate::geometry::{SurfaceColumns, offset_distance, offset_origin, reach};
use crate::math::{F32s, LANES, U32s, Vector, lanes};
use crate::scattering::event::{Event, Form};
use crate::scattering::painting::SceneAt;
use crate::scattering::vertex::{Same, Scatterer, Turn, Vertices, for_scatterer};
use crate::scattering::{Scene, Side};
use crate::transport::collapse::{has_collapsed, met_by_collapsed};
use crate::transport::mis::{self, End, PartialWeights};
use crate::transport::sampler::Purpose;
use crate::transport::tables::connections::{ConnectionLanes, ConnectionTable};
use crate::transport::tables::measured::Measured;
use crate::transport::tables::states::LightState;
use crate::transport::tables::vertices::LightPaths;
use crate::transport::vertex::{departing_states, turn_of_light};
use crate::transport::{Arrived, LightModel};

/// Vertices of a light path that all sensor vertices connect to, and segments of a sensor path
/// whose vertices all connect. A multiple of [`LANES`].
const ALWAYS: usize = 16;
/// Connections are made for sure that bring this part at least of what their path has brought.
const SURE: f32 = 0.1;

/// Connects each row that has arrived to the vertices of its slot's light path.
///
/// What long paths in dense media would cost, length times length, is bounded: of the light
/// vertices beyond the first `ALWAYS` a sensor vertex connects to eight neighbors, drawn with
/// equal chances among the groups of eight; and beyond `ALWAYS` segments it connects with the
/// probability `(ALWAYS / n)²` after n of them. Those that are drawn count for the others. The
/// weights of the strategies do not know of this, for they sum to one as they are; a path of such
/// a length has so many strategies that the share of each is small.
///
/// Of other paths, connections that would bring little beside what the path has brought already
/// (less than `SURE` of it) are made as often as they bring of that, and count for those that are
/// not: one number decides for all of a sensor vertex, so that as many are made as chances add up
/// to.
///
/// Where the sensor's end is a depolarizer, the Mueller kernels reduce to their first rows, and
/// only intensity crosses the connection.
///
/// From: depolarize_sensor, store_light_vertices, note_brought. To: trace_connections.
/// Writes: connections. Reads: arrived (paths, surfaces), light, scene, measured.
pub fn connect_to_vertices<const N: usize, M: LightModel<N>>(
    connections: &mut ConnectionTable<N>,
    arrived: &Arrived<N, M::Sensor>,
    light: &LightPaths<N>,
    (scene, measured): (SceneAt<N>, &Measured<N>),
) {
    connections.clear();
    let &Arrived { paths, ref rows, path_length, .. } = arrived;
    let mut places = [0.0; LANES];
    for row in rows.clone() {
        let lane = (row - rows.start) % LANES;
        if lane == 0 {
            places = paths.identity.draw_first(row, path_length, Purpose::Connections).to_array();
        }
        let slot = paths.identity.slot[row] as usize;
        let of_path = light.order.rows_of(slot);
        if of_path.is_empty() {
            continue;
        }
        let mut sensor = SensorVertex::load(arrived, &scene, row);
        let mut connect = |sensor: &mut SensorVertex<N>, first: usize| {
            let some = (first, LANES.min(of_path.end - first));
            sensor.connect::<M>(connections, light, scene, some);
        };
        let is_long = of_path.len() > ALWAYS || path_length as usize > ALWAYS;
        if !is_long {
            sensor.play_beside(measured.brought(slot), places[lane]);
            of_path.clone().step_by(LANES).for_each(|first| connect(&mut sensor, first));
            continue;
        }
        let [u, v] = paths.identity.draw_row(row, path_length, Purpose::Connections);
        let chance = (ALWAYS as f32 / path_length as f32).powi(2).min(1.0);
        if u >= chance {
            continue;
        }
        sensor.count_for(1.0 / chance);
        of_path.clone().take(ALWAYS).step_by(LANES).for_each(|first| connect(&mut sensor, first));
        let groups = of_path.len().saturating_sub(ALWAYS).div_ceil(LANES);
        if groups > 0 {
            sensor.count_for(groups as f32);
            let group = ((v * groups as f32) as usize).min(groups - 1);
            connect(&mut sensor, of_path.start + ALWAYS + group * LANES);
        }
    }
}

/// One sensor vertex in all lanes.
struct SensorVertex<'a, const N: usize> {
    row: u32,
    surfaces: &'a SurfaceColumns,
    event: Event,
    /// The medium around it, and the one behind, where light goes through the surface.
    inside: [u32; 2],
    position: Vector<F32s>,
    normal: Vector<F32s>,
    offset: F32s,
    given: Vector<F32s>,
    beta: [F32s; N],
    /// Whether dispersion has sent its path on at one wavelength.
    has_collapsed: bool,
    weights: PartialWeights<F32s>,
    /// Over what a connection must bring to be made for sure, if they are played for.
    per_sure: Option<f32>,
    /// The sum of their chances so far, less those made: from a random number on.
    place: f32,
}

impl<'a, const N: usize> SensorVertex<'a, N> {
    #[inline(always)]
    fn load<C>(arrived: &Arrived<'a, N, C>, scene: &Scene<N>, row: usize) -> Self {
        let &Arrived { paths, surfaces, event, .. } = arrived;
        let mut beta = [F32s::splat(0.0); N];
        for (beta, column) in beta.iter_mut().zip(&paths.beta) {
            *beta = F32s::splat(column[row]);
        }
        Self {
            row: row as u32,
            surfaces,
            event,
            inside: [paths.media.inside(row), arrived.beyond(scene, row)],
            position: Vector::splat(lanes::row_of(&surfaces.position, row)),
            normal: Vector::splat(lanes::row_of(&surfaces.geometric_normal, row)),
            offset: F32s::splat(surfaces.offset[row]),
            given: -Vector::splat(lanes::row_of(&paths.rays.direction, row)),
            beta,
            has_collapsed: has_collapsed(&paths.beta, row),
            weights: paths.mis.splat(row),
            per_sure: None,
            place: 0.0,
        }
    }

    /// Plays for connections that bring little beside what the path `has_brought`, from a random
    /// number in [0, 1) on.
    fn play_beside(&mut self, has_brought: f32, u: f32) {
        self.per_sure = (has_brought > 0.0).then(|| 1.0 / (SURE * has_brought));
        self.place = u;
    }

    /// The lanes of those carrying that are made; their values then count for the others.
    #[inline(always)]
    fn play(&mut self, value: &mut [F32s; N], carrying: F32s) -> F32s {
        let Some(per_sure) = self.per_sure else { return carrying };
        let most = value[1..].iter().fold(value[0], |most, &it| most.fast_max(it));
        let chance = (most * F32s::splat(per_sure)).fast_min(F32s::splat(1.0));
        let mut made = [false; LANES];
        for (made, chance) in made.iter_mut().zip((carrying & chance).to_array()) {
            let place = self.place + chance;
            *made = place >= 1.0;
            self.place = if *made { place - 1.0 } else { place };
        }
        for value in value {
            *value /= chance;
        }
        carrying & lanes::mask_of(made)
    }

    /// The media in which connections along these directions start.
    #[inline(always)]
    fn inside_towards(&self, direction: Vector<F32s>) -> U32s {
        let [here, beyond] = self.inside.map(U32s::splat);
        if self.inside[0] == self.inside[1] {
            return here;
        }
        let passes = self.normal.dot(direction) * self.normal.dot(self.given);
        let passes: U32s = bytemuck::cast(passes.simd_lt(F32s::splat(0.0)));
        (passes & beyond) | (!passes & here)
    }

    /// Makes what connections bring count for so many like it.
    fn count_for(&mut self, vertices: f32) {
        self.beta.iter_mut().for_each(|beta| *beta *= F32s::splat(vertices));
    }

    /// Connects to the `live` vertices from `first` on.
    #[inline(never)]
    fn connect<M: LightModel<N>>(
        &mut self,
        connections: &mut ConnectionTable<N>,
        &LightPaths { vertices, length_max, .. }: &LightPaths<N>,
        scene: SceneAt<N>,
        (first, live): (usize, usize),
    ) {
        let position = Vector::load(&vertices.position, first);
        let offset = position - self.position;
        let distance2 = offset.length_squared();
        let direction = offset * (F32s::splat(1.0) / distance2.sqrt());
        let turn = for_scatterer!(scene, self.event.met, all => {
            all.at(self.surfaces, Same(self.row as usize)).turn(self.given, direction)
        });
        let turn = turn.unwrap_or(Turn::none());
        let light = turn_of_light(vertices, scene, -direction, (first, live));
        let sensor_end = End { weights: self.weights, turn: (&turn).into() };
        let light_end = End { weights: vertices.weights(first), turn: (&light).into() };
        let inverse2 = F32s::splat(1.0) / distance2;
        let factor = mis::weight_of_vertices_connected(sensor_end, light_end, inverse2);
        let mut value = self.beta;
        for (n, value) in value.iter_mut().enumerate() {
            let power = lanes::load(&vertices.power[n], first) * light.value[n];
            *value = *value * turn.value[n] * power * factor;
        }
        if self.has_collapsed {
            let second = lanes::load(&vertices.power[1 % N], first);
            value[0] = met_by_collapsed::<N>(value[0], second);
        }
        let path_length = lanes::load_u32(&vertices.path_length, first);
        let fits: F32s = bytemuck::cast(path_length.simd_le(U32s::splat(length_max)));
        let made = self.play(&mut value, lanes::first(live) & fits);
        let normal = Vector::load(&vertices.geometric_normal, first);
        let from = offset_origin(self.position, self.normal, direction, self.offset);
        // The distances that its test computes have errors of where the ray comes from, too.
        let end = lanes::load(&vertices.offset, first).max(offset_distance(reach(self.position)));
        let to = offset_origin(position, normal, -direction, end);
        let length = (to - from).length();
        let lanes = ConnectionLanes {
            origin: from,
            direction: (to - from) * (F32s::splat(1.0) / length),
            t_max: length,
            value,
            weight: factor * distance2,
            target: U32s::splat(self.row),
            inside: self.inside_towards(direction),
            from: Side::Sensor,
        };
        let carrying = lanes.carrying(live) & made;
        let states = departing_states::<N, M>(vertices, scene, -direction, (first, live));
        if states.iter().all(Option::is_none) {
            connections.push_lanes(&lanes, carrying);
        } else {
            self.push_polarized(connections, &scene, (&lanes, carrying), &states);
        }
    }

    /// Appends the lanes in the mask, which light in these states comes to.
    fn push_polarized(
        &self,
        connections: &mut ConnectionTable<N>,
        scene: &Scene<N>,
        (lanes, carrying): (&ConnectionLanes<N>, F32s),
        states: &[Option<LightState<N>>; LANES],
    ) {
        let carrying = carrying.to_bitmask();
        for lane in (0..LANES).filter(|lane| carrying >> lane & 1 == 1) {
            let (segment, mut cargo) = lanes.lane(lane);
            match &states[lane] {
                Some(state) if self.event.form != Form::Depolarizer || scene.has_straight_on => {
                    connections.push_polarized(segment, cargo, self.row, *state);
                    continue;
                }
                Some(state) => {
                    for (n, value) in cargo.value.iter_mut().enumerate() {
                        *value *= state.at(n).depolarized();
                    }
                }
                None => {}
            }
            connections.push(segment, cargo, self.row);
        }
    }
}
