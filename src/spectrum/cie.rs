//! The CIE 1931 standard observer of 2 degrees: what light looks like, in three numbers.
//!
//! Color matching functions are tabulated every nanometer from 360 to 830 nm (ISO/CIE
//! 11664-1:2019), linear between and zero outside.

use std::sync::OnceLock;

use super::data;

/// The table: every nanometer of [`VISIBLE_NM`] with the three functions there.
const TABLE: &str = include_str!("data/cie1931.csv");
/// Wavelengths in nanometers outside of which nothing is seen.
pub const VISIBLE_NM: [f64; 2] = [360.0, 830.0];

/// The functions at every nanometer, from the first of [`VISIBLE_NM`] on.
fn tabulated() -> &'static [[f64; 3]] {
    static VALUES: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
    VALUES.get_or_init(|| {
        let row = |line| data::numbers(line).and_then(|cells| cells[1..].try_into().ok());
        data::lines(TABLE).map(|line| row(line).expect("three numbers a nanometer")).collect()
    })
}

/// The color matching functions x, y, z at a wavelength in nanometers.
pub fn color_matching(wavelength_nm: f64) -> [f64; 3] {
    let [first, last] = VISIBLE_NM;
    if !(first..=last).contains(&wavelength_nm) {
        return [0.0; 3];
    }
    let table = tabulated();
    let lower = ((wavelength_nm - first) as usize).min(table.len() - 2);
    let share = wavelength_nm - first - lower as f64;
    std::array::from_fn(|i| table[lower][i] * (1.0 - share) + table[lower + 1][i] * share)
}

/// Integrals over wavelength, in nanometers, of a spectrum times the color matching functions,
/// over what a range has of [`VISIBLE_NM`]; zero if that is nothing.
///
/// Simpson's rule within every nanometer: exact where the spectrum is linear there.
pub fn integrals(range_nm: [f64; 2], spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let (from, to) = (range_nm[0].max(VISIBLE_NM[0]), range_nm[1].min(VISIBLE_NM[1]));
    let mut sums = [0.0; 3];
    let mut start = from;
    while start < to {
        let end = (start.floor() + 1.0).min(to);
        let width = end - start;
        for (nm, weight) in [(start, 1.0), (start + 0.5 * width, 4.0), (end, 1.0)] {
            let value = spectrum(nm) * weight * width / 6.0;
            let seen = color_matching(nm);
            sums.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += value * seen);
        }
        start = end;
    }
    sums
}

/// Mean of a spectrum over what a range has of [`VISIBLE_NM`], weighted by the luminous efficiency
/// y: its luminance over that of a flat spectrum of 1.
pub fn luminous_mean(range_nm: [f64; 2], spectrum: impl Fn(f64) -> f64) -> f64 {
    integrals(range_nm, spectrum)[1] / integrals(range_nm, |_| 1.0)[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_met_and_linear_between() {
        assert_eq!(color_matching(555.0), [0.512_050_1, 1.0, 0.005_749_999]);
        assert_eq!(color_matching(360.0), [0.000_129_9, 3.917e-6, 0.000_606_1]);
        assert_eq!(color_matching(830.0), [1.251_141e-6, 4.518_1e-7, 0.0]);
        let [lower, upper] = [600.0, 601.0].map(color_matching);
        let between = color_matching(600.25);
        for i in 0..3 {
            assert!((between[i] - (0.75 * lower[i] + 0.25 * upper[i])).abs() < 1e-12);
        }
        for outside in [359.9, 830.1, 0.0, -5.0, f64::NAN, f64::INFINITY] {
            assert_eq!(color_matching(outside), [0.0; 3]);
        }
    }

    /// Sums over the table as the CIE states them (CIE 15).
    #[test]
    fn a_flat_spectrum_looks_as_the_cie_says() {
        let sums = integrals([0.0, 1000.0], |_| 1.0);
        for (sum, expected) in sums.into_iter().zip([106.865_469, 106.856_917, 106.892_251]) {
            assert!((sum - expected).abs() < 1e-3, "{sums:?}");
        }
        assert!((luminous_mean([380.0, 780.0], |_| 3.0) - 3.0).abs() < 1e-12);
        assert_eq!(integrals([900.0, 950.0], |_| 1.0), [0.0; 3]);
        assert_eq!(integrals([700.0, 500.0], |_| 1.0), [0.0; 3]);
        // In parts, with ends between the nanometers.
        let [low, high] = [[380.0, 512.3], [512.3, 780.0]].map(|range| integrals(range, |nm| nm));
        let whole = integrals([380.0, 780.0], |nm| nm);
        for i in 0..3 {
            assert!((low[i] + high[i] - whole[i]).abs() < 1e-9 * whole[i]);
        }
    }
}
