//! Free flights: where paths meet particles of the media they cross, or the surface behind.

use crate::geometry::{HitColumns, IN_MEDIUM};
use crate::math::{F32s, LANES, Real, lanes};
use crate::scattering::Scene;
use crate::scattering::medium::Medium;
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
    let depth = lanes::columns(|lane| &flights.progress[of(lane)].depth);
    let meets = lanes::each(|lane| {
        let met = hits.primitive[of(lane)];
        met >= IN_MEDIUM && met != NONE
    });
    let zero = F32s::splat(0.0);
    let is_deep = depth.iter().fold(zero, |is_deep, depth| is_deep | depth.simd_gt(zero));
    if !is_deep.any() && !meets.contains(&true) {
        return;
    }
    let drawn = lanes::columns(|lane| &flights.progress[of(lane)].drawn);
    let least = drawn[1..].iter().fold(drawn[0], |least, drawn| least.min(*drawn));
    // Only ratios matter: the least depth is taken out, so that no sum underflows.
    let of_light = depth.map(|depth| (least - depth).exp());
    let of_flights = if drawn == depth { of_light } else { drawn.map(|it| (least - it).exp()) };
    let media = lanes::each(|lane| paths.media.inside[of(lane)]);
    let sigmas = Sigmas { scene, media, meets };
    let mut densities = [zero; N];
    let mut sum = zero;
    for (n, density) in densities.iter_mut().enumerate() {
        *density = of_flights[n] * sigmas.at(|medium| medium.sigma_t[n]);
        if N > 1 {
            *density *= lanes::load(&paths.media.share[n], row);
        }
        sum += *density;
    }
    let inverse = F32s::splat(1.0) / sum;
    for n in 0..N {
        let value = of_light[n] * sigmas.at(|medium| medium.sigma_s[n]);
        let beta = lanes::load(&paths.beta[n], row) * value * inverse;
        lanes::store(&mut paths.beta[n], row, paths.len, beta);
        if N > 1 {
            lanes::store(&mut paths.media.share[n], row, paths.len, densities[n] * inverse);
        }
    }
}

/// The coefficients of the media that eight rows are in.
struct Sigmas<'a, const N: usize> {
    scene: &'a Scene<N>,
    media: [u32; LANES],
    /// Which of them meet particles there.
    meets: [bool; LANES],
}

impl<const N: usize> Sigmas<'_, N> {
    /// A coefficient where rows meet particles, else one.
    #[inline(always)]
    fn at(&self, of: impl Fn(&Medium<N>) -> f32) -> F32s {
        let one = F32s::splat(1.0);
        let [first, rest @ ..] = &self.media;
        let values = match rest.iter().all(|other| other == first) {
            true => F32s::splat(of(self.scene.medium(*first))),
            false => F32s::from(lanes::each(|lane| of(self.scene.medium(self.media[lane])))),
        };
        Real::select(lanes::mask_of(self.meets), values, one)
    }
}
