//! Path tracing from the sensor with next-event estimation: the plain reference.

use crate::scattering::Scene;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel, Strategy};

use super::Schedule;
use super::sensor_walk::{arrive, connect_emitters, depart, start, trace};
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Unidirectional;

/// Measures one chunk into `workspace.measured`.
fn path<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    start(workspace, scene, chunk, 0.0);
    for path_length in 1..=chunk.path_length_max {
        trace(workspace, scene, path_length, STRATEGY);
        if path_length == chunk.path_length_max || workspace.sensor[0].len == 0 {
            break;
        }
        arrive(workspace, scene, chunk, path_length, STRATEGY);
        connect_emitters(workspace, scene, path_length, STRATEGY);
        depart(workspace, scene, path_length);
    }
}

/// The integrator.
pub struct Path;

impl Schedule for Path {
    const NAME: &str = "path";
    const SUMMARY: &str = "From the sensor, with next-event estimation: plain path tracing";
    const MEASURES: bool = true;
    const SPLATS: bool = false;
    const PHOTONS: bool = false;

    fn chunk<const N: usize, M: LightModel<N>>(
        workspace: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        _photons: Option<&PhotonMaps<N>>,
    ) {
        path(workspace, scene, chunk);
    }
}
