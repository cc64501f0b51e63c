//! The program: exit code and nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    sunstone::cli::run()
}
