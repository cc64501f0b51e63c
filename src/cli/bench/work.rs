//! What is rendered, as validated.

use std::path::{Path, PathBuf};

use super::args::WorkArguments;
use crate::bench::measure::{Subject, subject};
use crate::cli::args::IntegratorName;
use crate::cli::color::light;
use crate::cli::files::{FileArguments, say};
use crate::cli::{CliError, job};
use crate::integrators::Integrator;
use crate::render::settings::{check_film, check_photons};
use crate::render::{Options, Photons, Settings};
use crate::scene::View;

/// Edge of the film where none is typed, in pixels.
const EDGE: u32 = 256;

/// Light paths an iteration where no number is typed, whatever the film.
const PHOTONS: u32 = 1_000_000;

/// Loads scenes, all before the first is measured; those that the program carries, if none are
/// named.
pub fn load_all(paths: &[PathBuf], files: &FileArguments) -> Result<Vec<Subject>, CliError> {
    let subjects = subject::load_all(paths, &files.reading(View::default()))?;
    subjects.iter().for_each(say_warnings);
    Ok(subjects)
}

/// Loads a scene.
pub fn load(path: &Path, files: &FileArguments) -> Result<Subject, CliError> {
    let subject = subject::load(path, &files.reading(View::default()))?;
    say_warnings(&subject);
    Ok(subject)
}

fn say_warnings(subject: &Subject) {
    for warning in &subject.warnings {
        say(format_args!("warning: {}: {warning}", subject.name));
    }
}

/// The size of the film: as typed, else `default`.
pub fn size(work: &WorkArguments, default: Option<[u32; 2]>) -> Result<[u32; 2], CliError> {
    let [width, height] = default.unwrap_or([EDGE, EDGE]);
    let [width, height] = [work.width.unwrap_or(width), work.height.unwrap_or(height)];
    check_film(width, height)?;
    Ok([width, height])
}

/// All options, polarized, for `samples` per pixel an iteration of photons.
pub fn options(
    work: &WorkArguments,
    integrator: Integrator,
    samples: u32,
    [width, height]: [u32; 2],
) -> Result<Options, CliError> {
    job::check_threads(work.threads)?;
    let per_iteration = Some(work.photons.unwrap_or(PHOTONS));
    let photons = Photons { per_iteration, samples: Some(samples), ..Photons::default() };
    check_photons(&photons)?;
    let options = Options {
        integrator: Some(integrator),
        width: Some(width),
        height: Some(height),
        samples,
        path_length_max: work.max_path_length,
        roulette_after: work.roulette_after,
        seed: work.seed,
        photons,
        ..light(&work.color)?
    };
    Ok(Settings::new(options)?.options())
}

/// Refuses options of photons where no integrator shoots any.
pub fn refuse_photons(
    integrators: &[IntegratorName],
    typed: &[(&str, bool)],
) -> Result<(), CliError> {
    let unused = typed.iter().find(|(_, is_typed)| *is_typed);
    match unused {
        Some((name, _)) if !integrators.iter().any(|name| name.0.shoots_photons()) => {
            Err(CliError::Usage(format!("{name} goes with --integrator ppm")))
        }
        _ => Ok(()),
    }
}

/// Refuses what would stand under one name twice.
pub fn check_names(subjects: &[Subject], integrators: &[IntegratorName]) -> Result<(), CliError> {
    for (index, subject) in subjects.iter().enumerate() {
        if let Some(other) = subjects[..index].iter().find(|other| other.label == subject.label) {
            let same = if other.name == subject.name { "" } else { ", which is the same file" };
            return Err(CliError::Usage(format!(
                "{} is named twice{same}: name every scene once",
                other.name
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
