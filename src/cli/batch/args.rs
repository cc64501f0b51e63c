//! What is typed to have a batch done in tasks.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::batch::farm::{ENGINES, Engine};
use crate::batch::share::Share;

const TASKS: &str = "Tasks";

/// Which share of a batch is done.
#[derive(Debug, Args)]
#[command(next_help_heading = TASKS)]
pub struct TaskArguments {
    /// Do share K of N of the work, and note it in a file of its own in the folder RESULTS.tasks
    #[arg(long, value_name = "K/N", conflicts_with = "merge")]
    pub task: Option<Share>,
    /// Note in the results what all tasks have done, make images of parts, and remove these
    #[arg(long, conflicts_with = "dry_run")]
    pub merge: bool,
    /// Parts of each image, with --task and --merge [default: those of the file's farm table, or 1]
    #[arg(long, value_name = "N")]
    pub parts: Option<u32>,
}

const FARM_NOTES: &str = "\
All machines need the same build of sunstone and one folder that they share, with the job file, \
its scenes and its outputs. What is written runs 'sunstone batch JOBS --task K/N' for every K, on \
any machine and in any order, and after them 'sunstone batch JOBS --merge'. Run again, it does \
what is left.

  sunstone farm slurm jobs.toml --tasks 100 --cpus 16 -o jobs.sh
  bash jobs.sh --partition=long --time=4:00:00 --mem=16G     # any options of sbatch
  sunstone farm openjd jobs.toml --tasks 100 -o jobs.json
  openjd run jobs.json                                       # or deadline bundle submit";

/// `farm` as typed.
#[derive(Debug, Args)]
#[command(after_long_help = FARM_NOTES)]
pub struct FarmArguments {
    /// What runs the tasks
    #[arg(value_name = "ENGINE", value_parser = engines())]
    pub engine: &'static Engine,
    /// The job file: .toml or .jsonl
    #[arg(value_name = "JOBS")]
    pub jobs: PathBuf,
    /// Where to write [default: standard output]
    #[arg(short, long, value_name = "FILE", allow_hyphen_values = true)]
    pub output: Option<PathBuf>,
    /// Tasks [default: those of the job file's farm table, or 1]
    #[arg(long, value_name = "N", help_heading = TASKS)]
    pub tasks: Option<u32>,
    /// Parts of each image [default: those of the job file's farm table, or 1]
    #[arg(long, value_name = "N", help_heading = TASKS)]
    pub parts: Option<u32>,
    /// Processors for each task, and threads in it [default: what the engine gives it]
    #[arg(long, value_name = "N", help_heading = TASKS)]
    pub cpus: Option<usize>,
    /// Where sunstone is on the machines [default: where this one is]
    #[arg(long, value_name = "FILE", help_heading = TASKS)]
    pub program: Option<PathBuf>,
    /// As for `sunstone batch`
    #[arg(long, value_name = "FILE", help_heading = TASKS)]
    pub results: Option<PathBuf>,
    /// As for `sunstone batch`
    #[arg(long, help_heading = TASKS)]
    pub allow_outside: bool,
}

/// The engines by name.
fn engines() -> impl TypedValueParser<Value = &'static Engine> {
    let named = |engine: &Engine| PossibleValue::new(engine.name).help(engine.summary);
    PossibleValuesParser::new(ENGINES.iter().map(named)).try_map(|name| {
        let found = ENGINES.iter().find(|engine| engine.name == name);
        found.ok_or("there is no such engine")
    })
}
