//! Color on the command line: what the channels stand for, and what light is carried at.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use clap::{Args, ValueEnum};

use super::CliError;
use super::args::LIGHT;
use super::white::WhiteName;
use crate::image::{extension, read_bytes};
use crate::math::Fault;
use crate::math::text::{excerpt, printable};
use crate::render::settings::{WAVELENGTH_NM, check_color};
use crate::render::spectral::RANGE_NM;
use crate::render::{Options, Spectral};
use crate::spectrum::{Bands, Color, Curves, WhiteBalance};

/// Color modes by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColorName {
    /// Red, green and blue, linear, sRGB primaries
    Rgb,
    /// One wavelength; see --wavelength
    Mono,
    /// All wavelengths of a --range, several at a time; the channels are --bands or --responses, or
    /// red, green and blue as the CIE 1931 observer sees them
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
    /// Hold what tables and formulas of materials, media and lights say at their ends where the
    /// wavelengths of the render reach beyond, instead of refusing it; a warning and the image's
    /// metadata say of which
    #[arg(long)]
    pub hold_spectra: bool,
    /// Wavelengths that --color spectral carries together, others in every iteration: 4 or 8
    /// [default: 8]
    #[arg(long, value_name = "N")]
    pub wavelengths: Option<u32>,
    /// First and last wavelength of --color spectral, in nanometers [default: those of the bands or
    /// responses, or 380:780]
    #[arg(long, value_name = "FROM:TO")]
    pub range: Option<RangeText>,
    /// Bands as the channels of --color spectral, each the mean over its width: centers of the
    /// first and the last in nanometers and how many (400:700:31), as wide as they are apart; or
    /// centers and widths (450x20,red=650x30); or a file .csv with a line of names,
    /// name,center_nm,width_nm
    #[arg(long, value_name = "BANDS", conflicts_with = "responses")]
    pub bands: Option<BandsText>,
    /// Responses as the channels of --color spectral: xyz, luminance, nikon-d5100, sigma-sd1, or a
    /// file .csv with a line of names, as wavelength_nm,red,green,blue, linear between its lines
    /// and zero outside
    #[arg(long, value_name = "NAME")]
    pub responses: Option<String>,
    /// Responses as their numbers are: channels are integrals of radiance times them; otherwise
    /// each is normalized to 1 for a spectrum of radiance 1 per nm
    #[arg(long)]
    pub raw_response: bool,
    /// A light that the film shows as white: an illuminant (D50, F11 ...), a temperature (3200K) or
    /// a file .spd; of RGB by Bradford's transform, of responses by making each 1 for it
    #[arg(long, value_name = "LIGHT")]
    pub white_balance: Option<String>,
}

impl ColorArguments {
    /// The files that are read, if any.
    pub fn files(&mut self) -> impl Iterator<Item = &mut String> {
        let bands = self.bands.iter_mut().filter_map(|bands| match bands {
            BandsText::File(path) => Some(path),
            BandsText::Even(..) | BandsText::List(_) => None,
        });
        let named = self.responses.iter_mut().filter(|name| is_file(name, CURVES));
        bands.chain(named).chain(self.white_balance.iter_mut().filter(|name| is_file(name, LIGHTS)))
    }
}

/// What files of bands and of responses end with.
const CURVES: &str = "csv";
/// What files of lights end with.
const LIGHTS: &str = "spd";
/// Most bytes of a file that is read.
const BYTES_MAX: u64 = 64 << 20;
/// Most characters of a name that an error shows.
const NAME: usize = 60;

fn is_file(name: &str, ending: &str) -> bool {
    extension(Path::new(name)) == ending
}

/// Two numbers with a colon between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeText([f32; 2]);

/// Bands as typed.
#[derive(Clone, Debug, PartialEq)]
pub enum BandsText {
    /// Two numbers and a count, with colons between.
    Even([f32; 2], usize),
    /// Their centers and widths.
    List(Bands),
    /// The path of a file that has them.
    File(String),
}

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
        if is_file(text, CURVES) {
            return Ok(Self::File(text.to_owned()));
        }
        if text.contains('x') {
            let told = |fault: Fault| match fault.field.as_str() {
                "bands" => format!("the bands {}", fault.problem),
                _ => fault.to_string(),
            };
            return Bands::from_list(text).map(Self::List).map_err(told);
        }
        let of = |text: &str| {
            let (ends, count) = text.rsplit_once(':')?;
            let RangeText(ends) = ends.parse().ok()?;
            Some(Self::Even(ends, count.trim().parse().ok()?))
        };
        let rule = "it is the centers of the first and the last band and how many there are, as in \
                    400:700:31, or centers and widths, as in 450x20,red=650x30, or a file .csv";
        of(text).ok_or_else(|| rule.to_owned())
    }
}

