//! Computes the log likelihood of all runs at once and its slopes.
//!
//! The generative statement: a wet run's e* = m(r) + σ_wet z, a dry run's e* = e_dry(v) + σ_dry z; the run stuck if e* is
//! at or below the limit; where such runs were not logged, a rebound's density is that of runs that rebound. A node is a
//! setting with a count and a mean restitution: where noise is normal and of one spread, runs of one setting are one node, and
//! what they scatter about their mean by is a sum of squares of its own, which is exact. Where z is of another family, or runs have errors
//! of their own, or noise acts on the energy kept, `by_row.rs` takes a run at a time.
//!
//! Symbols: r = e_dry² − C ρ̃ g(δ̃) − L x − b with x = 4/St and b = κ/v², as far as the form holds them, and e_dry = 1 − k p
//! (+ (3/5) k² p² to second order) with p = v^(1/5) at the dry speed in use. A trend with the film ratio stands in L and C:
//! L + L′ f and C exp(C′ f), f being the logarithm of the film ratio over the middle one of the runs.

mod asymmetric_laplace;
mod block_sums;
mod by_row;
mod by_series;
mod dry;
mod dry_sums;
mod errors;
mod hidden;
mod nodes;
pub mod normal;
mod own_rows;
pub mod pointwise;
mod prepared;
mod row_noise;
mod rows;
mod run_density;
mod run_law;
mod run_noise;
mod shared_speed;
mod sides;
mod student;
mod sums;
pub mod tails;
pub(crate) mod trend;

pub use by_series::SeriesDensities;
pub use prepared::Likelihood;
pub use run_density::Spreads;
pub use run_law::BelowRestitution;

use self::block_sums::BlockSums;
use self::by_row::BlockRows;
use self::nodes::WetBlock;
use self::row_noise::RowNoise;
use self::run_density::Side;
use self::run_noise::RunNoise;
use self::sides::{side_sums, SideOfLimit, SideSums};
use self::sums::{rebound_sums, NodeRange};
use self::trend::FilmParameters;
use super::parameters::{ParameterKind, SHAPE_SLOT};
use crate::distributions::LN_ROOT_TWO_PI;

/// The parameters give no density here: not an error, a place to turn back from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutsideDomain;

/// What the wet runs read of a full vector of parameters.
struct WetEvaluation {
    /// σ_wet
    sigma: f64,
    /// the rebounds of each block with its energy balance
    rebounds: Vec<NodeRange>,
}

impl Likelihood {
    /// Log likelihood at a full vector of parameters; `slopes`, as long, is overwritten.
    ///
    /// Fails where it is not finite; a full vector with e_dry ≤ 0 or σ ≤ 0 is the caller's to avoid by its bounds.
    pub fn ln_density(&self, full: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        slopes.fill(0.0);
        let value = self.wet(full, slopes) + self.dry(full, slopes);
        let finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        if finite {
            Ok(value)
        } else {
            Err(OutsideDomain)
        }
    }

    /// Log likelihood of the wet runs, with slopes.
    fn wet(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        if self.blocks.is_empty() {
            return 0.0;
        }
        let parameters = FilmParameters::new(self.form, full);
        let range = |block: &WetBlock| NodeRange {
            nodes: block.rebounds.clone(),
            law: self.law(block, full, parameters),
        };
        let wet = WetEvaluation {
            sigma: full[ParameterKind::SigmaWet.slot()],
            rebounds: self.blocks.iter().map(range).collect(),
        };
        match &self.own {
            Some(own) => {
                let noise = RowNoise {
                    own,
                    noise: RunNoise {
                        tails: self.tails(full),
                        spreads: Spreads {
                            sigma: wet.sigma,
                            energy: if own.both {
                                full[ParameterKind::SigmaEnergy.slot()]
                            } else {
                                0.0
                            },
                        },
                        wet: true,
                    },
                };
                self.wet_by_row(&wet, &noise, slopes)
            }
            None => self.wet_by_sums(&wet, slopes),
        }
    }

