//! A render as validated: nothing in it can be wrong any more.

use std::fmt::Display;
use std::time::Duration;

use crate::image::format::{Format, extension, extensions, named_by};
use crate::integrators::Integrator;
use crate::render::settings::{PATH_LENGTH_MAX, SAMPLES_MAX, check_photons};
use crate::render::threads::THREADS_MAX;
use crate::render::{Options, Photons, Settings};
use crate::scene::world::{Asked, Walk};

use super::CliError;
use super::args::{IntegratorChoice, PhotonArguments, RenderArguments};
use super::color::light;

/// What the files of parts end with.
pub(super) const PART: &str = "part";
/// Samples per pixel where no number is given.
const SPP: u32 = 64;

/// Checks what was typed.
pub(super) fn settings(arguments: &RenderArguments) -> Result<Settings, CliError> {
    // A name that says nothing is wrong whatever else was typed.
    check_output(arguments)?;
    let photons = photons(arguments)?;
    let of_photons = photons.samples.unwrap_or(1);
    let samples = samples(arguments.spp, None, SPP, of_photons)?;
    check_threads(arguments.threads)?;
    if arguments.variance
        && arguments.part.is_none()
        && named_by(&arguments.output, "written", Format::writes_variance).is_err()
    {
        return Err(CliError::Usage(format!(
            "--variance needs an output that ends in {}, and {} does not: other formats store no \
             variances",
            extensions(Format::writes_variance),
            arguments.output.display()
        )));
    }
    let keeps_layers = named_by(&arguments.output, "written", Format::writes_layers).is_ok();
    if !arguments.film.layers.is_empty() && !keeps_layers && arguments.part.is_none() {
        return Err(CliError::Usage(format!(
            "--layers needs an output that ends in {}, and {} does not: other formats store none",
            extensions(Format::writes_layers),
            arguments.output.display()
        )));
    }
    let light = light(&arguments.color)?;
    let color = &light.color;
    let is_image = arguments.part.is_none();
    if color.is_of_many()
        && is_image
        && named_by(&arguments.output, "written", Format::writes_many).is_err()
    {
        return Err(CliError::Usage(format!(
            "{color} need an output that ends in {}, and {} does not",
            extensions(Format::writes_many),
            arguments.output.display()
        )));
    }
    let options = Options {
        integrator: integrator(arguments),
        mode: arguments.mode.0,
        width: arguments.width,
        height: arguments.height,
        samples,
        iterations: arguments.iterations,
        replicates: replicates(arguments, arguments.iterations.unwrap_or(samples / of_photons))?,
        variance: arguments.variance,
        path_length_max: arguments.max_path_length.unwrap_or(PATH_LENGTH_MAX),
        roulette_after: arguments.roulette_after,
        stage_times: arguments.stats.is_some(),
        sampling: arguments.sampling.0,
        seed: arguments.seed.unwrap_or(0),
        photons,
        time_limit: seconds("--time-limit", arguments.time_limit)?,
        part: arguments.part,
        ..light
    };
    Ok(Settings::new(arguments.film.with(options))?)
}

/// The integrator that is named, or none: what suits the scene.
fn integrator(arguments: &RenderArguments) -> Option<Integrator> {
    arguments.integrator.and_then(|choice| choice.0)
}

/// The same with what the scene asks for where nothing was typed; and that in words, if there is
/// any.
pub(super) fn with_asked(
    arguments: &RenderArguments,
    asked: &Asked,
) -> (RenderArguments, Option<String>) {
    let mut filled = arguments.clone();
    let mut words = Vec::new();
    let mut fill = |option: &mut Option<u32>, name: &str, asked: Option<u32>| {
        if let (None, Some(value)) = (&option, asked) {
            words.push(format!("{name} {value}"));
            *option = asked;
        }
    };
    if arguments.iterations.is_none() {
        fill(&mut filled.spp, "--spp", asked.samples);
    }
    fill(&mut filled.seed, "--seed", asked.seed);
    fill(&mut filled.max_path_length, "--max-path-length", asked.path_length_max);
    fill(&mut filled.roulette_after, "--roulette-after", asked.roulette_after);
    let PhotonArguments { photons, samples_per_iteration, radius, alpha } = &arguments.photons;
    let shoots =
        photons.is_some() || samples_per_iteration.is_some() || radius.is_some() || alpha.is_some();
    if let (None, false, Some(walk)) = (arguments.integrator, shoots, asked.walk) {
        let integrator = match walk {
            Walk::FromSensor => Integrator::Path,
            Walk::FromEmitters => Integrator::Light,
        };
        words.push(format!("--integrator {}", integrator.name()));
        filled.integrator = Some(IntegratorChoice(Some(integrator)));
    }
    let words = (!words.is_empty()).then(|| words.join(" "));
    (filled, words)
}

