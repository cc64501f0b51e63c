//! What paths do between two boundaries of media, whichever stage asks.

use crate::geometry::{HitColumns, IN_MEDIUM};
use crate::scattering::Scene;
use crate::scene::baked::NONE;

use super::tables::flights::FlightTable;
use super::tables::paths::PathTable;

/// Flies on to the distance `t` from the segment's start, and turns the row's hit into one of the
/// medium where it meets a particle before that, which is its end. `wavelength` is the one that
/// distances are drawn for.
#[inline(always)]
pub fn fly<const N: usize, C>(
    hits: &mut HitColumns,
    flights: &mut FlightTable<N>,
    paths: &PathTable<N, C>,
    scene: &Scene<N>,
    (row, t, wavelength): (usize, f32, u32),
) {
    let progress = &mut flights.progress[row];
    let inside = paths.media.inside[row];
    let length = t - progress.travelled;
    if inside == NONE {
        progress.travelled = t;
        return;
    }
    let sigma_t = &scene.medium(inside).sigma_t;
    let sigma = sigma_t[wavelength as usize];
    let distance = progress.left / sigma;
    // Without extinction the distance is infinite, or not a number: nothing is met.
    let meets = distance < length;
    let piece = if meets { distance } else { length.min(f32::MAX) };
    for (depth, sigma) in progress.depth.iter_mut().zip(sigma_t) {
        *depth += sigma * piece;
    }
    progress.left -= sigma * piece;
    if meets {
        progress.is_over = true;
        hits.t[row] = progress.travelled + distance;
        hits.primitive[row] = IN_MEDIUM + inside;
    }
    progress.from = progress.travelled;
    progress.travelled = t;
}
