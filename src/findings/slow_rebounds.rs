//! Fits beside the posterior one whose noise acts on the energy, too, where a run rebounds barely.
//!
//! Where e is small, e² is known to 2 e σ: a run of e = 0.03 fixes the energy kept to 0.001 if all noise is on e, and by that
//! the critical Stokes number. An error of 1 % in its speed or of 3 % in its film moves that energy by several times as much.
//! So the noise that such errors make is allowed for; where it moves a main number by more than one ±, or widens its ± by as
//! much, the wider posterior stands; where the number is known no less well then, neither may be quoted. Where columns tell
//! errors of speeds, that noise is an error of the restitution of these runs. Least squares alone is held against itself
//! without them.

use super::balance::{fit_balance, EnergyBalance};
use super::estimate::Estimate;
use super::fit_columns::speeds_err;
use super::least_squares::LeastSquares;
use super::moved::{Moved, Told};
use super::places::EstimatePlace;
use super::posterior::derived::{derived_draws, main_draws, DerivedDraws};
use super::posterior::{fit_posterior, MethodChoice, Posterior};
use super::remarks::{self, shortened_by};
use super::scaling::Scaling;
use super::single_run::run_words;
use super::wet_fit::FitSetup;
use crate::error::Error;
use crate::inference::prepared_posterior::PreparedPosterior;
use crate::inference::sampling::{sample_about_the_mode, Sampled};
use crate::model::likelihood::Likelihood;
use crate::model::parameters::{ModelParameters, ParameterKind};
use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::rebound::slope_mean_restitution;
use crate::physics::{Form, Quantity};
use crate::remark::{Level, Remark};
use crate::rounding::to_digits;
use crate::runs::Runs;
use crate::scene::{LikelihoodFamily, NoiseOn, Prior, PriorChoice, Scene, SIGMA_ENERGY};

/// A rebound with a smaller restitution is slow.
const SLOW: f64 = 0.15;

/// By which speeds and films are taken to err where no column says otherwise, as shares of them.
const SPEED_ERROR: f64 = 0.01;
const FILM_ERROR: f64 = 0.03;

/// Sd of the logarithm of the spread that these errors make: known within a factor of 2.7.
const LN_SD: f64 = 0.5;

/// Runs up to which the second posterior is sampled wherever it is asked for. Of more, which integrate each for longer, it is
/// sampled where its mode lies further off than [`CLOSE`] of a ±; of more than the most not at all.
const FEW_RUNS: usize = 600;
const MOST_RUNS: usize = 10_000;
const CLOSE: f64 = 0.9;

/// Largest error, in posterior sd, of the second posterior of many runs: the cheapest method that vouches for it will do.
const ACCURACY: f64 = 0.1;

/// A ± below this share of that with noise on e alone is no wider one: allowing for errors has not made the number more careful.
const NARROWER: f64 = 0.9;

