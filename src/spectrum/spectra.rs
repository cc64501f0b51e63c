//! Spectral quantities as the user writes them, and their values at the wavelengths of a render.

use super::color_space::White;
use super::upsampling::Smooth;
use super::{Carried, Formula, RGB_FRINGES_NM, RGB_SPREAD, RGB_WAVELENGTHS_NM};
use crate::math::{Fault, Range};

/// A quantity that may depend on wavelength: a reflectance, an index of refraction, a radiance.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f32),
    /// Linear red, green and blue in sRGB primaries. At a wavelength: what the [`Role`] says.
    Rgb([f32; 3]),
    /// Values at wavelengths, interpolated linearly between them and undefined outside.
    Table(SpectrumTable),
    /// A formula of the wavelength, undefined outside of its range.
    Formula(Formula),
}

/// What a quantity is, and so what red, green and blue of it say of a wavelength. Numbers and
/// tables say the same in all roles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A share of light, within [0, 1]: a smooth spectrum within [0, 1] that has this color under
    /// the white ([`Smooth::reflectance`]).
    Reflectance,
    /// Light: a smooth spectrum times that of the white, which together have this color
    /// ([`Smooth::coefficient`]).
    Emission,
    /// Anything else that is not negative: a smooth spectrum of this color under the white
    /// ([`Smooth::coefficient`]).
    Coefficient,
    /// What no color is known for, an index of refraction say: linear between the values at the
    /// channels' [`RGB_WAVELENGTHS_NM`], constant beyond the outer two.
    Index,
    /// A length in nanometers, of which wavelengths become the unit: in RGB those of
    /// [`RGB_FRINGES_NM`].
    Waves,
    /// Half of the width of what a column stands for over its wavelength: [`RGB_SPREAD`] times what
    /// is said in RGB, and 0 for light of one wavelength.
    Spread,
}

