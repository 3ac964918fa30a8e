//! Runs one method for the parameters and times it.

use std::time::Instant;

use super::laws::{by_law, TradeLaws};
use super::methods::TradedMethod;
use super::results::Marginal;
use super::setup::TradeSetup;
use crate::findings::estimate::Quoting;
use crate::findings::posterior::start;
use crate::findings::{self, dry, energy, scaling};
use crate::inference::accuracy::{monte_carlo_error, normal_error};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::importance::DrawCounts;
use crate::inference::nuts::Effort;
use crate::inference::prepared_posterior::{Evaluation, PreparedPosterior, LARGEST_ERROR};
use crate::inference::sampling::{sample_by_nuts, sample_normal, Method, Sampled};
use crate::inference::weighing::sample_by_importance;
use crate::model::likelihood::Resolution;
use crate::scene::WetLaw;
use crate::seed::StreamName;

/// Times each method is timed; the shortest counts.
const TIMED: usize = 5;

/// Methods longer than this are timed once, s.
const LONG: f64 = 5.0;

/// What a method answers, before it is held against the reference.
pub(super) struct MethodAnswer {
    pub(super) marginals: Vec<Option<Marginal>>,
    pub(super) nodes: Option<usize>,
    pub(super) effective: Option<f64>,
    pub(super) vouched: Option<f64>,
    pub(super) failed: Option<String>,
}

impl TradeSetup<'_> {
    /// The shortest of a few times, and what came out each time.
    pub(super) fn timed(&self, path: TradedMethod) -> (f64, MethodAnswer) {
        let mut shortest = f64::INFINITY;
        let mut again = 1;
        loop {
            let began = Instant::now();
            let answer = self.go(path);
            let seconds = began.elapsed().as_secs_f64();
            shortest = shortest.min(seconds);
            if again == TIMED || seconds > LONG {
                return (shortest, answer);
            }
            again += 1;
        }
    }

    fn go(&self, path: TradedMethod) -> MethodAnswer {
        match path {
            TradedMethod::Law(law) => self.read_off(law),
            TradedMethod::Laplace | TradedMethod::LaplacePsis => {
                self.on_nodes(Evaluation::default(), |prepared, size, stream| match path {
                    TradedMethod::Laplace => Ok(sample_normal(prepared, size, stream)),
                    _ => {
                        sample_by_importance(prepared, size, stream).ok_or("the densities allow no weights".to_owned())
                    }
                })
            }
            TradedMethod::Nuts(evaluation) => self.on_nodes(evaluation, |prepared, size, stream| {
                let effort = Effort {
                    draws: size.draws,
                    ..self.effort
                };
                sample_by_nuts(prepared, effort, stream, &|_, _| ()).map_err(|why| why.to_string())
            }),
        }
    }

    fn read_off(&self, law: WetLaw) -> MethodAnswer {
        let (scene, runs) = (self.scene, &self.table.runs);
        let quoting = Quoting {
            level: scene.bootstrap.level,
        };
        let dry = dry::fit_dry_laws(scene, runs, quoting);
        let scaling = scaling::fit_scaling(scene, runs, &dry, quoting);
        let energy = energy::estimate_energy(scene, runs, &dry, &scaling, quoting);
        let fits = TradeLaws {
            dry: &dry,
            scaling: &scaling,
            energy: &energy,
        };
        MethodAnswer {
            marginals: by_law(law, &self.parameters, self.model.form.inertia, &fits),
            nodes: None,
            effective: None,
            vouched: None,
            failed: None,
        }
    }

    fn on_nodes(
        &self,
        evaluation: Evaluation,
        draw: impl Fn(&PreparedPosterior, DrawCounts, StreamName) -> Result<Sampled, String>,
    ) -> MethodAnswer {
        let least_squares = findings::fit_least_squares(self.scene, self.table, self.seed, false);
        let rows = self.rows();
        let start = start(least_squares.least_squares());
        let size = DrawCounts {
            chains: self.effort.chains,
            draws: self.effort.draws,
        };
        let stream = StreamName::new(self.seed, "trade");
        let sampled = PreparedPosterior::new(self.parameters.clone(), &rows, &start, evaluation)
            .map_err(|why| why.to_string())
            .and_then(|prepared| {
                let sampled = draw(&prepared, size, stream)?;
                // a normal's own error does not show in its draws
                let off = match sampled.method {
                    Method::Laplace => normal_error(&prepared, stream).map(|error| error.largest),
                    _ => Ok(0.0),
                };
                Ok((sampled, off))
            });
        let (sampled, off) = match sampled {
            Ok(sampled) => sampled,
            Err(why) => {
                return MethodAnswer {
                    marginals: vec![None; self.parameters.sampled.len()],
                    nodes: None,
                    effective: None,
                    vouched: None,
                    failed: Some(why),
                }
            }
        };
        let khat = sampled.khat.filter(|khat| *khat > khat_threshold(sampled.draws()));
        let unbounded = matches!(evaluation, Evaluation::Compressed(Resolution::Nodes(_)));
        let breach = sampled
            .checked_error
            .filter(|error| *error > sampled.bound.unwrap_or(LARGEST_ERROR));
        let failed = match (khat, breach, &off) {
            (Some(khat), _, _) => Some(format!("importance weights have the shape {khat:.2}")),
            (_, Some(error), _) => Some(format!("the nodes' log density is off by up to {error:.2}")),
            (_, _, Err(why)) => Some(why.clone()),
            _ => None,
        };
        let effective = sampled.values.iter().filter_map(|values| {
            let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            summarise(&chains).ess_bulk
        });
        let effective = effective.fold(f64::INFINITY, f64::min) / (sampled.mcse_factor * sampled.mcse_factor);
        let vouched = monte_carlo_error(&sampled) + off.unwrap_or(0.0);
        MethodAnswer {
            marginals: sampled.values.iter().map(|values| marginal(&sampled, values)).collect(),
            nodes: sampled.compression.map(|made| made.nodes),
            effective: Some(effective).filter(|effective| effective.is_finite()),
            vouched: Some(vouched).filter(|_| failed.is_none() && !unbounded),
            failed,
        }
    }
}

pub(super) fn marginal(sampled: &Sampled, values: &[Vec<f64>]) -> Option<Marginal> {
    debug_assert!(!sampled.chains.is_empty());
    let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let found = summarise(&chains);
    Some(Marginal {
        mean: found.mean?,
        sd: found.sd.filter(|sd| *sd > 0.0)?,
        q05: found.q05?,
        q95: found.q95?,
    })
}
