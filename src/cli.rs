//! Reads the command line, runs a verb, and turns its outcome into text and an exit status.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::OnceLock;
use std::time::Instant;

use clap::{Parser, Subcommand, ValueEnum};
use wetcor::error::Error;
use wetcor::findings::posterior::Way;
use wetcor::findings::{self, overview, verdicts};
use wetcor::inference::accuracy::RANGE;
use wetcor::model::simulate::Simulation;
use wetcor::notice::Notice;
use wetcor::report::folder::{self, Contents};
use wetcor::report::{self, markdown, trade as trade_report, Told};
use wetcor::runs::{self, RunWriter};
use wetcor::scene::{self, Scene};
use wetcor::study::{accuracy, calibration, trade};

use crate::progress::Progress;

mod predict;

/// Ran, and a gating verdict failed.
const NOT_QUOTABLE: u8 = 1;
/// Could not run.
const COULD_NOT_RUN: u8 = 2;

/// Infers the parameters of wet-particle impact from a scene file and a table of impacts
#[derive(Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
    /// Threads to use [default: all]
    #[arg(long, global = true, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Print errors only
    #[arg(long, global = true)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  wetcor check datasets/mueller2016/scene.toml
  wetcor fit datasets/mueller2016/scene.toml

Exit status: 0 ran; 1 ran, and the numbers are not to be quoted; 2 could not run";

#[derive(Subcommand)]
enum Verb {
    /// Fit a scene's runs and write the report
    #[command(after_help = "\
Example:
  wetcor fit datasets/mueller2016/scene.toml --out reports/mueller2016

Writes report.md, figures/, findings.json and timing.json. An existing folder is replaced only if it holds an earlier \
report of the same title.")]
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
        /// Sample with every row in every evaluation, to compare with the compressed likelihood
        #[arg(long, conflicts_with = "accuracy")]
        exact_rows: bool,
        /// Largest error of any posterior mean, in posterior sds, and of any sd, relative, from 0.005 to 1: take the
        /// cheapest method that can vouch for it [default: trajectories as [sampler] says]
        #[arg(long, value_name = "X", value_parser = read_accuracy)]
        accuracy: Option<f64>,
    },
    /// Say what was read and what it can identify, by least squares at most
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
  wetcor simulate datasets/mueller2016/scene.toml --runs 100000 --out runs.parquet")]
    Simulate {
        /// The scene file
        scene: PathBuf,
        /// File to write, .csv or .parquet
        #[arg(long)]
        out: PathBuf,
        /// Runs in all, spread evenly over the design [default: the design's repeats]
        #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
        runs: Option<u64>,
        /// Seed of every use of chance
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Predict the restitution at given speeds from a finished fit
    Predict(predict::Predict),
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
Example:
  wetcor calibrate --out reports/calibration.md")]
    Calibrate {
        /// File to write
        #[arg(long)]
        out: PathBuf,
        /// Data sets a design
        #[arg(long, default_value_t = 4000, value_parser = clap::value_parser!(u64).range(1..))]
        sets: u64,
        /// Seed of every use of chance
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
enum Stage {
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
    let watched = ctrlc::set_handler(|| {
        wetcor::unfinished::remove();
        std::process::exit(i32::from(COULD_NOT_RUN));
    });
    if let Err(error) = watched {
        warn(&format!("an interruption may leave a temporary folder: {error}"));
    }
    let quiet = arguments.quiet;
    let outcome = match arguments.verb {
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
            fit(&scene, out, seed, (&stages, way), quiet)
        }
        Verb::Check { scene, json } => check(&scene, json, quiet),
        Verb::Simulate { scene, out, runs, seed } => simulate(&scene, &out, runs, seed, quiet),
        Verb::Predict(asked) => predict::predict(&asked, quiet),
        Verb::Trade { scene, out, seed } => run_trade(&scene, out, seed, quiet),
        Verb::Calibrate { out, sets, seed } => calibrate(&out, sets, seed, quiet),
    };
    match outcome {
        Ok(status) => ExitCode::from(status),
        Err(error) => {
            let label = label("error", "\u{1b}[1;31m");
            let _ = writeln!(std::io::stderr(), "{label}: {error}");
            ExitCode::from(COULD_NOT_RUN)
        }
    }
}

/// An accuracy that may be asked for.
fn read_accuracy(text: &str) -> Result<f64, String> {
    let (least, most) = RANGE;
    let expected = || format!("expected a number from {least} to {most}");
    let value: f64 = text.parse().map_err(|_| expected())?;
    Some(value)
        .filter(|value| (least..=most).contains(value))
        .ok_or_else(expected)
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

/// A word before a message, coloured on a terminal only.
fn label(word: &str, colour: &str) -> String {
    let plain = !std::io::stderr().is_terminal() || std::env::var_os("NO_COLOR").is_some();
    if plain {
        word.to_owned()
    } else {
        format!("{colour}{word}\u{1b}[0m")
    }
}

fn warn(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}: {text}", label("notice", "\u{1b}[1;33m"));
}

fn tell(notices: &[Notice], quiet: bool) {
    if !quiet {
        for notice in notices {
            warn(&notice.text);
        }
    }
}

/// Prints to standard output. A reader that has left is no error.
fn say(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("standard output"), "write", error))
        }
        _ => Ok(()),
    }
}

