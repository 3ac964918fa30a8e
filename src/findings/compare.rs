//! Compares the forms of the law by how well they predict runs they have not seen.

use std::ops::Range;

use rayon::prelude::*;
use serde::Serialize;

use super::checks::{self, Check};
use super::form_choice::{is_gain, ln_prior_of_prefactor, Candidate, ChosenBy, InertiaChoice};
use super::least_squares::LeastSquares;
use super::notices;
use super::posterior::{effort, start, until_mixed, why_not_sampled, Posterior, PosteriorRefusal, SamplingSetup};
use crate::error::Error;
use crate::inference::diagnostics::loo::{difference, loo, relative_efficiency, Difference, Loo};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::nuts::{divergences, Watcher};
use crate::inference::sampling::{sample_until_mixed, Sampled, SamplingPlan};
use crate::model::likelihood::pointwise::Pointwise;
use crate::model::likelihood::{Likelihood, SeriesDensities};
use crate::model::parameters::{ModelParameters, ParameterKind};
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
pub struct ComparedModel {
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
    /// runs, or series that were left out as a whole, whose weights cannot be trusted
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
    pub models: Vec<ComparedModel>,
    /// what must hold
    pub checks: Vec<Check>,
    /// what wants a second look
    pub notices: Vec<Notice>,
    /// leave-one-out of the scene's own form
    pub own: Option<Loo>,
}

/// The name of a form: `stepwise/2`, and what else it holds or lacks: `cap/impact+bridge-viscous`.
pub fn model_name(form: Form) -> String {
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

/// What the models of a comparison are sampled from.
#[derive(Clone, Copy)]
pub struct ComparisonContext<'a> {
    /// what was held fixed
    pub scene: &'a Scene,
    /// the runs that every model is compared on
    pub runs: &'a Runs,
    /// where sampling starts
    pub least_squares: LeastSquares<'a>,
    /// hears of every draw
    pub watcher: Watcher<'a>,
}

/// A model with its leave-one-out densities.
#[derive(Debug, Clone)]
pub(super) struct EvaluatedModel {
    form: Form,
    row: ComparedModel,
    loo: Loo,
}

/// Samples every form of inertia with both dry speeds on the same runs; the scene's own has been sampled already.
///
/// A form under which a prior leaves a parameter no room is not compared, and a notice says so.
pub(super) fn compare_forms(context: ComparisonContext, own: &Posterior, known: &[EvaluatedModel]) -> Comparison {
    let runs = context.runs;
    let mut found = Comparison {
        models: vec![],
        checks: vec![],
        notices: vec![],
        own: None,
    };
    let Some(used) = affordable_draws(runs, own.sampled.draws()) else {
        let any_wet = !runs.series.is_empty();
        found.notices.push(notices::compare_left_out(runs.len(), any_wet));
        return found;
    };
    let mut evaluated: Vec<EvaluatedModel> = vec![];
    for form in alternatives(own.setup.form) {
        // what was sampled to choose the form of inertia need not be sampled again
        let known = known.iter().find(|model| model.form == form && form != own.setup.form);
        let model = known.map_or_else(|| evaluate_form(context, form, own, used), |known| Ok(known.clone()));
        match model {
            Ok(model) => evaluated.push(model),
            Err(why) => found.notices.push(notices::form_not_compared(&model_name(form), &why)),
        }
    }
    rank(&mut evaluated);
    if let Some(EvaluatedModel { row, .. }) = evaluated.iter().find(|model| model.row.own) {
        let units = if context.scene.model.series_offsets {
            "series or dry runs"
        } else {
            "runs"
        };
        found.checks.push(check_weights(row, used, units));
        found.notices.extend(better_form(row, &evaluated[0].row));
    }
    for EvaluatedModel { row, loo, .. } in evaluated {
        if row.own {
            found.own = Some(loo);
        }
        found.models.push(row);
    }
    found
}

/// The forms that a form is compared with, itself among them: every inertia with both dry speeds; and with its own ones
/// the other forms of a viscous loss that is held.
fn alternatives(own: Form) -> impl Iterator<Item = Form> {
    let reference = match own.dry_speed {
        DrySpeed::Impact => DrySpeed::Reference(REFERENCE_SPEED),
        reference => reference,
    };
    let of_inertia = move |inertia: Inertia| {
        [reference, DrySpeed::Impact].map(|dry_speed| Form {
            inertia,
            dry_speed,
            ..own
        })
    };
    let of_viscous = Viscous::NAMED
        .into_iter()
        .filter(move |viscous| Term::Viscous.is_held(own) && *viscous != own.viscous)
        .map(move |viscous| Form { viscous, ..own });
    Inertia::ALL.into_iter().flat_map(of_inertia).chain(of_viscous)
}

