//! Tells a standard deviation from a standard error, and both from other spreads and from the quantities themselves.

use super::super::words::{is_among, words_of};
use super::header::{Header, Instead, MEASURED};
use super::units::in_brackets;
use crate::scene::RunColumn;

/// Words for a standard deviation, and for a standard error.
const SPREADS: [&str; 2] = [
    "sd std stdev stdv stddev stabw standardabweichung écarttype σ",
    "se sem stderr standardfehler",
];

/// Words for a spread that is neither.
const OTHER_SPREADS: &str = "var variance varianz cv rsd ci ci95 u95 confidence konfidenzintervall expanded erweiterte fwhm mad iqr range spannweite";

/// A spread that a header names where its column takes another, or the quantity itself.
pub(super) fn other_spread(header: &Header, column: RunColumn) -> Option<Instead> {
    use RunColumn::{Diameter, Film, ImpactSpeedSd, ReboundSpeedSd, RestitutionSd, RestitutionSdOfRuns, RestitutionSe};
    let has = |list: &str| header.has(list);
    let of_mean = header.lower.contains("of the mean") || header.contains("√ sqrt") || has("mittelwerts");
    let is_error = has("err error errors fehler erreur") && (has("standard std st type") || of_mean);
    let is_deviation = has(SPREADS[0]) || has("standard") && has("deviation dev") || has("écart ecart") && has("type");
    let is_se = has(SPREADS[1]) || is_error || is_deviation && of_mean || header.lower.starts_with("s.e");
    let is_extent = has("min") && has("max") || has("half") && has("width");
    let tight = header.lower.replace(' ', "");
    let mut in_brackets = in_brackets(&header.lower).map(|own| own.inside);
    let is_multiple = is_multiple(&header.lower) || in_brackets.any(is_multiple) || tight.contains("k=2");
    let is_other = has(OTHER_SPREADS) || header.has_square_sign() || is_multiple || is_extent;
    let other = ("a spread that is neither sd nor standard error", None);
    match column {
        RestitutionSdOfRuns | RestitutionSe if is_other => Some(other),
        RestitutionSdOfRuns => is_se.then_some(("a standard error", Some(RestitutionSe))),
        RestitutionSe => (is_deviation && !is_se).then_some(("a standard deviation", Some(RestitutionSdOfRuns))),
        ImpactSpeedSd | ReboundSpeedSd | RestitutionSd => {
            let called = &header.called;
            let is_quantity = !called.is_empty() && called.iter().all(|of| MEASURED.contains(of));
            if is_quantity && !header.name.contains('±') {
                return Some(("a quantity itself", called.first().copied()));
            }
            let of_quantity = |of: &str| is_among("e en v vi v_i", of);
            let is_relative = has("rel relative relativ") || header.divisor().is_some_and(of_quantity);
            is_other
                .then_some(other)
                .or(is_relative.then_some(("a relative spread", None)))
        }
        // the first word or the last, and no `mean and sd`
        _ if MEASURED.contains(&column) => {
            let ends = [header.words.first()?, header.words.last()?];
            // a film or sphere is measured by SEM, a microscope
            let may_be_se = !matches!(column, Film | Diameter);
            let is_end = |list: &str| ends.iter().any(|word| is_among(list, word));
            let is_spread =
                is_error || is_end(SPREADS[0]) || may_be_se && is_end(SPREADS[1]) || is_end("error err fehler");
            (is_spread && !has("mean avg average mittel mittelwert"))
                .then_some(("the spread or error of a quantity", None))
        }
        _ => None,
    }
}

/// Whether a spread is written with a number before it, as `2σ` is.
fn is_multiple(lower: &str) -> bool {
    let after = lower.trim_start_matches(['±', ' ']);
    let spread = after.trim_start_matches(|c: char| c.is_ascii_digit() || ".,".contains(c));
    let of = spread.trim_start_matches(['·', '*', '×', ' ']);
    let is_spread = |word: &str| word == "s" || SPREADS.iter().any(|list| is_among(list, word));
    spread.len() < after.len() && words_of(of).next().is_some_and(is_spread)
}
