//! The steps of a light path's walk, shared by the integrators that take it.

use crate::geometry::{resolve_surfaces, trace_closest};
use crate::scattering::Scene;
use crate::transport::bounce::{Bounce, Side};
use crate::transport::stages::advance_paths::advance_paths;
use crate::transport::stages::connect_emission::connect_emission;
use crate::transport::stages::connect_to_sensor::connect_to_sensor;
use crate::transport::stages::depolarize_light::depolarize_light;
use crate::transport::stages::emit_light_paths::emit_light_paths;
use crate::transport::stages::fly_through_media::fly_through_media;
use crate::transport::stages::gather_connections::splat_connections;
use crate::transport::stages::scatter_light::scatter_light;
use crate::transport::stages::store_light_vertices::store_light_vertices;
use crate::transport::stages::trace_connections::trace_connections;
use crate::transport::stages::weigh_arrival::weigh_arrival;
use crate::transport::{Chunk, LightModel, Strategy};

use super::bounce::{scatter, sort};
use super::profile::Stage;
use super::workspace::Workspace;

/// Light paths an iteration: one for every pixel.
pub fn light_paths<const N: usize>(scene: &Scene<N>) -> f32 {
    (scene.sensor.width * scene.sensor.height) as f32
}

/// Emits the paths of a chunk.
pub fn start<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    w.profile.time(Stage::Start, || {
        w.splats.clear();
        emit_light_paths(&mut w.light[0], chunk, scene);
    });
}

/// Traces the paths of a chunk, just emitted, and leaves their vertices ordered by slot in
/// `workspace.vertices[1]`.
pub fn store_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    w.vertices[0].clear();
    // One more segment leads to the sensor.
    for path_length in 1..chunk.path_length_max {
        arrive(w, scene, chunk, path_length, Strategy::Bidirectional);
        let paths = &w.light[1];
        w.profile.time(Stage::Connect, || {
            let vertices = &mut w.vertices[0];
            for of_event in w.partition.connectable() {
                store_light_vertices(vertices, paths, &w.surfaces, scene, of_event, path_length);
            }
        });
        if path_length + 1 == chunk.path_length_max || paths.len == 0 {
            break;
        }
        depart(w, scene, path_length);
    }
    w.profile.time(Stage::Sort, || {
        let [stored, by_slot] = &mut w.vertices;
        by_slot.take_by_slot(stored, &mut w.slot_order, chunk.slots());
    });
}

/// Traces the next segment, groups the rows by what they have hit and brings them there;
/// `workspace.light[1]` holds them.
pub fn arrive<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    path_length: u32,
    strategy: Strategy,
) {
    let [paths, sorted] = &mut w.light;
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
    w.profile.time(Stage::Sort, || {
        let bounce = Bounce { path_length, side: Side::Light };
        sort(sorted, paths, &mut w.hits, &mut w.partition, scene, chunk, bounce);
        let rows = 0..sorted.len;
        resolve_surfaces(&mut w.surfaces, &w.hits[1], &sorted.rays, rows, &scene.shapes);
        if strategy == Strategy::Bidirectional {
            let events = (scene, &w.partition);
            weigh_arrival(sorted, &w.hits[1], &w.surfaces, events, path_length == 1);
        }
    });
    w.profile.time(Stage::Mueller, || {
        depolarize_light(&mut sorted.carriers, &mut sorted.beta, &w.partition);
    });
}

/// Sends the rows on in new directions; `workspace.light[0]` holds them then.
pub fn depart<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
) {
    let paths = &mut w.light[1];
    let bounce = Bounce { path_length, side: Side::Light };
    let (drawn, kernels) = (&mut w.drawn, &mut w.kernels);
    w.profile.time(Stage::Scatter, || {
        scatter::<N, M, _>(drawn, kernels, paths, &w.surfaces, scene, &w.partition, bounce);
    });
    w.profile.time(Stage::Mueller, || {
        scatter_light(&mut paths.carriers, kernels, &paths.rays.direction, &w.partition);
    });
    w.profile.time(Stage::Advance, || advance_paths(paths, drawn, &w.surfaces, scene.reach));
    w.light.swap(0, 1);
}

/// Connects the starts of all paths to the sensor: emitters seen directly.
pub fn splat_emission<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    let (connections, paths) = (&mut w.connections, &w.light[0]);
    w.profile.time(Stage::Connect, || {
        connect_emission(connections, paths, chunk, scene, light_paths(scene));
    });
    splat(w, scene);
}

/// Connects all vertices to the sensor.
pub fn splat_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    strategy: Strategy,
) {
    let (connections, vertices) = (&mut w.connections, &w.vertices[1]);
    w.profile.time(Stage::Connect, || {
        let light_paths = light_paths(scene);
        connect_to_sensor::<N, M>(connections, vertices, chunk, scene, light_paths, strategy);
    });
    splat(w, scene);
}

fn splat<const N: usize, M: LightModel<N>>(w: &mut Workspace<N, M>, scene: &Scene<N>) {
    w.profile.rays_visibility += w.connections.len as u64;
    w.profile.time(Stage::Visibility, || {
        trace_connections(&mut w.connections, (&mut w.flights, &mut w.scratch), scene);
    });
    w.profile.time(Stage::Gather, || splat_connections(&mut w.splats, &w.connections));
}
