//! Spectral quantities as the user writes them, and their values at the wavelengths of a render.

use super::{Carried, Formula, RGB_WAVELENGTHS_NM};
use crate::math::{Fault, Range};

/// A quantity that may depend on wavelength: a reflectance, an index of refraction, a radiance.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f32),
    /// Linear red, green and blue. At a single wavelength: interpolated linearly between the
    /// channels' [`RGB_WAVELENGTHS_NM`], constant beyond the outer two.
    Rgb([f32; 3]),
    /// Values at wavelengths, interpolated linearly between them and undefined outside.
    Table(SpectrumTable),
    /// A formula of the wavelength, undefined outside of its range.
    Formula(Formula),
}

/// A tabulated spectrum: see `SpectrumTable::new`.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumTable {
    wavelengths_nm: Vec<f32>,
    values: Vec<f32>,
}

impl From<f32> for Spectrum {
    fn from(constant: f32) -> Self {
        Self::Constant(constant)
    }
}

impl From<[f32; 3]> for Spectrum {
    fn from(rgb: [f32; 3]) -> Self {
        Self::Rgb(rgb)
    }
}

impl From<SpectrumTable> for Spectrum {
    fn from(table: SpectrumTable) -> Self {
        Self::Table(table)
    }
}

/// A render asks for a wavelength that a table or a formula does not cover.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("asked for {wavelength_nm} nm, but it covers {first_nm} to {last_nm} nm only")]
pub struct OutsideTable {
    /// Vacuum wavelength asked for, in nanometers.
    pub wavelength_nm: f32,
    /// Shortest wavelength of it, in nanometers.
    pub first_nm: f32,
    /// Longest wavelength of it, in nanometers.
    pub last_nm: f32,
}

impl SpectrumTable {
    /// A table from strictly increasing vacuum wavelengths in nanometers and as many finite
    /// values; what is wrong with them otherwise.
    pub fn new(wavelengths_nm: Vec<f32>, values: Vec<f32>) -> Result<Self, &'static str> {
        if wavelengths_nm.is_empty() || wavelengths_nm.len() != values.len() {
            return Err("needs as many wavelengths as values, and at least one");
        }
        if !wavelengths_nm.iter().all(|nm| nm.is_finite() && *nm > 0.0) {
            return Err("needs wavelengths in nanometers, greater than zero");
        }
        if !wavelengths_nm.is_sorted_by(|a, b| a < b) {
            return Err("needs wavelengths in increasing order, each once");
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err("needs finite values");
        }
        Ok(Self { wavelengths_nm, values })
    }

    /// The value at a vacuum wavelength in nanometers.
    fn at(&self, wavelength_nm: f32) -> Result<f32, OutsideTable> {
        let nm = &self.wavelengths_nm;
        let (first_nm, last_nm) = (nm[0], nm[nm.len() - 1]);
        if !(first_nm..=last_nm).contains(&wavelength_nm) {
            return Err(OutsideTable { wavelength_nm, first_nm, last_nm });
        }
        let upper = nm.partition_point(|&at| at < wavelength_nm);
        if nm[upper] == wavelength_nm {
            return Ok(self.values[upper]);
        }
        let share = (wavelength_nm - nm[upper - 1]) / (nm[upper] - nm[upper - 1]);
        Ok(mix(self.values[upper - 1], self.values[upper], share))
    }
}

impl Spectrum {
    /// A table of constants: see `SpectrumTable::new`.
    ///
    /// # Errors
    /// As for `SpectrumTable::new`.
    pub fn table(wavelengths_nm: &[f32], values: &[f32]) -> Result<Self, &'static str> {
        SpectrumTable::new(wavelengths_nm.to_vec(), values.to_vec()).map(Self::Table)
    }

    /// The numbers it was made of, whatever wavelength they belong to, or of a formula two bounds.
    /// All values that it takes lie between the least and the greatest of them.
    pub fn values(&self) -> &[f32] {
        match self {
            Self::Constant(value) => std::slice::from_ref(value),
            Self::Rgb(rgb) => rgb,
            Self::Table(table) => &table.values,
            Self::Formula(formula) => formula.bounds(),
        }
    }

    /// The wavelengths in nanometers between which it is linear, or nearly so, where it changes
    /// within a nanometer.
    pub fn knots_nm(&self) -> Vec<f32> {
        match self {
            Self::Constant(_) | Self::Rgb(_) => Vec::new(),
            Self::Table(table) => table.wavelengths_nm.clone(),
            Self::Formula(formula) => formula.knots_nm(),
        }
    }

    /// Refuses a spectrum that has values outside of a range, or not finite. `field` is what errors
    /// call it.
    ///
    /// # Errors
    /// With the first such value.
    pub fn check(&self, field: &str, range: Range) -> Result<(), Fault> {
        self.values().iter().try_for_each(|value| range.check(field, *value))
    }

    /// Itself times a number.
    #[must_use]
    pub fn scaled(mut self, factor: f32) -> Self {
        match &mut self {
            Self::Constant(value) => *value *= factor,
            Self::Rgb(rgb) => rgb.iter_mut().for_each(|value| *value *= factor),
            Self::Table(table) => table.values.iter_mut().for_each(|value| *value *= factor),
            Self::Formula(formula) => formula.scale(factor),
        }
        self
    }

    /// Its value at a vacuum wavelength in nanometers.
    ///
    /// # Errors
    /// When a table or a formula does not cover it.
    pub fn at(&self, wavelength_nm: f32) -> Result<f32, OutsideTable> {
        match self {
            Self::Constant(constant) => Ok(*constant),
            Self::Rgb(rgb) => Ok(rgb_at(rgb, wavelength_nm)),
            Self::Table(table) => table.at(wavelength_nm),
            Self::Formula(formula) => formula.at(wavelength_nm),
        }
    }

    /// Its values in the columns of a render.
    ///
    /// # Errors
    /// When a table or a formula does not cover a wavelength of the render.
    pub fn sample<const N: usize>(&self, carried: &Carried<N>) -> Result<[f32; N], OutsideTable> {
        let mut values = [0.0; N];
        let columns = values.iter_mut().zip(carried.wavelengths_nm()).enumerate();
        for (column, (value, &wavelength_nm)) in columns {
            *value = match self {
                Self::Rgb(rgb) if carried.is_rgb() => rgb[column % rgb.len()],
                _ => self.at(wavelength_nm)?,
            };
        }
        Ok(values)
    }
}

