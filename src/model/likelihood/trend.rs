//! Reads L and C of a film ratio from the parameters, with their trends, and turns slopes of r into those of parameters.
//!
//! Symbols: f = ln(δ̃/δ̃_m), δ̃_m being the middle film ratio of the runs; L + L′ f and C exp(C′ f). With δc ∝ δ̃^p at one
//! diameter L = ln(δc/ε) has the slope L′ = p; C′ is the power of the film ratio by which the inertial loss departs from
//! its form. Empirical: neither is in the paper, which asks whether they vanish.

use super::nodes::WetBlock;
use super::sums::BlockSums;
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::{Balance, BalanceAtFilm};
use crate::physics::coefficient::Coefficients;
use crate::physics::loss::Share;
use crate::physics::Form;
use crate::runs::Runs;

/// The film ratio in the middle of the wet runs, their geometric mean: there L and C are what they are without trends.
pub(crate) fn middle_film_ratio(runs: &Runs) -> f64 {
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

/// What of a full vector of parameters the losses read, once for all films.
#[derive(Debug, Clone, Copy)]
pub(super) struct FilmParameters {
    form: Form,
    values: Coefficients,
    /// L′
    lubrication_trend: f64,
    /// C′
    inertial_trend: f64,
}

/// What the trends make of L and C at one film ratio.
#[derive(Debug, Clone, Copy)]
struct Trends {
    /// L′ f
    added: f64,
    /// exp(C′ f)
    grown: f64,
}

impl FilmParameters {
    #[inline]
    pub fn new(form: Form, full: &[f64]) -> FilmParameters {
        FilmParameters {
            form,
            values: Coefficients::first_of(full),
            lubrication_trend: full[ParameterKind::LubricationTrend.slot()],
            inertial_trend: full[ParameterKind::InertialTrend.slot()],
        }
    }

    /// What the losses take at a film ratio with this f.
    #[inline]
    pub fn share(&self, film_ratio: f64, ln_film: f64) -> Share {
        self.trends(ln_film).of(self.form.share(film_ratio, &self.values))
    }

    /// The same with slopes.
    #[inline]
    pub fn losses(&self, film_ratio: f64, ln_film: f64) -> FilmLosses {
        let plain = BalanceAtFilm::new(self.form, film_ratio, &self.values);
        let trends = self.trends(ln_film);
        FilmLosses {
            plain,
            share: trends.of(plain.share),
            trends,
            ln_film,
        }
    }

    #[inline]
    fn trends(&self, ln_film: f64) -> Trends {
        Trends {
            added: self.lubrication_trend * ln_film,
            // an exponential a film is felt, and most models have no trend
            grown: if self.inertial_trend == 0.0 {
                1.0
            } else {
                (self.inertial_trend * ln_film).exp()
            },
        }
    }
}

impl Trends {
    #[inline]
    fn of(self, plain: Share) -> Share {
        Share {
            inertial: plain.inertial * self.grown,
            viscous: plain.viscous + self.added,
        }
    }
}

/// What the parameters say at one film ratio, with slopes.
#[derive(Debug, Clone, Copy)]
pub(super) struct FilmLosses {
    /// what the losses take without trends, with slopes
    plain: BalanceAtFilm,
    /// what they take with them
    share: Share,
    trends: Trends,
    /// f
    ln_film: f64,
}

impl FilmLosses {
    /// The energy balance of runs with this film ratio.
    pub fn balance(&self, form: Form, k: f64, density_ratio: f64) -> Balance {
        Balance::at(form, k, self.share, density_ratio)
    }

    /// Slopes of r turned into those of the parameters, over all blocks of this film ratio.
    pub fn add_slopes(&self, sums: FilmSums, slopes: &mut [f64]) {
        let kept = sums.inertial * self.trends.grown;
        // theirs come first
        for (slope, share) in slopes.iter_mut().zip(&self.plain.slopes) {
            *slope -= kept * share.inertial + sums.viscous * share.viscous;
        }
        slopes[ParameterKind::LubricationTrend.slot()] -= sums.viscous * self.ln_film;
        slopes[ParameterKind::InertialTrend.slot()] -= kept * self.plain.share.inertial * self.ln_film;
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
    /// Adds those of a block; its slopes in k and in its offset go to the slopes of the parameters at once.
    pub fn add(&mut self, block: &WetBlock, sums: BlockSums, slopes: &mut [f64]) {
        self.inertial += sums.kept * block.density_ratio;
        self.viscous += sums.viscous;
        slopes[COMMON_SLOTS + block.sphere] -= 2.0 * sums.dry;
        if let Some(slot) = block.offset {
            slopes[slot] += sums.kept;
        }
    }
}
