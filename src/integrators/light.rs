//! Particle tracing from the emitters, every vertex connected to the sensor.

use crate::scattering::Scene;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Chunk, LightModel, Strategy};

use super::Schedule;
use super::connect::{splat_emission, splat_vertices, store_vertices};
use super::sides::LightWalk;
use super::workspace::Workspace;

/// The integrator.
pub struct Light;

impl Schedule for Light {
    const NAME: &str = "light";
    const SUMMARY: &str =
        "From the emitters, connected to the sensor; sees nothing behind solid glass or in mirrors";
    const MEASURES: bool = false;
    const SPLATS: bool = true;
    const PHOTONS: bool = false;

    fn chunk<const N: usize, M: LightModel<N>>(
        workspace: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        _photons: Option<&PhotonMaps<N>>,
    ) {
        LightWalk::start(workspace, scene, chunk);
        splat_emission(workspace, scene, chunk, Strategy::Unidirectional);
        store_vertices(workspace, scene, chunk);
        splat_vertices(workspace, scene, chunk, Strategy::Unidirectional);
    }
}
