//! Color on the command line: what the channels stand for, and what light is carried at.

use std::str::FromStr;
use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::CliError;
use super::args::LIGHT;
use super::white::WhiteName;
use crate::render::Spectral;
use crate::render::settings::{WAVELENGTH_NM, check_color};
use crate::render::spectral::RANGE_NM;
use crate::spectrum::{Bands, Color};

/// Color modes by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColorName {
    /// Red, green and blue, linear, sRGB primaries
    Rgb,
    /// One wavelength; see --wavelength
    Mono,
    /// All wavelengths of a --range, several at a time; the channels are --bands
    Spectral,
}

impl ColorName {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rgb, Self::Mono, Self::Spectral];

    /// What the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgb => "rgb",
            Self::Mono => "mono",
            Self::Spectral => "spectral",
        }
    }
}

/// What the channels stand for, as typed.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = LIGHT)]
pub struct ColorArguments {
    /// What light is made of, and what the channels stand for
    #[arg(long, value_enum, default_value = "rgb")]
    pub color: ColorName,
    /// Wavelength of --color mono, in nanometers [default: 550]
    #[arg(long, value_name = "NM")]
    pub wavelength: Option<f32>,
    /// White under which [r, g, b] of materials and lights have the color that they say, at
    /// wavelengths: they stand for smooth spectra, and a lamp's is multiplied by this [default: e,
    /// but for a film of RGB]
    #[arg(long, value_enum, ignore_case = true, value_name = "WHITE")]
    pub rgb_white: Option<WhiteName>,
    /// Wavelengths that --color spectral carries together, others in every iteration: 4 or 8
    /// [default: 8]
    #[arg(long, value_name = "N")]
    pub wavelengths: Option<u32>,
    /// First and last wavelength of --color spectral, in nanometers [default: those of the bands]
    #[arg(long, value_name = "FROM:TO")]
    pub range: Option<RangeText>,
    /// The channels of --color spectral: centers of the first and the last in nanometers, and how
    /// many; each is the mean over its width, which is the distance of the centers
    #[arg(long, value_name = "FIRST:LAST:COUNT")]
    pub bands: Option<BandsText>,
}

/// Two numbers with a colon between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeText([f32; 2]);

/// Two numbers and a count, with colons between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandsText([f32; 2], usize);

impl FromStr for RangeText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f32>> = text.split(':').map(|it| it.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[first, last]) => Ok(Self([first, last])),
            _ => Err("it is two wavelengths, as in 380:780".to_owned()),
        }
    }
}

impl FromStr for BandsText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let of = |text: &str| {
            let (ends, count) = text.rsplit_once(':')?;
            let RangeText(ends) = ends.parse().ok()?;
            Some(Self(ends, count.trim().parse().ok()?))
        };
        let rule = "it is the centers of the first and the last band and how many there are, as in \
                    400:700:31";
        of(text).ok_or_else(|| rule.to_owned())
    }
}

/// What the channels stand for, and what light is carried at.
pub(super) fn color(arguments: &ColorArguments) -> Result<(Color, Option<Spectral>), CliError> {
    let ColorArguments { color, wavelength, wavelengths, range, bands, rgb_white: _ } = arguments;
    let usage = |text: &str| Err(CliError::Usage(text.to_owned()));
    let typed = [
        ("--wavelengths", wavelengths.is_some()),
        ("--range", range.is_some()),
        ("--bands", bands.is_some()),
    ];
    let typed = typed.into_iter().find(|(_, is)| *is);
    match (color, *wavelength, typed) {
        (ColorName::Spectral, None, _) => spectral(arguments),
        (ColorName::Spectral, Some(_), _) => {
            usage("--wavelength goes with --color mono; --color spectral has a --range")
        }
        (ColorName::Rgb | ColorName::Mono, _, Some((name, _))) => {
            usage(&format!("{name} goes with --color spectral"))
        }
        (ColorName::Rgb, None, None) => Ok((Color::Rgb, None)),
        (ColorName::Rgb, Some(_), None) => {
            usage("--wavelength goes with --color mono; RGB has three wavelengths of its own")
        }
        (ColorName::Mono, wavelength, None) => {
            let color = Color::Mono { wavelength_nm: wavelength.unwrap_or(WAVELENGTH_NM) };
            check_color(&color)?;
            Ok((color, None))
        }
    }
}

/// The same for programs, which say in words of their own what is wrong.
///
/// # Errors
/// The text of the command line, with its options.
pub fn of_arguments(arguments: &ColorArguments) -> Result<(Color, Option<Spectral>), String> {
    color(arguments).map_err(|error| {
        if let CliError::Usage(text) = &error {
            return text.clone();
        }
        error.to_string()
    })
}

fn spectral(arguments: &ColorArguments) -> Result<(Color, Option<Spectral>), CliError> {
    let (color, ends) = match arguments.bands {
        Some(bands) => of_bands(bands)?,
        None => (Color::Rgb, RANGE_NM),
    };
    let range_nm = arguments.range.map_or(ends, |RangeText(range)| range);
    let wavelengths = arguments.wavelengths.unwrap_or(Spectral::default().wavelengths);
    Ok((color, Some(Spectral { wavelengths, range_nm })))
}

fn of_bands(BandsText([first, last], count): BandsText) -> Result<(Color, [f32; 2]), CliError> {
    let bands = Bands::evenly(first, last, count)
        .map_err(|fault| CliError::Usage(format!("--bands {}", fault.problem)))?;
    let list = bands.list();
    let ends = [list[0].ends_nm()[0] as f32, list[list.len() - 1].ends_nm()[1] as f32];
    Ok((Color::Bands(Arc::new(bands)), ends))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_are_typed() {
        assert_eq!(ColorName::value_variants(), ColorName::ALL);
        for name in ColorName::ALL {
            assert_eq!(ColorName::from_str(name.name(), false), Ok(name));
        }
    }
}
