//! `bench overhead`.

use indicatif::ProgressBar;

use super::args::OverheadArguments;
use super::measure::{compare_modes, machine, progress_bar};
use super::report::{check_outputs, deliver};
use super::subject::{Subject, load_all};
use super::work;
use crate::bench::Machine;
use crate::bench::costs::Costs;
use crate::bench::overhead::{Case, Conditions, Overhead};
use crate::cli::args::IntegratorName;
use crate::cli::{CliError, job};
use crate::render::memory::check_memory;
use crate::render::settings::SAMPLES_MAX;
use crate::render::threads::Threads;
use crate::render::{Mode, Options, Settings};

/// Samples per pixel of a round, and of an iteration of photons, where no number is typed.
const SAMPLES: u32 = 16;

/// What is to be done with each scene: options, polarized, with the samples of a round.
type Plan = Vec<Options>;

/// Scalar against polarized.
pub fn overhead(arguments: &OverheadArguments) -> Result<(), CliError> {
    let size = work::size(&arguments.work, None)?;
    let plan = plan(arguments, size)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    check_memory(&plan[0], size)?;
    let subjects = load_all(&arguments.scenes)?;
    work::check_names(&subjects, &arguments.integrator)?;
    let threads = Threads::start(arguments.work.threads)?;
    let cases = subjects.len() * plan.len();
    let progress = progress_bar(cases as u64 * (u64::from(arguments.rounds) + 1));
    let mut cases = Vec::new();
    for subject in &subjects {
        for options in &plan {
            cases.push(case(subject, options, arguments.rounds, &threads, &progress)?);
        }
    }
    progress.finish_and_clear();
    let conditions = conditions(arguments, &plan[0], size, machine(&threads));
    let report = Overhead { conditions, cases };
    let machine = &report.conditions.machine;
    deliver(&report, output, ("overhead", machine))
}

/// Checks what was typed.
fn plan(arguments: &OverheadArguments, size: [u32; 2]) -> Result<Plan, CliError> {
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

fn case(
    subject: &Subject,
    options: &Options,
    rounds: u32,
    threads: &Threads,
    progress: &ProgressBar,
) -> Result<Case, CliError> {
    let integrator = options.integrator.name();
    progress.set_message(format!("{}, {integrator}", subject.name));
    let polarized = Settings::new(*options)?;
    let scalar = Settings::new(Options { mode: Mode::Scalar, ..*options })?;
    let (modes, samples) = ([&scalar, &polarized], options.samples);
    let world = &subject.world;
    let (rounds, develop) = compare_modes(world, modes, (rounds, samples), threads, progress)?;
    let photons = &options.photons;
    let shot = u64::from(photons.per_iteration) * u64::from(samples / photons.samples);
    Ok(Case {
        scene: subject.short_name(),
        integrator: integrator.into(),
        samples,
        photons_shot: options.integrator.shoots_photons().then_some(shot),
        costs: Costs::new(rounds),
        develop,
    })
}

fn conditions(
    arguments: &OverheadArguments,
    settings: &Options,
    [width, height]: [u32; 2],
    machine: Machine,
) -> Conditions {
    Conditions {
        machine,
        color: settings.color.to_string(),
        width,
        height,
        rounds: arguments.rounds,
        path_length_max: settings.path_length_max,
        roulette_after: settings.roulette_after,
        seed: settings.seed,
    }
}
