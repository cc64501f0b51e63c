//! The verb `batch`: many renders from one job file.

mod check;
mod options;

use std::collections::{BTreeSet, HashMap};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::HumanDuration;

use crate::batch::file::JobFile;
use crate::batch::order::{Checksums, Order};
use crate::batch::results::{Record, Results};
use crate::batch::run::{Batch, News};
use crate::math::text::{counted, excerpt};
use crate::render::threads::Threads;

use super::args::BatchArguments;
use super::files::{print, say};
use super::interrupt::{Signal, signals};
use super::progress::Progress;
use super::{CliError, job, render};

use check::Inputs;

/// Most troubles of a job file that are listed.
const TOLD_MAX: usize = 1000;
/// Most characters of a trouble, and of a warning.
const CHARACTERS_MAX: usize = 2000;
const JOBS: [&str; 2] = ["job", "jobs"];

/// Renders what a job file asks for and what has not been done.
pub(super) fn batch(arguments: &BatchArguments) -> Result<(), CliError> {
    job::check_threads(arguments.threads)?;
    let path = &arguments.jobs;
    let file = JobFile::read(path).map_err(|wrong| refused(path, &[wrong]))?;
    let beside = || file.folder.join("results.jsonl");
    let results_path = arguments.results.clone().unwrap_or_else(beside);
    let inputs = Inputs { jobs: path, results: &results_path };
    let orders = check::orders(&file, &inputs, arguments.allow_outside);
    let orders = orders.map_err(|wrong| refused(path, &wrong))?;
    let jobs = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let checksums = Checksums::default();
    if arguments.dry_run {
        return list(&file, &orders, &Results::look(&results_path), &checksums);
    }
    let refuse = |error: crate::batch::results::ResultsError| {
        CliError::Refused(format!("{error}\n  nothing has been rendered"))
    };
    let mut results = Results::open(&results_path).map_err(refuse)?;
    let (done, left) = divided(&file, orders, &results.records(), &checksums, &jobs);
    results.begin(&jobs, &done).map_err(refuse)?;
    let threads = Arc::new(Threads::start(arguments.threads)?);
    let batch = Batch {
        orders: &left,
        jobs,
        folder: file.folder.clone(),
        threads,
        allow_outside: arguments.allow_outside,
        checksums: &checksums,
        facts: vec![("command".to_owned(), render::command())],
    };
    let start = Instant::now();
    let mut course = Course::new(arguments, &left, results);
    let signal = signals()?;
    batch.run(|news| {
        course.hear(news);
        if signal().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    course.progress.finish();
    course.close(arguments, (done.len(), left.len()), start.elapsed(), signal())
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

/// Prints what would be done.
fn list(
    file: &JobFile,
    orders: &[Order],
    records: &HashMap<String, Record>,
    checksums: &Checksums,
) -> Result<(), CliError> {
    let mut left = 0;
    for order in orders {
        let record = records.get(&order.output_name);
        let is_done = record.is_some_and(|it| order.is_done_by(it, &file.folder, checksums));
        left += usize::from(!is_done);
        let state = if is_done { "done" } else { "to do" };
        print(format_args!(
            "{:>5}  {state:<5}  {}  {}",
            order.index,
            order.output_name,
            order.label()
        ))?;
    }
    print(format_args!("{}, {left} to do", counted(orders.len(), JOBS)))
}

/// The records of the jobs that have been done, and the orders of the others.
fn divided(
    file: &JobFile,
    orders: Vec<Order>,
    records: &HashMap<String, Record>,
    checksums: &Checksums,
    jobs: &str,
) -> (Vec<Record>, Vec<Order>) {
    let (mut done, mut left) = (Vec::new(), Vec::new());
    for order in orders {
        match records.get(&order.output_name) {
            Some(record) if order.is_done_by(record, &file.folder, checksums) => {
                let Order { index, name, values, .. } = order;
                done.push(Record { jobs: jobs.to_owned(), index, name, values, ..record.clone() });
            }
            _ => left.push(order),
        }
    }
    (done, left)
}

/// A batch on its way.
struct Course<'a> {
    orders: HashMap<usize, &'a Order>,
    results: Results,
    progress: Progress,
    ended: usize,
    failed: usize,
    /// Why results could not be written, the first time.
    unwritten: Option<String>,
    /// Warnings that have been said.
    said: BTreeSet<String>,
}

impl<'a> Course<'a> {
    fn new(arguments: &BatchArguments, orders: &'a [Order], results: Results) -> Self {
        let cost = orders.iter().map(Order::cost).fold(0, u64::saturating_add);
        let template = "{wide_bar} {msg}, {eta} left";
        let progress = match arguments.quiet {
            true => Progress::none(),
            false => Progress::of(cost, "samples", template),
        };
        let orders = orders.iter().map(|order| (order.index, order)).collect();
        let (said, unwritten) = (BTreeSet::new(), None);
        let course = Self { orders, results, progress, ended: 0, failed: 0, unwritten, said };
        course.tell();
        course
    }

    fn tell(&self) {
        self.progress.tell(format!("{} of {}", self.ended, counted(self.orders.len(), JOBS)));
    }

    /// Notes what has happened, and says it if it is worth it.
    fn hear(&mut self, news: News) {
        match news {
            News::Progress(done) => self.progress.set(done),
            News::Ended { record, warnings } => {
                self.ended += 1;
                if let Err(error) = self.results.add(&record)
                    && self.unwritten.is_none()
                {
                    self.say(&format!("error: {error}"));
                    self.unwritten = Some(error.to_string());
                }
                let label = match self.orders.get(&record.index) {
                    Some(order) => order.label(),
                    None => record.name.clone(),
                };
                if let Some(error) = &record.error {
                    self.failed += 1;
                    self.say(&format!("error: job {} {label}: {error}", record.index));
                }
                for warning in warnings {
                    if self.said.insert(excerpt(&warning, CHARACTERS_MAX)) {
                        let (kind, text) = warning.split_once(": ").unwrap_or(("note", &warning));
                        self.say(&format!("{kind}: job {} {label}: {text}", record.index));
                    }
                }
                self.tell();
            }
        }
    }

    fn say(&self, text: &str) {
        self.progress.aside(|| say(text));
    }

    /// Says what has become of the batch.
    fn close(
        self,
        arguments: &BatchArguments,
        (done, asked): (usize, usize),
        time: Duration,
        signal: Option<Signal>,
    ) -> Result<(), CliError> {
        let Self { ended, failed, unwritten, .. } = self;
        let rendered = ended - failed;
        if let Some(signal) = signal.filter(|_| ended < asked) {
            let left = asked - ended;
            let text = format!("{rendered} rendered, {left} left; start the batch again to go on");
            return Err(CliError::BatchInterrupted { signal, text });
        }
        let path = arguments.jobs.display();
        if !arguments.quiet {
            let before =
                if done > 0 { format!(", {done} were done before") } else { String::new() };
            let rendered = counted(rendered, ["image", "images"]);
            say(format_args!("{path}: {rendered} in {}{before}", HumanDuration(time)));
        }
        if failed > 0 {
            return Err(CliError::System(format!("{path}: {} failed", counted(failed, JOBS))));
        }
        unwritten.map_or(Ok(()), |text| Err(CliError::System(text)))
    }
}
