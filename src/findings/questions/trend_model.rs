//! Samples the model with a trend beside the scene's own: whether the trend is there, and how far it moves what is quoted.

use super::question::{answer_question, Question, Trend};
use crate::error::Error;
use crate::findings::compare::model_name;
use crate::findings::left_out::{largest_rhat, why_none_beside, ComparisonContext, Model};
use crate::findings::posterior::Posterior;
use crate::inference::mixing::summary_of;
use crate::inference::sampling::Sampled;
use crate::model::likelihood::trend::middle_film_ratio;
use crate::model::parameters::{physical, ModelParameters, ParameterKind};
use crate::physics::balance::Balance;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::Coefficient;
use crate::runs::{Runs, Series};

/// A film ratio counts with so many runs: fewer hardly have a mean and a spread.
const FEWEST_RUNS: usize = 5;

/// Chains that differ by more than this tell nothing; the stricter line of the posterior is one for quoting its numbers.
const RHAT: f64 = 1.05;

/// What the questions are answered from.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// what models are drawn from, with every run
    pub comparison: ComparisonContext<'a>,
    /// the scene's own model, sampled on every run
    pub own: &'a Posterior,
}

/// The scene's model of some runs with a trend.
pub(super) struct TrendModel<'a> {
    pub context: Context<'a>,
    pub runs: &'a Runs,
    pub trend: ParameterKind,
    /// what has the trend
    pub of: ParameterKind,
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
        let Context { comparison, own } = self.context;
        let scene = comparison.scene;
        if let Some(why) = why_none_beside(scene, comparison.runs, own.sampled.draws()) {
            return Ok(question.open(&why));
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
            Ok((trend, doubt)) => answer_question(question, trend, doubt),
            Err(why) => question.open(&why),
        })
    }

    /// The trend, and why nothing can be built on it; `Err` says why none is sampled.
    fn sampled(&self, parameters: ModelParameters) -> Result<(Trend, Option<String>), String> {
        let setup = self.context.own.setup;
        let context = ComparisonContext {
            runs: self.runs,
            ..self.context.comparison
        };
        let stream = format!("question {} trend", self.of.key());
        let parameters = parameters.with_trend(self.trend);
        let model = Model {
            context,
            setup,
            parameters: &parameters,
            stream: &stream,
        };
        let bent = model.draw(self.runs, &stream, |_| false)?;
        let trend = self.trend(&bent).ok_or("the trend has no draws")?;
        let doubt = largest_rhat(&bent).filter(|rhat| *rhat > RHAT).map(|rhat| {
            let name = format!("{}+{}", model_name(setup.form), self.trend.key());
            format!("the chains of {name} do not agree (R-hat {rhat:.2})")
        });
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
        let (scene, form) = (self.context.comparison.scene, self.context.own.setup.form);
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
