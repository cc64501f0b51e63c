//! What the verbs ask of the files they are given, and where they print.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

use clap::{ArgAction, Args};
use serde::Serialize;

use super::CliError;
use super::args::RUN;
use crate::image::extension;
use crate::math::text::{acts, printable};
use crate::scene::{Reading, View};

/// What scenes may read.
#[derive(Clone, Debug, Args)]
pub struct FileArguments {
    /// Let scenes read files outside their folders: only for scenes that you trust
    #[arg(long, help_heading = RUN)]
    pub allow_outside: bool,
    /// The value of a parameter of an .xml scene, in place of its default; once for each
    #[arg(short = 'D', long, value_name = "NAME=VALUE", value_parser = definition)]
    #[arg(action = ArgAction::Append, help_heading = RUN)]
    pub define: Vec<(String, String)>,
}

impl FileArguments {
    /// How the scenes are read, of which so much is seen.
    pub(super) fn reading(&self, view: View) -> Reading {
        let Self { allow_outside, define } = self;
        Reading { view, allow_outside: *allow_outside, definitions: define.clone() }
    }
}

/// A name and its value, as typed.
fn definition(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        Some(_) | None => Err("write it as name=value".to_owned()),
    }
}

/// Refuses to draw a picture into anything but PNG.
pub(super) fn require_png(path: &Path) -> Result<(), CliError> {
    require(path, "png", "pictures are PNG files")
}

/// Refuses to write a page into anything but HTML.
pub(super) fn require_html(path: &Path) -> Result<(), CliError> {
    require(path, "html", "pages are HTML files")
}

/// Refuses to write a scene into anything but glTF.
pub(super) fn require_gltf(path: &Path) -> Result<(), CliError> {
    if ["gltf", "glb"].contains(&extension(path).as_str()) {
        return Ok(());
    }
    let path = path.display();
    let text = format!("{path} must end in .gltf or .glb: scenes are written as glTF files");
    Err(CliError::Usage(text))
}

fn require(path: &Path, wanted: &str, why: &str) -> Result<(), CliError> {
    if extension(path) == wanted {
        return Ok(());
    }
    Err(CliError::Usage(format!("{} must end in .{wanted}: {why}", path.display())))
}

/// A value as JSON, in which what JSON allows and terminals act on is escaped.
pub(super) fn json(value: &impl Serialize) -> Result<String, CliError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| CliError::System(format!("cannot write JSON: {error}")))?;
    let escaped = |c: char| match acts(c) && c != '\n' {
        true => format!("\\u{:04x}", u32::from(c)),
        false => c.to_string(),
    };
    Ok(text.chars().map(escaped).collect())
}

/// Refuses to replace a file that the command reads, under this name or another.
pub(super) fn refuse_overwriting(
    output: &Path,
    inputs: &[impl AsRef<Path>],
) -> Result<(), CliError> {
    let target = std::fs::canonicalize(output);
    for input in inputs.iter().map(AsRef::as_ref) {
        let is_same = match (&target, std::fs::canonicalize(input)) {
            (Ok(target), Ok(input)) => *target == input,
            _ => output == input,
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

/// Prints a result to standard output, what would act on a terminal escaped. A reader that has
/// seen enough and left is no error.
pub(super) fn print(text: impl Display) -> Result<(), CliError> {
    match writeln!(io::stdout().lock(), "{}", printable(&text.to_string())) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::System(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Says something beside the result, on standard error, what would act on a terminal escaped; if
/// nobody can hear it, it is lost.
pub(super) fn say(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(&text.to_string()));
}
