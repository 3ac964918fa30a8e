//! Fits a generalised Pareto distribution to a tail, and says how long a tail and how heavy a one may be.

/// Fewest values a tail is fitted to.
pub const SHORTEST_TAIL: usize = 5;

/// Scale of the prior of b by the sample's first quarter (Zhang & Stephens 2009).
const PRIOR_SCALE: f64 = 3.0;

/// Centre of the weak prior of the shape, and how many values it is worth (Vehtari et al. 2024, appendix C).
const PRIOR_SHAPE: (f64, f64) = (0.5, 10.0);

/// A generalised Pareto distribution over [0, ∞) (up to −scale/shape where the shape is negative).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pareto {
    /// shape k: moments of order 1/k and above are infinite
    pub shape: f64,
    /// scale σ, in the values' unit
    pub scale: f64,
}

impl Pareto {
    /// Quantile at a probability in [0, 1).
    pub fn quantile(&self, probability: f64) -> f64 {
        let exponential = -(-probability).ln_1p();
        if self.shape == 0.0 {
            self.scale * exponential
        } else {
            self.scale * (self.shape * exponential).exp_m1() / self.shape
        }
    }
}

/// Fits exceedances over a threshold, in increasing order.
///
/// The posterior mean of b = −k/σ over a grid, then k by likelihood given b, shrunk weakly towards 1/2. `None` for
/// fewer than [`SHORTEST_TAIL`] values, where the lower quarter of them is tied (no Pareto tail is), or where a value is
/// not finite. Source: Zhang & Stephens 2009 (Technometrics 51, 316); Vehtari et al. 2024 (JMLR 25, 72), appendix C.
pub fn fit(exceedances: &[f64]) -> Option<Pareto> {
    let x = exceedances;
    if x.len() < SHORTEST_TAIL {
        return None;
    }
    let n = x.len() as f64;
    let quarter = x[(n / 4.0 + 0.5) as usize - 1];
    let largest = x[x.len() - 1];
    if quarter <= x[0] || !largest.is_finite() {
        return None;
    }
    let points = 30.0 + n.sqrt().floor();
    let grid: Vec<f64> = (0..points as u32)
        .map(|i| (1.0 - (points / (f64::from(i) + 0.5)).sqrt()) / (PRIOR_SCALE * quarter) + 1.0 / largest)
        .collect();
    let profile: Vec<f64> = grid
        .iter()
        .map(|&b| {
            let shape = mean_log(x, b);
            n * ((-b / shape).ln() - shape - 1.0)
        })
        .collect();
    let best = profile.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = profile.iter().map(|log| (log - best).exp()).collect();
    let total: f64 = weights.iter().sum();
    let b = grid.iter().zip(&weights).map(|(b, weight)| b * weight).sum::<f64>() / total;
    let shape = mean_log(x, b);
    let (centre, worth) = PRIOR_SHAPE;
    let pareto = Pareto {
        shape: (n * shape + worth * centre) / (n + worth),
        scale: -shape / b,
    };
    (pareto.shape.is_finite() && pareto.scale > 0.0).then_some(pareto)
}

/// Mean of ln(1 − b x): eight factors share a logarithm, as long as their product stays in range.
fn mean_log(x: &[f64], b: f64) -> f64 {
    let logs = x.chunks(8).map(|chunk| {
        let product: f64 = chunk.iter().map(|x| 1.0 - b * x).product();
        if product.is_normal() {
            product.ln()
        } else {
            chunk.iter().map(|x| (-b * x).ln_1p()).sum()
        }
    });
    logs.sum::<f64>() / x.len() as f64
}

/// How many of the largest of so many weights are taken for the tail, for a relative efficiency `r_eff` of the draws.
///
/// 3 √(S/r_eff), and a fifth of the draws where fewer than 225 are effective, rounded down as ArviZ does (R's loo
/// rounds up). Source: Vehtari et al. 2024 (JMLR 25, 72), section 5.
pub fn tail_length(draws: usize, r_eff: f64) -> usize {
    let count = draws as f64;
    let length = if count * r_eff > 225.0 {
        3.0 * (count / r_eff).sqrt()
    } else {
        count / 5.0
    };
    (length as usize).min(draws.saturating_sub(1))
}

/// Largest shape with which a mean over so many weighted draws is reliable: min(1 − 1/log10 S, 0.7).
///
/// Source: Vehtari et al. 2024 (JMLR 25, 72), section 3.2.
pub fn khat_threshold(draws: usize) -> f64 {
    (1.0 - 1.0 / (draws as f64).log10()).min(0.7)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_out_of_range_falls_back_to_single_logarithms() {
        let x: Vec<f64> = (0..16).map(|i| 10f64.powi(20 * i)).collect();
        let direct = x.iter().map(|x| x.ln_1p()).sum::<f64>() / 16.0;
        assert!((mean_log(&x, -1.0) / direct - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_tail_has_no_fit() {
        assert_eq!(fit(&[0.1, 0.2, 0.3, 0.4]), None);
        assert_eq!(fit(&[1.0; 40]), None);
        assert_eq!(fit(&[0.1, 0.2, 0.3, 0.4, 0.5, f64::INFINITY]), None);
    }
}
