//! Rounds estimates, main numbers and posteriors for print.

pub use crate::rounding::{
    between, by_mcse, optional, probability, range, rounded, shift, short, signed, signed_to, significant, with_se,
    NONE,
};

use crate::findings::posterior::QuantitySummary;
use crate::rounding::{positive, with_sd};

/// `mean ± sd` of a posterior, rounded by the sd but to no digit that its Monte Carlo error leaves open. `scale` must be
/// a plain factor.
pub fn mean_and_sd(quantity: &QuantitySummary, scale: impl Fn(f64) -> f64) -> String {
    let scaled = |x: Option<f64>| x.map(&scale);
    let (mean, sd) = (scaled(quantity.mean), positive(scaled(quantity.sd)));
    match (mean, sd, positive(scaled(quantity.mcse_mean))) {
        (Some(mean), Some(sd), Some(mcse)) => with_sd(mean, sd, mcse),
        _ => NONE.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_posteriors_digits_are_those_its_monte_carlo_error_leaves() {
        for (mcse, expected) in [(8.25e-6, "0.18352"), (1e-5, "0.1835"), (1.2e-4, "0.184"), (0.3, "0.2")] {
            assert_eq!(by_mcse(Some(0.183_524_7), Some(mcse)), expected);
        }
        assert_eq!(by_mcse(Some(1234.0), Some(20.0)), "1200");
        assert_eq!(by_mcse(Some(0.0), Some(0.01)), "0.0");
        assert_eq!(by_mcse(Some(0.183_524_7), None), "0.184");
        assert_eq!(by_mcse(None, Some(0.1)), NONE);
        let quantity = |sd: f64, mcse: f64| QuantitySummary {
            name: "k".to_owned(),
            mean: Some(0.183_524_7),
            sd: Some(sd),
            median: None,
            q05: Some(0.182_56),
            q95: Some(0.184_48),
            q025: None,
            q975: None,
            rhat: None,
            ess_bulk: None,
            ess_tail: None,
            mcse_mean: Some(mcse),
            mcse_sd: None,
            mcse_q05: Some(2.0 * mcse),
            mcse_q95: Some(mcse),
            from: None,
            prior: None,
            why_none: None,
        };
        let long = quantity(0.001_23, 9e-6);
        assert_eq!(mean_and_sd(&long, |x| x), "0.1835 ± 0.0012");
        assert_eq!(mean_and_sd(&long, |x| 1e3 * x), "183.5 ± 1.2");
        // a short run settles fewer digits than the sd would show
        assert_eq!(mean_and_sd(&quantity(0.001_23, 4e-4), |x| x), "0.184 ± 0.001");
        assert_eq!(mean_and_sd(&quantity(3.4e9, 1e8), |x| x), "0.18 ± 3.4e9");
    }
}
