//! What `render` is asked for: the command line's options by name, as Python's values.

use std::fmt::Display;
use std::str::FromStr;
use std::time::Duration;

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use sunstone::internals::cli::color::{ColorArguments, ColorName, of_arguments};
use sunstone::internals::cli::white::WhiteName;
use sunstone::internals::image::layers::LayerKind;
use sunstone::internals::math::text::sentence;
use sunstone::internals::render::settings::{AUTO, PATH_LENGTH_MAX};
use sunstone::internals::scene::world::{Asked, Walk};
use sunstone::{
    Crop, FilterKind, FilterSamples, Integrator, Mode, Options, Photons, Sampling, Settings, White,
};

use crate::errors::{RENDER_ERROR, of_settings};
use crate::keys::{extract, flag};

/// Options that only photons have.
const OF_PHOTONS: [&str; 4] = ["photons", "samples_per_iteration", "radius", "alpha"];

/// Checked settings of options by name; those that are not there are what the scene asks for, and
/// else the command line's.
pub fn settings(options: &Bound<PyDict>, asked: &Asked) -> PyResult<Settings> {
    let integrator = match integrator(options)? {
        None if !is_there(options, &[&["integrator"], &OF_PHOTONS[..]].concat())? => {
            asked.walk.map(|walk| match walk {
                Walk::FromSensor => Integrator::Path,
                Walk::FromEmitters => Integrator::Light,
            })
        }
        named => named,
    };
    let photons = photons(options, integrator)?;
    let (spp, iterations) = (option(options, "spp")?, option(options, "iterations")?);
    if spp.is_some() && iterations.is_some() {
        return Err(RENDER_ERROR.says("spp and iterations cannot both be given: leave one out"));
    }
    let default = Options::default();
    let variance = is_set(options, "variance")?;
    let light = of_arguments(&light(options)?).map_err(|text| RENDER_ERROR.says(text))?;
    let of_photons = photons.samples.unwrap_or(1).max(1);
    let spp = spp.or(asked.samples.filter(|_| iterations.is_none()));
    let samples = spp.unwrap_or(default.samples.next_multiple_of(of_photons));
    let options = Options {
        integrator,
        mode: named(options, "mode", &Mode::ALL, Mode::name)?.unwrap_or(default.mode),
        width: option(options, "width")?,
        height: option(options, "height")?,
        filter: named(options, "filter", &FilterKind::ALL, FilterKind::name)?,
        filter_radius: option(options, "filter_radius")?,
        filter_samples: named(options, "filter_samples", &FilterSamples::ALL, FilterSamples::name)?,
        crop: crop(options)?,
        pixel_aspect: option(options, "pixel_aspect")?,
        samples,
        iterations,
        replicates: replicates(options, variance, iterations.unwrap_or(samples / of_photons))?,
        variance,
        path_length_max: option(options, "max_path_length")?
            .or(asked.path_length_max)
            .unwrap_or(PATH_LENGTH_MAX),
        roulette_after: option(options, "roulette_after")?.or(asked.roulette_after),
        sampling: named(options, "sampling", &Sampling::ALL, Sampling::name)?
            .unwrap_or(default.sampling),
        seed: option(options, "seed")?.or(asked.seed).unwrap_or(default.seed),
        photons,
        time_limit: time_limit(options)?,
        layers: layers(options)?,
        part: None,
        ..light
    };
    Settings::new(options).map_err(of_settings)
}

/// Whether any of some options is there.
fn is_there(options: &Bound<PyDict>, names: &[&str]) -> PyResult<bool> {
    for name in names {
        if options.get_item(name)?.is_some_and(|value| !value.is_none()) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// An option, if it is there; a number that does not fit is refused in words.
pub fn option<'py, T>(options: &Bound<'py, PyDict>, name: &str) -> PyResult<Option<T>>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let Some(value) = options.get_item(name)?.filter(|value| !value.is_none()) else {
        return Ok(None);
    };
    extract(name, &value).map(Some).map_err(|error: PyErr| {
        if !error.is_instance_of::<PyOverflowError>(options.py()) {
            return error;
        }
        let most = u32::MAX;
        RENDER_ERROR.says(format!("{name} must be a whole number from 0 to {most}, not {value}"))
    })
}

fn integrator(options: &Bound<PyDict>) -> PyResult<Option<Integrator>> {
    let all: Vec<_> =
        std::iter::once(None).chain(Integrator::ALL.iter().copied().map(Some)).collect();
    let name = |it: Option<Integrator>| it.map_or(AUTO, Integrator::name);
    Ok(named(options, "integrator", &all, name)?.flatten())
}

/// The value of a name, if it is there.
fn named<T: Copy>(
    options: &Bound<PyDict>,
    option_name: &str,
    all: &[T],
    name: impl Fn(T) -> &'static str,
) -> PyResult<Option<T>> {
    let Some(word) = option::<String>(options, option_name)? else { return Ok(None) };
    match all.iter().find(|value| name(**value) == word) {
        Some(value) => Ok(Some(*value)),
        None => {
            let names: Vec<&str> = all.iter().map(|value| name(*value)).collect();
            let names = names.join(", ");
            Err(RENDER_ERROR.says(format!("{option_name} must be one of {names}, not {word:?}")))
        }
    }
}

