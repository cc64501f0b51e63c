//! Bidirectional path tracing with all strategies (paper, equations 8 to 12): emitters met, one
//! connection to an emitter, connections to every vertex of the paired light path, and light
//! vertices connected to the sensor; also points of emitters whose own images are small.

use crate::scattering::Scene;
use crate::transport::stages::connect_to_vertices::connect_to_vertices;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::tables::vertices::LightPaths;
use crate::transport::{Arrived, Chunk, LightModel, Strategy};

use super::Schedule;
use super::connect::{
    connect_emitters, for_each_connectable, light_paths, measure_connections, splat_emission,
    splat_vertices, store_vertices,
};
use super::profile::Stage;
use super::sides::{LightWalk, SensorWalk};
use super::walk::walk;
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Bidirectional;

/// Connects the vertices that can be, after `path_length` segments, to those of their light paths
/// that keep the whole within `path_length_max`.
fn connect_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    path_length: u32,
    path_length_max: u32,
) {
    for_each_connectable(w, |w, (event, rows)| {
        let (paths, surfaces) = (&w.sensor[1], &w.walk.surfaces);
        let arrived = Arrived { paths, surfaces, event, rows, path_length };
        let light = LightPaths {
            vertices: &w.vertices[1],
            order: &w.slot_order,
            length_max: path_length_max - path_length - 1,
        };
        let (connections, measured) = (&mut w.connections, &w.measured);
        let at = w.walk.models.of(scene);
        w.profile.time(Stage::Connect, || {
            connect_to_vertices::<N, M>(connections, &arrived, &light, (at, measured));
        });
        measure_connections(w, scene, (event.met, STRATEGY));
    });
}

/// The integrator.
pub struct Bdpt;

impl Schedule for Bdpt {
    const NAME: &str = "bdpt";
    const SUMMARY: &str = "From both, with all connections, each weighted by what it is good at";
    const MEASURES: bool = true;
    const SPLATS: bool = true;
    const PHOTONS: bool = false;
    /// Vertices cost more than by [`super::path::Path`], and light paths bring light to the first.
    const ROULETTE_AFTER: u32 = 3;

    fn chunk<const N: usize, M: LightModel<N>>(
        workspace: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        _photons: Option<&PhotonMaps<N>>,
    ) {
        LightWalk::start(workspace, scene, chunk);
        if scene.glimpses.has_any() {
            splat_emission(workspace, scene, chunk, STRATEGY);
        }
        store_vertices(workspace, scene, chunk);
        splat_vertices(workspace, scene, chunk, STRATEGY);
        if !chunk.is_seen {
            return;
        }

        SensorWalk::start(workspace, scene, chunk, light_paths(scene));
        walk::<SensorWalk, N, M>(workspace, scene, chunk, STRATEGY, |workspace, path_length| {
            connect_emitters(workspace, scene, path_length, STRATEGY);
            connect_vertices(workspace, scene, path_length, chunk.path_length_max);
        });
    }
}
