//! The verb `report`: a page of a batch.

use std::path::{Path, PathBuf};

use crate::batch::report::{EDGES, Report, Written};
use crate::batch::results::Results;
use crate::image::folder_of;
use crate::math::text::counted;

use super::CliError;
use super::args::ReportArguments;
use super::files::{refuse_overwriting, require_html, say};
use super::progress::Progress;

/// The name of results in the folder of a batch.
const RESULTS: &str = "results.jsonl";
const JOBS: [&str; 2] = ["job", "jobs"];
const LINES: [&str; 2] = ["line", "lines"];

/// Writes a page of what has become of a batch.
pub(super) fn report(arguments: &ReportArguments) -> Result<(), CliError> {
    let ReportArguments { batch, output, images, thumbnails, allow_outside, quiet } = arguments;
    require_html(output)?;
    if let Some(edge) = thumbnails.filter(|edge| !EDGES.contains(edge)) {
        let (least, most) = (EDGES.start(), EDGES.end());
        let text = format!("--thumbnails must be from {least} to {most}, and not {edge}");
        return Err(CliError::Usage(text));
    }
    let results = results_of(batch)?;
    refuse_overwriting(output, &[&results])?;
    let read = Results::latest_in(&results);
    let (records, broken) = read
        .map_err(|error| CliError::System(format!("cannot read {}: {error}", results.display())))?;
    if records.is_empty() && broken > 0 {
        return Err(CliError::System(format!(
            "{}: no line is of a job; give the folder that holds {RESULTS}, or the file that \
             `sunstone batch --results` has written",
            results.display()
        )));
    }
    if broken > 0 {
        let lines = counted(broken, LINES);
        say(format_args!("warning: {}: {lines} cannot be read", results.display()));
    }
    let folder = images.clone().unwrap_or_else(|| folder_of(&results));
    let report = Report {
        name: name_of(&results),
        records: &records,
        broken,
        folder,
        allow_outside: *allow_outside,
        edge: *thumbnails,
    };
    let progress = match quiet {
        true => Progress::none(),
        false => Progress::of(records.len() as u64, "jobs", "{wide_bar} {pos} of {len} jobs"),
    };
    let written = report.write(output, |done| progress.set(done as u64));
    progress.finish();
    let written = written?;
    let asked = records.len() - written.failed;
    if written.missing == asked && asked > 0 && images.is_none() {
        let words = "--images names the folder that their paths are relative to";
        say(format_args!("note: no image can be shown; {words}"));
    }
    if !quiet {
        say(format_args!("{}: {}", output.display(), words(records.len(), &written)));
    }
    Ok(())
}

/// The file of results that is meant.
fn results_of(batch: &Path) -> Result<PathBuf, CliError> {
    if !batch.is_dir() {
        // Whatever is wrong with it is said where it is read.
        return Ok(batch.to_owned());
    }
    let results = batch.join(RESULTS);
    if results.exists() {
        return Ok(results);
    }
    Err(CliError::System(format!(
        "{} has no {RESULTS}: `sunstone batch JOBS` writes it beside its job file; give the folder \
         of that, or the file of --results",
        batch.display()
    )))
}

/// What the batch is called: its folder, and the file if it has a name of its own.
fn name_of(results: &Path) -> String {
    let folder = folder_of(results);
    let folder = folder.canonicalize().unwrap_or(folder);
    let name = |path: &Path| path.file_name().map(|it| it.to_string_lossy().into_owned());
    match (name(&folder), name(results)) {
        (Some(folder), Some(file)) if file != RESULTS => format!("{folder}/{file}"),
        (Some(folder), _) => folder,
        (None, file) => file.unwrap_or_default(),
    }
}

/// What the page holds.
fn words(jobs: usize, written: &Written) -> String {
    let Written { bytes, failed, former, missing, changed } = *written;
    let mut text = counted(jobs, JOBS);
    let more = [
        (failed, "failed"),
        (former, "of these with an image of a former run"),
        (missing, "without an image to show"),
        (changed, "changed since"),
    ];
    for (count, words) in more.into_iter().filter(|(count, _)| *count > 0) {
        text += &format!(", {count} {words}");
    }
    text + &format!("; {:.1} MB", bytes as f64 / 1e6)
}