/// A tabulated spectrum: see `SpectrumTable::new`.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumTable {
    wavelengths_nm: Vec<f32>,
    /// As many, and then red, green and blue if it has a color of its own.
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

    /// The same with a color of its own, linear sRGB, which renders in RGB take in place of the
    /// values at the wavelengths that stand for the channels.
    #[must_use]
    pub fn seen_as(mut self, rgb: [f32; 3]) -> Self {
        self.values.truncate(self.wavelengths_nm.len());
        self.values.extend(rgb);
        self
    }

    /// Its own color, if it has one.
    pub fn color(&self) -> Option<[f32; 3]> {
        self.values[self.wavelengths_nm.len()..].try_into().ok()
    }

    /// The value at a vacuum wavelength in nanometers between its ends.
    fn at(&self, wavelength_nm: f32) -> f32 {
        let nm = &self.wavelengths_nm;
        let upper = nm.partition_point(|&at| at < wavelength_nm);
        if nm[upper] == wavelength_nm {
            return self.values[upper];
        }
        let share = (wavelength_nm - nm[upper - 1]) / (nm[upper] - nm[upper - 1]);
        mix(self.values[upper - 1], self.values[upper], share)
    }

    fn ends_nm(&self) -> [f32; 2] {
        [self.wavelengths_nm[0], self.wavelengths_nm[self.wavelengths_nm.len() - 1]]
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

    /// The numbers it was made of, whatever wavelength or channel they belong to, or of a formula
    /// two bounds.
    /// All values that it takes lie between the least and the greatest of them.
    pub fn values(&self) -> &[f32] {
        match self {
            Self::Constant(value) => std::slice::from_ref(value),
            Self::Rgb(rgb) => rgb,
            Self::Table(table) => &table.values,
            Self::Formula(formula) => formula.bounds(),
        }
    }

    /// Red, green and blue, if it is that or a number.
    pub fn rgb(&self) -> Option<[f32; 3]> {
        match self {
            Self::Constant(value) => Some([*value; 3]),
            Self::Rgb(rgb) => Some(*rgb),
            Self::Table(_) | Self::Formula(_) => None,
        }
    }

    /// Whether it is the same at all wavelengths, whatever they are.
    pub fn is_flat(&self) -> bool {
        let values = self.values();
        values.iter().all(|value| *value == values[0])
    }

    /// The first and the last wavelength in nanometers of what it says something of; none if it
    /// says something of all.
    pub fn ends_nm(&self) -> Option<[f32; 2]> {
        match self {
            Self::Constant(_) | Self::Rgb(_) => None,
            Self::Table(table) => Some(table.ends_nm()),
            Self::Formula(formula) => Some(formula.ends_nm()),
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

    /// Its value at a vacuum wavelength in nanometers; of red, green and blue, in the role of an
    /// index.
    ///
    /// # Errors
    /// When a table or a formula does not cover it.
    pub fn at(&self, wavelength_nm: f32) -> Result<f32, OutsideTable> {
        let [value] = self.sample(&Carried::at([wavelength_nm]), Role::Index)?;
        Ok(value)
    }

    /// Its values in the columns of a render, as a quantity of a role; none is a negative zero, by
    /// which paths say something else.
    ///
    /// # Errors
    /// When a table or a formula does not cover a wavelength of the render, unless what is at its
    /// ends is held, or the white is not known there.
    pub fn sample<const N: usize>(
        &self,
        carried: &Carried<N>,
        role: Role,
    ) -> Result<[f32; N], OutsideTable> {
        let values = match self {
            Self::Constant(constant) => [*constant; N],
            Self::Rgb(rgb) if carried.is_rgb() => {
                std::array::from_fn(|column| rgb[column % rgb.len()])
            }
            Self::Rgb(rgb) => rgb_at(*rgb, carried.wavelengths_nm(), role, carried.white())?,
            Self::Table(table) if carried.is_rgb() && table.color().is_some() => {
                let rgb = table.color().unwrap_or_default();
                std::array::from_fn(|column| rgb[column % rgb.len()])
            }
            Self::Table(table) => carried.within(table.ends_nm())?.map(|nm| table.at(nm)),
            Self::Formula(formula) => carried.within(formula.ends_nm())?.map(|nm| formula.at(nm)),
        };
        let values = values.map(|value| value + 0.0);
        Ok(match role {
            Role::Waves if carried.is_rgb() => {
                std::array::from_fn(|n| values[n] / RGB_FRINGES_NM[n % RGB_FRINGES_NM.len()])
            }
            Role::Waves => std::array::from_fn(|n| values[n] / carried.wavelengths_nm()[n]),
            Role::Spread if carried.is_rgb() => values.map(|value| value * RGB_SPREAD),
            Role::Spread => [0.0; N],
            Role::Reflectance | Role::Emission | Role::Coefficient | Role::Index => values,
        })
    }
}

/// What an RGB triple stands for at wavelengths in nanometers.
fn rgb_at<const N: usize>(
    rgb: [f32; 3],
    wavelengths_nm: &[f32; N],
    role: Role,
    white: White,
) -> Result<[f32; N], OutsideTable> {
    Ok(match role {
        Role::Reflectance => Smooth::reflectance(rgb, white).values(wavelengths_nm),
        Role::Coefficient => Smooth::coefficient(rgb, white).values(wavelengths_nm),
        Role::Emission => {
            let smooth = Smooth::coefficient(rgb, white);
            let mut values = [0.0; N];
            for (value, &nm) in values.iter_mut().zip(wavelengths_nm) {
                *value = (smooth.at(f64::from(nm)) * of_white(white, nm)?) as f32;
            }
            values
        }
        Role::Index | Role::Waves | Role::Spread => wavelengths_nm.map(|nm| linear(rgb, nm)),
    })
}

/// What [`Role::Emission`] says of a color of which [`Role::Coefficient`] says this, where it is
/// known that the white is.
pub fn lit<const N: usize>(mut values: [f32; N], carried: &Carried<N>) -> [f32; N] {
    for (value, light) in values.iter_mut().zip(carried.light()) {
        *value = (f64::from(*value) * light) as f32;
    }
    values
}

/// The white at a wavelength in nanometers.
fn of_white(white: White, wavelength_nm: f32) -> Result<f64, OutsideTable> {
    let [first_nm, last_nm] = white.known_nm().map(|nm| nm as f32);
    if !(first_nm..=last_nm).contains(&wavelength_nm) {
        return Err(OutsideTable { wavelength_nm, first_nm, last_nm });
    }
    Ok(white.at(f64::from(wavelength_nm)))
}

/// Between the values at the wavelengths that stand for red, green and blue.
fn linear(rgb: [f32; 3], wavelength_nm: f32) -> f32 {
    let [red_nm, green_nm, blue_nm] = RGB_WAVELENGTHS_NM;
    if wavelength_nm <= green_nm {
        let share = (wavelength_nm - blue_nm) / (green_nm - blue_nm);
        mix(rgb[2], rgb[1], share.clamp(0.0, 1.0))
    } else {
        let share = (wavelength_nm - green_nm) / (red_nm - green_nm);
        mix(rgb[1], rgb[0], share.clamp(0.0, 1.0))
    }
}

/// `from` for a share of 0, `to` for 1, both exactly, and what is the same for both.
fn mix(from: f32, to: f32, share: f32) -> f32 {
    if from == to {
        return from;
    }
    from * (1.0 - share) + to * share
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROLES: [Role; 4] = [Role::Reflectance, Role::Emission, Role::Coefficient, Role::Index];

    fn mono(wavelength_nm: f32) -> Carried<1> {
        Carried::at([wavelength_nm])
    }

    #[test]
    fn indices_meet_their_channels_at_their_wavelengths() {
        let spectrum = Spectrum::Rgb([0.1, 0.4, 0.8]);
        for (wavelength_nm, expected) in
            [(650.0, 0.1), (550.0, 0.4), (450.0, 0.8), (380.0, 0.8), (800.0, 0.1), (500.0, 0.6)]
        {
            let [value] = spectrum.sample(&mono(wavelength_nm), Role::Index).unwrap();
            assert!((value - expected).abs() < 1e-6, "{wavelength_nm} nm: {value}");
        }
    }

    #[test]
    fn in_rgb_colors_are_themselves_in_all_roles_by_any_white() {
        for (role, white) in ROLES.into_iter().flat_map(|role| White::ALL.map(|it| (role, it))) {
            let asked = Carried::RGB.under(white);
            assert_eq!(Spectrum::Rgb([0.1, 7.0, 0.8]).sample(&asked, role), Ok([0.1, 7.0, 0.8]));
        }
    }

    #[test]
    fn at_a_wavelength_numbers_are_flat_and_so_are_greys_by_equal_energy() {
        for role in ROLES {
            for grey in [0.0, 1e-38, 0.007, 0.18, 0.5, 0.73, 0.999_999_9, 1.0] {
                for nm in [1.0, 360.0, 447.3, 550.0, 830.0, 1e6] {
                    let sample = |it: Spectrum| it.sample(&mono(nm), role);
                    assert_eq!(sample(Spectrum::Constant(grey)), Ok([grey]));
                    assert_eq!(sample(Spectrum::Rgb([grey; 3])), Ok([grey]), "{role:?} at {nm}");
                }
            }
        }
        let bright = Spectrum::Rgb([3e38; 3]).sample(&mono(500.0), Role::Emission);
        assert_eq!(bright, Ok([3e38]));
    }

    #[test]
    fn lamps_shine_like_the_white_and_where_that_is_known() {
        let lamp = Spectrum::Rgb([2.0; 3]);
        let by_d65 = |nm: f32| {
            let asked = mono(nm).under(White::D65);
            lamp.sample(&asked, Role::Emission).map(|[value]| value)
        };
        let ratio = by_d65(450.0).unwrap() / by_d65(650.0).unwrap();
        // ISO/CIE 11664-2.
        assert!((ratio - 117.008 / 80.0268).abs() < 1e-4, "{ratio}");
        assert!((by_d65(560.0).unwrap() - 2.0).abs() < 0.05);
        let outside = by_d65(900.0).unwrap_err();
        assert_eq!((outside.first_nm, outside.last_nm), (300.0, 830.0));
        let asked = mono(900.0).under(White::D65);
        assert_eq!(lamp.sample(&asked, Role::Coefficient), Ok([2.0]));
    }

    #[test]
    fn colors_have_more_of_what_they_are_and_stay_in_their_range() {
        let red = Spectrum::Rgb([0.9, 0.1, 0.05]);
        let at = |nm: f32, role| red.sample(&mono(nm), role).unwrap()[0];
        for role in [Role::Reflectance, Role::Emission, Role::Coefficient] {
            assert!(at(650.0, role) > 0.7 && at(540.0, role) < 0.2 && at(450.0, role) < 0.1);
        }
        for nm in (360..=830).map(|nm| nm as f32) {
            assert!((0.0..=1.0).contains(&at(nm, Role::Reflectance)));
        }
    }

    #[test]
    fn tables_interpolate_inside_and_refuse_outside() {
        let spectrum = Spectrum::table(&[400.0, 500.0, 700.0], &[1.0, 2.0, 4.0]).unwrap();
        assert_eq!(spectrum.sample(&mono(400.0), Role::Index), Ok([1.0]));
        assert_eq!(spectrum.sample(&mono(600.0), Role::Index), Ok([3.0]));
        assert_eq!(spectrum.sample(&mono(700.0), Role::Index), Ok([4.0]));
        let outside = spectrum.sample(&mono(701.0), Role::Index).unwrap_err();
        assert_eq!((outside.first_nm, outside.last_nm), (400.0, 700.0));
        assert_eq!(spectrum.sample(&Carried::RGB, Role::Index), Ok([3.5, 2.5, 1.5]));
    }

    #[test]
    fn tables_with_a_color_have_it_in_rgb_alone() {
        let table = SpectrumTable::new(vec![400.0, 700.0], vec![1.0, 1.0]).unwrap();
        let seen = Spectrum::Table(table.clone().seen_as([0.5, 0.25, 2.0]));
        assert_eq!(seen.sample(&Carried::RGB, Role::Index), Ok([0.5, 0.25, 2.0]));
        assert_eq!(seen.sample(&mono(500.0), Role::Index), Ok([1.0]));
        assert_eq!(seen.ends_nm(), Some([400.0, 700.0]));
        assert!(seen.check("k", Range::UNIT).is_err(), "its color is checked, too");
        let twice = seen.clone().scaled(2.0);
        assert_eq!(twice.sample(&Carried::RGB, Role::Index), Ok([1.0, 0.5, 4.0]));
        assert_eq!(table.color(), None);
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
