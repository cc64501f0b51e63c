//! The program: exit code and nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    // Nothing may come before the check of the processor that `run` begins with.
    sunstone::internals::cli::run()
}