/// Samples the second posterior, and holds the first against it: the one that stands, and what is to be said: that the second
/// does, or that something else may be true, since it could not be sampled or the scene takes such runs at their word.
pub(super) fn fit_beside(
    scene: &Scene,
    runs: &Runs,
    least_squares: &LeastSquares,
    own: Posterior,
) -> Result<(Posterior, Option<Remark>), Error> {
    let model = &scene.model;
    let slow = slow_rebounds(runs.sample(), own.setup.form);
    if model.noise == NoiseOn::Both || slow.is_empty() {
        return Ok((own, None));
    }
    let Some(errors) = energy_errors(scene, runs.sample(), &own, &slow) else {
        return Ok((own, None));
    };
    let rows = shortened_by(&slow, |run| run_words(scene, runs.sample(), *run));
    if model.noise == NoiseOn::Restitution {
        let text = format!(
            "{rows}: taken at their word, as noise = \"restitution\" says. An error of 1 % in speed or of 3 % in film moves the \
             energy of such a run by more than its noise"
        );
        let notice = remarks::SLOW_REBOUNDS_ALLOWED.notice(slow.len(), text);
        return Ok((own, Some(notice.at(Level::Informs))));
    }
    if !can_be_asked(runs) {
        let text = format!(
            "{rows}: such runs fix the energy more tightly than errors of 1 % in speed and 3 % in film allow, and a posterior \
             with these errors is not sampled of {} runs",
            runs.all_measured()
        );
        let next = format!(
            "write noise = \"restitution\" in [model] where speeds and films err by much less; else fit a part of the runs, \
             {MOST_RUNS} at most"
        );
        return Ok((own, Some(remarks::SLOW_REBOUNDS.check(None, text).then(next))));
    }
    let takes_minutes = match model.likelihood {
        LikelihoodFamily::Normal => false,
        LikelihoodFamily::Student => runs.all_measured() > FEW_RUNS,
        LikelihoodFamily::AsymmetricLaplace => true,
    };
    if takes_minutes {
        let check = without_slow(scene, runs, least_squares, &own, (&slow, &rows))?;
        return Ok((own, check));
    }
    // with errors of speeds in columns, noise on the energy besides would make each density an integral of integrals: what it
    // does to the restitution is an error of that
    let by_speeds = speeds_err(runs);
    let (mut wider_scene, mut wider_runs) = (scene.clone(), runs.clone());
    let is_set = |choice: &PriorChoice| choice.parameter == SIGMA_ENERGY.name;
    if by_speeds {
        for (run, error) in slow.iter().zip(&errors) {
            let slope = slope_mean_restitution(runs.restitution[*run].powi(2));
            let sd = &mut wider_runs.errors[*run].restitution_sd;
            *sd = sd.hypot(slope * error);
        }
    } else {
        wider_scene.model.noise = NoiseOn::Both;
    }
    if !by_speeds && !scene.priors.iter().any(is_set) {
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let sigma = (squares / errors.len() as f64).sqrt();
        wider_scene.priors.push(PriorChoice {
            parameter: SIGMA_ENERGY.name,
            particle: None,
            prior: Prior::LogNormal(to_digits(sigma, 2), LN_SD),
            line: None,
        });
    }
    let main = main_numbers(&own);
    let mut setup = own.setup;
    if runs.all_measured() > FEW_RUNS {
        let about = about_the_mode(&wider_scene, &wider_runs, &own)?;
        let apart = about.and_then(|about| most_different(&main, &about, shift_or_widening));
        if apart.is_some_and(|(difference, _)| difference < CLOSE) {
            return Ok((own, None));
        }
        setup.method = MethodChoice::Accuracy(ACCURACY);
    }
    let wider = fit_posterior(&wider_scene, &wider_runs, least_squares, setup, &|_, _| ())?;
    let Some(mut wider) = wider.ok().filter(Posterior::sampling_holds) else {
        let text = format!(
            "{rows}: such runs fix the energy more tightly than errors of speeds and films allow, and a posterior with these \
             errors could not be sampled"
        );
        return Ok((own, Some(remarks::SLOW_REBOUNDS.check(None, text))));
    };
    let moved = most_different(&main, &main_numbers(&wider), shift_or_widening);
    let Some((shift, moved)) = moved.filter(|(by, _)| !remarks::SLOW_REBOUNDS.holds(*by)) else {
        return Ok((own, None));
    };
    if moved.after[1] < NARROWER * moved.before[1] {
        let [symbol, before, after] = moved.words();
        let text = format!(
            "{rows}: with errors of 1 % in speed and 3 % in film allowed for, {symbol} is {after} in place of {before}, and not \
             known less well: such runs and the others do not tell the same"
        );
        let next =
            "look at these rows again; a reason in the column exclude leaves one out, with its reason in the report";
        return Ok((own, Some(remarks::SLOW_REBOUNDS.check(Some(shift), text).then(next))));
    }
    let how = if by_speeds {
        "as errors of their restitutions"
    } else {
        "by noise = \"both\""
    };
    let [symbol, before, after] = moved.words();
    let text = format!(
        "{rows}: with noise on e alone such runs fix the energy more tightly than errors of 1 % in speed and 3 % in film \
         allow. With these allowed for, {how}, {symbol} is {after} in place of {before}: the numbers here allow for them"
    );
    let notice = remarks::SLOW_REBOUNDS_ALLOWED.notice(slow.len(), text);
    wider.scene = (!by_speeds).then(|| Box::new(wider_scene));
    // a prior that the runs contradict at their word is no better for reading less from them
    if let Some(before) = own.prior_conflict().filter(|_| wider.prior_conflict().is_none()) {
        wider.checks.retain(|check| check.code != before.code);
        wider.checks.push(before.clone());
        for (now, before) in wider.findings.parameters.iter_mut().zip(&own.findings.parameters) {
            if let (Some(now), Some(before)) = (&mut now.prior, &before.prior) {
                now.runs_alone = before.runs_alone;
            }
        }
    }
    wider.as_given = Some(Box::new(own));
    Ok((wider, Some(notice)))
}

