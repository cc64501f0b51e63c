//! What paths do between two boundaries of media, whichever stage asks.
//!
//! Absorption attenuates paths, it does not end them: of flights that are drawn by the extinction
//! coefficient, few come through colored glass, and each with the weight of all. A piece of length
//! L is passed with the probability exp(-sigma_d L), sigma_d^2 = sigma_s sigma_t: always, where a
//! medium only absorbs, and by extinction where it only scatters. Between these, that favors
//! neither what is behind the piece nor what is scattered on it. What passes weighs
//! exp(-(sigma_t - sigma_d) L); the other flights end by sigma_t exp(-sigma_t d) at d < L, so that
//! all of them weigh
//!
//! (sigma_s / sigma_t) (1 - exp(-sigma_t L)) / (1 - exp(-sigma_d L)),
//!
//! from sigma_d / sigma_t on short pieces down to its square on long ones: no weight exceeds 1.
//! That is the probability with which roulette lets paths go on.

use crate::geometry::{HitColumns, IN_MEDIUM};
use crate::math::elementary::{exp_m1, ln, ln_1p};
use crate::scattering::Scene;
use crate::scattering::medium::Medium;
use crate::scattering::surface::SURVIVAL_MIN;
use crate::scene::baked::NONE;

use super::tables::flights::{FlightTable, Progress};
use super::tables::paths::AnyPaths;

/// Flies on to the distance `t` from the segment's start, and turns the row's hit into one of the
/// medium where it meets a particle before that, which is its end. `wavelength` is the one that
/// distances are drawn for.
#[inline(always)]
pub fn fly<const N: usize>(
    hits: &mut HitColumns,
    flights: &mut FlightTable<N>,
    paths: &AnyPaths<N>,
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
    let medium = scene.medium(inside);
    let drawn = medium.sigma_d[wavelength as usize];
    let whole = length.min(f32::MAX);
    // Where nothing scatters the distance is infinite, or not a number: nothing is met.
    if progress.left / drawn < length {
        let distance = distance_met(medium, wavelength as usize, progress.left, whole);
        meet(progress, medium, distance, whole);
        hits.t[row] = progress.travelled + distance;
        hits.primitive[row] = IN_MEDIUM + inside;
    } else {
        for n in 0..N {
            progress.depth[n] += medium.sigma_t[n] * whole;
            progress.drawn[n] += medium.sigma_d[n] * whole;
        }
    }
    progress.left -= drawn * whole;
    progress.from = progress.travelled;
    progress.travelled = t;
}

/// Ends a flight at a `distance` on a piece of `length`.
fn meet<const N: usize>(
    progress: &mut Progress<N>,
    medium: &Medium<N>,
    distance: f32,
    length: f32,
) {
    progress.is_over = true;
    let depths = medium.sigma_t.map(|sigma_t| sigma_t * distance);
    progress.depth.iter_mut().zip(depths).for_each(|(sum, depth)| *sum += depth);
    progress.drawn.iter_mut().zip(depths).for_each(|(sum, depth)| *sum += depth);
    progress.survival = match medium.by_extinction {
        Some(survival) => survival,
        None => thin_out(progress, medium, length),
    };
}

/// Makes up for flights that end more rarely on a piece than light does; the probability with which
/// roulette lets them go on.
fn thin_out<const N: usize>(progress: &mut Progress<N>, medium: &Medium<N>, length: f32) -> f32 {
    let mut survival = SURVIVAL_MIN;
    for n in 0..N {
        match rarity(medium, n, length) {
            Some(rarity) => {
                progress.drawn[n] += ln(rarity);
                survival = survival.max(medium.sigma_s[n] / medium.sigma_t[n] * rarity);
            }
            None => progress.drawn[n] = f32::INFINITY,
        }
    }
    survival.min(1.0)
}

/// How much rarer flights end on a piece than light does; none where no flight does.
fn rarity<const N: usize>(medium: &Medium<N>, n: usize, length: f32) -> Option<f32> {
    let (sigma_t, sigma_d) = (medium.sigma_t[n], medium.sigma_d[n]);
    if sigma_d == sigma_t {
        return (sigma_d > 0.0).then_some(1.0);
    }
    let lost = |sigma: f32| exp_m1(-sigma * length);
    // Pieces may be so short that nothing is lost on them.
    let rarity = lost(sigma_t) / lost(sigma_d);
    (sigma_d > 0.0).then(|| if rarity.is_finite() { rarity } else { sigma_t / sigma_d })
}

/// Where on a piece of `length` the particle is that is met, with `left` of what is drawn before
/// it.
fn distance_met<const N: usize>(medium: &Medium<N>, n: usize, left: f32, length: f32) -> f32 {
    let (sigma_t, sigma_d) = (medium.sigma_t[n], medium.sigma_d[n]);
    if sigma_d == sigma_t {
        return left / sigma_d;
    }
    let lost = |depth: f64| -exp_m1(-depth);
    let [of_light, of_flights] =
        [sigma_t, sigma_d].map(|sigma| lost(f64::from(sigma) * f64::from(length)));
    let depth = -ln_1p(-lost(f64::from(left)) * of_light / of_flights);
    ((depth / f64::from(sigma_t)) as f32).min(length)
}
