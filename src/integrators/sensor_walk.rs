//! The steps of a sensor path's walk, shared by the integrators that take it.

use crate::geometry::{resolve_surfaces, trace_closest};
use crate::scattering::Scene;
use crate::scene::baked::MaterialKind;
use crate::transport::stages::advance_paths::advance_paths;
use crate::transport::stages::collect_emission::{Strategy, collect_emission};
use crate::transport::stages::collect_sensor::SensorSide;
use crate::transport::stages::connect_to_emitters::connect_to_emitters;
use crate::transport::stages::gather_connections::{gather_connections, trace_connections};
use crate::transport::stages::generate_sensor_paths::generate_sensor_paths;
use crate::transport::stages::scatter_diffuse::Side;
use crate::transport::stages::weigh_arrival::weigh_arrival;
use crate::transport::{Chunk, LightModel};

use super::bounce::{Bounce, scatter, sort};
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
        generate_sensor_paths(&mut w.sensor[0], chunk, &scene.sensor, light_paths);
    });
}

/// Traces the next segment and measures the emitters that it meets.
pub fn trace<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
    strategy: Strategy,
) {
    let paths = &w.sensor[0];
    w.profile.rays_closest += paths.len as u64;
    w.profile.time(Stage::Trace, || {
        trace_closest(&mut w.hits[0], &paths.rays, 0..paths.len, &scene.accelerator);
    });
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
        resolve_surfaces(&mut w.surfaces, &w.hits[1], &sorted.rays, rows, &scene.tables);
        if strategy == Strategy::Bidirectional {
            let from_infinity = path_length == 1 && !scene.sensor.is_finite();
            weigh_arrival(sorted, &w.hits[1], &w.surfaces, from_infinity);
        }
    });
    w.profile.time(Stage::Mueller, || {
        sorted.carriers.depolarize_sensor(&mut sorted.beta, &w.partition);
    });
}

/// Connects the diffuse vertices to one emitter each.
pub fn connect_emitters<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
    strategy: Strategy,
) {
    let rows = w.partition.rows_of(MaterialKind::Diffuse);
    let (connections, paths) = (&mut w.connections, &w.sensor[1]);
    w.profile.time(Stage::Connect, || {
        connect_to_emitters(connections, paths, &w.surfaces, scene, rows, path_length, strategy);
    });
    measure_connections(w, scene);
}

/// Tests the connections at hand and adds up those that are open.
pub fn measure_connections<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
) {
    w.profile.rays_visibility += w.connections.len as u64;
    w.profile.time(Stage::Visibility, || trace_connections(&mut w.connections, scene));
    w.profile.time(Stage::Gather, || {
        gather_connections(&mut w.measured, &w.connections, &w.sensor[1]);
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
        paths.carriers.collect_sensor(kernels, directions, up, &w.partition);
    });
    w.profile.time(Stage::Advance, || advance_paths(paths, drawn, &w.surfaces, scene.reach));
    w.sensor.swap(0, 1);
}
