//! Floor 12: the command line. Arguments as typed become a validated job; verbs run it.

mod args;
pub mod batch;
mod bench;
mod checkpoint;
pub mod color;
mod convert;
mod files;
mod film;
mod images;
mod interrupt;
mod job;
mod merge;
pub mod processor;
mod progress;
mod render;
mod report;
mod rescue;
mod tev;
mod view;
mod visualize;
pub mod white;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};

use crate::batch::crash::watch;
use crate::bench::measure::MeasureError;
use crate::math::text::counted;
use crate::render::statistics::SAMPLES;
use crate::render::{RenderError, SettingsError};

use args::{Arguments, Command};
use interrupt::Signal;

/// What ends a command early.
#[derive(Debug, thiserror::Error)]
enum CliError {
    /// The command line asks for something that does not go together.
    #[error("{0}\n\nFor more information, try 'sunstone help'.")]
    Usage(String),
    /// The scene is wrong.
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
    /// A file could not be read or written, or two images do not match.
    #[error(transparent)]
    Output(#[from] crate::image::OutputError),
    /// A render cannot go on from a file, or parts are not those of an image.
    #[error(transparent)]
    Part(#[from] crate::render::PartError),
    /// Threads could not be started.
    #[error(transparent)]
    Threads(#[from] crate::render::threads::ThreadsError),
    /// The memory does not hold the film, the photons or the shapes.
    #[error(transparent)]
    Memory(#[from] crate::render::memory::MemoryError),
    /// A signal ended a render, and the image so far is written, if it is one.
    #[error(
        "{} after {}: {} {}", .signal.name(), counted(*.samples as usize, SAMPLES),
        if *.is_part { "there is no part in" } else { "the image so far is in" },
        output.display()
    )]
    Interrupted {
        /// What came.
        signal: Signal,
        /// Samples per pixel that the image holds.
        samples: u32,
        /// Where it is, or would be.
        output: PathBuf,
        /// Whether it is a part, which is not written before it is done.
        is_part: bool,
    },
    /// A signal ended a batch.
    #[error("{}: {text}", .signal.name())]
    BatchInterrupted {
        /// What came.
        signal: Signal,
        /// What has been done, and how to go on.
        text: String,
    },
    /// What a file asks for does not go together.
    #[error("{0}")]
    Refused(String),
    /// The system refused something.
    #[error("{0}")]
    System(String),
}

impl From<SettingsError> for CliError {
    fn from(SettingsError { setting, rule }: SettingsError) -> Self {
        Self::Usage(format!("{} {rule}", job::option_of(setting)))
    }
}

impl From<MeasureError> for CliError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Render(error) => error.into(),
            MeasureError::Threads(error) => error.into(),
            MeasureError::Output(error) => error.into(),
        }
    }
}

impl From<RenderError> for CliError {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Scene(error) => error.into(),
            RenderError::Settings(error) => error.into(),
            RenderError::Memory(error) => error.into(),
        }
    }
}

/// Runs the program: 0 done, 1 something went wrong, 2 the command line was wrong, 128 and the
/// number of a signal if that ended a render; 101 if it was the program's own fault.
///
/// Begins with [`processor::refusal`]; until that has answered, nothing may run that the
/// processor might not know.
pub fn run() -> ExitCode {
    match processor::refusal() {
        Some(text) => {
            // If nobody can hear it, the exit code still says it.
            let _ = std::io::stderr().write_all(text.as_bytes());
            ExitCode::FAILURE
        }
        None => {
            watch();
            run_command()
        }
    }
}

/// The same command line, where numbers below zero are values and no options.
fn numbers_may_be_negative(command: clap::Command) -> clap::Command {
    let takes_values = |arg: &clap::Arg| arg.get_action().takes_values();
    command
        .mut_args(|arg| if takes_values(&arg) { arg.allow_negative_numbers(true) } else { arg })
        .mut_subcommands(numbers_may_be_negative)
}

#[inline(never)]
fn run_command() -> ExitCode {
    // What is wrong with a number below zero is said where its range is known.
    let command = numbers_may_be_negative(Arguments::command());
    let arguments = Arguments::from_arg_matches(&command.get_matches());
    let result = match arguments.unwrap_or_else(|error| error.exit()).command {
        Command::Render(arguments) => render::render(&arguments),
        Command::Merge(arguments) => merge::merge(&arguments),
        Command::Visualize(arguments) => visualize::visualize(&arguments),
        Command::View(arguments) => images::view(&arguments),
        Command::Compare(arguments) => images::compare(&arguments),
        Command::Inspect(arguments) => images::inspect(&arguments),
        Command::Convert(arguments) => convert::convert(&arguments),
        Command::Batch(arguments) => batch::batch(&arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Farm(arguments) => batch::farm::farm(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            error.say();
            ExitCode::from(error.exit_code())
        }
    }
}

impl CliError {
    fn say(&self) {
        let is_signal = matches!(self, Self::Interrupted { .. } | Self::BatchInterrupted { .. });
        let head = if is_signal { "" } else { "error: " };
        files::say(format_args!("{head}{self}"));
    }

    /// What the program ends with.
    fn exit_code(&self) -> u8 {
        if let Self::Interrupted { signal, .. } | Self::BatchInterrupted { signal, .. } = self {
            return signal.exit_code();
        }
        if let Self::Usage(_) | Self::Refused(_) = self { 2 } else { 1 }
    }
}
