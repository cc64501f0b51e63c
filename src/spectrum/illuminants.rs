//! Illuminants by name.
//!
//! All are as bright as a flat spectrum of 1: their mean under the luminous efficiency y of the
//! CIE 1931 observer, over what they cover of 360 to 830 nm, is 1. So a factor means the same for
//! all of them, and a film that shows the flat spectrum with a luminance of 1 shows any of them so.

use std::sync::LazyLock;

use super::cie::luminous_mean;
use super::lamps::RADIATION_NM_K;
use super::{Spectrum, data};

/// The table: first wavelength and step in nanometers, and the values.
const TABLE: &str = include_str!("data/illuminants.csv");
/// Illuminant A is Planck's law at 2848 K with the radiation constant of its time, in nm K.
const A: (f64, f64) = (2848.0, 1.435e7);

/// The names that [`Spectrum::illuminant`] knows.
pub fn illuminant_names() -> Vec<&'static str> {
    let mut names = vec!["A", "E"];
    names.extend(data::names(TABLE));
    names
}

/// How the name of an illuminant is written that is given in capitals or not.
pub(super) fn illuminant_name(name: &str) -> Option<&'static str> {
    data::known(illuminant_names(), name)
}

impl Spectrum {
    /// An illuminant of the CIE by its name, in capitals or not: A, D50, D65, E (flat), F1 to F12,
    /// LED-B1 to LED-B5, LED-BH1, LED-RGB1, LED-V1, LED-V2 (CIE 15:2018). As bright as a flat
    /// spectrum of 1: its mean under the luminous efficiency y of the CIE 1931 observer is 1. D65
    /// is tabulated from 300 to 830 nm, D50 to 780 nm, F and LED from 380 to 780 nm, linear
    /// between.
    ///
    /// None if there is none of this name.
    pub fn illuminant(name: &str) -> Option<Self> {
        match illuminant_name(name)? {
            "A" => Self::blackbody(A.0 * (RADIATION_NM_K / A.1)).ok(),
            "E" => Some(Self::Constant(1.0)),
            name => tabulated(name),
        }
    }
}

fn tabulated(name: &str) -> Option<Spectrum> {
    let table = Tabulated::of(name)?;
    let nm: Vec<f32> = (0..table.values.len()).map(|i| table.nm(i) as f32).collect();
    let values: Vec<f32> = table.values.iter().map(|value| *value as f32).collect();
    let spectrum = Spectrum::table(&nm, &values).ok()?;
    let at = |nm: f64| f64::from(spectrum.at(nm as f32).unwrap_or(0.0));
    let mean = luminous_mean(table.ends_nm(), at);
    Some(spectrum.scaled((1.0 / mean) as f32))
}

/// An entry of the table, which has a value every so many nanometers.
struct Tabulated {
    first_nm: f64,
    step_nm: f64,
    values: Vec<f64>,
}

impl Tabulated {
    fn of(name: &str) -> Option<Self> {
        let numbers = data::numbers(data::entries(TABLE, name).next()?)?;
        let [first_nm, step_nm, values @ ..] = &numbers[..] else { return None };
        Some(Self { first_nm: *first_nm, step_nm: *step_nm, values: values.to_vec() })
    }

    /// The wavelength of a value in nanometers.
    fn nm(&self, index: usize) -> f64 {
        self.first_nm + self.step_nm * index as f64
    }

    fn ends_nm(&self) -> [f64; 2] {
        [self.first_nm, self.nm(self.values.len() - 1)]
    }
}

/// The white of sRGB, which everything that is a color is reckoned by.
static D65: LazyLock<Tabulated> =
    LazyLock::new(|| Tabulated::of("D65").expect("it is in the table that comes with the program"));

/// From which wavelength to which D65 is tabulated, in nanometers.
pub(super) fn d65_nm() -> [f64; 2] {
    D65.ends_nm()
}

