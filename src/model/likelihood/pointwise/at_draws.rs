//! Computes the log likelihood of some runs at every one of many draws.

use std::ops::Range;

use rayon::prelude::*;

use super::Pointwise;
use crate::model::likelihood::run_noise::RunNoise;

/// Many draws of the parameters, ready for some runs at a time.
#[derive(Debug)]
pub struct AtDraws<'p> {
    pointwise: &'p Pointwise,
    draws: Vec<Draw<'p>>,
}

/// A draw with what all runs read of it.
#[derive(Debug)]
struct Draw<'p> {
    /// the full vector of parameters
    full: &'p [f64],
    /// of dry and of wet runs
    noise: [RunNoise; 2],
    /// log density of each run given those that share its true speed; empty where none does
    given_the_others: Vec<f64>,
}

impl Pointwise {
    /// The runs at some draws, full vectors of parameters.
    pub fn at_draws<'p>(&'p self, draws: Vec<&'p [f64]>) -> AtDraws<'p> {
        let draw = |full: &'p [f64]| Draw {
            full,
            noise: self.noise_at(full),
            given_the_others: if self.shared.is_empty() {
                vec![]
            } else {
                self.at(full).given_the_others().to_vec()
            },
        };
        AtDraws {
            pointwise: self,
            draws: draws.into_par_iter().map(draw).collect(),
        }
    }
}

impl AtDraws<'_> {
    /// [`EvaluatedLaw::ln_likelihood`](super::EvaluatedLaw::ln_likelihood) of these runs, a row each that is as long as there
    /// are draws.
    pub fn ln_likelihoods(&self, runs: Range<usize>, rows: &mut [f64]) {
        let Some(last) = runs.clone().last() else { return };
        let [first, last] = [runs.start, last].map(|run| self.pointwise.setting[run] as usize);
        for (place, draw) in self.draws.iter().enumerate() {
            let law = self.pointwise.at_settings(draw.full, draw.noise, first..last + 1);
            for (run, row) in runs.clone().zip(rows.chunks_exact_mut(self.draws.len())) {
                row[place] = if self.pointwise.is_shared(run) {
                    draw.given_the_others[run]
                } else {
                    law.ln_likelihood_alone(run)
                };
            }
        }
    }
}
