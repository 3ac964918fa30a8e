//! Says what may be said: estimates with their verdicts, as numbers and fixed words, no prose of a report.
//!
//! | file | job |
//! |---|---|
//! | `estimate.rs` | a number with its standard error, its interval, or why there is none |
//! | `judge.rs` | whether a fit may be quoted |
//! | `dry.rs` | k of each particle, and whether one k serves all diameters |
//! | `erring.rs` | what the runs of a fit are measured to err by |
//! | `own_dry_speed.rs` | e_dry at each run's own speed |
//! | `series.rs` | the square-root law of each series |
//! | `scaling.rs` | e_inf and St_c by both laws, with the linear law's bias on this design |
//! | `balance.rs` | L, inertial prefactor and film scale from every rebound at once |
//! | `pooling.rs` | what pooling liquids does to the square-root law |
//! | `terms/` | what each term of the balance matters, and whether it is held |
//! | `energy.rs` | the energy the liquid takes, St_c·e_inf², δc |
//! | `noise/` | outliers, unequal spreads, offsets that series share |
//! | `constants/` | how results move with the constants taken as exact |
//! | `bootstrap/` | the bootstrap interval of each estimate |
//! | `posterior/` | parameters from all runs at once, with priors |
//! | `predict.rs` | restitution at any speed from the posterior's draws |
//! | `compare.rs` | which form of the law predicts best |
//! | `questions/` | whether L and C are the same at every film ratio |
//! | `shown.rs` | the film ratio shown where one must be chosen |
//! | `published.rs` | ours beside the literature's |
//! | `verdicts.rs` | what must hold before the numbers are quoted |
//! | `identify/` | what the runs can identify, and what is determined instead |
//! | `overview.rs` | what was read, for `check` |

pub mod balance;
pub mod bootstrap;
pub mod compare;
pub mod constants;
pub mod dry;
pub mod energy;
pub mod erring;
pub mod estimate;
pub mod identify;
mod judge;
pub mod noise;
pub mod overview;
pub mod own_dry_speed;
mod pooling;
pub mod posterior;
pub mod predict;
pub mod published;
pub mod questions;
pub mod scaling;
pub mod series;
pub mod shown;
pub mod terms;
pub mod verdicts;

use serde::Serialize;

use crate::error::Error;
use crate::inference::nuts::Watcher;
use crate::notice::Notice;
use crate::physics::impact::Form;
use crate::physics::inertia::Inertia;
use crate::runs::{Runs, Screened, Table};
use crate::scene::{NoiseOn, Scene};
use compare::Comparison;
use estimate::Quoting;
use posterior::{Asked, Declined, Posterior, Way};

/// The name and version of the findings file's layout.
pub const SCHEMA: &str = "wetcor.findings/1";

/// Everything a fit says. Field names are those of `findings.json`.
#[derive(Debug, Serialize)]
pub struct Findings {
    /// always [`SCHEMA`]
    pub schema: &'static str,
    /// the scene's folder name
    pub scene: String,
    /// the scene's title
    pub title: String,
    /// version that made this
    pub wetcor: &'static str,
    /// seed of every use of chance
    pub seed: u64,
    /// SHA-256 of the table of runs
    pub data_sha256: String,
    /// SHA-256 of the scene file
    pub scene_sha256: String,
    /// what was read and used
    pub counts: Counts,
    /// k of each particle with dry runs
    pub dry: Vec<dry::Dry>,
    /// the square-root law of each series
    pub series: Vec<series::SeriesFit>,
    /// e_inf and St_c by both laws
    pub scaling: Vec<scaling::Scaling>,
    /// L, inertial prefactor and film scale over all rebounds; `None` without a usable k
    pub energy_balance: Option<balance::EnergyBalance>,
    /// what each term of the energy balance matters, and whether it is held
    pub terms: Vec<terms::SizedTerm>,
    /// the energy balance that is held; its form of inertia may still be open
    #[serde(skip)]
    pub form: Form,
    /// where the energy went
    pub energy: Vec<energy::Energy>,
    /// how results move with the constants taken as exact
    pub constants: Vec<constants::Sensitivity>,
    /// what the scatter of the runs is like; `None` without a fit or without scatter
    pub noise: Option<noise::Noise>,
    /// how replicates were made; `None`: a stage that was not run
    pub bootstrap: Option<bootstrap::Resampling>,
    /// the literature beside ours
    pub published: Vec<published::Compared>,
    /// what all runs at once say under the priors; `None` if the stage was not run
    pub posterior: Option<posterior::PosteriorFindings>,
    /// how well each form of the law predicts runs it has not seen; `None` if the stage was not run
    pub compare: Option<Vec<compare::Compared>>,
    /// whether L and C are the same at every film ratio; `None` if the stage was not run
    pub questions: Option<Vec<questions::Question>>,
    /// what the runs see of the parameters; `None` without parameters, or where a sum is not finite
    pub identifies: Option<identify::Directions>,
    /// what must hold before the numbers are quoted
    pub verdicts: Vec<verdicts::Check>,
    /// what wants a second look
    pub notices: Vec<Notice>,
}

