//! Writes numbers as every one of the codes reads them.

use crate::rounding::to_digits;

/// Digits of a number in a file; e is proved to three decimals.
const DIGITS: usize = 7;

/// A number as every one of the codes reads it, to seven digits.
pub(super) fn number(x: f64) -> String {
    let rounded = to_digits(x, DIGITS);
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// A restitution, to five decimals.
pub(super) fn restitution(e: f64) -> String {
    format!("{e:.5}")
}

/// A restitution as a code is given it, to six decimals.
pub(super) fn input(e: f64) -> String {
    format!("{e:.6}")
}
