//! Says what may be said: estimates with their verdicts, as numbers and fixed words, no prose of a report.
//!
//! A file uses only what stands above it in this table; this one, which calls them in turn, stands last.
//!
//! | file | job |
//! |---|---|
//! | `notices.rs` | what wants a second look: codes, sentences, next steps |
//! | `estimate.rs` | a number with its standard error, its interval, or why there is none |
//! | `fit_verdict.rs` | whether a fit may be quoted |
//! | `quantities.rs` | estimates of quantities from a fit, by the delta method |
//! | `range.rs` | the smallest and the largest of some numbers |
//! | `film_ratio.rs` | the film ratio that stands for the others of a particle, and how one is rounded |
//! | `places.rs` | where an energy balance is told: film ratios of particles, and diameters where the form tells them apart |
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
//! | `identify/` | which parameters the runs identify, and which combinations are determined instead |
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
pub mod film_ratio;
mod fit_verdict;
pub mod identify;
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
pub mod terms;
pub mod verdicts;

use crate::error::Error;
use crate::inference::nuts::Watcher;
use crate::notice::Notice;
use crate::physics::inertia::Inertia;
use crate::physics::Form;
use crate::runs::{Runs, Table};
use crate::scene::{NoiseOn, Scene};
use balance::EnergyBalance;
use bootstrap::Resampling;
use checks::Check;
use compare::{Comparison, ComparisonContext};
use dry::FittedDry;
use energy::Energy;
use estimate::Quoting;
use posterior::{contraction, MethodChoice, Posterior, PosteriorRefusal, SamplingSetup};
use scaling::FittedScaling;
use series::SeriesFit;
use terms::SizedTerm;

pub use document::{Counts, Findings, SCHEMA};
pub use fit_verdict::Verdict;

/// Fits everything least squares can say of a scene's runs; with `bootstrap`, resamples them as the scene says.
pub fn fit_least_squares(scene: &Scene, table: &Table, seed: u64, bootstrap: bool) -> Findings {
    fit_least_squares_watched(scene, table, seed, bootstrap, &|_| ())
}

