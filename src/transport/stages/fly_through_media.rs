//! Free flights: where paths meet particles of the media they cross, or the surface behind.

use crate::geometry::{HitColumns, IN_MEDIUM};
use crate::math::{F32s, LANES, Real, lanes};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::flight::fly;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::PathTable;

/// Takes every row to where it ends, and turns hits behind particles into hits of the medium. The
/// throughput takes transmittance over density; both are summed over the wavelengths that the
/// distance could have been drawn for.
///
/// From: draw_distances, fly_to_crossings, cross_surfaces. To: keep_pieces, collect_emission,
/// play_roulette, partition_paths.
/// Writes: hits, paths (beta, media), flights. Reads: paths, scene.
pub fn fly_through_media<const N: usize, C>(
    hits: &mut HitColumns,
    paths: &mut PathTable<N, C>,
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
) {
    for first in (0..paths.len).step_by(LANES) {
        let end = paths.len.min(first + LANES);
        let clear = paths.media.inside[first..end].iter().all(|&medium| medium == NONE);
        if clear {
            continue;
        }
        let wavelength = paths.identity.wavelength::<N>(first);
        for row in first..end {
            if !flights.progress[row].is_over {
                let t = hits.t[row];
                fly(hits, flights, paths, scene, (row, t, wavelength[row - first]));
            }
        }
    }
    for row in (0..paths.len).step_by(LANES) {
        weigh(hits, paths, flights, scene, row);
    }
}

/// Throughput and shares of eight rows.
#[inline(always)]
fn weigh<const N: usize, C>(
    hits: &HitColumns,
    paths: &mut PathTable<N, C>,
    flights: &FlightTable<N>,
    scene: &Scene<N>,
    row: usize,
) {
    let live = LANES.min(paths.len - row);
    let of = |lane: usize| row + lane.min(live - 1);
    let depth = |n: usize| F32s::from(lanes::each(|lane| flights.progress[of(lane)].depth[n]));
    let drawn = |n: usize| F32s::from(lanes::each(|lane| flights.progress[of(lane)].drawn[n]));
    let mut least = drawn(0);
    for n in 1..N {
        least = least.min(drawn(n));
    }
    let meets = lanes::each(|lane| {
        let met = hits.primitive[of(lane)];
        met >= IN_MEDIUM && met != NONE
    });
    let meets = lanes::mask_of(meets);
    let one = F32s::splat(1.0);
    let mut densities = [one; N];
    let mut values = [one; N];
    let mut sum = F32s::splat(0.0);
    for n in 0..N {
        let sigma = |of_medium: fn(&crate::scattering::medium::Medium<N>) -> &[f32; N]| {
            let value = |lane| of_medium(scene.medium(paths.media.inside[of(lane)]))[n];
            Real::select(meets, F32s::from(lanes::each(value)), one)
        };
        // Only ratios matter: the least depth is taken out, so that no sum underflows.
        values[n] = sigma(|medium| &medium.sigma_s) * (least - depth(n)).exp();
        densities[n] = sigma(|medium| &medium.sigma_t) * (least - drawn(n)).exp();
        if N > 1 {
            densities[n] *= lanes::load(&paths.media.share[n], row);
        }
        sum += densities[n];
    }
    let inverse = one / sum;
    for n in 0..N {
        let beta = lanes::load(&paths.beta[n], row) * values[n] * inverse;
        lanes::store(&mut paths.beta[n], row, paths.len, beta);
        if N > 1 {
            lanes::store(&mut paths.media.share[n], row, paths.len, densities[n] * inverse);
        }
    }
}
