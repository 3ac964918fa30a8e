//! Fits beside the posterior one whose noise acts on the energy, too, where a run rebounds barely.
//!
//! Where e is small, e² is known to 2 e σ: a run of e = 0.03 fixes the energy kept to 0.001 if all noise is on e, and by that
//! the critical Stokes number. An error of 1 % in its speed or of 3 % in its film moves that energy by several times as much.
//! So the noise that such errors make is allowed for; where it moves a main number by more than one ±, the wider posterior
//! stands. Where columns tell errors of speeds, that noise is an error of the restitution of these runs. Least squares alone
//! is held against itself without them.

use super::balance::{fit_balance, BalanceSetup, EnergyBalance};
use super::estimate::Estimate;
use super::least_squares::LeastSquares;
use super::posterior::{fit_posterior, Posterior};
use super::remarks::{self, shortened};
use super::scaling::FittedScaling;
use super::single_run::run_words;
use crate::error::Error;
use crate::model::parameters::ParameterKind;
use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::rebound::slope_mean_restitution;
use crate::physics::{Form, Quantity};
use crate::remark::Remark;
use crate::rounding::{short, to_digits, with_se};
use crate::runs::Runs;
use crate::scene::{NoiseOn, Prior, PriorChoice, Scene, Sticking, SIGMA_ENERGY};

/// A rebound with a smaller restitution is slow.
const SLOW: f64 = 0.15;

/// By which speeds and films are taken to err where no column says otherwise, as shares of them.
const SPEED_ERROR: f64 = 0.01;
const FILM_ERROR: f64 = 0.03;

/// Sd of the logarithm of the spread that these errors make: known within a factor of 2.7.
const LN_SD: f64 = 0.5;

/// Where the prior of that spread comes from.
const SOURCE: &str = "errors of 1 % in speed and 3 % in film of the runs that barely rebound";

/// Runs up to which slow ones are asked about: the second posterior integrates every run, and takes minutes of more.
const MOST_RUNS: usize = 600;

/// What the second posterior says.
pub(super) enum Beside {
    /// no run asks for it, or it says the same
    Same,
    /// it says something else: it stands, and the notice says so
    Stands(Box<Posterior>, Remark),
    /// something else may be true, and it could not be sampled
    Open(Remark),
}

