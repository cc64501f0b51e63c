//! Spectra as color: CIE XYZ, linear sRGB, and whites.
//!
//! X, Y and Z are integrals of a spectrum with the color matching functions of the CIE 1931
//! standard observer (2 degrees), divided by that of y: a flat spectrum of 1 has the luminance
//! Y = 1, whatever unit it has by nanometer. Linear sRGB has the primaries of IEC 61966-2-1, and
//! its white is D65 as the functions see it, so that red, green and blue of D65 with Y = 1 are 1
//! to the last bits (the standard rounds the white to four digits, and the matrix then too).
//!
//! All of this is linear: the same numbers go for each component of a Stokes vector, whose colors
//! have signs.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

use super::Color;
use super::cie::{VISIBLE_NM, color_matching};
use super::illuminants::{d65, d65_nm};

/// Where integrals are summed up, from the first of [`VISIBLE_NM`] to the last: every nanometer.
pub(super) const NODES: usize = 471;

/// x, y of the primaries red, green and blue of IEC 61966-2-1 (ITU-R BT.709).
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// From XYZ to the responses of the three kinds of cones as Bradford has them (K. M. Lam,
/// "Metamerism and colour constancy", 1985; the numbers are those of ICC.1:2022, annex E).
const BRADFORD: DMat3 = DMat3::from_cols_array(&[
    0.8951, -0.7502, 0.0389, // of X
    0.2664, 1.7135, -0.0685, // of Y
    -0.1614, 0.0367, 1.0296, // of Z
]);

/// The white by which colors are taken: a grey reflects all of its wavelengths alike, and a lamp
/// of a grey color shines like it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum White {
    /// Average daylight, the CIE standard illuminant D65, white of sRGB.
    D65,
    /// Equal energy, the same at all wavelengths.
    E,
}

impl White {
    /// All whites.
    pub const ALL: [Self; 2] = [Self::D65, Self::E];

    /// The white of a film where none is named: of channels that stand for colors D65, of others
    /// E, so that greys stay the numbers that they are.
    pub fn of(color: &Color) -> Self {
        match color {
            Color::Rgb | Color::Responses(_) => Self::D65,
            Color::Mono { .. } | Color::Bands(_) => Self::E,
        }
    }

    /// What reports and the command line call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::D65 => "d65",
            Self::E => "e",
        }
    }

    /// From which wavelength to which it is known, in nanometers.
    pub fn known_nm(self) -> [f64; 2] {
        match self {
            Self::D65 => d65_nm(),
            Self::E => [0.0, f64::INFINITY],
        }
    }

    /// Its spectrum at a wavelength in nanometers, in which the luminance is 1; zero where it is
    /// not known.
    pub fn at(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::D65 => d65(wavelength_nm) * STANDARD.d65_scale,
            Self::E => 1.0,
        }
    }
}

/// X, Y and Z of a spectrum, of which values are asked every nanometer.
pub fn xyz(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    sums(spectrum) / STANDARD.flat
}

/// Linear sRGB of X, Y and Z.
pub fn rgb_of_xyz(xyz: DVec3) -> DVec3 {
    STANDARD.rgb_of_xyz * xyz
}

/// X, Y and Z of linear sRGB.
pub fn xyz_of_rgb(rgb: DVec3) -> DVec3 {
    STANDARD.xyz_of_rgb * rgb
}

/// The responses of an RGB film to the wavelengths: signed, by nanometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RgbResponse {
    /// From the color matching functions to red, green and blue.
    matrix: DMat3,
}

impl RgbResponse {
    /// That of linear sRGB: D65 of the luminance 1 gives (1, 1, 1).
    pub fn new() -> Self {
        Self { matrix: STANDARD.rgb_of_xyz * (1.0 / STANDARD.flat) }
    }

    /// That of a film which an illuminant leaves white: with the luminance 1 it gives (1, 1, 1), as
    /// D65 did before. Colors are adapted by Bradford's transform of XYZ: von Kries' scales of the
    /// responses of cones, not of red, green and blue.
    ///
    /// # Errors
    /// When one kind of cones does not see the illuminant: a laser has no white balance.
    pub fn balanced(illuminant: impl Fn(f64) -> f64) -> Result<Self, &'static str> {
        Self::white_in(sums(illuminant))
    }

    /// The same of what X, Y and Z of the illuminant are, in whatever unit.
    ///
    /// # Errors
    /// As [`RgbResponse::balanced`].
    pub fn white_in(seen: DVec3) -> Result<Self, &'static str> {
        let cones = BRADFORD * (seen / seen.y);
        if !(seen.y > 0.0 && cones.is_finite() && cones.min_element() > 0.0) {
            return Err("needs a light that red, green and blue are in");
        }
        let scales = BRADFORD * STANDARD.d65 / cones;
        let adapt = BRADFORD.inverse() * DMat3::from_diagonal(scales) * BRADFORD;
        Ok(Self { matrix: STANDARD.rgb_of_xyz * adapt * (1.0 / STANDARD.flat) })
    }

    /// That of a film which one of the known whites leaves white.
    pub(super) fn by(white: White) -> Self {
        match white {
            White::D65 => Self::new(),
            // Adapted from equal energy, which all cones see.
            White::E => Self::balanced(|_| 1.0).unwrap_or_default(),
        }
    }

    /// Of red, green and blue to a wavelength in nanometers, zero outside of [`VISIBLE_NM`].
    pub fn at(&self, wavelength_nm: f64) -> [f64; 3] {
        (self.matrix * DVec3::from(color_matching(wavelength_nm))).to_array()
    }

    /// Red, green and blue of a spectrum, of which values are asked every nanometer.
    pub fn rgb(&self, spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
        (self.matrix * sums(spectrum)).to_array()
    }
}

