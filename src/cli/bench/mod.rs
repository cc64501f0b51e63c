//! The verb `bench`: measurements of this program on this machine.

pub mod args;
mod error;
mod history;
mod overhead;
mod report;
mod scaling;
mod table1;
mod wavelengths;
mod work;

use self::args::{Bench, BenchArguments};
use super::CliError;
use super::progress::Progress;

/// How far a measurement is.
fn progress_of(rounds: u64) -> Progress {
    Progress::of(rounds, "rounds", "{msg} {wide_bar} {pos}/{len} rounds, {eta} left")
}

/// Measures what is asked for.
pub(super) fn bench(arguments: &BenchArguments) -> Result<(), CliError> {
    match &arguments.what {
        Bench::Table1(arguments) => table1::table1(arguments),
        Bench::Overhead(arguments) => overhead::overhead(arguments),
        Bench::Wavelengths(arguments) => wavelengths::wavelengths(arguments),
        Bench::Scaling(arguments) => scaling::scaling(arguments),
        Bench::Error(arguments) => error::error(arguments),
        Bench::History(arguments) => history::history(arguments),
    }
}