/// Seconds each stage took, for `timing.json`.
struct Timing {
    started: Instant,
    stages: Vec<(&'static str, f64)>,
}

impl Timing {
    fn stage<T>(&mut self, name: &'static str, quiet: bool, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let progress = Progress::spinner(name, quiet);
        let done = work();
        drop(progress);
        self.stages.push((name, started.elapsed().as_secs_f64()));
        done
    }

    /// Least squares, and the bootstrap from where it is first told of replicates.
    fn fits<T>(&mut self, replicates: u64, quiet: bool, work: impl FnOnce(&(dyn Fn(usize) + Sync)) -> T) -> T {
        let started = Instant::now();
        let progress = Progress::bar("bootstrap", replicates, quiet);
        let finished = AtomicU64::new(0);
        let bootstrap = OnceLock::new();
        let done = work(&|more| {
            bootstrap.get_or_init(Instant::now);
            let before = finished.fetch_add(more as u64, Relaxed);
            progress.at(before + more as u64);
        });
        let ended = Instant::now();
        let fitted = *bootstrap.get().unwrap_or(&ended);
        self.stages.push(("least_squares", (fitted - started).as_secs_f64()));
        if fitted != ended {
            self.stages.push(("bootstrap", (ended - fitted).as_secs_f64()));
        }
        done
    }

    fn json(&self) -> String {
        let mut stages: Vec<String> = self
            .stages
            .iter()
            .map(|(name, seconds)| format!("  \"{name}\": {seconds:.6}"))
            .collect();
        stages.push(format!("  \"all\": {:.6}", self.started.elapsed().as_secs_f64()));
        format!("{{\n{}\n}}\n", stages.join(",\n"))
    }
}

fn fit(path: &Path, out: Option<PathBuf>, seed: u64, (stages, way): (&[Stage], Way), quiet: bool) -> Result<u8, Error> {
    let mut timing = Timing {
        started: Instant::now(),
        stages: vec![],
    };
    let wanted = |stage: Stage| stages.is_empty() || stages.contains(&stage);
    if !wanted(Stage::LeastSquares) {
        return Err(Error::Usage(
            "every stage starts from the fits: add least_squares to --stages".to_owned(),
        ));
    }
    if wanted(Stage::Compare) && !wanted(Stage::Posterior) {
        return Err(Error::Usage(
            "compare starts from the posterior: add posterior to --stages".to_owned(),
        ));
    }
    let scene = scene::read(path)?;
    let out = out.unwrap_or_else(|| Path::new("reports").join(&scene.name));
    folder::check(&out, Contents::Fit, &scene.title)?;
    let table = timing.stage("read", quiet, || runs::read(&scene))?;
    let mut findings = timing.fits(scene.bootstrap.replicates, quiet, |done| {
        findings::find_watched(&scene, &table, seed, wanted(Stage::Bootstrap), done)
    });
    let overview = overview::find(&scene, &table, &findings);
    let mut posterior = None;
    if wanted(Stage::Posterior) {
        let draws = Draws::of(&scene, quiet, "posterior", 1);
        let runs = &table.runs;
        posterior = timing.stage("posterior", true, || {
            findings.add_posterior(&scene, runs, way, &|kept, diverging| draws.one(kept, diverging))
        })?;
        drop(draws);
        if let Some(posterior) = &posterior {
            let parts = ["posterior_compressing", "posterior_sampling", "posterior_checking"];
            timing.stages.extend(parts.into_iter().zip(posterior.sampled.seconds));
        }
    }
    if let Some(posterior) = posterior.as_ref().filter(|_| wanted(Stage::Compare)) {
        let draws = Draws::of(&scene, quiet, "compare", COMPARED);
        timing.stage("compare", true, || {
            let watcher = |kept, diverging| draws.one(kept, diverging);
            findings.add_comparison(&scene, &table.runs, posterior, &watcher)
        })?;
    }
    let told = Told {
        scene: &scene,
        runs: &table.runs,
        overview: &overview,
        findings: &findings,
        posterior: posterior.as_ref(),
    };
    let files = timing.stage("report", quiet, || report::files(told, wanted(Stage::Figures)));
    let mut files = files?;
    let began = Instant::now();
    files.last = Some(Box::new(move || {
        timing.stages.push(("write", began.elapsed().as_secs_f64()));
        ("timing.json".to_owned(), timing.json().into_bytes())
    }));
    folder::write(&out, Contents::Fit, &scene.title, files)?;
    tell(&findings.notices, quiet);
    if !quiet {
        let report = out.join("report.md");
        say(&format!("{}report: {}\n", markdown::summary(told), report.display()))?;
    }
    Ok(if verdicts::quotable(&findings.verdicts) {
        0
    } else {
        NOT_QUOTABLE
    })
}

/// Models that are sampled besides the scene's own: forms of the law, and trends with the film.
const COMPARED: u64 = 10;

/// Shows draws as they come, and counts divergences among the kept ones.
struct Draws {
    progress: Progress,
    name: &'static str,
    drawn: AtomicU64,
    diverged: AtomicU64,
}

impl Draws {
    /// Draws of so many posteriors of the scene.
    fn of(scene: &Scene, quiet: bool, name: &'static str, posteriors: u64) -> Draws {
        let sampler = &scene.sampler;
        let all = sampler
            .chains
            .saturating_mul(sampler.warmup.saturating_add(sampler.draws));
        Draws {
            progress: Progress::bar(name, all.saturating_mul(posteriors), quiet),
            name,
            drawn: AtomicU64::new(0),
            diverged: AtomicU64::new(0),
        }
    }

