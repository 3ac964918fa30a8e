//! Runs `wetcor fit`: every requested stage, and the report of what was found.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use wetcor::error::{named, Error};
use wetcor::findings::posterior::{ExpectedSampling, MethodChoice, Posterior};
use wetcor::findings::{self, Findings};
use wetcor::inference::accuracy::RANGE;
use wetcor::model::parameters::ModelParameters;
use wetcor::ranks::Ranks;
use wetcor::report::folder::{Contents, Destination};
use wetcor::report::{self, ReportInput};
use wetcor::runs::{self, Runs};
use wetcor::scene::{self, Scene};

use super::draws::Draws;
use super::messages::{print_after_writing, print_cautions, say, status};
use super::timing::Timing;
use crate::progress::is_quiet;

/// Models that are sampled besides the scene's own: forms of the law, and trends with the film.
const COMPARED: u64 = 10;

#[derive(Args)]
#[command(after_help = include_str!("help/fit.txt").trim_ascii_end())]
pub(super) struct Fit {
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

/// An accuracy inside the range that may be requested.
fn read_accuracy(text: &str) -> Result<f64, String> {
    let (least, most) = RANGE;
    let value = text.parse().ok().filter(|value: &f64| (least..=most).contains(value));
    value.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

impl Fit {
    fn method(&self) -> MethodChoice {
        match self.accuracy {
            Some(accuracy) => MethodChoice::Accuracy(accuracy),
            None if self.exact_rows => MethodChoice::Rows,
            None => MethodChoice::Sampler,
        }
    }

    fn wants(&self, stage: Stage) -> bool {
        self.stages.is_empty() || self.stages.contains(&stage)
    }

    /// Checks that every stage has the one it starts from.
    fn check_stages(&self) -> Result<(), Error> {
        let lacks = if !self.wants(Stage::LeastSquares) {
            "every stage starts from the fits: add least_squares to --stages"
        } else if self.wants(Stage::Compare) && !self.wants(Stage::Posterior) {
            "compare starts from the posterior: add posterior to --stages"
        } else {
            return Ok(());
        };
        Err(Error::Usage(lacks.to_owned()))
    }

    /// The command that makes the report again: what was given, without what changes no number.
    fn command(&self) -> String {
        let mut words = vec![
            "wetcor".to_owned(),
            "fit".to_owned(),
            shell_word(&self.scene.to_string_lossy()),
        ];
        let mut flag = |name: &str, value: String| words.extend([name.to_owned(), value]);
        if let Some(out) = &self.out {
            flag("--out", shell_word(&out.to_string_lossy()));
        }
        flag("--seed", self.seed.to_string());
        if !self.stages.is_empty() {
            let names = self.stages.iter().filter_map(ValueEnum::to_possible_value);
            let names: Vec<String> = names.map(|stage| stage.get_name().to_owned()).collect();
            flag("--stages", names.join(","));
        }
        if let Some(accuracy) = self.accuracy {
            flag("--accuracy", accuracy.to_string());
        }
        if self.exact_rows {
            words.push("--exact-rows".to_owned());
        }
        words.join(" ")
    }

    /// Samples the posterior, and those of the models it is compared with.
    fn sample(
        &self,
        scene: &Scene,
        runs: &Runs,
        findings: &mut Findings,
        timing: &mut Timing,
    ) -> Result<Option<Posterior>, Error> {
        let method = self.method();
        let mut posterior = None;
        if self.wants(Stage::Posterior) {
            if !is_quiet() {
                say_how_long(
                    findings.expected_sampling(scene, runs, method),
                    self.wants(Stage::Compare) && findings::is_compared(scene, runs),
                );
            }
            let draws = Draws::of(scene, "posterior", 1);
            posterior = timing.time("posterior", || {
                findings.add_posterior(scene, runs, method, &|kept, diverging| draws.one(kept, diverging))
            })?;
            drop(draws);
            if let Some(posterior) = &posterior {
                let parts = ["posterior_mode", "posterior_sampling"];
                timing.stages.extend(parts.into_iter().zip(posterior.sampled.seconds));
            }
        }
        if let Some(posterior) = posterior.as_ref().filter(|_| self.wants(Stage::Compare)) {
            let draws = Draws::of(scene, "compare", COMPARED);
            timing.time("compare", || {
                let watcher = |kept, diverging| draws.one(kept, diverging);
                findings.add_comparison(scene, runs, posterior, &watcher)
            })?;
        }
        Ok(posterior)
    }
}

/// A word as a shell takes it, in quotes where it needs them.
fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Says how long sampling will take, with the models that it is compared with, where that is more than a moment.
fn say_how_long(expected: Option<ExpectedSampling>, is_compared: bool) {
    const MOMENT: f64 = 5.0;
    let Some(ExpectedSampling { one, all }) = expected else {
        return;
    };
    let others = if is_compared { COMPARED } else { 0 };
    if (1 + others) as f64 * all > MOMENT {
        let each = match others {
            0 => String::new(),
            _ => format!(" for each of up to {} models", 1 + others),
        };
        say(&format!(
            "sampling reads the runs one by one, {:.2} ms each time: about {all:.1} s{each}",
            1e3 * one
        ));
    }
}

/// Fits a scene; ranks share the reading of a table of more runs than are kept, and the first does the rest.
pub(super) fn fit(fit: &Fit, ranks: &Ranks) -> Result<u8, Error> {
    let mut timing = Timing {
        started: Instant::now(),
        stages: vec![],
    };
    fit.check_stages()?;
    let scene = scene::read(&fit.scene)?;
    let default_out = || Path::new("reports").join(&scene.name);
    let out = fit.out.clone().unwrap_or_else(default_out);
    let prepare = || Destination::prepare(&out, Contents::Fit, &scene.title, &scene.inputs());
    let destination = ranks.is_first().then(prepare).transpose()?;
    let most_kept = if fit.exact_rows { usize::MAX } else { runs::MOST_KEPT };
    let table = timing.stage("read", || runs::read_any_number(&scene, most_kept, ranks))?;
    let Some(destination) = destination else {
        return Ok(0);
    };
    if fit.wants(Stage::Posterior) {
        // a prior without room is refused now, not after the bootstrap
        ModelParameters::of(&scene, &table.runs, scene.model.form())?;
    }
    let mut findings = timing.fits(scene.bootstrap.replicates, |done| {
        let watcher = fit.wants(Stage::Bootstrap).then_some(done);
        findings::fit_least_squares_watched(&scene, &table, fit.seed, watcher)
    });
    let posterior = fit.sample(&scene, &table.runs, &mut findings, &mut timing)?;
    let command = fit.command();
    let input = ReportInput {
        command: &command,
        scene: posterior
            .as_ref()
            .and_then(|posterior| posterior.scene.as_deref())
            .unwrap_or(&scene),
        runs: &table.runs,
        findings: &findings,
        posterior: posterior.as_ref(),
    };
    let files = timing.stage("report", || report::files(input, fit.wants(Stage::Figures)));
    let mut files = files?;
    let began = Instant::now();
    files.last = Some(Box::new(move || {
        timing.stages.push(("write", began.elapsed().as_secs_f64()));
        ("timing.json".to_owned(), timing.json().into_bytes())
    }));
    destination.write(files)?;
    let report = out.join("report.md");
    let text = format!(
        "{}report: {} (in a browser: {})\n",
        report::summary(input)?,
        named(&report),
        named(&out.join("report.html"))
    );
    print_after_writing(&report, &text)?;
    print_cautions(&findings, fit.verbose);
    Ok(status(findings.main.verdict.passed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_is_made_again_by_the_command_that_was_given() {
        let given = Fit {
            scene: PathBuf::from("drops/May's drops.toml"),
            out: Some(PathBuf::from("reports/drops")),
            seed: 7,
            stages: vec![Stage::LeastSquares, Stage::Figures],
            exact_rows: true,
            accuracy: Some(0.1),
            verbose: false,
        };
        let command = "wetcor fit 'drops/May'\\''s drops.toml' --out reports/drops --seed 7 --stages \
                       least_squares,figures --accuracy 0.1 --exact-rows";
        assert_eq!(given.command(), command);
    }
}
