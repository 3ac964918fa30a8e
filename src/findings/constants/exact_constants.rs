//! Says which constant without an uncertainty would widen the results most.

use super::constant::Constant;
use super::sensitivity::Sensitivity;
use crate::findings::checks::BIAS;
use crate::findings::notices::{self, ExactConstant};
use crate::notice::Notice;
use crate::scene::Scene;

/// An error of a constant that nobody would call large.
const ERROR: f64 = 0.01;

/// The constant whose error of 1 % moves some result by most of its standard errors, among those whose uncertainty is
/// not given; `None` where no such error would spoil an interval.
pub(super) fn exact_constants_notice(
    scene: &Scene,
    not_given: &[Constant],
    constants: &[Constant],
    sensitivities: &[(Sensitivity, Vec<f64>)],
) -> Option<Notice> {
    let worst = |constant: &Constant| {
        let column = constants.iter().position(|other| other == constant)?;
        let rows = sensitivities.iter().map(|(sensitivity, elasticities)| {
            let shift = ERROR * elasticities[column];
            let in_se = (shift * sensitivity.value).abs() / sensitivity.scale;
            (in_se, shift, sensitivity)
        });
        let (in_se, shift, sensitivity) = rows.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (in_se > BIAS).then_some((in_se, shift, sensitivity, *constant))
    };
    let above: Vec<(f64, f64, &Sensitivity, Constant)> = not_given.iter().filter_map(worst).collect();
    // of equal ones the first: viscosities are known worse than densities
    let (in_se, shift, sensitivity, constant) = above.iter().reduce(|a, b| if b.0 > a.0 { b } else { a })?;
    Some(notices::constants_exact(&ExactConstant {
        matter: above.len(),
        constant: &constant.words(scene),
        key: constant.key(),
        error: ERROR,
        result: &sensitivity.label(),
        moved: *shift,
        in_se: *in_se,
    }))
}
