//! Next-event estimation: connects vertices of sensor paths to emitters.

use std::any::Any;

use glam::Vec3;

use crate::geometry::{SurfaceColumns, offset_distance, offset_origin, reach};
use crate::math::{F32s, LANES, Real, U32s, Vector, lanes};
use crate::scattering::emitter::direct::{DirectLanes, either};
use crate::scattering::event::Form;
use crate::scattering::painting::SceneAt;
use crate::scattering::vertex::{Consecutive, Scatterer, Turn, Vertices, for_scatterer};
use crate::scattering::{Met, Scene, Side};
use crate::transport::emission::state_sent;
use crate::transport::mis::{self, EmitterDensities, End, PartialWeights};
use crate::transport::piece::PieceLanes;
use crate::transport::sampler::{Purpose, draw};
use crate::transport::sides::SensorSide;
use crate::transport::tables::connections::{ConnectionLanes, ConnectionTable};
use crate::transport::tables::paths::AnyPaths;
use crate::transport::vantage::vantages;
use crate::transport::{Arrived, Strategy};

/// Connects rows that have arrived to one emitter each. In polarized mode the light is in the state
/// in which it leaves that, where anything comes that asks.
///
/// From: depolarize_sensor. To: trace_connections.
/// Writes: connections. Reads: arrived (paths, surfaces), scene.
pub fn connect_to_emitters<const N: usize, C: SensorSide<N>>(
    connections: &mut ConnectionTable<N>,
    arrived: &Arrived<N, C>,
    scene: SceneAt<N>,
    strategy: Strategy,
) {
    connections.clear();
    let asks = arrived.event.form != Form::Depolarizer || scene.has_straight_on;
    let is_polarized = asks && arrived.paths.carriers.columns().is_some();
    let any = &arrived.of_any();
    for_scatterer!(scene, arrived.event.met, all => {
        let turn = |rows: Consecutive, given, drawn| {
            all.at(arrived.surfaces, rows).turn(given, drawn)
        };
        connect(connections, (any, is_polarized), (&scene, &turn), strategy);
    });
}

/// What vertices in some rows do to light between two directions.
// Called by way of a pointer: the stage is large, and is compiled once for all scatterers.
type TurnOf<'a, const N: usize> = dyn Fn(Consecutive, Vector<F32s>, Vector<F32s>) -> Turn<N> + 'a;

fn connect<const N: usize>(
    connections: &mut ConnectionTable<N>,
    (arrived, is_polarized): (&Arrived<N, dyn Any>, bool),
    (scene, turn_of): (&Scene<N>, &TurnOf<N>),
    strategy: Strategy,
) {
    let &Arrived { paths, surfaces, ref rows, path_length, event } = arrived;
    let has_states = is_polarized && scene.has_polarized_lamps();
    let lit = medium_lit(event.met, scene).filter(|_| strategy.connects_flights());
    for row in rows.clone().step_by(LANES) {
        let live = LANES.min(rows.end - row);
        let Chosen { lanes: mut chosen, offset, emitters, chance: of_choice } =
            choose(paths, surfaces, scene, (row, live), path_length);
        if scene.has_painted_lamps {
            let at = (chosen.point, chosen.direction);
            scene.tint_lanes(&mut chosen.radiance, emitters, at);
        }
        if !scene.optics.patterns.is_empty() {
            scene.weigh_patterns(&mut chosen, emitters);
        }
        if scene.has_incandescent_lamps() {
            let to = (chosen.normal, chosen.direction);
            scene.weigh_exits(&mut chosen.radiance, emitters, to);
        }
        let given = -Vector::load(&paths.rays.direction, row);
        let turn = turn_of(Consecutive(row, live), given, chosen.direction);
        let chance = mis::chance_over_choice(turn.pdf, chosen.reachable, chosen.pdf_w);
        let weight = match strategy {
            Strategy::Unidirectional | Strategy::Merging => mis::power_of_emitter_connected(chance),
            Strategy::Bidirectional => {
                if let Some(aim) = &scene.aim {
                    aim.mix(&mut chosen, emitters, Vector::load(&surfaces.position, row));
                }
                bidirectional_weight(paths.mis.load(row), &chosen, &turn, chance)
            }
        };
        let mut factor = weight / chosen.pdf_w;
        if let Some(medium) = lit {
            factor *= weight_beside_lamps(arrived, scene, medium, row, (emitters, of_choice));
        }
        let mut value = chosen.radiance;
        for (n, value) in value.iter_mut().enumerate() {
            let beta = lanes::load(&paths.beta[n], row) * turn.value[n];
            *value = beta * *value * factor;
        }
        let lanes = segments(arrived, scene, (&chosen, offset), (value, weight), row);
        let (first, carrying) = (connections.len, lanes.carrying(live));
        connections.push_lanes(&lanes, carrying);
        if has_states {
            let bits = carrying.to_bitmask();
            polarize(connections, (first, bits), (emitters, chosen.point, chosen.direction), scene);
        }
    }
}

/// Gives the rows from `first` on, which are the lanes of the mask `bits`, the states in which
/// their light leaves the emitters.
#[inline(never)]
fn polarize<const N: usize>(
    connections: &mut ConnectionTable<N>,
    (first, bits): (usize, u32),
    (emitters, points, towards): ([usize; LANES], Vector<F32s>, Vector<F32s>),
    scene: &Scene<N>,
) {
    let (points, towards) = (points.to_rows(), towards.to_rows());
    let lanes = (0..LANES).filter(|lane| bits >> lane & 1 == 1);
    for (row, lane) in (first..).zip(lanes) {
        let from = (points[lane].into(), -Vec3::from(towards[lane]));
        if let Some(state) = state_sent(scene, emitters[lane], from) {
            connections.set_state(row, state);
        }
    }
}

