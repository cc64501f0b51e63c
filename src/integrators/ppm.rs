//! Progressive photon mapping (paper, section 4.1; Knaus and Zwicker 2011, "Progressive photon
//! mapping: a probabilistic approach").
//!
//! A path has one vertex, the first from the sensor that is not specular, at which its light is
//! found: straight from an emitter, by a connection, or else by merging with the photons about
//! it, which light paths of two segments and more have left. So each path is found in one way,
//! and nothing needs to be weighed.

use crate::scattering::Scene;
use crate::transport::stages::merge_photons::merge_photons;
use crate::transport::tables::photon_maps::PhotonMaps;
use crate::transport::{Arrived, Chunk, LightModel, Strategy};

use super::Schedule;
use super::connect::{connect_emitters, for_each_connectable};
use super::profile::Stage;
use super::sides::SensorWalk;
use super::walk::walk;
use super::workspace::Workspace;

const STRATEGY: Strategy = Strategy::Merging;

/// Traces the paths of a chunk through specular events up to their first other vertices, for
/// which it calls `visit` with the segments so far.
pub fn walk_to_merging<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    mut visit: impl FnMut(&mut Workspace<N, M>, u32),
) {
    SensorWalk::start(workspace, scene, chunk, 0.0);
    walk::<SensorWalk, N, M>(workspace, scene, chunk, STRATEGY, |workspace, path_length| {
        visit(workspace, path_length);
        workspace.walk.partition.end_at_connections();
    });
}

/// Merges the vertices that can be, after `path_length` segments, with the photons about them that
/// keep the whole within `path_length_max`.
fn merge<const N: usize, M: LightModel<N>>(
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    maps: &PhotonMaps<N>,
    path_length: u32,
    path_length_max: u32,
) {
    for_each_connectable(w, |w, (event, rows)| {
        let map = (maps.of(event.met), path_length_max - path_length);
        let (paths, surfaces) = (&w.sensor[1], &w.walk.surfaces);
        let arrived = Arrived { paths, surfaces, event, rows, path_length };
        let (measured, order) = (&mut w.measured, &mut w.queries);
        w.profile.time(Stage::Merge, || {
            merge_photons::<N, M>(measured, order, &arrived, map, scene);
        });
    });
}

/// The integrator.
pub struct Ppm;

impl Schedule for Ppm {
    const NAME: &str = "ppm";
    const SUMMARY: &str =
        "Progressive photon mapping: sees caustics in mirrors and through glass, blurred at first";
    const MEASURES: bool = true;
    const SPLATS: bool = false;
    const PHOTONS: bool = true;

    fn chunk<const N: usize, M: LightModel<N>>(
        workspace: &mut Workspace<N, M>,
        scene: &Scene<N>,
        chunk: &Chunk,
        photons: Option<&PhotonMaps<N>>,
    ) {
        let photons = photons.expect("photons are shot before they are gathered");
        walk_to_merging(workspace, scene, chunk, |workspace, path_length| {
            connect_emitters(workspace, scene, path_length, STRATEGY);
            merge(workspace, scene, photons, path_length, chunk.path_length_max);
        });
    }
}
