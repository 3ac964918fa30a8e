//! Reads what the losses take of a film from the parameters, with the trends of L and C, and turns slopes of r into those of
//! parameters.
//!
//! A film enters by the shape g(δ̃) of the inertial loss and by the trends alone; what the viscous loss takes over 4/St is
//! the same at every film.
//!
//! Symbols: f = ln(δ̃/δ̃_m), δ̃_m being the middle film ratio of the runs; L + L′ f and C exp(C′ f). With δc ∝ δ̃^p at one
//! diameter L = ln(δc/ε) has the slope L′ = p; C′ is the power of the film ratio by which the inertial loss departs from
//! its form. Empirical: neither is in the paper, which asks whether they vanish.

use super::block_sums::BlockSums;
use super::nodes::{NodeFilm, Nodes, WetBlock};
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

    /// What the losses take at a film ratio with this f.
    #[inline]
    pub fn share(&self, film_ratio: f64, ln_film: f64) -> Share {
        let shape = self.form.inertia.shape(film_ratio, self.film_scale);
        self.share_of_shape(shape * self.grown(ln_film), ln_film)
    }

    #[inline]
    fn share_of_shape(&self, grown_shape: f64, ln_film: f64) -> Share {
        Share {
            inertial: self.prefactor * grown_shape,
            viscous: self.viscous() + self.lubrication_trend * ln_film,
        }
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
    pub fn shapes(&self, films: FilmColumns, fused: bool, to: &mut [[f64; CHUNK]; 2]) {
        let count = films.ratio.len();
        let [shapes, slopes] = to.each_mut().map(|buffer| &mut buffer[..count]);
        if self.form.inertia.has_film_scale() {
            for ((shape, slope), ratio) in shapes.iter_mut().zip(slopes.iter_mut()).zip(films.ratio) {
                (*shape, *slope) = Inertia::saturating_shape_and_slope(*ratio, self.film_scale, fused);
            }
        } else {
            shapes.copy_from_slice(films.shape);
        }
        if self.inertial_trend != 0.0 {
            for ((shape, slope), ln) in shapes.iter_mut().zip(slopes.iter_mut()).zip(films.ln) {
                let grown = exponential(self.inertial_trend * ln, fused);
                *shape *= grown;
                *slope *= grown;
            }
        }
    }
}

/// Nodes whose shapes are computed at a time.
pub(super) const CHUNK: usize = 64;

/// The films of some nodes, as columns.
#[derive(Clone, Copy)]
pub(super) struct FilmColumns<'n> {
    /// δ̃
    pub ratio: &'n [f64],
    /// f
    pub ln: &'n [f64],
    /// g(δ̃); empty where a parameter moves it
    pub shape: &'n [f64],
}

/// The energy balance of the runs of a block, whatever their films.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockLaw {
    pub films: FilmParameters,
    pub dry_k: f64,
    pub density_ratio: f64,
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

impl BlockLaw {
    /// At the film of a node.
    pub fn at(&self, film: NodeFilm) -> FilmLaw {
        let films = &self.films;
        let grown = films.grown(film.ln);
        let (shape, slope) = match film.shape {
            Some(shape) => (shape, 0.0),
            None => films
                .form
                .inertia
                .shape_and_slope_film_scale(film.ratio, films.film_scale),
        };
        let shape = [shape * grown, slope * grown];
        let share = films.share_of_shape(shape[0], film.ln);
        FilmLaw {
            balance: Balance::at(films.form, self.dry_k, share, self.density_ratio).with_offset(self.offset),
            ln_film: film.ln,
            shape,
        }
    }

    /// Turns the slopes of r, summed over the runs of a block, into those of the parameters.
    pub fn add_slopes(&self, block: &WetBlock, sums: &BlockSums, slopes: &mut [f64]) {
        let films = &self.films;
        let inertial = self.density_ratio * films.prefactor;
        if films.form.inertia != Inertia::None {
            slopes[Coefficient::InertialPrefactor as usize] -= self.density_ratio * sums.shape;
            slopes[ParameterKind::InertialTrend.slot()] -= inertial * sums.inertial_trend;
        }
        if films.form.inertia.has_film_scale() {
            slopes[Coefficient::FilmScale as usize] -= inertial * sums.scale;
        }
        for of_viscous in films.viscous.slopes.into_iter().flatten() {
            slopes[of_viscous.of as usize] -= sums.viscous * of_viscous.share.viscous;
        }
        slopes[ParameterKind::LubricationTrend.slot()] -= sums.viscous_trend;
        slopes[COMMON_SLOTS + block.sphere] -= 2.0 * sums.dry;
        if let Some(slot) = block.offset {
            slopes[slot] += sums.kept;
        }
    }
}

/// The films of nodes one after the other: neighbours mostly share one, and an exponential costs more than the rest.
pub(super) struct NodeFilms<'n> {
    nodes: &'n Nodes,
    law: &'n BlockLaw,
    last: Option<(NodeFilm, FilmLaw)>,
}

impl Nodes {
    /// The energy balance of a block at the films of its nodes.
    pub(super) fn films<'n>(&'n self, law: &'n BlockLaw) -> NodeFilms<'n> {
        NodeFilms {
            nodes: self,
            law,
            last: None,
        }
    }
}

impl NodeFilms<'_> {
    /// At the film of a node.
    pub fn at(&mut self, node: usize) -> FilmLaw {
        let film = self.nodes.film(node);
        match self.last {
            Some((same, law)) if same == film => law,
            _ => self.last.insert((film, self.law.at(film))).1,
        }
    }
}

impl FilmLaw {
    /// Adds the slopes of runs at this film: in r, in −L, and in k, the last by 2 e_dry.
    #[inline]
    pub fn add(&self, sums: &mut BlockSums, kept: f64, viscous: f64, dry: f64) {
        let [shape, scale] = self.shape.map(|of_film| kept * of_film);
        sums.kept += kept;
        sums.viscous += viscous;
        sums.dry += dry;
        sums.shape += shape;
        sums.scale += scale;
        sums.viscous_trend += viscous * self.ln_film;
        sums.inertial_trend += shape * self.ln_film;
    }
}
