//! Free flights: where paths meet particles of the media they cross, or the surface behind.

use crate::geometry::{HitColumns, IN_MEDIUM, medium_met};
use crate::math::{F32s, LANES, Real, lanes};
use crate::scattering::Scene;
use crate::scattering::medium::Medium;
use crate::scene::baked::NONE;
use crate::transport::flight::fly;
use crate::transport::tables::flights::FlightTable;
use crate::transport::tables::paths::AnyPaths;

/// Takes every row to where it ends, and turns hits behind particles into hits of the medium. The
/// throughput takes transmittance over density; both are summed over the wavelengths that the
/// distance could have been drawn for.
///
/// From: draw_distances, fly_to_crossings, cross_surfaces. To: keep_pieces, collect_emission,
/// play_roulette, partition_paths.
/// Writes: hits, paths (beta, media), flights. Reads: paths, scene.
pub fn fly_through_media<const N: usize>(
    hits: &mut HitColumns,
    paths: &mut AnyPaths<N>,
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
) {
    for row in (0..paths.len).step_by(LANES) {
        let live = LANES.min(paths.len - row);
        let of = |lane: usize| row + lane.min(live - 1);
        let media = lanes::each(|lane| paths.media.inside[of(lane)]);
        let is_whole = !scene.has_straight_on;
        if is_whole && media == [NONE; LANES] {
            continue;
        }
        let by_extinction = |medium: &u32| scene.medium(*medium).by_extinction.is_some();
        let flown = if is_whole && media.iter().all(by_extinction) {
            fly_whole(hits, paths, flights, scene, (row, media))
        } else {
            fly_on(hits, paths, flights, scene, (row, media))
        };
        weigh(paths, &flown, scene, row);
    }
}

/// How eight rows have flown.
struct Flown<const N: usize> {
    /// Optical depths.
    depth: [F32s; N],
    /// The same of what is drawn: minus the logarithm of the probability of coming so far.
    drawn: [F32s; N],
    /// The media that they are in, of those that have met a particle there.
    media: [u32; LANES],
    meets: F32s,
}

/// Rows with nothing on their way but a medium each, in which flights are drawn by extinction.
#[inline(always)]
fn fly_whole<const N: usize>(
    hits: &mut HitColumns,
    paths: &AnyPaths<N>,
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
    (row, media): (usize, [u32; LANES]),
) -> Flown<N> {
    let live = LANES.min(paths.len - row);
    let of = |lane: usize| row + lane.min(live - 1);
    let wavelength = paths.identity.wavelength::<N>(row);
    let sigma = |lane: usize| scene.medium(media[lane]).sigma_t[wavelength[lane] as usize];
    let left = F32s::from(lanes::each(|lane| flights.progress[of(lane)].left));
    let length = lanes::load(&hits.t, row);
    // Where nothing scatters the distance is infinite, or not a number: nothing is met.
    let distance = left / F32s::from(lanes::each(sigma));
    let meets = distance.simd_lt(length);
    let flown = Real::select(meets, distance, length.min(F32s::splat(f32::MAX)));
    let of_media = OfMedia { scene, media };
    let mut depth = [F32s::splat(0.0); N];
    for (n, depth) in depth.iter_mut().enumerate() {
        *depth = of_media.at(|medium| medium.sigma_t[n]) * flown;
    }
    let (bits, lengths, distances) = (meets.to_bitmask(), length.to_array(), flown.to_array());
    for lane in (0..live).filter(|lane| bits >> lane & 1 == 1) {
        let (row, medium) = (row + lane, media[lane]);
        hits.t[row] = distances[lane];
        hits.primitive[row] = IN_MEDIUM + medium;
        let progress = &mut flights.progress[row];
        progress.is_over = true;
        progress.survival = scene.medium(medium).by_extinction.unwrap_or(1.0);
        progress.travelled = lengths[lane];
    }
    Flown { depth, drawn: depth, media, meets }
}