/// What the channels stand for and what light is carried at, as the command line has it.
fn light(options: &Bound<PyDict>) -> PyResult<ColorArguments> {
    let (bands, responses) = (parsed(options, "bands")?, option(options, "responses")?);
    if bands.is_some() && responses.is_some() {
        return Err(RENDER_ERROR.says("bands and responses cannot both be given: leave one out"));
    }
    Ok(ColorArguments {
        color: named(options, "color", &ColorName::ALL, ColorName::name)?.unwrap_or(ColorName::Rgb),
        wavelength: option(options, "wavelength")?,
        rgb_white: named(options, "rgb_white", &White::ALL, White::name)?.map(WhiteName),
        wavelengths: option(options, "wavelengths")?,
        range: parsed(options, "range")?,
        bands,
        responses,
        raw_response: is_set(options, "raw_response")?,
        white_balance: option(options, "white_balance")?,
        hold_spectra: is_set(options, "hold_spectra")?,
    })
}

/// Whether an option that is true or false is there and true.
fn is_set(options: &Bound<PyDict>, name: &str) -> PyResult<bool> {
    let value = options.get_item(name)?.filter(|value| !value.is_none());
    value.map_or(Ok(false), |value| flag(name, &value))
}

/// An option that the command line has as numbers with colons between, or as a name: such a text,
/// or the numbers.
fn parsed<T: FromStr<Err = String>>(options: &Bound<PyDict>, name: &str) -> PyResult<Option<T>> {
    let Some(value) = options.get_item(name)?.filter(|value| !value.is_none()) else {
        return Ok(None);
    };
    let text = match value.cast::<PyString>() {
        Ok(text) => text.to_cow()?.into_owned(),
        Err(_) => {
            let numbers: Vec<f64> = extract(name, &value)?;
            let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
            numbers.join(":")
        }
    };
    let wrong = |rule: String| {
        let known = if rule.contains(&format!("`{text}`")) {
            String::new()
        } else {
            format!(", not {text}")
        };
        RENDER_ERROR.says(sentence(name, &(rule + &known)))
    };
    text.parse().map(Some).map_err(wrong)
}

/// What the camera sees first: names, in a list or in a text with commas between them.
fn layers(options: &Bound<PyDict>) -> PyResult<Vec<LayerKind>> {
    let Some(value) = options.get_item("layers")?.filter(|value| !value.is_none()) else {
        return Ok(Vec::new());
    };
    let names: Vec<String> = match value.cast::<PyString>() {
        Ok(text) => text.to_cow()?.split(',').map(str::to_owned).collect(),
        Err(_) => extract("layers", &value)?,
    };
    let kind = |name: &String| name.parse().map_err(|text: String| RENDER_ERROR.says(text));
    names.iter().map(kind).collect()
}

/// The part of the film that is rendered: four whole numbers of pixels, or a text as the command
/// line takes it.
fn crop(options: &Bound<PyDict>) -> PyResult<Option<Crop>> {
    let Some(value) = options.get_item("crop")?.filter(|value| !value.is_none()) else {
        return Ok(None);
    };
    let Ok(text) = value.cast::<PyString>() else {
        return extract("crop", &value).map(|ends| Some(Crop::Pixels(ends)));
    };
    let text = text.to_cow()?;
    text.parse().map(Some).map_err(|rule: String| RENDER_ERROR.says(format!("crop {rule}")))
}

fn photons(options: &Bound<PyDict>, integrator: Option<Integrator>) -> PyResult<Photons> {
    if integrator.is_some_and(|it| !it.shoots_photons()) {
        for name in OF_PHOTONS {
            if options.get_item(name)?.is_some_and(|value| !value.is_none()) {
                return Err(RENDER_ERROR.says(format!("{name} goes with integrator=\"ppm\"")));
            }
        }
    }
    let default = Photons::default();
    Ok(Photons {
        per_iteration: option(options, "photons")?,
        samples: option(options, "samples_per_iteration")?,
        alpha: option(options, "alpha")?.unwrap_or(default.alpha),
        radius: option(options, "radius")?,
    })
}

/// Their number, for which there must be iterations enough where variances are to come of them.
fn replicates(options: &Bound<PyDict>, variance: bool, iterations: u32) -> PyResult<u32> {
    let refuse = |text: &dyn Display| Err(RENDER_ERROR.says(text));
    match option(options, "replicates")? {
        None if variance && iterations < 2 => refuse(&"variance needs two iterations or more"),
        None => Ok(1),
        Some(replicates) => {
            let least = if variance { 2 } else { 1 };
            match (least..=iterations).contains(&replicates) {
                true => Ok(replicates),
                false => refuse(&format_args!(
                    "replicates must be from {least} to the number of iterations, which is \
                     {iterations}, not {replicates}"
                )),
            }
        }
    }
}

fn time_limit(options: &Bound<PyDict>) -> PyResult<Option<Duration>> {
    let Some(seconds) = option::<f64>(options, "time_limit")? else { return Ok(None) };
    let limit = Duration::try_from_secs_f64(seconds);
    limit.map(Some).map_err(|_| {
        RENDER_ERROR.says(format!("time_limit must be a number of seconds, not {seconds}"))
    })
}
