//! Keeps what light paths bring to surfaces that are there by a share as photons.

use crate::math::{F32s, Vector, lanes};
use crate::scattering::Scene;
use crate::scattering::surface::Crossed;
use crate::transport::photon::{Arriving, leave};
use crate::transport::sides::LightSide;
use crate::transport::tables::crossings::Crossing;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::photons::PhotonTable;

/// Appends the rows that have come to a part, whether they will pass or not: the sensor's paths
/// ask what light there is, and have been told by chance that the surface is there. Photons of
/// those that meet it alone would be few and bright where it hardly is, and next to a hole the
/// kernel would find its part of it dark.
///
/// From: fly_to_crossings. To: choose_passage, store_photons, the photon maps.
/// Writes: photons. Reads: paths, crossing, flights, scene.
// Rare, and out of the loop of those who walk.
#[inline(never)]
pub fn store_crossed_photons<const N: usize, C: LightSide<N>>(
    photons: &mut PhotonTable<N>,
    paths: &PathTable<N, C>,
    crossing: &Crossing<N>,
    flights: &FlightTable<N>,
    scene: &Scene<N>,
    path_length: u32,
) {
    let &Crossing { crossings, part, .. } = crossing;
    if part.kind != Crossed::Holes {
        return;
    }
    let first = photons.len;
    for index in part.rows.clone() {
        let row = crossings.row[index] as usize;
        let progress = &flights.progress[row];
        let event = scene.events[scene.event_hit(crossings.hits.primitive[index])];
        if progress.is_over || !event.connects() || paths.beta.iter().all(|beta| beta[row] == 0.0) {
            continue;
        }
        let reaches = paths.media.reaching(row, &progress.depth, &progress.drawn);
        let mut power = [F32s::splat(0.0); N];
        for (n, power) in power.iter_mut().enumerate() {
            *power = F32s::splat(paths.beta[n][row] * reaches[n]);
        }
        let position = Vector::splat(lanes::row_of(&crossings.surfaces.position, index));
        let direction = Vector::splat(lanes::row_of(&paths.rays.direction, row));
        let arriving = Arriving { position, direction, power };
        leave(photons, arriving, &paths.carriers, (row, 1));
    }
    photons.note_path_length(first, path_length);
}