/// Rows that come from the surfaces that they have crossed, to the last piece of their ways.
#[inline(always)]
fn fly_on<const N: usize>(
    hits: &mut HitColumns,
    paths: &AnyPaths<N>,
    flights: &mut FlightTable<N>,
    scene: &Scene<N>,
    (row, media): (usize, [u32; LANES]),
) -> Flown<N> {
    let live = LANES.min(paths.len - row);
    if media != [NONE; LANES] {
        let wavelength = paths.identity.wavelength::<N>(row);
        for (lane, wavelength) in wavelength.into_iter().enumerate().take(live) {
            if !flights.progress[row + lane].is_over {
                let t = hits.t[row + lane];
                fly(hits, flights, paths, scene, (row + lane, t, wavelength));
            }
        }
    }
    let of = |lane: usize| row + lane.min(live - 1);
    let meets = lanes::each(|lane| medium_met(hits.primitive[of(lane)]).is_some());
    Flown {
        depth: lanes::columns(|lane| &flights.progress[of(lane)].depth),
        drawn: lanes::columns(|lane| &flights.progress[of(lane)].drawn),
        media,
        meets: lanes::mask_of(meets),
    }
}

/// Throughput and shares of eight rows.
#[inline(always)]
fn weigh<const N: usize>(
    paths: &mut AnyPaths<N>,
    Flown { depth, drawn, media, meets }: &Flown<N>,
    scene: &Scene<N>,
    row: usize,
) {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let is_deep = depth.iter().fold(*meets, |is_deep, depth| is_deep | depth.simd_gt(zero));
    if is_deep.none() {
        return;
    }
    let of_media = OfMedia { scene, media: *media };
    let sigma_t = |n: usize| Real::select(*meets, of_media.at(|medium| medium.sigma_t[n]), one);
    let sigma_s = |n: usize| Real::select(*meets, of_media.at(|medium| medium.sigma_s[n]), one);
    if !paths.media.has_shares() {
        // All wavelengths are one.
        let gain = (drawn[0] - depth[0]).exp() * sigma_s(0) / sigma_t(0);
        for beta in &mut paths.beta {
            lanes::scale(beta, row, paths.len, gain);
        }
        return;
    }
    let least = drawn[1..].iter().fold(drawn[0], |least, drawn| least.min(*drawn));
    // Only ratios matter: the least depth is taken out, so that no sum underflows.
    let of_light = depth.map(|depth| (least - depth).exp());
    let of_flights = if drawn == depth { of_light } else { drawn.map(|it| (least - it).exp()) };
    let mut densities = [zero; N];
    let mut sum = zero;
    for (n, density) in densities.iter_mut().enumerate() {
        *density = of_flights[n] * sigma_t(n) * lanes::load(&paths.media.share[n], row);
        sum += *density;
    }
    // What has met nothing stays as it is, whatever its neighbors have: shares sum to one but for
    // rounding.
    let inverse = Real::select(is_deep, one / sum, one);
    for n in 0..N {
        let beta = lanes::load(&paths.beta[n], row) * of_light[n] * sigma_s(n) * inverse;
        lanes::store(&mut paths.beta[n], row, paths.len, beta);
        lanes::store(&mut paths.media.share[n], row, paths.len, densities[n] * inverse);
    }
}

/// The media that eight rows are in.
struct OfMedia<'a, const N: usize> {
    scene: &'a Scene<N>,
    media: [u32; LANES],
}

impl<const N: usize> OfMedia<'_, N> {
    /// One of their coefficients.
    #[inline(always)]
    fn at(&self, of: impl Fn(&Medium<N>) -> f32) -> F32s {
        let [first, rest @ ..] = &self.media;
        match rest.iter().all(|other| other == first) {
            true => F32s::splat(of(self.scene.medium(*first))),
            false => F32s::from(lanes::each(|lane| of(self.scene.medium(self.media[lane])))),
        }
    }
}
