//! Describes the fits to be bootstrapped and how their runs are divided.

use std::ops::Range;

use super::errors::RunErrors;
use crate::inference::kernel::{self, Regression, WeightedFit};

/// A fit to be bootstrapped: its runs, in strata, and where it ended.
#[derive(Debug, Clone)]
pub struct Target<'a> {
    /// the law and its runs; a run has the same restitution in every target
    pub regression: Regression<'a>,
    /// the strata, as indices into [`Pool::strata`]; consecutive, and together all of x
    pub strata: Range<usize>,
    /// the series, as indices into [`Pool::series`]; consecutive, and together all of x
    pub series: Range<usize>,
    /// parameters of the fit to the runs themselves
    pub fitted: [f64; 2],
    /// the measurement errors by which the runs are weighed; `None`: all weigh alike
    pub errors: Option<&'a RunErrors>,
}

impl Target<'_> {
    /// Fits the law to what was drawn of the runs.
    pub(super) fn fit(&self, drawn: &Regression) -> WeightedFit {
        match self.errors {
            None => kernel::fit(drawn, self.fitted),
            Some(errors) => errors.fit(drawn, self.fitted),
        }
    }

    /// Fits the law to all runs with these weights.
    pub(super) fn fit_weighted(&self, weights: &[f64]) -> WeightedFit {
        self.fit(&self.regression.weighted(weights))
    }
}

/// How all runs are divided, in the fixed order in which a replicate draws them; ranges of consecutive runs.
#[derive(Debug, Clone, Default)]
pub struct Pool {
    /// runs that may stand for one another
    pub strata: Vec<Range<usize>>,
    /// series (dry: runs of one diameter), each made of whole strata
    pub series: Vec<Range<usize>>,
}

impl Pool {
    /// Strata that cannot vary, since they hold one run.
    pub fn single_runs(&self) -> usize {
        self.strata.iter().filter(|stratum| stratum.len() == 1).count()
    }

    pub(super) fn runs(&self) -> usize {
        self.strata.last().map_or(0, |stratum| stratum.end)
    }

    pub(super) fn first_run(&self, target: &Target) -> usize {
        self.strata.get(target.strata.start).map_or(0, |stratum| stratum.start)
    }
}
