//! `bench overhead`.

use super::args::OverheadArguments;
use super::report::{check_outputs, deliver};
use super::{progress_of, work};
use crate::bench::measure::overhead::{self as measure, rounds_in_all};
use crate::cli::args::IntegratorName;
use crate::cli::{CliError, job};
use crate::render::Options;
use crate::render::memory::check_memory;
use crate::render::settings::SAMPLES_MAX;
use crate::render::threads::Threads;

/// Samples per pixel of a round, and of an iteration of photons, where no number is typed.
const SAMPLES: u32 = 16;

/// What is to be done with each scene: options, polarized, with the samples of a round.
pub(super) type Plan = Vec<Options>;

/// Scalar against polarized.
pub fn overhead(arguments: &OverheadArguments) -> Result<(), CliError> {
    let size = work::size(&arguments.work, None)?;
    let plan = plan(arguments, size)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    check_memory(&plan[0], size)?;
    let subjects = work::load_all(&arguments.scenes, &arguments.work.files)?;
    work::check_names(&subjects, &arguments.integrator)?;
    let threads = Threads::start(arguments.work.threads)?;
    let rounds = arguments.rounds;
    let progress = progress_of(subjects.len() as u64 * rounds_in_all(&plan, rounds));
    let report = measure::overhead(&subjects, &plan, rounds, &threads, &progress)?;
    progress.finish();
    deliver(&report, output, ("overhead", &report.conditions.machine))
}

/// Checks what was typed.
pub(super) fn plan(arguments: &OverheadArguments, size: [u32; 2]) -> Result<Plan, CliError> {
    let OverheadArguments { integrator, work, samples_per_iteration, .. } = arguments;
    let typed = [
        ("--photons", work.photons.is_some()),
        ("--samples-per-iteration", samples_per_iteration.is_some()),
    ];
    work::refuse_photons(integrator, &typed)?;
    let of_photons = samples_per_iteration.unwrap_or(SAMPLES);
    job::within("--samples-per-iteration", of_photons, SAMPLES_MAX, "")?;
    let options = |&IntegratorName(integrator)| {
        let of_iteration = if integrator.shoots_photons() { of_photons } else { 1 };
        let samples = job::samples(arguments.spp, arguments.iterations, SAMPLES, of_iteration)?;
        // One more round warms up.
        job::within("--rounds", arguments.rounds, SAMPLES_MAX / samples - 1, "")?;
        Ok(Options { samples, ..work::options(work, integrator, of_iteration, size)? })
    };
    integrator.iter().map(options).collect()
}
