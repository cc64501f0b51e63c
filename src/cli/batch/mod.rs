//! The verb `batch`: many renders from one job file, at once or in tasks.

pub mod args;
mod course;
pub mod farm;
mod options;

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::batch::check::WrongOption;
use crate::batch::file::Job;
use crate::batch::order::Order;
use crate::batch::prepared::{Asked, Prepared, Work};
use crate::batch::results::ResultsError;
use crate::math::text::counted;
use crate::render::threads::Threads;

use super::args::BatchArguments;
use super::files::{print, say};
use super::interrupt::signals;
use super::{CliError, job, render};

use course::Course;
use options::Reader;

/// Most characters of a warning.
const CHARACTERS_MAX: usize = 2000;
const JOBS: [&str; 2] = ["job", "jobs"];
const IMAGES: [&str; 2] = ["image", "images"];
const PARTS: [&str; 2] = ["part", "parts"];

/// Renders what a job file asks for and what has not been done, or a share of it, or merges what
/// shares have become.
pub(super) fn batch(arguments: &BatchArguments) -> Result<(), CliError> {
    job::check_threads(arguments.threads)?;
    let asked = Asked {
        jobs: arguments.jobs.clone(),
        results: arguments.results.clone(),
        allow_outside: arguments.allow_outside,
        work: work(arguments)?,
    };
    let prepared = prepared(asked)?;
    // What is counted, and what is made of it.
    let [unit, made] = match asked_for_parts(arguments, &prepared) {
        true => [PARTS; 2],
        false => [JOBS, IMAGES],
    };
    if arguments.dry_run {
        return list(&prepared, unit);
    }
    let mut begun = prepared.begin().map_err(|error: ResultsError| refused(&error.to_string()))?;
    let is_loud = |text: &&String| !(arguments.quiet && text.starts_with("note: "));
    begun.notes().iter().filter(is_loud).for_each(say);
    let threads = Arc::new(Threads::start(arguments.threads)?);
    let start = Instant::now();
    let mut course = Course::new(arguments, &begun, [unit, made]);
    let signal = signals()?;
    begun.run(&threads, vec![("command".to_owned(), render::command())], |news| {
        course.hear(news);
        if signal().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    course.close(start.elapsed(), signal())
}

/// What is typed to have a batch done in tasks.
fn work(arguments: &BatchArguments) -> Result<Work, CliError> {
    let tasks = &arguments.tasks;
    match (tasks.task, tasks.merge, tasks.parts) {
        (Some(share), _, parts) => Ok(Work::Share(share, parts)),
        (None, true, parts) => Ok(Work::Merge(parts)),
        (None, false, None) => Ok(Work::All),
        (None, false, Some(_)) => {
            Err(CliError::Usage("--parts goes with --task or --merge".to_owned()))
        }
    }
}

/// A batch of which the file alone shows nothing that is wrong.
fn prepared(asked: Asked) -> Result<Prepared, CliError> {
    let mut read = reader(asked.allow_outside);
    Prepared::read(asked, &mut read).map_err(|wrong| refused(&wrong.to_string()))
}

fn refused(text: &str) -> CliError {
    CliError::Refused(format!("{text}\n  nothing has been rendered"))
}

fn asked_for_parts(arguments: &BatchArguments, prepared: &Prepared) -> bool {
    prepared.parts() > 1 && !arguments.tasks.merge
}

/// What reads the options of jobs, which are those of `render`.
pub fn reader(allow_outside: bool) -> impl FnMut(&Job, &Path) -> Result<Order, Vec<WrongOption>> {
    let mut reader = Reader::new(allow_outside);
    move |job, folder| reader.order(job, folder)
}

/// Prints what would be done.
fn list(prepared: &Prepared, unit: [&str; 2]) -> Result<(), CliError> {
    let (mut all, mut left) = (0, 0);
    let (unread, rows) = prepared.look();
    unread.iter().for_each(|text| say(format_args!("warning: {text}")));
    for (order, record) in rows {
        all += 1;
        left += usize::from(record.is_none());
        let state = if record.is_some() { "done" } else { "to do" };
        let (index, output) = (order.index, &order.output_name);
        print(format_args!("{index:>5}  {state:<5}  {output}  {}", order.label()))?;
    }
    print(format_args!("{}, {left} to do", counted(all, unit)))
}
