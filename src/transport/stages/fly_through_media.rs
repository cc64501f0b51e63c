//! Free flights: where paths meet particles of the media they cross, or the surface behind.

use crate::geometry::{Hit, HitColumns, IN_MEDIUM, TraceScratch, offset_distance, trace_closest};
use crate::math::columns::Rows;
use crate::math::{F32s, LANES, Real, lanes};
use crate::scattering::Scene;
use crate::scene::baked::NONE;
use crate::transport::flight::step_over;
use crate::transport::sampler::Purpose;
use crate::transport::tables::flights::{Flight, FlightTable};
use crate::transport::tables::paths::PathTable;

/// Draws how far every row flies, through boundaries that do not bend it, and turns hits behind
/// that into hits of the medium. The throughput takes transmittance over density; both are summed
/// over the wavelengths that the distance could have been drawn for.
///
/// From: trace_closest. To: collect_emission, play_roulette, partition_paths.
/// Writes: hits, paths (beta, media), flights, scratch. Reads: paths, scene.
pub fn fly_through_media<const N: usize, C>(
    hits: &mut HitColumns,
    paths: &mut PathTable<N, C>,
    (flights, scratch): (&mut FlightTable<N>, &mut TraceScratch),
    scene: &Scene<N>,
    path_length: u32,
) {
    flights.clear(paths.len);
    first_pieces(hits, paths, flights, scene, path_length);
    while flights.len > 0 {
        let rows = 0..flights.len;
        trace_closest(&mut flights.hits, scratch, &flights.rays, rows, &scene.accelerator);
        later_pieces(hits, paths, flights, scene);
    }
    for row in (0..paths.len).step_by(LANES) {
        weigh(hits, paths, flights, scene, row);
    }
}

/// The segments up to their first boundary.
fn first_pieces<const N: usize, C>(
    hits: &mut HitColumns,
    paths: &mut PathTable<N, C>,
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
    path_length: u32,
) {
    for first in (0..paths.len).step_by(LANES) {
        let end = paths.len.min(first + LANES);
        let clear = paths.media.inside[first..end].iter().all(|&medium| medium == NONE);
        if clear && !scene.has_null_boundaries {
            continue;
        }
        let [u, _] = paths.identity.draw(first, path_length, Purpose::Distance);
        let left = (-(F32s::splat(1.0) - u).ln()).to_array();
        let wavelength = paths.identity.wavelength::<N>(first);
        for row in first..end {
            let lane = row - first;
            flights.left[row] = left[lane];
            let (t, inside) = (hits.t[row], paths.media.inside[row]);
            match fly(flights, scene, (row, inside), t, wavelength[lane] as usize) {
                Some(distance) => {
                    hits.t[row] = distance;
                    hits.primitive[row] = IN_MEDIUM + inside;
                }
                None if is_null_boundary(scene, hits.primitive[row]) => {
                    let index = flights.len;
                    flights.push_row(Flight {
                        row: row as u32,
                        rays: paths.rays.get(row),
                        hits: Hit { t, u: 0.0, v: 0.0, primitive: hits.primitive[row] },
                        inside,
                        travelled: 0.0,
                    });
                    flights.len = index;
                    step_over(flights, index, scene);
                }
                None => {}
            }
        }
    }
}

/// The pieces between two boundaries, or behind the last.
fn later_pieces<const N: usize, C>(
    hits: &mut HitColumns,
    paths: &mut PathTable<N, C>,
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
) {
    let len = std::mem::replace(&mut flights.len, 0);
    for index in 0..len {
        let row = flights.row[index] as usize;
        let inside = flights.inside[index];
        let (t, primitive) = (flights.hits.t[index], flights.hits.primitive[index]);
        let start = row - row % LANES;
        let wavelength = paths.identity.wavelength::<N>(start)[row - start] as usize;
        // The step off the last boundary: what lies within it is met at a negative distance.
        let sigma = scene.medium(inside).sigma_t[wavelength];
        flights.left[row] -= sigma * offset_distance(scene.reach);
        let met = fly(flights, scene, (row, inside), t, wavelength);
        if met.is_none() && is_null_boundary(scene, primitive) {
            step_over(flights, index, scene);
            continue;
        }
        paths.media.inside[row] = inside;
        hits.t[row] = flights.travelled[index] + met.unwrap_or(t);
        hits.primitive[row] = if met.is_some() { IN_MEDIUM + inside } else { primitive };
        hits.u[row] = flights.hits.u[index];
        hits.v[row] = flights.hits.v[index];
    }
}

/// Flies up to `t` through the medium `inside`: the distance at which the row meets a particle, if
/// it does. Takes what is flown through from the optical depth that is left.
#[inline(always)]
fn fly<const N: usize>(
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
    (row, inside): (usize, u32),
    t: f32,
    wavelength: usize,
) -> Option<f32> {
    if inside == NONE {
        return None;
    }
    let sigma_t = &scene.medium(inside).sigma_t;
    let sigma = sigma_t[wavelength];
    let distance = flights.left[row] / sigma;
    // Without extinction the distance is infinite, or not a number: nothing is met.
    let meets = distance < t;
    let piece = if meets { distance } else { t.min(f32::MAX) };
    for (depth, sigma) in flights.depth[row].iter_mut().zip(sigma_t) {
        *depth += sigma * piece;
    }
    flights.left[row] -= sigma * piece;
    meets.then_some(distance)
}

fn is_null_boundary<const N: usize>(scene: &Scene<N>, primitive: u32) -> bool {
    scene.has_null_boundaries && primitive != NONE && scene.material_at(primitive).kind.is_crossed()
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
    let depth = |n: usize| F32s::from(lanes::each(|lane| flights.depth[of(lane)][n]));
    let mut least = depth(0);
    for n in 1..N {
        least = least.min(depth(n));
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
        // Only ratios matter: the least depth is taken out, so that nothing underflows.
        let transmittance = (least - depth(n)).exp();
        values[n] = sigma(|medium| &medium.sigma_s) * transmittance;
        densities[n] = sigma(|medium| &medium.sigma_t) * transmittance;
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
