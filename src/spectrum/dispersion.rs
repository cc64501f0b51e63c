//! Formulas of indices of refraction: Sellmeier, Cauchy, and what an Abbe number says.

use super::Spectrum;
use super::formula::{Formula, Law};

/// Micrometers in a nanometer.
const UM: f64 = 1e-3;
/// Wavelengths in nanometers of the helium line d and of the hydrogen lines F and C, by which an
/// index and an Abbe number are stated.
pub const D_NM: f32 = 587.561_8;
const F_NM: f64 = 486.132_7;
const C_NM: f64 = 656.272_5;
/// Where [`Spectrum::of_dispersion`] is valid, in nanometers.
const DISPERSION_NM: [f32; 2] = [300.0, 1000.0];
/// Abbe number of a dispersion of 1 in `KHR_materials_dispersion`.
const UNIT_ABBE: f64 = 20.0;

impl Spectrum {
    /// An index of refraction by the formula of Sellmeier 1871: n^2 = 1 + sum of b w^2 / (w^2 - c)
    /// for a wavelength w in micrometers, in a range of wavelengths in nanometers.
    ///
    /// # Errors
    /// When there are not as many b as c, or none; when one is not finite; when the range is none;
    /// when the formula has a resonance in it or n^2 might not be positive there.
    pub fn sellmeier(b: &[f64], c_um2: &[f64], range_nm: [f32; 2]) -> Result<Self, &'static str> {
        if b.is_empty() || b.len() != c_um2.len() {
            return Err("needs as many b as c_um2, and at least one");
        }
        if !b.iter().chain(c_um2).all(|number| number.is_finite()) {
            return Err("needs finite coefficients");
        }
        check_range(range_nm)?;
        let [from, to] = range_nm.map(|nm| squared_um(f64::from(nm)));
        if c_um2.iter().any(|c| (from..=to).contains(c)) {
            return Err("has a resonance within its range: narrow range_nm, or mend c_um2");
        }
        let terms = b.iter().copied().zip(c_um2.iter().copied()).collect();
        let law = Sellmeier { terms };
        let [least, most] = law.bounds_squared(range_nm.map(f64::from));
        if !(least > 0.0 && most.is_finite()) {
            return Err("needs an index greater than zero in all of its range");
        }
        Ok(Self::Formula(Formula::new(Law::Sellmeier(law), range_nm)))
    }

    /// An index of refraction by the formula of Cauchy 1836: n = a + b / w^2 + c / w^4 for a
    /// wavelength w in micrometers, in a range of wavelengths in nanometers.
    ///
    /// # Errors
    /// When a number is not finite, when the range is none, or when n might not be positive there.
    pub fn cauchy(
        a: f64,
        b_um2: f64,
        c_um4: f64,
        range_nm: [f32; 2],
    ) -> Result<Self, &'static str> {
        if ![a, b_um2, c_um4].iter().all(|number| number.is_finite()) {
            return Err("needs finite coefficients");
        }
        check_range(range_nm)?;
        let law = Cauchy { a, b_um2, c_um4 };
        let [least, most] = law.bounds(range_nm.map(f64::from));
        if !(least > 0.0 && most.is_finite()) {
            return Err("needs an index greater than zero in all of its range");
        }
        Ok(Self::Formula(Formula::new(Law::Cauchy(law), range_nm)))
    }

    /// What glTF's `KHR_materials_dispersion` says: an index of refraction n at the line d
    /// (587.56 nm) and a dispersion, which is 20 over the Abbe number (n - 1) / (n_F - n_C). By
    /// Cauchy's formula of two terms, from 300 to 1000 nm.
    ///
    /// # Errors
    /// When the dispersion is negative or not finite, or the index not positive in the range.
    pub fn of_dispersion(ior: f32, dispersion: f32) -> Result<Self, &'static str> {
        if !(dispersion.is_finite() && dispersion >= 0.0) {
            return Err("needs a dispersion that is finite and not negative");
        }
        let difference = (f64::from(ior) - 1.0) * f64::from(dispersion) / UNIT_ABBE;
        let b_um2 = difference / (1.0 / squared_um(F_NM) - 1.0 / squared_um(C_NM));
        let a = f64::from(ior) - b_um2 / squared_um(f64::from(D_NM));
        Self::cauchy(a, b_um2, 0.0, DISPERSION_NM)
    }
}

/// The square of a wavelength in nanometers, in square micrometers.
fn squared_um(wavelength_nm: f64) -> f64 {
    (wavelength_nm * UM) * (wavelength_nm * UM)
}

fn check_range([from, to]: [f32; 2]) -> Result<(), &'static str> {
    if from.is_finite() && to.is_finite() && 0.0 < from && from <= to {
        return Ok(());
    }
    Err("needs a range_nm of two wavelengths in nanometers, greater than zero, the lesser first")
}

/// What bounds of sums of terms are that rise or fall each in the whole of a range.
fn bounds_of(terms: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    terms.fold([0.0; 2], |[least, most], [a, b]| [least + a.min(b), most + a.max(b)])
}

/// Sellmeier's formula: pairs of b and c in square micrometers.
#[derive(Clone, Debug, PartialEq)]
pub struct Sellmeier {
    terms: Vec<(f64, f64)>,
}

impl Sellmeier {
    /// The index at a wavelength in nanometers.
    pub(super) fn at(&self, wavelength_nm: f64) -> f64 {
        let terms = self.terms.iter().map(|&term| term_at(term, wavelength_nm));
        (1.0 + terms.sum::<f64>()).sqrt()
    }

