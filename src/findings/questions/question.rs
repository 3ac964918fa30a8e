//! Concludes whether a parameter is constant, and words the answer to a question as `findings.json` writes it.

use schemars::JsonSchema;
use serde::Serialize;

use crate::findings::remarks::{self, CLEAR_TREND};
use crate::physics::Coefficient;
use crate::remark::Remark;
use crate::rounding::with_se;

/// A question with its answer. Field names are those of `findings.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Question {
    /// in words
    pub question: &'static str,
    /// the parameter it asks of: `lubrication_log`, `inertial_prefactor`
    pub parameter: &'static str,
    /// only runs with film ratios below this one count; `None`: all
    pub film_ratio_below: Option<f64>,
    /// wet runs that count
    pub runs: usize,
    /// film ratios that enough of them have; `None` where they were not counted
    pub film_ratios: Option<usize>,
    /// the trend; `None` where nothing was sampled
    pub trend: Option<Trend>,
    /// what follows
    pub answer: Answer,
    /// the same in words
    pub text: String,
    /// why it is open, where that is not for what the trend is
    #[serde(skip)]
    pub why_open: Option<String>,
}

/// How a parameter goes with the logarithm of the film ratio: dL/d ln δ̃ or d ln C/d ln δ̃.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Trend {
    /// its letter
    pub symbol: &'static str,
    /// mean of the posterior
    pub mean: f64,
    /// its standard deviation
    pub sd: f64,
    /// its central 95 %
    pub interval: [f64; 2],
    /// largest change of an e_inf or a St_c at a film ratio of the runs, as a share of it, with the trend at either end of
    /// the interval in place of none; `None` where one of them ceases to be
    pub largest_change: Option<f64>,
    /// what was believed before, as a scene writes it
    pub prior: String,
    /// the sd of that; `None` where it has none
    #[serde(skip)]
    pub prior_sd: Option<f64>,
    /// why
    pub source: &'static str,
}

/// Whether a parameter goes with the film ratio.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// one value for all film ratios
    #[serde(rename = "one_serves")]
    Constant,
    /// it rises with the film ratio
    Rises,
    /// it falls
    Falls,
    /// the runs leave it open
    #[default]
    Open,
}

impl Question {
    /// The same, left open for a reason.
    pub(super) fn open(self, why: &str) -> Question {
        Question {
            answer: Answer::Open,
            why_open: Some(why.to_owned()),
            ..self
        }
        .worded()
    }

    /// The same with its answer in words.
    pub(super) fn worded(self) -> Question {
        Question {
            text: self.told(None),
            ..self
        }
    }

    /// The parameter it asks of.
    pub fn coefficient(&self) -> Coefficient {
        if self.film_ratio_below.is_some() {
            Coefficient::LubricationLog
        } else {
            Coefficient::InertialPrefactor
        }
    }

    /// The answer in words, without a full stop; of a parameter that is constant with its value, where one is given.
    pub fn told(&self, value: Option<String>) -> String {
        let symbol = self.coefficient().describe().symbol;
        let film = match self.film_ratio_below {
            Some(below) => format!("the film below δ/D = {below:.2}"),
            None => "the film".to_owned(),
        };
        if let Some(why) = &self.why_open {
            return format!("Whether {symbol} is independent of {film} is open: {why}");
        }
        let Some(trend) = &self.trend else {
            return String::new();
        };
        let slope = format!("{} = {}", trend.symbol, with_se(trend.mean, trend.sd));
        let change = trend.largest_change.map(|change| format!("{:.1} %", 100.0 * change));
        let goes = match self.answer {
            Answer::Constant => {
                return format!(
                    "{symbol} is independent of {film}{}. A trend with the film ({slope}) would move no e_inf or St_c by more \
                     than {}",
                    value.map_or(String::new(), |value| format!(": {value}")),
                    change.unwrap_or_default()
                )
            }
            Answer::Open => {
                let moves = change.map_or_else(
                    || "leaves no e_inf or St_c at a film of the runs".to_owned(),
                    |share| format!("may move e_inf or St_c by up to {share}"),
                );
                return format!(
                    "Whether {symbol} is independent of {film} is open: a trend with the film ({slope}) {moves}; film ratios \
                     farther apart would tell"
                );
            }
            Answer::Rises => "rises",
            Answer::Falls => "falls",
        };
        format!("{symbol} {goes} with the film: {slope}")
    }
}

/// A trend is small that moves no e_inf and no St_c at the films of the runs by more than this share of it.
pub const SMALL: f64 = 0.02;

/// A trend is there that lies so far from zero as chance hardly takes it ([`CLEAR_TREND`]); then one value is not quoted.
/// The parameter is constant where the whole interval is [`SMALL`].
/// `reports/questions.md` has how often which answer is given.
fn conclude(trend: &Trend) -> Answer {
    // a trend that is there may be small, too: then one value can be quoted all the same
    if trend.largest_change.is_some_and(|change| change <= SMALL) {
        Answer::Constant
    } else if trend.sds_from_zero() <= CLEAR_TREND {
        Answer::Open
    } else if trend.mean > 0.0 {
        Answer::Rises
    } else {
        Answer::Falls
    }
}

/// The question answered by the trend; `doubt` says why nothing can be built on it.
pub(super) fn answer_question(question: Question, trend: Trend, doubt: Option<String>) -> Question {
    let why_open = doubt.or_else(|| untold(&trend));
    Question {
        answer: why_open.as_ref().map_or_else(|| conclude(&trend), |_| Answer::Open),
        trend: Some(trend),
        why_open,
        ..question
    }
    .worded()
}

impl Trend {
    /// How far it lies from zero, in sds of the side that faces zero: a trend of C is skewed.
    fn sds_from_zero(&self) -> f64 {
        /// half width of a normal 95 % interval in sds
        const HALF: f64 = 1.96;
        let [lo, hi] = self.interval;
        let facing = if self.mean > 0.0 {
            self.mean - lo
        } else {
            hi - self.mean
        };
        HALF * self.mean.abs() / facing
    }
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
/// where they do not. `None` where nothing was sampled.
pub(super) fn check_trend(question: &Question) -> Option<Remark> {
    let check = remarks::FILM_TREND.check(question.trend.as_ref()?.sds_from_zero(), question.text.as_str());
    Some(Remark {
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
            prior: String::new(),
            prior_sd: Some(1.0),
            source: "",
        }
    }

    #[test]
    fn an_answer_needs_a_trend_far_from_zero_or_one_that_moves_nothing() {
        for (mean, sd, answer) in [
            (0.0, 0.1, Answer::Constant),
            (0.6, 0.04, Answer::Rises),
            (-0.6, 0.04, Answer::Falls),
            (0.33, 0.1, Answer::Rises),
            // there, and small
            (0.1, 0.04, Answer::Constant),
            // its 95 % interval excludes zero, as chance makes in one table of twenty
            (0.31, 0.1, Answer::Open),
            // the runs say nothing: the prior is what is left
            (0.0, 1.0, Answer::Open),
        ] {
            assert_eq!(conclude(&trend(mean, sd)), answer, "{mean} {sd}");
        }
        let without = Trend {
            largest_change: None,
            ..trend(0.0, 0.01)
        };
        assert_eq!(conclude(&without), Answer::Open);
        // at nearly one film ratio whatever trend there is moves nothing, and is not told
        let near = Trend {
            largest_change: Some(0.01),
            ..trend(0.3, 0.8)
        };
        assert!(untold(&near).is_some() && untold(&trend(0.0, 0.1)).is_none());
    }
}
