//! Path tracing from the sensor with next-event estimation: the plain reference.

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
use crate::transport::{Chunk, LightModel};

use super::bounce::{Bounce, scatter, sort};
use super::profile::Stage;
use super::workspace::Workspace;

/// Measures one chunk into `workspace.measured`.
pub fn path<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    let w = workspace;
    let up = scene.sensor.up();
    w.profile.time(Stage::Start, || {
        w.measured.clear();
        generate_sensor_paths(&mut w.sensor[0], chunk, &scene.sensor, 0.0);
    });
    for path_length in 1..=chunk.path_length_max {
        let [paths, sorted] = &mut w.sensor;
        w.profile.rays_closest += paths.len as u64;
        w.profile.time(Stage::Trace, || {
            trace_closest(&mut w.hits[0], &paths.rays, 0..paths.len, &scene.accelerator);
        });
        w.profile.time(Stage::Emission, || {
            let strategy = Strategy::Unidirectional;
            collect_emission(&mut w.measured, paths, &w.hits[0], scene, path_length, strategy);
        });
        if path_length == chunk.path_length_max || paths.len == 0 {
            break;
        }
        let bounce = Bounce { path_length, side: Side::Sensor };
        w.profile.time(Stage::Sort, || {
            sort(sorted, paths, &mut w.hits, &mut w.partition, scene, chunk, bounce);
            resolve_surfaces(
                &mut w.surfaces,
                &w.hits[1],
                &sorted.rays,
                0..sorted.len,
                &scene.tables,
            );
        });
        w.profile.time(Stage::Mueller, || {
            sorted.carriers.depolarize_sensor(&mut sorted.beta, &w.partition);
        });
        connect(w, scene, path_length);

        let sorted = &mut w.sensor[1];
        w.profile.time(Stage::Scatter, || {
            scatter::<N, M, _>(
                &mut w.drawn,
                &mut w.kernels,
                sorted,
                &w.surfaces,
                scene,
                &w.partition,
                bounce,
            );
        });
        w.profile.time(Stage::Mueller, || {
            let directions = &sorted.rays.direction;
            sorted.carriers.collect_sensor(&w.kernels, directions, up, &w.partition);
        });
        w.profile.time(Stage::Advance, || {
            advance_paths(sorted, &w.drawn, &w.surfaces, scene.reach);
        });
        w.sensor.swap(0, 1);
    }
}

/// Connects the diffuse vertices to one emitter each.
fn connect<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
) {
    let diffuse = w.partition.rows_of(MaterialKind::Diffuse);
    w.profile.time(Stage::Connect, || {
        connect_to_emitters(
            &mut w.connections,
            &w.sensor[1],
            &w.surfaces,
            scene,
            diffuse,
            path_length,
            Strategy::Unidirectional,
        );
    });
    w.profile.rays_visibility += w.connections.len as u64;
    w.profile.time(Stage::Visibility, || trace_connections(&mut w.connections, scene));
    w.profile.time(Stage::Gather, || {
        gather_connections(&mut w.measured, &w.connections, &w.sensor[1]);
    });
}
