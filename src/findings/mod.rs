//! Says what may be said: estimates with their verdicts, as numbers and fixed words, no prose of a report.
//!
//! A file uses only what stands above it in this table; this one, which calls them in turn, stands last.
//!
//! | file | job |
//! |---|---|
//! | `estimate.rs` | a number with its standard error, its interval, or why there is none |
//! | `fit_verdict.rs` | whether a fit may be quoted |
//! | `form_choice.rs` | when a form of the law stands in for the default one |
//! | `quantities.rs` | estimates of quantities from a fit, by the delta method |
//! | `range.rs` | the smallest and the largest of some numbers |
//! | `places.rs` | what an estimate is of; where an energy balance is told: film ratios of particles, and diameters where the form tells them apart |
//! | `fit_columns.rs` | the runs of a fit in columns, with each run's own dry speed and its measurement errors |
//! | `remarks.rs` | every remark: code, level, line with its source, next step; and in which order they are told |
//! | `film_groups.rs` | film groups with their width, why some have no film ratio of their own, and which stands for the others |
//! | `dry.rs` | k of each particle, and whether one k serves all diameters |
//! | `wet_fit.rs` | what laws of the wet runs are fitted to, and a law fitted to the rebounds of some series |
//! | `which_law.rs` | the linear law against the square root, by all runs together |
//! | `series.rs` | the square-root law of each series |
//! | `scaling.rs` | e_inf and St_c by both laws, with the linear law's bias on this design, and where the energy went |
//! | `published.rs` | ours beside the literature's |
//! | `balance.rs` | L, inertial prefactor and film scale from every rebound at once, and what pooling liquids does to the law of one film |
//! | `terms.rs` | what each term of the balance matters, and whether it is held |
//! | `noise/` | outliers, unequal spreads, offsets that series share |
//! | `bootstrap/` | the bootstrap interval of each estimate |
//! | `verdicts.rs` | what must hold before the numbers are quoted, and what wants a second look |
//! | `constants/` | how results move with the constants taken as exact |
//! | `least_squares.rs` | what least squares found, for the stages that start from it |
//! | `identify/` | which parameters the runs identify |
//! | `predict.rs` | restitution at any speed from the posterior's draws |
//! | `posterior/` | parameters from all runs at once, with priors |
//! | `estimates.rs` | every estimate in a row of one table |
//! | `main_numbers.rs` | which estimates are the main numbers, each from the source that serves it |
//! | `exact_constants.rs` | which constant without an uncertainty would widen the main numbers most |
//! | `left_out.rs` | draws from a model, each run predicted from the others |
//! | `moved.rs` | a number in two fits |
//! | `single_run.rs` | the runs without which a main number moves |
//! | `slow_rebounds.rs` | whether barely rebounding runs may be taken at their word |
//! | `compare.rs` | which form of the law predicts best |
//! | `questions.rs` | whether L and C are the same at every film ratio |
//! | `document.rs` | everything a fit says, as `findings.json` writes it |
//! | `learnt.rs` | what was learnt, in sentences |
//! | `laws.rs` | the law e(v) of every pair, in numbers |
//! | `repeats.rs`, `repeats/` | rows that repeat others, and means of others |
//! | `columns_agree.rs` | columns that tell the same thing and contradict each other |
//! | `plausible.rs` | constants, runs and results that no such experiment has |
//! | `overview.rs` | what was read, for `check` |

pub mod balance;
pub mod bootstrap;
mod columns_agree;
pub mod compare;
pub mod constants;
mod document;
pub mod dry;
pub mod estimate;
pub mod estimates;
mod exact_constants;
pub mod film_groups;
mod fit_columns;
mod fit_verdict;
pub mod form_choice;
pub mod identify;
pub mod laws;
pub mod learnt;
pub mod least_squares;
pub mod left_out;
pub mod main_numbers;
mod moved;
pub mod noise;
pub mod overview;
pub mod places;
mod plausible;
pub mod posterior;
pub mod predict;
pub mod published;
mod quantities;
pub mod questions;
pub(crate) mod range;
pub mod remarks;
mod repeats;
pub mod scaling;
pub mod series;
mod single_run;
mod slow_rebounds;
pub mod terms;
pub mod verdicts;
mod wet_fit;
mod which_law;