/// What was read and used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// rows of the file
    pub runs: usize,
    /// rebounds used by least squares
    pub used: usize,
    /// runs that stuck
    pub stuck: usize,
    /// runs left out, by reason
    pub screened: Vec<Screened>,
    /// runs in use that carry measurement errors; `None` where none does
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<erring::Given>,
}

/// Whether a result may be quoted, and why or why not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// whether it may be quoted
    pub passed: bool,
    /// why, in words
    pub reason: String,
}

impl Verdict {
    /// Passed, with a remark.
    pub fn passed(reason: impl Into<String>) -> Verdict {
        Verdict {
            passed: true,
            reason: reason.into(),
        }
    }

    /// Failed, with the reason.
    pub fn failed(reason: impl Into<String>) -> Verdict {
        Verdict {
            passed: false,
            reason: reason.into(),
        }
    }
}

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
    let (form, energy_balance, terms) = terms::settle(scene, runs, &dry, &mut scaling, quoting);
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
        bootstrap::complete(scene, runs, estimates, seed, false, done)
    });
    let published = published::find(scene, &dry, &scaling);
    let mut verdicts = verdicts::find(runs, &dry, &series, &scaling, energy_balance.as_ref());
    if bootstrap {
        verdicts.extend(verdicts::of_replicates(&dry, &scaling));
    }
    let mut notices = table.notices.clone();
    notices.extend(terms::notices(&terms));
    notices.extend(verdicts::notices(scene, table, &dry, &series, &scaling, bootstrap));
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
            measurement_errors: erring::Given::of(runs),
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
    findings.notices.extend(erring::notices(&findings.scaling));
    findings.identifies = identify::directions(scene, runs, &findings);
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
            let (chosen, notice) = compare::choose(scene, runs, self, asked, watcher)?;
            asked = chosen;
            self.notices.extend(notice);
        }
        match posterior::find(scene, runs, self, asked, self.seed, watcher)? {
            Ok(posterior) => {
                // the posterior's own check of k against the dry runs takes the place of least squares'
                let replaced = |check: &verdicts::Check| posterior.checks.iter().any(|new| new.check == check.check);
                self.verdicts.retain(|check| !replaced(check));
                if scene.model.noise == NoiseOn::Both {
                    // least squares knows neither this noise nor the runs that stuck: the posterior's parameters are quoted
                    for check in &mut self.verdicts {
                        check.gates &= check.check != verdicts::ENERGY_BALANCE;
                    }
                }
                self.verdicts.extend(posterior.checks.iter().cloned());
                self.notices.extend(posterior.notices.iter().cloned());
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
        let found = compare::find(scene, runs, (self, posterior), watcher);
        self.verdicts.extend(found.checks.iter().cloned());
        self.notices.extend(found.notices.iter().cloned());
        self.compare = (!found.models.is_empty()).then(|| found.models.clone());
        let context = questions::Context {
            scene,
            runs,
            least_squares: self,
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
