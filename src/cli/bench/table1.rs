//! `bench table1`.

use super::args::Table1Arguments;
use super::measure::{compare_modes, machine, progress_bar};
use super::report::{check_outputs, deliver};
use super::subject::load_all;
use crate::bench::Machine;
use crate::bench::table1::{Conditions, SceneReport, Table1};
use crate::cli::args::{PATH_LENGTH, ROULETTE_AFTER};
use crate::cli::{CliError, job};
use crate::integrators::Integrator;
use crate::render::memory::check_memory;
use crate::render::settings::{SAMPLES_MAX, check_film, check_photons};
use crate::render::threads::Threads;
use crate::render::{Mode, Options, Photons, Settings};

/// The paper's Table 1.
pub fn table1(arguments: &Table1Arguments) -> Result<(), CliError> {
    let options = options(arguments)?;
    let polarized = Settings::new(options)?;
    let scalar = Settings::new(Options { mode: Mode::Scalar, ..options })?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    let size = [arguments.width, arguments.height];
    check_memory(&polarized, size)?;
    let subjects = load_all(&arguments.scenes)?;
    if output.record.is_some() {
        super::work::check_names(&subjects, &[])?;
    }
    let threads = Threads::start(arguments.threads)?;
    let rounds = (arguments.iterations, arguments.samples_per_iteration);
    let progress = progress_bar(subjects.len() as u64 * (u64::from(arguments.iterations) + 1));
    let measured = subjects.iter().map(|subject| {
        progress.set_message(subject.name.clone());
        let modes = [&scalar, &polarized];
        let (rounds, _) = compare_modes(&subject.world, modes, rounds, &threads, &progress)?;
        Ok(SceneReport::new(subject.name.clone(), subject.paper, rounds))
    });
    let scenes: Vec<SceneReport> = measured.collect::<Result<_, CliError>>()?;
    progress.finish_and_clear();
    let conditions = conditions(arguments, &polarized, machine(&threads));
    let report = Table1::new(conditions, scenes);
    let machine = &report.conditions.machine;
    deliver(&report, output, ("table1", machine))
}

/// Checks what was typed; for the polarized half, from which the other differs in its mode alone.
fn options(arguments: &Table1Arguments) -> Result<Options, CliError> {
    let Table1Arguments { photons, samples_per_iteration: samples, .. } = *arguments;
    let photons = Photons { per_iteration: photons, samples, ..Photons::default() };
    check_photons(&photons)?;
    // One more warms up.
    job::within("--iterations", arguments.iterations, SAMPLES_MAX / samples - 1, "")?;
    job::check_threads(arguments.threads)?;
    check_film(arguments.width, arguments.height)?;
    Ok(Options {
        integrator: Integrator::Ppm,
        width: Some(arguments.width),
        height: Some(arguments.height),
        samples: (1 + arguments.iterations) * samples,
        path_length_max: PATH_LENGTH,
        roulette_after: ROULETTE_AFTER,
        seed: arguments.seed,
        photons,
        ..Options::default()
    })
}

fn conditions(arguments: &Table1Arguments, settings: &Settings, machine: Machine) -> Conditions {
    Conditions {
        machine,
        integrator: "ppm".into(),
        color: "RGB".into(),
        width: arguments.width,
        height: arguments.height,
        iterations: arguments.iterations,
        photons_shot: settings.photons.per_iteration,
        samples_per_iteration: settings.photons.samples,
        alpha: settings.photons.alpha,
        path_length_max: settings.path_length_max,
        roulette_after: settings.roulette_after,
        seed: settings.seed,
    }
}
