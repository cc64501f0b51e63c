//! Bidirectional path tracing with all strategies (paper, equations 8 to 12): emitters met, one
//! connection to an emitter, connections to every vertex of the paired light path, and light
//! vertices connected to the sensor.

use crate::geometry::{resolve_surfaces, trace_closest};
use crate::scattering::Scene;
use crate::scene::baked::MaterialKind;
use crate::transport::stages::advance_paths::advance_paths;
use crate::transport::stages::collect_emission::{Strategy, collect_emission};
use crate::transport::stages::collect_sensor::SensorSide;
use crate::transport::stages::connect_to_emitters::connect_to_emitters;
use crate::transport::stages::connect_to_vertices::connect_to_vertices;
use crate::transport::stages::emit_light_paths::emit_light_paths;
use crate::transport::stages::gather_connections::{gather_connections, trace_connections};
use crate::transport::stages::generate_sensor_paths::generate_sensor_paths;
use crate::transport::stages::scatter_diffuse::Side;
use crate::transport::stages::weigh_arrival::weigh_arrival;
use crate::transport::{Chunk, LightModel};

use super::bounce::{Bounce, scatter, sort};
use super::light::{splat_vertices, trace_light_vertices};
use super::profile::Stage;
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Bidirectional;

/// Measures one chunk into `workspace.measured` and splats into `workspace.splats`.
pub fn bdpt<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    workspace.profile.time(Stage::Start, || {
        workspace.splats.clear();
        emit_light_paths(&mut workspace.light[0], chunk, scene);
    });
    trace_light_vertices(workspace, scene, chunk);
    splat_vertices(workspace, scene, chunk, STRATEGY);

    let light_paths = (scene.sensor.width * scene.sensor.height) as f32;
    workspace.profile.time(Stage::Start, || {
        workspace.measured.clear();
        generate_sensor_paths(&mut workspace.sensor[0], chunk, &scene.sensor, light_paths);
    });
    for path_length in 1..=chunk.path_length_max {
        let w = &mut *workspace;
        let [paths, sorted] = &mut w.sensor;
        w.profile.rays_closest += paths.len as u64;
        w.profile.time(Stage::Trace, || {
            trace_closest(&mut w.hits[0], &paths.rays, 0..paths.len, &scene.accelerator);
        });
        w.profile.time(Stage::Emission, || {
            collect_emission(&mut w.measured, paths, &w.hits[0], scene, path_length, STRATEGY);
        });
        if path_length == chunk.path_length_max || paths.len == 0 {
            break;
        }
        let bounce = Bounce { path_length, side: Side::Sensor };
        w.profile.time(Stage::Sort, || {
            sort(sorted, paths, &mut w.hits, &mut w.partition, scene, chunk, bounce);
            let rows = 0..sorted.len;
            resolve_surfaces(&mut w.surfaces, &w.hits[1], &sorted.rays, rows, &scene.tables);
            let from_infinity = path_length == 1 && !scene.sensor.is_finite();
            weigh_arrival(sorted, &w.hits[1], &w.surfaces, from_infinity);
        });
        w.profile.time(Stage::Mueller, || {
            sorted.carriers.depolarize_sensor(&mut sorted.beta, &w.partition);
        });
        connect(w, scene, chunk, path_length);

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
            let up = scene.sensor.up();
            sorted.carriers.collect_sensor(&w.kernels, directions, up, &w.partition);
        });
        w.profile.time(Stage::Advance, || {
            advance_paths(sorted, &w.drawn, &w.surfaces, scene.reach);
        });
        w.sensor.swap(0, 1);
    }
}

/// Connects the diffuse vertices to an emitter and to the vertices of their light paths.
fn connect<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    path_length: u32,
) {
    let diffuse = w.partition.rows_of(MaterialKind::Diffuse);
    w.profile.time(Stage::Connect, || {
        connect_to_emitters(
            &mut w.connections,
            &w.sensor[1],
            &w.surfaces,
            scene,
            diffuse.clone(),
            path_length,
            STRATEGY,
        );
    });
    measure_connections(w, scene);
    let vertex_length_max = chunk.path_length_max - path_length - 1;
    w.profile.time(Stage::Connect, || {
        connect_to_vertices(
            &mut w.connections,
            &w.sensor[1],
            &w.surfaces,
            (&w.vertices[1], &w.slot_order),
            scene,
            (diffuse, vertex_length_max),
        );
    });
    measure_connections(w, scene);
}

fn measure_connections<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
) {
    w.profile.rays_visibility += w.connections.len as u64;
    w.profile.time(Stage::Visibility, || trace_connections(&mut w.connections, scene));
    w.profile.time(Stage::Gather, || {
        gather_connections(&mut w.measured, &w.connections, &w.sensor[1]);
    });
}
