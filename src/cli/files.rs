//! What the verbs ask of the files they are given, and where they print.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

use super::CliError;
use crate::image::extension;

/// Refuses to draw a picture into anything but PNG.
pub(super) fn require_png(path: &Path) -> Result<(), CliError> {
    match extension(path).as_str() {
        "png" => Ok(()),
        _ => Err(CliError::Usage(format!(
            "{} must end in .png: pictures are PNG files",
            path.display()
        ))),
    }
}

/// Refuses to replace a file that the command reads, under this name or another.
pub(super) fn refuse_overwriting(output: &Path, inputs: &[&Path]) -> Result<(), CliError> {
    let target = std::fs::canonicalize(output);
    for input in inputs {
        let is_same = match (&target, std::fs::canonicalize(input)) {
            (Ok(target), Ok(input)) => *target == input,
            _ => output == *input,
        };
        if is_same {
            return Err(CliError::Usage(format!(
                "the output {} is the input {}: choose another name",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// Prints a result to standard output. A reader that has seen enough and left is no error.
pub(super) fn print(text: impl Display) -> Result<(), CliError> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::System(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Says something beside the result, on standard error; if nobody can hear it, it is lost.
pub(super) fn say(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
