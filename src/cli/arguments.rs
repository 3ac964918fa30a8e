//! Says what the command line may hold.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Command, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use wetcor::inference::accuracy::RANGE;
use wetcor::model::simulate::MOST_RUNS;
use wetcor::study::calibration;

use super::{handoff, predict, track};

/// Infers the parameters of wet-particle impact from a scene file and a table of impacts
#[derive(Parser)]
#[command(version, arg_required_else_help = true, disable_help_subcommand = true, after_help = EXAMPLES)]
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

const EXAMPLES: &str = "\
Examples:
  wetcor new runs.csv
  wetcor check datasets/mueller2016/scene.toml
  wetcor fit datasets/mueller2016/scene.toml
  wetcor help scene

Exit status: 0 ran; 1 ran, and the numbers are not to be quoted; 2 could not run";

#[derive(Subcommand)]
pub(super) enum Verb {
    /// Make a table of runs from recordings of falling spheres
    Track(track::Track),
    /// Draft a scene from a table of runs
    #[command(after_help = "\
Example:
  wetcor new runs.csv

Names the particles and liquids of the table, guesses its columns and says so, and lists every key with its default. What \
must be filled in is marked; `wetcor check` names it. An existing file is kept.")]
    New {
        /// The table: .csv, .tsv, .txt, .parquet or .xlsx (`book.xlsx#May` for another than the first sheet)
        table: PathBuf,
        /// File to write [default: scene.toml beside the table]
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Fit a scene's runs and write the report
    #[command(after_help = "\
Example:
  wetcor fit datasets/mueller2016/scene.toml --out reports/mueller2016

Writes report.md, the same as report.html for a browser, figures/, findings.json, laws.csv and laws_table.csv (e_n(v) of every \
pair), draws/ and timing.json. An existing folder is replaced only if it holds an earlier \
report of the same title and nothing else. With mpirun, in a build with the feature `mpi`, the ranks share the reading of a \
table of more than 2,500,000 runs; the report is the same.")]
    Fit {
        /// The scene file
        scene: PathBuf,
        /// Folder to write [default: reports/<the scene's folder name>]
        #[arg(long)]
        out: Option<PathBuf>,
        /// Seed of every use of chance
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Stages to run [default: all]
        #[arg(long, value_delimiter = ',')]
        stages: Vec<Stage>,
        /// Sample with every run, however many, where few would stand for more than 100,000
        #[arg(long, conflicts_with = "accuracy")]
        exact_rows: bool,
        /// Largest error of any posterior mean, in posterior sds, and of any sd, relative, from 0.005 to 1: take the
        /// cheapest method that can vouch for it [default: trajectories as [sampler] says]
        #[arg(long, value_name = "X", value_parser = read_accuracy)]
        accuracy: Option<f64>,
        /// Print every notice, not only the three that bear most on the main numbers
        #[arg(long, conflicts_with = "quiet")]
        verbose: bool,
    },
    /// Show what was read and which parameters it can determine (no sampling)
    #[command(after_help = "\
Example:
  wetcor check datasets/mueller2016/scene.toml --json")]
    Check {
        /// The scene file
        scene: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Draw runs from a scene's [truth] and [design]
    #[command(after_help = "\
Example:
  wetcor simulate datasets/mueller2016/scene.toml --runs 100000 --out runs.parquet
  mpirun -n 4 wetcor simulate datasets/mueller2016/scene.toml --runs 100000000 --parts 16 --out runs

An existing file is kept unless --force is given; a scene, and the runs of a scene beside it, are never replaced. With \
mpirun, in a build with the feature `mpi`, the ranks write a share of the parts each; the files are the same.")]
    Simulate {
        /// The scene file
        scene: PathBuf,
        /// File to write, .csv or .parquet; with --parts, folder
        #[arg(long)]
        out: PathBuf,
        /// Write so many Parquet files, part-000.parquet and so on, into a new folder
        #[arg(long, value_name = "N", conflicts_with = "force", value_parser = clap::value_parser!(u64).range(1..=10_000))]
        parts: Option<u64>,
        /// Runs in all, spread evenly over the design [default: the design's repeats]
        #[arg(long, value_parser = clap::value_parser!(u64).range(1..=MOST_RUNS))]
        runs: Option<u64>,
        /// Seed of every use of chance
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Replace an existing file
        #[arg(long)]
        force: bool,
    },
    /// Predict the restitution at given speeds from a finished fit
    Predict(predict::Predict),
    /// Write a finished fit's law as input of a simulation code
    Handoff(handoff::HandoffArguments),
    /// Measure, on a scene's runs, what each method costs and how far off it is
    #[command(after_help = "\
Example:
  wetcor trade datasets/mueller2016/scene.toml --out reports/mueller2016-trade

Writes trade.md, trade.json and trade.svg. The other methods are held against a long run that evaluates every run.")]
    Trade {
        /// The scene file
        scene: PathBuf,
        /// Folder to write [default: reports/<the scene's folder name>-trade]
        #[arg(long)]
        out: Option<PathBuf>,
        /// Seed of every use of chance
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Measure how often the intervals cover the truth, on simulated data
    #[command(after_help = "\
Examples:
  wetcor calibrate --out reports/calibration.md
  mpirun -n 4 wetcor calibrate --out reports/calibration.md

With mpirun, in a build with the feature `mpi`, the ranks take a share of the data sets each; the page is the same.")]
    Calibrate {
        /// File to write
        #[arg(long)]
        out: PathBuf,
        /// Data sets a design
        #[arg(long, default_value_t = calibration::SETS, value_parser = clap::value_parser!(u64).range(1..=calibration::MOST_SETS))]
        sets: u64,
        /// Seed of every use of chance
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Print the script by which a shell completes commands and options
    #[command(after_help = "\
Example:
  wetcor completions bash > ~/.local/share/bash-completion/completions/wetcor

Other shells look for it elsewhere: zsh as _wetcor in a folder of its fpath, fish as \
~/.config/fish/completions/wetcor.fish; elvish and PowerShell read it from their start-up file.")]
    Completions {
        /// The shell that is to complete
        shell: Shell,
    },
    /// Print the help of a command, or every key of a scene
    #[command(after_help = "\
Example:
  wetcor help scene")]
    Help {
        /// A command, or `scene`
        topic: Option<String>,
    },
    /// Print the manual page of wetcor, or of a command
    #[command(after_help = "\
Example:
  wetcor man fit | man -l -

`man wetcor-fit` finds the page where it lies in ~/.local/share/man/man1 as wetcor-fit.1; that of wetcor itself is \
wetcor.1.")]
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

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(super) enum Stage {
    /// Every fit and its intervals
    LeastSquares,
    /// Bootstrap intervals beside those of least squares
    Bootstrap,
    /// Parameters from all runs at once, under the scene's priors
    Posterior,
    /// Which form of the law predicts the runs best
    Compare,
    /// The report's figures
    Figures,
}

/// An accuracy inside the range that may be requested.
fn read_accuracy(text: &str) -> Result<f64, String> {
    let (least, most) = RANGE;
    let expected = || format!("expected a number from {least} to {most}");
    let value: f64 = text.parse().map_err(|_| expected())?;
    Some(value)
        .filter(|value| (least..=most).contains(value))
        .ok_or_else(expected)
}
