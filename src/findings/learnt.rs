//! Says in sentences what was learnt of the law, each made from the numbers of the findings.

use super::compare::ComparedModel;
use super::document::Findings;
use super::estimate::Estimate;
use super::form_choice::{is_gain, ChosenBy};
use super::identify::Unidentified;
use super::questions::Question;
use super::remarks::{self, Kind};
use crate::physics::inertia::Inertia;
use crate::physics::{Coefficient, Quantity};
use crate::rounding::{short, significant, to_digits, with_se};
use crate::runs::Runs;
use crate::scene::{Scene, Sticking, NOISE};

/// What was learnt of a scene's runs: whether L and C depend on the film, which form of inertia they prefer, whether the loss levels off,
/// what stuck runs say, and what is not determined. Of what was not asked nothing is said.
pub(super) fn what_was_learnt(scene: &Scene, runs: &Runs, findings: &Findings) -> Vec<String> {
    let asked = |question: &&Question| !runs.series.is_empty() && !question.text.is_empty();
    let questions = findings.questions.iter().flatten().filter(asked);
    let (of_l, of_c): (Vec<&Question>, Vec<&Question>) =
        questions.partition(|question| question.coefficient() == Coefficient::LubricationLog);
    let constant = |question: &&Question| {
        let value = shared(findings, question.coefficient()).map(Estimate::rounded);
        format!("{}.", question.told(value))
    };
    of_l.iter()
        .map(constant)
        .chain(preferred_inertia(findings))
        .chain(level_off(findings))
        .chain(of_c.iter().map(constant))
        .chain(stuck(scene, runs, findings))
        .chain(determined(findings))
        .collect()
}

/// The main number of a parameter that all runs share.
fn shared(findings: &Findings, coefficient: Coefficient) -> Option<&Estimate> {
    let mut parameters = findings.main.parameters.iter();
    let own = parameters.find(|own| own.is(Quantity::Shared(coefficient)))?;
    Some(&own.number)
}

/// What a form of the inertial loss is called in a sentence.
fn form_words(inertia: &str) -> &str {
    if inertia == Inertia::None.name() {
        "none at all"
    } else {
        inertia
    }
}

/// Which form of the inertial loss the runs prefer, and by how much.
fn preferred_inertia(findings: &Findings) -> Option<String> {
    if let Some((best, next)) = inertia_compared(findings) {
        let told = preference([best.inertia(), next.inertia()], -next.delta, next.delta_se);
        return Some(format!("Of the forms of the inertial loss the runs {told}."));
    }
    let choice = findings.inertia.as_ref();
    let choice = choice.filter(|own| own.by == ChosenBy::LeastSquares)?;
    let others = choice.others.iter();
    let next = others.max_by(|a, b| a.difference.total_cmp(&b.difference))?;
    let told = preference([choice.inertia.name(), next.inertia.name()], -next.difference, next.se);
    Some(format!(
        "Of the forms of the inertial loss the runs {told}, by the squares they leave."
    ))
}

/// Whether the first of two forms is preferred to the second, over which it gains so much.
fn preference([first, second]: [&str; 2], gain: f64, se: Option<f64>) -> String {
    let (first, second) = (form_words(first), form_words(second));
    let amount = |gain: f64| match se {
        Some(se) => with_se(gain, se),
        None => significant(gain, 3),
    };
    if is_gain(gain, se) {
        format!("prefer {first}, by {} in log density over {second}", amount(gain))
    } else {
        // the first may be chosen for having fewer parameters, and gain nothing
        let apart = amount(gain.abs());
        format!("do not tell {first} from {second}, {apart} apart in log density")
    }
}

/// The form that predicts best, and the best with another inertia.
fn inertia_compared(findings: &Findings) -> Option<(&ComparedModel, &ComparedModel)> {
    let models = findings.compare.as_ref()?;
    let best = models.first()?;
    let next = models.iter().find(|model| model.inertia() != best.inertia())?;
    Some((best, next))
}

/// Whether the inertial loss levels off, where a form that does is preferred.
fn level_off(findings: &Findings) -> Option<String> {
    let (best, next) = inertia_compared(findings)?;
    let scale = shared(findings, Coefficient::FilmScale)?;
    let is_seen = best.inertia() == Inertia::Saturating.name() && next.is_clearly_worse();
    is_seen.then(|| {
        format!(
            "The inertial loss levels off with the film, on a scale of δ/D = {} ({}).",
            scale.rounded(),
            Coefficient::FilmScale.describe().symbol
        )
    })
}

