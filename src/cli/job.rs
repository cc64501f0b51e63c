//! A render as validated: nothing in it can be wrong any more.

use std::time::Duration;

use crate::integrators::{Integrator, Mode, Settings};
use crate::scene::baked::{Camera, Projection};
use crate::spectrum::Color;

use super::CliError;
use super::args::{ColorName, IntegratorName, ModeName, RenderArguments};

/// Replicates where variances are asked for and no number is given.
const REPLICATES: u32 = 16;
/// Film width where neither the scene nor the command line names one, in pixels.
const WIDTH: u32 = 512;
/// Largest film edge in pixels; beyond it the film alone would take terabytes.
const EDGE_MAX: u32 = 65_536;
/// Wavelength where none is named, in nanometers.
const WAVELENGTH_NM: f32 = 550.0;

/// Checks what was typed.
pub(super) fn settings(arguments: &RenderArguments) -> Result<Settings, CliError> {
    let usage = |text: String| Err(CliError::Usage(text));
    if arguments.spp == 0 {
        return usage("--spp must be 1 or more".into());
    }
    if arguments.max_path_length == 0 {
        return usage("--max-path-length must be 1 or more: 1 shows emitters only".into());
    }
    if arguments.threads == Some(0) {
        return usage("--threads must be 1 or more; leave it out to use all processors".into());
    }
    if let Some(edge) = [arguments.width, arguments.height]
        .into_iter()
        .flatten()
        .find(|edge| !(1..=EDGE_MAX).contains(edge))
    {
        return usage(format!("--width and --height must be from 1 to {EDGE_MAX}, not {edge}"));
    }
    Ok(Settings {
        integrator: match arguments.integrator {
            IntegratorName::Path => Integrator::Path,
            IntegratorName::Light => Integrator::Light,
            IntegratorName::Bdpt => Integrator::Bdpt,
        },
        mode: match arguments.mode {
            ModeName::Scalar => Mode::Scalar,
            ModeName::Polarized => Mode::Polarized,
        },
        color: color(arguments)?,
        iterations: arguments.spp,
        replicates: replicates(arguments)?,
        path_length_max: arguments.max_path_length,
        roulette_after: arguments.roulette_after,
        seed: arguments.seed,
        time_limit: time_limit(arguments)?,
    })
}

fn color(arguments: &RenderArguments) -> Result<Color, CliError> {
    match (arguments.color, arguments.wavelength) {
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

fn replicates(arguments: &RenderArguments) -> Result<u32, CliError> {
    let replicates = match (arguments.replicates, arguments.variance) {
        (Some(replicates), _) => replicates,
        (None, true) => REPLICATES,
        (None, false) => return Ok(1),
    };
    let least = if arguments.variance { 2 } else { 1 };
    if (least..=arguments.spp).contains(&replicates) {
        return Ok(replicates);
    }
    Err(CliError::Usage(format!(
        "{replicates} replicates do not fit: --replicates must be from {least} to --spp, which is \
         {}",
        arguments.spp
    )))
}

fn time_limit(arguments: &RenderArguments) -> Result<Option<Duration>, CliError> {
    let Some(seconds) = arguments.time_limit else { return Ok(None) };
    Duration::try_from_secs_f64(seconds).map(Some).map_err(|_| {
        CliError::Usage(format!("--time-limit must be a number of seconds, not {seconds}"))
    })
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
    if width > EDGE_MAX || height > EDGE_MAX {
        return Err(CliError::Usage(format!(
            "a film of {width} x {height} pixels is too large: give --width and --height up to \
             {EDGE_MAX}"
        )));
    }
    Ok((width, height))
}
