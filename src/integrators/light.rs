//! Particle tracing from the emitters, every vertex connected to the sensor.

use crate::geometry::{resolve_surfaces, trace_closest};
use crate::scattering::Scene;
use crate::scene::baked::MaterialKind;
use crate::transport::stages::advance_paths::advance_paths;
use crate::transport::stages::collect_emission::Strategy;
use crate::transport::stages::connect_emission::connect_emission;
use crate::transport::stages::connect_to_sensor::connect_to_sensor;
use crate::transport::stages::emit_light_paths::emit_light_paths;
use crate::transport::stages::gather_connections::{splat_connections, trace_connections};
use crate::transport::stages::scatter_diffuse::Side;
use crate::transport::stages::scatter_light::LightSide;
use crate::transport::stages::store_light_vertices::store_light_vertices;
use crate::transport::stages::weigh_arrival::weigh_arrival;
use crate::transport::{Chunk, LightModel};

use super::bounce::{Bounce, scatter, sort};
use super::profile::Stage;
use super::workspace::Workspace;

/// Splats one chunk of light paths into `workspace.splats`.
pub fn light<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    workspace.profile.time(Stage::Start, || {
        workspace.splats.clear();
        emit_light_paths(&mut workspace.light[0], chunk, scene);
    });
    let light_paths = (scene.sensor.width * scene.sensor.height) as f32;
    let w = &mut *workspace;
    w.profile.time(Stage::Connect, || {
        connect_emission(&mut w.connections, &w.light[0], chunk, scene, light_paths);
    });
    splat(w, scene);
    trace_light_vertices(workspace, scene, chunk);
    splat_vertices(workspace, scene, chunk, Strategy::Unidirectional);
}

/// Traces the light paths of a chunk, just emitted, and leaves their vertices ordered by slot in
/// `workspace.vertices[1]`.
pub(super) fn trace_light_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    w.vertices[0].len = 0;
    // One more segment leads to the sensor.
    for path_length in 1..chunk.path_length_max {
        let [paths, sorted] = &mut w.light;
        w.profile.rays_closest += paths.len as u64;
        w.profile.time(Stage::Trace, || {
            trace_closest(&mut w.hits[0], &paths.rays, 0..paths.len, &scene.accelerator);
        });
        let bounce = Bounce { path_length, side: Side::Light };
        w.profile.time(Stage::Sort, || {
            sort(sorted, paths, &mut w.hits, &mut w.partition, scene, chunk, bounce);
            let rows = 0..sorted.len;
            resolve_surfaces(&mut w.surfaces, &w.hits[1], &sorted.rays, rows, &scene.tables);
            weigh_arrival(sorted, &w.hits[1], &w.surfaces, path_length == 1);
        });
        w.profile.time(Stage::Mueller, || {
            sorted.carriers.depolarize_light(&mut sorted.beta, &w.partition);
        });
        let diffuse = w.partition.rows_of(MaterialKind::Diffuse);
        w.profile.time(Stage::Connect, || {
            let vertices = &mut w.vertices[0];
            store_light_vertices(vertices, sorted, &w.surfaces, scene, diffuse, path_length);
        });
        if path_length + 1 == chunk.path_length_max || sorted.len == 0 {
            break;
        }
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
            sorted.carriers.scatter_light(&w.kernels, &sorted.rays.direction, &w.partition);
        });
        w.profile.time(Stage::Advance, || {
            advance_paths(sorted, &w.drawn, &w.surfaces, scene.reach);
        });
        w.light.swap(0, 1);
    }
    w.profile.time(Stage::Sort, || {
        let [stored, by_slot] = &mut w.vertices;
        by_slot.gather_by_slot(stored, &mut w.slot_order, chunk.slots());
    });
}

/// Connects all vertices to the sensor.
pub(super) fn splat_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    strategy: Strategy,
) {
    let light_paths = (scene.sensor.width * scene.sensor.height) as f32;
    w.profile.time(Stage::Connect, || {
        connect_to_sensor(&mut w.connections, &w.vertices[1], chunk, scene, light_paths, strategy);
    });
    splat(w, scene);
}

fn splat<const N: usize, M: LightModel<N>>(w: &mut Workspace<N, M>, scene: &Scene<N>) {
    w.profile.rays_visibility += w.connections.len as u64;
    w.profile.time(Stage::Visibility, || trace_connections(&mut w.connections, scene));
    w.profile.time(Stage::Gather, || splat_connections(&mut w.splats, &w.connections));
}
