//! Says what may be said: estimates with their verdicts, as numbers and fixed words, no prose of a report.
//!
//! A file uses only what stands above it in this table; this one, which calls them in turn, stands last.
//!
//! | file | job |
//! |---|---|
//! | `notices.rs` | what wants a second look: codes, sentences, next steps |
//! | `estimate.rs` | a number with its standard error, its interval, or why there is none |
//! | `judge.rs` | whether a fit may be quoted |
//! | `quantities.rs` | estimates of quantities from a fit, by the delta method |
//! | `range.rs` | the smallest and the largest of some numbers |
//! | `shown.rs` | the film ratio shown where one must be chosen |
//! | `own_dry_speed.rs` | e_dry at each run's own speed |
//! | `measurement_errors.rs` | measurement errors of the runs of a fit |
//! | `dry.rs` | k of each particle, and whether one k serves all diameters |
//! | `series.rs` | the square-root law of each series |
//! | `scaling.rs` | e_inf and St_c by both laws, with the linear law's bias on this design |
//! | `error_notices.rs` | notices of measurement errors that matter or are too large |
//! | `energy.rs` | the energy the liquid takes, St_c·e_inf², δc |
//! | `published.rs` | ours beside the literature's |
//! | `balance.rs` | L, inertial prefactor and film scale from every rebound at once |
//! | `pooling.rs` | what pooling liquids does to the square-root law |
//! | `terms/` | what each term of the balance matters, and whether it is held |
//! | `noise/` | outliers, unequal spreads, offsets that series share |
//! | `bootstrap/` | the bootstrap interval of each estimate |
//! | `checks.rs` | the table of what must hold: codes, lines, sources, advice |
//! | `verdicts.rs` | what must hold before the numbers are quoted |
//! | `constants/` | how results move with the constants taken as exact |
//! | `least_squares.rs` | what least squares found, for the stages that start from it |
//! | `identify/` | what the runs can identify, and what is determined instead |
//! | `predict.rs` | restitution at any speed from the posterior's draws |
//! | `posterior/` | parameters from all runs at once, with priors |
//! | `regions.rs` | where e_inf and St_c lie together |
//! | `compare.rs` | which form of the law predicts best |
//! | `questions/` | whether L and C are the same at every film ratio |
//! | `document.rs` | everything a fit says, as `findings.json` writes it |
//! | `overview.rs` | what was read, for `check` |

pub mod balance;
pub mod bootstrap;
pub mod checks;
pub mod compare;
pub mod constants;
mod document;
pub mod dry;
pub mod energy;
pub mod error_notices;
pub mod estimate;
pub mod identify;
mod judge;
pub mod least_squares;
pub mod measurement_errors;
pub mod noise;
mod notices;
pub mod overview;
pub mod own_dry_speed;
mod places;
mod pooling;
pub mod posterior;
pub mod predict;
pub mod published;
mod quantities;
pub mod questions;
mod range;
pub mod regions;
pub mod scaling;
pub mod series;
pub mod shown;
pub mod terms;
pub mod verdicts;

use crate::error::Error;
use crate::inference::nuts::Watcher;
use crate::physics::inertia::Inertia;
use crate::runs::{Runs, Table};
use crate::scene::{NoiseOn, Scene};
use compare::Comparison;
use estimate::Quoting;
use posterior::{contraction, Asked, Declined, Posterior, Way};

pub use document::{Counts, Findings, SCHEMA};
pub use judge::Verdict;

/// Fits everything least squares can say of a scene's runs; with `bootstrap`, resamples them as the scene says.
pub fn find(scene: &Scene, table: &Table, seed: u64, bootstrap: bool) -> Findings {
    find_watched(scene, table, seed, bootstrap, &|_| ())
}

