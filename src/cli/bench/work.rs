//! What is rendered, as validated.

use super::args::WorkArguments;
use super::subject::Subject;
use crate::cli::args::IntegratorName;
use crate::cli::{CliError, job};
use crate::render::{Integrator, Mode, Photons, Settings};
use crate::spectrum::Color;

/// Edge of the film where none is typed, in pixels.
const EDGE: u32 = 256;

/// The size of the film: as typed, else `default`.
pub fn size(work: &WorkArguments, default: Option<(u32, u32)>) -> Result<(u32, u32), CliError> {
    let (width, height) = default.unwrap_or((EDGE, EDGE));
    let (width, height) = (work.width.unwrap_or(width), work.height.unwrap_or(height));
    job::within("--width", width, job::EDGE_MAX, "")?;
    job::within("--height", height, job::EDGE_MAX, "")?;
    job::check_film_size(width, height)?;
    Ok((width, height))
}

/// What the channels stand for.
pub fn color(work: &WorkArguments) -> Result<Color, CliError> {
    job::color(work.color, work.wavelength)
}

/// All else, polarized, for `samples` per pixel an iteration of photons; samples in all are left
/// to the render.
pub fn settings(
    work: &WorkArguments,
    integrator: Integrator,
    samples: u32,
) -> Result<Settings, CliError> {
    let default = Photons::default();
    let per_iteration = work.photons.unwrap_or(default.per_iteration);
    job::within("--photons", per_iteration, job::PHOTONS_MAX, "")?;
    job::within("--max-path-length", work.max_path_length, job::PATH_LENGTH_MAX, "")?;
    job::check_threads(work.threads)?;
    Ok(Settings {
        integrator,
        mode: Mode::Polarized,
        color: color(work)?,
        iterations: samples,
        replicates: 1,
        path_length_max: work.max_path_length,
        roulette_after: work.roulette_after,
        seed: work.seed,
        photons: Photons { per_iteration, samples, ..default },
        time_limit: None,
    })
}

/// Refuses options of photons where no integrator shoots any.
pub fn check_photons(
    integrators: &[IntegratorName],
    typed: &[(&str, bool)],
) -> Result<(), CliError> {
    let unused = typed.iter().find(|(_, is_typed)| *is_typed);
    match unused {
        Some((name, _)) if !integrators.contains(&IntegratorName::Ppm) => {
            Err(CliError::Usage(format!("{name} goes with --integrator ppm")))
        }
        _ => Ok(()),
    }
}

/// Refuses what would stand under one name twice.
pub fn check_names(subjects: &[Subject], integrators: &[IntegratorName]) -> Result<(), CliError> {
    for (index, subject) in subjects.iter().enumerate() {
        let name = subject.short_name();
        if let Some(other) = subjects[..index].iter().find(|other| other.short_name() == name) {
            return Err(CliError::Usage(format!(
                "{} and {} are both called {name} in reports and records: measure them one by one",
                other.name, subject.name
            )));
        }
    }
    for (index, integrator) in integrators.iter().enumerate() {
        if integrators[..index].contains(integrator) {
            return Err(CliError::Usage("--integrator names an integrator twice".into()));
        }
    }
    Ok(())
}