/// Samples a form as the scene's own was, unless it is that, and leaves each run out; `Err` says why that cannot be done.
fn evaluate_form(
    context: ComparisonContext,
    form: Form,
    own: &Posterior,
    used: usize,
) -> Result<EvaluatedModel, String> {
    let setup = SamplingSetup { form, ..own.setup };
    let is_own = form == own.setup.form;
    let sampled;
    let draws = if is_own {
        &own.sampled
    } else {
        // own dry speeds bound k by the fastest run: what has room in the scene's form may have none in another
        let none = |_| Err("a prior of the scene leaves dry_k no room there".to_owned());
        sampled = sample_form(context, setup).unwrap_or_else(none)?;
        &sampled
    };
    let loo = leave_out(context.scene, context.runs, setup, draws, used)?;
    Ok(EvaluatedModel {
        form,
        row: summarise_model(model_name(form), is_own, draws, &loo, used),
        loo,
    })
}

/// Puts the best first, and says how far each is behind it.
fn rank(evaluated: &mut [EvaluatedModel]) {
    evaluated.sort_by(|a, b| b.row.elpd_loo.total_cmp(&a.row.elpd_loo));
    let against_best: Vec<_> = evaluated
        .iter()
        .map(|model| difference(&model.loo, &evaluated[0].loo))
        .collect();
    for (model, against) in evaluated.iter_mut().zip(against_best) {
        if let Some(against) = against {
            model.row.delta = against.value;
            // the best against itself differs by nothing, surely
            model.row.delta_se = against.se;
        }
    }
}

/// Whether the weights of the scene's own form can be trusted.
fn check_weights(own: &ComparedModel, used: usize, units: &str) -> Check {
    let text = if own.khat_high == 0 {
        "largest shape of the leave-one-out weights".to_owned()
    } else {
        format!(
            "{} {units} weigh so much that leaving them out cannot be computed from these draws",
            own.khat_high
        )
    };
    Check {
        // a run without a shape may weigh too much, too, and without any run of a shape none does
        passed: own.khat_high == 0,
        ..checks::LOO_KHAT.at(khat_threshold(used)).check(own.khat_max, text)
    }
}

/// How many of the draws can leave each run out; `None` for too many runs, or without wet ones.
pub(super) fn affordable_draws(runs: &Runs, draws: usize) -> Option<usize> {
    let used = draws.min(MOST_DENSITIES / runs.len().max(1));
    (used >= FEWEST_DRAWS.min(draws) && !runs.series.is_empty()).then_some(used)
}

/// What a choice among forms found: the setup to sample, how it was chosen, and the forms that were sampled for it.
pub struct Chosen {
    /// the form to sample
    pub setup: SamplingSetup,
    /// how it was chosen; `None` where nothing could be compared
    pub choice: Option<InertiaChoice>,
    /// the forms that were left out run by run
    pub(super) evaluated: Vec<EvaluatedModel>,
}

/// The form of inertia that a scene which leaves it open is given, by how well each predicts runs it has not seen. Where runs
/// are too many to leave each out, the one that least squares took.
pub fn choose_inertia(context: ComparisonContext, default: SamplingSetup) -> Result<Chosen, Error> {
    let ComparisonContext {
        scene,
        runs,
        least_squares,
        ..
    } = context;
    let of = |inertia: Inertia| SamplingSetup {
        form: Form {
            inertia,
            ..default.form
        },
        ..default
    };
    let Some(used) = affordable_draws(runs, effort(scene).chains * effort(scene).draws) else {
        let balance = least_squares.energy_balance;
        return Ok(Chosen {
            setup: balance.map_or(default, |balance| of(balance.form().inertia)),
            choice: balance.and_then(|balance| balance.choice.clone()),
            evaluated: vec![],
        });
    };
    let (mut evaluated, mut candidates) = (vec![], vec![]);
    for inertia in Inertia::ALL {
        let setup = of(inertia);
        let Ok(sampled) = sample_form(context, setup)? else {
            continue;
        };
        let Ok(loo) = leave_out(scene, runs, setup, &sampled, used) else {
            continue;
        };
        let row = summarise_model(model_name(setup.form), false, &sampled, &loo, used);
        let c = geometric_mean(&sampled, ParameterKind::INERTIAL_PREFACTOR);
        candidates.push(Candidate {
            inertia,
            log_densities: loo.runs.iter().map(|run| run.elpd).collect(),
            ln_prior: c.map_or(0.0, |c| ln_prior_of_prefactor(scene, runs, setup.form, c)),
            trusted: row.khat_high == 0,
        });
        evaluated.push(EvaluatedModel {
            form: setup.form,
            row,
            loo,
        });
    }
    let chosen = InertiaChoice::among(&candidates, ChosenBy::LeaveOneOut);
    Ok(Chosen {
        setup: chosen.as_ref().map_or(default, |(inertia, _)| of(*inertia)),
        choice: chosen.map(|(_, choice)| choice),
        evaluated,
    })
}