use crate::error::Error;
use crate::inference::nuts::Watcher;
use crate::model::parameters::ModelParameters;
use crate::physics::form::Term;
use crate::physics::inertia::{Inertia, PREFACTOR};
use crate::remark::{Level, Remark};
use crate::runs::{FilmGroup, Runs, Table};
use crate::scene::{NoiseOn, Scene, Sticking};
use estimates::EstimateSources;
use form_choice::OtherForm;
use least_squares::LeastSquares;
use left_out::ComparisonContext;
use main_numbers::MainNumbers;
use posterior::{contraction, ExpectedSampling, MethodChoice, Posterior, SamplingSetup};
use remarks::Kind;
use scaling::Scaling;
use terms::SizedTerm;
use which_law::LineAgainstRoot;

pub use document::{Counts, Findings, SCHEMA};
pub use fit_verdict::Verdict;
pub use wet_fit::FitSetup;

/// Fits everything least squares can say of a scene's runs; with `bootstrap`, resamples them as the scene says.
pub fn fit_least_squares(scene: &Scene, table: &Table, seed: u64, bootstrap: bool) -> Findings {
    fit_least_squares_watched(scene, table, seed, bootstrap.then_some(&|_| ()))
}

/// The same, with bootstrap intervals where somebody watches their replicates: `watcher` is called with 0 before the first,
/// then with the number of replicates finished.
pub fn fit_least_squares_watched(
    scene: &Scene,
    table: &Table,
    seed: u64,
    watcher: Option<&(dyn Fn(usize) + Sync)>,
) -> Findings {
    let runs = &table.runs;
    let (mut fits, line) = fit_laws(scene, runs, seed);
    let (of_sample, balance) = (fits.setup(scene, runs.sample()), fits.energy_balance.as_ref());
    let few = runs.sample().condensed(scene.data.smallest_restitution);
    let of_few = fits.setup(scene, few.as_ref().unwrap_or(runs.sample()));
    let (constants, noise) = rayon::join(
        || constants::find_sensitivities(of_few, &fits.scaling, balance),
        || noise::analyse_noise(of_sample, balance, fits.form),
    );
    let resampled = watcher.map(|done| {
        done(0);
        let estimates = bootstrap::Estimates {
            dry: &mut fits.dry,
            series: &mut fits.series,
            scaling: &mut fits.scaling,
        };
        let options = bootstrap::Options {
            seed,
            keep_all: false,
            most_resampled: bootstrap::MOST_RESAMPLED,
        };
        bootstrap::add_bootstrap_intervals(scene, runs, estimates, options, done)
    });
    let (resampling, fewer_replicates) = resampled.unzip();
    let mut findings = Findings {
        schema: SCHEMA,
        scene: scene.name.clone(),
        title: scene.title.clone(),
        wetcor: env!("CARGO_PKG_VERSION"),
        seed,
        data_sha256: table.sha256.clone(),
        scene_sha256: scene.sha256.clone(),
        counts: Counts::of(table),
        main: MainNumbers::default(),
        inertia: fits.energy_balance.as_ref().and_then(|balance| balance.choice.clone()),
        sampled_forms: vec![],
        published: published::compare_with_published(fits.setup(scene, runs), &fits.scaling),
        identifies: identify::identify_directions(scene, runs, &fits),
        fits,
        constants,
        noise,
        bootstrap: resampling,
        posterior: None,
        compare: None,
        questions: None,
        remarks: vec![],
        estimates: vec![],
    };
    let (balance, line) = (findings.energy_balance.as_ref(), line.as_ref());
    let setup = findings.setup(scene, runs);
    // a wrong unit explains what else fails
    let mut remarks = plausible::check_input(scene, runs);
    remarks.extend(columns_agree::check_columns(&table.compared, &runs.places));
    let of_dry = findings.dry.iter().filter_map(|own| own.residual_sd);
    let spreads = of_dry.chain(balance.and_then(|own| own.residual_sd));
    remarks.extend(repeats::check_rows(runs, spreads.reduce(f64::min)));
    remarks.extend(verdicts::check_least_squares(
        setup,
        table,
        &findings.scaling,
        balance,
        line,
    ));
    if let Some(noise) = &findings.noise {
        remarks.extend(verdicts::wet_law_holds(noise, line));
        remarks.extend(verdicts::independent_runs(scene, noise));
    }
    remarks.extend(balance.and_then(|own| slow_rebounds::check_fit(setup, &findings.scaling, own)));
    let own_films_stand = balance.is_some_and(|balance| balance.verdict.passed);
    remarks.extend(film_groups::check(&findings.film_groups, own_films_stand));
    remarks.extend(table.notices.iter().cloned());
    remarks.extend(findings.terms.iter().filter_map(terms::term_notice));
    remarks.extend(verdicts::fit_notices(setup, table, &findings.series, &findings.scaling));
    let viscous = findings.form.viscous;
    remarks.extend(viscous.caution().map(|caution| {
        let text = format!("viscous loss \"{}\": {caution}", viscous.name());
        remarks::VISCOUS_FORM.notice(runs.wet_measured(), text)
    }));
    remarks.extend(fewer_replicates.flatten());
    remarks.extend(noise::noise_notices(scene, findings.noise.as_ref()));
    remarks.extend(findings.chosen_form());
    remarks.extend(identify::unidentified_notice(findings.identifies.as_ref()));
    remarks.extend(plausible::check_results(scene, runs, &findings));
    remarks.extend(columns_agree::rows_apart(&table.compared, &runs.places));
    findings.remarks = remarks;
    findings.pick_main_numbers(scene, runs, None);
    findings
}