    fn one(&self, kept: bool, diverging: bool) {
        let drawn = 1 + self.drawn.fetch_add(1, Relaxed);
        if kept && diverging {
            let diverged = 1 + self.diverged.fetch_add(1, Relaxed);
            self.progress.say(format!("{}, {diverged} divergences", self.name));
        }
        if drawn.is_multiple_of(64) {
            self.progress.at(drawn);
        }
    }
}

fn check(path: &Path, json: bool, quiet: bool) -> Result<u8, Error> {
    let scene = scene::read(path)?;
    let progress = Progress::spinner("read", quiet);
    let table = runs::read(&scene);
    drop(progress);
    let table = table?;
    let least_squares = findings::find(&scene, &table, 1, false);
    let overview = overview::find(&scene, &table, &least_squares);
    if json {
        say(&report::json::text(&overview)?)?;
    } else {
        tell(&overview.notices, quiet);
        say(&markdown::overview_text(&overview))?;
    }
    Ok(0)
}

fn simulate(path: &Path, out: &Path, runs: Option<u64>, seed: u64, quiet: bool) -> Result<u8, Error> {
    if !runs::can_write(out) {
        let text = format!("{}: expected a file ending in .csv or .parquet", out.display());
        return Err(Error::Usage(text));
    }
    let scene = scene::read(path)?;
    let simulation = Simulation::new(&scene, runs)?;
    let progress = Progress::bar("simulate", simulation.runs(), quiet);
    let mut writer = RunWriter::create(out)?;
    let mut written = 0u64;
    simulation.draw(seed, |run| {
        written += 1;
        if written.is_multiple_of(1 << 16) {
            progress.at(written);
        }
        writer.write(run)
    })?;
    writer.finish()?;
    drop(progress);
    if !quiet {
        if simulation.left_out > 0 {
            warn(&format!(
                "{} combinations of film ratio and diameter not made: the scene's own screens would leave them out",
                simulation.left_out
            ));
        }
        say(&format!("{written} simulated runs: {}\n", out.display()))?;
    }
    Ok(0)
}

fn run_trade(path: &Path, out: Option<PathBuf>, seed: u64, quiet: bool) -> Result<u8, Error> {
    let scene = scene::read(path)?;
    let out = out.unwrap_or_else(|| Path::new("reports").join(format!("{}-trade", scene.name)));
    folder::check(&out, Contents::Trade, &scene.title)?;
    let table = runs::read(&scene)?;
    let progress = Progress::bar("trade", trade::PATHS, quiet);
    let done = AtomicU64::new(0);
    let measured = trade::measure(&scene, &table, seed, &|| progress.at(1 + done.fetch_add(1, Relaxed)))?;
    drop(progress);
    let files = trade_report::files(&scene, &measured)?;
    folder::write(&out, Contents::Trade, &scene.title, files)?;
    tell(&table.notices, quiet);
    if !quiet {
        let page = out.join("trade.md");
        say(&format!(
            "{}trade: {}\n",
            trade_report::summary(&measured),
            page.display()
        ))?;
    }
    Ok(0)
}

fn calibrate(out: &Path, sets: u64, seed: u64, quiet: bool) -> Result<u8, Error> {
    // an accuracy takes about as long as a hundred data sets
    let of_accuracy = 100;
    let all = sets * calibration::DESIGNS + of_accuracy * accuracy::SCENES;
    let progress = Progress::bar("calibrate", all, quiet);
    let done = AtomicU64::new(0);
    let step = || progress.at(1 + done.fetch_add(1, Relaxed));
    let table = calibration::measure(sets, calibration::REPLICATES, seed, &step)?;
    let kept = accuracy::measure(accuracy::SCENES, seed, &|| {
        progress.at(of_accuracy + done.fetch_add(of_accuracy, Relaxed));
    })?;
    let text = calibration::markdown(&table) + &accuracy::markdown(&kept);
    std::fs::write(out, text).map_err(|error| Error::io(out, "write", error))?;
    drop(progress);
    if !quiet {
        say(&format!("table: {}\n", out.display()))?;
    }
    Ok(0)
}
