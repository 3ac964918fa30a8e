//! Describes the fits to be bootstrapped and how their runs are divided, and fits one to weighted runs.

use std::ops::Range;

use super::kernel::{self, Failure, Sample, WeightedFit};
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
    /// weights of the runs beside those of resampling; `None`: all alike
    pub run_weights: Option<&'a RunWeights>,
}

/// How the runs of a fit were weighed, which no replicate settles anew.
#[derive(Debug, Clone, PartialEq)]
pub struct RunWeights {
    /// weight of each run, 1 on average but for runs that are left out and have 0
    pub weights: Vec<f64>,
    /// what was taken off the parameters of the fit, and is of those of a replicate
    pub bias: [f64; 2],
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

    /// The strata and series of some targets alone, with these targets on them; runs of the others are not drawn.
    pub fn of_targets<'t>(&self, targets: &[Target<'t>]) -> (Pool, Vec<Target<'t>>) {
        let (strata, place_of_stratum) = kept(&self.strata, targets.iter().map(|target| &target.strata));
        let (series, place_of_series) = kept(&self.series, targets.iter().map(|target| &target.series));
        let moved = |range: &Range<usize>, places: &[usize]| places[range.start]..places[range.end];
        let targets = targets.iter().map(|target| Target {
            strata: moved(&target.strata, &place_of_stratum),
            series: moved(&target.series, &place_of_series),
            ..target.clone()
        });
        (Pool { strata, series }, targets.collect())
    }

    pub(super) fn first_run(&self, target: &Target) -> usize {
        self.strata.get(target.strata.start).map_or(0, |stratum| stratum.start)
    }
}

/// The ranges of runs that some lists of them name, moved together, and how many of those before each are.
fn kept<'a>(ranges: &[Range<usize>], named: impl Iterator<Item = &'a Range<usize>>) -> (Vec<Range<usize>>, Vec<usize>) {
    let mut is_named = vec![false; ranges.len()];
    named.for_each(|range| is_named[range.clone()].fill(true));
    let (mut kept, mut places): (Vec<Range<usize>>, Vec<usize>) = (vec![], vec![]);
    for (range, is_named) in ranges.iter().zip(is_named) {
        places.push(kept.len());
        if is_named {
            let start = kept.last().map_or(0, |last| last.end);
            kept.push(start..start + range.len());
        }
    }
    places.push(kept.len());
    (kept, places)
}

/// Fits a target to weighted restitutions of its runs.
pub(super) fn solve(target: &Target, restitution: &[f64], weights: &[f64]) -> Result<WeightedFit, Failure> {
    let Regression { law, x, offset, .. } = target.regression;
    let sample = Sample {
        offset,
        ..Sample::new(x, restitution, weights)
    };
    let Some(own) = target.run_weights else {
        return kernel::fit(law, &sample, target.fitted);
    };
    let weights: Vec<f64> = weights
        .iter()
        .zip(&own.weights)
        .map(|(drawn, own)| drawn * own)
        .collect();
    let weighted = Sample {
        weights: &weights,
        ..sample
    };
    let fitted = kernel::fit(law, &weighted, target.fitted)?;
    let [a, b] = fitted.parameters;
    Ok(WeightedFit {
        parameters: [a - own.bias[0], b - own.bias[1]],
        ..fitted
    })
}