/// Every fit by least squares, with how the linear law stands to the square root.
fn fit_laws(scene: &Scene, runs: &Runs, seed: u64) -> (LeastSquares, Option<LineAgainstRoot>) {
    let film_groups = film_groups::list_film_groups(scene, runs);
    let dry = dry::fit_dry_laws(scene, runs);
    // with the form open, models are compared run by run; a law of one film ratio that is fitted over films of all kinds
    // may have the edge of its square root anywhere among the runs
    let needs_each = scene.model.inertia_is_open() || !runs.film_groups.iter().all(FilmGroup::has_one_film_ratio);
    let few = || runs.condensed(scene.data.smallest_restitution);
    let condensed = (!needs_each).then(few).flatten();
    let runs = condensed.as_ref().unwrap_or(runs);
    let setup = FitSetup { scene, runs, dry: &dry };
    let (series, mut scaling) = rayon::join(|| series::fit_series(setup), || scaling::fit_scaling(setup));
    let (form, energy_balance, terms) = terms::choose_terms(setup, &scaling);
    if let Some(balance) = &energy_balance {
        balance::add_bias_of_pooling(setup, &mut scaling, balance);
    }
    let line = LineAgainstRoot::over_all(setup);
    if let Some(line) = line.filter(LineAgainstRoot::favours_line) {
        scaling::quote_lines(&mut scaling, line.line_holds());
    }
    let fits = LeastSquares {
        seed,
        dry,
        film_groups,
        series,
        scaling,
        energy_balance,
        terms,
        form,
    };
    (fits, line)
}

/// Whether other models are drawn beside the scene's own, to be compared.
pub fn is_compared(scene: &Scene, runs: &Runs) -> bool {
    let effort = posterior::effort(scene);
    left_out::why_none_beside(scene, runs, effort.chains * effort.draws).is_none()
}

