//! Describes the fits to be bootstrapped and how their runs are divided.

use std::ops::Range;

use super::errors::RunErrors;
use crate::inference::kernel::{self, Sample, WeightedFit};
use crate::inference::regression::Regression;

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
    fn fit(&self, drawn: &Sample) -> WeightedFit {
        match self.errors {
            None => kernel::fit(self.regression.law, drawn, self.fitted),
            Some(errors) => errors.fit(self.regression.law, drawn, self.fitted),
        }
    }
}

/// The runs of a fit, those that follow one another at one abscissa as a single one at their mean: the squares about the
/// mean are no function of the parameters. Runs with measurement errors have no common mean.
pub(super) struct Nodes<'a> {
    target: &'a Target<'a>,
    /// the runs of each node
    runs: Vec<Range<usize>>,
    x: Vec<f64>,
    offset: Vec<f64>,
}

impl<'a> Nodes<'a> {
    pub(super) fn new(target: &'a Target<'a>) -> Nodes<'a> {
        let Regression { x, offset, .. } = target.regression;
        let at = |run: usize| (x[run], offset.get(run));
        let mut runs: Vec<Range<usize>> = vec![];
        for run in 0..x.len() {
            match runs.last_mut() {
                Some(node) if target.errors.is_none() && at(node.start) == at(run) => node.end = run + 1,
                _ => runs.push(run..run + 1),
            }
        }
        let of = |column: &[f64]| runs.iter().filter_map(|node| column.get(node.start)).copied().collect();
        Nodes {
            target,
            x: of(x),
            offset: of(offset),
            runs,
        }
    }

    /// Fits the law to all runs with these weights.
    pub(super) fn fit(&self, weights: &[f64]) -> WeightedFit {
        let (mut restitution, mut of_nodes) = (Vec::with_capacity(self.x.len()), Vec::with_capacity(self.x.len()));
        for node in &self.runs {
            let (own, e) = (
                &weights[node.clone()],
                &self.target.regression.restitution[node.clone()],
            );
            let weight: f64 = own.iter().sum();
            let sum: f64 = own.iter().zip(e).map(|(weight, e)| weight * e).sum();
            // without weight any number does
            restitution.push(if e.len() > 1 && weight > 0.0 {
                sum / weight
            } else {
                e[0]
            });
            of_nodes.push(weight);
        }
        self.target.fit(&Sample {
            offset: &self.offset,
            ..Sample::new(&self.x, &restitution, &of_nodes)
        })
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
