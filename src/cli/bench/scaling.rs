//! `bench scaling`.

use super::args::ScalingArguments;
use super::report::{check_outputs, deliver};
use super::{progress_of, work};
use crate::bench::measure::processors;
use crate::bench::measure::scaling::{self as measure, Base, Plan, film_of};
use crate::cli::{CliError, job};
use crate::render::Options;
use crate::render::memory::check_memory;
use crate::render::settings::SAMPLES_MAX;

/// Times over sizes.
pub fn scaling(arguments: &ScalingArguments) -> Result<(), CliError> {
    let base = base(arguments)?;
    let plans: Vec<Plan> = arguments.series.iter().map(|name| Plan::of(name.0, &base)).collect();
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), arguments.scene.as_slice())?;
    for point in plans.iter().flat_map(|plan| &plan.points) {
        check_memory(&point.options, film_of(&point.options))?;
    }
    let subject = match &arguments.scene {
        Some(path) => work::load(path, &arguments.work.files)?,
        None => work::load_all(&[], &arguments.work.files)?.swap_remove(0),
    };
    let points: u64 = plans.iter().map(|plan| plan.points.len() as u64).sum();
    let progress = progress_of(points * (u64::from(arguments.rounds) + 1));
    let report = measure::scaling(&subject, &plans, &base, &progress)?;
    progress.finish();
    deliver(&report, output, ("scaling", &report.conditions.machine))
}

/// Checks what was typed.
fn base(arguments: &ScalingArguments) -> Result<Base, CliError> {
    let ScalingArguments { work, series, integrator, rounds, .. } = arguments;
    let typed = [("--photons", work.photons.is_some())];
    work::refuse_photons(std::slice::from_ref(integrator), &typed)?;
    job::within("--rounds", *rounds, 1000, "")?;
    job::within("--spp", arguments.spp.unwrap_or(1), SAMPLES_MAX, "")?;
    job::within("--points", arguments.points.unwrap_or(1), 1000, "")?;
    if (1..series.len()).any(|index| series[..index].contains(&series[index])) {
        return Err(CliError::Usage("--series names a series twice".into()));
    }
    let options = work::options(work, integrator.0, 1, work::size(work, None)?)?;
    Ok(Base {
        options: Options { mode: arguments.mode.0, ..options.clone() },
        threads: work.threads.or_else(processors).unwrap_or(1),
        samples: arguments.spp,
        film: [work.width, work.height],
        points_max: arguments.points.map_or(usize::MAX, |points| points as usize),
        rounds: *rounds,
    })
}
