//! Connections, which several integrators make at the vertices of their walks.

use std::ops::Range;

use crate::scattering::{Event, Met, Scene};
use crate::transport::emission::Finding;
use crate::transport::stages::choose_lamps::choose_lamps;
use crate::transport::stages::connect_emission::connect_emission;
use crate::transport::stages::connect_flights::connect_flights;
use crate::transport::stages::connect_to_emitters::connect_to_emitters;
use crate::transport::stages::connect_to_sensor::connect_to_sensor;
use crate::transport::stages::cross_connections::cross_connections;
use crate::transport::stages::follow_connections::follow_connections;
use crate::transport::stages::gather_connections::{gather_connections, splat_connections};
use crate::transport::stages::list_pieces::list_pieces;
use crate::transport::stages::note_brought::note_brought;
use crate::transport::stages::store_light_vertices::store_light_vertices;
use crate::transport::stages::trace_connections::trace_connections;
use crate::transport::tables::crossings::Crossing;
use crate::transport::{Arrived, Chunk, LightModel, Strategy};

use super::profile::Stage;
use super::sides::LightWalk;
use super::walk::{pass_surfaces_of, walk};
use super::workspace::{WalkTables, Workspace};

/// Light paths an iteration: one for every pixel.
pub fn light_paths<const N: usize>(scene: &Scene<N>) -> f32 {
    let [width, height] = scene.sensor.layout.sampled().film;
    width as f32 * height as f32
}

/// Does `work` for every kind of event that can be connected to, and its rows.
pub fn for_each_connectable<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    mut work: impl FnMut(&mut Workspace<N, M>, (Event, Range<usize>)),
) {
    let all = std::mem::take(&mut w.walk.partition);
    // The partition is put aside, since what is done with its rows writes to its neighbors.
    for of_event in all.connectable() {
        work(w, of_event);
    }
    w.walk.partition = all;
}

/// Connects the vertices of sensor paths that can be to one emitter each.
pub fn connect_emitters<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
    strategy: Strategy,
) {
    for_each_connectable(w, |w, (event, rows)| {
        let (paths, surfaces) = (&w.sensor[1], &w.walk.surfaces);
        let arrived = Arrived { paths, surfaces, event, rows, path_length };
        let (connections, at) = (&mut w.connections, w.walk.models.of(scene));
        w.profile.time(Stage::Connect, || {
            connect_to_emitters(connections, &arrived, at, strategy);
        });
        measure_connections(w, scene, (event.met, strategy));
    });
}

/// Connects places on the way of sensor paths through media to one lamp each: up to a crossing, or
/// to the ends of their segments.
pub fn connect_lamps<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    crossing: Option<&Crossing<N>>,
    scene: &Scene<N>,
    Finding { path_length, is_last, strategy }: Finding,
) {
    let Some(lamps) = scene.lamps.as_ref().filter(|_| !is_last && strategy.connects_flights())
    else {
        return;
    };
    for medium in lamps.media_lit() {
        let WalkTables { hits: [hits, _], flights, .. } = &w.walk;
        let (paths, pieces, connections) = (&w.sensor[0], &mut w.pieces, &mut w.connections);
        w.profile.time(Stage::Connect, || {
            let ends = (hits, crossing);
            pieces.medium = medium;
            list_pieces(pieces, paths, flights, ends, &w.merged);
            choose_lamps(pieces, paths, scene, path_length);
            connect_flights(connections, pieces, (paths, flights), scene);
        });
        if w.connections.len == 0 {
            continue;
        }
        // The segments are still on their way.
        w.walk.swap_flights();
        test_connections(w, scene, strategy);
        w.walk.swap_flights();
        w.profile.time(Stage::Gather, || {
            let (connections, at) = (&w.connections, (&w.sensor[0], &w.walk.surfaces));
            gather_connections::<N, M>(
                &mut w.measured,
                connections,
                at,
                scene.into(),
                Met::Medium(medium),
            );
        });
    }
}