/// What the runs that stuck say.
fn stuck(scene: &Scene, runs: &Runs, findings: &Findings) -> Option<String> {
    let stuck: usize = runs.series.iter().map(|own| runs.measured(own.stuck.clone())).sum();
    let wet = runs.wet_measured();
    if wet == 0 {
        return None;
    }
    if scene.model.sticking == Sticking::Truncated {
        return Some("Runs that stuck were not logged: each rebound counts as one of those that rebound.".to_owned());
    }
    if stuck == 0 {
        let none = "No wet run stuck: the speed below which nothing rebounds follows from the law alone.";
        return Some(none.to_owned());
    }
    let of_all = format!("{stuck} of {wet} wet runs stuck");
    let is_censored = scene.model.sticking == Sticking::Censored;
    let Some(posterior) = findings.posterior.as_ref().filter(|_| is_censored) else {
        return Some(format!("{of_all}; these numbers rest on those that rebounded."));
    };
    let in_doubt = &posterior.predictive.stuck;
    let fails = |kind: &Kind| findings.remarks.iter().any(|check| kind.is(check) && !check.passed);
    let failed = fails(&remarks::PREDICTIVE_STUCK);
    let Some(worst) = in_doubt.iter().min_by(|a, b| a.p.total_cmp(&b.p)) else {
        return Some(format!("{of_all}, all of them where the law leaves no doubt."));
    };
    let observed: usize = in_doubt.iter().map(|own| own.observed).sum();
    let expected: f64 = in_doubt.iter().map(|own| own.expected).sum();
    Some(if failed {
        format!(
            "{of_all}, not as the law expects: of {} in {} and {}, D = {} mm, δ/D = {}, {} stuck and {:.1} were expected.",
            worst.runs,
            worst.particle,
            worst.liquid,
            short(1e3 * worst.diameter_m),
            short(worst.film_ratio),
            worst.observed,
            worst.expected
        )
    } else {
        // one of them may be no stuck run
        let how = match fails(&remarks::UNSEEN_REBOUNDS) {
            true => "which the law allows, though one of them is in doubt (see the checks)",
            false => "as the law expects",
        };
        format!(
            "{of_all}, {how}: in the {} series near the threshold {observed} stuck, and {expected:.1} were \
             expected.",
            in_doubt.len()
        )
    })
}

/// The parameter of the law that keeps most of its prior's sd in the posterior, and how much.
fn least_known(findings: &Findings) -> Option<(String, f64)> {
    let parameters = findings.posterior.as_ref()?.parameters.iter();
    let of_law = parameters.filter(|own| NOISE.iter().all(|noise| noise.name != own.name));
    let each = of_law.filter_map(|own| {
        let prior = own.prior.as_ref()?;
        let name = match own.name.split_once('[') {
            Some((_, of)) => format!("{} of {}", prior.symbol, of.trim_end_matches(']')),
            None => prior.symbol.to_owned(),
        };
        Some((name, prior.sd_ratio?))
    });
    each.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// What the runs do not determine, and which would.
fn determined(findings: &Findings) -> Vec<String> {
    let Some(directions) = &findings.identifies else {
        return vec![];
    };
    if directions.unseen.is_empty() {
        let by_runs = || (directions.least_known_words.clone(), directions.spread_left);
        let (least_known, left) = least_known(findings).unwrap_or_else(by_runs);
        // beside a narrow prior of the scene the share that is left says nothing
        if left > 0.5 {
            return vec![];
        }
        return vec![format!(
            "The runs determine every parameter. The least constrained is {least_known}, which keeps {} % of its prior sd.",
            // rounded as the share itself is elsewhere
            short(100.0 * to_digits(left, 2))
        )];
    }
    let sentence = |one: &Unidentified| capital(&format!("{}; {}.", one.reason, one.add));
    directions.unseen.iter().map(sentence).collect()
}

/// The same with a capital at its start.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_preferred_only_where_the_difference_is_clear() {
        let none = "prefer none at all, by 60 ± 9 in log density over cap";
        assert_eq!(preference(["none", "cap"], 60.0, Some(9.0)), none);
        // kept for having fewer parameters
        let fewer = "do not tell stepwise from saturating, 0.7 ± 1.5 apart in log density";
        assert_eq!(preference(["stepwise", "saturating"], -0.7, Some(1.5)), fewer);
    }
}
