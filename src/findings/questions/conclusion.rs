//! Concludes whether a parameter is constant, from the gain of a trend and the trend itself.

use super::question::{Answer, Question, Trend};
use crate::findings::checks::{self, Check};
use crate::findings::compare::ComparedModel;
use crate::findings::form_choice::is_gain;
use crate::inference::diagnostics::loo::Difference;

/// A trend is small that moves no e_inf and no St_c at the films of the runs by more than this share of it.
pub const SMALL: f64 = 0.02;

/// A trend is there where its 95 % interval excludes zero and it gains as much in log density as another form of the law must
/// ([`is_gain`]): one that lies 3.2 of its sds from zero gains 4 (z²/2 less 1 for its own parameter), and chance takes 1 in 700
/// so far. Then one value is not quoted.
/// The parameter is constant where the whole interval is [`SMALL`].
/// `reports/questions.md` has how often which answer is given.
fn conclude(gain: Difference, trend: &Trend) -> Answer {
    let [lo, hi] = trend.interval;
    // a trend that is there may be small, too: then one value can be quoted all the same
    if trend.largest_change.is_some_and(|change| change <= SMALL) {
        Answer::Constant
    } else if !is_gain(gain) || (lo <= 0.0 && hi >= 0.0) {
        Answer::Open
    } else if trend.mean > 0.0 {
        Answer::Rises
    } else {
        Answer::Falls
    }
}

/// The question answered by what a model without the trend and one with it say; the gain of the second is in log density.
pub(super) fn answer_question(
    question: Question,
    models: [ComparedModel; 2],
    gain: Difference,
    trend: Trend,
) -> Question {
    let why_open = doubt(&models).or_else(|| untold(&trend));
    let answer = if why_open.is_some() {
        Answer::Open
    } else {
        conclude(gain, &trend)
    };
    Question {
        models: models.to_vec(),
        gain: Some(gain.value),
        gain_se: gain.se,
        trend: Some(trend),
        answer,
        why_open,
        ..question
    }
    .worded()
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
}
