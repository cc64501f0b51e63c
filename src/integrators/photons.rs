//! Light paths whose vertices become photons.

use crate::scattering::Scene;
use crate::transport::stages::store_photons::store_photons;
use crate::transport::tables::photon_maps::{PhotonMaps, map_of};
use crate::transport::tables::photons::PhotonTable;
use crate::transport::{Arrived, Chunk, LightModel, Strategy};

use super::profile::Stage;
use super::sides::LightWalk;
use super::walk::walk;
use super::workspace::{WalkTables, Workspace};

/// Traces the light paths of a chunk and stores what they bring. Light that comes straight from
/// an emitter is found by connections. `batch` has a table for every one of the `maps`
/// ([`map_of`]).
pub fn photons<const N: usize, M: LightModel<N>>(
    batch: &mut [PhotonTable<N>],
    w: &mut Workspace<N, M>,
    scene: &Scene<N>,
    chunk: &Chunk,
    maps: &PhotonMaps<N>,
) {
    LightWalk::start(w, scene, chunk);
    walk::<LightWalk, N, M>(w, scene, chunk, Strategy::Merging, |w, path_length| {
        if path_length == 1 {
            return;
        }
        let (WalkTables { surfaces, partition, hits: [_, hits], .. }, paths) =
            (&w.walk, &w.light[1]);
        w.profile.time(Stage::Store, || {
            let merging = partition.connectable().filter(|(event, _)| maps.merge_at(event.met));
            for (event, rows) in merging {
                let arrived = Arrived { paths, surfaces, event, rows, path_length };
                store_photons(&mut batch[map_of(event.met)], &arrived, (hits, scene));
            }
        });
    });
}
