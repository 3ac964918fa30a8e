//! Computes the log density of each series of runs with its offset integrated out, and of each dry run.
//!
//! Over an offset o, normal about 0 with the sd σ_series, the density of a series' runs is integrated by Laplace's method: at
//! its highest o*, with the curvature I of the runs there, it is p(runs | o*) exp(−o*²/(2σ²))/√(1 + σ² I). Of many runs a
//! series, or of noise that is normal far from the threshold, that is exact to rounding.

use std::ops::Range;

use super::{Likelihood, OutsideDomain};
use crate::model::parameters::{offset_slot, ParameterKind};
use crate::runs::Runs;

/// What is left out together where series have offsets: a series, or a dry run.
pub struct SeriesDensities<'r> {
    likelihood: Likelihood,
    runs: &'r Runs,
}

impl<'r> SeriesDensities<'r> {
    /// The runs of a likelihood with offsets.
    pub fn new(likelihood: Likelihood, runs: &'r Runs) -> SeriesDensities<'r> {
        SeriesDensities { likelihood, runs }
    }

    /// Dry runs and series.
    pub fn count(&self) -> usize {
        self.runs.len() - self.runs.wet() + self.runs.series.len()
    }

    /// The runs of one of them.
    pub fn runs_of(&self, unit: usize) -> Range<usize> {
        let dry = self.runs.len() - self.runs.wet();
        match unit.checked_sub(dry) {
            None => unit..unit + 1,
            Some(series) => self.runs.series[series].runs(),
        }
    }

    /// Whether the density of a run is an integral.
    pub fn are_integrals(&self) -> bool {
        self.likelihood.rows.is_integrated()
    }

    /// The log density of each dry run, then of each series, at a full vector of parameters with offsets.
    ///
    /// Fails where the likelihood does.
    pub fn ln_densities(&self, full: &[f64]) -> Result<Vec<f64>, OutsideDomain> {
        let sigma = full[ParameterKind::SigmaSeries.slot()];
        let variance = sigma * sigma;
        let first = offset_slot(self.runs, 0);
        let (at, strengths) = self.likelihood.highest_offsets(full, first..full.len(), variance)?;
        let law = self.likelihood.rows.at(&at);
        let dry = self.runs.len() - self.runs.wet();
        let mut densities: Vec<f64> = (0..dry).map(|run| law.ln_likelihood(run)).collect();
        let each = self.runs.series.iter().zip(strengths).zip(&at[first..]);
        densities.extend(each.map(|((series, strength), offset)| {
            let runs = law.ln_likelihood_of(series.runs());
            runs - 0.5 * offset * offset / variance - 0.5 * (variance * strength).ln_1p()
        }));
        Ok(densities)
    }
}

impl Likelihood {
    /// The full vector with each offset where the density of its series is highest, under a normal of this variance about 0,
    /// and the curvature of its runs there. `offsets` are their places.
    ///
    /// Fails where that is not found.
    pub(in crate::model) fn highest_offsets(
        &self,
        full: &[f64],
        offsets: Range<usize>,
        variance: f64,
    ) -> Result<(Vec<f64>, Vec<f64>), OutsideDomain> {
        /// of Newton's; from an offset of the posterior two do where noise is normal
        const STEPS: usize = 100;
        /// no step is longer, in r
        const LONGEST: f64 = 0.1;
        /// a step of fewer sds is the last
        const STILL: f64 = 1e-4;
        /// far below any spread of a mean, far above rounding
        const NEAR: f64 = 1e-6;
        let mut at = full.to_vec();
        let (mut slopes, mut beyond) = (vec![0.0; full.len()], vec![0.0; full.len()]);
        let mut strengths = vec![0.0; offsets.len()];
        // where the density is known to rise and to fall: near the threshold Newton's steps alone may go back and forth
        let mut between = vec![(f64::NEG_INFINITY, f64::INFINITY); offsets.len()];
        for _ in 0..STEPS {
            self.ln_density(&at, &mut slopes)?;
            at[offsets.clone()].iter_mut().for_each(|offset| *offset += NEAR);
            self.ln_density(&at, &mut beyond)?;
            let mut longest = 0.0;
            for (place, (strength, (low, high))) in offsets.clone().zip(strengths.iter_mut().zip(&mut between)) {
                at[place] -= NEAR;
                *strength = ((slopes[place] - beyond[place]) / NEAR).max(0.0);
                let precision = *strength + 1.0 / variance;
                let rise = slopes[place] - at[place] / variance;
                *(if rise > 0.0 { &mut *low } else { &mut *high }) = at[place];
                let mut next = at[place] + (rise / precision).clamp(-LONGEST, LONGEST);
                if !(*low..=*high).contains(&next) {
                    next = 0.5 * (*low + *high);
                }
                longest = f64::max(longest, (next - at[place]).abs() * precision.sqrt());
                at[place] = next;
            }
            if longest < STILL {
                return Ok((at, strengths));
            }
        }
        Err(OutsideDomain)
    }
}