/// The medium that was met, if lamps light it on the way of paths.
fn medium_lit<const N: usize>(met: Met, scene: &Scene<N>) -> Option<u32> {
    let Met::Medium(medium) = met else { return None };
    scene.lamps.as_ref().filter(|lamps| lamps.light(medium)).map(|_| medium)
}

/// The weight of vertices in a medium beside the places on the way there that connect to lamps.
fn weight_beside_lamps<const N: usize>(
    &Arrived { paths, surfaces, .. }: &Arrived<N, dyn Any>,
    scene: &Scene<N>,
    medium: u32,
    row: usize,
    chosen: ([usize; LANES], F32s),
) -> F32s {
    let (origin, direction) =
        (Vector::load(&paths.rays.origin, row), Vector::load(&paths.rays.direction, row));
    let range = [&paths.piece.from, &paths.piece.to].map(|column| lanes::load(column, row));
    let piece = PieceLanes { medium: scene.medium(medium), origin, direction, range };
    let distance = (Vector::load(&surfaces.position, row) - origin).dot(direction);
    piece.weight_of_flight(scene, distance, chosen)
}

/// The weight among all strategies; `chance` as in [`mis::chance_over_choice`].
#[inline(always)]
fn bidirectional_weight<const N: usize>(
    weights: PartialWeights<F32s>,
    chosen: &DirectLanes<N>,
    turn: &Turn<N>,
    chance: F32s,
) -> F32s {
    let &DirectLanes { pdf_w: direct_pdf, emission_pdf, cos_at_light, .. } = chosen;
    let emitter = EmitterDensities { direct_pdf, emission_pdf, cos_at_light };
    let sensor = End { weights, turn: turn.into() };
    mis::weight_of_emitter_connected(sensor, emitter, chance)
}

/// One emitter a row, and a point or direction on it.
#[inline(always)]
fn choose<const N: usize>(
    paths: &AnyPaths<N>,
    surfaces: &SurfaceColumns,
    scene: &Scene<N>,
    (row, live): (usize, usize),
    path_length: u32,
) -> Chosen<N> {
    let seed = lanes::load_u32(&paths.identity.seed, row);
    let iteration = lanes::load_u32(&paths.identity.iteration, row);
    let choice = draw(seed, iteration, path_length, Purpose::Emitter).map(|u| u.to_array());
    let u = draw(seed, iteration, path_length, Purpose::EmitterPosition);
    let reference = Vector::load(&surfaces.position, row);
    if !scene.choice.depends_on_vantage() {
        return choose_by_power(scene, choice, reference, u);
    }
    let from = vantages(surfaces, Vector::load(&paths.rays.direction, row), scene, row);
    let of = scene.choice.choose(&from, choice, live);
    let emitters = lanes::each(|lane| of[lane].0);
    let chance = F32s::from(lanes::each(|lane| of[lane].1));
    let offset = F32s::from(lanes::each(|lane| scene.emitter_offset(emitters[lane])));
    let lanes = scene.direct.sample(&scene.optics.lamps, (emitters, chance), reference, u);
    Chosen { lanes, offset, emitters, chance }
}

/// One of two emitters at most.
#[inline(always)]
fn choose_by_power<const N: usize>(
    scene: &Scene<N>,
    choice: [[f32; LANES]; 2],
    reference: Vector<F32s>,
    u: [F32s; 2],
) -> Chosen<N> {
    let second = scene.choice.second_by_power(choice);
    let all = &scene.optics.emitters;
    let both = [0, all.len() - 1];
    let chance = either(second, both.map(|emitter| all[emitter].probability));
    let offset = either(second, both.map(|emitter| scene.emitter_offset(emitter)));
    let lanes = scene.direct.sample_either(&scene.optics.lamps, (second, chance), reference, u);
    let bits = second.to_bitmask();
    let emitters = lanes::each(|lane| (bits >> lane & 1) as usize);
    Chosen { lanes, offset, emitters, chance }
}

/// Points of emitters, or directions to them.
struct Chosen<const N: usize> {
    lanes: DirectLanes<N>,
    /// How far before the emitters segments end.
    offset: F32s,
    /// The emitters.
    emitters: [usize; LANES],
    /// The probabilities of choosing them.
    chance: F32s,
}

/// Eight connections to be tested, off the surfaces at both ends, with what they would carry.
#[inline(always)]
fn segments<const N: usize>(
    arrived: &Arrived<N, dyn Any>,
    scene: &Scene<N>,
    (chosen, offset): (&DirectLanes<N>, F32s),
    (value, weight): ([F32s; N], F32s),
    row: usize,
) -> ConnectionLanes<N> {
    let surfaces = arrived.surfaces;
    let position = Vector::load(&surfaces.position, row);
    let normal = Vector::load(&surfaces.geometric_normal, row);
    let start = lanes::load(&surfaces.offset, row);
    let origin = offset_origin(position, normal, chosen.direction, start);
    // The distances that its test computes have errors of where the ray comes from, too.
    let before = offset.max(offset_distance(reach(position)));
    let end = offset_origin(chosen.point, chosen.normal, -chosen.direction, before);
    let offset = end - origin;
    let length = offset.length();
    let towards = offset * (F32s::splat(1.0) / length);
    ConnectionLanes {
        origin,
        direction: Vector::select(chosen.finite, towards, chosen.direction),
        t_max: Real::select(chosen.finite, length, F32s::splat(f32::INFINITY)),
        value,
        weight,
        target: U32s::from(lanes::each(|lane| (row + lane) as u32)),
        inside: arrived.inside_towards(scene, chosen.direction, row),
        from: Side::Sensor,
    }
}
