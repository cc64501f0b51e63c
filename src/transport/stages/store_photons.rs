//! Keeps what light paths bring to surfaces and media as photons.

use crate::math::{F32s, LANES, Vector, lanes};
use crate::scattering::surface::Crossed;
use crate::scattering::{Met, Scene};
use crate::transport::Arrived;
use crate::transport::photon::{Arriving, leave};
use crate::transport::sides::LightSide;
use crate::transport::tables::photons::PhotonTable;

/// Appends rows that have arrived. At depolarizers the power is all there is; elsewhere the state
/// of polarization is kept relative to it. Light that meets a surface which is there by a share
/// has left its photon before that was decided.
///
/// From: depolarize_light, store_crossed_photons. To: the photon maps.
/// Writes: photons. Reads: arrived (paths, surfaces), scene.
pub fn store_photons<const N: usize, C: LightSide<N>>(
    photons: &mut PhotonTable<N>,
    arrived: &Arrived<N, C>,
    scene: &Scene<N>,
) {
    let &Arrived { paths, surfaces, ref rows, path_length, event } = arrived;
    let may_be_crossed = matches!(event.met, Met::Surface(_)) && scene.has_holes();
    let first = photons.len;
    let mut store = |row: usize, live: usize| {
        let mut power = [F32s::splat(0.0); N];
        for (power, beta) in power.iter_mut().zip(&paths.beta) {
            *power = lanes::load(beta, row);
        }
        let position = Vector::load(&surfaces.position, row);
        let direction = Vector::load(&paths.rays.direction, row);
        let arriving = Arriving { position, direction, power };
        leave(photons, arriving, &paths.carriers, (row, live));
    };
    if !may_be_crossed {
        rows.clone().step_by(LANES).for_each(|row| store(row, LANES.min(rows.end - row)));
    } else {
        let is_whole = |row: &usize| {
            let material = scene.material_at(surfaces.primitive[*row]);
            material.crossed() != Some(Crossed::Holes)
        };
        for row in rows.clone().step_by(LANES) {
            let eight = row..rows.end.min(row + LANES);
            match eight.clone().all(|row| is_whole(&row)) {
                true => store(row, eight.len()),
                false => eight.filter(is_whole).for_each(|row| store(row, 1)),
            }
        }
    }
    photons.note_path_length(first, path_length);
}
