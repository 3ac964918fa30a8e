//! Answers what the paper leaves open about the film: is L constant where films are thin, is C at every film ratio?
//!
//! The scene's model is sampled with a trend: whether that is there, and how far it moves what is quoted.

use schemars::JsonSchema;
use serde::Serialize;

use super::compare::model_name;
use super::left_out::{largest_rhat, why_none_beside, ComparisonContext, Model};
use super::posterior::Posterior;
use super::remarks::{self, CLEAR_TREND};
use crate::error::Error;
use crate::inference::mixing::summary_of;
use crate::inference::sampling::Sampled;
use crate::model::likelihood::trend::middle_film_ratio;
use crate::model::parameters::{physical, ModelParameters, ParameterKind};
use crate::physics::balance::Balance;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::Coefficient;
use crate::remark::Remark;
use crate::rounding::with_se;
use crate::runs::{Runs, Series};

/// The paper takes L as constant for film ratios below this one (text of its summary).
pub const THIN: f64 = 0.10;

/// Both questions, in the order of the paper's text, and whether a trend that was seen forbids quoting.
///
/// Fails where a prior leaves a parameter no room.
pub fn answer_questions(comparison: ComparisonContext, own: &Posterior) -> Result<(Vec<Question>, Vec<Remark>), Error> {
    let questions = vec![
        is_lubrication_constant(comparison, own, THIN)?,
        is_prefactor_constant(comparison, own)?,
    ];
    let checks = questions.iter().filter_map(check_trend).collect();
    Ok((questions, checks))
}

/// Whether one L holds for the runs with film ratios below a line, under the scene's own form.
pub fn is_lubrication_constant(comparison: ComparisonContext, own: &Posterior, below: f64) -> Result<Question, Error> {
    let model = TrendModel {
        comparison,
        own,
        runs: &comparison.runs.with_films_below(below),
        trend: ParameterKind::LubricationTrend,
        of: ParameterKind::LUBRICATION_LOG,
    };
    model.answer("Is L the same at every film ratio below 0.10?", Some(below))
}

/// Whether one C holds for all runs, under the scene's own form.
pub fn is_prefactor_constant(comparison: ComparisonContext, own: &Posterior) -> Result<Question, Error> {
    let model = TrendModel {
        comparison,
        own,
        runs: comparison.runs,
        trend: ParameterKind::InertialTrend,
        of: ParameterKind::INERTIAL_PREFACTOR,
    };
    model.answer("Is C the same at every film ratio?", None)
}

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
    /// The same, answered by a trend, if any, or left open for a reason.
    fn answered(mut self, trend: Option<Trend>, why_open: Option<String>) -> Question {
        self.answer = match (&trend, &why_open) {
            (Some(trend), None) => conclude(trend),
            _ => Answer::Open,
        };
        (self.trend, self.why_open) = (trend, why_open);
        self.text = self.told(None);
        self
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
fn check_trend(question: &Question) -> Option<Remark> {
    let check = remarks::FILM_TREND.check(question.trend.as_ref()?.sds_from_zero(), question.text.as_str());
    Some(Remark {
        passed: !matches!(question.answer, Answer::Rises | Answer::Falls),
        ..check
    })
}

/// A film ratio counts with so many runs: fewer hardly have a mean and a spread.
const FEWEST_RUNS: usize = 5;

/// Chains that differ by more than this tell nothing; the stricter line of the posterior is one for quoting its numbers.
const RHAT: f64 = 1.05;

/// The scene's model of some runs with a trend.
struct TrendModel<'a> {
    /// what models are drawn from, with every run
    comparison: ComparisonContext<'a>,
    /// the scene's own model, sampled on every run
    own: &'a Posterior,
    runs: &'a Runs,
    trend: ParameterKind,
    /// what has the trend
    of: ParameterKind,
}

