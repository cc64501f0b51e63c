//! The verb `batch`: many renders from one job file, at once or in tasks.

pub mod args;
mod check;
mod course;
pub mod farm;
mod options;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use crate::batch::file::JobFile;
use crate::batch::known::{Known, folder_of_tasks, remove_files_of_tasks};
use crate::batch::merging::{Leftovers, Merging};
use crate::batch::order::{Checksums, Order};
use crate::batch::results::{Record, Results, ResultsError};
use crate::batch::run::{Batch, How};
use crate::batch::share::Share;
use crate::math::text::{counted, excerpt};
use crate::render::SettingsError;
use crate::render::threads::Threads;

use super::args::BatchArguments;
use super::files::print;
use super::interrupt::signals;
use super::{CliError, job, render};

use check::Inputs;
use course::Course;

/// Most troubles of a job file that are listed.
const TOLD_MAX: usize = 1000;
/// Most characters of a trouble, and of a warning.
const CHARACTERS_MAX: usize = 2000;
const JOBS: [&str; 2] = ["job", "jobs"];
const IMAGES: [&str; 2] = ["image", "images"];
const PARTS: [&str; 2] = ["part", "parts"];

/// What a job file asks for, and nothing is wrong with it.
struct Asked<'a> {
    arguments: &'a BatchArguments,
    file: JobFile,
    orders: Vec<Order>,
    /// The file name of the job file.
    jobs: String,
    results: PathBuf,
    /// Parts of each image, if it is done in tasks.
    parts: u32,
    checksums: Checksums,
}

/// Renders what a job file asks for and what has not been done, or a share of it, or merges what
/// shares have become.
pub(super) fn batch(arguments: &BatchArguments) -> Result<(), CliError> {
    job::check_threads(arguments.threads)?;
    let asked = Asked::read(arguments)?;
    if arguments.dry_run {
        return asked.list();
    }
    match arguments.tasks.task {
        Some(share) => asked.render_share(share),
        None if arguments.tasks.merge => asked.merge(),
        None => asked.render(),
    }
}

/// Where results are noted.
fn results_of(file: &JobFile, typed: Option<&Path>) -> PathBuf {
    typed.map_or_else(|| file.folder.join("results.jsonl"), Path::to_owned)
}

/// All that is wrong with a job file.
fn refused(path: &Path, wrong: &[String]) -> CliError {
    let path = excerpt(&path.display().to_string(), CHARACTERS_MAX);
    let mut text = match wrong {
        [only] => format!("{path}: {only}"),
        _ => {
            let lines = wrong.iter().take(TOLD_MAX).map(|text| format!("\n  {text}"));
            format!("{path}: {} things are wrong{}", wrong.len(), lines.collect::<String>())
        }
    };
    if wrong.len() > TOLD_MAX {
        text += &format!("\n  and {} more", wrong.len() - TOLD_MAX);
    }
    CliError::Refused(text + "\n  nothing has been rendered")
}

fn refused_results(error: ResultsError) -> CliError {
    CliError::Refused(format!("{error}\n  nothing has been rendered"))
}

/// Settings that were found to be good.
fn refused_parts(error: SettingsError) -> CliError {
    CliError::Refused(format!("{error}\n  nothing has been rendered"))
}

