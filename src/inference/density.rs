//! Estimates the density of draws of one quantity.

/// Points along a smoothed density.
const CURVE: usize = 60;
/// Draws a smoothed density is made of.
const SMOOTHED: usize = 1000;

/// Density of draws from lo to hi as the heights of so many equal bars; what lies beyond counts to the outer ones.
pub fn bars(draws: &[f64], (lo, hi): (f64, f64), count: usize) -> Vec<f64> {
    let width = (hi - lo) / count as f64;
    let mut heights = vec![0.0; count];
    for draw in draws {
        // a float too large for an index saturates, and one of draws all the same is NaN, which becomes 0
        heights[(((draw - lo) / width) as usize).min(count - 1)] += 1.0;
    }
    let share = 1.0 / (draws.len() as f64 * width);
    heights.iter_mut().for_each(|height| *height *= share);
    heights
}

/// The density of draws inside bounds over its highest, at points from lowest to highest, some four standard deviations
/// about the mean: a normal kernel of Silverman's width, 1.06 sd n^(−1/5).
pub fn smoothed(draws: &[f64], (lower, upper): (f64, f64)) -> Vec<(f64, f64)> {
    let step = draws.len().div_ceil(SMOOTHED).max(1);
    let some: Vec<f64> = draws.iter().copied().step_by(step).collect();
    let n = some.len() as f64;
    let mean = some.iter().sum::<f64>() / n;
    let sd = (some.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt();
    let width = 1.06 * sd * n.powf(-0.2);
    let (lo, hi) = ((mean - 4.0 * sd).max(lower), (mean + 4.0 * sd).min(upper));
    let at = |x: f64| -> f64 {
        let kernel = some.iter().map(|draw| (x - draw) / width);
        kernel.map(|z| (-0.5 * z * z).exp()).sum()
    };
    let along = (0..=CURVE).map(|i| lo + (hi - lo) * i as f64 / CURVE as f64);
    let mut curve: Vec<(f64, f64)> = along.map(|x| (x, at(x))).collect();
    let highest = curve.iter().map(|point| point.1).fold(0.0, f64::max);
    for point in &mut curve {
        point.1 /= highest;
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smoothed_density_is_highest_where_most_draws_are() {
        let draws: Vec<f64> = (0..1000)
            .map(|i| 1.0 + ((f64::from(i) * 0.618).fract() - 0.5).powi(3))
            .collect();
        let curve = smoothed(&draws, (0.0, f64::INFINITY));
        let highest = curve.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("points");
        assert!((highest.0 - 1.0).abs() < 0.02 && highest.1 == 1.0, "{highest:?}");
    }
}