/// Samples the second posterior, and holds the first against it.
pub(super) fn fit_beside(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    own: &Posterior,
) -> Result<Beside, Error> {
    let model = &scene.model;
    let is_asked = model.noise == NoiseOn::Restitution && model.sticking != Sticking::Truncated;
    let slow = slow_rebounds(runs, own.setup.form);
    if !is_asked || slow.is_empty() {
        return Ok(Beside::Same);
    }
    let Some(errors) = energy_errors(scene, runs, own, &slow) else {
        return Ok(Beside::Same);
    };
    let rows: Vec<String> = slow.iter().map(|run| run_words(scene, runs, *run)).collect();
    // with errors of speeds in columns, noise on the energy besides would make each density an integral of integrals: what it
    // does to the restitution is an error of that
    let by_speeds = runs.errors.as_ref().is_some_and(|errors| errors.counts()[1] > 0);
    let (mut wider_scene, mut wider_runs) = (scene.clone(), runs.clone());
    let is_set = |choice: &PriorChoice| choice.parameter == SIGMA_ENERGY.name;
    let is_ours = !by_speeds && !scene.priors.iter().any(is_set);
    if let Some(sds) = wider_runs.errors.as_mut().filter(|_| by_speeds) {
        for (run, error) in slow.iter().zip(&errors) {
            let slope = slope_mean_restitution(runs.restitution[*run].powi(2));
            sds.restitution_sd[*run] = sds.restitution_sd[*run].hypot(slope * error);
        }
    } else {
        wider_scene.model.noise = NoiseOn::Both;
    }
    if is_ours {
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        let sigma = (squares / errors.len() as f64).sqrt();
        wider_scene.priors.push(PriorChoice {
            parameter: SIGMA_ENERGY.name,
            particle: None,
            prior: Prior::LogNormal(to_digits(sigma, 2), LN_SD),
            line: None,
        });
    }
    let wider = fit_posterior(&wider_scene, &wider_runs, least_squares, own.setup, &|_, _| ())?;
    let Some(mut wider) = wider.ok().filter(Posterior::sampling_holds) else {
        let text = format!(
            "{}: such runs fix the energy more tightly than errors of speeds and films allow, and a posterior with these \
             errors could not be sampled",
            shortened(&rows)
        );
        return Ok(Beside::Open(remarks::SLOW_REBOUNDS.check(None, text)));
    };
    let Some((name, before, after)) = posterior_moves(own, &wider) else {
        return Ok(Beside::Same);
    };
    let how = if by_speeds {
        "as errors of their restitutions"
    } else {
        "by noise = \"both\""
    };
    let text = format!(
        "{}: with noise on e alone such runs fix the energy more tightly than errors of 1 % in speed and 3 % in film allow. \
         With these allowed for, {how}, {} is {} in place of {}: the numbers here allow for them",
        shortened(&rows),
        remarks::in_symbols(&name),
        with_se(after[0], after[1]),
        with_se(before[0], before[1])
    );
    let notice = remarks::SLOW_REBOUNDS_ALLOWED.notice(slow.len(), text);
    // no prior of the scene: what the user can write is the noise itself
    let energy = format!("{}:", remarks::in_symbols(SIGMA_ENERGY.name));
    let is_of_energy = |check: &&mut Remark| check.code == remarks::PRIOR_CONFLICT.code && check.text.contains(&energy);
    if let Some(check) = wider.checks.iter_mut().filter(|_| is_ours).find(is_of_energy) {
        check.next_step =
            "write noise = \"both\" in [model]: energies scatter otherwise than errors of 1 % in speed and 3 % in \
                           film make them"
                .to_owned();
    }
    wider.scene = (!by_speeds).then(|| Box::new(wider_scene));
    let mut priors = wider.findings.parameters.iter_mut();
    let energy = priors.find(|one| is_ours && one.name == SIGMA_ENERGY.name);
    if let Some(prior) = energy.and_then(|one| one.prior.as_mut()) {
        prior.source = SOURCE;
    }
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
    Ok(Beside::Stands(Box::new(wider), notice))
}

/// Whether least squares, which knows no noise on the energy, gives the same numbers without the runs that barely rebound;
/// `None` where there are none.
pub(super) fn check_fit(setup: BalanceSetup, scaling: &[FittedScaling], own: &EnergyBalance) -> Option<Remark> {
    let BalanceSetup { scene, runs, .. } = setup;
    let slow = slow_rebounds(runs, own.form());
    if slow.is_empty() {
        return None;
    }
    let rows: Vec<String> = slow.iter().map(|run| run_words(scene, runs, *run)).collect();
    let others = runs.with_runs(|run| !slow.contains(&run));
    let others = BalanceSetup { runs: &others, ..setup };
    let moved = fit_balance(others, scaling, own.form(), false).and_then(|without| fit_moves(own, &without));
    let found = match &moved {
        Some((_, (name, before, after))) => {
            let told = |[value, se]: [f64; 2]| with_se(value, se);
            format!(
                "{} is {} with them and {} without them",
                remarks::in_symbols(name),
                told(*before),
                told(*after)
            )
        }
        None => "without them the others tell no number".to_owned(),
    };
    let text = format!(
        "{}: such runs fix the energy more tightly than errors of 1 % in speed or 3 % in film allow: by least squares {found}",
        shortened(&rows)
    );
    let mut check = remarks::SLOW_REBOUNDS.check(moved.map(|(shift, _)| shift), text);
    check.next_step = "sample the posterior (no --stages), which allows for such errors".to_owned();
    Some(check)
}

/// A number by its name, with its value and ± in two fits.
type InBoth = (String, [f64; 2], [f64; 2]);