impl<'a> Asked<'a> {
    fn read(arguments: &'a BatchArguments) -> Result<Self, CliError> {
        let path = &arguments.jobs;
        let file = JobFile::read(path).map_err(|wrong| refused(path, &[wrong]))?;
        let results = results_of(&file, arguments.results.as_deref());
        let tasks = &arguments.tasks;
        let parts = match (tasks.task.is_some() || tasks.merge, tasks.parts) {
            (true, typed) => typed.unwrap_or(file.farm.parts),
            (false, None) => 1,
            (false, Some(_)) => {
                return Err(CliError::Usage("--parts goes with --task or --merge".to_owned()));
            }
        };
        let inputs = Inputs { jobs: path, results: &results, parts };
        let orders = check::orders(&file, &inputs, arguments.allow_outside);
        let orders = orders.map_err(|wrong| refused(path, &wrong))?;
        let jobs = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { arguments, file, orders, jobs, results, parts, checksums: Checksums::default() })
    }

    /// What is known of these and of what tasks have done.
    fn known(&self, records: impl IntoIterator<Item = Record>) -> Known {
        Known::with_tasks(records, &self.results, &self.jobs)
    }

    fn done<'k>(&self, known: &'k Known, order: &Order) -> Option<&'k Record> {
        known.done(order, &self.file.folder, &self.checksums)
    }

    /// The records of the jobs that have been done, and the orders of the others.
    fn divided(&self, known: &Known) -> (Vec<Record>, Vec<Order>) {
        let (mut done, mut left) = (Vec::new(), Vec::new());
        for order in &self.orders {
            match self.done(known, order) {
                Some(record) => {
                    let Order { index, name, values, .. } = order.clone();
                    let jobs = self.jobs.clone();
                    done.push(Record { jobs, index, name, values, ..record.clone() });
                }
                None => left.push(order.clone()),
            }
        }
        (done, left)
    }

    /// The pieces of a share, and which of them are left.
    fn pieces(&self, share: Share, known: &Known) -> Result<Vec<(Order, bool)>, CliError> {
        let pieces = share.pieces(&self.orders, self.parts).map_err(refused_parts)?;
        let mut latest: Option<(usize, bool)> = None;
        let with_state = pieces.into_iter().map(|piece| {
            // Parts whose image is there are no longer needed.
            let is_whole = match latest {
                Some((index, is_whole)) if index == piece.index => is_whole,
                _ => self.done(known, &self.orders[piece.index]).is_some(),
            };
            latest = Some((piece.index, is_whole));
            let is_left = !is_whole && self.done(known, &piece).is_none();
            (piece, is_left)
        });
        Ok(with_state.collect())
    }

    /// Prints what would be done.
    fn list(&self) -> Result<(), CliError> {
        let known = self.known(Results::look(&self.results));
        let rows: Vec<(Order, bool)> = match self.arguments.tasks.task {
            Some(share) => self.pieces(share, &known)?,
            None => {
                let is_left = |order: &Order| self.done(&known, order).is_none();
                self.orders.iter().map(|order| (order.clone(), is_left(order))).collect()
            }
        };
        for (order, is_left) in &rows {
            let state = if *is_left { "to do" } else { "done" };
            let (index, output) = (order.index, &order.output_name);
            print(format_args!("{index:>5}  {state:<5}  {output}  {}", order.label()))?;
        }
        let left = rows.iter().filter(|(_, is_left)| *is_left).count();
        print(format_args!("{}, {left} to do", counted(rows.len(), self.unit([JOBS, PARTS]))))
    }

    /// What pieces are called, by whether they are images or parts.
    fn unit(&self, [image, part]: [[&'static str; 2]; 2]) -> [&'static str; 2] {
        if self.parts > 1 && !self.arguments.tasks.merge { part } else { image }
    }

    fn render(&self) -> Result<(), CliError> {
        let mut results = Results::open(&self.results).map_err(refused_results)?;
        let (done, left) = self.divided(&self.known(results.records()));
        results.begin(&self.jobs, &done).map_err(refused_results)?;
        self.run(How::Once, &left, done.len(), results, |_| Ok(())).map(drop)
    }

    /// Renders what is left of a share, and notes it in a file that nobody else writes.
    fn render_share(&self, share: Share) -> Result<(), CliError> {
        let known = self.known(Results::look(&self.results));
        let pieces = self.pieces(share, &known)?;
        let count = pieces.len();
        let left: Vec<Order> =
            pieces.into_iter().filter(|(_, is_left)| *is_left).map(|(piece, _)| piece).collect();
        let path = folder_of_tasks(&self.results).join(share.file_name(&self.jobs));
        let results = Results::open_of_task(&path).map_err(refused_results)?;
        self.run(How::Again, &left, count - left.len(), results, |_| Ok(()))
    }

    /// Makes one batch of what tasks have done.
    fn merge(&self) -> Result<(), CliError> {
        let mut results = Results::open(&self.results).map_err(refused_results)?;
        // What failed is told by tasks; errors in the results are those of former merges.
        let known = self.known(results.records().filter(|record| record.error.is_none()));
        let (done, left) = self.divided(&known);
        let leftovers = Leftovers::find(&self.orders);
        results.begin(&self.jobs, &done).map_err(refused_results)?;
        let is_left = |error: std::io::Error| {
            CliError::System(format!("what is no longer needed is left: {error}"))
        };
        for record in &done {
            leftovers.remove(&self.orders[record.index].output).map_err(is_left)?;
        }
        let merging = Merging { known: &known, parts: self.parts, there: &leftovers };
        let remove = |record: &Record| leftovers.remove(&self.orders[record.index].output);
        self.run(How::Merging(&merging), &left, done.len(), results, remove)?;
        remove_files_of_tasks(&self.results, &self.jobs).map_err(is_left)
    }

    /// Does what is left; `after` is done when it is noted that a job is done.
    fn run(
        &self,
        how: How,
        left: &[Order],
        done: usize,
        results: Results,
        after: impl Fn(&Record) -> std::io::Result<()>,
    ) -> Result<(), CliError> {
        let batch = Batch {
            orders: left,
            how,
            jobs: self.jobs.clone(),
            folder: self.file.folder.clone(),
            threads: Arc::new(Threads::start(self.arguments.threads)?),
            allow_outside: self.arguments.allow_outside,
            checksums: &self.checksums,
            facts: vec![("command".to_owned(), render::command())],
        };
        let start = Instant::now();
        let unit = self.unit([JOBS, PARTS]);
        let mut course = Course::new(self.arguments, left, unit, results);
        let signal = signals()?;
        batch.run(|news| {
            if let Some(record) = course.hear(news)
                && let Err(error) = after(&record)
            {
                course.warn(&format!("what is no longer needed is left: {error}"));
            }
            if signal().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        course.close(self.unit([IMAGES, PARTS]), done, start.elapsed(), signal())
    }
}
