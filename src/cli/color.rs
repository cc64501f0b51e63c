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
    /// Hold what tables and formulas of materials, media and lights say at their ends where the
    /// wavelengths of the render reach beyond, instead of refusing it; a warning and the image's
    /// metadata say of which
    #[arg(long)]
    pub hold_spectra: bool,
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
    let ColorArguments { color, wavelength, wavelengths, range, bands, .. } = arguments;
    let usage = |text: &str| Err(CliError::Usage(text.to_owned()));
    let typed = [
        ("--wavelengths", wavelengths.is_some()),
        ("--range", range.is_some()),
        ("--bands", bands.is_some()),
    ];
    if *color == ColorName::Spectral {
        if wavelength.is_some() {
            return usage("--wavelength goes with --color mono; --color spectral has a --range");
        }
        let (color, ends) = match bands {
            Some(bands) => of_bands(*bands)?,
            None => (Color::Rgb, RANGE_NM),
        };
        let range_nm = range.map_or(ends, |RangeText(range)| range);
        let default = Spectral::default();
        let wavelengths = wavelengths.unwrap_or(default.wavelengths);
        return Ok((color, Some(Spectral { wavelengths, range_nm })));
    }
    match typed.into_iter().find(|(_, is)| *is) {
        Some((name, _)) => usage(&format!("{name} goes with --color spectral")),
        None => Ok((plain(*color, *wavelength)?, None)),
    }
}

fn of_bands(BandsText([first, last], count): BandsText) -> Result<(Color, [f32; 2]), CliError> {
    let bands = Bands::evenly(first, last, count)
        .map_err(|fault| CliError::Usage(format!("--bands {}", fault.problem)))?;
    let list = bands.list();
    let ends = [list[0].ends_nm()[0] as f32, list[list.len() - 1].ends_nm()[1] as f32];
    Ok((Color::Bands(Arc::new(bands)), ends))
}

/// What the channels stand for where they are what light is carried at.
pub(super) fn plain(name: ColorName, wavelength: Option<f32>) -> Result<Color, CliError> {
    match (name, wavelength) {
        (ColorName::Rgb, None) => Ok(Color::Rgb),
        (ColorName::Rgb, Some(_)) => Err(CliError::Usage(
            "--wavelength goes with --color mono; RGB has three wavelengths of its own".into(),
        )),
        (ColorName::Mono, wavelength) => {
            let color = Color::Mono { wavelength_nm: wavelength.unwrap_or(WAVELENGTH_NM) };
            check_color(&color)?;
            Ok(color)
        }
        (ColorName::Spectral, _) => {
            Err(CliError::Usage("--color spectral is not measured: choose rgb or mono".to_owned()))
        }
    }
}
