//! `bench overhead`.

use indicatif::ProgressBar;

use super::args::OverheadArguments;
use super::measure::{compare_modes, machine, progress_bar};
use super::report::{check_outputs, deliver};
use super::subject::{Renderable, Subject, load_all};
use super::work;
use crate::bench::Machine;
use crate::bench::costs::Costs;
use crate::bench::overhead::{Case, Conditions, Overhead};
use crate::cli::render::{color_of, name_of};
use crate::cli::{CliError, job, system};
use crate::render::threads::Threads;
use crate::render::{Integrator, Mode, Settings};

/// Samples per pixel of a round, and of an iteration of photons, where no number is typed.
const SAMPLES: u32 = 16;

/// What is to be done with each scene: settings, polarized, with the samples of a round.
type Plan = Vec<Settings>;

/// Scalar against polarized.
pub fn overhead(arguments: &OverheadArguments) -> Result<(), CliError> {
    let plan = plan(arguments)?;
    let size = work::size(&arguments.work, None)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    job::check_memory(&plan[0], size, system::available_memory())?;
    let subjects = load_all(&arguments.scenes)?;
    work::check_names(&subjects, &arguments.integrator)?;
    let baked = subjects.iter().map(|subject| Ok((subject, subject.bake(plan[0].color, size)?)));
    let baked: Vec<(&Subject, Box<dyn Renderable>)> = baked.collect::<Result<_, CliError>>()?;
    let threads = Threads::start(arguments.work.threads)?;
    let cases = baked.len() * plan.len();
    let progress = progress_bar(cases as u64 * (u64::from(arguments.rounds) + 1));
    let measured = baked.iter().flat_map(|(subject, scene)| {
        let case = |settings| {
            case(subject, scene.as_ref(), settings, arguments.rounds, &threads, &progress)
        };
        plan.iter().map(case).collect::<Vec<Case>>()
    });
    let cases = measured.collect();
    progress.finish_and_clear();
    let conditions = conditions(arguments, &plan[0], size, machine(&threads));
    let report = Overhead { conditions, cases };
    let machine = &report.conditions.machine;
    deliver(&report, output, ("overhead", machine))
}

/// Checks what was typed.
fn plan(arguments: &OverheadArguments) -> Result<Plan, CliError> {
    let OverheadArguments { integrator, work, samples_per_iteration, .. } = arguments;
    let typed = [
        ("--photons", work.photons.is_some()),
        ("--samples-per-iteration", samples_per_iteration.is_some()),
    ];
    work::check_photons(integrator, &typed)?;
    let of_photons = samples_per_iteration.unwrap_or(SAMPLES);
    job::within("--samples-per-iteration", of_photons, job::SPP_MAX, "")?;
    let settings = |&name| {
        let integrator = job::integrator(name);
        let of_iteration = if integrator == Integrator::Ppm { of_photons } else { 1 };
        let samples = job::samples(arguments.spp, arguments.iterations, SAMPLES, of_iteration)?;
        // One more round warms up.
        job::within("--rounds", arguments.rounds, job::SPP_MAX / samples - 1, "")?;
        let settings = work::settings(work, integrator, of_iteration)?;
        Ok(Settings { iterations: samples, ..settings })
    };
    integrator.iter().map(settings).collect()
}

fn case(
    subject: &Subject,
    scene: &dyn Renderable,
    polarized: &Settings,
    rounds: u32,
    threads: &Threads,
    progress: &ProgressBar,
) -> Case {
    let integrator = name_of(polarized.integrator);
    progress.set_message(format!("{}, {integrator}", subject.name));
    let scalar = Settings { mode: Mode::Scalar, ..*polarized };
    let samples = polarized.iterations;
    let modes = [&scalar, polarized];
    let (rounds, develop) = compare_modes(scene, modes, (rounds, samples), threads, progress);
    let photons = &polarized.photons;
    let shot = u64::from(photons.per_iteration) * u64::from(samples / photons.samples);
    Case {
        scene: subject.short_name(),
        integrator: integrator.into(),
        samples,
        photons_shot: (polarized.integrator == Integrator::Ppm).then_some(shot),
        costs: Costs::new(rounds),
        develop,
    }
}

fn conditions(
    arguments: &OverheadArguments,
    settings: &Settings,
    (width, height): (u32, u32),
    machine: Machine,
) -> Conditions {
    Conditions {
        machine,
        color: color_of(settings.color),
        width,
        height,
        rounds: arguments.rounds,
        path_length_max: settings.path_length_max,
        roulette_after: settings.roulette_after,
        seed: settings.seed,
    }
}
