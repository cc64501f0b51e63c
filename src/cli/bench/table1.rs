//! `bench table1`.

use super::args::PATH_LENGTH;
use super::args::Table1Arguments;
use super::report::{check_outputs, deliver};
use super::{progress_of, work};
use crate::bench::measure::table1 as measure;
use crate::cli::{CliError, job};
use crate::integrators::Integrator;
use crate::render::memory::check_memory;
use crate::render::settings::{SAMPLES_MAX, check_film, check_photons};
use crate::render::threads::Threads;
use crate::render::{Options, Photons, Settings};

/// The paper's Table 1.
pub fn table1(arguments: &Table1Arguments) -> Result<(), CliError> {
    let options = options(arguments)?;
    let settings = Settings::new(options.clone())?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    check_memory(&settings, [arguments.width, arguments.height])?;
    let subjects = work::load_all(&arguments.scenes, &arguments.files)?;
    if output.record.is_some() {
        work::check_names(&subjects, &[])?;
    }
    let threads = Threads::start(arguments.threads)?;
    let iterations = arguments.iterations;
    let progress = progress_of(subjects.len() as u64 * (u64::from(iterations) + 1));
    let report = measure::table1(&subjects, &options, iterations, &threads, &progress)?;
    progress.finish();
    deliver(&report, output, ("table1", &report.conditions.machine))
}

/// Checks what was typed; for the polarized half, from which the other differs in its mode alone.
fn options(arguments: &Table1Arguments) -> Result<Options, CliError> {
    let Table1Arguments { photons, samples_per_iteration, .. } = *arguments;
    let (per_iteration, samples) = (Some(photons), Some(samples_per_iteration));
    let photons = Photons { per_iteration, samples, ..Photons::default() };
    check_photons(&photons)?;
    // One more warms up.
    job::within("--iterations", arguments.iterations, SAMPLES_MAX / samples_per_iteration - 1, "")?;
    job::check_threads(arguments.threads)?;
    check_film(arguments.width, arguments.height)?;
    Ok(Options {
        integrator: Some(Integrator::Ppm),
        width: Some(arguments.width),
        height: Some(arguments.height),
        samples: (1 + arguments.iterations) * samples_per_iteration,
        path_length_max: PATH_LENGTH,
        roulette_after: None,
        seed: arguments.seed,
        photons,
        ..Options::default()
    })
}
