//! Says which constant without an uncertainty would widen the results most.

use super::constant::{Constant, InUse, Kind};
use super::sensitivity::Sensitivity;
use crate::findings::checks::BIAS;
use crate::notice::Notice;
use crate::scene::Scene;

/// An error of a constant that nobody would call large.
const ERROR: f64 = 0.01;

/// The constant whose error of 1 % moves some result by most of its standard errors, among those whose uncertainty the
/// scene does not give; `None` where no such error would spoil an interval.
pub(super) fn notice(
    scene: &Scene,
    in_use: &InUse,
    kinds: &[Kind],
    constants: &[Constant],
    told: &[(Sensitivity, Vec<f64>)],
) -> Option<Notice> {
    let open: Vec<Constant> = kinds.iter().flat_map(|kind| kind.not_given(in_use, scene)).collect();
    let worst = |constant: &Constant| {
        let column = constants.iter().position(|other| other == constant)?;
        let rows = told.iter().map(|(sensitivity, elasticities)| {
            let moved = ERROR * elasticities[column];
            let in_se = (moved * sensitivity.value).abs() / sensitivity.se;
            (in_se, moved, sensitivity)
        });
        let (in_se, moved, sensitivity) = rows.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (in_se > BIAS).then_some((in_se, moved, sensitivity, *constant))
    };
    let above: Vec<(f64, f64, &Sensitivity, Constant)> = open.iter().filter_map(worst).collect();
    // of equal ones the first: viscosities are known worse than densities
    let (in_se, moved, sensitivity, constant) = above.iter().reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    Some(Notice::new(
        "constants_exact",
        above.len(),
        format!(
            "the {} is taken as exact: were it off by {} %, {} would be off by {:.1} %, {:.1} times its ±, which is of \
             the runs alone",
            constant.words(scene),
            100.0 * ERROR,
            sensitivity.label(),
            100.0 * moved.abs(),
            in_se
        ),
        format!(
            "say how well it is known ({}), and the report adds it; the others stand under Constants taken as exact",
            constant.key()
        ),
    ))
}
