//! Says whether a parameter is constant, from the gain of a trend and the trend itself.

use super::question::{Answer, Question, Trend};
use crate::findings::compare::ComparedModel;
use crate::findings::form_choice::{is_gain, GAIN};
use crate::findings::notices;
use crate::inference::diagnostics::loo::Difference;
use crate::notice::Notice;
use crate::physics::inertia::Inertia;
use crate::physics::Form;

/// What two models of the same runs give as evidence.
pub(super) struct TrendEvidence {
    /// the one without the trend, the one with it
    pub models: [ComparedModel; 2],
    /// by how much the trend predicts the runs better, in log density
    pub gain: Difference,
    pub trend: Trend,
}

/// A trend that matters: half of the one that keeps δc a fixed share of the film, or a loss from growing with it.
const MATTERS: f64 = 0.5;

/// The line is that of choosing a form: a gain above 4 and above 4 standard errors. One value serves only where the runs
/// exclude a trend that matters; a small one may be there.
fn conclude(gain: Difference, trend: &Trend) -> Answer {
    let [lo, hi] = trend.interval;
    if is_gain(gain) {
        if trend.mean > 0.0 {
            Answer::Rises
        } else {
            Answer::Falls
        }
    } else if gain.value <= GAIN && lo > -MATTERS && hi < MATTERS {
        Answer::Constant
    } else {
        Answer::Open
    }
}

/// The question answered by what both models of a form say.
pub(super) fn answer_question(question: Question, form: Form, evidence: TrendEvidence) -> Question {
    let TrendEvidence { models, gain, trend } = evidence;
    let concluded = conclude(gain, &trend);
    let doubt = doubt(&models, concluded);
    let answer = if doubt.is_some() { Answer::Open } else { concluded };
    let of_lubrication = question.film_ratio_below.is_some();
    let text = match &doubt {
        Some(doubt) => format!("open: {doubt}"),
        None => format!(
            "{}: {}; {}",
            lead(answer, of_lubrication, form),
            reason(answer, gain, &trend),
            value(&trend)
        ),
    };
    Question {
        models: models.to_vec(),
        gain: Some(gain.value),
        gain_se: gain.se,
        trend: Some(trend),
        answer,
        text,
        ..question
    }
}

/// Chains that differ by more than this tell nothing; the stricter line of the posterior is one for quoting its numbers.
const RHAT: f64 = 1.05;

/// Why an answer cannot be built on the models, the one with the trend last.
fn doubt(models: &[ComparedModel], answer: Answer) -> Option<String> {
    let apart = |model: &ComparedModel| {
        let rhat = model.rhat.filter(|rhat| *rhat > RHAT)?;
        Some(format!("the chains of {} do not agree (R-hat {rhat:.2})", model.model))
    };
    if let Some(why) = models.iter().find_map(apart) {
        return Some(why);
    }
    // a run that weighs too much tends to make its model look better than it is: that matters of the one that wins, and
    // where one value serves the interval of the trend says so, too
    let winner = models
        .last()
        .filter(|_| matches!(answer, Answer::Rises | Answer::Falls))?;
    (winner.khat_high > 0).then(|| {
        format!(
            "a trend seems to gain, but {} of the runs weigh so much that {} cannot be judged without them",
            winner.khat_high, winner.model
        )
    })
}

/// The answer in the field's words.
fn lead(answer: Answer, of_lubrication: bool, form: Form) -> String {
    let formula = form.inertia.name();
    match (answer, of_lubrication) {
        (Answer::Open, _) => "open".to_owned(),
        (Answer::Constant, true) => "one L serves".to_owned(),
        (Answer::Rises, true) => {
            "L rises with the film (in a thicker one the sphere turns round farther out)".to_owned()
        }
        (Answer::Falls, true) => "L falls with the film".to_owned(),
        (Answer::Constant, false) if form.inertia == Inertia::Saturating => {
            "one C serves (the loss levels off as the saturating form says)".to_owned()
        }
        (Answer::Constant, false) => format!("one C serves (no level-off is seen beyond the {formula} form)"),
        (Answer::Falls, false) => {
            format!("C falls with the film (the level-off: the inertial loss grows less than the {formula} form says)")
        }
        (Answer::Rises, false) => {
            format!("C rises with the film (the inertial loss grows more than the {formula} form says)")
        }
    }
}

