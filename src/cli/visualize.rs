//! The verb `visualize`: maps, analyzers and mosaics of a Stokes image.

use std::path::Path;

use crate::image::analyzed::{self, ANALYZERS};
use crate::image::format::{extensions, named_by};
use crate::image::mosaic::{Electrons, Filters, PolarizationSensor};
use crate::image::visualize::{Map, View, panels, visualize as draw};
use crate::image::{StokesImage, extension, png};
use crate::polarization::Analyzer;

use super::CliError;
use super::args::{ANALYZERS_MAP, MOSAIC, PANELS, SensorArguments, SensorName, VisualizeArguments};
use super::files::{refuse_overwriting, require_png};
use super::images::load_at;
use super::job::option_of;

/// What an image is shown as.
enum Shown {
    Map(Map),
    Panels,
    /// What passes one of them, as a picture or an image.
    Analyzer(Analyzer),
    Analyzers,
    Mosaic,
}

/// Shows an image in another way.
pub(super) fn visualize(arguments: &VisualizeArguments) -> Result<(), CliError> {
    let VisualizeArguments { image, output, exposure, .. } = arguments;
    let shown = shown(&arguments.map);
    match &shown {
        Shown::Analyzer(_) => require_png_or_image(output)?,
        Shown::Map(_) | Shown::Panels | Shown::Analyzers | Shown::Mosaic => require_png(output)?,
    }
    refuse_overwriting(output, &[image])?;
    if !matches!(shown, Shown::Mosaic) {
        refuse_sensor(&arguments.sensor)?;
    }
    // What is wrong with it is to be said whatever the image is.
    check(&sensor(arguments, Filters::Mono))?;
    let image = load_at(image, &arguments.channel)?;
    let picture = match shown {
        Shown::Map(map) => draw(&image, map, &view(arguments, &image))?,
        Shown::Panels => panels(&image, &view(arguments, &image))?,
        Shown::Analyzers => analyzed::pictures(&image, *exposure)?,
        Shown::Analyzer(analyzer) if extension(output) != "png" => {
            return Ok(image.behind(analyzer)?.save(output)?);
        }
        Shown::Analyzer(analyzer) => analyzed::picture(&image, analyzer, *exposure)?,
        Shown::Mosaic => {
            let raw = sensor(arguments, Filters::of(&image.color)).record(&image)?;
            return Ok(raw.save(output)?);
        }
    };
    Ok(png::write(&picture, output)?)
}

/// What a map that the command line knows shows.
fn shown(name: &str) -> Shown {
    if let Some(map) = Map::ALL.into_iter().find(|map| map.name() == name) {
        return Shown::Map(map);
    }
    if let Some((_, analyzer)) = ANALYZERS.into_iter().find(|(known, _)| *known == name) {
        return Shown::Analyzer(analyzer);
    }
    match name {
        ANALYZERS_MAP => Shown::Analyzers,
        MOSAIC => Shown::Mosaic,
        _ => {
            debug_assert_eq!(name, PANELS);
            Shown::Panels
        }
    }
}

fn view(arguments: &VisualizeArguments, image: &StokesImage) -> View {
    let view = if arguments.full_scale { View::default() } else { View::fitted(image) };
    View { exposure_ev: arguments.exposure, ..view }
}

/// Refuses what can be neither the picture nor the image behind an analyzer.
fn require_png_or_image(path: &Path) -> Result<(), CliError> {
    let named = named_by(path, "written", |format| format.write);
    named.map(|_| ()).map_err(|_| {
        CliError::Usage(format!(
            "{} must end in one of {}: .png is a picture, the others keep what passes",
            path.display(),
            extensions(|format| format.write)
        ))
    })
}

/// Refuses options of sensors where there is none.
fn refuse_sensor(sensor: &SensorArguments) -> Result<(), CliError> {
    let SensorArguments { sensor, bits, full_well, gain, read_noise, black_level, seed } = sensor;
    let typed = [
        ("--sensor", sensor.is_some()),
        ("--bits", bits.is_some()),
        ("--full-well", full_well.is_some()),
        ("--gain", gain.is_some()),
        ("--read-noise", read_noise.is_some()),
        ("--black-level", black_level.is_some()),
        ("--seed", seed.is_some()),
    ];
    match typed.into_iter().find(|(_, is)| *is) {
        None => Ok(()),
        Some((name, _)) => Err(CliError::Usage(format!("{name} goes with --map {MOSAIC}"))),
    }
}

/// The sensor that was asked for, or that of an image with these filters.
fn sensor(arguments: &VisualizeArguments, filters: Filters) -> PolarizationSensor {
    let typed = &arguments.sensor;
    PolarizationSensor {
        filters: typed.sensor.map_or(filters, |name| match name {
            SensorName::Mono => Filters::Mono,
            SensorName::Color => Filters::Bayer,
        }),
        bits: typed.bits.unwrap_or(8),
        exposure_ev: arguments.exposure,
        black_level: typed.black_level.unwrap_or(0),
        electrons: typed.full_well.map(|full_well| Electrons {
            full_well,
            gain: typed.gain,
            read_noise: typed.read_noise.unwrap_or(0.0),
        }),
        seed: typed.seed.unwrap_or(0),
    }
}

fn check(sensor: &PolarizationSensor) -> Result<(), CliError> {
    sensor.check().map_err(|fault| {
        let remedy = if fault.remedy.is_empty() { "" } else { ", " };
        let (option, problem) = (option_of(&fault.field), &fault.problem);
        CliError::Usage(format!("{option}: {problem}{remedy}{}", fault.remedy))
    })
}