/// The exponential of the mean logarithm of a positive parameter; `None` where it was not sampled.
fn geometric_mean(sampled: &Sampled, kind: ParameterKind) -> Option<f64> {
    let chains = &sampled.values[sampled.parameters.place(kind)?];
    let logarithms: f64 = chains.iter().flatten().map(|value| value.ln()).sum();
    let draws: usize = chains.iter().map(Vec::len).sum();
    Some((logarithms / draws as f64).exp())
}

/// The scene's own form predicts clearly worse than another.
fn better_form(own: &ComparedModel, best: &ComparedModel) -> Option<Notice> {
    let gain = -own.delta;
    let in_se = gain / own.delta_se.unwrap_or(f64::NAN);
    let clear = is_gain(Difference {
        value: gain,
        se: own.delta_se,
    });
    clear.then(|| notices::better_form(&best.model, &own.model, gain, in_se))
}

fn sample_form(context: ComparisonContext, setup: SamplingSetup) -> Result<Result<Sampled, String>, Error> {
    let parameters = ModelParameters::of(context.scene, context.runs, setup.form)?;
    let stream = format!("compare {}", model_name(setup.form));
    Ok(sample_model(context, setup, parameters, &stream))
}

/// Samples these parameters of a form from streams of this name; `Err` says why that cannot be done.
pub(super) fn sample_model(
    context: ComparisonContext,
    setup: SamplingSetup,
    parameters: ModelParameters,
    stream: &str,
) -> Result<Sampled, String> {
    let ComparisonContext {
        scene, least_squares, ..
    } = context;
    if let Some(PosteriorRefusal(why)) = why_not_sampled(context.runs, least_squares, &parameters) {
        return Err(why.text);
    }
    let rows = Likelihood::of_rows(scene, context.runs, setup.form);
    let plan = SamplingPlan {
        effort: effort(scene),
        stream: StreamName::new(least_squares.seed, stream),
        evaluation: setup.method.evaluation(),
    };
    let start = start(least_squares);
    let until = until_mixed(plan, parameters.dimension());
    sample_until_mixed(parameters, &rows, &start, until, context.watcher).map_err(|why| why.to_string())
}

/// PSIS leave-one-out of a sampled form, by so many of its draws; `Err` says which run stands in the way. Where series have
/// offsets a whole series is left out: a run would leave its offset known, which takes what a form misfits between series.
pub(super) fn leave_out(
    scene: &Scene,
    runs: &Runs,
    setup: SamplingSetup,
    sampled: &Sampled,
    used: usize,
) -> Result<Loo, String> {
    let pointwise = Pointwise::new(scene, runs, setup.form);
    let full = sampled.full_draws();
    let step = full.len().div_ceil(used).max(1);
    if scene.model.series_offsets {
        let rows = Likelihood::of_rows(scene, runs, setup.form);
        let units = SeriesDensities::new(pointwise, rows, runs);
        let some: Vec<&[f64]> = full.iter().step_by(step).map(Vec::as_slice).collect();
        return leave_series_out(&units, &some, efficiency(sampled));
    }
    let some = pointwise.at_draws(full.iter().step_by(step).map(Vec::as_slice).collect());
    let fill = |runs: Range<usize>, rows: &mut [f64]| some.ln_likelihoods(runs, rows);
    loo(runs.len(), some.len(), efficiency(sampled), fill).map_err(|(run, why)| format!("run {}: {why}", run + 1))
}

/// The same of dry runs and whole series.
fn leave_series_out(units: &SeriesDensities, draws: &[&[f64]], efficiency: f64) -> Result<Loo, String> {
    let each: Result<Vec<Vec<f64>>, _> = draws.par_iter().map(|full| units.ln_densities(full)).collect();
    let each = each.map_err(|_| "a draw has no density".to_owned())?;
    let fill = |some: Range<usize>, rows: &mut [f64]| {
        for (unit, row) in some.zip(rows.chunks_exact_mut(each.len().max(1))) {
            for (value, of_draw) in row.iter_mut().zip(&each) {
                *value = of_draw[unit];
            }
        }
    };
    let found = loo(units.len(), each.len(), efficiency, fill);
    found.map_err(|(unit, why)| format!("dry run or series {}: {why}", unit + 1))
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

/// The row of a sampled model; its difference to the best is not known here.
pub(super) fn summarise_model(model: String, own: bool, sampled: &Sampled, found: &Loo, used: usize) -> ComparedModel {
    let (khat_max, khat_high) = found.worst_khat(khat_threshold(used));
    let rhats = sampled.values.iter().filter_map(|chains| summary_of(chains).rhat);
    ComparedModel {
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
