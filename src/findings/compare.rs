//! Compares the forms of the law by how well they predict runs they have not seen.

use rayon::prelude::*;
use serde::Serialize;

use super::checks::{self, Check};
use super::least_squares::LeastSquares;
use super::notices;
use super::posterior::{effort, start, Asked, Posterior};
use crate::error::Error;
use crate::inference::diagnostics::loo::{difference, loo, relative_efficiency, Loo};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::nuts::{divergences, Watcher};
use crate::inference::sampling::{sample_posterior, Sampled, SamplingPlan};
use crate::model::likelihood::pointwise::{EvaluatedLaw, Pointwise};
use crate::model::likelihood::Likelihood;
use crate::model::parameters::Parameters;
use crate::notice::Notice;
use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::inertia::Inertia;
use crate::physics::DrySpeed;
use crate::physics::{Form, Viscous};
use crate::runs::Runs;
use crate::scene::Scene;
use crate::seed::StreamName;

/// Log densities, runs times draws, that may be computed for one model.
pub const MOST_DENSITIES: usize = 20_000_000;

/// Fewer draws than this do not carry the weights.
const FEWEST_DRAWS: usize = 400;

/// One form of the law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// form of inertia and dry speed: `stepwise/2`, `cap/impact`
    pub model: String,
    /// whether it is the scene's own
    pub own: bool,
    /// expected log density of new runs, summed over the runs
    pub elpd_loo: f64,
    /// its standard error from the spread between runs
    pub se: Option<f64>,
    /// effective number of parameters
    pub p_loo: f64,
    /// largest shape of the weights' tail
    pub khat_max: Option<f64>,
    /// runs whose weights cannot be trusted
    pub khat_high: usize,
    /// by how much it predicts less than the best
    pub delta: f64,
    /// standard error of that difference, run by run
    pub delta_se: Option<f64>,
    /// largest R-hat of its sampling
    pub rhat: Option<f64>,
    /// draws that diverged
    pub divergences: usize,
}

/// What a comparison found.
#[derive(Debug)]
pub struct Comparison {
    /// the forms, best first
    pub models: Vec<Compared>,
    /// what must hold
    pub checks: Vec<Check>,
    /// what wants a second look
    pub notices: Vec<Notice>,
    /// leave-one-out of the scene's own form
    pub own: Option<Loo>,
}

/// The name of a form: `stepwise/2`, and what else it holds or lacks: `cap/impact+bridge-viscous`.
pub fn name(form: Form) -> String {
    let mut name = match form.dry_speed {
        DrySpeed::Reference(v) => format!("{}/{v}", form.inertia.name()),
        DrySpeed::Impact => format!("{}/impact", form.inertia.name()),
    };
    // the form of inertia says whether that is held
    let usual = Form::new(form.inertia, form.dry_speed);
    if Term::Viscous.is_held(form) && form.viscous != usual.viscous {
        name.push('+');
        name.push_str(form.viscous.name());
    }
    let differs = |term: &Term| term.is_held(form) != term.is_held(usual);
    for term in [Term::Bridge, Term::DrySecondOrder, Term::Viscous]
        .into_iter()
        .filter(differs)
    {
        name.push(if term.is_held(form) { '+' } else { '-' });
        name.push_str(term.name());
    }
    name
}

/// The forms that are compared with one: every form of inertia with both dry speeds; and with its own ones the other forms
/// of a viscous loss that is held.
fn compared_forms(own: Form) -> Vec<Form> {
    let reference = match own.dry_speed {
        DrySpeed::Impact => DrySpeed::Reference(REFERENCE_SPEED),
        reference => reference,
    };
    let of_inertia = |inertia: Inertia| {
        let of_speed = move |dry_speed: DrySpeed| Form {
            inertia,
            dry_speed,
            ..own
        };
        [reference, DrySpeed::Impact].map(of_speed)
    };
    let inertial = Inertia::ALL.into_iter().flat_map(of_inertia);
    let viscous = Viscous::NAMED
        .into_iter()
        .filter(|viscous| Term::Viscous.is_held(own) && *viscous != own.viscous)
        .map(|viscous| Form { viscous, ..own });
    inertial.chain(viscous).collect()
}

