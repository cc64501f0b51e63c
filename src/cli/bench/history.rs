//! `bench history`.

use super::args::HistoryArguments;
use super::report::{check_outputs, show};
use crate::bench::history::{Choice, History};
use crate::bench::record;
use crate::cli::CliError;
use crate::math::text::listed;

/// Most figures in a plot.
const CURVES_MAX: usize = 12;

/// Says that the choice leaves nothing of a record.
fn nothing_fits(arguments: &HistoryArguments, cpus: &[&str]) -> String {
    let given = [(!arguments.figure.is_empty(), "--figure"), (arguments.cpu.is_some(), "--cpu")];
    let given: Vec<&str> = given.iter().filter(|(is, _)| *is).map(|(_, name)| *name).collect();
    let (file, cpus) = (arguments.file.display(), listed(cpus));
    format!("no record in {file} fits {}; its processors are {cpus}", given.join(" and "))
}

/// The trends in a record.
pub fn history(arguments: &HistoryArguments) -> Result<(), CliError> {
    check_outputs(&arguments.report, None, std::slice::from_ref(&arguments.file))?;
    let records = record::read(&arguments.file)?;
    let choice = Choice { figures: &arguments.figure, cpu: arguments.cpu.as_deref() };
    let history = History::new(&records, choice);
    let file = arguments.file.display();
    if history.machines.is_empty() {
        let mut cpus: Vec<&str> = records.iter().map(|record| record.cpu.as_str()).collect();
        cpus.sort_unstable();
        cpus.dedup();
        return Err(CliError::System(match cpus[..] {
            [] => {
                format!("{file} holds no records yet: --record of the other measurements adds them")
            }
            _ => nothing_fits(arguments, &cpus),
        }));
    }
    let curves = history.machines.iter().map(|machine| machine.trends.len()).max().unwrap_or(0);
    if arguments.report.plot.is_some() && curves > CURVES_MAX {
        return Err(CliError::Usage(format!(
            "--plot shows {CURVES_MAX} figures at most, and these are {curves}: choose some with \
             --figure"
        )));
    }
    show(&history, || history.panels(), &arguments.report)
}