/// Tests the connections at hand, from vertices that have `met` the same, and adds up those that
/// are open.
pub fn measure_connections<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    (met, strategy): (Met, Strategy),
) {
    trace(w, scene);
    if strategy == Strategy::Bidirectional {
        w.profile.time(Stage::Gather, || {
            note_brought(&mut w.measured, &w.connections, &w.sensor[1]);
        });
    }
    cross(w, scene, strategy);
    w.profile.time(Stage::Gather, || {
        let at = (&w.sensor[1], &w.walk.surfaces);
        let scene = w.walk.models.of(scene);
        gather_connections::<N, M>(&mut w.measured, &w.connections, at, scene, met);
    });
}

/// Traces the light paths of a chunk, just started, and leaves their vertices ordered by slot in
/// `workspace.vertices[1]`.
pub fn store_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    w.vertices[0].clear();
    walk::<LightWalk, N, M>(w, scene, chunk, Strategy::Bidirectional, |w, path_length| {
        let WalkTables { surfaces, models, partition, .. } = &w.walk;
        let at = models.of(scene);
        let (vertices, paths) = (&mut w.vertices[0], &w.light[1]);
        w.profile.time(Stage::Connect, || {
            for (event, rows) in partition.connectable() {
                let arrived = Arrived { paths, surfaces, event, rows, path_length };
                store_light_vertices(vertices, &arrived, at);
            }
        });
    });
    w.walk.models.keep();
    w.profile.time(Stage::Sort, || {
        let [stored, by_slot] = &mut w.vertices;
        by_slot.take_by_slot(stored, &mut w.slot_order, chunk.slots());
    });
}

/// Connects the starts of light paths to the sensor: emitters seen directly, all, or those that
/// sensor paths hardly meet.
pub fn splat_emission<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    strategy: Strategy,
) {
    let (connections, paths) = (&mut w.connections, &w.light[0]);
    w.profile.time(Stage::Connect, || {
        connect_emission(connections, paths, chunk, scene, light_paths(scene), strategy);
    });
    splat(w, scene, strategy);
}

/// Connects all light vertices to the sensor.
pub fn splat_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    strategy: Strategy,
) {
    let (connections, vertices) = (&mut w.connections, &w.vertices[1]);
    w.profile.time(Stage::Connect, || {
        let light_paths = light_paths(scene);
        let scene = w.walk.models.of(scene);
        connect_to_sensor::<N, M>(connections, vertices, chunk, scene, light_paths, strategy);
    });
    splat(w, scene, strategy);
}

fn splat<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    strategy: Strategy,
) {
    test_connections(w, scene, strategy);
    w.profile.time(Stage::Gather, || {
        splat_connections(&mut w.splats, &w.connections, &scene.sensor);
    });
}

fn test_connections<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    strategy: Strategy,
) {
    trace(w, scene);
    cross(w, scene, strategy);
}

fn trace<const N: usize, M: LightModel<N>>(w: &mut Workspace<N, M>, scene: &Scene<N>) {
    w.profile.rays_visibility += w.connections.len as u64;
    let (connections, scratch) = (&mut w.connections, &mut w.walk.scratch);
    w.profile.time(Stage::Visibility, || trace_connections(connections, scratch, scene));
}

/// Lets connections cross what lets them pass straight on.
fn cross<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    strategy: Strategy,
) {
    if !scene.has_straight_on {
        return;
    }
    let WalkTables { flights, crossings, scratch, .. } = &mut w.walk;
    let connections = &mut w.connections;
    w.profile.time(Stage::Visibility, || {
        follow_connections(crossings, (flights, scratch), connections, scene);
        pass_surfaces_of::<N, M>(crossings, scene);
        if M::POLARIZED {
            cross_connections::<N, true>(connections, flights, crossings, scene, strategy);
        } else {
            cross_connections::<N, false>(connections, flights, crossings, scene, strategy);
        }
    });
}