/// Holds the posterior against that of the runs without the slow ones, where integrals over the noise on the energy take
/// minutes: those of two kinds of exponentials, and of many runs with Student's tails.
fn without_slow(
    scene: &Scene,
    runs: &Runs,
    least_squares: &LeastSquares,
    own: &Posterior,
    (slow, rows): (&[usize], &str),
) -> Result<Option<Remark>, Error> {
    let others = runs.with_runs(|run| slow.binary_search(&run).is_err());
    let others = fit_posterior(scene, &others, least_squares, own.setup, &|_, _| ())?;
    let others = others.ok().filter(Posterior::sampling_holds);
    let moved =
        others.and_then(|others| most_different(&main_numbers(own), &main_numbers(&others), Moved::shift_in_smaller));
    Ok(match moved {
        Some((by, _)) if remarks::SLOW_REBOUNDS.holds(by) => None,
        moved => Some(told_without(rows, "", moved)),
    })
}

/// The check of slow runs by the number that leaving them out moves most; `None` where no number can be compared.
fn told_without(rows: &str, by: &str, moved: Option<(f64, Moved)>) -> Remark {
    let found = match &moved {
        Some((_, moved)) => moved.with_and_without("them"),
        None => "what the others tell without them is not known".to_owned(),
    };
    let text = format!(
        "{rows}: such runs fix the energy more tightly than errors of 1 % in speed or 3 % in film allow: {by}{found}"
    );
    remarks::SLOW_REBOUNDS.check(moved.map(|(shift, _)| shift), text)
}

/// Whether least squares, which knows no noise on the energy, gives the same numbers without the runs that barely rebound;
/// `None` where there are none.
pub(super) fn check_fit(setup: FitSetup, scaling: &[Scaling], own: &EnergyBalance) -> Option<Remark> {
    let FitSetup { scene, runs, .. } = setup;
    let measured = runs.sample();
    let slow = slow_rebounds(measured, own.form());
    if slow.is_empty() || scene.model.noise == NoiseOn::Restitution {
        return None;
    }
    let rows = shortened_by(&slow, |run| run_words(scene, measured, *run));
    // few that stand for very many runs are not told apart by what they keep
    let without = can_be_asked(runs).then(|| {
        let others = runs.with_runs(|run| slow.binary_search(&run).is_err());
        let others = FitSetup { runs: &others, ..setup };
        fit_balance(others, scaling, own.form(), false)
    });
    let without = without.flatten().map(|without| fit_numbers(&without));
    let moved = without.and_then(|without| most_different(&fit_numbers(own), &without, Moved::shift_in_smaller));
    let check = told_without(&rows, "by least squares ", moved);
    Some(check.then("sample the posterior (no --stages), which allows for such errors"))
}