/// The numbers behind the answer.
fn reason(answer: Answer, gain: Difference, trend: &Trend) -> String {
    let gains = match gain.se {
        Some(se) => format!("a trend gains {} ± {se:.1} (se) in log density", signed(gain.value, 1)),
        None => format!("a trend gains {} in log density", signed(gain.value, 1)),
    };
    let [lo, hi] = trend.interval;
    let range = format!("{} to {}", signed(lo, 2), signed(hi, 2));
    match answer {
        Answer::Open if gain.value > GAIN => format!("{gains}, which is less than four standard errors"),
        Answer::Open => format!(
            "{gains}, but its 95 % interval, {range}, reaches ±{MATTERS}, which would matter; add film ratios farther apart, or runs"
        ),
        _ => gains,
    }
}

fn value(trend: &Trend) -> String {
    let decimals = if trend.sd < 0.1 { 3 } else { 2 };
    format!(
        "{} = {} ± {:.decimals$} (sd)",
        trend.symbol,
        signed(trend.mean, decimals),
        trend.sd
    )
}

/// A number to so many decimals, without a minus before 0.
fn signed(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|byte| matches!(byte, b'0' | b'.')) => zero.to_owned(),
        _ => text,
    }
}

/// What to do about a parameter that is not constant.
pub(super) fn trend_notice(question: &Question) -> Option<Notice> {
    if !matches!(question.answer, Answer::Rises | Answer::Falls) {
        return None;
    }
    let of_lubrication = question.film_ratio_below.is_some();
    Some(notices::film_trend(question.runs, &question.text, of_lubrication))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trend(mean: f64, sd: f64) -> Trend {
        Trend {
            symbol: "L′",
            mean,
            sd,
            interval: [mean - 1.96 * sd, mean + 1.96 * sd],
            prior: String::new(),
            source: "",
        }
    }

    fn gain_of(value: f64, se: Option<f64>) -> Difference {
        Difference { value, se }
    }

    #[test]
    fn an_answer_needs_a_gain_or_runs_that_would_have_shown_one() {
        let of = |gain: f64, se: f64, mean: f64, sd: f64| conclude(gain_of(gain, Some(se)), &trend(mean, sd));
        assert_eq!(of(0.3, 1.1, 0.05, 0.1), Answer::Constant);
        assert_eq!(of(-1.0, 0.4, 0.0, 0.1), Answer::Constant);
        assert_eq!(of(90.0, 12.0, 0.6, 0.04), Answer::Rises);
        assert_eq!(of(90.0, 12.0, -0.6, 0.04), Answer::Falls);
        // between the lines
        assert_eq!(of(12.0, 5.0, 0.6, 0.1), Answer::Open);
        assert_eq!(of(2.5, 2.4, 0.33, 0.1), Answer::Open);
        // small, and known to be
        assert_eq!(of(1.6, 1.7, -0.07, 0.035), Answer::Constant);
        // the runs say nothing: the prior is what is left
        assert_eq!(of(0.0, 0.1, 0.0, 1.0), Answer::Open);
        assert_eq!(conclude(gain_of(90.0, None), &trend(0.6, 0.04)), Answer::Open);
    }

    #[test]
    fn reasons_tell_which_line_was_missed() {
        let open = |gain, t: Trend| reason(Answer::Open, gain_of(gain, Some(5.0)), &t);
        assert!(open(12.0, trend(0.6, 0.1)).ends_with("less than four standard errors"));
        assert!(open(0.0, trend(0.0, 1.0)).contains("-1.96 to 1.96, reaches ±0.5"));
        assert_eq!(value(&trend(-0.004, 0.1)), "L′ = 0.00 ± 0.10 (sd)");
    }
}
