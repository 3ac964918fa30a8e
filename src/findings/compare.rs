//! Compares the forms of the law by how well they predict runs they have not seen.

use schemars::JsonSchema;
use serde::Serialize;

use super::form_choice::{is_gain, ln_prior_of_prefactor, Candidate, ChosenBy, InertiaChoice};
use super::left_out::{largest_rhat, why_none_beside, ComparisonContext, LeftOutModel, Model};
use super::posterior::{effort, Posterior, SamplingSetup};
use super::remarks;
use crate::error::Error;
use crate::inference::diagnostics::loo::{difference, trusted_difference, Loo};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::nuts::divergences;
use crate::inference::sampling::{Method, Sampled};
use crate::model::parameters::{ModelParameters, ParameterKind};
use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::inertia::Inertia;
use crate::physics::DrySpeed;
use crate::physics::{Form, Viscous};
use crate::remark::{Level, Remark};
use crate::rounding::with_se;

/// One form of the law.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
    /// its Monte Carlo error: what other draws of both would move it by
    pub delta_mcse: Option<f64>,
    /// draws that runs were left out by
    pub draws: usize,
    /// whether these are draws of Student's t about the mode, weighed and resampled; else trajectories were followed
    pub weighed: bool,
    /// largest R-hat of its trajectories
    pub rhat: Option<f64>,
    /// draws that diverged
    pub divergences: usize,
}

impl ComparedModel {
    /// The name of its form of inertia.
    pub fn inertia(&self) -> &str {
        self.model.split(['/', '+']).next().unwrap_or_default()
    }

    /// By how many standard errors it predicts less than the best.
    pub fn errors_behind(&self) -> Option<f64> {
        self.delta_se.filter(|se| *se > 0.0).map(|se| -self.delta / se)
    }

    /// Whether the best predicts clearly better.
    pub fn is_clearly_worse(&self) -> bool {
        is_gain(-self.delta, self.delta_se)
    }
}

