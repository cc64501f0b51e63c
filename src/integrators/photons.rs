//! Light paths whose vertices become photons.

use crate::math::columns::Columns;
use crate::scattering::{Met, Scene};
use crate::transport::stages::store_photons::store_photons;
use crate::transport::tables::photon_maps::{PhotonMaps, SURFACES, map_of};
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
    // Paths leave photons between vertices, too.
    let merges = maps.0[SURFACES].merges;
    w.photons = merges.then(|| std::mem::replace(&mut batch[SURFACES], PhotonTable::absent()));
    walk::<LightWalk, N, M>(w, scene, chunk, Strategy::Merging, |w, path_length| {
        if path_length == 1 {
            return;
        }
        let Workspace { light: [_, paths], photons, profile, walk, .. } = w;
        let WalkTables { surfaces, partition, .. } = walk;
        profile.time(Stage::Store, || {
            let merging = partition.connectable().filter(|(event, _)| maps.merge_at(event.met));
            for (event, rows) in merging {
                let to = match (event.met, &mut *photons) {
                    (Met::Surface(_), Some(photons)) => photons,
                    (met, _) => &mut batch[map_of(met)],
                };
                let arrived = Arrived { paths, surfaces, event, rows, path_length };
                store_photons(to, &arrived, scene);
            }
        });
    });
    if let Some(photons) = w.photons.take() {
        batch[SURFACES] = photons;
    }
}
