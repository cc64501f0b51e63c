//! Path tracing from the sensor with next-event estimation: the plain reference.

use crate::scattering::Scene;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel, Strategy};

use super::Schedule;
use super::connect::connect_emitters;
use super::sides::SensorWalk;
use super::walk::walk;
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Unidirectional;

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
        SensorWalk::start(workspace, scene, chunk, 0.0);
        walk::<SensorWalk, N, M>(workspace, scene, chunk, STRATEGY, |workspace, path_length| {
            connect_emitters(workspace, scene, path_length, STRATEGY);
        });
    }
}
