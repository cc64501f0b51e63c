//! Progressive photon mapping (paper, section 4.1; Knaus and Zwicker 2011, "Progressive photon
//! mapping: a probabilistic approach").
//!
//! A path from the sensor ends at the first vertex whose map merges: mostly the first that is not
//! specular. There it merges with the photons about it, which light paths of two segments and more
//! have left. What comes straight from an emitter, there and at vertices before, is found as in
//! path tracing: by a connection and by the next segment, each weighed by what it is good at. So
//! the paths that photons bring are found in one way.
//!
//! In media whose phase functions have a forward peak, the few photons in it would make nearly all
//! of the noise. They do not count, and paths that are scattered so little go on to merge farther
//! off: what the two find is apart by the angle. So it is about the mirrored direction on surfaces
//! of narrow facets, unless photons alone find some light.

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

/// Traces the paths of a chunk up to their first vertices that merge, and to the emitters behind
/// these, and calls `visit` at every vertex with the segments so far.
pub fn walk_to_merging<const N: usize, M: LightModel<N>>(
    workspace: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    maps: &PhotonMaps<N>,
    mut visit: impl FnMut(&mut Workspace<N, M>, u32),
) {
    SensorWalk::start(workspace, scene, chunk, 0.0);
    workspace.merged.clear();
    let merges_everywhere = maps.0.iter().all(|map| map.merges);
    let ends_at_once = merges_everywhere && !scene.has_met_emitters() && !scene.has_peaks();
    walk::<SensorWalk, N, M>(workspace, scene, chunk, STRATEGY, |w, path_length| {
        visit(w, path_length);
        if ends_at_once {
            w.walk.partition.end_at_connections();
            return;
        }
        let arrived = (&w.sensor[1].rays.direction, &w.walk.surfaces);
        for (event, rows) in w.walk.partition.connectable() {
            if maps.merge_at(event.met) {
                w.merged.push(rows, arrived, (scene, event.met));
            }
        }
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
        if !maps.merge_at(event.met) {
            return;
        }
        let map = (maps.of(event.met), path_length_max - path_length);
        let (paths, surfaces) = (&w.sensor[1], &w.walk.surfaces);
        let arrived = Arrived { paths, surfaces, event, rows, path_length };
        let (measured, queries) = (&mut w.measured, &mut w.queries);
        let at = w.walk.models.of(scene);
        w.profile.time(Stage::Merge, || {
            merge_photons::<N, M>(measured, queries, &arrived, map, at);
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
        walk_to_merging(workspace, scene, chunk, photons, |workspace, path_length| {
            connect_emitters(workspace, scene, path_length, STRATEGY);
            merge(workspace, scene, photons, path_length, chunk.path_length_max);
        });
    }
}
