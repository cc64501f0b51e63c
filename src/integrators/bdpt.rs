//! Bidirectional path tracing with all strategies (paper, equations 8 to 12): emitters met, one
//! connection to an emitter, connections to every vertex of the paired light path, and light
//! vertices connected to the sensor.

use crate::scattering::Scene;
use crate::transport::stages::connect_to_vertices::connect_to_vertices;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel, Strategy};

use super::Schedule;
use super::connect::{
    connect_emitters, for_each_connectable, light_paths, measure_connections, splat_vertices,
    store_vertices,
};
use super::profile::Stage;
use super::sides::{LightWalk, SensorWalk};
use super::walk::walk;
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Bidirectional;

/// Connects the vertices that can be to those of their light paths that are at most
/// `vertex_length_max` segments from the emitter.
fn connect_vertices<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    vertex_length_max: u32,
) {
    for_each_connectable(w, |w, of_event| {
        let met = of_event.0.met;
        let (connections, paths) = (&mut w.connections, &w.sensor[1]);
        let vertices = (&w.vertices[1], &w.slot_order);
        let length_max = vertex_length_max;
        w.profile.time(Stage::Connect, || {
            let surfaces = &w.walk.surfaces;
            connect_to_vertices::<N, M>(
                connections,
                paths,
                surfaces,
                vertices,
                scene,
                of_event,
                length_max,
            );
        });
        measure_connections(w, scene, met);
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

    fn chunk<const N: usize, M: LightModel<N>>(
        workspace: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        _photons: Option<&PhotonMaps<N>>,
    ) {
        LightWalk::start(workspace, scene, chunk);
        store_vertices(workspace, scene, chunk);
        splat_vertices(workspace, scene, chunk, STRATEGY);

        SensorWalk::start(workspace, scene, chunk, light_paths(scene));
        walk::<SensorWalk, N, M>(workspace, scene, chunk, STRATEGY, |workspace, path_length| {
            connect_emitters(workspace, scene, path_length, STRATEGY);
            connect_vertices(workspace, scene, chunk.path_length_max - path_length - 1);
        });
    }
}
