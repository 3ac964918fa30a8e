//! Reads L and C of a film ratio from the parameters, with their trends, and turns slopes of r into those of parameters.
//!
//! Symbols: f = ln(δ̃/δ̃_m), δ̃_m being the middle film ratio of the runs; L + L′ f and C exp(C′ f). With δc ∝ δ̃^p at one
//! diameter L = ln(δc/ε) has the slope L′ = p; C′ is the power of the film ratio by which the inertial loss departs from
//! its form. Empirical: neither is in the paper, which asks whether they vanish.

use super::law::Law;
use super::nodes::Block;
use super::sums::Sums;
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::impact::{DrySpeed, Form};
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
pub(super) struct Film {
    /// L + L′ f
    pub l: f64,
    /// C
    c: f64,
    /// exp(C′ f)
    grown: f64,
    /// g(δ̃) and its slope in δ̃0
    shape: (f64, f64),
    /// f
    ln_film: f64,
}

impl Film {
    /// At a film ratio with this f, and this g and slope of g in δ̃0.
    pub fn of(ln_film: f64, shape: (f64, f64), full: &[f64]) -> Film {
        let at = |kind: Kind| full[kind.slot()];
        let trend = at(Kind::InertialTrend);
        Film {
            l: at(Kind::LubricationLog) + at(Kind::LubricationTrend) * ln_film,
            c: at(Kind::InertialPrefactor),
            // an exponential a film is felt, and most models have no trend
            grown: if trend == 0.0 { 1.0 } else { (trend * ln_film).exp() },
            shape,
            ln_film,
        }
    }

    /// C exp(C′ f) ρ̃ g(δ̃).
    pub fn inertial(&self, density_ratio: f64) -> f64 {
        self.c * self.grown * density_ratio * self.shape.0
    }

    /// The law of runs with this film ratio.
    pub fn law(&self, form: Form, k: f64, density_ratio: f64) -> Law {
        Law {
            order: form.dry,
            own_speed: form.dry_speed == DrySpeed::Impact,
            k,
            inertial: self.inertial(density_ratio),
            l: self.l,
        }
    }

    /// Slopes of r turned into those of the parameters, over all blocks of this film ratio.
    pub fn add_slopes(&self, sums: OfFilm, slopes: &mut [f64]) {
        let (shape, shape_slope) = self.shape;
        let kept = sums.inertial * self.grown;
        slopes[Kind::LubricationLog.slot()] -= sums.viscous;
        slopes[Kind::LubricationTrend.slot()] -= sums.viscous * self.ln_film;
        slopes[Kind::InertialPrefactor.slot()] -= kept * shape;
        slopes[Kind::InertialTrend.slot()] -= kept * self.c * shape * self.ln_film;
        slopes[Kind::FilmScale.slot()] -= kept * self.c * shape_slope;
    }
}

/// Slopes of r, added up over the blocks of a film ratio.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct OfFilm {
    /// those in r times ρ̃
    inertial: f64,
    /// those in −L
    viscous: f64,
}

impl OfFilm {
    /// Adds those of a block; its slope in k goes to the slopes of the parameters at once.
    pub fn add(&mut self, block: &Block, sums: Sums, slopes: &mut [f64]) {
        self.inertial += sums.kept * block.density_ratio;
        self.viscous += sums.viscous;
        slopes[COMMON_SLOTS + block.particle] -= 2.0 * sums.dry;
    }
}
