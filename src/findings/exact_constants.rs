//! Says which constant without an uncertainty would widen the main numbers most.

use super::constants::{list_constants, Sensitivity};
use super::estimates::EstimateRow;
use super::main_numbers::MainNumbers;
use super::remarks::{self, BIAS};
use crate::remark::Remark;
use crate::runs::Runs;
use crate::scene::Scene;

/// An error of a constant that nobody would call large.
const ERROR: f64 = 0.01;

/// The constant whose error of 1 % moves some main number by most of its ±, among those whose uncertainty is not given;
/// `None` where no such error would spoil an interval.
pub(super) fn exact_constants_notice(
    scene: &Scene,
    runs: &Runs,
    sensitivities: &[Sensitivity],
    main: &MainNumbers,
) -> Option<Remark> {
    let listed = list_constants(scene, runs);
    let open = listed.iter().filter(|constant| constant.is_open);
    let above = open.filter_map(|constant| {
        // what it does to a main number in ± of that, and as a share of it
        let shifts = sensitivities.iter().flat_map(|result| {
            let moves = result.by.iter().find(|moves| moves.constant == constant.name);
            let share = moves.map_or(0.0, |moves| ERROR * moves.elasticity);
            let in_se = move |row: &EstimateRow| {
                let se = row.number.se.filter(|se| *se > 0.0)?;
                Some((share * row.number.value?).abs() / se)
            };
            let sizes = main.rows().filter(move |row| row.is_result(result)).filter_map(in_se);
            sizes.map(move |in_se| (in_se, share, result))
        });
        let worst = shifts.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (worst.0 > BIAS).then_some((constant, worst))
    });
    let above: Vec<_> = above.collect();
    // of equal ones the first: viscosities are known worse than densities
    let most = above.iter().reduce(|a, b| if b.1 .0 > a.1 .0 { b } else { a })?;
    let (constant, (in_se, share, result)) = most;
    let text = format!(
        "the {} is taken as exact: were it off by {} %, {} would be off by {:.1} %, {:.1} times its ±",
        constant.words,
        100.0 * ERROR,
        result.subject(),
        100.0 * share.abs(),
        in_se
    );
    let next = format!(
        "say how well it is known ({}), and the report adds it; the others stand under Constants taken as exact",
        constant.key
    );
    Some(remarks::CONSTANTS_EXACT.notice(above.len(), text).then(next))
}
