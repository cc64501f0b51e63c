//! Bands as the CIE 1931 observer sees them: what red, green and blue are of an image of bands.
//!
//! Between the centers of bands a spectrum is taken to be linear, and beyond the outer two constant
//! to the ends of these bands, where it ends. Red, green and blue of that are linear in the values
//! of the bands, so that each has weights, as good for S1 to S3 as for S0.

use super::Bands;
use super::cie::{VISIBLE_NM, integrals};
use super::color_space::{RgbResponse, nodes_nm};

/// The least share of what x, y and z take of a flat spectrum that lies within the bands.
const SHARE: f64 = 0.9;
/// The farthest that two centers may be apart, in nanometers: lobes of the observer are some
/// hundred wide.
const GAP_NM: f32 = 60.0;

/// The weights of every band in linear red, green and blue of sRGB, so that daylight of luminance
/// 1 is about (1, 1, 1); nothing if the bands do not tell the color of light, as they miss too much
/// of what is seen.
pub fn rgb_of_bands(bands: &Bands) -> Option<Vec<[f32; 3]>> {
    let list = bands.list();
    let ends = [list[0].ends_nm()[0], list[list.len() - 1].ends_nm()[1]];
    let is_close = list.windows(2).all(|pair| pair[1].center_nm - pair[0].center_nm <= GAP_NM);
    let [part, whole] = [ends, VISIBLE_NM].map(|range| integrals(range, |_| 1.0));
    let is_seen = part.iter().zip(whole).all(|(part, whole)| *part >= SHARE * whole);
    if !(is_close && is_seen) {
        return None;
    }
    let response = RgbResponse::new();
    let mut weights = vec![[0.0_f64; 3]; list.len()];
    for nm in nodes_nm().filter(|nm| (ends[0]..=ends[1]).contains(nm)) {
        let upper = list.partition_point(|band| f64::from(band.center_nm) <= nm);
        let share = share_of_upper(bands, upper, nm);
        let seen = response.at(nm);
        for (band, share) in [(upper.saturating_sub(1), 1.0 - share), (upper, share)] {
            if let Some(weight) = weights.get_mut(band) {
                weight.iter_mut().zip(seen).for_each(|(weight, seen)| *weight += share * seen);
            }
        }
    }
    Some(weights.into_iter().map(|weight| weight.map(|weight| weight as f32)).collect())
}

/// How much the band of index `upper` has of the spectrum at a wavelength below its center; the one
/// before has the rest.
fn share_of_upper(bands: &Bands, upper: usize, nm: f64) -> f64 {
    let list = bands.list();
    match (upper.checked_sub(1).map(|lower| &list[lower]), list.get(upper)) {
        (Some(lower), Some(upper)) => {
            let [from, to] = [lower, upper].map(|band| f64::from(band.center_nm));
            (nm - from) / (to - from)
        }
        (None, Some(_)) => 1.0,
        (_, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(bands: &Bands, spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for (band, weights) in bands.list().iter().zip(rgb_of_bands(bands).expect("seen")) {
            for (rgb, weight) in rgb.iter_mut().zip(weights) {
                *rgb += f64::from(weight) * spectrum(f64::from(band.center_nm));
            }
        }
        rgb
    }

    #[test]
    fn equal_energy_has_its_color() {
        // Sums of the rows of the matrix of IEC 61966-2-1.
        let expected = [1.2048, 0.9484, 0.9087];
        for (first, last, count) in [(380.0, 780.0, 41), (400.0, 700.0, 31), (400.0, 720.0, 8)] {
            let bands = Bands::evenly(first, last, count).unwrap();
            let found = seen(&bands, |_| 1.0);
            let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 0.012, "{bands}: {found:?}");
        }
    }

    /// Linear spectra are what they are, and smooth ones nearly.
    #[test]
    fn spectra_have_the_colors_that_their_bands_tell() {
        let bands = Bands::evenly(400.0, 700.0, 31).unwrap();
        let response = RgbResponse::new();
        let within = |nm: f64| if (395.0..=705.0).contains(&nm) { 1.0 } else { 0.0 };
        let line = |nm: f64| nm.clamp(400.0, 700.0) / 550.0;
        let wave = |nm: f64| 1.0 + 0.5 * (nm / 30.0).cos();
        for (spectrum, tolerance) in [(&line as &dyn Fn(f64) -> f64, 1e-5), (&wave, 0.01)] {
            let found = seen(&bands, spectrum);
            let expected = response.rgb(|nm| within(nm) * spectrum(nm));
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < tolerance, "{found:?} and not {expected:?}");
            }
        }
    }

    #[test]
    fn bands_that_miss_what_is_seen_tell_no_color() {
        for (first, last, count) in
            [(460.0, 640.0, 10), (800.0, 1000.0, 5), (400.0, 700.0, 3), (550.0, 552.0, 2)]
        {
            let bands = Bands::evenly(first, last, count).unwrap();
            assert_eq!(rgb_of_bands(&bands), None, "{bands}");
        }
    }
}
