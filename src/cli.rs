//! Reads the command line, runs a verb, and turns its outcome into text and an exit status.
//!
//! | file | job |
//! |---|---|
//! | `arguments.rs` | says what the command line may hold |
//! | `said.rs` | says things to the user |
//! | `timing.rs` | times the stages of a fit |
//! | `draws.rs` | shows draws as they come |
//! | `defect.rs` | makes one line of a panic |
//! | `fit.rs`, `check.rs`, `simulate.rs`, `predict.rs`, `trade.rs`, `calibrate.rs` | run the verb of their name |

mod arguments;
mod calibrate;
mod check;
mod defect;
mod draws;
mod fit;
mod predict;
mod said;
mod simulate;
mod timing;
mod trade;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use wetcor::findings::posterior::Way;
use wetcor::interruption;
use wetcor::runs::Existing;

use arguments::{Arguments, Verb};
use said::{label, warn};

/// Ran, and a gating verdict failed.
const NOT_QUOTABLE: u8 = 1;
/// Could not run.
const COULD_NOT_RUN: u8 = 2;

/// Runs the command line.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(help) => {
            // help and version go to standard output and are no failure; a closed pipe is none either
            let _ = help.print();
            return if help.use_stderr() {
                ExitCode::from(COULD_NOT_RUN)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    bound_threads(arguments.threads);
    if let Err(error) = interruption::watch(fail) {
        warn(&format!("an interruption may leave a temporary folder: {error}"));
    }
    let quiet = arguments.quiet;
    let verb = arguments.verb;
    let outcome = defect::caught(|| match verb {
        Verb::Fit {
            scene,
            out,
            seed,
            stages,
            exact_rows,
            accuracy,
        } => {
            let way = match accuracy {
                Some(accuracy) => Way::Accuracy(accuracy),
                None if exact_rows => Way::Rows,
                None => Way::Nodes,
            };
            fit::fit(&scene, out, seed, (&stages, way), quiet)
        }
        Verb::Check { scene, json } => check::check(&scene, json, quiet),
        Verb::Simulate {
            scene,
            out,
            runs,
            seed,
            force,
        } => {
            let existing = if force { Existing::Replaced } else { Existing::Kept };
            simulate::simulate(&scene, (&out, existing), runs, seed, quiet)
        }
        Verb::Predict(asked) => predict::predict(&asked, quiet),
        Verb::Trade { scene, out, seed } => trade::run_trade(&scene, out, seed, quiet),
        Verb::Calibrate { out, sets, seed } => calibrate::calibrate(&out, sets, seed, quiet),
    });
    match outcome.unwrap_or_else(Err) {
        Ok(status) => ExitCode::from(status),
        Err(error) => {
            fail(&error.to_string());
            ExitCode::from(COULD_NOT_RUN)
        }
    }
}

/// Says why there is no answer.
fn fail(why: &str) {
    let label = label("error", "\u{1b}[1;31m");
    let _ = writeln!(std::io::stderr(), "{label}: {why}");
}

/// Bounds every pool. The table reader's pool is its own and reads its size from the environment when first used.
fn bound_threads(threads: Option<u16>) {
    let Some(threads) = threads else {
        return;
    };
    std::env::set_var("POLARS_MAX_THREADS", threads.to_string());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
    // fails only if a pool exists already, and none does this early
    if let Err(error) = pool.build_global() {
        warn(&format!("--threads has no effect: {error}"));
    }
}
