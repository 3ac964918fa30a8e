//! Holds a question with its answer, as `findings.json` writes it, and words it.

use serde::Serialize;

use crate::findings::compare::ComparedModel;
use crate::physics::Coefficient;
use crate::rounding::with_se;

/// A question with its answer. Field names are those of `findings.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// the model without the trend and the one with it; none where nothing was sampled
    pub models: Vec<ComparedModel>,
    /// by how much the trend predicts runs better, in log density summed over them
    pub gain: Option<f64>,
    /// standard error of the gain, run by run
    pub gain_se: Option<f64>,
    /// the trend; `None` where nothing was sampled
    pub trend: Option<Trend>,
    /// what follows
    pub answer: Answer,
    /// the same in words
    pub text: String,
    /// why it is open, where that is not for what a trend gains
    #[serde(skip)]
    pub why_open: Option<String>,
}

/// How a parameter goes with the logarithm of the film ratio: dL/d ln δ̃ or d ln C/d ln δ̃.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// the runs, in words, of which more would tell most of it
    pub add: Option<String>,
    /// what was believed before, as a scene writes it
    pub prior: String,
    /// the sd of that; `None` where it has none
    #[serde(skip)]
    pub prior_sd: Option<f64>,
    /// why
    pub source: &'static str,
}

/// Whether a parameter goes with the film ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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
                let add = trend.add.as_ref();
                let add = add.map_or(String::new(), |runs| format!(", or more runs of {runs}"));
                return format!(
                    "Whether {symbol} is independent of {film} is open: a trend with the film ({slope}) {moves}; film ratios \
                     farther apart would tell{add}"
                );
            }
            Answer::Rises => "rises",
            Answer::Falls => "falls",
        };
        let gain = match (self.gain, self.gain_se) {
            (Some(gain), Some(se)) => format!(", which gains {} in log density", with_se(gain, se)),
            _ => String::new(),
        };
        format!("{symbol} {goes} with the film: {slope}{gain}")
    }
}
