//! Measures, on a scene's own runs, what each method for its parameters costs and how far off it is.
//!
//! The methods from the cheapest on: the linear and the square-root law by least squares (`laws.rs`), the normal about the
//! posterior's mode, the same with importance weights, the No-U-Turn sampler. Each is held against a long run of the last.

mod laws;
pub mod report;

use std::time::Instant;

use serde::Serialize;

use crate::error::Error;
use crate::findings;
use crate::findings::posterior::{check_room, effort, start, why_not_sampled};
use crate::inference::accuracy::{monte_carlo_error, normal_error};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::importance::DrawCounts;
use crate::inference::mixing::summary_of;
use crate::inference::nuts::{Effort, SamplingPlan};
use crate::inference::prepared_posterior::PreparedPosterior;
use crate::inference::sampling::{sample_by_importance, sample_by_nuts, sample_normal, Method, Sampled};
use crate::model::likelihood::Likelihood;
use crate::model::parameters::ModelParameters;
use crate::physics::Form;
use crate::runs::Table;
use crate::scene::{Scene, WetLaw};
use crate::seed::StreamName;

pub use crate::report::folder::TRADE_SCHEMA as SCHEMA;
pub use laws::Marginal;

/// What every method was found to cost and to miss. Field names are those of `trade.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trade {
    /// always [`SCHEMA`]
    pub schema: &'static str,
    /// the scene's title
    pub title: String,
    /// version that made this
    pub wetcor: &'static str,
    /// seed of every use of chance
    pub seed: u64,
    /// runs in use
    pub runs: usize,
    /// threads in use
    pub threads: usize,
    /// what the methods are held against
    pub reference: Reference,
    /// the methods, cheapest kind first
    pub methods: Vec<MeasuredMethod>,
}

/// A long run of the No-U-Turn sampler.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// chains
    pub chains: usize,
    /// draws a chain
    pub draws: usize,
    /// largest Monte Carlo error of a mean, in sds
    pub mcse_mean: f64,
    /// largest Monte Carlo error of an sd, relative
    pub mcse_sd: f64,
    /// largest R-hat
    pub rhat: f64,
    /// each parameter
    pub parameters: Vec<NamedMarginal>,
}

/// A parameter by its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedMarginal {
    /// its name in files
    pub name: String,
    /// where it lies
    #[serde(flatten)]
    pub marginal: Marginal,
}

/// What one method costs, and how far off it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredMethod {
    /// its name
    pub name: &'static str,
    /// shortest of up to five times from runs in memory to the parameters, s
    pub seconds: f64,
    /// how far each parameter is off: the mean in posterior sds, the sd relative; `None` where the method gives none
    pub errors: Vec<Option<Marginal>>,
    /// largest error of a mean, in posterior sds
    pub worst_mean: Option<f64>,
    /// largest error of an sd, relative
    pub worst_sd: Option<f64>,
    /// the error its own check vouches for; `None` without draws, or where the check failed
    pub vouched: Option<f64>,
    /// why there is nothing, or why it is not to be trusted
    pub failed: Option<String>,
}

impl MeasuredMethod {
    /// The largest error of a mean or an sd; `None` where the method does not give every parameter.
    pub fn error(&self) -> Option<f64> {
        let whole = self.errors.iter().all(Option::is_some);
        self.worst_mean
            .zip(self.worst_sd)
            .filter(|_| whole)
            .map(|(mean, sd)| mean.max(sd))
    }
}

/// A method that is measured.
#[derive(Debug, Clone, Copy)]
enum Measurable {
    /// read off a law fitted by least squares
    Law(WetLaw),
    /// draws of the posterior
    Draws(Method),
}

const MEASURABLE: [Measurable; 5] = [
    Measurable::Law(WetLaw::Linear),
    Measurable::Law(WetLaw::Sqrt),
    Measurable::Draws(Method::Laplace),
    Measurable::Draws(Method::LaplacePsis),
    Measurable::Draws(Method::Nuts),
];