/// What the channels stand for, and what light is carried at.
fn color(arguments: &ColorArguments) -> Result<(Color, Option<Spectral>), CliError> {
    let ColorArguments { color, wavelength, wavelengths, range, bands, responses, .. } = arguments;
    let usage = |text: &str| Err(CliError::Usage(text.to_owned()));
    let typed = [
        ("--wavelengths", wavelengths.is_some()),
        ("--range", range.is_some()),
        ("--bands", bands.is_some()),
        ("--responses", responses.is_some()),
        ("--raw-response", arguments.raw_response),
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

/// The options of a render that tell what the channels stand for and what light is carried at; the
/// others are the defaults.
pub(super) fn light(arguments: &ColorArguments) -> Result<Options, CliError> {
    let (color, spectral) = color(arguments)?;
    Ok(Options {
        color,
        spectral,
        rgb_white: arguments.rgb_white.map(|WhiteName(white)| white),
        white_balance: white_balance(arguments)?,
        raw_response: arguments.raw_response,
        hold_spectra: arguments.hold_spectra,
        ..Options::default()
    })
}

/// The same for programs, which say in words of their own what is wrong.
///
/// # Errors
/// The text of the command line, with its options.
pub fn of_arguments(arguments: &ColorArguments) -> Result<Options, String> {
    light(arguments).map_err(|error| {
        if let CliError::Usage(text) = &error {
            return text.clone();
        }
        error.to_string()
    })
}

fn spectral(arguments: &ColorArguments) -> Result<(Color, Option<Spectral>), CliError> {
    let (color, ends) = match (&arguments.bands, &arguments.responses) {
        (Some(bands), _) => of_bands(bands)?,
        (None, Some(name)) => {
            let curves = curves(name)?;
            let ends = curves.ends_nm();
            (Color::Responses(Arc::new(curves)), ends)
        }
        (None, None) => (Color::Rgb, RANGE_NM),
    };
    let range_nm = arguments.range.map_or(ends, |RangeText(range)| range);
    let wavelengths = arguments.wavelengths.unwrap_or(Spectral::default().wavelengths);
    Ok((color, Some(Spectral { wavelengths, range_nm })))
}

fn of_bands(bands: &BandsText) -> Result<(Color, [f32; 2]), CliError> {
    let refuse = |fault: Fault| CliError::Usage(format!("--bands {}", fault.problem));
    let bands = match bands {
        BandsText::Even([first, last], count) => {
            Bands::evenly(*first, *last, *count).map_err(refuse)?
        }
        BandsText::List(bands) => bands.clone(),
        BandsText::File(path) => {
            Bands::from_csv(&text(path)?).map_err(|fault| of_file(path, &fault))?
        }
    };
    let ends = bands.ends_nm().map(|nm| nm as f32);
    Ok((Color::Bands(Arc::new(bands)), ends))
}

/// Responses by name, or those of a file.
fn curves(name: &str) -> Result<Curves, CliError> {
    if is_file(name, CURVES) {
        let path = Path::new(name);
        let short = path.file_name().map_or(name.into(), |name| name.to_string_lossy());
        return Curves::from_csv(printable(&short), &text(name)?)
            .map_err(|fault| of_file(name, &fault));
    }
    Curves::named(name).ok_or_else(|| {
        let (name, known) = (excerpt(name, NAME), Curves::names().join(", "));
        CliError::Usage(format!(
            "--responses {name} is not known: use one of {known}, or a file that ends in .{CURVES}"
        ))
    })
}

/// The light that is to be white.
fn white_balance(arguments: &ColorArguments) -> Result<Option<WhiteBalance>, CliError> {
    let Some(name) = &arguments.white_balance else { return Ok(None) };
    let light = if is_file(name, LIGHTS) {
        let short = Path::new(name).file_name().map_or(name.into(), |name| name.to_string_lossy());
        WhiteBalance::from_spd(printable(&short), &text(name)?)
            .map_err(|fault| of_file(name, &fault))
    } else {
        WhiteBalance::named(name).map_err(|Fault { problem, remedy, .. }| {
            let end = if remedy.is_empty() { "" } else { ": " };
            CliError::Usage(format!("--white-balance: {problem}{end}{remedy}"))
        })
    };
    light.map(Some)
}

/// The text of a file.
fn text(path: &str) -> Result<String, CliError> {
    let refuse =
        |problem: String| CliError::Refused(format!("cannot read {}: {problem}", printable(path)));
    let bytes = read_bytes(&PathBuf::from(path), BYTES_MAX + 1);
    let bytes = bytes.map_err(|error| refuse(error.to_string()))?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(refuse(format!("it is larger than {} MiB", BYTES_MAX >> 20)));
    }
    String::from_utf8(bytes).map_err(|_| refuse("it is no text in UTF-8".to_owned()))
}

/// What is wrong with a file.
fn of_file(path: &str, Fault { field, problem, remedy }: &Fault) -> CliError {
    let place = if field.is_empty() { String::new() } else { format!(", {field}") };
    let end = if remedy.is_empty() { "" } else { "; " };
    CliError::Refused(format!("{}{place}: {problem}{end}{remedy}", printable(path)))
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
