//! Path tracing from the sensor with next-event estimation: the plain reference.

use crate::scattering::Scene;
use crate::transport::stages::collect_emission::Strategy;
use crate::transport::{Chunk, LightModel};

use super::sensor_walk::{arrive, connect_emitters, depart, start, trace};
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Unidirectional;

/// Measures one chunk into `workspace.measured`.
pub fn path<const N: usize, M: LightModel<N>>(
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
