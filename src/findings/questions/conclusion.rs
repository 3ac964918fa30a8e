//! Says whether a parameter is constant, from the gain of a trend and the trend itself.

use super::question::{Answer, Question, Trend};
use crate::findings::checks::{self, Check};
use crate::findings::compare::ComparedModel;
use crate::findings::form_choice::is_gain;
use crate::inference::diagnostics::loo::Difference;
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

/// A trend is small that moves no e_inf and no St_c at the films of the runs by more than this share of it.
pub const SMALL: f64 = 0.02;

/// A trend is there where its 95 % interval excludes zero and it gains as much in log density as another form of the law must
/// ([`is_gain`]): one that lies 3.2 of its sds from zero gains 4 (z²/2 less 1 for its own parameter), and chance takes 1 in 700
/// so far. Then one value is not quoted.
/// One value serves where the whole interval is [`SMALL`].
/// `reports/questions.md` has how often which answer is given.
fn conclude(gain: Difference, trend: &Trend) -> Answer {
    // a trend that is there may be small, too: then one value serves all the same
    if trend.largest_change.is_some_and(|change| change <= SMALL) {
        Answer::Constant
    } else if !is_seen(gain, trend) {
        Answer::Open
    } else if trend.mean > 0.0 {
        Answer::Rises
    } else {
        Answer::Falls
    }
}

/// Whether a trend is there, however small.
fn is_seen(gain: Difference, trend: &Trend) -> bool {
    let [lo, hi] = trend.interval;
    is_gain(gain) && (lo > 0.0 || hi < 0.0)
}

