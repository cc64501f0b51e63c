//! `bench wavelengths`.

use super::args::OverheadArguments;
use super::overhead::plan;
use super::report::{check_outputs, deliver};
use super::{progress_of, work};
use crate::bench::measure::overhead::rounds_in_all;
use crate::bench::measure::wavelengths::{self as measure, carried};
use crate::cli::CliError;
use crate::render::Settings;
use crate::render::memory::check_memory;
use crate::render::threads::Threads;

/// One, three, four and eight wavelengths.
pub fn wavelengths(arguments: &OverheadArguments) -> Result<(), CliError> {
    if arguments.work.color.wavelengths.is_some() {
        let problem = "--wavelengths: every number of them is measured; leave it out";
        return Err(CliError::Usage(problem.to_owned()));
    }
    let size = work::size(&arguments.work, None)?;
    let plan = plan(arguments, size)?;
    let output = &arguments.output;
    check_outputs(&output.report, output.record.as_deref(), &arguments.scenes)?;
    for carried in plan.iter().flat_map(carried) {
        check_memory(&*Settings::new(carried.options)?, size)?;
    }
    let subjects = work::load_all(&arguments.scenes, &arguments.work.files)?;
    work::check_names(&subjects, &arguments.integrator)?;
    let threads = Threads::start(arguments.work.threads)?;
    let rounds = arguments.rounds;
    let progress = progress_of(subjects.len() as u64 * rounds_in_all(&plan, rounds));
    let report = measure::wavelengths(&subjects, &plan, rounds, &threads, &progress)?;
    progress.finish();
    deliver(&report, output, ("wavelengths", &report.conditions.machine))
}
