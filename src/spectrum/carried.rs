//! What the columns of the transport stand for, which need not be what an image's channels do.

use super::color_space::White;
use super::{Color, RGB_WAVELENGTHS_NM};

/// What light is carried at: `N` columns of every table of paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried<const N: usize> {
    wavelengths_nm: [f32; N],
    kind: Kind,
    /// Under which red, green and blue have the color that they say.
    white: White,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Rgb,
    /// The same wavelengths throughout a render.
    Fixed,
    /// One of the many sets of a render.
    Set,
}

impl Carried<3> {
    /// Red, green and blue, each of which stands for a range of wavelengths; where one is needed,
    /// it is that of [`RGB_WAVELENGTHS_NM`].
    pub const RGB: Self =
        Self { wavelengths_nm: RGB_WAVELENGTHS_NM, kind: Kind::Rgb, white: White::D65 };
}

impl<const N: usize> Carried<N> {
    /// Vacuum wavelengths in nanometers, greater than zero, by a white of equal energy.
    pub const fn at(wavelengths_nm: [f32; N]) -> Self {
        Self { wavelengths_nm, kind: Kind::Fixed, white: White::E }
    }

    /// The same of a render that has other wavelengths in every iteration.
    pub const fn set(wavelengths_nm: [f32; N]) -> Self {
        Self { wavelengths_nm, kind: Kind::Set, white: White::E }
    }

    /// What a film of such channels is rendered with, if those are as many and each is carried by
    /// itself.
    pub fn of(color: &Color) -> Option<Self> {
        let wavelengths_nm: &[f32] = match color {
            Color::Rgb => &RGB_WAVELENGTHS_NM,
            Color::Mono { wavelength_nm } => std::slice::from_ref(wavelength_nm),
            Color::Bands(_) | Color::Responses(_) => return None,
        };
        let wavelengths_nm = wavelengths_nm.try_into().ok()?;
        let kind = if *color == Color::Rgb { Kind::Rgb } else { Kind::Fixed };
        Some(Self { wavelengths_nm, kind, white: White::of(color) })
    }

    /// The same under another white.
    #[must_use]
    pub const fn under(self, white: White) -> Self {
        Self { white, ..self }
    }

    /// Under which red, green and blue have the color that they say.
    pub fn white(&self) -> White {
        self.white
    }

    /// The vacuum wavelength of every column in nanometers.
    pub fn wavelengths_nm(&self) -> &[f32; N] {
        &self.wavelengths_nm
    }

    /// Whether the columns are red, green and blue.
    pub fn is_rgb(&self) -> bool {
        self.kind == Kind::Rgb
    }

    /// Whether there are other wavelengths in other iterations, so that what is the same at these
    /// may differ at those.
    pub fn is_one_of_many(&self) -> bool {
        self.kind == Kind::Set
    }
}
