//! A batch on its way: what has happened is noted, said and counted.

use std::collections::{BTreeSet, HashMap};
use std::time::Duration;

use indicatif::HumanDuration;

use crate::batch::order::Order;
use crate::batch::results::{Record, Results};
use crate::batch::run::News;
use crate::math::text::{counted, excerpt};

use super::super::CliError;
use super::super::args::BatchArguments;
use super::super::files::say;
use super::super::interrupt::Signal;
use super::super::progress::Progress;
use super::CHARACTERS_MAX;

/// What has become of a batch so far.
pub struct Course<'a> {
    arguments: &'a BatchArguments,
    /// By the names of their outputs.
    orders: HashMap<&'a str, &'a Order>,
    results: Results,
    progress: Progress,
    /// What there is one of for every order: a job or a part.
    unit: [&'static str; 2],
    ended: usize,
    failed: usize,
    /// How many of these another try might mend.
    passing: usize,
    /// Why results could not be written, the first time.
    unwritten: Option<String>,
    /// Warnings that have been said.
    said: BTreeSet<String>,
}

impl<'a> Course<'a> {
    /// At its beginning.
    pub fn new(
        arguments: &'a BatchArguments,
        orders: &'a [Order],
        unit: [&'static str; 2],
        results: Results,
    ) -> Self {
        let cost = orders.iter().map(Order::cost).fold(0, u64::saturating_add);
        let template = "{wide_bar} {msg}, {eta} left";
        let progress = match arguments.quiet {
            true => Progress::none(),
            false => Progress::of(cost, "samples", template),
        };
        let course = Self {
            arguments,
            orders: orders.iter().map(|order| (&*order.output_name, order)).collect(),
            results,
            progress,
            unit,
            ended: 0,
            failed: 0,
            passing: 0,
            unwritten: None,
            said: BTreeSet::new(),
        };
        course.tell();
        course
    }

    fn tell(&self) {
        self.progress.tell(format!("{} of {}", self.ended, counted(self.orders.len(), self.unit)));
    }

    /// Notes what has happened, and says it if it is worth it. Returns the record of a job that has
    /// been done, when that is noted.
    pub fn hear(&mut self, news: News) -> Option<Box<Record>> {
        match news {
            News::Progress(done) => {
                self.progress.set(done);
                None
            }
            News::Again { output, error } => {
                self.say(&format!("warning: job {}: {error}: trying again", self.called(&output)));
                None
            }
            News::Ended { record, warnings, may_pass } => {
                self.ended += 1;
                let noted = self.results.add(&record);
                let is_noted = noted.is_ok();
                if let Err(error) = noted
                    && self.unwritten.is_none()
                {
                    self.say(&format!("error: {error}"));
                    self.unwritten = Some(error.to_string());
                }
                let job = self.called(&record.output);
                if let Some(error) = &record.error {
                    self.failed += 1;
                    self.passing += usize::from(may_pass);
                    self.say(&format!("error: job {job}: {error}"));
                }
                for warning in warnings {
                    if self.said.insert(excerpt(&warning, CHARACTERS_MAX)) {
                        let (kind, text) = warning.split_once(": ").unwrap_or(("note", &warning));
                        self.say(&format!("{kind}: job {job}: {text}"));
                    }
                }
                self.tell();
                (is_noted && record.error.is_none()).then_some(record)
            }
        }
    }

    /// How a job is called: by its number and its name.
    fn called(&self, output: &str) -> String {
        let order = self.orders.get(output);
        order.map_or(output.to_owned(), |order| format!("{} {}", order.index, order.label()))
    }

    /// Says that something is not as it should be.
    pub fn warn(&self, text: &str) {
        self.say(&format!("warning: {text}"));
    }

    fn say(&self, text: &str) {
        self.progress.aside(|| say(text));
    }

    /// Says what has become of the batch, in which so many had been done before. What is made is
    /// called `made`.
    pub fn close(
        self,
        made: [&str; 2],
        done: usize,
        time: Duration,
        signal: Option<Signal>,
    ) -> Result<(), CliError> {
        self.progress.finish();
        let Self { unit, ended, failed, passing, unwritten, .. } = self;
        let rendered = ended - failed;
        if let Some(signal) = signal.filter(|_| ended < self.orders.len()) {
            let left = self.orders.len() - ended;
            let text = format!("{rendered} rendered, {left} left; start the batch again to go on");
            return Err(CliError::BatchInterrupted { signal, text });
        }
        let path = self.arguments.jobs.display();
        if !self.arguments.quiet {
            let before =
                if done > 0 { format!(", {done} were done before") } else { String::new() };
            let rendered = counted(rendered, made);
            say(format_args!("{path}: {rendered} in {}{before}", HumanDuration(time)));
        }
        let is_task = self.arguments.tasks.task.is_some();
        if failed > 0 && is_task && passing == 0 && unwritten.is_none() {
            let failed = counted(failed, unit);
            say(format_args!("{path}: {failed} failed, and would again; --merge will tell"));
            return Ok(());
        }
        if failed > 0 {
            return Err(CliError::System(format!("{path}: {} failed", counted(failed, unit))));
        }
        unwritten.map_or(Ok(()), |text| Err(CliError::System(text)))
    }
}