    /// Indices between which all in a range are.
    pub(super) fn bounds(&self, range_nm: [f64; 2]) -> [f64; 2] {
        self.bounds_squared(range_nm).map(f64::sqrt)
    }

    fn bounds_squared(&self, range_nm: [f64; 2]) -> [f64; 2] {
        let term = |&term: &(f64, f64)| range_nm.map(|nm| term_at(term, nm));
        bounds_of(self.terms.iter().map(term)).map(|bound| 1.0 + bound)
    }
}

fn term_at((b, c_um2): (f64, f64), wavelength_nm: f64) -> f64 {
    let squared = squared_um(wavelength_nm);
    b * squared / (squared - c_um2)
}

/// Cauchy's formula.
#[derive(Clone, Debug, PartialEq)]
pub struct Cauchy {
    a: f64,
    b_um2: f64,
    c_um4: f64,
}

impl Cauchy {
    /// The index at a wavelength in nanometers.
    pub(super) fn at(&self, wavelength_nm: f64) -> f64 {
        self.terms(wavelength_nm).iter().sum()
    }

    /// Indices between which all in a range are.
    pub(super) fn bounds(&self, range_nm: [f64; 2]) -> [f64; 2] {
        let [from, to] = range_nm.map(|nm| self.terms(nm));
        bounds_of(from.into_iter().zip(to).map(|(from, to)| [from, to]))
    }

    fn terms(&self, wavelength_nm: f64) -> [f64; 3] {
        let squared = squared_um(wavelength_nm);
        [self.a, self.b_um2 / squared, self.c_um4 / (squared * squared)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Range;

    const RANGE: [f32; 2] = [300.0, 2500.0];

    #[test]
    fn a_dispersion_gives_its_abbe_number() {
        for (ior, dispersion) in [(1.5, 0.0), (1.5168, 0.311_7), (2.42, 0.363_6), (1.33, 5.0)] {
            let spectrum = Spectrum::of_dispersion(ior, dispersion).unwrap();
            let at = |nm: f64| f64::from(spectrum.at(nm as f32).unwrap());
            assert!((at(f64::from(D_NM)) - f64::from(ior)).abs() < 1e-6);
            let difference = at(F_NM) - at(C_NM);
            let expected = (f64::from(ior) - 1.0) * f64::from(dispersion) / 20.0;
            assert!((difference - expected).abs() < 1e-6, "{ior} {dispersion}: {difference}");
        }
        for (ior, dispersion) in
            [(1.5, -0.1), (1.5, f32::NAN), (f32::INFINITY, 0.1), (0.0, 0.0), (1.5, 1e9)]
        {
            assert!(Spectrum::of_dispersion(ior, dispersion).is_err(), "{ior} {dispersion}");
        }
    }

    #[test]
    fn formulas_refuse_what_is_no_index() {
        let sellmeier = |b: &[f64], c: &[f64]| Spectrum::sellmeier(b, c, RANGE).map(drop);
        assert_eq!(sellmeier(&[1.0, 0.2], &[0.01, 0.02]), Ok(()));
        for (b, c) in [
            (&[][..], &[][..]),
            (&[1.0], &[]),
            (&[f64::NAN], &[0.01]),
            (&[1.0], &[f64::INFINITY]),
            (&[1.0], &[0.25]),
            (&[-3.0], &[0.01]),
            (&[1e308, 1e308], &[0.01, 0.02]),
        ] {
            assert!(sellmeier(b, c).is_err(), "{b:?} {c:?}");
        }
        assert!(Spectrum::cauchy(1.5, 0.004, 0.0, RANGE).is_ok());
        assert!(Spectrum::cauchy(0.0, -0.1, 0.0, RANGE).is_err());
        assert!(Spectrum::cauchy(f64::NAN, 0.0, 0.0, RANGE).is_err());
        for range in [[0.0, 1.0], [2.0, 1.0], [f32::NAN, 1.0], [1.0, f32::INFINITY], [-1.0, 5.0]] {
            assert!(Spectrum::cauchy(1.5, 0.0, 0.0, range).is_err(), "{range:?}");
        }
        assert!(Spectrum::cauchy(1.5, 0.0, 0.0, [500.0, 500.0]).is_ok());
    }

    #[test]
    fn formulas_hold_within_their_range_and_bounds() {
        let mixed = Spectrum::sellmeier(&[1.2, -0.1, 0.9], &[0.01, 0.02, 100.0], RANGE).unwrap();
        let falling = Spectrum::cauchy(1.5, 0.01, -0.0005, RANGE).unwrap();
        for spectrum in [mixed, falling] {
            for factor in [1.0, 2.5, -1.0] {
                let scaled = spectrum.clone().scaled(factor);
                let [least, most] = scaled.values().try_into().unwrap();
                for nm in (300..=2500).step_by(50) {
                    let value = scaled.at(nm as f32).unwrap();
                    assert!(least <= value && value <= most);
                    let one = spectrum.at(nm as f32).unwrap();
                    assert!((value - factor * one).abs() < 1e-6);
                }
            }
            assert_eq!(spectrum.at(299.9).unwrap_err().first_nm, 300.0);
            assert!(spectrum.at(2500.1).is_err() && spectrum.at(f32::NAN).is_err());
            assert!(spectrum.check("eta", Range::POSITIVE).is_ok());
        }
    }
}
