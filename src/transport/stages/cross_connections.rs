//! Takes the light of connections through surfaces.

use crate::geometry::CROSSES;
use crate::math::elementary::exp;
use crate::math::{Vector, lanes};
use crate::polarization::kernel::Kernel;
use crate::scattering::Scene;
use crate::scattering::event::Form;
use crate::scattering::surface::Crossed;
use crate::scene::baked::NONE;
use crate::transport::Strategy;
use crate::transport::crossing::dense_at;
use crate::transport::mis;
use crate::transport::scale::excess;
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::crossings::{CrossingPart, CrossingTable};
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::states::LightState;

/// Takes the light of all connections that cross surfaces through these and the media between, and
/// opens them. With `POLARIZED`, in the order in which light meets them.
///
/// From: pass_surfaces. To: gather_connections, splat_connections.
/// Writes: connections (value, state, states, inside, blocked), flights. Reads: crossings, scene.
pub fn cross_connections<const N: usize, const POLARIZED: bool>(
    connections: &mut ConnectionTable<N>,
    flights: &mut FlightTable<N>,
    crossings: &CrossingTable<N>,
    scene: &Scene<N>,
    strategy: Strategy,
) {
    if scene.has_media() {
        for index in 0..crossings.len {
            fly_piece(connections, flights, (crossings, index), scene);
        }
    }
    for row in 0..connections.len {
        if connections.blocked[row] == CROSSES {
            connections.blocked[row] = 0;
            if scene.has_media() {
                arrive(connections, flights, row, scene);
            }
        }
    }
    let acting: Vec<&CrossingPart> = crossings.parts.iter().filter(|it| it.kind.acts()).collect();
    // A ray that starts at the sensor's end meets the surfaces in the order of light reversed.
    for part in acting.iter().rev() {
        pass::<N, POLARIZED>(connections, flights, (crossings, part), scene, true);
    }
    for part in &acting {
        pass::<N, POLARIZED>(connections, flights, (crossings, part), scene, false);
    }
    reweigh(connections, flights, strategy);
}

/// Through the medium before a crossing, into the one behind.
fn fly_piece<const N: usize>(
    connections: &mut ConnectionTable<N>,
    flights: &mut FlightTable<N>,
    (crossings, index): (&CrossingTable<N>, usize),
    scene: &Scene<N>,
) {
    let row = crossings.row[index] as usize;
    let inside = connections.inside[row];
    let t = crossings.hits.t[index];
    absorb(flights, row, inside, t - flights.progress[row].travelled, scene);
    flights.progress[row].travelled = t;
    connections.inside[row] =
        scene.medium_behind(&crossings.surfaces, &crossings.rays, index, inside);
}

/// Through the last medium; what all have absorbed is taken from the light.
fn arrive<const N: usize>(
    connections: &mut ConnectionTable<N>,
    flights: &mut FlightTable<N>,
    row: usize,
    scene: &Scene<N>,
) {
    let length = connections.t_max[row] - flights.progress[row].travelled;
    absorb(flights, row, connections.inside[row], length, scene);
    for (value, depth) in connections.value[row].iter_mut().zip(flights.progress[row].depth) {
        *value *= exp(-depth);
    }
}

fn absorb<const N: usize>(
    flights: &mut FlightTable<N>,
    row: usize,
    inside: u32,
    length: f32,
    scene: &Scene<N>,
) {
    if inside == NONE {
        return;
    }
    let depth = &mut flights.progress[row].depth;
    for (depth, sigma) in depth.iter_mut().zip(&scene.medium(inside).sigma_t) {
        *depth += sigma * length.clamp(0.0, f32::MAX);
    }
}

/// Weighs connections against strategies that trace the segment, and pass by chance.
fn reweigh<const N: usize>(
    connections: &mut ConnectionTable<N>,
    flights: &FlightTable<N>,
    strategy: Strategy,
) {
    for (row, progress) in flights.progress.iter().enumerate() {
        let chance = match strategy {
            Strategy::Unidirectional | Strategy::Merging => progress.chance * progress.chance,
            Strategy::Bidirectional => progress.chance,
        };
        // What is closed has taken all.
        if chance > 0.0 && chance < 1.0 {
            let gain = mis::gain_of_crossing(connections.weight[row], chance);
            connections.value[row].iter_mut().for_each(|value| *value *= gain);
        }
    }
}

/// Takes the light of the connections whose rays start at the sensor's end, or of the others,
/// through the surfaces of a part.
fn pass<const N: usize, const POLARIZED: bool>(
    connections: &mut ConnectionTable<N>,
    flights: &mut FlightTable<N>,
    (crossings, part): (&CrossingTable<N>, &CrossingPart),
    scene: &Scene<N>,
    from_sensor: bool,
) {
    for index in part.rows.clone() {
        let row = crossings.row[index] as usize;
        if (connections.from_sensor[row] == 1) != from_sensor {
            continue;
        }
        flights.progress[row].chance *= crossings.chance[index];
        let value = &mut connections.value[row];
        for (value, transmittance) in value.iter_mut().zip(crossings.transmittance[index]) {
            *value *= transmittance;
        }
        if let (true, Crossed::Model(kind)) = (POLARIZED, part.kind) {
            if kind.form_straight_on() == Form::Dense {
                let kernels = dense_at(crossings, (kind, index), scene, from_sensor);
                polarize(connections, row, &kernels, (crossings, index));
            } else {
                polarize(connections, row, &crossings.kernels(index, kind), (crossings, index));
            }
        }
    }
}

/// Applies the kernels of a crossing.
fn polarize<const N: usize, K: Kernel<f32>>(
    connections: &mut ConnectionTable<N>,
    row: usize,
    kernels: &[K; N],
    (crossings, index): (&CrossingTable<N>, usize),
) {
    let axis: Vector<f32> = lanes::row_of(&crossings.axis, index).into();
    let k = connections.along_light(row);
    if connections.state[row] == NONE {
        connections.state[row] = connections.states.len() as u32;
        connections.states.push(LightState::first_event(kernels, axis));
        return;
    }
    let state = &mut connections.states[connections.state[row] as usize];
    *state = state.scatter(kernels, axis, k);
    for (n, value) in connections.value[row].iter_mut().enumerate() {
        let scale = excess(state.stokes[n].0[0]);
        *value *= scale;
        state.stokes[n] = state.stokes[n].scaled(1.0 / scale);
    }
}
