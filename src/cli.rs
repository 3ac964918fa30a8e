//! Reads the command line, runs a verb, and turns its result into text and an exit status.
//!
//! | file | job |
//! |---|---|
//! | `arguments.rs` | says what the command line may hold |
//! | `help/` | what the help of a verb says after its options |
//! | `messages.rs` | prints notices, errors and results |
//! | `threads.rs` | starts the threads of every pool |
//! | `timing.rs` | times the stages of a fit |
//! | `draws.rs` | shows draws as they come |
//! | `defect.rs` | makes one line of a panic |
//! | `setting.rs` | reads a setting, and finds the law that holds there |
//! | `track.rs`, `new.rs`, `fit.rs`, `check.rs`, `simulate.rs`, `predict.rs`, `handoff.rs`, `trade.rs`, `calibrate.rs` | run the verb of their name |
//! | `manual.rs` | prints completions and manual pages |

mod arguments;
mod calibrate;
mod check;
mod defect;
mod draws;
mod fit;
mod handoff;
mod manual;
mod messages;
mod new;
mod predict;
mod setting;
mod simulate;
mod threads;
mod timing;
mod track;
mod trade;

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use wetcor::error::Error;
use wetcor::interruption;
use wetcor::ranks::Ranks;

use arguments::{Arguments, Verb};
use messages::{complain, notice, print_result};

use crate::progress::be_quiet;

/// Could not run.
const COULD_NOT_RUN: u8 = 2;

/// Runs the command line, as one process or as one of those that share its work.
pub fn run() -> ExitCode {
    let (ranks, started) = Ranks::start();
    let arguments = match arguments::read(std::env::args_os()) {
        Ok(arguments) => arguments,
        // it is the same on every rank
        Err(error) if ranks.is_first() => return without_arguments(error),
        Err(error) => return ExitCode::from(if error.use_stderr() { COULD_NOT_RUN } else { 0 }),
    };
    if let Verb::Help { topic } = &arguments.verb {
        return if ranks.is_first() {
            help(topic.as_deref())
        } else {
            ExitCode::SUCCESS
        };
    }
    match ranks.end(started.and_then(|()| run_verb(&arguments, &ranks))) {
        Ok(status) => ExitCode::from(status),
        Err(error) => could_not_run(&error),
    }
}

/// Runs a verb on this rank; the first alone tells what came out.
fn run_verb(arguments: &Arguments, ranks: &Ranks) -> Result<u8, Error> {
    let is_divided = matches!(arguments.verb, Verb::Fit(_) | Verb::Calibrate(_));
    if ranks.count() > 1 && !is_divided {
        return Err(Error::Usage(format!(
            "a launcher started {} processes; only `fit` and `calibrate` divide their work among several",
            ranks.count()
        )));
    }
    let is_first = ranks.is_first();
    if arguments.quiet || !is_first {
        be_quiet();
    }
    threads::check_address_space()?;
    threads::start(arguments.threads)?;
    let interrupted = move |text: &str| {
        if is_first && !FAILED.load(Relaxed) {
            complain(text);
        }
    };
    if let Err(error) = interruption::watch(interrupted) {
        notice(&format!("an interruption may leave a temporary folder: {error}"));
    }
    let result = defect::caught(|| match &arguments.verb {
        Verb::Track(request) => track::track(request),
        Verb::New(request) => new::new(request),
        Verb::Fit(request) => fit::fit(request, ranks),
        Verb::Check(request) => check::check(request),
        Verb::Simulate(request) => simulate::simulate(request),
        Verb::Predict(request) => predict::predict(request),
        Verb::Handoff(request) => handoff::handoff(request),
        Verb::Trade(request) => trade::trade(request),
        Verb::Calibrate(request) => calibrate::calibrate(request, ranks),
        Verb::Completions { shell } => manual::completions(*shell),
        Verb::Man { command } => manual::man(command.as_deref()),
        Verb::Help { .. } => Ok(0),
    });
    result.unwrap_or_else(Err)
}

/// Whether a failure has been told: a launcher that sees one rank end with it interrupts the others, about which there is
/// nothing left to say.
static FAILED: AtomicBool = AtomicBool::new(false);

fn could_not_run(error: &Error) -> ExitCode {
    // another rank says why
    if !matches!(error, Error::OtherRank) {
        complain(&error.to_string());
    }
    FAILED.store(true, Relaxed);
    ExitCode::from(COULD_NOT_RUN)
}

/// Prints every key of a scene, or what a command prints when it is asked for help.
fn help(topic: Option<&str>) -> ExitCode {
    if topic == Some(arguments::SCENE) {
        return match print_result(&wetcor::scene::plain()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => could_not_run(&error),
        };
    }
    let words = ["wetcor"].into_iter().chain(topic).chain(["--help"]);
    match arguments::read(words) {
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => without_arguments(error),
    }
}

/// Prints help and version, which are no failure, or what is wrong with the command line.
fn without_arguments(error: clap::Error) -> ExitCode {
    if error.use_stderr() {
        complain(&messages::usage(error));
        return ExitCode::from(COULD_NOT_RUN);
    }
    match error.print() {
        // a reader that has left is no error
        Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => {
            could_not_run(&Error::Unprinted { written: None, source })
        }
        _ => ExitCode::SUCCESS,
    }
}