impl EvaluatedModel {
    /// Its difference to the best is not known here.
    fn new(form: Form, own: bool, sampled: &Sampled, loo: Loo, used: usize) -> EvaluatedModel {
        let (khat_max, khat_high) = loo.worst_khat(khat_threshold(used));
        // rough draws of a form far behind have weights of their own that are too unequal
        let rough = sampled.khat.filter(|khat| *khat > khat_threshold(used));
        let row = ComparedModel {
            model: model_name(form),
            own,
            elpd_loo: loo.elpd,
            se: loo.se,
            p_loo: loo.p_loo,
            khat_max: khat_max.into_iter().chain(rough).reduce(f64::max),
            khat_high,
            delta: 0.0,
            delta_se: None,
            delta_mcse: None,
            draws: used,
            weighed: sampled.method != Method::Nuts,
            rhat: largest_rhat(sampled),
            divergences: divergences(&sampled.chains),
        };
        EvaluatedModel { form, row, loo }
    }
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

/// A model with its leave-one-out densities.
#[derive(Debug, Clone)]
pub(super) struct EvaluatedModel {
    form: Form,
    row: ComparedModel,
    loo: Loo,
}

/// Samples every form of inertia with both dry speeds on the same runs; the scene's own has been sampled already. The forms, best
/// first, and what must hold, and what wants a second look.
///
/// A form under which a prior leaves a parameter no room, or that reads a roughness that is not given, is not compared, and a
/// notice says so.
pub(super) fn compare_forms(
    context: ComparisonContext,
    own: &Posterior,
    known: &[EvaluatedModel],
) -> (Vec<ComparedModel>, Vec<Remark>) {
    let runs = context.runs;
    if let Some(why_none) = why_none_beside(context.scene, runs, own.sampled.draws()) {
        let left_out = if runs.series.is_empty() {
            let text = "no wet runs: there are no forms of the wet law to compare";
            remarks::COMPARE_LEFT_OUT.notice(1, text.to_owned()).then("nothing")
        } else {
            let text = format!("forms of the law are not compared: {why_none}");
            remarks::COMPARE_LEFT_OUT.notice(1, text).at(Level::Cautions)
        };
        return (vec![], vec![left_out]);
    }
    // the scene's own is left out by its own draws, which a report writes
    let model = Model {
        context,
        setup: own.setup,
        parameters: &own.sampled.parameters,
        stream: "leave out",
    };
    let (own_loo, used) = match model.leave_out(&own.sampled, own.run_densities(context.scene, runs)) {
        Ok(left_out) => left_out,
        Err(why) => return (vec![], vec![not_compared(own.setup.form, &why)]),
    };
    let why_no_roughness = context.scene.why_no_roughness(runs.wet_particles());
    let own_model = EvaluatedModel::new(own.setup.form, true, &own.sampled, own_loo.clone(), used);
    let (mut evaluated, mut found) = (vec![own_model], vec![]);
    for form in alternatives(own.setup.form).filter(|form| *form != own.setup.form) {
        if let Some(why) = why_no_roughness.as_ref().filter(|_| form.viscous.reads_roughness()) {
            found.push(Remark {
                next_step: "give roughness_um in [particles], and it is compared".into(),
                ..not_compared(form, why)
            });
            continue;
        }
        // what was drawn to choose the form of inertia need not be drawn again
        let known = known.iter().find(|model| model.form == form);
        let setup = SamplingSetup { form, ..own.setup };
        let model = known.map_or_else(|| evaluate_form(context, setup, &own_loo), |known| Ok(known.clone()));
        match model {
            Ok(model) => evaluated.push(model),
            Err(why) => found.push(not_compared(form, &why)),
        }
    }
    rank(&mut evaluated);
    if let Some(EvaluatedModel { row, .. }) = evaluated.iter().find(|model| model.row.own) {
        let better = check_better_form((own.setup.form, row, &own_loo), &evaluated[0]);
        found.push(better);
    }
    (evaluated.into_iter().map(|model| model.row).collect(), found)
}

/// Says why a form is not compared.
fn not_compared(form: Form, why: &str) -> Remark {
    remarks::FORM_NOT_COMPARED.notice(1, format!("{} is not compared: {why}", model_name(form)))
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

/// Draws from a form and leaves each run out, beside the scene's own; `Err` says why that cannot be done.
fn evaluate_form(context: ComparisonContext, setup: SamplingSetup, own: &Loo) -> Result<EvaluatedModel, String> {
    // own dry speeds bound k by the fastest run: what has room in the scene's form may have none in another
    let none = |_| Err("a prior of the scene leaves dry_k no room there".to_owned());
    let LeftOutModel { sampled, loo, used } = draw_form(context, setup, Some(own)).unwrap_or_else(none)?;
    Ok(EvaluatedModel::new(setup.form, false, &sampled, loo, used))
}

/// Puts the best first, and says how far each is behind it.
fn rank(evaluated: &mut [EvaluatedModel]) {
    evaluated.sort_by(|a, b| b.row.elpd_loo.total_cmp(&a.row.elpd_loo));
    let against = |model: &EvaluatedModel| difference(&model.loo, &evaluated[0].loo);
    let against_best: Vec<_> = evaluated.iter().map(against).collect();
    for (model, against) in evaluated.iter_mut().zip(against_best) {
        if let Some(against) = against {
            model.row.delta = against.value;
            // the best against itself differs by nothing, surely
            model.row.delta_se = against.se;
            model.row.delta_mcse = (model.row.delta != 0.0).then_some(against.mcse);
        }
    }
}

/// The form of inertia that a scene which leaves it open is given, by how well each predicts runs it has not seen. Where runs
/// are too many for that, the one that least squares took. With it how it was chosen, `None` where nothing could be compared, and
/// the forms that were left out run by run for that.
pub(super) fn choose_inertia(
    context: ComparisonContext,
    default: SamplingSetup,
) -> Result<(SamplingSetup, Option<InertiaChoice>, Vec<EvaluatedModel>), Error> {
    let (scene, runs) = (context.scene, context.runs);
    let of = |inertia: Inertia| SamplingSetup {
        form: Form {
            inertia,
            ..default.form
        },
        ..default
    };
    if why_none_beside(scene, runs, effort(scene).chains * effort(scene).draws).is_some() {
        let balance = context.least_squares.energy_balance.as_ref();
        let setup = balance.map_or(default, |balance| of(balance.form().inertia));
        return Ok((setup, balance.and_then(|balance| balance.choice.clone()), vec![]));
    };
    let (mut evaluated, mut candidates): (Vec<EvaluatedModel>, _) = (vec![], vec![]);
    for inertia in Inertia::ALL {
        let setup = of(inertia);
        let best = evaluated
            .iter()
            .max_by(|a, b| a.row.elpd_loo.total_cmp(&b.row.elpd_loo));
        let drawn = draw_form(context, setup, best.map(|best| &best.loo))?;
        let Ok(LeftOutModel { sampled, loo, used }) = drawn else {
            continue;
        };
        let c = geometric_mean(&sampled, ParameterKind::INERTIAL_PREFACTOR);
        let model = EvaluatedModel::new(setup.form, false, &sampled, loo, used);
        candidates.push(Candidate {
            inertia,
            log_densities: model.loo.runs.iter().map(|run| run.elpd).collect(),
            ln_prior: c.map_or(0.0, |c| ln_prior_of_prefactor(scene, runs, setup.form, c)),
            untrusted: model.loo.untrusted(khat_threshold(used)).collect(),
        });
        evaluated.push(model);
    }
    let choice = InertiaChoice::among(&candidates, ChosenBy::LeaveOneOut);
    let setup = choice.as_ref().map_or(default, |choice| of(choice.inertia));
    Ok((setup, choice, evaluated))
}

/// The exponential of the mean logarithm of a positive parameter; `None` where it was not sampled.
fn geometric_mean(sampled: &Sampled, kind: ParameterKind) -> Option<f64> {
    let chains = &sampled.values[sampled.parameters.place(kind)?];
    let logarithms: f64 = chains.iter().flatten().map(|value| value.ln()).sum();
    let draws: usize = chains.iter().map(Vec::len).sum();
    Some((logarithms / draws as f64).exp())
}

/// Settles the notice that e_dry at each run's own speed is not in the model, once forms that have it are compared.
pub(super) fn settle_dry_speed(notices: &mut Vec<Remark>, models: &[ComparedModel]) {
    let awaits = |notice: &Remark| notice.next_step == remarks::COMPARE_DRY_SPEEDS;
    let Some(at) = notices.iter().position(awaits) else {
        return;
    };
    let has_it = |model: &ComparedModel| model.model.contains("/impact");
    let (Some(best), Some(own)) = (models.first(), models.iter().find(|model| model.own)) else {
        return;
    };
    if has_it(best) && !has_it(own) && own.is_clearly_worse() {
        // the check of the better form says it
        notices.remove(at);
        return;
    }
    // the scene's own form but for its dry speed
    let twin = |other: &&ComparedModel| {
        let is_viscous_alike = other.model.contains('+') == own.model.contains('+');
        !other.own && has_it(other) && is_viscous_alike && other.inertia() == own.inertia()
    };
    let behind = |twin: &ComparedModel| (own.delta - twin.delta, twin.delta_se);
    let behind = models.iter().find(twin).map(behind);
    let notice = &mut notices[at];
    let Some((behind, Some(se))) = behind.filter(|(gain, se)| is_gain(*gain, *se)) else {
        notice.next_step =
            "see Other forms of the law: dry_speed_m_s = \"impact\" holds it where it predicts better".into();
        return;
    };
    *notice = notice.clone().at(Level::Informs);
    notice.text = format!(
        "{}: not in the model, and the comparison of forms speaks against it: with it the runs are predicted worse by {} \
         in log density",
        Term::OwnDrySpeed.in_words(),
        with_se(behind, se)
    );
    notice.next_step = "nothing".into();
}

/// Whether another form of the law predicts the runs clearly better than the scene's own.
///
/// A run that weighs too much makes its form look better than it is: what it gains by such runs alone forbids nothing.
fn check_better_form((form, own, own_loo): (Form, &ComparedModel, &Loo), best: &EvaluatedModel) -> Remark {
    let gain = -own.delta;
    let is_better = own.is_clearly_worse();
    let trusted = trusted_difference(&best.loo, own_loo, khat_threshold(best.row.draws));
    let forbids = trusted.is_some_and(|gain| is_gain(gain.value, gain.se));
    let mut text = if is_better {
        format!(
            "{} ({}) predicts the runs better than {} by {gain:.1} in log density, {:.1} standard errors",
            best.row.model,
            keys_of(best.form, form),
            own.model,
            own.errors_behind().unwrap_or_default()
        )
    } else {
        format!(
            "gain in log density of the form that predicts the runs best ({})",
            best.row.model
        )
    };
    if is_better && !forbids {
        let by_trusted = trusted.map_or("nothing".to_owned(), |gain| format!("{:.1}", gain.value));
        text +=
            &format!("; by the runs whose weights can be trusted it gains {by_trusted}, too little to forbid quoting");
    }
    Remark {
        passed: !is_better,
        ..remarks::BETTER_FORM.check(gain, text).forbidding_if(forbids)
    }
}

/// The keys of `[model]` that hold a form, where they differ from those of another.
fn keys_of(form: Form, other: Form) -> String {
    let dry_speed = match form.dry_speed {
        DrySpeed::Impact => "\"impact\"".to_owned(),
        DrySpeed::Reference(v) => v.to_string(),
    };
    let keys = [
        (form.inertia != other.inertia).then(|| format!("inertia = \"{}\"", form.inertia.name())),
        (form.dry_speed != other.dry_speed).then(|| format!("dry_speed_m_s = {dry_speed}")),
        (form.viscous != other.viscous).then(|| format!("viscous = \"{}\"", form.viscous.name())),
    ];
    format!("[model] {}", keys.into_iter().flatten().collect::<Vec<_>>().join(", "))
}

fn draw_form(
    context: ComparisonContext,
    setup: SamplingSetup,
    beside: Option<&Loo>,
) -> Result<Result<LeftOutModel, String>, Error> {
    let parameters = ModelParameters::of(context.scene, context.runs, setup.form)?;
    let stream = format!("compare {}", model_name(setup.form));
    let model = Model {
        context,
        setup,
        parameters: &parameters,
        stream: &stream,
    };
    Ok(model.draw_and_leave_out(beside))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model that no runs were compared by.
    fn made_up(name: &str, own: bool, delta: f64) -> ComparedModel {
        ComparedModel {
            model: name.to_owned(),
            own,
            elpd_loo: 100.0 + delta,
            se: Some(5.0),
            p_loo: 3.0,
            khat_max: Some(0.2),
            khat_high: 0,
            delta,
            delta_se: Some(3.0),
            delta_mcse: None,
            draws: 4000,
            weighed: false,
            rhat: Some(1.0),
            divergences: 0,
        }
    }

    #[test]
    fn what_is_said_of_a_dry_speed_of_each_run_waits_for_the_comparison() {
        for (best, other, delta, level) in [
            // the check of the better form says it
            (("cap/impact", false), "stepwise/2", -26.0, None),
            (("cap/impact", false), "stepwise/2", -3.0, Some(Level::Cautions)),
            (("cap/2", false), "stepwise/2", -26.0, Some(Level::Cautions)),
            (("cap/impact", false), "stepwise/impact", -26.0, Some(Level::Cautions)),
            (("cap/2", true), "cap/impact", -3.0, Some(Level::Cautions)),
            // it is rejected
            (("cap/2", true), "cap/impact", -367.2, Some(Level::Informs)),
        ] {
            let of_each_run = Remark::new("term_not_held", 1, "if it acts", remarks::COMPARE_DRY_SPEEDS);
            let mut notices = vec![of_each_run];
            let models = [made_up(best.0, best.1, 0.0), made_up(other, !best.1, delta)];
            settle_dry_speed(&mut notices, &models);
            let found = notices.first().map(|notice| notice.level);
            assert_eq!(found, level, "{best:?} {other} {delta}");
        }
    }
}
