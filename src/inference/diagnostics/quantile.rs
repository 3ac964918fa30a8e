//! Interpolates a quantile of sorted draws.

/// Quantile at a probability in [0, 1] of draws in increasing order, at least one.
///
/// Linear between the order statistics at (S − 1)·probability (type 7 of Hyndman & Fan), rounded as NumPy rounds it:
/// a tail ESS counts the draws up to and including the quantile, so that the last bit matters where it is a draw.
pub(crate) fn of_sorted(sorted: &[f64], probability: f64) -> f64 {
    let place = (sorted.len() - 1) as f64 * probability;
    let below = place.floor();
    let low = sorted[below as usize];
    let high = sorted[(below as usize + 1).min(sorted.len() - 1)];
    let between = place - below;
    if between >= 0.5 {
        high - (high - low) * (1.0 - between)
    } else {
        low + (high - low) * between
    }
}

/// All draws in increasing order.
pub(crate) fn sorted(mut draws: Vec<f64>) -> Vec<f64> {
    draws.sort_unstable_by(f64::total_cmp);
    draws
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_and_end_at_the_extremes() {
        let draws = sorted(vec![4.0, 1.0, 2.0, 3.0]);
        assert_eq!(of_sorted(&draws, 0.0), 1.0);
        assert_eq!(of_sorted(&draws, 0.5), 2.5);
        assert_eq!(of_sorted(&draws, 0.25), 1.75);
        assert_eq!(of_sorted(&draws, 1.0), 4.0);
    }
}
