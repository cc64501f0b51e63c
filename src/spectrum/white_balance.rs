//! The light that a film leaves white.

use std::fmt::{self, Display};

use super::color_space::RgbResponse;
use super::illuminants::{illuminant_name, illuminant_names};
use super::{Curves, OutsideTable, Response, Spectrum, SpectrumTable};
use crate::math::text::excerpt;
use crate::math::{Fault, Range};

/// Most characters of a name that an error shows.
const NAME: usize = 40;

/// A light that a film shows as white.
///
/// ```
/// use sunstone::WhiteBalance;
/// assert_eq!(WhiteBalance::named("d50")?.name(), "D50");
/// assert_eq!(WhiteBalance::named("3200K")?.name(), "3200 K");
/// assert!(WhiteBalance::named("noon").is_err());
/// # Ok::<(), sunstone::particles::Fault>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WhiteBalance {
    name: String,
    spectrum: Spectrum,
}

impl WhiteBalance {
    /// A light by its spectrum, of which errors and metadata say the name.
    ///
    /// # Errors
    /// When it is negative somewhere, or is red, green and blue, which are no spectrum.
    pub fn new(name: impl Into<String>, spectrum: Spectrum) -> Result<Self, Fault> {
        spectrum.check("", Range::NOT_NEGATIVE)?;
        if let Spectrum::Rgb(_) = spectrum {
            let remedy = "name an illuminant, or give a table";
            return Err(Fault::new("", "is red, green and blue and no spectrum", remedy));
        }
        Ok(Self { name: name.into(), spectrum })
    }

    /// An illuminant of the CIE by its name, in capitals or not, or a blackbody by its temperature
    /// in kelvin, as `3200K`.
    ///
    /// # Errors
    /// When it is neither.
    pub fn named(name: &str) -> Result<Self, Fault> {
        if let Some(known) = illuminant_name(name)
            && let Some(spectrum) = Spectrum::illuminant(known)
        {
            return Self::new(known, spectrum);
        }
        let kelvin = name.strip_suffix(['K', 'k']).and_then(|number| number.trim().parse().ok());
        let Some(kelvin) = kelvin else {
            let problem = format!("there is no light that is called `{}`", excerpt(name, NAME));
            let known = illuminant_names().join(", ");
            let remedy = format!("use a temperature as 3200K, a file .spd, or one of {known}");
            return Err(Fault::new("", problem, remedy));
        };
        Self::new(format!("{kelvin} K"), Spectrum::blackbody(kelvin)?)
    }

    /// A light that was measured: see [`SpectrumTable::from_spd`].
    ///
    /// # Errors
    /// As that, and when it is negative somewhere.
    pub fn from_spd(name: impl Into<String>, text: &str) -> Result<Self, Fault> {
        Self::new(name, Spectrum::Table(SpectrumTable::from_spd(text)?))
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The integral of the light with a response over a range, in nanometers.
    ///
    /// # Errors
    /// When the light is not known where the response is not zero.
    pub(super) fn seen_by(&self, response: &Response, range_nm: [f32; 2]) -> Result<f64, Fault> {
        let Some(ends) = response.ends_within(range_nm.map(f64::from)) else { return Ok(0.0) };
        // Ends in single precision may be a little outside of those that the light has in it.
        for nm in ends {
            self.spectrum.at(nm as f32).map_err(|outside| self.is_outside(outside))?;
        }
        let knots: Vec<f64> = self.spectrum.knots_nm().into_iter().map(f64::from).collect();
        let at = |nm: f64| f64::from(self.spectrum.at(nm as f32).unwrap_or(0.0));
        Ok(response.integral(range_nm.map(f64::from), &knots, at))
    }

    fn is_outside(&self, outside: OutsideTable) -> Fault {
        let OutsideTable { wavelength_nm, first_nm, last_nm } = outside;
        let problem = format!(
            "{} is known from {first_nm} to {last_nm} nm, and the film sees {wavelength_nm} nm",
            self.name
        );
        Fault::new("", problem, format!("bound it by range, as {first_nm}:{last_nm}"))
    }

    /// The response of a film of red, green and blue to a range in nanometers that leaves the light
    /// white: with the luminance that it has there.
    ///
    /// # Errors
    /// When the light is not known in all of the range that is visible, or one kind of cones does
    /// not see it.
    pub(super) fn rgb_response(&self, range_nm: [f32; 2]) -> Result<RgbResponse, Fault> {
        let refuse = |problem: &str| {
            let problem = format!("{}: {problem}", self.name);
            Fault::new("", problem, "take another light, or a wider range")
        };
        let curves = Curves::named("xyz").ok_or_else(|| refuse("nobody sees it"))?.responses();
        let mut seen = [0.0; 3];
        for (sum, response) in seen.iter_mut().zip(curves.list()) {
            *sum = self.seen_by(response, range_nm)?;
        }
        RgbResponse::white_in(seen.into()).map_err(refuse)
    }
}

impl Display for WhiteBalance {
    /// Its name.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", self.name)
    }
}