impl Findings {
    /// About how long [`Findings::add_posterior`] will sample.
    pub fn expected_sampling(&self, scene: &Scene, runs: &Runs, method: MethodChoice) -> Option<ExpectedSampling> {
        let setup = SamplingSetup {
            form: self.form,
            method,
        };
        posterior::expected_sampling(scene, runs, &self.fits, setup)
    }

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
        let default = ModelParameters::of(scene, runs, setup.form)?;
        let may_be_sampled = posterior::why_not_sampled(runs, &self.fits, &default).is_none();
        if scene.model.inertia_is_open() && self.form.inertia != Inertia::None && may_be_sampled {
            // refused before the forms are sampled, not after
            let quantities = default.dimension() + posterior::derived::count_derived(scene, runs, setup.form);
            posterior::check_room(posterior::effort(scene), quantities)?;
            let context = self.comparison_context(scene, runs, watcher);
            let (chosen, choice, evaluated) = compare::choose_inertia(context, setup)?;
            (setup, self.sampled_forms) = (chosen, evaluated);
            self.inertia = choice.or(self.inertia.take());
            self.say_anew(&[remarks::FORM_CHOSEN], self.chosen_form());
        }
        let posterior = match posterior::fit_posterior(scene, runs, &self.fits, setup, watcher)? {
            Ok(posterior) => posterior,
            Err(check) => {
                self.remarks.push(*check);
                self.pick_main_numbers(scene, runs, None);
                return Ok(None);
            }
        };
        let (posterior, told) = slow_rebounds::fit_beside(scene, runs, &self.fits, posterior)?;
        // what least squares made of barely rebounding runs no longer matters
        self.say_anew(&[remarks::SLOW_REBOUNDS], told);
        let scene = posterior.scene.as_deref().unwrap_or(scene);
        let context = self.comparison_context(scene, runs, watcher);
        let mut carried = single_run::find_single_runs(context, &posterior);
        // the posterior's own check of k against the dry runs takes the place of least squares'
        let replaced = |check: &Remark| posterior.checks.iter().any(|new| new.code == check.code);
        self.remarks.retain(|check| !replaced(check));
        self.spare_by_posterior(scene, &posterior);
        self.remarks.extend(posterior.checks.iter().cloned());
        // a prior that the runs contradict explains what else fails
        self.remarks
            .sort_by_key(|check| !remarks::PRIOR_CONFLICT.is(check) || check.passed);
        self.settle_notices(scene, &posterior);
        self.posterior = Some(posterior.findings.clone());
        self.say_anew(
            &[remarks::PLAUSIBLE_RESULT],
            plausible::check_results(scene, runs, self),
        );
        self.pick_main_numbers(scene, runs, Some(&posterior));
        carried.extend(single_run::carried_laws(
            self.setup(scene, runs),
            &self.main,
            &self.scaling,
        ));
        self.remarks.extend(single_run::unseen_rebounds(scene, runs, &carried));
        remarks::order_advice(&mut self.remarks);
        let outliers = self.noise.as_ref().map_or(&[][..], |noise| &noise.outliers);
        let outlying = single_run::carrying_outlier(runs, &carried, outliers);
        self.remarks.extend(outlying);
        self.remarks.extend(single_run::single_run_notice(scene, runs, carried));
        self.main.verdict = main_numbers::judge(&self.remarks);
        self.main.learnt = learnt::what_was_learnt(scene, runs, self);
        Ok(Some(posterior))
    }

    /// Takes back what failed checks of least squares forbid where the posterior does not rest on it.
    fn spare_by_posterior(&mut self, scene: &Scene, posterior: &Posterior) {
        let other_form = self.energy_balance.as_ref().map(|own| own.inertia) != Some(posterior.findings.inertia);
        let offsets = scene.model.series_offsets;
        // what barely rebounding runs are allowed is too little to excuse a misfit
        let other_noise = scene.model.noise == NoiseOn::Both && posterior.as_given.is_none() || offsets;
        // no law of a film ratio is quoted beside the posterior then
        let balance = self.energy_balance.as_ref();
        let few = balance.is_some_and(|balance| balance.verdict.passed)
            && self.scaling.iter().all(|law| !law.tells_its_spread());
        // an offset of its only series spoils no law
        let of_offsets = offsets && !self.scaling.iter().any(Scaling::fails_by_itself);
        for remark in &mut self.remarks {
            // least squares does not know this noise, or holds a form that predicts worse: the posterior is quoted
            let of_balance = remarks::ENERGY_BALANCE.is(remark) || remarks::WET_ERRORS.is(remark);
            let is_law = remarks::SCALING_LAW.is(remark);
            let spared = of_balance && (other_noise || other_form);
            // nor does the posterior need film groups
            if spared || is_law && (of_offsets || few) || remarks::FILM_GROUPS.is(remark) {
                *remark = remark.clone().forbidding_if(false);
            }
            if spared && !remark.passed {
                let why = if other_form {
                    "holds another form of inertia"
                } else {
                    "does not know the noise of the posterior"
                };
                remark.text = format!("{} by least squares, which {why}", remark.text);
            }
            // a film ratio without a law has its numbers from the posterior
            if !remark.passed && (spared || is_law && !remark.gates()) {
                *remark = remark.clone().at(Level::Informs);
            }
        }
    }

    /// Settles what was said of least squares, now that the posterior is sampled.
    fn settle_notices(&mut self, scene: &Scene, posterior: &Posterior) {
        // what the runs seem not to tell follows from a prior that they contradict
        if posterior.prior_conflict().is_some() {
            self.say_anew(&[remarks::UNSEEN], None);
        }
        let directions = self.identifies.as_ref();
        self.remarks
            .extend(contraction::contraction_notice(&posterior.findings, directions));
        if scene.model.sticking == Sticking::Censored {
            settle_stuck_runs(&mut self.remarks);
        }
        // noise on the energy kept grows so as the restitution falls
        if scene.model.noise == NoiseOn::Both {
            self.say_anew(&[remarks::NOISE_GROWS], None);
        }
        // the posterior holds an inertial loss, whatever least squares made of it
        if posterior.findings.inertia != Inertia::None {
            for sized in self.fits.terms.iter_mut().filter(|sized| sized.term == Term::Inertia) {
                sized.held = true;
            }
            self.remarks.retain(|notice| !says_not_held(notice, Term::Inertia));
        }
    }

    /// Says these in place of what was said of such before.
    fn say_anew(&mut self, kinds: &[Kind], remarks: impl IntoIterator<Item = Remark>) {
        self.remarks.retain(|before| !kinds.iter().any(|kind| kind.is(before)));
        self.remarks.extend(remarks);
    }

    /// Which form of inertia the runs chose; `None` where the scene names it.
    fn chosen_form(&self) -> Option<Remark> {
        let choice = self.inertia.as_ref()?;
        let name = choice.inertia.name();
        let text = format!("inertia = \"auto\" took {name}: the intervals ignore that the same runs chose it");
        Some(remarks::FORM_CHOSEN.notice(1, text).cautioning_if(!choice.is_clear()))
    }

    /// Names the form without inertia where it is C that its prior keeps too large.
    fn advise_no_inertia(&mut self) {
        let is_better = |other: &OtherForm| other.inertia == Inertia::None && other.difference > 0.0;
        if !self.inertia.iter().flat_map(|choice| &choice.others).any(is_better) {
            return;
        }
        let of_c = format!("{}: the runs alone", remarks::in_symbols(PREFACTOR.name));
        let contradicts = |check: &Remark| remarks::PRIOR_CONFLICT.is(check) && check.forbids();
        let is_of_c = |check: &&mut Remark| contradicts(check) && check.text.contains(&of_c);
        for check in self.remarks.iter_mut().filter(is_of_c) {
            check.next_step =
                "write inertia = \"none\" in [model], which predicts these runs better; else widen or drop the prior"
                    .to_owned();
        }
    }

    /// Lists the estimates and picks the main numbers among them anew, from what was found by now.
    fn pick_main_numbers(&mut self, scene: &Scene, runs: &Runs, posterior: Option<&Posterior>) {
        let sources = EstimateSources {
            scene,
            runs,
            least_squares: &self.fits,
            posterior,
        };
        let mut rows = sources.rows();
        self.main = main_numbers::pick_main_numbers(sources, &mut rows);
        self.estimates = rows;
        self.say_anew(&[remarks::BOOTSTRAP_FAILURES], self.main.check_replicates());
        self.settle_terms();
        remarks::order_advice(&mut self.remarks);
        self.advise_no_inertia();
        self.main.verdict = main_numbers::judge(&self.remarks);
        self.main.learnt = learnt::what_was_learnt(scene, runs, self);
        let of_main = [
            remarks::SPEED_ERROR_MATTERS,
            remarks::MEASUREMENT_ERRORS_TOO_LARGE,
            remarks::CONSTANTS_EXACT,
        ];
        let is_main = |law: &Scaling| self.main.rows().any(|row| row.is_of_law(law));
        let mut found = verdicts::measurement_error_notices(runs, &self.scaling, is_main);
        let exact = exact_constants::exact_constants_notice(scene, runs.sample(), &self.constants, &self.main);
        found.extend(exact);
        self.say_anew(&of_main, found);
    }

    /// Lets a term that is not held, and that the runs have not rejected, caution only where leaving it out would move a main
    /// number by more than a quarter of its ±, and forbid quoting where they show it only above half, and no run that barely
    /// rebounds may feign it.
    fn settle_terms(&mut self) {
        let shift = |sized: &SizedTerm| {
            let name = sized.moves.as_ref()?;
            let number = &self.main.parameters.iter().find(|own| own.name() == *name)?.number;
            let mut fitted = self.energy_balance.iter().flat_map(|balance| &balance.parameters);
            let fitted = fitted.find(|own| own.name == *name)?;
            let (_, scale) = fitted.estimate.value_and_scale()?;
            Some(sized.size? * scale / number.se?)
        };
        // least squares takes a run that barely rebounds at its word, and so does what it says of a term
        let is_of_slow = |remark: &Remark| remarks::SLOW_REBOUNDS.is(remark) && !remark.passed && !remark.informs();
        let takes_slow = self.remarks.iter().any(is_of_slow);
        // forms compare the dry speeds
        let is_open = |own: &&SizedTerm| own.term != Term::OwnDrySpeed && !own.held && !own.is_rejected();
        let open = self.fits.terms.iter().filter(is_open);
        let shifts: Vec<(Term, Option<f64>)> = open.map(|own| (own.term, shift(own))).collect();
        for (term, shift) in shifts {
            let beyond = |line: f64| shift.is_some_and(|shift| shift > line);
            for remark in self.remarks.iter_mut().filter(|remark| says_not_held(remark, term)) {
                if takes_slow && remarks::TERM_ACTS.is(remark) {
                    let told = remarks::TERM_NOT_HELD.notice(1, std::mem::take(&mut remark.text));
                    *remark = told.then(std::mem::take(&mut remark.next_step));
                }
                remark.level = if beyond(remarks::FELT) && remarks::TERM_ACTS.is(remark) {
                    Level::Forbids
                } else if beyond(remarks::BIAS) {
                    Level::Cautions
                } else {
                    Level::Informs
                };
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
    ) -> Result<(), Error> {
        // forms are compared under the noise that was given: under one on the energy, too, each run is an integral
        let own = posterior.as_given.as_deref().unwrap_or(posterior);
        let context = self.comparison_context(scene, runs, watcher);
        let (models, found) = compare::compare_forms(context, own, &self.sampled_forms);
        self.remarks.extend(found);
        compare::settle_dry_speed(&mut self.remarks, &models);
        self.compare = (!models.is_empty()).then_some(models);
        let comparison = self.comparison_context(scene, runs, watcher);
        let (questions, checks) = questions::answer_questions(comparison, own)?;
        self.remarks.extend(checks);
        self.questions = Some(questions);
        self.pick_main_numbers(posterior.scene.as_deref().unwrap_or(scene), runs, Some(posterior));
        join_terms(&mut self.remarks);
        Ok(())
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
            least_squares: &self.fits,
            watcher,
        }
    }
}