/// What an RGB triple stands for at one wavelength.
fn rgb_at(rgb: &[f32; 3], wavelength_nm: f32) -> f32 {
    let [red_nm, green_nm, blue_nm] = RGB_WAVELENGTHS_NM;
    if wavelength_nm <= green_nm {
        let share = (wavelength_nm - blue_nm) / (green_nm - blue_nm);
        mix(rgb[2], rgb[1], share.clamp(0.0, 1.0))
    } else {
        let share = (wavelength_nm - green_nm) / (red_nm - green_nm);
        mix(rgb[1], rgb[0], share.clamp(0.0, 1.0))
    }
}

/// `from` for a share of 0, `to` for 1, both exactly; never outside the two.
fn mix(from: f32, to: f32, share: f32) -> f32 {
    from * (1.0 - share) + to * share
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mono(wavelength_nm: f32) -> Carried<1> {
        Carried::at([wavelength_nm])
    }

    #[test]
    fn rgb_meets_its_channels_at_their_wavelengths() {
        let spectrum = Spectrum::Rgb([0.1, 0.4, 0.8]);
        for (wavelength_nm, expected) in
            [(650.0, 0.1), (550.0, 0.4), (450.0, 0.8), (380.0, 0.8), (800.0, 0.1), (500.0, 0.6)]
        {
            let [value] = spectrum.sample(&mono(wavelength_nm)).unwrap();
            assert!((value - expected).abs() < 1e-6, "{wavelength_nm} nm: {value}");
        }
        assert_eq!(spectrum.sample(&Carried::RGB), Ok([0.1, 0.4, 0.8]));
    }

    #[test]
    fn tables_interpolate_inside_and_refuse_outside() {
        let spectrum = Spectrum::table(&[400.0, 500.0, 700.0], &[1.0, 2.0, 4.0]).unwrap();
        assert_eq!(spectrum.sample(&mono(400.0)), Ok([1.0]));
        assert_eq!(spectrum.sample(&mono(600.0)), Ok([3.0]));
        assert_eq!(spectrum.sample(&mono(700.0)), Ok([4.0]));
        let outside = spectrum.sample(&mono(701.0)).unwrap_err();
        assert_eq!((outside.first_nm, outside.last_nm), (400.0, 700.0));
        assert_eq!(spectrum.sample(&Carried::RGB), Ok([3.5, 2.5, 1.5]));
    }

    #[test]
    fn values_outside_of_a_range_are_named() {
        assert_eq!(Spectrum::from(0.5).check("k", Range::UNIT), Ok(()));
        let fault = Spectrum::from([0.1, -0.2, 0.3]).check("k", Range::UNIT).unwrap_err();
        assert_eq!(fault.problem, "-0.2 must be within [0, 1]");
        let table = Spectrum::table(&[400.0, 500.0], &[1.0, 1.5]).unwrap();
        assert!(table.check("k", Range::UNIT).is_err() && table.check("k", Range::ANY).is_ok());
        assert!(Spectrum::Constant(f32::NAN).check("k", Range::ANY).is_err());
    }

    #[test]
    fn tables_say_what_is_wrong_with_them() {
        assert!(Spectrum::table(&[], &[]).is_err());
        assert!(Spectrum::table(&[500.0], &[1.0, 2.0]).is_err());
        assert!(Spectrum::table(&[500.0, 500.0], &[1.0, 2.0]).is_err());
        assert!(Spectrum::table(&[500.0, f32::NAN], &[1.0, 2.0]).is_err());
        assert!(Spectrum::table(&[500.0], &[f32::INFINITY]).is_err());
    }
}