/// Relative spectral power of D65 at a wavelength in nanometers, 100 at 560 nm (ISO/CIE 11664-2):
/// linear between the values of the table, and zero outside of them, where it is not known.
pub(super) fn d65(wavelength_nm: f64) -> f64 {
    let Tabulated { first_nm, step_nm, values } = &*D65;
    let [first, last] = D65.ends_nm();
    if !(first..=last).contains(&wavelength_nm) {
        return 0.0;
    }
    let place = (wavelength_nm - first_nm) / step_nm;
    let lower = (place as usize).min(values.len() - 2);
    let share = place - lower as f64;
    values[lower] * (1.0 - share) + values[lower + 1] * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::cie::{VISIBLE_NM, integrals};

    fn within(spectrum: &Spectrum, nm: f64) -> f64 {
        f64::from(spectrum.at(nm as f32).unwrap_or(0.0))
    }

    /// Chromaticities x, y of CIE 15:2018, as stated there: of sums every 5 nm, which differ from
    /// integrals where there are lines.
    const CHROMATICITIES: [(&str, f64, f64); 25] = [
        ("A", 0.447_58, 0.407_45),
        ("D50", 0.345_67, 0.358_51),
        ("D65", 0.312_72, 0.329_03),
        ("E", 0.333_33, 0.333_33),
        ("F1", 0.3131, 0.3371),
        ("F2", 0.3721, 0.3751),
        ("F3", 0.4091, 0.3941),
        ("F4", 0.4402, 0.4031),
        ("F5", 0.3138, 0.3452),
        ("F6", 0.3779, 0.3882),
        ("F7", 0.3129, 0.3292),
        ("F8", 0.3458, 0.3586),
        ("F9", 0.3741, 0.3727),
        ("F10", 0.3458, 0.3588),
        ("F11", 0.3805, 0.3769),
        ("F12", 0.4370, 0.4042),
        ("LED-B1", 0.4560, 0.4078),
        ("LED-B2", 0.4357, 0.4012),
        ("LED-B3", 0.3756, 0.3723),
        ("LED-B4", 0.3422, 0.3502),
        ("LED-B5", 0.3118, 0.3236),
        ("LED-BH1", 0.4474, 0.4066),
        ("LED-RGB1", 0.4557, 0.4211),
        ("LED-V1", 0.4548, 0.4044),
        ("LED-V2", 0.3781, 0.3775),
    ];

    #[test]
    fn every_illuminant_has_its_color_and_a_luminance_of_one() {
        assert_eq!(illuminant_names().len(), CHROMATICITIES.len());
        for (name, x, y) in CHROMATICITIES {
            assert!(illuminant_names().contains(&name), "{name}");
            let spectrum = Spectrum::illuminant(name).unwrap();
            let seen = integrals(VISIBLE_NM, |nm| within(&spectrum, nm));
            let sum: f64 = seen.iter().sum();
            let error = (seen[0] / sum - x).abs().max((seen[1] / sum - y).abs());
            assert!(error < 3e-4, "{name}: {error:e}");
            // 106.857 nm is the integral of y.
            assert!((seen[1] / 106.857 - 1.0).abs() < 1e-3, "{name}: {}", seen[1]);
        }
        for (typed, name) in [("d65", "D65"), ("a", "A"), ("e", "E"), ("led-rgb1", "LED-RGB1")] {
            assert_eq!(Spectrum::illuminant(typed), Spectrum::illuminant(name), "{typed}");
        }
        let small: std::collections::BTreeSet<String> =
            illuminant_names().into_iter().map(str::to_lowercase).collect();
        assert_eq!(small.len(), illuminant_names().len(), "two names differ in capitals alone");
        for unknown in ["", "d66", "D65 ", "F13", "#", "D65,300"] {
            assert_eq!(Spectrum::illuminant(unknown), None);
        }
    }

    #[test]
    fn daylight_is_that_of_the_standard() {
        assert_eq!([300.0, 360.0, 560.0, 830.0].map(d65), [0.0341, 46.6383, 100.0, 60.3125]);
        assert!((d65(562.5) - 0.5 * (100.0 + 98.1671)).abs() < 1e-12);
        for nm in [f64::NAN, -1.0, 0.0, 299.999, 830.001, f64::INFINITY] {
            assert_eq!(d65(nm), 0.0);
        }
    }

    /// The formula of CIE 15 for illuminant A.
    #[test]
    fn illuminant_a_is_the_formula_of_the_cie() {
        let a = Spectrum::illuminant("A").unwrap();
        let of = |nm: f64| (560.0 / nm).powi(5) / (1.435e7 / (2848.0 * nm)).exp_m1();
        for nm in [300.0, 380.0, 450.0, 560.0, 700.0, 830.0] {
            let ratio = within(&a, nm) / within(&a, 560.0) / (of(nm) / of(560.0));
            assert!((ratio - 1.0).abs() < 1e-6, "{nm}: {ratio}");
        }
    }
}