/// Samples the other forms on the same runs; the scene's own has been sampled already.
///
/// A form under which a prior leaves a parameter no room is not compared, and a notice says so.
pub fn find(
    scene: &Scene,
    runs: &Runs,
    (least_squares, own): (LeastSquares, &Posterior),
    watcher: Watcher,
) -> Comparison {
    let asked = own.asked;
    let mut found = Comparison {
        models: vec![],
        checks: vec![],
        notices: vec![],
        own: None,
    };
    let Some(used) = affordable(runs, own.sampled.draws()) else {
        let any_wet = !runs.series.is_empty();
        found.notices.push(notices::compare_left_out(runs.len(), any_wet));
        return found;
    };
    let mut all: Vec<(Compared, Loo)> = vec![];
    for form in compared_forms(asked.form) {
        let form = Asked { form, ..asked };
        let is_own = form.form == asked.form;
        let sampled;
        let draws = if is_own {
            &own.sampled
        } else {
            // own dry speeds bound k by the fastest run: what has room in the scene's form may have none in another
            let none = |_| Err("a prior of the scene leaves dry_k no room there".to_owned());
            match sample_form(scene, runs, least_squares, form, watcher).unwrap_or_else(none) {
                Ok(of_form) => {
                    sampled = of_form;
                    &sampled
                }
                Err(why) => {
                    found.notices.push(notices::form_not_compared(&name(form.form), &why));
                    continue;
                }
            }
        };
        match leave_out(scene, runs, form, draws, used) {
            Ok(of_form) => all.push((compared(name(form.form), is_own, draws, &of_form, used), of_form)),
            Err(why) => found.notices.push(notices::form_not_compared(&name(form.form), &why)),
        }
    }
    all.sort_by(|a, b| b.0.elpd_loo.total_cmp(&a.0.elpd_loo));
    let against_best: Vec<_> = all.iter().map(|(_, of_form)| difference(of_form, &all[0].1)).collect();
    for ((row, _), against) in all.iter_mut().zip(against_best) {
        if let Some(against) = against {
            row.delta = against.value;
            // the best against itself differs by nothing, surely
            row.delta_se = against.se;
        }
    }
    let threshold = khat_threshold(used);
    if let Some((row, _)) = all.iter().find(|(row, _)| row.own) {
        let text = if row.khat_high == 0 {
            "largest shape of the leave-one-out weights".to_owned()
        } else {
            format!(
                "{} runs weigh so much that leaving them out cannot be computed from these draws",
                row.khat_high
            )
        };
        found.checks.push(Check {
            // a run without a shape may weigh too much, too, and without any run of a shape none does
            passed: row.khat_high == 0,
            ..checks::LOO_KHAT.at(threshold).check(row.khat_max, text)
        });
        found.notices.extend(better(row, &all[0].0));
    }
    (found.models, found.own) = {
        let own = all.iter().position(|(row, _)| row.own);
        let mut loos: Vec<Loo> = vec![];
        let mut rows = vec![];
        for (row, of_form) in all {
            rows.push(row);
            loos.push(of_form);
        }
        (rows, own.map(|place| loos.swap_remove(place)))
    };
    found
}

/// How many of the draws can leave each run out; `None` for too many runs, or without wet ones.
pub(super) fn affordable(runs: &Runs, draws: usize) -> Option<usize> {
    let used = draws.min(MOST_DENSITIES / runs.len().max(1));
    (used >= FEWEST_DRAWS.min(draws) && !runs.series.is_empty()).then_some(used)
}

/// A form is better than another if it gains more than this in log density, and this many standard errors.
pub(super) const GAIN: f64 = 4.0;

/// Whether a difference of log density is a gain.
pub(super) fn is_gain(value: f64, se: Option<f64>) -> bool {
    value > GAIN && se.is_some_and(|se| value > GAIN * se)
}