/// The number that differs most between two fits, after by how many of the smaller ±.
fn moved_most(numbers: impl Iterator<Item = InBoth>) -> Option<(f64, InBoth)> {
    let shift = |(_, before, after): &InBoth| (after[0] - before[0]).abs() / before[1].min(after[1]);
    numbers
        .map(|number| (shift(&number), number))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The number that two fits of the balance differ in most.
fn fit_moves(own: &EnergyBalance, other: &EnergyBalance) -> Option<(f64, InBoth)> {
    let parameters = own.parameters.iter().filter_map(|parameter| {
        let after = other.estimate(parameter.kind)?;
        Some((parameter.name.clone(), &parameter.estimate, after))
    });
    let derived = own.derived.iter().flat_map(|row| {
        let after = other.derived.iter().find(|after| after.place == row.place);
        let here = format!("({}, δ/D = {})", row.particle, short(row.film_ratio));
        let pairs = after.map(|after| [("e_inf", &row.e_inf, &after.e_inf), ("St_c", &row.st_c, &after.st_c)]);
        let pairs = pairs.into_iter().flatten();
        pairs.map(move |(name, before, after)| (format!("{name} {here}"), before, after))
    });
    let pair = |estimate: &Estimate| estimate.value_and_scale().map(<[f64; 2]>::from);
    let each = parameters.chain(derived);
    moved_most(each.filter_map(|(name, before, after)| Some((name, pair(before)?, pair(after)?))))
}

/// The rebounds with a small restitution, where the liquid takes energy; none of many runs, which no few of them carry.
fn slow_rebounds(runs: &Runs, form: Form) -> Vec<usize> {
    let are_many = runs.sample.is_some() || !runs.count.is_empty() || runs.all_measured() > MOST_RUNS;
    if are_many || !Term::Viscous.is_held(form) {
        return vec![];
    }
    let rebounds = runs.series.iter().flat_map(|series| series.rebounds.clone());
    rebounds.filter(|run| runs.restitution[*run] < SLOW).collect()
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
        let sphere = series.find(|series| series.runs().any(|one| one == *run))?.sphere;
        let k = mean(ParameterKind::DryK(sphere)).unwrap_or(0.15);
        let e_dry = 1.0 - k * REFERENCE_SPEED.powf(0.2);
        let kept = runs.restitution[*run].powi(2);
        let lost = (e_dry * e_dry - kept).max(0.0);
        let viscous = l.map_or(lost, |l| (4.0 * l * runs.inverse_stokes(*run)).min(lost));
        // an error of the speed that a column tells is in the density already
        let is_told = runs.errors.as_ref().is_some_and(|errors| errors.of(*run)[0] > 0.0);
        let of_speed = if is_told { 0.0 } else { SPEED_ERROR * viscous };
        Some(of_speed.hypot(FILM_ERROR * (lost - viscous)))
    };
    let all: Vec<f64> = slow.iter().map(of_run).collect::<Option<_>>()?;
    all.iter().any(|error| *error > 0.0).then_some(all)
}

/// The main number that differs most between two posteriors, with its mean and sd in both; `None` where none differs by more
/// than one of the smaller sds.
fn posterior_moves(own: &Posterior, wider: &Posterior) -> Option<InBoth> {
    let quoted = [Quantity::EInf, Quantity::StC].map(|quantity| quantity.describe().name);
    let all = |posterior: &Posterior| -> Vec<(String, [f64; 2])> {
        let found = &posterior.findings;
        let parameters = posterior.sampled.parameters.sampled.iter().zip(&found.parameters);
        let parameters = parameters.filter(|(own, _)| own.kind.quantity().is_some());
        let derived = posterior.derived.iter().zip(&found.derived);
        let derived = derived.filter(|(own, _)| quoted.contains(&own.quantity));
        let each = parameters.map(|(_, one)| one).chain(derived.map(|(_, one)| one));
        each.filter_map(|one| Some((one.name.clone(), [one.mean?, one.sd?])))
            .collect()
    };
    let wider = all(wider);
    let pairs = all(own).into_iter().filter_map(|(name, before)| {
        let (_, after) = wider.iter().find(|(other, _)| *other == name)?;
        Some((name, before, *after))
    });
    let (shift, most) = moved_most(pairs)?;
    (!remarks::SLOW_REBOUNDS.holds(shift)).then_some(most)
}