/// The number that `by` tells most different in two fits.
fn most_different(before: &[Told], after: &[Told], by: fn(&Moved) -> f64) -> Option<(f64, Moved)> {
    let moved = Moved::between(before, after).map(|moved| (by(&moved), moved));
    moved.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// By how many of the smaller ± a value, or the ± itself, differs.
fn shift_or_widening(moved: &Moved) -> f64 {
    moved
        .shift_in_smaller()
        .max((moved.after[1] - moved.before[1]) / moved.before[1])
}

/// The parameters of a fit of the balance, and e_inf and St_c at each film ratio.
fn fit_numbers(fit: &EnergyBalance) -> Vec<Told> {
    let parameters = fit.parameters.iter().map(|own| (own.name.clone(), &own.estimate));
    let derived = fit.derived.iter().flat_map(|row| {
        let here = EstimatePlace::of_particle(&row.particle, row.diameter_m).at(Some(row.film_ratio));
        let here = here.words(None);
        let named =
            move |(quantity, estimate): (Quantity, _)| (format!("{} ({here})", quantity.describe().symbol), estimate);
        row.estimates.iter().map(named)
    });
    let told = |(name, estimate): (String, &Estimate)| Some((name, estimate.value_and_scale().map(<[f64; 2]>::from)?));
    parameters.chain(derived).filter_map(told).collect()
}

/// The rebounds with a small restitution, where the liquid takes energy.
fn slow_rebounds(runs: &Runs, form: Form) -> Vec<usize> {
    if !Term::Viscous.is_held(form) {
        return vec![];
    }
    let rebounds = runs.series.iter().flat_map(|series| series.rebounds.clone());
    rebounds.filter(|run| runs.restitution[*run] < SLOW).collect()
}

/// Whether runs are few enough to ask what the slow ones move.
fn can_be_asked(runs: &Runs) -> bool {
    runs.all_measured() <= MOST_RUNS && runs.count.is_empty()
}

/// The sd of the energy kept that errors of speed and film make of these runs where no column tells them; `None` where that is
/// nothing.
fn energy_errors(scene: &Scene, runs: &Runs, own: &Posterior, slow: &[usize]) -> Option<Vec<f64>> {
    let mean = |kind: ParameterKind| {
        let name = kind.name(scene, runs);
        let found = own.findings.parameters.iter().find(|one| one.name == name)?;
        found.mean
    };
    // where L is held, or its form has another parameter in its place, by that of a usual sphere
    let l = mean(ParameterKind::LUBRICATION_LOG).filter(|_| scene.model.viscous.why_no_critical_separation().is_none());
    let of_run = |run: &usize| {
        let mut series = runs.series.iter();
        let sphere = series.find(|series| series.runs().contains(run))?.sphere;
        let k = mean(ParameterKind::DryK(sphere)).unwrap_or(0.15);
        let e_dry = 1.0 - k * REFERENCE_SPEED.powf(0.2);
        let kept = runs.restitution[*run].powi(2);
        let lost = (e_dry * e_dry - kept).max(0.0);
        let viscous = l.map_or(lost, |l| (4.0 * l * runs.inverse_stokes(*run)).min(lost));
        // an error of the speed that a column tells is in the density already
        let is_told = runs.errors.get(*run).is_some_and(|error| error.impact_speed_sd > 0.0);
        let of_speed = if is_told { 0.0 } else { SPEED_ERROR * viscous };
        Some(of_speed.hypot(FILM_ERROR * (lost - viscous)))
    };
    let all: Vec<f64> = slow.iter().map(of_run).collect::<Option<_>>()?;
    all.iter().any(|error| *error > 0.0).then_some(all)
}

/// Mean and sd of the draws of each main number.
fn main_numbers(of: &Posterior) -> Vec<Told> {
    numbers(&of.sampled, &of.derived, |draws| draws - 1.0)
}

/// Value and ± of each main number by the normal about the mode, which lies near those of another posterior; `None` where
/// there is none.
fn about_the_mode(scene: &Scene, runs: &Runs, own: &Posterior) -> Result<Option<Vec<Told>>, Error> {
    let form = own.setup.form;
    let likelihood = Likelihood::new(scene, runs, form);
    let parameters = ModelParameters::of(scene, runs, form)?;
    let found = own.sampled.parameters.sampled.iter().zip(&own.findings.parameters);
    let start = found.filter_map(|(own, found)| Some((own.kind, found.mean?))).collect();
    let prepared = PreparedPosterior::near(parameters, &likelihood, &start).ok();
    Ok(prepared.filter(|prepared| prepared.about.is_at_peak()).map(|prepared| {
        let pairs = sample_about_the_mode(&prepared);
        let derived = derived_draws(scene, runs, form, &pairs);
        // one ± to either side in each direction of the normal
        numbers(&pairs, &derived, |_| 2.0)
    }))
}

/// Mean and ± of the physical parameters, e_inf and St_c: of so many draws, their squares about the mean are over `freedom`.
fn numbers(sampled: &Sampled, derived: &[DerivedDraws], freedom: impl Fn(f64) -> f64) -> Vec<Told> {
    let told = |values: &[f64]| {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        [mean, (squares / freedom(n)).sqrt()]
    };
    let all = main_draws(sampled, derived).map(|(name, chains)| (name.clone(), told(&chains.concat())));
    // a number that some draws do not have is not told
    let is_whole = |(_, number): &Told| number.iter().all(|one| one.is_finite());
    all.filter(is_whole).collect()
}
