//! Says which bootstrap intervals want a second look: few runs, strata that cannot vary, one series alone.

use super::replicates::FEWEST_RUNS;
use super::resampling::{Estimates, Resampling};
use crate::findings::estimate::Bootstrapped;
use crate::findings::notices;
use crate::notice::Notice;
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// What a reader of the replicates should look at.
pub(super) fn bootstrap_notices(
    scene: &Scene,
    runs: &Runs,
    resampling: &Resampling,
    estimates: &Estimates,
) -> Vec<Notice> {
    let mut found = vec![];
    let drawn = |boot: &Option<Bootstrapped>| boot.as_ref().is_some_and(|boot| boot.replicates > 0);
    let dry = estimates.dry.iter().map(|fit| (fit.dry.runs, &fit.dry.dry_k));
    let series = estimates.series.iter().map(|fit| (fit.runs, &fit.alpha));
    let scaling = estimates
        .scaling
        .iter()
        .map(|fit| (fit.scaling.runs, &fit.scaling.e_inf));
    let fits: Vec<_> = dry.chain(series).chain(scaling).collect();
    let few = fits
        .iter()
        .filter(|(runs, estimate)| *runs < FEWEST_RUNS && drawn(&estimate.bootstrap))
        .count();
    if few > 0 {
        let drawn = fits.iter().filter(|(_, estimate)| drawn(&estimate.bootstrap)).count();
        found.push(notices::bootstrap_few_runs(
            few,
            drawn,
            FEWEST_RUNS,
            scene.bootstrap.interval.is_some(),
        ));
    }
    let partly = runs.series.iter().filter(|series| partly_stuck(runs, series)).count();
    if partly > 0 {
        found.push(notices::bootstrap_partly_stuck(partly, runs.series.len()));
    }
    let single = resampling.single_run_strata;
    if single > 0 {
        found.push(notices::bootstrap_single_run_strata(single, resampling.strata));
    }
    let alone = fits
        .iter()
        .filter_map(|(_, estimate)| estimate.bootstrap.as_ref())
        .filter(|boot| boot.se.is_none() && boot.replicates == 0)
        .count();
    if alone > 0 {
        found.push(notices::bootstrap_one_series(alone));
    }
    found
}

/// Whether a run stuck that was no slower than one that rebounded.
fn partly_stuck(runs: &Runs, series: &Series) -> bool {
    let speeds = |range: &std::ops::Range<usize>| runs.impact_speed[range.clone()].iter().copied();
    let slowest = speeds(&series.rebounds).fold(f64::INFINITY, f64::min);
    speeds(&series.stuck).any(|speed| speed >= slowest)
}
