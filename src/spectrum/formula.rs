//! Spectra that are formulas of the wavelength, evaluated in double precision where they are valid.

use std::fmt;

use super::dispersion::{Cauchy, Sellmeier};
use super::lamps::{Blackbody, Lines};

/// A quantity as a formula of the wavelength. [`Spectrum`](super::Spectrum) makes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    law: Law,
    /// Vacuum wavelengths in nanometers between which it holds.
    range_nm: [f32; 2],
    factor: f64,
    /// No value is less than the first or greater than the second.
    bounds: [f32; 2],
}

/// The formulas.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// A blackbody.
    Blackbody(Blackbody),
    /// An index of refraction by Cauchy's formula.
    Cauchy(Cauchy),
    /// Emission lines.
    Lines(Lines),
    /// An index of refraction by Sellmeier's formula.
    Sellmeier(Sellmeier),
}

impl Law {
    /// The value at a vacuum wavelength in nanometers.
    fn at(&self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Blackbody(blackbody) => blackbody.at(wavelength_nm),
            Self::Cauchy(cauchy) => cauchy.at(wavelength_nm),
            Self::Lines(lines) => lines.at(wavelength_nm),
            Self::Sellmeier(sellmeier) => sellmeier.at(wavelength_nm),
        }
    }

    /// Numbers between which all values in a range are.
    fn bounds(&self, range_nm: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Blackbody(blackbody) => blackbody.bounds(range_nm),
            Self::Cauchy(cauchy) => cauchy.bounds(range_nm),
            Self::Lines(lines) => lines.bounds(),
            Self::Sellmeier(sellmeier) => sellmeier.bounds(range_nm),
        }
    }
}

impl Formula {
    /// A law that holds between two vacuum wavelengths in nanometers.
    pub(super) fn new(law: Law, range_nm: [f32; 2]) -> Self {
        let bounds = law.bounds(range_nm.map(f64::from)).map(|bound| bound as f32);
        Self { law, range_nm, factor: 1.0, bounds }
    }

    /// The value at a vacuum wavelength in nanometers between its ends.
    pub(super) fn at(&self, wavelength_nm: f32) -> f32 {
        (self.law.at(f64::from(wavelength_nm)) * self.factor) as f32
    }

    /// The vacuum wavelengths in nanometers between which it holds.
    pub(super) fn ends_nm(&self) -> [f32; 2] {
        self.range_nm
    }

    /// The wavelengths in nanometers between which it is nearly linear, where it changes within a
    /// nanometer.
    pub(super) fn knots_nm(&self) -> Vec<f32> {
        match &self.law {
            Law::Blackbody(_) | Law::Cauchy(_) | Law::Sellmeier(_) => Vec::new(),
            Law::Lines(lines) => lines.knots_nm().map(|nm| nm as f32).collect(),
        }
    }

    /// Two numbers between which all values are.
    pub(super) fn bounds(&self) -> &[f32] {
        &self.bounds
    }

    /// Itself times a number.
    pub(super) fn scale(&mut self, factor: f32) {
        self.factor *= f64::from(factor);
        let bounds = self.law.bounds(self.range_nm.map(f64::from));
        self.bounds = bounds.map(|bound| (bound * self.factor) as f32);
        if factor < 0.0 {
            self.bounds.reverse();
        }
    }
}

/// What it is, in words.
impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [first, last] = self.range_nm;
        match &self.law {
            Law::Blackbody(blackbody) => write!(f, "{blackbody}")?,
            Law::Cauchy(_) => write!(f, "by Cauchy's formula, {first} to {last} nm")?,
            Law::Lines(lines) => write!(f, "{lines}")?,
            Law::Sellmeier(_) => write!(f, "by Sellmeier's formula, {first} to {last} nm")?,
        }
        match self.factor {
            1.0 => Ok(()),
            factor => write!(f, ", times {}", factor as f32),
        }
    }
}
