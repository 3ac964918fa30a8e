//! Finds the smallest and the largest of some numbers.

/// Smallest and largest of some numbers; `None` without any.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, x| match range {
        None => Some([x, x]),
        Some([lo, hi]) => Some([f64::min(lo, x), f64::max(hi, x)]),
    })
}
