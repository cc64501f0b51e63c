//! What the columns of the transport stand for, which need not be what an image's channels do.

use super::color_space::White;
use super::{Color, OutsideTable, RGB_WAVELENGTHS_NM};

/// What light is carried at: `N` columns of every table of paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried<const N: usize> {
    wavelengths_nm: [f32; N],
    kind: Kind,
    /// Under which red, green and blue have the color that they say.
    white: White,
    /// What that is in every column; zero where it is not known.
    light: [f64; N],
    beyond: Beyond,
}

/// What a table or a formula says of wavelengths beyond its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Beyond {
    /// Nothing: a render that asks for them is refused.
    #[default]
    Refused,
    /// What it says of the end.
    Held,
}

impl Beyond {
    /// Where what is known between two wavelengths in nanometers is read for another.
    ///
    /// # Errors
    /// When that is not between them, and what is at the ends is not held.
    pub fn place(
        self,
        wavelength_nm: f32,
        [first_nm, last_nm]: [f32; 2],
    ) -> Result<f32, OutsideTable> {
        if (first_nm..=last_nm).contains(&wavelength_nm) {
            return Ok(wavelength_nm);
        }
        match self {
            Self::Refused => Err(OutsideTable { wavelength_nm, first_nm, last_nm }),
            Self::Held => Ok(wavelength_nm.clamp(first_nm, last_nm)),
        }
    }
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
    pub const RGB: Self = Self {
        wavelengths_nm: RGB_WAVELENGTHS_NM,
        kind: Kind::Rgb,
        white: White::D65,
        light: [1.0; 3],
        beyond: Beyond::Refused,
    };
}

impl<const N: usize> Carried<N> {
    /// Vacuum wavelengths in nanometers, greater than zero, by a white of equal energy.
    pub const fn at(wavelengths_nm: [f32; N]) -> Self {
        Self::of_kind(wavelengths_nm, Kind::Fixed)
    }

    /// The same of a render that has other wavelengths in every iteration.
    pub const fn set(wavelengths_nm: [f32; N]) -> Self {
        Self::of_kind(wavelengths_nm, Kind::Set)
    }

    const fn of_kind(wavelengths_nm: [f32; N], kind: Kind) -> Self {
        let (white, light, beyond) = (White::E, [1.0; N], Beyond::Refused);
        Self { wavelengths_nm, kind, white, light, beyond }
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
        Some(Self::of_kind(wavelengths_nm, kind).under(White::of(color)))
    }

    /// The same under another white.
    #[must_use]
    pub fn under(self, white: White) -> Self {
        let light = match self.is_rgb() {
            true => [1.0; N],
            false => self.wavelengths_nm.map(|nm| white.at(f64::from(nm))),
        };
        Self { white, light, ..self }
    }

    /// Under which red, green and blue have the color that they say.
    pub fn white(&self) -> White {
        self.white
    }

    /// What the white is in every column: 1 of red, green and blue, and zero where it is not known.
    pub fn light(&self) -> &[f64; N] {
        &self.light
    }

    /// The same with spectra that are known so beyond their ends.
    #[must_use]
    pub const fn beyond(self, beyond: Beyond) -> Self {
        Self { beyond, ..self }
    }

    /// What spectra say beyond their ends.
    pub fn held_beyond(&self) -> Beyond {
        self.beyond
    }

    /// Where what is known between two wavelengths in nanometers is read for every column.
    ///
    /// # Errors
    /// When one is not between them, and what is at the ends is not held.
    pub fn within(&self, ends_nm: [f32; 2]) -> Result<[f32; N], OutsideTable> {
        let mut places = self.wavelengths_nm;
        for place in &mut places {
            *place = self.beyond.place(*place, ends_nm)?;
        }
        Ok(places)
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
