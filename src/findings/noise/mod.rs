//! Holds the scatter of the runs against what every interval assumes: normal, of one spread, independent run by run.
//!
//! | file | job |
//! |---|---|
//! | `point.rs` | the point about which the joint fit is looked at |
//! | `rows.rs` | what each run leaves of the joint fit, with its slopes |
//! | `scatter.rs` | the scatter about it, found so that outliers do not mislead |
//! | `normal_equations.rs` | the sums of all runs, put together |
//! | `outliers.rs` | runs that normal noise would hardly ever take so far |
//! | `standard_errors.rs` | by how much standard errors are too small |
//! | `spread.rs` | what unequal spreads of groups do to standard errors |
//! | `offsets.rs` | what offsets that the runs of a series share do to them |
//! | `tell.rs` | which of it wants a second look |
//!
//! The joint fit is that of the energy balance with the dry law, linearised where least squares ended, with one spread
//! for all dry and one for all wet runs as the likelihood has them. Stuck runs, and rebounds of settings that may stick,
//! are not in it: what is left of a scatter that the limit cuts off has neither its mean nor its spread. Outliers are
//! taken out before spreads and offsets are looked at.

mod normal_equations;
mod offsets;
mod outliers;
mod point;
mod rows;
mod scatter;
mod spread;
mod standard_errors;
mod tell;

use serde::Serialize;

use super::balance::EnergyBalance;
use super::dry::FittedDry;
use crate::inference::spreads::equal_spreads;
use crate::physics::Form;
use crate::runs::Runs;
use crate::scene::{Likelihood, Scene};
pub use offsets::Offsets;
pub use outliers::{Outlier, FALSE_ALARM, MOST_TOLD};
use point::Point;
use rows::{Kind, Rows};
pub use spread::{OfGroup, Spreads};
use spread::{Unequal, Variances};
pub use standard_errors::{Lacking, LEVEL, LINE};
pub(super) use tell::notices;

/// What the scatter of the runs is like.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Noise {
    /// runs held against the line for outliers
    pub runs: usize,
    /// outliers in all; 0 where the likelihood is Student's t, which has room for them
    pub outliers_found: usize,
    /// the [`MOST_TOLD`] furthest
    pub outliers: Vec<Outlier>,
    /// spreads of the groups; `None` with fewer than two groups of five runs
    pub spread: Option<Spreads>,
    /// offsets that series share; `None` where there are no more series than the parameters take up
    pub offsets: Option<Offsets>,
}

/// Looks at the scatter about the joint fit; `None` without a fit or without any scatter.
pub(super) fn find(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    balance: Option<&EnergyBalance>,
    form: Form,
) -> Option<Noise> {
    let rows = Rows::new(scene, Point::new(scene, runs, dry, balance, form));
    let tested = outliers::tested(&rows);
    let far = outliers::far(tested);
    let mut settled = scatter::settle(&rows, far)?;
    let mut kinds = Kind::ALL.map(|kind| -> Vec<Vec<f64>> {
        let of_kind = rows
            .groups
            .iter()
            .zip(&settled.residuals)
            .filter(|(group, _)| group.kind == kind);
        of_kind.map(|(_, residuals)| residuals.clone()).collect()
    });
    let test = equal_spreads(&mut kinds, far);
    let unequal = Unequal::of(test.as_ref(), &mut settled.residuals);
    let sorted = outliers::sort(&rows, &settled, unequal.as_ref());
    let variances = Variances::new(&rows, &sorted.sums);
    // where other things scatter, too, the sds of runs without them
    let sds = settled.scatter.map(scatter::Scatter::least);
    let told = scene.model.likelihood == Likelihood::Normal;
    let sd_wet = sds[Kind::Wet as usize];
    Some(Noise {
        runs: tested,
        outliers_found: if told { sorted.found } else { 0 },
        outliers: if told { sorted.outliers } else { vec![] },
        spread: spread::spreads(&rows, &sorted.sums, &variances, test, sds),
        offsets: offsets::offsets(
            &rows,
            &sorted.sums,
            &variances,
            unequal.is_some(),
            sd_wet * variances.kinds[Kind::Wet as usize].sqrt(),
        ),
    })
}