    /// Log likelihood of wet runs that have spreads or tails of their own: by sums over the rebounds of each block where
    /// these have one spread, else a run at a time.
    fn wet_by_row(&self, wet: &WetEvaluation, noise: &RowNoise, slopes: &mut [f64]) -> f64 {
        let (sigma, tails) = (wet.sigma, noise.noise.tails);
        let heavy = tails
            .heavy(sigma)
            .filter(|_| !self.truncated && noise.own.spreads_are_one());
        let all_sums = heavy.map(|heavy| rebound_sums(&self.rebounds, self.form.dry, Some(heavy), &wet.rebounds));
        let mut value = 0.0;
        let mut sums = vec![BlockSums::default(); self.blocks.len()];
        for (place, (block, NodeRange { nodes, law })) in self.blocks.iter().zip(&wet.rebounds).enumerate() {
            let sums = &mut sums[place];
            let mut one_by_one = nodes.clone();
            if let Some(all_sums) = &all_sums {
                *sums = all_sums[place];
                let density = tails.of_sums(*sums, nodes.len(), sigma);
                value += density.value;
                slopes[ParameterKind::SigmaWet.slot()] += density.sigma;
                slopes[SHAPE_SLOT] += density.shape;
                sums.weigh_slopes(density.kept_factor);
                one_by_one = nodes.end..nodes.end;
            }
            let rows = BlockRows {
                rebounds: one_by_one,
                stuck: block.stuck.clone(),
                law,
            };
            value += self.run_by_run(rows, noise, (slopes, sums));
        }
        value += self.of_shared_speeds(noise, &wet.rebounds, (slopes, &mut sums));
        for ((block, range), sums) in self.blocks.iter().zip(&wet.rebounds).zip(&sums) {
            range.law.add_slopes(block, sums, slopes);
        }
        value
    }

    /// Log likelihood of wet runs that all have σ for their spread and normal tails, by sums of squares.
    fn wet_by_sums(&self, wet: &WetEvaluation, slopes: &mut [f64]) -> f64 {
        let sigma = wet.sigma;
        let precision = 1.0 / (sigma * sigma);
        let mut squares = self.leftover;
        let all_sums = rebound_sums(&self.rebounds, self.form.dry, None, &wet.rebounds);
        let side = |side: Side| SideOfLimit {
            side,
            limit: self.limit,
            sigma,
        };
        let stuck: Vec<NodeRange> = self
            .blocks
            .iter()
            .zip(&wet.rebounds)
            .map(|(block, range)| NodeRange {
                nodes: block.stuck.clone(),
                law: range.law,
            })
            .collect();
        let stuck = side_sums(&self.stuck, self.form.dry, side(Side::Below), &stuck);
        // the density of a rebound is that of runs that rebound
        let logged = if self.truncated {
            side_sums(&self.rebounds, self.form.dry, side(Side::Above), &wet.rebounds)
        } else {
            vec![SideSums::default(); stuck.len()]
        };
        let mut sides = 0.0;
        let of_blocks = self.blocks.iter().zip(&wet.rebounds).zip(all_sums);
        for (((block, range), mut sums), (stuck, logged)) in of_blocks.zip(stuck.iter().zip(logged)) {
            squares += sums.squares;
            sums.weigh_slopes(precision);
            for (of, times) in [(stuck, 1.0), (&logged, -1.0)] {
                sides += times * of.value;
                slopes[ParameterKind::SigmaWet.slot()] += times * of.sigma;
                sums.add_slopes(of.slopes, times);
            }
            range.law.add_slopes(block, &sums, slopes);
        }
        slopes[ParameterKind::SigmaWet.slot()] += (squares * precision - self.wet_rebounds) / sigma;
        sides - self.wet_rebounds * (sigma.ln() + LN_ROOT_TWO_PI) - 0.5 * squares * precision
    }
}

#[cfg(test)]
mod tests;
