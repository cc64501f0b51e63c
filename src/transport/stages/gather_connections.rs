//! Adds up what open connections carry.

use std::ops::Range;

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
use crate::transport::tables::states::scatter_states;

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
        for first in (0..connections.len).step_by(LANES) {
            let some = first..connections.len.min(first + LANES);
            gather_polarized(measured, connections, (paths, surfaces), (scene, met), some);
        }
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

/// Eight of them at most, to polarizing vertices.
fn gather_polarized<const N: usize, C: SensorSide<N>>(
    measured: &mut Measured<N>,
    connections: &ConnectionTable<N>,
    (paths, surfaces): (&PathTable<N, C>, &SurfaceColumns),
    (scene, met): (SceneAt<N>, Met),
    rows: Range<usize>,
) {
    if rows.clone().all(|index| connections.blocked[index] != 0) {
        return;
    }
    let target = |lane: usize| connections.target[(rows.start + lane).min(rows.end - 1)] as usize;
    let k_in = -Vector::load(&connections.rays.direction, rows.start);
    let k_out = -Vector::gather(|lane| lanes::row_of(&paths.rays.direction, target(lane)));
    let found = for_scatterer!(scene, met, all => {
        all.at(surfaces, lanes::each(target)).leaving(k_in, k_out)
    });
    let Some(leaving) = found else { return };
    let (first, k_out) = (rows.start, k_out.to_rows());
    let open = (0..rows.len()).filter(|lane| connections.blocked[first + lane] == 0);
    let state = |lane: usize| connections.states.get(connections.state[first + lane] as usize);
    scatter_states(&leaving, k_in, open, state, |lane, light| {
        let row = target(lane);
        let place = (row, paths.identity.slot[row] as usize);
        let along = (k_out[lane].into(), scene.sensor.up());
        let value = connections.value[first + lane];
        measure_polarized(measured, &paths.carriers, place, value, light, along);
    });
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
