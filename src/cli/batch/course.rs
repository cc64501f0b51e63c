//! A batch on its way: what has happened is noted, said and counted.

use std::collections::BTreeSet;
use std::time::Duration;

use indicatif::HumanDuration;

use crate::batch::order::Order;
use crate::batch::prepared::Begun;
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
    progress: Progress,
    /// What there is one of for every order, a job or a part, and what is made of it.
    names: [[&'static str; 2]; 2],
    /// How many were done before, and how many were left.
    done: usize,
    asked: usize,
    ended: usize,
    failed: usize,
    /// How many of these another try might mend.
    passing: usize,
    /// What could not be noted or removed, the first time.
    unwritten: Option<String>,
    /// Warnings that have been said.
    said: BTreeSet<String>,
}

impl<'a> Course<'a> {
    /// At its beginning.
    pub fn new(
        arguments: &'a BatchArguments,
        begun: &Begun,
        names: [[&'static str; 2]; 2],
    ) -> Self {
        let template = "{wide_bar} {msg}, {eta} left";
        let progress = match arguments.quiet {
            true => Progress::none(),
            false => Progress::of(begun.cost(), "samples", template),
        };
        let course = Self {
            arguments,
            progress,
            names,
            done: begun.done().len(),
            asked: begun.left().len(),
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
        self.progress.tell(format!("{} of {}", self.ended, counted(self.asked, self.names[0])));
    }

    /// Counts what has happened, and says it if it is worth it.
    pub fn hear(&mut self, news: News) {
        match news {
            News::Progress(done) => self.progress.set(done),
            News::Again { order, error } => {
                self.say(&format!("warning: job {}: {error}: trying again", called(order)));
            }
            News::Unwritten(error) => {
                self.say(&format!("error: {error}"));
                self.unwritten.get_or_insert(error.to_string());
            }
            News::Left(error) => {
                let text = format!("what is no longer needed is left: {error}");
                self.say(&format!("warning: {text}"));
                self.unwritten.get_or_insert(text);
            }
            News::Ended { order, record, warnings, may_pass, is_former } => {
                self.ended += 1;
                if let Some(error) = &record.error {
                    self.failed += 1;
                    self.passing += usize::from(may_pass);
                    self.say(&format!("error: job {}: {error}", called(order)));
                    if is_former {
                        let (job, file) = (called(order), order.output.display());
                        self.say(&format!("warning: job {job}: {file} is of a former run"));
                    }
                }
                for warning in warnings {
                    if self.said.insert(excerpt(&warning, CHARACTERS_MAX)) {
                        let (kind, text) = warning.split_once(": ").unwrap_or(("note", &warning));
                        self.say(&format!("{kind}: job {}: {text}", called(order)));
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
    pub fn close(self, time: Duration, signal: Option<Signal>) -> Result<(), CliError> {
        self.progress.finish();
        let Self { done, asked, ended, failed, passing, unwritten, .. } = self;
        let ([unit, made], rendered) = (self.names, ended - failed);
        if let Some(signal) = signal.filter(|_| ended < asked) {
            let left = asked - ended;
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

/// How a job is called: by its number and its name.
fn called(order: &Order) -> String {
    format!("{} {}", order.index, order.label())
}