/// How many steps a measurement has: the long run, and each method.
pub const STEPS: u64 = 1 + MEASURABLE.len() as u64;

/// Measures every method on the runs of a scene. `progress` is called after each step.
///
/// Fails where a prior leaves a parameter no room, where the runs are such that no posterior should be sampled, or where
/// the long run does not come off; the text says why.
pub fn measure(scene: &Scene, table: &Table, seed: u64, progress: &dyn Fn()) -> Result<Trade, Error> {
    let least_squares = findings::fit_least_squares(scene, table, seed, false);
    let setup = TradeSetup {
        scene,
        table,
        seed,
        form: least_squares.form,
        parameters: ModelParameters::of(scene, &table.runs, least_squares.form)?,
        effort: effort(scene),
    };
    if let Some(declined) = why_not_sampled(&table.runs, &least_squares.fits, &setup.parameters) {
        return Err(Error::Usage(format!("nothing to trade: {}", declined.text)));
    }
    let reference = setup.reference()?;
    progress();
    let measured = |method: &Measurable| {
        let found = setup.measure(*method, &reference);
        progress();
        found
    };
    Ok(Trade {
        schema: SCHEMA,
        title: scene.title.clone(),
        wetcor: env!("CARGO_PKG_VERSION"),
        seed,
        runs: table.runs.len(),
        threads: rayon::current_num_threads(),
        methods: MEASURABLE.iter().map(measured).collect(),
        reference,
    })
}

/// What all methods start from.
struct TradeSetup<'t> {
    scene: &'t Scene,
    table: &'t Table,
    seed: u64,
    form: Form,
    parameters: ModelParameters,
    effort: Effort,
}