/// The question answered by what both models of a form say.
pub(super) fn answer_question(question: Question, form: Form, evidence: TrendEvidence) -> Question {
    let TrendEvidence { models, gain, trend } = evidence;
    let concluded = conclude(gain, &trend);
    let doubt = doubt(&models).or_else(|| untold(&trend));
    let answer = if doubt.is_some() { Answer::Open } else { concluded };
    let of_lubrication = question.film_ratio_below.is_some();
    let text = match &doubt {
        Some(doubt) => format!("open: {doubt}"),
        None => format!(
            "{}: {}; {}",
            match answer {
                Answer::Constant if is_seen(gain, &trend) => small_trend(of_lubrication).to_owned(),
                _ => lead(answer, of_lubrication, form),
            },
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
        why_open: doubt,
        ..question
    }
}

/// Chains that differ by more than this tell nothing; the stricter line of the posterior is one for quoting its numbers.
const RHAT: f64 = 1.05;

/// Why an answer cannot be built on the models.
fn doubt(models: &[ComparedModel]) -> Option<String> {
    let apart = |model: &ComparedModel| {
        let rhat = model.rhat.filter(|rhat| *rhat > RHAT)?;
        Some(format!("the chains of {} do not agree (R-hat {rhat:.2})", model.model))
    };
    models.iter().find_map(apart)
}

/// Why runs at nearly one film ratio tell no trend, however little it would move there.
fn untold(trend: &Trend) -> Option<String> {
    /// of the prior's sd, as for a parameter that is led by its prior
    const LED: f64 = 0.5;
    let led = trend.prior_sd.is_some_and(|sd| trend.sd > LED * sd);
    let is_small = trend.largest_change.is_some_and(|change| change <= SMALL);
    (led && is_small).then(|| "the film ratios lie too near one another to tell a trend".to_owned())
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

/// The answer where a trend is there that moves next to nothing.
fn small_trend(of_lubrication: bool) -> &'static str {
    if of_lubrication {
        "one L serves (a trend is seen, too small to matter)"
    } else {
        "one C serves (a trend is seen, too small to matter)"
    }
}

/// The numbers behind the answer.
fn reason(answer: Answer, gain: Difference, trend: &Trend) -> String {
    let gains = match gain.se {
        Some(se) => format!("a trend gains {} ± {se:.1} (se) in log density", signed(gain.value, 1)),
        None => format!("a trend gains {} in log density", signed(gain.value, 1)),
    };
    let [lo, hi] = trend.interval;
    let decimals = decimals(trend);
    let range = format!(
        "its 95 % interval, {} to {}",
        signed(lo, decimals),
        signed(hi, decimals)
    );
    let moves = match trend.largest_change {
        Some(change) => format!(
            "moves e_inf or St_c at a film of the runs by up to {:.1} %",
            100.0 * change
        ),
        None => "leaves no e_inf or St_c at a film of the runs".to_owned(),
    };
    match answer {
        Answer::Constant => format!("{gains}; {range}, {moves}"),
        Answer::Rises | Answer::Falls => format!("{gains}; {range}, excludes zero"),
        Answer::Open => {
            let why = if lo > 0.0 || hi < 0.0 {
                "excludes zero, but the trend does not predict clearly better"
            } else {
                "includes zero"
            };
            let add = trend.add.as_ref();
            let add = add.map_or(String::new(), |runs| format!(", or more runs of the ends: {runs}"));
            format!(
                "{gains}; {range}, {why}, and {moves}, more than {:.0} %; add film ratios farther apart{add}",
                100.0 * SMALL
            )
        }
    }
}

/// Decimals that tell a trend.
fn decimals(trend: &Trend) -> usize {
    if trend.sd < 0.1 {
        3
    } else {
        2
    }
}

fn value(trend: &Trend) -> String {
    let decimals = decimals(trend);
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
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// Whether the runs leave a parameter the same at every film ratio: no number of a law that holds it constant may be quoted
/// where they do not. `None` where nothing was compared.
pub(super) fn check_trend(question: &Question) -> Option<Check> {
    let check = checks::FILM_TREND.check(question.gain?, question.text.as_str());
    Some(Check {
        passed: !matches!(question.answer, Answer::Rises | Answer::Falls),
        ..check
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trend that moves St_c by a tenth of itself.
    fn trend(mean: f64, sd: f64) -> Trend {
        let interval = [mean - 1.96 * sd, mean + 1.96 * sd];
        Trend {
            symbol: "L′",
            mean,
            sd,
            interval,
            largest_change: Some(0.1 * f64::max(-interval[0], interval[1])),
            add: Some("PTFE in AK10".to_owned()),
            prior: String::new(),
            prior_sd: Some(1.0),
            source: "",
        }
    }

    fn gain_of(value: f64) -> Difference {
        Difference {
            value,
            se: Some(1.0),
            mcse: 0.0,
        }
    }

    #[test]
    fn an_answer_needs_an_interval_that_excludes_zero_or_moves_nothing() {
        let of = |gain: f64, mean: f64, sd: f64| conclude(gain_of(gain), &trend(mean, sd));
        assert_eq!(of(-1.0, 0.0, 0.1), Answer::Constant);
        assert_eq!(of(90.0, 0.6, 0.04), Answer::Rises);
        assert_eq!(of(90.0, -0.6, 0.04), Answer::Falls);
        assert_eq!(of(4.5, 0.33, 0.1), Answer::Rises);
        // there, and small
        assert_eq!(of(5.0, 0.1, 0.04), Answer::Constant);
        // it excludes zero, and does not predict clearly better
        assert_eq!(of(3.9, 0.33, 0.1), Answer::Open);
        // it predicts better, and includes zero
        assert_eq!(of(4.5, 0.15, 0.1), Answer::Open);
        // the runs say nothing: the prior is what is left
        assert_eq!(of(0.0, 0.0, 1.0), Answer::Open);
        let without = Trend {
            largest_change: None,
            ..trend(0.0, 0.01)
        };
        assert_eq!(conclude(gain_of(0.0), &without), Answer::Open);
        // at nearly one film ratio whatever trend there is moves nothing, and is not told
        let near = Trend {
            largest_change: Some(0.01),
            ..trend(0.3, 0.8)
        };
        assert!(untold(&near).is_some() && untold(&trend(0.0, 0.1)).is_none());
    }

    #[test]
    fn reasons_tell_which_line_was_missed() {
        let open = |gain, t: Trend| reason(Answer::Open, gain_of(gain), &t);
        let text = open(-0.2, trend(0.33, 0.1));
        assert!(
            text.contains("excludes zero, but the trend does not predict clearly better"),
            "{text}"
        );
        let text = open(0.0, trend(0.0, 1.0));
        assert!(
            text.contains("−1.96 to 1.96, includes zero, and moves") && text.ends_with("PTFE in AK10"),
            "{text}"
        );
        assert_eq!(value(&trend(-0.004, 0.1)), "L′ = 0.00 ± 0.10 (sd)");
    }
}