/// The same; `done` is called with 0 before the first replicate, then with the number of replicates finished.
pub fn fit_least_squares_watched(
    scene: &Scene,
    table: &Table,
    seed: u64,
    bootstrap: bool,
    done: &(dyn Fn(usize) + Sync),
) -> Findings {
    let runs = &table.runs;
    let mut fits = LeastSquaresFits::new(scene, runs);
    let balance = fits.energy_balance.as_ref();
    let (constants, constants_notice) = constants::find_sensitivities(scene, runs, &fits.dry, &fits.scaling, balance);
    let noise = noise::analyse_noise(scene, runs, &fits.dry, balance, fits.form);
    let resampled = bootstrap.then(|| {
        done(0);
        fits.add_bootstrap(scene, runs, seed, done)
    });
    let (resampling, bootstrap_notices) = resampled.unzip();
    let verdicts = fits.checks(runs, bootstrap);
    let mut notices = table.notices.clone();
    notices.extend(fits.notices(scene, table, bootstrap));
    notices.extend(notices::viscous_form(fits.form, runs.wet()));
    notices.extend(bootstrap_notices.into_iter().flatten());
    notices.extend(constants_notice);
    notices.extend(noise::noise_notices(scene, noise.as_ref()));
    let published = published::compare_with_published(scene, &fits.dry, &fits.scaling);
    let mut findings = Findings {
        schema: SCHEMA,
        scene: scene.name.clone(),
        title: scene.title.clone(),
        wetcor: env!("CARGO_PKG_VERSION"),
        seed,
        data_sha256: table.sha256.clone(),
        scene_sha256: scene.sha256.clone(),
        counts: Counts::of(table),
        dry: fits.dry.into_iter().map(|fitted| fitted.dry).collect(),
        series: fits.series,
        scaling: fits.scaling.into_iter().map(|fitted| fitted.scaling).collect(),
        energy_balance: fits.energy_balance,
        terms: fits.terms,
        form: fits.form,
        energy: fits.energy,
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
    let of_errors = error_notices::measurement_error_notices(runs, &findings.scaling);
    findings.notices.extend(of_errors);
    findings.identifies = identify::identify_directions(scene, runs, findings.least_squares());
    let unidentified = identify::unidentified_notice(findings.identifies.as_ref());
    findings.notices.extend(unidentified);
    findings
}

/// Every fit by least squares, with what later stages need of it besides the estimates.
struct LeastSquaresFits {
    dry: Vec<FittedDry>,
    series: Vec<SeriesFit>,
    scaling: Vec<FittedScaling>,
    energy: Vec<Energy>,
    /// the energy balance that is held; its form of inertia may still be open
    form: Form,
    energy_balance: Option<EnergyBalance>,
    terms: Vec<SizedTerm>,
}

impl LeastSquaresFits {
    fn new(scene: &Scene, runs: &Runs) -> LeastSquaresFits {
        let quoting = Quoting {
            level: scene.bootstrap.level,
        };
        let dry = dry::fit_dry_laws(scene, runs, quoting);
        let (series, mut scaling) = rayon::join(
            || series::fit_series(scene, runs, &dry, quoting),
            || scaling::fit_scaling(scene, runs, &dry, quoting),
        );
        let setup = balance::BalanceSetup {
            scene,
            runs,
            dry: &dry,
            quoting,
        };
        let (form, energy_balance, terms) = terms::choose_terms(setup, &scaling);
        if let Some(balance) = &energy_balance {
            pooling::add_bias(setup, &mut scaling, balance);
        }
        let energy = energy::estimate_energy(scene, runs, &dry, &scaling, quoting);
        LeastSquaresFits {
            dry,
            series,
            scaling,
            energy,
            form,
            energy_balance,
            terms,
        }
    }

    /// Gives the estimates their bootstrap intervals.
    fn add_bootstrap(
        &mut self,
        scene: &Scene,
        runs: &Runs,
        seed: u64,
        done: &(dyn Fn(usize) + Sync),
    ) -> (Resampling, Vec<Notice>) {
        let estimates = bootstrap::Estimates {
            dry: &mut self.dry,
            series: &mut self.series,
            scaling: &mut self.scaling,
            energy: &mut self.energy,
        };
        let options = bootstrap::Options { seed, keep_all: false };
        bootstrap::add_bootstrap_intervals(scene, runs, estimates, options, done)
    }

    /// What must hold of the fits, and with `bootstrap` of their replicates.
    fn checks(&self, runs: &Runs, bootstrap: bool) -> Vec<Check> {
        let balance = self.energy_balance.as_ref();
        let mut checks = verdicts::check_least_squares(runs, &self.dry, &self.series, &self.scaling, balance);
        if bootstrap {
            checks.extend(verdicts::check_replicates(&self.dry, &self.scaling));
        }
        checks
    }

    /// What of the terms, the runs, the fits and the settings wants a second look.
    fn notices(&self, scene: &Scene, table: &Table, bootstrap: bool) -> Vec<Notice> {
        let mut notices = terms::term_notices(&self.terms);
        notices.extend(verdicts::screened_notice(table));
        notices.extend(verdicts::fit_notices(scene, &self.dry, &self.series, &self.scaling));
        notices.extend(verdicts::unused_settings_notice(scene, bootstrap));
        notices
    }
}

impl Findings {
    /// Samples the posterior from these least-squares findings, and adds what it says; `None` where the runs are such
    /// that nothing was sampled, which a failed check then says.
    ///
    /// Fails where a prior leaves a parameter no room.
    pub fn add_posterior(
        &mut self,
        scene: &Scene,
        runs: &Runs,
        method: MethodChoice,
        watcher: Watcher,
    ) -> Result<Option<Posterior>, Error> {
        let mut setup = SamplingSetup {
            form: self.form,
            method,
        };
        if scene.model.inertia_is_open() && self.form.inertia != Inertia::None {
            let (chosen, notice) = compare::choose_inertia(self.comparison_context(scene, runs, watcher), setup)?;
            setup = chosen;
            self.notices.extend(notice);
        }
        match posterior::fit_posterior(scene, runs, self.least_squares(), setup, watcher)? {
            Ok(posterior) => {
                // the posterior's own check of k against the dry runs takes the place of least squares'
                let replaced = |check: &Check| posterior.checks.iter().any(|new| new.check == check.check);
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
                    .extend(contraction::contraction_notices(&posterior.findings, directions));
                self.posterior = Some(posterior.findings.clone());
                Ok(Some(posterior))
            }
            Err(PosteriorRefusal(check)) => {
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
        let found = compare::compare_forms(self.comparison_context(scene, runs, watcher), posterior);
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
        let (questions, notices) = questions::answer_questions(context)?;
        self.notices.extend(notices);
        self.questions = Some(questions);
        Ok(found)
    }

    fn comparison_context<'a>(
        &'a self,
        scene: &'a Scene,
        runs: &'a Runs,
        watcher: Watcher<'a>,
    ) -> ComparisonContext<'a> {
        ComparisonContext {
            scene,
            runs,
            least_squares: self.least_squares(),
            watcher,
        }
    }
}
