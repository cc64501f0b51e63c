//! `bench table1`.

use super::args::Table1Arguments;
use super::measure::{compare_modes, machine, progress_bar};
use super::report::{check_outputs, deliver};
use super::subject::{Renderable, Subject, load_all};
use crate::bench::Machine;
use crate::bench::table1::{Conditions, SceneReport, Table1};
use crate::cli::args::{PATH_LENGTH, ROULETTE_AFTER};
use crate::cli::{CliError, job, system};
use crate::render::threads::Threads;
use crate::render::{Integrator, Mode, Photons, Settings};
use crate::spectrum::Color;

/// The paper's Table 1.
pub fn table1(arguments: &Table1Arguments) -> Result<(), CliError> {
    let polarized = settings(arguments)?;
    let scalar = Settings { mode: Mode::Scalar, ..polarized };
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    let size = (arguments.width, arguments.height);
    job::check_memory(&polarized, size, system::available_memory())?;
    let subjects = load_all(&arguments.scenes)?;
    if output.record.is_some() {
        super::work::check_names(&subjects, &[])?;
    }
    let baked = subjects.iter().map(|subject| Ok((subject, subject.bake(polarized.color, size)?)));
    let baked: Vec<(&Subject, Box<dyn Renderable>)> = baked.collect::<Result<_, CliError>>()?;
    let threads = Threads::start(arguments.threads)?;
    let rounds = (arguments.iterations, arguments.samples_per_iteration);
    let progress = progress_bar(baked.len() as u64 * (u64::from(arguments.iterations) + 1));
    let measured = baked.iter().map(|(subject, scene)| {
        progress.set_message(subject.name.clone());
        let modes = [&scalar, &polarized];
        let (rounds, _) = compare_modes(scene.as_ref(), modes, rounds, &threads, &progress);
        SceneReport::new(subject.name.clone(), subject.paper, rounds)
    });
    let scenes: Vec<SceneReport> = measured.collect();
    progress.finish_and_clear();
    let conditions = conditions(arguments, &polarized, machine(&threads));
    let report = Table1::new(conditions, scenes);
    let machine = &report.conditions.machine;
    deliver(&report, output, ("table1", machine))
}

/// Checks what was typed; for the polarized half, from which the other differs in its mode alone.
fn settings(arguments: &Table1Arguments) -> Result<Settings, CliError> {
    let Table1Arguments { photons, samples_per_iteration: samples, .. } = *arguments;
    job::within("--photons", photons, job::PHOTONS_MAX, "")?;
    job::within("--samples-per-iteration", samples, job::SPP_MAX, "")?;
    // One more warms up.
    job::within("--iterations", arguments.iterations, job::SPP_MAX / samples - 1, "")?;
    job::check_threads(arguments.threads)?;
    job::within("--width", arguments.width, job::EDGE_MAX, "")?;
    job::within("--height", arguments.height, job::EDGE_MAX, "")?;
    job::check_film_size(arguments.width, arguments.height)?;
    Ok(Settings {
        integrator: Integrator::Ppm,
        mode: Mode::Polarized,
        color: Color::Rgb,
        iterations: (1 + arguments.iterations) * samples,
        replicates: 1,
        path_length_max: PATH_LENGTH,
        roulette_after: ROULETTE_AFTER,
        seed: arguments.seed,
        photons: Photons { per_iteration: photons, samples, ..Photons::default() },
        time_limit: None,
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
