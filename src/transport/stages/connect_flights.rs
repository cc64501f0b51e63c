//! Next-event estimation between vertices: connects places in media, on the way of sensor paths,
//! to lamps.

use glam::Vec3;

use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::emitter::chance_of_choice;
use crate::scattering::emitter::direct::DirectLanes;
use crate::scattering::emitter::lamps::Lamps;
use crate::scattering::emitter::tree::Vantage;
use crate::scattering::phase::for_phase;
use crate::scattering::vertex::{InMedium, Turn, Vertices};
use crate::scattering::{Scene, Side};
use crate::transport::emission::state_sent;
use crate::transport::piece::PieceLanes;
use crate::transport::sides::SensorSide;
use crate::transport::tables::connections::{Cargo, ConnectionTable, Segment};
use crate::transport::tables::flights::{FlightTable, Progress};
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::pieces::PieceTable;
use crate::transport::tables::states::LightState;

/// Connects a place on every piece of a segment in a medium to one lamp each.
///
/// From: choose_lamps. To: trace_connections.
/// Writes: connections. Reads: pieces, paths, flights, scene.
pub fn connect_flights<const N: usize, C: SensorSide<N>>(
    connections: &mut ConnectionTable<N>,
    pieces: &PieceTable,
    (paths, flights): (&PathTable<N, C>, &FlightTable<N>),
    scene: &Scene<N>,
) {
    connections.clear();
    let Some(lamps) = &scene.lamps else { return };
    for first in (0..pieces.len).step_by(LANES) {
        let live = LANES.min(pieces.len - first);
        let rows = pieces.rows_of_paths(first);
        let piece = PieceLanes::load(pieces, paths, (scene.medium(pieces.medium), first), &rows);
        let place = place(&piece, scene, lamps, (pieces, first));
        let turn = for_phase!(&piece.medium.phase, phase => {
            InMedium { medium: piece.medium, phase }.turn(-piece.direction, place.lamp.direction)
        });
        push(
            connections,
            (&piece, &place, &turn),
            (paths, flights),
            (&rows[..live], pieces.medium),
            scene,
        );
    }
}

/// Places on pieces, each with a lamp.
struct Places<const N: usize> {
    position: Vector<F32s>,
    /// Where that is on the piece, from its beginning.
    length: F32s,
    lamp: DirectLanes<N>,
    /// The rows of the lamps.
    emitters: [usize; LANES],
    /// What the light that is found is multiplied by: the weight over the density, and the square
    /// of the distance.
    factor: F32s,
}

impl<const N: usize> Places<N> {
    /// How the light of a lamp is polarized that comes to its place.
    #[inline(always)]
    fn state(&self, scene: &Scene<N>, lane: usize) -> Option<LightState<N>> {
        if !scene.has_polarized_lamps() {
            return None;
        }
        let [point, towards] = [self.lamp.point, self.lamp.direction].map(|it| it.lane(lane));
        let [point, towards]: [[f32; 3]; 2] = [point.into(), towards.into()];
        state_sent(scene, self.emitters[lane], (point.into(), -Vec3::from(towards)))
    }
}

#[inline(always)]
fn place<const N: usize>(
    piece: &PieceLanes<N>,
    scene: &Scene<N>,
    lamps: &Lamps,
    (pieces, first): (&PieceTable, usize),
) -> Places<N> {
    let emitters = lanes::each(|lane| pieces.lamp[pieces.in_use(first + lane)] as usize);
    let chance = lanes::load(&pieces.chance, first);
    let seen = piece.seen_by(lamps, emitters);
    let [from, to] = piece.range;
    let distance = seen.sample(lanes::load(&pieces.place, first)).max(from).min(to);
    let position = piece.origin + piece.direction * distance;
    let mut lamp =
        scene.direct.sample(&scene.optics.lamps, (emitters, chance), position, [F32s::ZERO; 2]);
    if !scene.optics.patterns.is_empty() {
        scene.weigh_patterns(&mut lamp, emitters);
    }
    let rows = position.to_rows();
    let of_vertex = F32s::from(lanes::each(|lane| {
        let from = Vantage { position: rows[lane].into(), normal: Vec3::ZERO };
        chance_of_choice(scene, emitters[lane], &from)
    }));
    let density = of_vertex.mul_add(piece.density(distance), chance * seen.density(distance));
    Places {
        position,
        length: distance - from,
        lamp,
        emitters,
        factor: chance / (density * lamp.pdf_w),
    }
}

/// Appends the connections of eight places that would carry anything.
#[inline(always)]
fn push<const N: usize, C: SensorSide<N>>(
    connections: &mut ConnectionTable<N>,
    (piece, place, turn): (&PieceLanes<N>, &Places<N>, &Turn<N>),
    (paths, flights): (&PathTable<N, C>, &FlightTable<N>),
    (rows, inside): (&[usize], u32),
    scene: &Scene<N>,
) {
    let mut values = [[0.0; LANES]; N];
    for (n, values) in values.iter_mut().enumerate() {
        let transmittance = (-(F32s::splat(piece.medium.sigma_t[n]) * place.length)).exp();
        let scattered = F32s::splat(piece.medium.sigma_s[n]) * transmittance * turn.value[n];
        *values = (scattered * place.lamp.radiance[n] * place.factor).to_array();
    }
    let is_polarized = paths.carriers.columns().is_some();
    let (from, to) = (place.position.to_rows(), place.lamp.point.to_rows());
    for (lane, &row) in rows.iter().enumerate() {
        let Progress { depth, drawn, .. } = &flights.progress[row];
        let reaching = paths.media.reaching(row, depth, drawn);
        let mut value = lanes::row_of_lanes(&values, lane);
        for (n, value) in value.iter_mut().enumerate() {
            *value *= paths.beta[n][row] * reaching[n];
        }
        if value.iter().any(|&value| value > 0.0) {
            let segment = Segment::between(Side::Sensor, from[lane], to[lane], inside);
            let cargo = Cargo { value, weight: 1.0 };
            match place.state(scene, lane).filter(|_| is_polarized) {
                Some(state) => connections.push_polarized(segment, cargo, row as u32, state),
                None => connections.push(segment, cargo, row as u32),
            }
        }
    }
}
