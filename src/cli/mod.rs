//! Floor 9: the command line. Arguments as typed become a validated job; verbs run it.

mod args;
mod images;
mod job;
mod render;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

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
    Output(#[from] crate::output::OutputError),
    /// The system refused something.
    #[error("{0}")]
    System(String),
}

/// Runs the program: 0 done, 1 something went wrong, 2 the command line was wrong.
pub fn run() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Render(arguments) => render::render(&arguments),
        Command::Visualize(arguments) => images::visualize(&arguments),
        Command::Compare(arguments) => images::compare(&arguments),
        Command::Inspect(arguments) => images::inspect(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if matches!(error, CliError::Usage(_)) { 2 } else { 1 })
        }
    }
}