/// The same; `done` is told 0 before the first replicate, then of replicates as they are finished.
pub fn find_watched(
    scene: &Scene,
    table: &Table,
    seed: u64,
    bootstrap: bool,
    done: &(dyn Fn(usize) + Sync),
) -> Findings {
    let runs = &table.runs;
    let quoting = Quoting {
        level: scene.bootstrap.level,
    };
    let mut dry = dry::find(scene, runs, quoting);
    let (mut series, mut scaling) = rayon::join(
        || series::find(scene, runs, &dry, quoting),
        || scaling::find(scene, runs, &dry, quoting),
    );
    let setup = balance::Setup {
        scene,
        runs,
        dry: &dry,
        quoting,
    };
    let (form, energy_balance, terms) = terms::settle(setup, &scaling);
    if let Some(balance) = &energy_balance {
        pooling::add_bias(setup, &mut scaling, balance);
    }
    let mut energy = energy::find(scene, runs, &dry, &scaling, quoting);
    let (constants, of_constants) = constants::find(scene, runs, &dry, &scaling, energy_balance.as_ref());
    let noise = noise::find(scene, runs, &dry, energy_balance.as_ref(), form);
    let resampled = bootstrap.then(|| {
        done(0);
        let estimates = bootstrap::Estimates {
            dry: &mut dry,
            series: &mut series,
            scaling: &mut scaling,
            energy: &mut energy,
        };
        bootstrap::complete(
            scene,
            runs,
            estimates,
            bootstrap::Options { seed, keep_all: false },
            done,
        )
    });
    let published = published::find(scene, &dry, &scaling);
    let mut verdicts = verdicts::find(runs, &dry, &series, &scaling, energy_balance.as_ref());
    if bootstrap {
        verdicts.extend(verdicts::of_replicates(&dry, &scaling));
    }
    let mut notices = table.notices.clone();
    notices.extend(terms::notices(&terms));
    notices.extend(verdicts::of_table(table));
    notices.extend(verdicts::of_fits(scene, &dry, &series, &scaling));
    notices.extend(verdicts::of_settings(scene, bootstrap));
    notices.extend(notices::viscous_form(form, runs.wet()));
    let (resampling, of_resampling) = resampled.unzip();
    notices.extend(of_resampling.into_iter().flatten());
    notices.extend(of_constants);
    notices.extend(noise::notices(scene, noise.as_ref()));
    let mut findings = Findings {
        schema: SCHEMA,
        scene: scene.name.clone(),
        title: scene.title.clone(),
        wetcor: env!("CARGO_PKG_VERSION"),
        seed,
        data_sha256: table.sha256.clone(),
        scene_sha256: scene.sha256.clone(),
        counts: Counts {
            runs: table.rows,
            used: runs.len() - runs.stuck(),
            stuck: runs.stuck(),
            screened: table.screened.clone(),
            measurement_errors: measurement_errors::RunsWithErrors::of(runs),
        },
        dry: dry.into_iter().map(|fitted| fitted.dry).collect(),
        series,
        scaling: scaling.into_iter().map(|fitted| fitted.scaling).collect(),
        energy_balance,
        terms,
        form,
        energy,
        constants,
        noise,
        bootstrap: resampling,
        published,
        posterior: None,
        compare: None,
        questions: None,
        identifies: None,
        verdicts,
        notices,
    };
    findings.notices.extend(error_notices::notices(&findings.scaling));
    findings.identifies = identify::directions(scene, runs, findings.least_squares());
    findings.notices.extend(identify::notice(findings.identifies.as_ref()));
    findings
}

impl Findings {
    /// Samples the posterior from these least-squares findings, and adds what it says; `None` where the runs are such
    /// that nothing was sampled, which a failed check then tells.
    ///
    /// Fails where a prior leaves a parameter no room.
    pub fn add_posterior(
        &mut self,
        scene: &Scene,
        runs: &Runs,
        way: Way,
        watcher: Watcher,
    ) -> Result<Option<Posterior>, Error> {
        let mut asked = Asked { form: self.form, way };
        if scene.model.inertia_is_open() && self.form.inertia != Inertia::None {
            let (chosen, notice) = compare::choose(scene, runs, self.least_squares(), asked, watcher)?;
            asked = chosen;
            self.notices.extend(notice);
        }
        match posterior::find(scene, runs, self.least_squares(), asked, watcher)? {
            Ok(posterior) => {
                // the posterior's own check of k against the dry runs takes the place of least squares'
                let replaced = |check: &checks::Check| posterior.checks.iter().any(|new| new.check == check.check);
                self.verdicts.retain(|check| !replaced(check));
                if scene.model.noise == NoiseOn::Both {
                    // least squares knows neither this noise nor the runs that stuck: the posterior's parameters are quoted
                    for check in &mut self.verdicts {
                        check.gates &= check.check != checks::ENERGY_BALANCE.code;
                    }
                }
                self.verdicts.extend(posterior.checks.iter().cloned());
                let directions = self.identifies.as_ref();
                self.notices
                    .extend(contraction::notices(&posterior.findings, directions));
                self.posterior = Some(posterior.findings.clone());
                Ok(Some(posterior))
            }
            Err(Declined(check)) => {
                self.verdicts.push(check);
                Ok(None)
            }
        }
    }

    /// Compares the forms of the law, asks whether L and C are constant, and adds what that says.
    ///
    /// Fails where a prior leaves a parameter of some form no room.
    pub fn add_comparison(
        &mut self,
        scene: &Scene,
        runs: &Runs,
        posterior: &Posterior,
        watcher: Watcher,
    ) -> Result<Comparison, Error> {
        let found = compare::find(scene, runs, (self.least_squares(), posterior), watcher);
        self.verdicts.extend(found.checks.iter().cloned());
        self.notices.extend(found.notices.iter().cloned());
        self.compare = (!found.models.is_empty()).then(|| found.models.clone());
        let context = questions::Context {
            scene,
            runs,
            least_squares: self.least_squares(),
            own: posterior,
            own_loo: found.own.as_ref(),
            watcher,
        };
        let (questions, notices) = questions::find(context)?;
        self.notices.extend(notices);
        self.questions = Some(questions);
        Ok(found)
    }
}
