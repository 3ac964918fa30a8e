//! Reads what the losses take of a film from the parameters, with the trends of L and C, and turns slopes of r into those of
//! parameters.
//!
//! A film enters by the shape g(δ̃) of the inertial loss and by the trends alone; what the viscous loss takes over 4/St is
//! the same at every film.
//!
//! Symbols: f = ln(δ̃/δ̃_m), δ̃_m being the middle film ratio of the runs; L + L′ f and C exp(C′ f). With δc ∝ δ̃^p at one
//! diameter L = ln(δc/ε) has the slope L′ = p; C′ is the power of the film ratio by which the inertial loss departs from
//! its form. Empirical: neither is in the paper, which asks whether they vanish.

use std::ops::Range;

use super::nodes::{Block, Film, Nodes};
use super::run_density::BlockSums;
use crate::exponential::exponential;
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Balance;
use crate::physics::coefficient::{Coefficient, Coefficients};
use crate::physics::loss::{AtFilm, Loss, Share};
use crate::physics::{Form, Inertia};
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
    pub form: Form,
    /// C; 0 without an inertial loss
    pub prefactor: f64,
    /// δ̃0
    film_scale: f64,
    /// the viscous loss without its trend
    viscous: AtFilm,
    /// L′
    pub lubrication_trend: f64,
    /// C′
    inertial_trend: f64,
}

impl FilmParameters {
    #[inline]
    pub fn new(form: Form, full: &[f64]) -> FilmParameters {
        let values = Coefficients::first_of(full);
        FilmParameters {
            form,
            prefactor: if form.inertia == Inertia::None {
                0.0
            } else {
                values[Coefficient::InertialPrefactor]
            },
            film_scale: values[Coefficient::FilmScale],
            // of any film
            viscous: form.viscous.at(0.0, &values),
            lubrication_trend: full[ParameterKind::LubricationTrend.slot()],
            inertial_trend: full[ParameterKind::InertialTrend.slot()],
        }
    }

    /// L, or what stands in its place, without its trend.
    pub fn viscous(&self) -> f64 {
        self.viscous.share.viscous
    }

    /// exp(C′ f)
    #[inline]
    fn grown(&self, ln_film: f64) -> f64 {
        // an exponential a film is felt, and most models have no trend
        if self.inertial_trend == 0.0 {
            1.0
        } else {
            (self.inertial_trend * ln_film).exp()
        }
    }

    /// Writes g exp(C′ f) of some nodes, and its slope in δ̃0 where it has one.
    #[inline(always)]
    pub fn shapes(&self, nodes: &Nodes, chunk: Range<usize>, fused: bool, to: &mut [[f64; CHUNK]; 2]) {
        let [shapes, slopes] = to.each_mut().map(|buffer| &mut buffer[..chunk.len()]);
        if self.form.inertia.has_film_scale() {
            let ratios = &nodes.film_ratio[chunk.clone()];
            for ((shape, slope), ratio) in shapes.iter_mut().zip(slopes.iter_mut()).zip(ratios) {
                (*shape, *slope) = Inertia::saturating_shape_and_slope(*ratio, self.film_scale, fused);
            }
        } else {
            shapes.copy_from_slice(&nodes.shape[chunk.clone()]);
        }
        if self.inertial_trend != 0.0 {
            for ((shape, slope), ln) in shapes.iter_mut().zip(slopes.iter_mut()).zip(&nodes.ln_film[chunk]) {
                let grown = exponential(self.inertial_trend * ln, fused);
                *shape *= grown;
                *slope *= grown;
            }
        }
    }
}

/// Nodes whose shapes are computed at a time.
pub(super) const CHUNK: usize = 64;

/// The energy balance of the runs of a block, whatever their films.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockLaw {
    pub block: Block,
    pub films: FilmParameters,
    pub dry_k: f64,
    /// that of the series, 0 where series have none
    pub offset: f64,
}

/// The energy balance at one film, with the shape of the inertial loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FilmLaw {
    pub balance: Balance,
    /// f
    ln_film: f64,
    /// g exp(C′ f), and its slope in δ̃0
    shape: [f64; 2],
}

impl Block {
    /// The energy balance at a full vector of parameters, which `films` has read.
    pub fn law(&self, films: FilmParameters, full: &[f64]) -> BlockLaw {
        BlockLaw {
            block: *self,
            films,
            dry_k: full[COMMON_SLOTS + self.sphere],
            offset: self.offset.map_or(0.0, |slot| full[slot]),
        }
    }
}

impl BlockLaw {
    /// At a film; a dry block has none.
    pub fn at(&self, film: Film) -> FilmLaw {
        let films = &self.films;
        if !self.block.wet {
            return FilmLaw {
                balance: Balance::dry(films.form.dry, self.dry_k),
                ln_film: 0.0,
                shape: [0.0; 2],
            };
        }
        let grown = films.grown(film.ln);
        let (shape, slope) = match film.shape {
            Some(shape) => (shape, 0.0),
            None => films
                .form
                .inertia
                .shape_and_slope_film_scale(film.ratio, films.film_scale),
        };
        let share = Share {
            inertial: films.prefactor * shape * grown,
            viscous: films.viscous() + films.lubrication_trend * film.ln,
        };
        FilmLaw {
            balance: Balance::at(films.form, self.dry_k, share, self.block.density_ratio).with_offset(self.offset),
            ln_film: film.ln,
            shape: [shape * grown, slope * grown],
        }
    }

    /// Turns the slopes of r, summed over the runs of a block, into those of the parameters.
    pub fn add_slopes(&self, sums: &BlockSums, slopes: &mut [f64]) {
        let (block, films) = (&self.block, &self.films);
        let [kept, viscous, dry_k, shape, scale, viscous_trend, inertial_trend] = *sums;
        slopes[COMMON_SLOTS + block.sphere] += dry_k;
        if !block.wet {
            return;
        }
        let inertial = block.density_ratio * films.prefactor;
        if films.form.inertia != Inertia::None {
            slopes[Coefficient::InertialPrefactor as usize] -= block.density_ratio * shape;
            slopes[ParameterKind::InertialTrend.slot()] -= inertial * inertial_trend;
        }
        if films.form.inertia.has_film_scale() {
            slopes[Coefficient::FilmScale as usize] -= inertial * scale;
        }
        for of_viscous in films.viscous.slopes.into_iter().flatten() {
            slopes[of_viscous.of as usize] -= viscous * of_viscous.share.viscous;
        }
        slopes[ParameterKind::LubricationTrend.slot()] -= viscous_trend;
        if let Some(slot) = block.offset {
            slopes[slot] += kept;
        }
    }
}

impl FilmLaw {
    /// Adds so many times the slopes of runs at this film: in r, in −L and in k.
    #[inline]
    pub fn add(&self, sums: &mut BlockSums, [kept, viscous, dry_k]: [f64; 3], count: f64) {
        let [shape, scale] = self.shape.map(|of_film| kept * of_film);
        let trends = [viscous, shape].map(|slope| slope * self.ln_film);
        let terms = [kept, viscous, dry_k, shape, scale, trends[0], trends[1]];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += count * term;
        }
    }
}
