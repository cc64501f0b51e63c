//! Where reports go: standard output, files, and the record.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;

use super::args::{RecordedReportArguments, ReportArguments};
use crate::bench::plot::{self, Panel};
use crate::bench::record::{self, Record, rfc3339};
use crate::bench::{Machine, Report};
use crate::cli::CliError;
use crate::cli::args::StatsFormat;
use crate::cli::files::{self, print, refuse_overwriting};
use crate::image::atomic;
use crate::render::system;

/// Checks, before anything is measured, that all files can be written and none is an input.
pub fn check_outputs(
    report: &ReportArguments,
    record: Option<&Path>,
    inputs: &[PathBuf],
) -> Result<(), CliError> {
    let outputs = [report.json.as_deref(), report.plot.as_deref(), record];
    let outputs: Vec<&Path> = outputs.into_iter().flatten().collect();
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    for (index, path) in outputs.iter().enumerate() {
        refuse_overwriting(path, &inputs)?;
        if outputs[..index].contains(path) {
            return Err(CliError::Usage(format!(
                "two of --json, --plot and --record are {}: choose different files",
                path.display()
            )));
        }
    }
    if let Some(path) = &report.json {
        atomic::probe_writable(path)?;
    }
    if let Some(path) = &report.plot {
        plot::check_writable(path)?;
    }
    if let Some(path) = record {
        record::check_appendable(path)?;
    }
    Ok(())
}

/// Prints a report, writes its files and keeps its figures under the name of the bench.
pub fn deliver(
    report: &impl Report,
    arguments: &RecordedReportArguments,
    (bench, machine): (&str, &Machine),
) -> Result<(), CliError> {
    show(report, || report.panels(), &arguments.report)?;
    let Some(path) = &arguments.record else { return Ok(()) };
    let line = Record {
        date: rfc3339(SystemTime::now()),
        commit: system::commit_beside(path),
        cpu: machine.processor.clone().unwrap_or_else(|| "unknown".into()),
        processors: machine.processors,
        threads: machine.threads,
        version: machine.version.clone(),
        bench: bench.into(),
        figures: report.figures(),
    };
    Ok(record::append(path, &line)?)
}

/// Prints something and writes it to its files.
pub fn show<R: std::fmt::Display + Serialize>(
    shown: &R,
    panels: impl FnOnce() -> Vec<Panel>,
    arguments: &ReportArguments,
) -> Result<(), CliError> {
    let json = files::json(shown)?;
    match arguments.format {
        StatsFormat::Text => print(shown)?,
        StatsFormat::Json => print(&json)?,
    }
    if let Some(path) = &arguments.json {
        atomic::write(path, (json + "\n").as_bytes())?;
    }
    if let Some(path) = &arguments.plot {
        plot::write(&panels(), path)?;
    }
    Ok(())
}
