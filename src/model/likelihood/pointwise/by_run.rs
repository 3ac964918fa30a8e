//! Computes the log likelihood of each of some runs at every one of many draws.

use std::ops::Range;

use rayon::prelude::*;

use super::{EvaluatedLaw, NoiseSd, Pointwise};
use crate::model::likelihood::tails::Tails;
use crate::model::parameters::ParameterKind;

/// Many draws of the parameters, ready for some runs at a time.
#[derive(Debug)]
pub struct AtDraws<'p, 'r> {
    pointwise: &'p Pointwise<'r>,
    /// full vectors of parameters
    draws: Vec<&'p [f64]>,
    /// of dry runs at each draw
    dry: Vec<NoiseSd>,
    /// of wet runs
    wet: Vec<NoiseSd>,
    /// the law at each draw, where runs are not plain
    laws: Vec<EvaluatedLaw<'p, 'r>>,
}

impl<'r> Pointwise<'r> {
    /// The runs at some draws, full vectors of parameters.
    pub fn at_draws<'p>(&'p self, draws: Vec<&'p [f64]>) -> AtDraws<'p, 'r> {
        let spreads = |kind: ParameterKind| draws.iter().map(|full| NoiseSd::of(full[kind.slot()])).collect();
        AtDraws {
            pointwise: self,
            dry: spreads(ParameterKind::SigmaDry),
            wet: spreads(ParameterKind::SigmaWet),
            laws: if self.is_plain() {
                vec![]
            } else {
                draws.par_iter().map(|full| self.at(full)).collect()
            },
            draws,
        }
    }
}

impl AtDraws<'_, '_> {
    /// Draws.
    pub fn len(&self) -> usize {
        self.draws.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.draws.is_empty()
    }

    /// [`EvaluatedLaw::ln_likelihood`] of these runs, a row each that is as long as there are draws.
    pub fn ln_likelihoods(&self, runs: Range<usize>, rows: &mut [f64]) {
        let rows = rows.chunks_exact_mut(self.len().max(1));
        if !self.pointwise.is_plain() {
            for (run, row) in runs.zip(rows) {
                for (value, law) in row.iter_mut().zip(&self.laws) {
                    *value = law.ln_likelihood(run);
                }
            }
            return;
        }
        let setting = &self.pointwise.setting[runs.clone()];
        let Some((first, last)) = setting.first().zip(setting.last()) else {
            return;
        };
        let means = self.means(*first as usize..*last as usize + 1);
        for ((run, row), setting) in runs.zip(rows).zip(setting) {
            let place = (setting - first) as usize * self.len();
            self.fill(run, &means[place..place + self.len()], row);
        }
    }

    /// The mean of e* at these settings, a row each.
    fn means(&self, settings: Range<usize>) -> Vec<f64> {
        let settings = &self.pointwise.settings[settings];
        let mut means = vec![0.0; settings.len() * self.len()];
        for (draw, full) in self.draws.iter().enumerate() {
            // the losses of a film are computed once for the settings that share it
            let mut mean = self.pointwise.means(full);
            let column = means.iter_mut().skip(draw).step_by(self.len());
            for (into, setting) in column.zip(settings) {
                *into = mean(setting);
            }
        }
        means
    }

    /// A plain run at every draw.
    fn fill(&self, run: usize, means: &[f64], row: &mut [f64]) {
        let spreads = if run < self.pointwise.dry { &self.dry } else { &self.wet };
        let draws = row.iter_mut().zip(means).zip(spreads);
        if self.pointwise.stuck[run] {
            for ((value, mean), spread) in draws {
                let z = (self.pointwise.limit - mean) / spread.sigma;
                *value = Tails::Normal.ln_probability_and_slope(z).0;
            }
        } else {
            let restitution = self.pointwise.runs.restitution[run];
            for ((value, mean), spread) in draws {
                let z = (restitution - mean) / spread.sigma;
                *value = Tails::Normal.ln_unit_density(z) - spread.ln;
            }
        }
    }
}
