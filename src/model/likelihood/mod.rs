//! Computes the log likelihood of all runs at once and its slopes.
//!
//! The generative statement: e* = m(r) + σ z, with σ_wet or σ_dry; a dry run keeps r = e_dry², of which m(r) is e_dry within
//! 1e-6 from e_dry = 0.23 on. The run stuck if e* is at or below the limit; where such runs were not logged, a rebound's
//! density is that of runs that rebound. A node is a
//! setting with a count and a mean restitution: where noise is normal and of one spread, runs of one setting are one node, and
//! what they scatter about their mean by is a sum of squares of its own, which is exact. Where z is of another family, or runs
//! have errors of their own, or noise acts on the energy kept, `by_row.rs` takes a run at a time, as what leaves runs out and
//! what predicts them do; `pointwise.rs` says what one adds. Rebounds with Student's noise of one spread are summed as nodes, too.
//!
//! Each run gives its log density with the slopes in the noise and in what it keeps; `trend.rs` alone turns the latter into
//! those of the parameters.
//!
//! Symbols: r = e_dry² − C ρ̃ g(δ̃) − L x − b with x = 4/St and b = κ/v², as far as the form holds them, and e_dry = 1 − k p
//! (+ (3/5) k² p² to second order) with p = v^(1/5) at the dry speed in use. A trend with the film ratio stands in L and C:
//! L + L′ f and C exp(C′ f), f being the logarithm of the film ratio over the middle one of the runs.

mod asymmetric_laplace;
mod by_row;
mod by_series;
mod energy;
mod errors;
mod hidden;
mod nodes;
pub mod normal;
pub mod pointwise;
mod prepared;
mod run_density;
mod run_law;
mod run_noise;
mod shared_speed;
mod student;
mod sums;
pub mod tails;
pub(crate) mod trend;

pub use by_series::SeriesDensities;
pub use prepared::Likelihood;
pub use run_law::NewImpact;
pub use run_noise::{normal_number, RunNoise};

use self::run_density::{RunDensity, Side, Totals};
use self::sums::{Asked, NodeSums};
use self::tails::Tails;
use self::trend::{BlockLaw, FilmParameters};
use super::parameters::{ParameterKind, SHAPE_SLOT};
use crate::distributions::LN_ROOT_TWO_PI;

/// The parameters give no density here: not an error, a place to turn back from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("outside the domain")]
pub struct OutsideDomain;

impl Likelihood {
    /// Log likelihood at a full vector of parameters; `slopes`, as long, is overwritten.
    ///
    /// Fails where it is not finite; a full vector with e_dry ≤ 0 or σ ≤ 0 is the caller's to avoid by its bounds.
    pub fn ln_density(&self, full: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        slopes.fill(0.0);
        let rows = &self.rows;
        let films = FilmParameters::new(rows.form, full);
        let laws: Vec<BlockLaw> = rows.blocks.iter().map(|block| block.law(films, full)).collect();
        let noise = rows.noise_at(full);
        let mut totals = Totals {
            of_kind: [RunDensity::default(); 2],
            blocks: vec![Default::default(); laws.len()],
        };
        for (kind, noise) in noise.iter().enumerate() {
            self.add_nodes(kind, noise, &laws, &mut totals);
        }
        if self.needs_rows {
            rows.add_to(full, &noise, self.nodes.iter().any(|own| own.runs > 0.0), &mut totals);
        }
        for (law, sums) in laws.iter().zip(&totals.blocks) {
            law.add_slopes(sums, slopes);
        }
        let mut value = 0.0;
        let sigmas = [ParameterKind::SigmaDry, ParameterKind::SigmaWet];
        for (of, sigma) in totals.of_kind.into_iter().zip(sigmas) {
            value += of.value;
            slopes[sigma.slot()] += of.sigma;
            slopes[ParameterKind::SigmaEnergy.slot()] += of.energy;
            slopes[SHAPE_SLOT] += of.shape;
        }
        let finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        finite.then_some(value).ok_or(OutsideDomain)
    }

    /// Adds the runs of a kind that nodes stand for. What a dry run keeps is e_dry², without losses.
    fn add_nodes(&self, kind: usize, noise: &RunNoise, laws: &[BlockLaw], totals: &mut Totals) {
        let own = &self.nodes[kind];
        let is_empty = own.rebounds.len() + own.stuck.len() == 0;
        let student = match noise.tails {
            _ if is_empty => return,
            Tails::Normal => None,
            Tails::Student(student) => Some(student),
            // whose rebounds are taken one by one
            Tails::AsymmetricLaplace(_) => return,
        };
        let (peak, peak_slope) = student.map_or((-LN_ROOT_TWO_PI, 0.0), |of| (of.peak, of.peak_slope));
        let sigma = noise.sigma;
        let mut add = |nodes, asked, times| {
            let sums = NodeSums {
                nodes,
                kind,
                laws,
                order: self.rows.form.dry,
                sigma,
                asked,
                times,
            };
            sums.add_to(totals);
        };
        add(&own.rebounds, Asked::Rebounds(student), 1.0);
        add(&own.stuck, Asked::Side(Side::Below, self.rows.limit), 1.0);
        if self.rows.truncated {
            // the density of a rebound is that of runs that rebound
            add(&own.rebounds, Asked::Side(Side::Above, self.rows.limit), -1.0);
        }
        let squares = own.leftover / (sigma * sigma);
        let all = &mut totals.of_kind[kind];
        all.value += own.runs * (peak - sigma.ln()) - 0.5 * squares;
        all.sigma += (squares - own.runs) / sigma;
        all.shape += own.runs * peak_slope;
    }
}

#[cfg(test)]
mod tests;
