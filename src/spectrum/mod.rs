//! Floor 1: what a column "per wavelength" stands for.
//!
//! The renderer is generic over the number of columns `N`; this floor says what they carry
//! ([`Carried`]), what the channels of an image stand for ([`Color`]) and take of light
//! ([`Responses`]), and turns what the user writes (RGB triples, tabulated spectra, constants) into
//! `[f32; N]`.

mod bands;
mod carried;
pub mod cie;
pub mod color_space;
mod curves;
mod data;
pub mod density;
mod dispersion;
mod fits;
mod formula;
mod illuminants;
mod indices;
mod lamps;
mod responses;
mod rows;
mod seen;
mod shapes;
mod spd;
mod spectra;
pub mod upsampling;
mod white_balance;

pub use bands::{BANDS_MAX, Band, Bands};
pub use carried::{Beyond, Carried};
pub use color_space::White;
pub use curves::{CHANNELS_MAX, Curves};
pub use dispersion::D_NM;
pub use formula::Formula;
pub use illuminants::illuminant_names;
pub use indices::{index, index_names, metal, metal_names};
pub use lamps::{Line, LineShape};
pub use responses::{Response, Responses, Taken};
pub use seen::rgb_of_bands;
pub use shapes::Shapes;
pub use spectra::{OutsideTable, Role, Spectrum, SpectrumTable, lit};
pub use white_balance::WhiteBalance;

use std::sync::Arc;

/// The vacuum wavelengths, in nanometers, that stand for the red, green and blue channels when a
/// spectral quantity (an index of refraction, say) is reduced to RGB, and for which the channels
/// stand when an index in RGB is asked for its value at one wavelength.
pub const RGB_WAVELENGTHS_NM: [f32; 3] = [650.0, 550.0, 450.0];

/// The vacuum wavelengths, in nanometers, that stand for red, green and blue where light interferes
/// with itself, in films and crystals: with [`RGB_SPREAD`], films of 20 to 1500 nm on glass and
/// metal have the colors, in daylight, that are nearest to those of all wavelengths.
pub const RGB_FRINGES_NM: [f32; 3] = [605.0, 542.0, 455.0];

/// Half of the width of the lines of Lorentz's shape that stand for red, green and blue there, over
/// their wavelengths.
pub const RGB_SPREAD: f32 = 0.025;

/// Least width of a line or a band over its wavelength: wavelengths are numbers of single
/// precision, of which 100 to 200 are in so much, and rounding takes a share of what is narrower.
pub const RELATIVE_WIDTH_MIN: f64 = 2e-5;

/// What the channels of an image stand for.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    /// Three channels, red, green and blue, in linear sRGB primaries.
    Rgb,
    /// One wavelength.
    Mono {
        /// Vacuum wavelength in nanometers.
        wavelength_nm: f32,
    },
    /// Bands of wavelengths, over each of which light is averaged: per nanometer.
    Bands(Arc<Bands>),
    /// Channels with responses of their own: each is the integral of radiance times its response.
    Responses(Arc<Curves>),
}

impl std::fmt::Display for Color {
    /// `RGB`, or the wavelength, or the bands in words.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Rgb => write!(f, "RGB"),
            Self::Mono { wavelength_nm } => write!(f, "{wavelength_nm} nm"),
            Self::Bands(bands) => write!(f, "{bands}"),
            Self::Responses(curves) => write!(f, "{curves}"),
        }
    }
}

impl Color {
    /// Number of channels.
    pub fn channels(&self) -> usize {
        match self {
            Color::Rgb => 3,
            Color::Mono { .. } => 1,
            Color::Bands(bands) => bands.list().len(),
            Color::Responses(curves) => curves.channels().len(),
        }
    }

    /// What the channels are called: `R`, `G` and `B`, or the wavelength, or the names of bands or
    /// responses.
    pub fn channel_names(&self) -> Vec<String> {
        match self {
            Color::Rgb => ["R", "G", "B"].map(String::from).to_vec(),
            Color::Mono { .. } => vec![self.to_string()],
            Color::Bands(bands) => bands.list().iter().map(|band| band.name.clone()).collect(),
            Color::Responses(curves) => curves.channels().map(String::from).collect(),
        }
    }

    /// The vacuum wavelength in nanometers that a channel stands for: of a band its center, of a
    /// response its mean wavelength. None of red, green and blue, which are colors.
    pub fn wavelength_of(&self, channel: usize) -> Option<f32> {
        match self {
            Color::Rgb => None,
            Color::Mono { wavelength_nm } => Some(*wavelength_nm),
            Color::Bands(bands) => bands.list().get(channel).map(|band| band.center_nm),
            Color::Responses(curves) => curves.center_nm(channel),
        }
    }

    /// Whether the channels are not those of a picture: bands or responses, any number of them.
    pub fn is_of_many(&self) -> bool {
        match self {
            Color::Rgb | Color::Mono { .. } => false,
            Color::Bands(_) | Color::Responses(_) => true,
        }
    }

    /// How the channels of two images with bands or responses measure other light, in words; none
    /// if they do not, whatever they are called, or neither has any.
    pub fn difference(&self, second: &Self) -> Option<String> {
        match (self, second) {
            (Color::Bands(first), Color::Bands(second)) => first.difference(second),
            (Color::Responses(first), Color::Responses(second)) => first.difference(second),
            (Color::Bands(_) | Color::Responses(_), _)
            | (_, Color::Bands(_) | Color::Responses(_)) => {
                let [first, second] = [self, second].map(Color::kind);
                Some(format!("the first has {first} and the second {second}"))
            }
            (Color::Rgb | Color::Mono { .. }, Color::Rgb | Color::Mono { .. }) => None,
        }
    }

    /// What the channels are, in a word.
    fn kind(&self) -> &'static str {
        match self {
            Color::Rgb => "red, green and blue",
            Color::Mono { .. } => "one wavelength",
            Color::Bands(_) => "bands",
            Color::Responses(_) => "responses",
        }
    }

    /// What one of its channels is called in words.
    pub fn channel_name(&self, channel: usize) -> String {
        match self {
            Color::Rgb => ["red", "green", "blue"][channel].to_owned(),
            Color::Mono { .. } | Color::Bands(_) | Color::Responses(_) => {
                self.channel_names().swap_remove(channel)
            }
        }
    }

    /// The channel that has a wavelength in nanometers, and the wavelength that it stands for: the
    /// center of its band, or its own. None of responses has one, nor of red, green and blue.
    pub fn channel_at(&self, wavelength_nm: f32) -> Option<(usize, f32)> {
        match self {
            Color::Rgb | Color::Responses(_) => None,
            Color::Mono { wavelength_nm: own } => (*own == wavelength_nm).then_some((0, *own)),
            Color::Bands(bands) => {
                bands.index_at(wavelength_nm).map(|index| (index, bands.list()[index].center_nm))
            }
        }
    }
}
