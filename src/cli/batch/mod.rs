//! The verb `batch`: many renders from one job file.

mod options;

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::HumanDuration;

use crate::batch::file::Job;
use crate::batch::order::Order;
use crate::batch::prepared::{Asked, Begun, Prepared};
use crate::batch::results::ResultsError;
use crate::batch::run::News;
use crate::math::text::{counted, excerpt};
use crate::render::threads::Threads;

use super::args::BatchArguments;
use super::files::{print, say};
use super::interrupt::{Signal, signals};
use super::progress::Progress;
use super::{CliError, job, render};

use options::Reader;

/// Most characters of a warning.
const CHARACTERS_MAX: usize = 2000;
const JOBS: [&str; 2] = ["job", "jobs"];

/// Renders what a job file asks for and what has not been done.
pub(super) fn batch(arguments: &BatchArguments) -> Result<(), CliError> {
    job::check_threads(arguments.threads)?;
    let refuse = |text: String| CliError::Refused(text + "\n  nothing has been rendered");
    let asked = Asked {
        jobs: arguments.jobs.clone(),
        results: arguments.results.clone(),
        allow_outside: arguments.allow_outside,
    };
    let prepared = Prepared::read(asked, &mut reader());
    let prepared = prepared.map_err(|refused| refuse(refused.to_string()))?;
    if arguments.dry_run {
        return list(&prepared);
    }
    let begun = prepared.begin().map_err(|error: ResultsError| refuse(error.to_string()));
    let mut begun = begun?;
    let threads = Arc::new(Threads::start(arguments.threads)?);
    let start = Instant::now();
    let (done, left) = (begun.done().len(), begun.left().len());
    let mut course = Course::new(arguments, &begun);
    let signal = signals()?;
    begun.run(&threads, vec![("command".to_owned(), render::command())], |news| {
        course.hear(news);
        if signal().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    course.progress.finish();
    course.close(arguments, (done, left), start.elapsed(), signal())
}

/// What reads the options of jobs, which are those of `render`.
pub fn reader() -> impl FnMut(&Job, &Path) -> Result<Order, Vec<String>> {
    let mut reader = Reader::new();
    move |job, folder| reader.order(job, folder)
}

/// Prints what would be done.
fn list(prepared: &Prepared) -> Result<(), CliError> {
    let (mut all, mut left) = (0, 0);
    for (order, record) in prepared.look() {
        all += 1;
        left += usize::from(record.is_none());
        let state = if record.is_some() { "done" } else { "to do" };
        print(format_args!(
            "{:>5}  {state:<5}  {}  {}",
            order.index,
            order.output_name,
            order.label()
        ))?;
    }
    print(format_args!("{}, {left} to do", counted(all, JOBS)))
}

/// A batch on its way.
struct Course {
    asked: usize,
    progress: Progress,
    ended: usize,
    failed: usize,
    /// Why results could not be written, the first time.
    unwritten: Option<String>,
    /// Warnings that have been said.
    said: BTreeSet<String>,
}

impl Course {
    fn new(arguments: &BatchArguments, begun: &Begun) -> Self {
        let template = "{wide_bar} {msg}, {eta} left";
        let progress = match arguments.quiet {
            true => Progress::none(),
            false => Progress::of(begun.cost(), "samples", template),
        };
        let (asked, said, unwritten) = (begun.left().len(), BTreeSet::new(), None);
        let course = Self { asked, progress, ended: 0, failed: 0, unwritten, said };
        course.tell();
        course
    }

    fn tell(&self) {
        self.progress.tell(format!("{} of {}", self.ended, counted(self.asked, JOBS)));
    }

    /// Notes what has happened, and says it if it is worth it.
    fn hear(&mut self, news: News) {
        match news {
            News::Progress(done) => self.progress.set(done),
            News::Unwritten(error) => {
                self.say(&format!("error: {error}"));
                self.unwritten = Some(error.to_string());
            }
            News::Ended { order, record, warnings } => {
                self.ended += 1;
                let label = order.label();
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
