//! Draws how far paths fly through media.

use crate::math::{F32s, LANES};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::sampler::Purpose;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::AnyPaths;

/// Draws the optical depth at which every row would meet a particle, at the wavelength of its path.
///
/// From: follow_paths. To: list_pieces, fly_to_crossings, fly_through_media.
/// Writes: flights. Reads: paths, scene.
pub fn draw_distances<const N: usize>(
    flights: &mut FlightTable<N>,
    paths: &AnyPaths<N>,
    scene: &Scene<N>,
    path_length: u32,
) {
    for first in (0..paths.len).step_by(LANES) {
        let end = paths.len.min(first + LANES);
        let clear = paths.media.inside[first..end].iter().all(|&medium| medium == NONE);
        if clear && !scene.has_straight_on {
            continue;
        }
        let u = paths.identity.draw_first(first, path_length, Purpose::Distance);
        let left = (-(F32s::splat(1.0) - u).ln()).to_array();
        for (progress, left) in flights.progress[first..end].iter_mut().zip(left) {
            progress.left = left;
        }
    }
}