/// Checks that the output's name says what is asked for: a part, or an image in some format.
fn check_output(arguments: &RenderArguments) -> Result<(), CliError> {
    let output = &arguments.output;
    let is_part = extension(output) == PART;
    match (arguments.part, is_part) {
        (Some(_), true) => Ok(()),
        (Some(part), false) => Err(CliError::Usage(format!(
            "--part {part} needs an output that ends in .{PART}, and {} does not: `sunstone merge` \
             makes the image of all parts",
            output.display()
        ))),
        (None, true) => Err(CliError::Usage(format!(
            "{} ends in .{PART}: say which part of the image it is, as in --part 1/2",
            output.display()
        ))),
        (None, false) => {
            let named = named_by(output, "written", |format| format.write);
            named.map_err(|error| CliError::Usage(error.to_string())).map(|_| ())
        }
    }
}

/// What the command line calls a setting.
pub(super) fn option_of(setting: &str) -> String {
    let name = match setting {
        "samples" => "spp",
        "path_length_max" => "max-path-length",
        name => name,
    };
    format!("--{}", name.replace('_', "-"))
}

pub(super) fn check_threads(threads: Option<usize>) -> Result<(), CliError> {
    threads.map_or(Ok(()), |threads| {
        within("--threads", threads, THREADS_MAX, "; leave it out to use all processors")
    })
}

/// Checks that a number is from 1 to `most`.
pub(super) fn within<T: PartialOrd + From<u8> + Display>(
    name: &str,
    value: T,
    most: T,
    advice: &str,
) -> Result<(), CliError> {
    if T::from(1) <= value && value <= most {
        return Ok(());
    }
    Err(CliError::Usage(format!("{name} must be from 1 to {most}, not {value}{advice}")))
}

fn replicates(arguments: &RenderArguments, iterations: u32) -> Result<u32, CliError> {
    let Some(replicates) = arguments.replicates else {
        return match (arguments.variance, iterations) {
            (true, 0..2) => {
                let problem = "--variance needs two iterations or more".to_owned();
                Err(CliError::Usage(problem))
            }
            _ => Ok(1),
        };
    };
    let least = if arguments.variance { 2 } else { 1 };
    if (least..=iterations).contains(&replicates) {
        return Ok(replicates);
    }
    Err(CliError::Usage(format!(
        "{replicates} replicates do not fit: --replicates must be from {least} to the number of \
         iterations, which is {iterations}"
    )))
}

/// Samples per pixel in all, `default` of them where neither number is given; `samples` is their
/// number in an iteration.
pub(super) fn samples(
    spp: Option<u32>,
    iterations: Option<u32>,
    default: u32,
    samples: u32,
) -> Result<u32, CliError> {
    if let Some(iterations) = iterations {
        within("--iterations", iterations, SAMPLES_MAX / samples, "")?;
        return Ok(iterations * samples);
    }
    let spp = spp.unwrap_or(default.next_multiple_of(samples));
    within("--spp", spp, SAMPLES_MAX, "")?;
    if spp.is_multiple_of(samples) {
        return Ok(spp);
    }
    Err(CliError::Usage(format!(
        "--spp {spp} is not a multiple of --samples-per-iteration {samples}: use --iterations"
    )))
}

/// How photons are shot; refused where nothing shoots any.
fn photons(arguments: &RenderArguments) -> Result<Photons, CliError> {
    let PhotonArguments { photons, samples_per_iteration, radius, alpha } = &arguments.photons;
    let typed = [
        ("--photons", photons.is_some()),
        ("--samples-per-iteration", samples_per_iteration.is_some()),
        ("--radius", radius.is_some()),
        ("--alpha", alpha.is_some()),
    ];
    let typed = typed.into_iter().find(|(_, is)| *is);
    let shoots_none = integrator(arguments).is_some_and(|it| !it.shoots_photons());
    if let (Some((name, _)), true) = (typed, shoots_none) {
        return Err(CliError::Usage(format!("{name} goes with --integrator ppm")));
    }
    let default = Photons::default();
    let photons = Photons {
        per_iteration: *photons,
        samples: *samples_per_iteration,
        alpha: alpha.unwrap_or(default.alpha),
        radius: *radius,
    };
    check_photons(&photons)?;
    Ok(photons)
}

/// A time in seconds, not negative.
pub(super) fn seconds(name: &str, seconds: Option<f64>) -> Result<Option<Duration>, CliError> {
    let Some(seconds) = seconds else { return Ok(None) };
    Duration::try_from_secs_f64(seconds)
        .map(Some)
        .map_err(|_| CliError::Usage(format!("{name} must be a number of seconds, not {seconds}")))
}
