//! Holds the scatter of the runs against what every interval assumes: normal, of one spread, independent run by run.
//!
//! | file | job |
//! |---|---|
//! | `rows.rs` | the point about which the joint fit is looked at, what each run leaves there, with its slopes, and sums of these |
//! | `scatter.rs` | the scatter about it, found so that outliers do not mislead |
//! | `outliers.rs` | runs that normal noise would hardly ever take so far |
//! | `standard_errors.rs` | by how much they are too small, by unequal spreads of groups and by offsets that series share |
//! | `growth.rs` | whether the noise grows with the impact speed, 1/St or the restitution |
//! | `wet_law.rs` | whether e bends or slopes with v or 1/St, inside a film, as the law does not |
//! | `assumptions.rs` | which assumption of the intervals fails, for the notices |
//!
//! The joint fit is that of the energy balance with the dry law, linearised where least squares ended, with one spread
//! for all dry and one for all wet runs as the likelihood has them. Stuck runs, and rebounds of settings that may stick,
//! are not in it: what is left of a scatter that the limit cuts off has neither its mean nor its spread. Outliers are
//! taken out before spreads and offsets are looked at.

mod assumptions;
mod growth;
mod outliers;
mod rows;
mod scatter;
mod standard_errors;
mod wet_law;

use schemars::JsonSchema;
use serde::Serialize;

use super::balance::EnergyBalance;
use super::wet_fit::FitSetup;
use crate::inference::spreads::equal_spreads;
use crate::physics::Form;
use crate::runs::is_in_even_share;
use crate::scene::LikelihoodFamily;
pub(super) use assumptions::noise_notices;
pub use growth::{GrowthTest, GrowthWith, NoiseGrowth, LINE_OF_BANDS};
pub use outliers::{Outlier, FALSE_ALARM, MOST_DESCRIBED};
use rows::{linearisation_point, Rows, RunKind};
use standard_errors::{test_offsets, test_spreads, unequal_spreads, GroupVariances};
pub use standard_errors::{GroupSpread, Offsets, SpreadTest, StandardErrorRatio, LEVEL, LINE};
pub use wet_law::{WetAlternative, WetLawTest};

/// More runs than this say little new of their scatter: of longer tables the dry runs and about so many wet ones are taken.
const MOST_RUNS: usize = 200_000;

/// What the scatter of the runs is like.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Noise {
    /// runs held against the line for outliers
    pub runs: usize,
    /// outliers in all; 0 where the likelihood is Student's t, which has room for them
    pub outliers_found: usize,
    /// the furthest of them
    pub outliers: Vec<Outlier>,
    /// spreads of the groups; `None` with fewer than two groups of five runs
    pub spread: Option<SpreadTest>,
    /// offsets that series share; `None` where there are no more series than the parameters take up
    pub offsets: Option<Offsets>,
    /// whether the noise grows with what changes from run to run; `None` with fewer than twenty runs of either kind
    pub growth: Option<NoiseGrowth>,
    /// the wet law against what it does not have; `None` where no group has runs to tell
    pub wet_law: Option<WetLawTest>,
}

/// Analyses the scatter about the joint fit; `None` without a fit or without any scatter.
pub(super) fn analyse_noise(setup: FitSetup, balance: Option<&EnergyBalance>, form: Form) -> Option<Noise> {
    let FitSetup { scene, runs, .. } = setup;
    let share = MOST_RUNS as f64 / runs.len().max(1) as f64;
    let some = (share < 1.0).then(|| runs.with_runs(|run| runs.film[run] == 0.0 || is_in_even_share(run, share)));
    let runs = some.as_ref().unwrap_or(runs);
    let (joint, point) = linearisation_point(FitSetup { runs, ..setup }, balance, form);
    let rows = Rows::new(scene, joint, point);
    let tested = outliers::count_tested(&rows);
    let far = outliers::candidate_distance(tested);
    let robust = scatter::fit_robustly(&rows, far)?;
    let of_kind = |kind: RunKind| {
        let all = rows.groups.iter().zip(&robust.residuals);
        all.filter(move |(group, _)| group.kind == kind)
            .map(|(_, own)| own.clone())
    };
    let test = equal_spreads(&mut RunKind::ALL.map(|kind| of_kind(kind).collect()), far);
    let unequal = unequal_spreads(test.as_ref(), &robust.residuals);
    let sorted = outliers::find_outliers(&rows, &robust, unequal.as_deref());
    let variances = GroupVariances::new(&rows, &sorted.sums);
    // where other things scatter, too, the sds of runs without them
    let sds = robust.scatter.map(scatter::Scatter::least);
    let growth = growth::test_growth(&rows, &robust, &sorted);
    let wet_law = wet_law::test_wet_law(&rows, &robust, &sorted);
    let normal = scene.model.likelihood == LikelihoodFamily::Normal;
    let sd_wet = sds[RunKind::Wet as usize];
    Some(Noise {
        runs: tested,
        outliers_found: if normal { sorted.outlying.len() } else { 0 },
        outliers: if normal { sorted.outliers } else { vec![] },
        spread: test_spreads(&rows, &sorted.sums, &variances, test, sds),
        offsets: test_offsets(
            &rows,
            &sorted.sums,
            &variances,
            unequal.is_some(),
            sd_wet * variances.kinds[RunKind::Wet as usize].sqrt(),
        ),
        growth,
        wet_law,
    })
}
