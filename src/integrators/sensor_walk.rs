//! The steps of a sensor path's walk, shared by the integrators that take it.

use std::ops::Range;

use crate::geometry::{resolve_surfaces, trace_closest};
use crate::scattering::event::Event;
use crate::scattering::{Met, Scene};
use crate::transport::bounce::{Bounce, Side};
use crate::transport::stages::advance_paths::advance_paths;
use crate::transport::stages::collect_emission::collect_emission;
use crate::transport::stages::collect_sensor::collect_sensor;
use crate::transport::stages::connect_to_emitters::connect_to_emitters;
use crate::transport::stages::depolarize_sensor::depolarize_sensor;
use crate::transport::stages::fly_through_media::fly_through_media;
use crate::transport::stages::gather_connections::gather_connections;
use crate::transport::stages::generate_sensor_paths::generate_sensor_paths;
use crate::transport::stages::trace_connections::trace_connections;
use crate::transport::stages::weigh_arrival::weigh_arrival;
use crate::transport::{Chunk, LightModel, Strategy};

use super::bounce::{scatter, sort};
use super::profile::Stage;
use super::workspace::Workspace;

/// Starts the paths. `light_paths` is the number of light paths an iteration that connect to the
/// sensor, or zero.
pub fn start<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    light_paths: f32,
) {
    w.profile.time(Stage::Start, || {
        w.measured.clear();
        let components = w.measured.components();
        generate_sensor_paths(&mut w.sensor[0], chunk, scene, light_paths, components);
    });
}

/// Traces the next segment and measures the emitters that it meets.
pub fn trace<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
    strategy: Strategy,
) {
    let paths = &mut w.sensor[0];
    w.profile.rays_closest += paths.len as u64;
    w.profile.time(Stage::Trace, || {
        let rows = 0..paths.len;
        trace_closest(&mut w.hits[0], &mut w.scratch, &paths.rays, rows, &scene.accelerator);
    });
    if scene.has_media() {
        w.profile.time(Stage::Flight, || {
            let working = (&mut w.flights, &mut w.scratch);
            fly_through_media(&mut w.hits[0], paths, working, scene, path_length);
        });
    }
    w.profile.time(Stage::Emission, || {
        collect_emission(&mut w.measured, paths, &w.hits[0], scene, path_length, strategy);
    });
}

/// Groups the rows by what they have hit and brings them there; `workspace.sensor[1]` holds them.
pub fn arrive<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    path_length: u32,
    strategy: Strategy,
) {
    let [paths, sorted] = &mut w.sensor;
    let bounce = Bounce { path_length, side: Side::Sensor };
    w.profile.time(Stage::Sort, || {
        sort(sorted, paths, &mut w.hits, &mut w.partition, scene, chunk, bounce);
        let rows = 0..sorted.len;
        resolve_surfaces(&mut w.surfaces, &w.hits[1], &sorted.rays, rows, &scene.shapes);
        if strategy == Strategy::Bidirectional {
            let from_infinity = path_length == 1 && !scene.sensor.is_finite();
            let events = (scene, &w.partition);
            weigh_arrival(sorted, &w.hits[1], &w.surfaces, events, from_infinity);
        }
    });
    w.profile.time(Stage::Mueller, || {
        depolarize_sensor(&mut sorted.carriers, &mut sorted.beta, &w.partition);
    });
}

/// Does `work` for every kind of event that can be connected to, and its rows.
pub fn for_each_connectable<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    mut work: impl FnMut(&mut Workspace<N, M>, (Event, Range<usize>)),
) {
    let all = std::mem::take(&mut w.partition);
    // The partition is put aside, since what is done with its rows writes to its neighbors.
    for of_event in all.connectable() {
        work(w, of_event);
    }
    w.partition = all;
}

/// Connects the vertices that can be to one emitter each.
pub fn connect_emitters<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
    strategy: Strategy,
) {
    for_each_connectable(w, |w, of_event| {
        let met = of_event.0.met;
        let (connections, paths) = (&mut w.connections, &w.sensor[1]);
        let surfaces = &w.surfaces;
        w.profile.time(Stage::Connect, || {
            connect_to_emitters(
                connections,
                paths,
                surfaces,
                scene,
                of_event,
                path_length,
                strategy,
            );
        });
        measure_connections(w, scene, met);
    });
}

/// Tests the connections at hand, from vertices that have `met` the same, and adds up those that
/// are open.
pub fn measure_connections<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    met: Met,
) {
    w.profile.rays_visibility += w.connections.len as u64;
    w.profile.time(Stage::Visibility, || {
        trace_connections(&mut w.connections, (&mut w.flights, &mut w.scratch), scene);
    });
    w.profile.time(Stage::Gather, || {
        let (connections, paths) = (&w.connections, &w.sensor[1]);
        gather_connections::<N, M>(&mut w.measured, connections, paths, scene, met);
    });
}

/// Sends the rows on in new directions; `workspace.sensor[0]` holds them then.
pub fn depart<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
) {
    let paths = &mut w.sensor[1];
    let bounce = Bounce { path_length, side: Side::Sensor };
    let (drawn, kernels) = (&mut w.drawn, &mut w.kernels);
    w.profile.time(Stage::Scatter, || {
        scatter::<N, M, _>(drawn, kernels, paths, &w.surfaces, scene, &w.partition, bounce);
    });
    w.profile.time(Stage::Mueller, || {
        let (directions, up) = (&paths.rays.direction, scene.sensor.up());
        collect_sensor(&mut paths.carriers, kernels, directions, up, &w.partition);
    });
    w.profile.time(Stage::Advance, || advance_paths(paths, drawn, &w.surfaces, scene.reach));
    w.sensor.swap(0, 1);
}
