//! Puts the offset of a series on the whole line, where the sampler meets a standard normal however much its runs tell.
//!
//! Symbols: o = σ ζ with ζ standard normal beforehand, σ being σ_series; the runs of the series by themselves say
//! o = ô ± √s. Given σ, ζ is then normal about σ ô/(σ² + s) with the variance s/(σ² + s), and u stands for ζ less that mean
//! over that sd. With s = ∞ u is ζ itself, which the sampler finds hard where runs are many (o is known, so that ζ and σ
//! only move together); with s = 0 it is o, hard where they are few. ô and s, found once about a point, change neither the
//! posterior nor its Jacobian's truth, but only how far it is from round.

use super::likelihood::Likelihood;
use super::parameters::ModelParameters;

/// What the runs of one series say of its offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffsetCoordinate {
    /// ô
    estimate: f64,
    /// s
    variance: f64,
}

/// An offset with what a density needs of its coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MappedOffset {
    /// o
    pub value: f64,
    /// do/du
    pub slope: f64,
    /// do/dσ
    pub slope_sigma: f64,
    /// ln of the prior density of ζ, with ln dζ/du
    pub ln_prior: f64,
    /// its slope in u
    pub ln_prior_slope: f64,
    /// its slope in σ
    pub ln_prior_slope_sigma: f64,
}

/// The widest that an offset is taken to be told, in r: beyond, its runs tell nothing.
const WIDEST: f64 = 1.0;

impl OffsetCoordinate {
    /// Of a series whose runs tell nothing.
    pub const UNTOLD: OffsetCoordinate = OffsetCoordinate {
        estimate: 0.0,
        variance: WIDEST * WIDEST,
    };

    /// The offset at u and σ.
    #[inline]
    pub fn at(&self, u: f64, sigma: f64) -> MappedOffset {
        let OffsetCoordinate { estimate, variance } = *self;
        let total = sigma * sigma + variance;
        let (pull, width) = (sigma / total, (variance / total).sqrt());
        let zeta = pull * estimate + width * u;
        // of ζ in σ
        let zeta_slope = (variance - sigma * sigma) / (total * total) * estimate - width * pull * u;
        MappedOffset {
            value: sigma * zeta,
            slope: sigma * width,
            slope_sigma: zeta + sigma * zeta_slope,
            ln_prior: -0.5 * zeta * zeta + width.ln(),
            ln_prior_slope: -zeta * width,
            ln_prior_slope_sigma: -zeta * zeta_slope - pull,
        }
    }

    /// u of an offset.
    pub fn inverse(&self, offset: f64, sigma: f64) -> f64 {
        let total = sigma * sigma + self.variance;
        (offset / sigma - sigma / total * self.estimate) / (self.variance / total).sqrt()
    }
}

/// The coordinates of the offsets about a full vector of parameters: each offset alone climbs to where the runs want it.
///
/// A series whose runs have no density there is taken to tell nothing.
pub fn coordinates_about(parameters: &ModelParameters, likelihood: &Likelihood, full: &[f64]) -> Vec<OffsetCoordinate> {
    let offsets = parameters.first_offset()..full.len();
    let weakest = 1.0 / (WIDEST * WIDEST);
    let Ok((at, strengths)) = likelihood.highest_offsets(full, offsets.clone(), WIDEST * WIDEST) else {
        return vec![OffsetCoordinate::UNTOLD; offsets.len()];
    };
    let each = at[offsets].iter().zip(strengths);
    each.map(|(estimate, strength)| OffsetCoordinate {
        estimate: *estimate,
        variance: 1.0 / (strength + weakest),
    })
    .collect()
}
