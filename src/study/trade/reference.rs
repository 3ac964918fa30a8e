//! Makes the long run that every method is held against.

use std::time::Instant;

use super::results::{NamedMarginal, Reference};
use super::setup::TradeSetup;
use super::timed::marginal;
use crate::error::Error;
use crate::findings::posterior::{check_room, start};
use crate::findings::Findings;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::nuts::Effort;
use crate::inference::prepared_posterior::{Evaluation, PreparedPosterior, LARGEST_ERROR};
use crate::inference::sampling::sample_by_nuts;
use crate::model::likelihood::Resolution;
use crate::seed::StreamName;

/// Draws a chain of the reference keeps.
const REFERENCE_DRAWS: usize = 25_000;

/// Runs up to which the reference evaluates every row; beyond, nodes to a bound a hundred times the default's.
const REFERENCE_ROWS: usize = 100_000;

impl TradeSetup<'_> {
    /// The long run.
    pub(super) fn reference(&self, least_squares: &Findings) -> Result<Reference, Error> {
        let began = Instant::now();
        let rows = self.rows();
        let evaluation = if self.table.runs.len() <= REFERENCE_ROWS {
            Evaluation::Rows
        } else {
            Evaluation::Compressed(Resolution::Bound(0.01 * LARGEST_ERROR))
        };
        let effort = Effort {
            draws: REFERENCE_DRAWS,
            warmup: self.effort.warmup.max(1000),
            chains: self.effort.chains.max(4),
            ..self.effort
        };
        check_room(effort, self.parameters.dimension())?;
        let fail = |why: String| Error::Usage(format!("no long run to hold the others against: {why}"));
        let start = start(least_squares.least_squares());
        let prepared = PreparedPosterior::new(self.parameters.clone(), &rows, &start, evaluation)
            .map_err(|why| fail(why.to_string()))?;
        let stream = StreamName::new(self.seed, "trade reference");
        let sampled = sample_by_nuts(&prepared, effort, stream, &|_, _| ()).map_err(|why| fail(why.to_string()))?;
        let mut parameters = vec![];
        let (mut mcse_mean, mut mcse_sd, mut rhat) = (0.0, 0.0, 0.0);
        for (parameter, values) in sampled.parameters.sampled.iter().zip(&sampled.values) {
            let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            let found = summarise(&chains);
            let undiagnosed = || {
                fail(format!(
                    "the draws of {} do not tell how far they may be trusted",
                    parameter.name
                ))
            };
            let marginal = marginal(&sampled, values).ok_or_else(undiagnosed)?;
            mcse_mean = f64::max(mcse_mean, found.mcse_mean.ok_or_else(undiagnosed)? / marginal.sd);
            mcse_sd = f64::max(mcse_sd, found.mcse_sd.ok_or_else(undiagnosed)? / marginal.sd);
            rhat = f64::max(rhat, found.rhat.ok_or_else(undiagnosed)?);
            parameters.push(NamedMarginal {
                name: parameter.name.clone(),
                marginal,
            });
        }
        Ok(Reference {
            method: sampled.method.name(),
            chains: effort.chains,
            draws: effort.draws,
            seconds: began.elapsed().as_secs_f64(),
            mcse_mean,
            mcse_sd,
            rhat,
            parameters,
        })
    }
}
