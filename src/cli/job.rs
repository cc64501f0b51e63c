//! A render as validated: nothing in it can be wrong any more.

use std::fmt::Display;
use std::time::Duration;

use crate::render::{Integrator, Mode, Photons, Settings};
use crate::scene::baked::{Camera, Projection};
use crate::spectrum::Color;

use super::CliError;
use super::args::{ColorName, IntegratorName, ModeName, PhotonArguments, RenderArguments};
use super::files::extension;

/// Samples per pixel where no number is given.
const SPP: u32 = 64;
/// Most light paths an iteration: their photons are counted in 32 bits.
pub(super) const PHOTONS_MAX: u32 = 1 << 28;
/// Replicates where variances are asked for and no number is given.
const REPLICATES: u32 = 16;
/// Film width where neither the scene nor the command line names one, in pixels.
const WIDTH: u32 = 512;
/// Largest film edge in pixels: what a Radiance picture can have.
pub(super) const EDGE_MAX: u32 = 65_535;
/// Most pixels of a film: they are counted in 32 bits.
const PIXELS_MAX: u64 = 1 << 31;
/// Most samples per pixel: more would not fit the sequences of 32 bits, nor a lifetime.
pub(super) const SPP_MAX: u32 = 1 << 30;
/// Most segments of a path that can be asked for; nothing needs more.
pub(super) const PATH_LENGTH_MAX: u32 = 65_535;
/// Most threads that can be asked for.
const THREADS_MAX: usize = 4096;
/// Wavelength where none is named, in nanometers.
const WAVELENGTH_NM: f32 = 550.0;

/// Checks what was typed.
pub(super) fn settings(arguments: &RenderArguments) -> Result<Settings, CliError> {
    let photons = photons(arguments)?;
    let iterations = samples(arguments.spp, arguments.iterations, SPP, photons.samples)?;
    within("--max-path-length", arguments.max_path_length, PATH_LENGTH_MAX, "")?;
    check_threads(arguments.threads)?;
    for (name, edge) in [("--width", arguments.width), ("--height", arguments.height)] {
        if let Some(edge) = edge {
            within(name, edge, EDGE_MAX, "")?;
        }
    }
    if arguments.variance && extension(&arguments.output) != "exr" {
        return Err(CliError::Usage(format!(
            "--variance needs an .exr output, and {} is none: other formats store no variances",
            arguments.output.display()
        )));
    }
    Ok(Settings {
        integrator: integrator(arguments.integrator),
        mode: mode(arguments.mode),
        color: color(arguments.color, arguments.wavelength)?,
        iterations,
        replicates: replicates(arguments, iterations / photons.samples)?,
        path_length_max: arguments.max_path_length,
        roulette_after: arguments.roulette_after,
        seed: arguments.seed,
        photons,
        time_limit: seconds("--time-limit", arguments.time_limit)?,
    })
}

/// The integrator of a name.
pub(super) fn integrator(name: IntegratorName) -> Integrator {
    match name {
        IntegratorName::Path => Integrator::Path,
        IntegratorName::Light => Integrator::Light,
        IntegratorName::Bdpt => Integrator::Bdpt,
        IntegratorName::Ppm => Integrator::Ppm,
    }
}