/// Whether a remark says that a term is not in the model.
fn says_not_held(remark: &Remark, term: Term) -> bool {
    let kinds = [remarks::TERM_NOT_HELD, remarks::TERM_ACTS];
    kinds.iter().any(|kind| kind.is(remark)) && remark.text.starts_with(term.in_words())
}

/// Says in one caution which terms the model does not hold, once nothing more is to be settled of any.
fn join_terms(remarks: &mut Vec<Remark>) {
    let is_open = |remark: &Remark| remarks::TERM_NOT_HELD.is(remark) && remark.cautions();
    let Some(first) = remarks.iter().position(is_open) else {
        return;
    };
    while let Some(further) = remarks[first + 1..].iter().position(is_open) {
        let other = remarks.remove(first + 1 + further);
        let own = &mut remarks[first];
        own.value = Some(own.count() as f64 + 1.0);
        own.text += &format!(". {}", learnt::capital(&other.text));
        own.next_step += &format!(". {}", learnt::capital(&other.next_step));
    }
}

/// Settles what was said of stuck runs where the posterior counts them.
fn settle_stuck_runs(notices: &mut [Remark]) {
    for notice in notices.iter_mut().filter(|notice| remarks::STUCK_LEFT_OUT.is(notice)) {
        *notice = notice.clone().at(Level::Informs);
        notice.next_step =
            "nothing: the main numbers of their film ratios come from the posterior, which counts them".to_owned();
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::runs::Screened;
    use crate::scene::WetLaw;
    use crate::{runs, scene};

    /// A scene of the project with its runs.
    pub(super) fn read_example(path: &str) -> (Scene, Table) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        let scene = scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let table = runs::read(&scene).unwrap_or_else(|error| panic!("{error}"));
        (scene, table)
    }

    pub(super) fn read_plain() -> (Scene, Table) {
        read_example("tests/data/good/plain/scene.toml")
    }

    /// What is found of it, of which one run stuck, with these runs left out.
    fn fit_plain(screened: Vec<Screened>) -> Findings {
        let (scene, mut table) = read_plain();
        table.screened = screened;
        fit_least_squares(&scene, &table, 1, false)
    }

    fn of<'n>(notices: &'n [Remark], code: &str) -> &'n Remark {
        notices.iter().find(|notice| notice.code == code).expect("it is said")
    }

    #[test]
    fn stuck_runs_caution_only_where_no_posterior_counts_them() {
        let mut notices = fit_plain(vec![]).remarks;
        let before = of(&notices, "stuck_left_out");
        assert!(before.cautions() && before.text.starts_with("1 of 25 wet runs stuck"));
        settle_stuck_runs(&mut notices);
        let counted = of(&notices, "stuck_left_out");
        assert!(!counted.cautions() && !counted.next_step.contains("quote the square-root law"));
    }

    #[test]
    fn advice_on_screened_runs_goes_by_their_reasons() {
        let screened_for = |reasons: &[&'static str]| {
            let all = reasons.iter().copied().map(|next_step| Screened {
                reason: "some reason".to_owned(),
                runs: 2,
                next_step,
            });
            of(&fit_plain(all.collect()).remarks, "screened").next_step.clone()
        };
        assert_eq!(screened_for(&["widen"]), "widen");
        assert_eq!(
            screened_for(&["widen", "widen", "clear the word"]),
            "widen; clear the word"
        );
    }

    #[test]
    fn the_second_order_cautions_only_where_it_moves_a_main_number() {
        let mut findings = fit_plain(vec![]);
        let text = format!("{}: not in the model", Term::DrySecondOrder.in_words());
        findings.remarks = vec![remarks::TERM_NOT_HELD.notice(1, text)];
        let name = findings.main.parameters[0].name();
        let mut balance = findings.energy_balance.iter().flat_map(|balance| &balance.parameters);
        let fitted = balance.find(|own| own.name == name).expect("k is fitted");
        let (_, se) = fitted.estimate.value_and_scale().expect("k has a standard error");
        let mut cautions = |size: f64, se: f64| {
            findings.remarks[0].level = Level::Cautions;
            findings.main.parameters[0].number.se = Some(se);
            let terms = findings.fits.terms.iter_mut();
            for sized in terms.filter(|sized| sized.term == Term::DrySecondOrder) {
                (sized.held, sized.size, sized.moves) = (false, Some(size), Some(name.clone()));
                (sized.runs_show, sized.runs_show_se) = (None, None);
            }
            findings.settle_terms();
            findings.remarks[0].cautions()
        };
        assert!(cautions(3.0, se) && !cautions(3.0, 20.0 * se) && !cautions(0.2, se));
    }

    #[test]
    fn terms_that_caution_are_told_in_one_and_others_by_themselves() {
        let told = |text: &str| remarks::TERM_NOT_HELD.notice(1, text.to_owned()).then("hold it");
        let apart = remarks::UNSEEN.notice(1, "one film ratio".to_owned());
        let rejected = told("inertia").at(Level::Informs);
        let mut all = vec![
            told("a bridge"),
            rejected.clone(),
            apart.clone(),
            told("the second order"),
        ];
        join_terms(&mut all);
        assert_eq!((all.len(), &all[1], &all[2]), (3, &rejected, &apart));
        assert_eq!(
            (all[0].count(), all[0].text.as_str()),
            (2, "a bridge. The second order")
        );
    }

    #[test]
    fn an_error_of_speeds_cautions_only_of_a_law_with_main_numbers() {
        let (_, Table { runs, .. }) = read_plain();
        let mut scaling = fit_plain(vec![]).fits.scaling;
        scaling.retain(|row| row.law == WetLaw::Sqrt && row.film_ratio.is_some());
        for row in &mut scaling {
            row.fitted.verdict = Verdict::passed("");
            row.fitted.speed_error_of_a_tenth_se = Some(0.001);
        }
        let level = |is_main: bool| {
            let found = verdicts::measurement_error_notices(&runs, &scaling, |_| is_main);
            of(&found, "speed_error_matters").level
        };
        assert_eq!([level(true), level(false)], [Level::Cautions, Level::Informs]);
    }

    #[test]
    fn a_trend_beside_series_that_lie_apart_is_told_with_the_offsets_first() {
        let mut findings = fit_plain(vec![]);
        let trend = || remarks::FILM_TREND.check(9.0, "L rises with the film");
        findings.remarks = vec![trend()];
        remarks::order_advice(&mut findings.remarks);
        assert_eq!(findings.remarks, [trend()]);
        findings
            .remarks
            .push(remarks::INDEPENDENT_RUNS.check(3.0, "series lie apart"));
        remarks::order_advice(&mut findings.remarks);
        assert!(findings.remarks.iter().all(Remark::forbids));
        let first = &findings.remarks[0].next_step;
        assert!(first.starts_with("set [model] series_offsets = true first"), "{first}");
        // what makes both is seen to before either
        findings.remarks.push(remarks::LINEAR_LAW.check(9.0, "a line"));
        remarks::order_advice(&mut findings.remarks);
        assert_eq!(
            [0, 1].map(|n| findings.remarks[n].next_step.as_str()),
            [remarks::LAW_FIRST; 2]
        );
    }
}
