//! Light paths whose vertices become photons.

use crate::scattering::Scene;
use crate::transport::stages::store_photons::store_photons;
use crate::transport::tables::photon_maps::map_of;
use crate::transport::tables::photons::PhotonTable;
use crate::transport::{Chunk, LightModel, Strategy};

use super::light_walk::{arrive, depart, start};
use super::profile::Stage;
use super::workspace::Workspace;

/// Traces the light paths of a chunk and stores what they bring. Light that comes straight from
/// an emitter is found by connections. `batch` has a table for every map ([`map_of`]).
pub fn photons<const N: usize, M: LightModel<N>>(
    batch: &mut [PhotonTable<N>],
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
) {
    start(w, scene, chunk);
    // One more segment leads to the sensor.
    for path_length in 1..chunk.path_length_max {
        arrive(w, scene, chunk, path_length, Strategy::Merging);
        if path_length > 1 {
            let (partition, paths, surfaces) = (&w.partition, &w.light[1], &w.surfaces);
            w.profile.time(Stage::Store, || {
                for (event, rows) in partition.connectable() {
                    let map = &mut batch[map_of(event.met)];
                    store_photons(map, paths, surfaces, rows, path_length);
                }
            });
        }
        if path_length + 1 == chunk.path_length_max || w.light[1].len == 0 {
            break;
        }
        depart(w, scene, path_length);
    }
}