impl Default for RgbResponse {
    fn default() -> Self {
        Self::new()
    }
}

/// What everything here is measured by.
struct Standard {
    /// The integral of y over the wavelengths.
    flat: f64,
    /// What makes the tabulated D65 one of luminance 1.
    d65_scale: f64,
    /// X, Y and Z of D65 with Y = 1.
    d65: DVec3,
    rgb_of_xyz: DMat3,
    xyz_of_rgb: DMat3,
}

static STANDARD: LazyLock<Standard> = LazyLock::new(|| {
    let flat = sums(|_| 1.0).y;
    let daylight = sums(d65);
    let white = daylight / daylight.y;
    let primaries = PRIMARIES.map(|[x, y]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y));
    let primaries = DMat3::from_cols(primaries[0], primaries[1], primaries[2]);
    let luminances = primaries.inverse() * white;
    let xyz_of_rgb = primaries * DMat3::from_diagonal(luminances);
    Standard {
        flat,
        d65_scale: flat / daylight.y,
        d65: white,
        rgb_of_xyz: xyz_of_rgb.inverse(),
        xyz_of_rgb,
    }
});

/// Integrals of a spectrum with the color matching functions over nanometers.
fn sums(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    let node = |nm: f64| DVec3::from(color_matching(nm)) * spectrum(nm);
    nodes_nm().map(node).sum()
}

/// The wavelengths of the sums.
pub(super) fn nodes_nm() -> impl Iterator<Item = f64> {
    (0..NODES).map(|node| VISIBLE_NM[0] + node as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
        assert!(near, "{found:?} and not {expected:?}");
    }

    #[test]
    fn daylight_is_white_and_equal_energy_is_where_the_cie_has_it() {
        let daylight = xyz(|nm| White::D65.at(nm));
        // ISO/CIE 11664-2: x = 0.31272, y = 0.32903.
        let [x, y] = [daylight.x, daylight.y].map(|it| it / daylight.element_sum());
        assert!((x - 0.31272).abs() < 3e-5 && (y - 0.32903).abs() < 3e-5, "{x} {y}");
        assert!((daylight.y - 1.0).abs() < 1e-14);
        assert_near(RgbResponse::new().rgb(|nm| White::D65.at(nm)), [1.0; 3], 1e-14);
        // By definition, to what their tables are from it.
        assert_near(xyz(|_| 1.0).to_array(), [1.0; 3], 4e-4);
    }

    #[test]
    fn the_matrix_is_that_of_the_standard_to_its_digits() {
        // IEC 61966-2-1, which starts from a white of four digits.
        let standard = DMat3::from_cols(
            DVec3::new(3.2406, -0.9689, 0.0557),
            DVec3::new(-1.5372, 1.8758, -0.2040),
            DVec3::new(-0.4986, 0.0415, 1.0570),
        );
        for unit in [DVec3::X, DVec3::Y, DVec3::Z] {
            assert_near(rgb_of_xyz(unit).to_array(), (standard * unit).to_array(), 1e-3);
            assert_near(rgb_of_xyz(xyz_of_rgb(unit)).to_array(), unit.to_array(), 1e-14);
        }
        assert!((xyz_of_rgb(DVec3::ONE).y - 1.0).abs() < 1e-14);
        let green = xyz_of_rgb(DVec3::Y);
        assert!((green.y - 0.7152).abs() < 1e-4, "{green}");
    }

    #[test]
    fn balanced_films_are_white_in_their_illuminant_and_as_bright() {
        let tungsten = |nm: f64| (nm / 560.0).powi(4);
        let response = RgbResponse::balanced(tungsten).unwrap();
        let luminance = xyz(tungsten).y;
        assert_near(response.rgb(tungsten), [luminance; 3], 1e-13);
        let [red, .., blue] = RgbResponse::new().rgb(tungsten);
        assert!(red > 1.5 * blue, "{red} {blue}");
        let same = RgbResponse::balanced(d65).unwrap();
        assert_near(same.at(600.0), RgbResponse::new().at(600.0), 1e-16);
        assert_near(RgbResponse::by(White::E).rgb(|_| 1.0), [1.0; 3], 1e-14);
    }

    #[test]
    fn no_light_is_no_white() {
        assert!(RgbResponse::balanced(|_| 0.0).is_err());
        assert!(RgbResponse::balanced(|_| f64::NAN).is_err());
        assert!(RgbResponse::balanced(|_| -1.0).is_err());
        let laser = |nm: f64| if nm == 650.0 { 1.0 } else { 0.0 };
        assert!(RgbResponse::balanced(laser).is_err());
        assert_eq!(RgbResponse::new().at(300.0), [0.0; 3]);
    }

    #[test]
    fn responses_have_signs() {
        let response = RgbResponse::new();
        let [red, green, blue] = response.at(505.0);
        assert!(red < 0.0 && green > 0.0 && blue > 0.0, "{red} {green} {blue}");
    }
}
