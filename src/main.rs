//! Runs the `wetcor` command.

mod cli;
mod progress;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
