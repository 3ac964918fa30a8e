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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_seven_digits_and_no_long_zeros() {
        assert_eq!(number(0.004762), "0.004762");
        assert_eq!(number(1.0 / 3.0), "0.3333333");
        assert_eq!(number(1.215_61e-4 / 100.0), "1.21561e-6");
        assert_eq!(number(1.5e9), "1.5e9");
        assert_eq!(number(0.0), "0");
    }
}