/// The mode of a name.
pub(super) fn mode(name: ModeName) -> Mode {
    match name {
        ModeName::Scalar => Mode::Scalar,
        ModeName::Intensity => Mode::Intensity,
        ModeName::Polarized => Mode::Polarized,
    }
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

/// What the channels stand for.
pub(super) fn color(name: ColorName, wavelength: Option<f32>) -> Result<Color, CliError> {
    match (name, wavelength) {
        (ColorName::Rgb, None) => Ok(Color::Rgb),
        (ColorName::Rgb, Some(_)) => Err(CliError::Usage(
            "--wavelength goes with --color mono; RGB has three wavelengths of its own".into(),
        )),
        (ColorName::Mono, wavelength) => {
            let wavelength_nm = wavelength.unwrap_or(WAVELENGTH_NM);
            if wavelength_nm.is_finite() && wavelength_nm > 0.0 {
                Ok(Color::Mono { wavelength_nm })
            } else {
                Err(CliError::Usage(format!(
                    "--wavelength must be a positive number of nanometers, not {wavelength_nm}"
                )))
            }
        }
    }
}

fn replicates(arguments: &RenderArguments, iterations: u32) -> Result<u32, CliError> {
    let replicates = match (arguments.replicates, arguments.variance) {
        (Some(replicates), _) => replicates,
        (None, true) => REPLICATES,
        (None, false) => return Ok(1),
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
        within("--iterations", iterations, SPP_MAX / samples, "")?;
        return Ok(iterations * samples);
    }
    let spp = spp.unwrap_or(default.next_multiple_of(samples));
    within("--spp", spp, SPP_MAX, "")?;
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
    if let (Some((name, _)), true) = (typed, arguments.integrator != IntegratorName::Ppm) {
        return Err(CliError::Usage(format!("{name} goes with --integrator ppm")));
    }
    let default = Photons::default();
    let per_iteration = photons.unwrap_or(default.per_iteration);
    within("--photons", per_iteration, PHOTONS_MAX, "")?;
    let samples = samples_per_iteration.unwrap_or(default.samples);
    within("--samples-per-iteration", samples, SPP_MAX, "")?;
    let alpha = alpha.unwrap_or(default.alpha);
    if !(alpha > 0.0 && alpha <= 1.0) {
        let problem = format!("--alpha must be greater than 0 and at most 1, not {alpha}");
        return Err(CliError::Usage(problem));
    }
    if let Some(radius) = radius.filter(|radius| !(*radius > 0.0 && radius.is_finite())) {
        let problem = format!("--radius must be a length greater than 0, not {radius}");
        return Err(CliError::Usage(problem));
    }
    Ok(Photons { per_iteration, samples, alpha, radius: *radius })
}

/// A time in seconds, not negative.
pub(super) fn seconds(name: &str, seconds: Option<f64>) -> Result<Option<Duration>, CliError> {
    let Some(seconds) = seconds else { return Ok(None) };
    Duration::try_from_secs_f64(seconds)
        .map(Some)
        .map_err(|_| CliError::Usage(format!("{name} must be a number of seconds, not {seconds}")))
}

/// The size of the film: what was typed, else what the scene asks for, else a default; an edge
/// that is not given follows from the other and the camera's aspect.
pub(super) fn film_size(
    arguments: &RenderArguments,
    camera: &Camera,
) -> Result<(u32, u32), CliError> {
    let aspect = match (camera.resolution, camera.projection) {
        (Some([width, height]), _) => width as f32 / height as f32,
        (None, Projection::Perspective { aspect, .. }) => aspect.unwrap_or(1.0),
        (None, Projection::Orthographic { half_width, half_height }) => half_width / half_height,
    };
    let edge = |value: f32| (value.round() as u32).max(1);
    let (width, height) = match (arguments.width, arguments.height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, edge(width as f32 / aspect)),
        (None, Some(height)) => (edge(height as f32 * aspect), height),
        (None, None) => match camera.resolution {
            Some([width, height]) => (width, height),
            None => (WIDTH, edge(WIDTH as f32 / aspect)),
        },
    };
    check_film_size(width, height)?;
    Ok((width, height))
}

/// Refuses a film that could not be counted or stored.
pub(super) fn check_film_size(width: u32, height: u32) -> Result<(), CliError> {
    let pixels = u64::from(width) * u64::from(height);
    if width > EDGE_MAX || height > EDGE_MAX || pixels > PIXELS_MAX {
        return Err(CliError::Usage(format!(
            "a film of {width} x {height} pixels is too large: --width and --height go up to \
             {EDGE_MAX}, and their product up to {PIXELS_MAX}"
        )));
    }
    Ok(())
}

/// Refuses a film that the memory does not hold, before the system ends the render for it.
///
/// Counts what every render needs: the sums of the film in double precision, and the image that
/// is developed from them, with their variances. The tables of paths come on top; they are small.
pub(super) fn check_memory(
    settings: &Settings,
    (width, height): (u32, u32),
    available: Option<u64>,
) -> Result<(), CliError> {
    let components = settings.mode.components() as u64;
    let bytes_of_value = if settings.replicates > 1 { 3 * 8 + 2 * 4 } else { 8 + 4 };
    let values = u64::from(width) * u64::from(height) * components;
    let needed = values * settings.color.channels() as u64 * bytes_of_value;
    match available {
        Some(available) if needed > available => Err(CliError::System(format!(
            "a film of {width} x {height} pixels needs {:.1} GiB of memory and {:.1} GiB are \
             available: give a smaller --width and --height",
            gibibytes(needed),
            gibibytes(available)
        ))),
        _ => Ok(()),
    }
}

fn gibibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}