impl TradeSetup<'_> {
    fn reference(&self) -> Result<Reference, Error> {
        const DRAWS: usize = 25_000;
        let effort = Effort {
            draws: DRAWS,
            warmup: self.effort.warmup.max(1000),
            chains: self.effort.chains.max(4),
            ..self.effort
        };
        check_room(effort, self.parameters.dimension())?;
        let draw = |prepared: &PreparedPosterior| {
            let plan = SamplingPlan::new(effort, StreamName::new(self.seed, "trade reference"));
            sample_by_nuts(prepared, plan, &mut |_| 0).map_err(|why| why.to_string())
        };
        let fail = |why: String| Error::Usage(format!("no long run to hold the others against: {why}"));
        let sampled = self.prepared(draw).map_err(fail)?;
        let mut reference = Reference {
            chains: effort.chains,
            draws: effort.draws,
            mcse_mean: 0.0,
            mcse_sd: 0.0,
            rhat: 0.0,
            parameters: vec![],
        };
        for (parameter, values) in sampled.parameters.sampled.iter().zip(&sampled.values) {
            let name = parameter.name.clone();
            let found = summary_of(values);
            let diagnosed = found.mcse_mean.zip(found.mcse_sd).zip(found.rhat);
            let told = marginal(values).zip(diagnosed);
            let untold = || fail(format!("the draws of {name} do not tell how far they may be trusted"));
            let (marginal, ((mcse_mean, mcse_sd), rhat)) = told.ok_or_else(untold)?;
            reference.mcse_mean = reference.mcse_mean.max(mcse_mean / marginal.sd);
            reference.mcse_sd = reference.mcse_sd.max(mcse_sd / marginal.sd);
            reference.rhat = reference.rhat.max(rhat);
            reference.parameters.push(NamedMarginal { name, marginal });
        }
        Ok(reference)
    }

    /// What a method gives, with the shortest of a few times.
    fn measure(&self, method: Measurable, reference: &Reference) -> MeasuredMethod {
        /// a method is timed so often, one that takes longer than this once, s
        const TIMES: usize = 5;
        const LONG: f64 = 5.0;
        let mut quickest = self.run(method, reference);
        for _ in 1..TIMES {
            if quickest.seconds > LONG {
                break;
            }
            quickest.seconds = quickest.seconds.min(self.run(method, reference).seconds);
        }
        quickest
    }

    fn run(&self, method: Measurable, reference: &Reference) -> MeasuredMethod {
        let began = Instant::now();
        let (marginals, checked) = match method {
            Measurable::Law(law) => {
                let (parameters, inertia) = (&self.parameters, self.form.inertia);
                (
                    laws::marginals(law, self.scene, &self.table.runs, parameters, inertia),
                    Ok(None),
                )
            }
            Measurable::Draws(method) => {
                let drawn = self.prepared(|prepared| self.draw(method, prepared));
                match drawn {
                    Err(why) => (vec![None; reference.parameters.len()], Err(why)),
                    Ok((sampled, own)) => (
                        sampled.values.iter().map(|values| marginal(values)).collect(),
                        own.and_then(|own| Ok(Some(own + vouched_by(&sampled)?))),
                    ),
                }
            }
        };
        let off = |(found, of): (Option<Marginal>, &NamedMarginal)| {
            found.map(|found| Marginal {
                mean: (found.mean - of.marginal.mean) / of.marginal.sd,
                sd: found.sd / of.marginal.sd - 1.0,
            })
        };
        let errors: Vec<Option<Marginal>> = marginals.into_iter().zip(&reference.parameters).map(off).collect();
        let worst = |of: fn(&Marginal) -> f64| errors.iter().flatten().map(|error| of(error).abs()).reduce(f64::max);
        MeasuredMethod {
            name: match method {
                Measurable::Law(law) => law.name(),
                Measurable::Draws(method) => method.name(),
            },
            seconds: began.elapsed().as_secs_f64(),
            worst_mean: worst(|error| error.mean),
            worst_sd: worst(|error| error.sd),
            errors,
            vouched: checked.clone().unwrap_or_default(),
            failed: checked.err(),
        }
    }

    /// Draws by a method, and the error of its own that does not show in them.
    fn draw(&self, method: Method, prepared: &PreparedPosterior) -> Result<(Sampled, Result<f64, String>), String> {
        let stream = StreamName::new(self.seed, "trade");
        let size = DrawCounts {
            chains: self.effort.chains,
            draws: self.effort.draws,
        };
        Ok(match method {
            Method::Laplace => {
                let error = normal_error(prepared, stream);
                (sample_normal(prepared, size, stream), error.map(|error| error.largest))
            }
            Method::LaplacePsis => {
                let sampled = sample_by_importance(prepared, size, stream);
                (sampled.ok_or("the densities allow no weights")?, Ok(0.0))
            }
            Method::Nuts => {
                let sampled = sample_by_nuts(prepared, SamplingPlan::new(self.effort, stream), &mut |_| 0);
                (sampled.map_err(|why| why.to_string())?, Ok(0.0))
            }
        })
    }

    /// What is drawn from the posterior as least squares and the search for the mode prepare it.
    fn prepared<T>(&self, draw: impl Fn(&PreparedPosterior) -> Result<T, String>) -> Result<T, String> {
        let least_squares = findings::fit_least_squares(self.scene, self.table, self.seed, false);
        let likelihood = Likelihood::new(self.scene, &self.table.runs, self.form);
        let start = start(&least_squares.fits);
        let prepared = PreparedPosterior::new(self.parameters.clone(), &likelihood, &start);
        draw(&prepared.map_err(|why| why.to_string())?)
    }
}

/// The error that draws vouch for, or why none.
fn vouched_by(sampled: &Sampled) -> Result<f64, String> {
    let khat = sampled.khat.filter(|khat| *khat > khat_threshold(sampled.draws()));
    match khat {
        Some(khat) => Err(format!("importance weights have the shape {khat:.2}")),
        None => Ok(monte_carlo_error(sampled)),
    }
}

fn marginal(values: &[Vec<f64>]) -> Option<Marginal> {
    let found = summary_of(values);
    Some(Marginal {
        mean: found.mean?,
        sd: found.sd.filter(|sd| *sd > 0.0)?,
    })
}
