//! Makes the summary of one quantity: where its draws lie, and how reliable they are.

use super::halves::Halves;
use super::ranks::OrderedDraws;
use super::{ess, have_diagnostics, mcse, mean, quantile, rhat, variance};

/// What the draws say of one quantity, in its own unit.
///
/// Mean, sd and quantiles are `None` where a draw is not finite or there is none, the sd also of a single draw; the rest
/// is `None` where the draws are too few or too much alike.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, schemars::JsonSchema)]
pub struct Summary {
    /// mean
    pub mean: Option<f64>,
    /// standard deviation, by S − 1
    pub sd: Option<f64>,
    /// 50 % point
    pub median: Option<f64>,
    /// 5 % point
    pub q05: Option<f64>,
    /// 95 % point
    pub q95: Option<f64>,
    /// 2.5 % point
    pub q025: Option<f64>,
    /// 97.5 % point
    pub q975: Option<f64>,
    /// R-hat: 1 where all chains look alike, above 1.01 not reliable
    pub rhat: Option<f64>,
    /// effective draws in the bulk: those of the normal scores
    pub ess_bulk: Option<f64>,
    /// effective draws in the tails: the smaller of those at the 5 % and at the 95 % point
    pub ess_tail: Option<f64>,
    /// effective draws for the mean, of which [`super::loo::relative_efficiency`] is made
    #[serde(skip)]
    pub ess_mean: Option<f64>,
    /// Monte Carlo error of the mean: sd over the root of its effective draws
    pub mcse_mean: Option<f64>,
    /// Monte Carlo error of the sd
    pub mcse_sd: Option<f64>,
    /// Monte Carlo error of the 5 % quantile
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcse_q05: Option<f64>,
    /// Monte Carlo error of the 95 % quantile
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcse_q95: Option<f64>,
}

impl Summary {
    /// Whether the draws give all of it.
    pub fn is_whole(&self) -> bool {
        let diagnostics = [self.rhat, self.ess_bulk, self.ess_tail, self.ess_mean, self.mcse_sd];
        diagnostics.iter().all(Option::is_some)
    }
}

/// Summary of one quantity from its draws, one slice a chain.
///
/// From three sorts and five sums of autocovariances.
pub fn summarise(chains: &[&[f64]]) -> Summary {
    let mut summary = Summary::default();
    let draws = chains.concat();
    if draws.iter().any(|x| !x.is_finite()) {
        return summary;
    }
    let sorted = quantile::sorted(draws.clone());
    let Some((low, high)) = describe(&mut summary, &draws, &sorted).filter(|_| have_diagnostics(chains)) else {
        return summary;
    };
    let halves = Halves::map(chains, |x| x);
    let ordered = OrderedDraws::of(&halves);
    let scores = ordered.scores();
    let (ess_low, ess_high) = (ess::below(chains, low), ess::below(chains, high));
    let ess_mean = ess::of_halves(&halves);
    let centre = mean(&draws);
    let ess_sd = ess::of_sd_about(chains, centre);
    summary.rhat = rhat::of_scores(&ordered, &scores);
    summary.ess_bulk = ess::of_halves(&scores);
    summary.ess_tail = ess_low.zip(ess_high).map(|(low, high)| low.min(high));
    summary.ess_mean = ess_mean;
    summary.mcse_mean = summary.sd.zip(ess_mean).map(|(sd, effective)| sd / effective.sqrt());
    summary.mcse_sd = ess_sd.map(|effective| mcse::from_moments(&draws, centre, effective));
    summary.mcse_q05 = ess_low.map(|effective| mcse::from_order(&sorted, ess::TAIL, effective));
    summary.mcse_q95 = ess_high.map(|effective| mcse::from_order(&sorted, 1.0 - ess::TAIL, effective));
    summary
}

/// Fills in location and spread; returns the 5 % and 95 % points, `None` without draws.
fn describe(summary: &mut Summary, draws: &[f64], sorted: &[f64]) -> Option<(f64, f64)> {
    let (least, most) = (*sorted.first()?, *sorted.last()?);
    let (low, high) = (
        quantile::of_sorted(sorted, ess::TAIL),
        quantile::of_sorted(sorted, 1.0 - ess::TAIL),
    );
    // draws that are all the same have no spread at all, which a rounded mean would hide
    let same = least == most;
    summary.mean = Some(if same { least } else { mean(draws) });
    summary.sd = (draws.len() > 1).then(|| if same { 0.0 } else { variance(draws).sqrt() });
    summary.median = Some(quantile::of_sorted(sorted, 0.5));
    summary.q05 = Some(low);
    summary.q95 = Some(high);
    summary.q025 = Some(quantile::of_sorted(sorted, 0.025));
    summary.q975 = Some(quantile::of_sorted(sorted, 0.975));
    Some((low, high))
}
