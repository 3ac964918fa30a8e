//! Says which bootstrap intervals want a second look: few runs, strata that cannot vary, one series alone.

use super::replicates::FEWEST_RUNS;
use super::resampling::{Estimates, Resampling};
use crate::findings::estimate::Bootstrapped;
use crate::findings::remarks;
use crate::remark::{Level, Remark};
use crate::rounding::by_number;
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// What a reader of the replicates should look at.
pub(super) fn bootstrap_notices(
    scene: &Scene,
    runs: &Runs,
    resampling: &Resampling,
    estimates: &Estimates,
) -> Vec<Remark> {
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
        let (level, so) = if scene.bootstrap.interval.is_some() {
            (
                Level::Cautions,
                "the interval that the scene names may be too short for them",
            )
        } else {
            (
                Level::Informs,
                "their interval is that of least squares with Student's t, since resampling so few makes intervals too short",
            )
        };
        let text = format!(
            "{few} of {drawn} bootstrapped fits {} on fewer than {FEWEST_RUNS} runs: {so}",
            by_number(few, "rests", "rest")
        );
        found.push(remarks::BOOTSTRAP_FEW_RUNS.notice(few, text).at(level));
    }
    let partly = runs.series.iter().filter(|series| partly_stuck(runs, series)).count();
    if partly > 0 {
        let text = format!(
            "in {partly} of {} series some runs stuck at speeds at which others rebounded; those left spread less than the \
             noise, which makes intervals of St_c that rest on them too short",
            runs.series.len()
        );
        found.push(remarks::BOOTSTRAP_PARTLY_STUCK.notice(partly, text));
    }
    let single = resampling.single_run_strata;
    if single > 0 {
        let (strata, hold) = (resampling.strata, by_number(single, "holds", "hold"));
        let text = format!("{single} of {strata} strata {hold} a single run, which no resample can vary");
        found.push(remarks::BOOTSTRAP_SINGLE_RUN_STRATA.notice(single, text));
    }
    let alone = fits
        .iter()
        .filter_map(|(_, estimate)| estimate.bootstrap.as_ref())
        .filter(|boot| boot.se.is_none() && boot.replicates == 0)
        .count();
    if alone > 0 {
        let rest = by_number(alone, "fit rests", "fits rest");
        let text =
            format!("{alone} {rest} on one series, for which none can be drawn: the delta interval stands there");
        found.push(remarks::BOOTSTRAP_ONE_SERIES.notice(alone, text));
    }
    found
}

/// Whether a run stuck that was no slower than one that rebounded.
fn partly_stuck(runs: &Runs, series: &Series) -> bool {
    let speeds = |range: &std::ops::Range<usize>| runs.impact_speed[range.clone()].iter().copied();
    let slowest = speeds(&series.rebounds).fold(f64::INFINITY, f64::min);
    speeds(&series.stuck).any(|speed| speed >= slowest)
}
