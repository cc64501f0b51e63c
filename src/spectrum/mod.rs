//! Floor 1: what a column "per wavelength" stands for.
//!
//! The renderer is generic over the number of wavelengths `N`; this floor says which they are and
//! turns what the user writes (RGB triples, tabulated spectra, constants) into `[f32; N]`, and
//! spectra into colors.

pub mod cie;
pub mod color_space;
mod daylight;
mod metals;
mod spectra;
pub mod upsampling;

pub use color_space::White;
pub use metals::{metal, metal_names};
pub use spectra::{Asked, OutsideTable, Role, Spectrum, SpectrumTable};

/// The vacuum wavelengths, in nanometers, that stand for the red, green and blue channels when a
/// spectral quantity (an index of refraction, say) is reduced to RGB, and for which the channels
/// stand when an index in RGB is asked for its value at one wavelength.
pub const RGB_WAVELENGTHS_NM: [f32; 3] = [650.0, 550.0, 450.0];

/// Which wavelengths a render carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Color {
    /// Three channels, red, green and blue, in linear sRGB primaries.
    Rgb,
    /// One wavelength.
    Mono {
        /// Vacuum wavelength in nanometers.
        wavelength_nm: f32,
    },
}

impl std::fmt::Display for Color {
    /// `RGB`, or the wavelength.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Rgb => write!(f, "RGB"),
            Self::Mono { wavelength_nm } => write!(f, "{wavelength_nm} nm"),
        }
    }
}

impl Color {
    /// Number of channels, the `N` of the renderer's tables.
    pub fn channels(self) -> usize {
        match self {
            Color::Rgb => 3,
            Color::Mono { .. } => 1,
        }
    }
}
