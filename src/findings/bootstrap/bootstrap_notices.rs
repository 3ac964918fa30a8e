//! Says which bootstrap intervals want a second look: few runs, and runs that partly stuck.

use super::replicates::FEWEST_RUNS;
use super::resampling::Estimates;
use crate::findings::estimate::Bootstrapped;
use crate::findings::remarks;
use crate::remark::{Level, Remark};
use crate::rounding::by_number;
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// What a reader of the replicates should look at.
pub(super) fn bootstrap_notices(scene: &Scene, runs: &Runs, estimates: &Estimates) -> Vec<Remark> {
    let mut found = vec![];
    let drawn = |boot: &Option<Bootstrapped>| boot.as_ref().is_some_and(|boot| boot.replicates > 0);
    let dry = estimates.dry.iter().map(|fit| (fit.dry.runs, &fit.dry.dry_k));
    let series = estimates.series.iter().map(|fit| (fit.runs, &fit.alpha));
    let scaling = estimates.scaling.iter().map(|fit| &fit.scaling);
    let scaling = scaling.map(|fit| (fit.runs, &fit.e_inf));
    let fits = dry.chain(series).chain(scaling);
    let drawn: Vec<_> = fits.filter(|(_, estimate)| drawn(&estimate.bootstrap)).collect();
    let few = drawn.iter().filter(|(runs, _)| *runs < FEWEST_RUNS).count();
    if few > 0 {
        let drawn = drawn.len();
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
    found
}

/// Whether a run stuck that was no slower than one that rebounded.
fn partly_stuck(runs: &Runs, series: &Series) -> bool {
    let speeds = |range: &std::ops::Range<usize>| runs.impact_speed[range.clone()].iter().copied();
    let slowest = speeds(&series.rebounds).fold(f64::INFINITY, f64::min);
    speeds(&series.stuck).any(|speed| speed >= slowest)
}