/// The form of inertia that a scene with `inertia = "auto"` is given: the default one, unless another predicts clearly
/// better and its weights can be trusted. A notice says that intervals ignore the choice.
pub fn choose(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    default: Asked,
    watcher: Watcher,
) -> Result<(Asked, Option<Notice>), Error> {
    let Some(used) = affordable(runs, effort(scene).chains * effort(scene).draws) else {
        return Ok((default, None));
    };
    let mut forms = vec![];
    for inertia in Inertia::ALL {
        let form = Asked {
            form: Form {
                inertia,
                ..default.form
            },
            ..default
        };
        let sampled = sample_form(scene, runs, least_squares, form, watcher)?;
        if let Ok(of_form) = sampled.and_then(|sampled| leave_out(scene, runs, form, &sampled, used)) {
            forms.push((form, of_form));
        }
    }
    let Some((_, usual)) = forms.iter().find(|(form, _)| form.form == default.form) else {
        return Ok((default, None));
    };
    let gains = forms.iter().filter_map(|(form, of_form)| {
        let trusted = of_form.worst_khat(khat_threshold(used)).1 == 0;
        let gain = difference(of_form, usual)?;
        (trusted && is_gain(gain.value, gain.se)).then_some((*form, gain))
    });
    let Some((chosen, gain)) = gains.max_by(|a, b| a.1.value.total_cmp(&b.1.value)) else {
        return Ok((default, None));
    };
    let names = [chosen, default].map(|asked| asked.form.inertia.name());
    let notice = notices::form_chosen(names[0], names[1], gain.value);
    Ok((chosen, Some(notice)))
}

/// The scene's own form predicts clearly worse than another.
fn better(own: &Compared, best: &Compared) -> Option<Notice> {
    let gain = -own.delta;
    let in_se = gain / own.delta_se.unwrap_or(f64::NAN);
    is_gain(gain, own.delta_se).then(|| notices::better_form(&best.model, &own.model, gain, in_se))
}

fn sample_form(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    form: Asked,
    watcher: Watcher,
) -> Result<Result<Sampled, String>, Error> {
    let parameters = Parameters::of(scene, runs, form.form)?;
    let stream = format!("compare {}", name(form.form));
    Ok(sample_model(
        scene,
        runs,
        least_squares,
        (form, parameters, &stream),
        watcher,
    ))
}

/// Samples these parameters of a form from streams of this name; `Err` says why that cannot be done.
pub(super) fn sample_model(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    (form, parameters, stream): (Asked, Parameters, &str),
    watcher: Watcher,
) -> Result<Sampled, String> {
    let rows = Likelihood::of_rows(scene, runs, form.form);
    let plan = SamplingPlan {
        effort: effort(scene),
        stream: StreamName::new(least_squares.seed, stream),
        evaluation: form.way.evaluation(),
    };
    let start = start(scene, least_squares);
    sample_posterior(parameters, &rows, &start, plan, watcher).map_err(|why| why.to_string())
}

/// PSIS leave-one-out of a sampled form, by so many of its draws; `Err` says which run stands in the way.
pub(super) fn leave_out(
    scene: &Scene,
    runs: &Runs,
    form: Asked,
    sampled: &Sampled,
    used: usize,
) -> Result<Loo, String> {
    let pointwise = Pointwise::new(scene, runs, form.form);
    let full = sampled.full_draws();
    let step = full.len().div_ceil(used).max(1);
    let some: Vec<EvaluatedLaw> = full.par_iter().step_by(step).map(|full| pointwise.at(full)).collect();
    let fill = |run: usize, values: &mut [f64]| {
        for (value, at) in values.iter_mut().zip(&some) {
            *value = at.ln_likelihood(run);
        }
    };
    loo(runs.len(), some.len(), efficiency(sampled), fill).map_err(|(run, why)| format!("run {}: {why}", run + 1))
}

/// Relative efficiency of the draws over the sampled parameters.
fn efficiency(sampled: &Sampled) -> f64 {
    let ess: Vec<f64> = sampled
        .values
        .iter()
        .filter_map(|chains| summary_of(chains).ess_mean)
        .collect();
    relative_efficiency(&ess, sampled.chains.len(), sampled.draws())
}

fn summary_of(chains: &[Vec<f64>]) -> crate::inference::diagnostics::summary::Summary {
    let slices: Vec<&[f64]> = chains.iter().map(Vec::as_slice).collect();
    summarise(&slices)
}

/// What is told of a sampled model; its difference to the best is not known here.
pub(super) fn compared(model: String, own: bool, sampled: &Sampled, found: &Loo, used: usize) -> Compared {
    let (khat_max, khat_high) = found.worst_khat(khat_threshold(used));
    let rhats = sampled.values.iter().filter_map(|chains| summary_of(chains).rhat);
    Compared {
        model,
        own,
        elpd_loo: found.elpd,
        se: found.se,
        p_loo: found.p_loo,
        khat_max,
        khat_high,
        delta: 0.0,
        delta_se: None,
        rhat: rhats.reduce(f64::max),
        divergences: divergences(&sampled.chains),
    }
}
