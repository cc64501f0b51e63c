//! Keeps what light paths bring to surfaces and media as photons.

use std::ops::Range;

use crate::geometry::SurfaceColumns;
use crate::math::{F32s, LANES, Vector, lanes};
use crate::transport::tables::paths::PathTable;
use crate::transport::tables::photons::{PhotonClass, PhotonTable, round_directions};

use super::scatter_light::LightSide;

/// Appends the rows `rows`, after `path_length` segments. At depolarizers the power is all there
/// is; in polarizing media the state of polarization is kept relative to it.
///
/// From: depolarize_light. To: merge_photons, by way of the grid.
/// Writes: photons. Reads: paths, surfaces.
pub fn store_photons<const N: usize, C: LightSide<N>>(
    photons: &mut PhotonTable<N>,
    paths: &PathTable<N, C>,
    surfaces: &SurfaceColumns,
    rows: Range<usize>,
    path_length: u32,
) {
    let first = photons.len;
    for row in rows.clone().step_by(LANES) {
        let live = LANES.min(rows.end - row);
        let direction = Vector::load(&paths.rays.direction, row);
        let position = Vector::load(&surfaces.position, row);
        let mut power = [F32s::splat(0.0); N];
        for (power, beta) in power.iter_mut().zip(&paths.beta) {
            *power = lanes::load(beta, row);
        }
        let start = photons.len;
        if photons.class == PhotonClass::Power {
            photons.append(position, direction, &power, live);
            continue;
        }
        let rounded = round_directions(direction);
        let states = paths.carriers.states_about(row, live, rounded);
        for (power, state) in power.iter_mut().zip(&states) {
            *power *= state[0];
        }
        photons.append(position, direction, &power, live);
        for (channel, state) in states.iter().enumerate().take(photons.class.channels(N)) {
            let polarization = [state[1], state[2], state[3]];
            photons.store_stokes(start, photons.len, channel, polarization);
        }
    }
    photons.note_path_length(first, path_length);
}
