//! Reads L and C of a film ratio from the parameters, with their trends, and turns slopes of r into those of parameters.
//!
//! Symbols: f = ln(δ̃/δ̃_m), δ̃_m being the middle film ratio of the runs; L + L′ f and C exp(C′ f). With δc ∝ δ̃^p at one
//! diameter L = ln(δc/ε) has the slope L′ = p; C′ is the power of the film ratio by which the inertial loss departs from
//! its form. Empirical: neither is in the paper, which asks whether they vanish.

use super::nodes::WetBlock;
use super::sums::BlockSums;
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::balance::{AtFilm, Balance};
use crate::physics::coefficient::Coefficients;
use crate::physics::loss::Share;
use crate::physics::Form;
use crate::runs::Runs;

/// The film ratio in the middle of the wet runs, their geometric mean: there L and C are what they are without trends.
pub(super) fn middle_film_ratio(runs: &Runs) -> f64 {
    let (mut logs, mut count) = (0.0, 0.0);
    for series in &runs.series {
        let weight = series.runs().len() as f64;
        logs += weight * (series.film / series.diameter).ln();
        count += weight;
    }
    if count > 0.0 {
        (logs / count).exp()
    } else {
        1.0
    }
}

/// What the parameters say at one film ratio.
#[derive(Debug, Clone, Copy)]
pub(super) struct FilmLosses {
    /// what the losses take without trends, with slopes
    plain: AtFilm,
    /// what they take with them
    share: Share,
    /// exp(C′ f)
    grown: f64,
    /// f
    ln_film: f64,
}

impl FilmLosses {
    /// At a film ratio with this f.
    pub fn of(form: Form, film_ratio: f64, ln_film: f64, full: &[f64]) -> FilmLosses {
        let at = |kind: Kind| full[kind.slot()];
        let plain = AtFilm::new(form, film_ratio, &Coefficients::first_of(full));
        let trend = at(Kind::InertialTrend);
        // an exponential a film is felt, and most models have no trend
        let grown = if trend == 0.0 { 1.0 } else { (trend * ln_film).exp() };
        FilmLosses {
            plain,
            share: Share {
                inertial: plain.share.inertial * grown,
                viscous: plain.share.viscous + at(Kind::LubricationTrend) * ln_film,
            },
            grown,
            ln_film,
        }
    }

    /// The energy balance of runs with this film ratio.
    pub fn balance(&self, form: Form, k: f64, density_ratio: f64) -> Balance {
        Balance::at(form, k, self.share, density_ratio)
    }

    /// Slopes of r turned into those of the parameters, over all blocks of this film ratio.
    pub fn add_slopes(&self, sums: FilmSums, slopes: &mut [f64]) {
        let kept = sums.inertial * self.grown;
        for slope in self.plain.slopes() {
            slopes[Kind::Shared(slope.of).slot()] -= kept * slope.share.inertial + sums.viscous * slope.share.viscous;
        }
        slopes[Kind::LubricationTrend.slot()] -= sums.viscous * self.ln_film;
        slopes[Kind::InertialTrend.slot()] -= kept * self.plain.share.inertial * self.ln_film;
    }
}

/// Slopes of r, added up over the blocks of a film ratio.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FilmSums {
    /// those in r times ρ̃
    inertial: f64,
    /// those in −L
    viscous: f64,
}

impl FilmSums {
    /// Adds those of a block; its slope in k goes to the slopes of the parameters at once.
    pub fn add(&mut self, block: &WetBlock, sums: BlockSums, slopes: &mut [f64]) {
        self.inertial += sums.kept * block.density_ratio;
        self.viscous += sums.viscous;
        slopes[COMMON_SLOTS + block.particle] -= 2.0 * sums.dry;
    }
}