impl TrendModel<'_> {
    /// The question, of runs with film ratios below a line or of all, with its answer; it stays open, with the reason, where
    /// the runs or the form allow none.
    pub fn answer(&self, question: &'static str, film_ratio_below: Option<f64>) -> Result<Question, Error> {
        let mut question = Question {
            question,
            parameter: self.of.key(),
            film_ratio_below,
            ..Question::default()
        };
        let TrendModel { comparison, own, .. } = *self;
        let scene = comparison.scene;
        if let Some(why) = why_none_beside(scene, comparison.runs, own.sampled.draws()) {
            return Ok(question.answered(None, Some(why)));
        }
        let counted = film_ratios(self.runs, scene.data.film_ratio_gap);
        (question.runs, question.film_ratios) = (self.runs.wet(), Some(counted));
        let parameters = ModelParameters::of(scene, self.runs, own.setup.form)?;
        let below = film_ratio_below.map_or(String::new(), |below| format!(" below {below:.2}"));
        let why_open = match (parameters.place(self.of), counted) {
            (None, _) => {
                let left = parameters.left_out.iter().find(|left| left.kind == self.of);
                let lacks = match self.of {
                    ParameterKind::LUBRICATION_LOG => {
                        "L belongs to each film and diameter in this form of the viscous loss"
                    }
                    _ => "the model holds no inertial loss",
                };
                Some(left.map_or(lacks, |left| left.reason).to_owned())
            }
            (_, 0) => Some(format!("no film ratio{below} has {FEWEST_RUNS} runs")),
            (_, 1) => Some(format!("one film ratio{below} tells no trend; add another")),
            _ => None,
        };
        Ok(match why_open.map_or_else(|| self.sampled(parameters), Err) {
            Ok((trend, doubt)) => question.answered(Some(trend), doubt),
            Err(why) => question.answered(None, Some(why)),
        })
    }

    /// The trend, and why nothing can be built on it; `Err` says why none is sampled.
    fn sampled(&self, parameters: ModelParameters) -> Result<(Trend, Option<String>), String> {
        let setup = self.own.setup;
        let context = ComparisonContext {
            runs: self.runs,
            ..self.comparison
        };
        let stream = format!("question {} trend", self.of.key());
        let parameters = parameters.with_trend(self.trend);
        let model = Model {
            context,
            setup,
            parameters: &parameters,
            stream: &stream,
        };
        let bent = model.draw(self.runs, &stream, None)?;
        let trend = self.trend(&bent).ok_or("the trend has no draws")?;
        let doubt = largest_rhat(&bent).filter(|rhat| *rhat > RHAT).map(|rhat| {
            let name = format!("{}+{}", model_name(setup.form), self.trend.key());
            format!("the chains of {name} do not agree (R-hat {rhat:.2})")
        });
        let doubt = doubt.or_else(|| untold(&trend));
        Ok((trend, doubt))
    }

    fn trend(&self, sampled: &Sampled) -> Option<Trend> {
        let place = sampled.parameters.place(self.trend)?;
        let parameter = &sampled.parameters.sampled[place];
        let found = summary_of(&sampled.values[place]);
        let interval = [found.q025?, found.q975?];
        let change = self.largest_change(sampled, interval)?;
        Some(Trend {
            symbol: parameter.kind.symbol(),
            mean: found.mean?,
            sd: found.sd?,
            interval,
            largest_change: Some(change).filter(|change| change.is_finite()),
            prior: parameter.prior.text(),
            prior_sd: parameter.prior.sd(),
            source: parameter.source,
        })
    }

    /// The largest change of an e_inf or a St_c at a film ratio of the runs, as a share of it, with the trend at either end of
    /// an interval in place of none, the parameters at their posterior means; infinite where one of them ceases to be. `None`
    /// without draws, or where what has the trend is no coefficient of the balance.
    fn largest_change(&self, sampled: &Sampled, interval: [f64; 2]) -> Option<f64> {
        let (scene, form) = (self.comparison.scene, self.own.setup.form);
        let ParameterKind::Shared(of) = self.of else {
            return None;
        };
        let mean = |values: &Vec<Vec<f64>>| {
            let draws: usize = values.iter().map(Vec::len).sum();
            values.iter().flatten().sum::<f64>() / draws as f64
        };
        let means: Vec<f64> = sampled.values.iter().map(mean).collect();
        if !means.iter().all(|mean| mean.is_finite()) {
            return None;
        }
        let (full, middle) = (sampled.parameters.full(&means), middle_film_ratio(self.runs));
        // e_inf and St_c
        let quoted = |series: &Series, trend: f64| {
            let f = (series.film / series.diameter / middle).ln();
            let value = full[of as usize];
            let moved = match of {
                Coefficient::LubricationLog => value + trend * f,
                _ => value * (trend * f).exp(),
            };
            let setting = series.setting(scene);
            let balance = Balance::new(form, setting.of_film(), &physical(&full, series.sphere).with(of, moved));
            let e_inf = balance.e_inf(scene.model.dry_speed.reference());
            let l = balance.lost.over_stokes + form.fixed_over_stokes(&setting);
            let wetted = Wetted::of_balance(e_inf, l);
            [Quantity::EInf, Quantity::StC].map(|quantity| quantity.value(&Place::NONE, &wetted))
        };
        let mut largest: f64 = 0.0;
        for series in &self.runs.series {
            let plain = quoted(series, 0.0);
            for trend in interval {
                for (moved, plain) in quoted(series, trend).into_iter().zip(plain) {
                    let change = (moved / plain - 1.0).abs();
                    // what is not there without the trend either cannot be moved
                    if !plain.is_nan() {
                        largest = largest.max(if change.is_nan() { f64::INFINITY } else { change });
                    }
                }
            }
        }
        Some(largest)
    }
}

/// Film ratios that differ by more than the gap and have runs enough, whatever groups they were put in.
fn film_ratios(runs: &Runs, gap: f64) -> usize {
    let wet = runs.series.iter().flat_map(|series| series.runs());
    let mut ratios: Vec<f64> = wet.map(|run| runs.film[run] / runs.diameter[run]).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let mut rest = &ratios[..];
    let mut counted = 0;
    while let Some(first) = rest.first() {
        let same = rest.partition_point(|ratio| *ratio <= first + gap);
        counted += usize::from(same >= FEWEST_RUNS);
        rest = &rest[same.max(1)..];
    }
    counted
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

    #[test]
    fn film_ratios_are_counted_where_enough_runs_have_them() {
        let of = |ratios: &[(f64, usize)]| {
            let film: Vec<f64> = ratios.iter().flat_map(|(ratio, runs)| vec![*ratio; *runs]).collect();
            let n = film.len();
            let runs = Runs {
                diameter: vec![1.0; n],
                film,
                series: vec![Series {
                    particle: 0,
                    sphere: 0,
                    liquid: 0,
                    diameter: 1.0,
                    film: 0.1,
                    film_ratio: 0.1,
                    rebounds: 0..n,
                    stuck: n..n,
                }],
                ..Runs::default()
            };
            film_ratios(&runs, 0.004)
        };
        assert_eq!(of(&[]), 0);
        assert_eq!(of(&[(0.03, 4)]), 0);
        assert_eq!(of(&[(0.03, 5), (0.032, 5)]), 1);
        assert_eq!(of(&[(0.03, 5), (0.06, 4), (0.09, 70)]), 2);
        // films without nominal values: one group by its gaps, several film ratios all the same
        let spread: Vec<(f64, usize)> = (0..60).map(|i| (0.03 + 0.001 * f64::from(i), 2)).collect();
        assert_eq!(of(&spread), 12);
    }
}
