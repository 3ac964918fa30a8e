//! Says what the command line may hold.

use std::ffi::OsString;

use clap::builder::PossibleValuesParser;
use clap::{Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;

use super::{calibrate, check, fit, handoff, new, predict, simulate, track, trade};

/// Infers the parameters of wet-particle impact from a scene file and a table of impacts
#[derive(Parser)]
#[command(version, arg_required_else_help = true, disable_help_subcommand = true)]
#[command(after_help = include_str!("help/wetcor.txt").trim_ascii_end())]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) verb: Verb,
    /// Threads to use [default: all]
    #[arg(long, global = true, value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) threads: Option<u16>,
    /// Print errors only
    #[arg(long, global = true)]
    pub(super) quiet: bool,
}

#[derive(Subcommand)]
pub(super) enum Verb {
    /// Make a table of runs from recordings of falling spheres
    Track(track::Track),
    /// Draft a scene from a table of runs
    New(new::New),
    /// Fit a scene's runs and write the report
    Fit(fit::Fit),
    /// Show what was read and which parameters it can determine (no sampling)
    Check(check::Check),
    /// Draw runs from a scene's [truth] and [design]
    Simulate(simulate::Simulate),
    /// Predict the restitution at given speeds from a finished fit
    Predict(predict::Predict),
    /// Write a finished fit's law as input of a simulation code
    Handoff(handoff::HandoffArguments),
    /// Measure, on a scene's runs, what each method costs and how far off it is
    Trade(trade::Trade),
    /// Measure how often the intervals cover the truth, on simulated data
    Calibrate(calibrate::Calibrate),
    /// Print the script by which a shell completes commands and options
    #[command(after_help = include_str!("help/completions.txt").trim_ascii_end())]
    Completions {
        /// The shell that is to complete
        shell: Shell,
    },
    /// Print the help of a command, or every key of a scene
    #[command(after_help = include_str!("help/help.txt").trim_ascii_end())]
    Help {
        /// A command, or `scene`
        topic: Option<String>,
    },
    /// Print the manual page of wetcor, or of a command
    #[command(after_help = include_str!("help/man.txt").trim_ascii_end())]
    Man {
        /// A command [default: wetcor itself]
        command: Option<String>,
    },
}

/// What `help` explains besides the commands.
pub(super) const SCENE: &str = "scene";

/// The command line as it is read, and as `--help`, completions and manual pages describe it.
///
/// `help` and `man` take the name of a command; which there are, the commands themselves say.
pub(super) fn definition() -> Command {
    let command = Arguments::command();
    let verbs = command.get_subcommands().map(|verb| verb.get_name().to_owned());
    let verbs: Vec<String> = verbs.collect();
    let topics = verbs.iter().cloned().chain([SCENE.to_owned()]);
    let topics = PossibleValuesParser::new(topics);
    let pages = PossibleValuesParser::new(verbs);
    command
        .mut_subcommand("help", |help| {
            help.mut_arg("topic", |topic| topic.value_parser(topics).hide_possible_values(true))
        })
        .mut_subcommand("man", |man| {
            man.mut_arg("command", |page| page.value_parser(pages).hide_possible_values(true))
        })
}

/// The words of a command line, read.
pub(super) fn read<W: Into<OsString> + Clone>(words: impl IntoIterator<Item = W>) -> Result<Arguments, clap::Error> {
    definition()
        .try_get_matches_from(words)
        .and_then(|matches| Arguments::from_arg_matches(&matches))
}
