//! Adds up what open connections carry.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::SurfaceColumns;
use crate::math::{LANES, Vector, lanes};
use crate::polarization::{Arrival, SensorRow, Stokes, film_axis};
use crate::scattering::Met;
use crate::scattering::event::Form;
use crate::scattering::painting::SceneAt;
use crate::scattering::sensor::Sensor;
use crate::scattering::vertex::{Scatterer, Vertices, for_scatterer};
use crate::scene::baked::NONE;
use crate::transport::LightModel;
use crate::transport::measure::{measure_polarized, measure_unpolarized};
use crate::transport::sides::SensorSide;
use crate::transport::tables::connections::ConnectionTable;
use crate::transport::tables::measured::{Measured, PolarizedSplat, Splats};
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::states::{LightState, kernels_of_lanes};

/// Adds open connections to the slots of the sensor paths they belong to, all of which have met
/// the same. In polarized mode, polarizing vertices apply their kernels to the light that arrives.
///
/// From: trace_connections, cross_connections. To: weigh_samples, the film.
/// Writes: measured. Reads: connections, paths, surfaces, scene.
pub fn gather_connections<const N: usize, M: LightModel<N>>(
    measured: &mut Measured<N>,
    connections: &ConnectionTable<N>,
    (paths, surfaces): (&PathTable<N, M::Sensor>, &SurfaceColumns),
    scene: SceneAt<N>,
    met: Met,
) {
    if M::POLARIZED && scene.events[met.event()].form != Form::Depolarizer {
        let of = (paths, surfaces);
        for_scatterer!(scene, met, all => {
            gather_polarized(measured, connections, of, all, scene.sensor.up());
        });
        return;
    }
    for index in 0..connections.len {
        if connections.blocked[index] == 0 {
            let row = connections.target[index] as usize;
            let slot = paths.identity.slot[row] as usize;
            let mut value = connections.value[index];
            if let Some(state) = connections.states.get(connections.state[index] as usize) {
                for (n, value) in value.iter_mut().enumerate() {
                    *value *= state.at(n).depolarized();
                }
            }
            measure_unpolarized(measured, &paths.carriers, (row, slot), value);
        }
    }
}

/// Connections to polarizing vertices.
fn gather_polarized<const N: usize, C: SensorSide<N>, S: Scatterer<N>>(
    measured: &mut Measured<N>,
    connections: &ConnectionTable<N>,
    of: (&PathTable<N, C>, &SurfaceColumns),
    all: S,
    film_up: Vec3,
) {
    // No such event gets here, and nothing is compiled for it.
    if !S::POLARIZES {
        return;
    }
    for first in (0..connections.len).step_by(LANES) {
        let rows = first..connections.len.min(first + LANES);
        gather_scattered(measured, connections, of, all, rows, film_up);
    }
}

/// Eight of them.
fn gather_scattered<const N: usize, C: SensorSide<N>, S: Scatterer<N>>(
    measured: &mut Measured<N>,
    connections: &ConnectionTable<N>,
    (paths, surfaces): (&PathTable<N, C>, &SurfaceColumns),
    all: S,
    rows: Range<usize>,
    film_up: Vec3,
) {
    if rows.clone().all(|index| connections.blocked[index] != 0) {
        return;
    }
    let target = |lane: usize| connections.target[(rows.start + lane).min(rows.end - 1)] as usize;
    let k_in = -Vector::load(&connections.rays.direction, rows.start);
    let k_out = -Vector::gather(|lane| lanes::row_of(&paths.rays.direction, target(lane)));
    let (kernels, axis) = all.at(surfaces, lanes::each(target)).kernels(k_in, k_out);
    let kernels = kernels_of_lanes(&kernels);
    let (axis, k_in, k_out) = (axis.to_rows(), k_in.to_rows(), k_out.to_rows());
    for (lane, index) in rows.clone().enumerate() {
        if connections.blocked[index] != 0 {
            continue;
        }
        let (axis, k_in) = (axis[lane].into(), k_in[lane].into());
        let light = match connections.state[index] {
            NONE => LightState::first_event(&kernels[lane], axis),
            state => connections.states[state as usize].scatter(&kernels[lane], axis, k_in),
        };
        let row = target(lane);
        let place = (row, paths.identity.slot[row] as usize);
        let along = (k_out[lane].into(), film_up);
        let value = connections.value[index];
        measure_polarized(measured, &paths.carriers, place, value, &light, along);
    }
}

/// Appends open connections to the sensor to the lists of splats, in their order, polarized light
/// in the film's frame, or, behind an analyzer, twice what passes of it, as S0.
///
/// From: trace_connections, cross_connections. To: the film.
/// Writes: splats. Reads: connections, sensor.
pub fn splat_connections<const N: usize>(
    splats: &mut Splats<N>,
    connections: &ConnectionTable<N>,
    sensor: &Sensor,
) {
    let passing = sensor.analyzer().map(|analyzer| analyzer.state().0.map(|value| value as f32));
    for index in (0..connections.len).filter(|&index| connections.blocked[index] == 0) {
        let (pixel, value) = (connections.target[index], connections.value[index]);
        match connections.state[index] {
            NONE => splats.push(pixel, value),
            state => {
                let k = connections.along_light(index);
                let film_x = film_axis(-k, sensor.up().to_array().into());
                let light = &connections.states[state as usize];
                let arrival = Arrival::between(light.x, film_x, k);
                let mut stokes = [[0.0; 4]; N];
                for (n, (stokes, &value)) in stokes.iter_mut().zip(&value).enumerate() {
                    let arriving = light.at(n);
                    let measured = match passing {
                        None => arriving.turned(&arrival).stokes,
                        Some(row) => {
                            let behind = SensorRow { row, x: film_x };
                            Stokes([behind.measure(&arriving, &arrival), 0.0, 0.0, 0.0])
                        }
                    };
                    *stokes = measured.scaled(value).0;
                }
                splats.polarized.push(PolarizedSplat { pixel, stokes });
            }
        }
    }
}
