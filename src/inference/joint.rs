//! Puts every run in a row of one joint fit, the dry law for dry runs and the energy balance for wet ones: what it leaves,
//! with its slopes.
//!
//! The restitution of a wet run is m(r), defined where the square root is not: a lucky rebound at a setting that keeps no
//! energy on average is noise, and must not bound the parameters as the square root's domain would. Parameters are those
//! of the form that particles share, then k of each sphere. Whatever wants residuals, slopes or sums of them over runs
//! takes them from here.

use std::ops::Range;

use nalgebra::DMatrix;

use super::effective_variance::{ErrorColumns, RunInSpeed, SpeedDependent};
use super::law::SpeedResponse;
use super::least_squares::{fit, no_scatter_left, Fit, OutOfDomain, ResidualProblem};
use super::linearised_joint::Inverse;
use super::sums::{add_square, Sums};
use crate::model::parameters::ParameterKind;
use crate::physics::balance::{Balance, BalanceAtFilm, Impact, Lost};
use crate::physics::coefficient::Coefficients;
use crate::physics::loss::{Loss, MOST_PARAMETERS};
use crate::physics::{rebound, Coefficient, Form, Parameters};
use crate::runs::{by_film, Conditions, DryGroup, Runs, Series};
use crate::scene::Scene;

/// Most slopes a run has: in k and in the shared parameters.
pub const MOST_SLOPES: usize = 1 + 2 * MOST_PARAMETERS;

/// The runs of a series, or the dry ones of a sphere and diameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// index into [`Runs::spheres`]
    pub sphere: usize,
    /// index into [`Runs::series`]; `None` for dry runs
    pub series: Option<usize>,
    /// mean D, m
    pub diameter: f64,
    /// ρ̃; NaN for dry runs
    density_ratio: f64,
    /// runs that rebounded, as a range of every column of [`Runs`]
    pub rebounds: Range<usize>,
    /// runs that stuck
    pub stuck: Range<usize>,
    /// places of the parameters its runs have slopes in, in the order of the slopes: k first
    pub places: Vec<usize>,
}

impl Part {
    /// The slopes of one of its runs, times a factor, each with its parameter's place.
    pub fn slopes(&self, row: &JointRow, factor: f64) -> Vec<(usize, f64)> {
        let own = self.places.iter().zip(row.slopes);
        own.map(|(place, slope)| (*place, factor * slope)).collect()
    }
}

/// What one run leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRow {
    /// index into the columns of [`Runs`]
    pub run: usize,
    /// r, the energy kept; that of a dry run is 1, as good as all
    pub kept: f64,
    /// m, the restitution of the model
    pub model: f64,
    /// model − restitution
    pub residual: f64,
    /// slopes of the model, in the order of [`Part::places`]; zeros beyond
    pub slopes: [f64; MOST_SLOPES],
    /// τ², what the measurement errors of the run add to the variance about the model; 0 unless handed on by
    /// [`Joint::each_in_log_speed`]
    pub measured: f64,
}

/// The derivatives of a [`JointRow`]'s model in the logarithm of the impact speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InLogSpeed {
    /// m, v m′ and v² m″
    pub response: SpeedResponse,
    /// v J′, in the order of [`JointRow::slopes`]
    pub slopes: [f64; MOST_SLOPES],
}

/// The balance of a part's runs of one film ratio, and the slopes of its losses in the shared parameters.
struct AtSetting {
    balance: Balance,
    slopes: Vec<Lost>,
}

/// The runs of a joint fit under one form of the energy balance.
#[derive(Debug, Clone)]
pub struct Joint<'r> {
    /// the form
    pub form: Form,
    /// all runs of the table
    pub runs: &'r Runs,
    conditions: Conditions<'r>,
    /// the parameters that particles share, first in every point
    pub shared: Vec<Coefficient>,
    /// the spheres whose k follow, as indices into [`Runs::spheres`]
    pub spheres: Vec<usize>,
    /// of each sphere of the runs, the place of its k in a point
    places: Vec<Option<usize>>,
    /// wet parts, then dry ones
    pub parts: Vec<Part>,
}

impl<'r> Joint<'r> {
    /// Wet runs of the spheres that `wet` names and dry runs of those that `dry` names, each in ascending order. Where
    /// the first is empty there are no shared parameters.
    pub fn new(scene: &Scene, runs: &'r Runs, form: Form, wet: &[usize], dry: &[usize]) -> Joint<'r> {
        let mut joint = Joint {
            form,
            runs,
            conditions: Conditions::new(scene, runs, form),
            shared: form.coefficients().filter(|_| !wet.is_empty()).collect(),
            spheres: wet.to_vec(),
            places: vec![None; runs.spheres.len()],
            parts: vec![],
        };
        let dry_alone = dry.iter().filter(|sphere| wet.binary_search(sphere).is_err());
        joint.spheres.extend(dry_alone);
        for (place, sphere) in joint.spheres.iter().enumerate() {
            joint.places[*sphere] = Some(joint.shared.len() + place);
        }
        let place = |sphere: usize, of: &[usize]| joint.places[sphere].filter(|_| of.contains(&sphere));
        let of_series = |(index, series): (usize, &Series)| {
            let place = place(series.sphere, wet)?;
            Some(Part {
                sphere: series.sphere,
                series: Some(index),
                diameter: series.diameter,
                density_ratio: series.density_ratio(scene),
                rebounds: series.rebounds.clone(),
                stuck: series.stuck.clone(),
                places: std::iter::once(place).chain(0..joint.shared.len()).collect(),
            })
        };
        let of_dry = |group: &DryGroup| {
            let place = place(group.sphere, dry)?;
            Some(Part {
                sphere: group.sphere,
                series: None,
                diameter: group.diameter,
                density_ratio: f64::NAN,
                rebounds: group.rebounds.clone(),
                stuck: group.stuck.clone(),
                places: vec![place],
            })
        };
        let wet_parts = runs.series.iter().enumerate().filter_map(of_series);
        joint.parts = wet_parts.chain(runs.dry.iter().filter_map(of_dry)).collect();
        joint
    }

    /// The spheres of the dry parts, in their order.
    pub fn dry_spheres(&self) -> Vec<usize> {
        let mut spheres: Vec<usize> = self.dry_parts().map(|part| part.sphere).collect();
        spheres.dedup();
        spheres
    }

    /// How many parameters a point has.
    pub fn parameters(&self) -> usize {
        self.shared.len() + self.spheres.len()
    }

    /// Place of a sphere's k in a point; `None` for one that is not in the fit.
    pub fn place(&self, sphere: usize) -> Option<usize> {
        self.places[sphere]
    }

    /// What the parameters of a point are, in their order.
    pub fn kinds(&self) -> impl Iterator<Item = ParameterKind> + '_ {
        let shared = self
            .shared
            .iter()
            .map(|coefficient| ParameterKind::Shared(*coefficient));
        shared.chain(self.spheres.iter().map(|sphere| ParameterKind::DryK(*sphere)))
    }

    /// The value of a shared parameter at a point; `None` of one the form lacks.
    pub fn value(&self, coefficient: Coefficient, point: &[f64]) -> Option<f64> {
        let place = self.shared.iter().position(|own| *own == coefficient)?;
        Some(point[place])
    }

    /// The parameters of one sphere at a point.
    pub fn of_sphere(&self, k: f64, point: &[f64]) -> Parameters {
        let mut shared = Coefficients::default();
        for (coefficient, value) in self.shared.iter().zip(point) {
            shared[*coefficient] = *value;
        }
        Parameters { dry_k: k, shared }
    }

    /// Whether a point lies where the model is defined.
    pub fn holds(&self, point: &[f64]) -> bool {
        let positive = |(own, value): (&Coefficient, &f64)| !own.describe().must_be_positive || *value > 0.0;
        point.iter().all(|x| x.is_finite()) && self.shared.iter().zip(point).all(positive)
    }

    /// Hands on a range of a part's runs in turn, about a point.
    pub fn each(&self, part: &Part, range: Range<usize>, point: &[f64], mut hand_on: impl FnMut(JointRow)) {
        self.each_with(part, range, point, |row, _, _| hand_on(row));
    }

    /// The same with the derivatives in the logarithm of the speed, and with what the runs are measured to err by.
    pub fn each_in_log_speed(
        &self,
        part: &Part,
        range: Range<usize>,
        point: &[f64],
        mut hand_on: impl FnMut(JointRow, InLogSpeed),
    ) {
        self.each_with(part, range, point, |mut row, at, at_setting| {
            let by_speed = self.in_log_speed(part, &row, at, at_setting);
            if let Some(error) = self.runs.errors.get(row.run) {
                let own = error.restitution_sd;
                let with_speed =
                    error.impact_speed_sd / self.runs.impact_speed[row.run] * by_speed.response.error_slope();
                row.measured = own * own + with_speed * with_speed;
            }
            hand_on(row, by_speed);
        });
    }

    fn each_with(
        &self,
        part: &Part,
        range: Range<usize>,
        point: &[f64],
        mut hand_on: impl FnMut(JointRow, &Impact, &AtSetting),
    ) {
        let parameters = self.of_sphere(point[part.places[0]], point);
        let is_dry = part.series.is_none();
        // dry runs have one film ratio, 0
        let of_film = |run: usize| match is_dry {
            true => AtSetting {
                balance: Balance::dry(self.form.dry, parameters.dry_k),
                slopes: vec![],
            },
            false => {
                let at_film = BalanceAtFilm::new(self.form, self.runs.impacts.film_ratio[run], &parameters.shared);
                AtSetting {
                    balance: Balance::at(self.form, parameters.dry_k, at_film.share, part.density_ratio),
                    slopes: at_film.lost_slopes(&self.form, part.density_ratio).collect(),
                }
            }
        };
        by_film(self.runs, range, of_film, |run, at_setting| {
            let mut row = JointRow {
                run,
                kept: 1.0,
                model: 0.0,
                residual: 0.0,
                slopes: [0.0; MOST_SLOPES],
                measured: 0.0,
            };
            let at = if is_dry {
                let at = self.conditions.dry(run);
                [row.model, row.slopes[0], _] = at_setting.balance.e_dry(at.dry_root);
                at
            } else {
                let at = self.conditions.wet(run);
                let (kept, of_k) = at_setting.balance.kept(&at);
                let (model, root) = rebound::mean_and_slope(kept);
                (row.kept, row.model, row.slopes[0]) = (kept, model, root * of_k);
                for (own, slope) in row.slopes[1..].iter_mut().zip(&at_setting.slopes) {
                    *own = root * slope.slope_of_kept(&at);
                }
                at
            };
            row.residual = row.model - self.runs.restitution[run];
            hand_on(row, &at, at_setting);
        });
    }

    fn in_log_speed(&self, part: &Part, row: &JointRow, at: &Impact, at_setting: &AtSetting) -> InLogSpeed {
        let balance = &at_setting.balance;
        let mut slopes = [0.0; MOST_SLOPES];
        let [slope, bend] = if part.series.is_none() {
            // v d/dv is a fifth of k d/dk
            let [_, first, second] = balance.e_dry(at.dry_root);
            slopes[0] = 0.2 * (first + balance.dry_k * second);
            balance.order.in_log_speed(balance.dry_k * at.dry_root)
        } else {
            let [first, second] = balance.in_log_speed(at);
            let root = rebound::slope_mean_restitution(row.kept);
            let turn = rebound::bend_mean_restitution(row.kept);
            slopes[0] = turn * first * balance.kept(at).1 + root * balance.in_log_speed_slope_k(at);
            for (own, slope) in slopes[1..].iter_mut().zip(&at_setting.slopes) {
                // 4/St falls with 1/v
                *own = turn * first * slope.slope_of_kept(at) + root * slope.over_stokes * at.over_stokes;
            }
            [root * first, turn * first * first + root * second]
        };
        let value = row.model;
        InLogSpeed {
            response: SpeedResponse { value, slope, bend },
            slopes,
        }
    }

    /// The restitution of every wet rebound at a point.
    pub fn expected(&self, point: &[f64]) -> Vec<f64> {
        let mut expected = Vec::with_capacity(self.wet_rebounds());
        for part in self.wet_parts() {
            self.each(part, part.rebounds.clone(), point, |row| expected.push(row.model));
        }
        expected
    }

    /// Sums over the rebounds of some parts about a point, without weights.
    pub fn sums<'p>(&self, parts: impl Iterator<Item = &'p Part>, point: &[f64]) -> Sums {
        let mut sums = Sums::new(self.parameters());
        let mut measured = 0;
        for part in parts {
            measured += self.runs.measured(part.rebounds.clone());
            self.each(part, part.rebounds.clone(), point, |row| {
                let root = self.runs.count(row.run).sqrt();
                sums.add(root * row.residual, &part.slopes(&row, root));
            });
        }
        // not the rows that stand for them
        sums.runs = measured;
        sums
    }

    /// The parts of wet runs.
    pub fn wet_parts(&self) -> impl Iterator<Item = &Part> + Clone {
        self.parts.iter().filter(|part| part.series.is_some())
    }

    /// The parts of dry runs.
    pub fn dry_parts(&self) -> impl Iterator<Item = &Part> + Clone {
        self.parts.iter().filter(|part| part.series.is_none())
    }

    /// Rows of wet rebounds.
    pub fn wet_rebounds(&self) -> usize {
        self.wet_parts().map(|part| part.rebounds.len()).sum()
    }

    /// Wet rebounds that were measured, for which the rows stand.
    pub fn measured_rebounds(&self) -> usize {
        self.wet_parts()
            .map(|part| self.runs.measured(part.rebounds.clone()))
            .sum()
    }
}

/// What is known of one k besides the runs, in a row of its own: (k − value) · root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// place of the k in a point
    pub place: usize,
    /// its value
    pub value: f64,
    /// root of the weight
    pub root: f64,
}

/// A joint fit as a least-squares problem: wet rebounds, then dry ones, then what else is known of a k.
#[derive(Debug, Clone)]
pub struct JointFit<'r> {
    /// the runs
    pub joint: Joint<'r>,
    /// k of each sphere of the fit by its dry runs, or by what else is known of it
    pub own_k: Vec<f64>,
    /// root of the weight of each dry rebound against a wet one, in the order of the parts
    pub dry_roots: Vec<f64>,
    /// what is known of k beyond the runs
    pub known: Vec<Known>,
}

impl JointFit<'_> {
    /// Hands on every rebound about a point, with its place among the residuals and the root of its weight.
    pub fn each_rebound(&self, b: &[f64], mut hand_on: impl FnMut(usize, &Part, f64, JointRow)) {
        let wet = self.joint.wet_rebounds();
        let mut row: usize = 0;
        for part in &self.joint.parts {
            self.joint.each(part, part.rebounds.clone(), b, |one| {
                let root = row.checked_sub(wet).map_or(1.0, |dry| self.dry_roots[dry]);
                hand_on(row, part, root * self.joint.runs.count(one.run).sqrt(), one);
                row += 1;
            });
        }
    }

    fn rebounds(&self) -> usize {
        self.joint.wet_rebounds() + self.dry_roots.len()
    }

    /// Sums over all residuals about a point, each times a root of its own besides the fit's, without roots times 1; `None`
    /// outside the domain.
    ///
    /// To the information is added what the bend of m(r) has of the squares' curvature where it adds to it: without it,
    /// steps leap to and fro over a run near r = 0 that rebounded by luck.
    pub fn sums_at(&self, roots: &[f64], b: &[f64]) -> Option<Sums> {
        if !self.joint.holds(b) {
            return None;
        }
        let root_of = |residual: usize| roots.get(residual).copied().unwrap_or(1.0);
        let mut sums = Sums::new(self.joint.parameters());
        self.each_rebound(b, |residual, part, root, row| {
            let root = root * root_of(residual);
            let slopes = part.slopes(&row, root);
            sums.add(root * row.residual, &slopes);
            let bent = row.residual * rebound::bend_mean_restitution(row.kept)
                / rebound::slope_mean_restitution(row.kept).powi(2);
            if part.series.is_some() && bent > 0.0 {
                add_square(&mut sums.information, bent, &slopes);
            }
        });
        for (known, residual) in self.known.iter().zip(self.rebounds()..) {
            let root = known.root * root_of(residual);
            sums.add((b[known.place] - known.value) * root, &[(known.place, root)]);
        }
        sums.squares.is_finite().then_some(sums)
    }

    /// Values to start from: of parameters that enter the energy linearly the best line through e², over a grid of the
    /// others; and the same with the viscous loss lowered until every rebound keeps energy. A run near r = 0 can hold a
    /// fit on its own side of the turn.
    fn starts(&self) -> [Vec<f64>; 2] {
        let lines = grid(&self.joint.shared).into_iter().map(|tried| self.line(&tried));
        let best = lines.min_by(|(_, one), (_, other)| one.total_cmp(other));
        let line = best.map_or_else(|| self.own_k.clone(), |(point, _)| point);
        let lowered = self.lowered(&line);
        [line, lowered]
    }

    /// The best line through e² with some parameters held at tried values; and its residual sum of squares.
    fn line(&self, tried: &[Option<f64>]) -> (Vec<f64>, f64) {
        let mut point: Vec<f64> = tried.iter().map(|held| held.unwrap_or(0.0)).collect();
        point.extend(&self.own_k);
        let free: Vec<usize> = (0..tried.len()).filter(|place| tried[*place].is_none()).collect();
        let mut sums = Sums::new(free.len());
        self.each_wet_energy(&point, |run, kept, slopes| {
            let (e, root) = (self.joint.runs.restitution[run], self.joint.runs.count(run).sqrt());
            let slopes = free.iter().map(|place| root * slopes[*place]);
            let slopes: Vec<(usize, f64)> = slopes.enumerate().collect();
            sums.add(root * (e * e - kept), &slopes);
        });
        // one film ratio and one density ratio, say: a line cannot tell the two losses apart, nor need a start
        let found = Inverse::of(&sums.information).matrix * &sums.gradient;
        for (place, value) in free.iter().zip(&found) {
            point[*place] = *value;
        }
        (point, sums.squares - found.dot(&sums.gradient))
    }

    /// A point with the parameter that scales the viscous loss as low as every rebound needs to keep energy.
    fn lowered(&self, line: &[f64]) -> Vec<f64> {
        /// energy kept at least
        const KEPT: f64 = 0.02;
        /// decades tried of one that does not enter linearly
        const DECADES: usize = 12;
        let mut lowered = line.to_vec();
        let viscous = self.joint.form.viscous;
        for (place, coefficient) in self.joint.shared.iter().enumerate() {
            if !viscous.coefficients().contains(coefficient) {
                continue;
            }
            if coefficient.describe().grid.is_empty() {
                let mut without = line.to_vec();
                without[place] = 0.0;
                self.each_wet_energy(&without, |_, kept, slopes| {
                    lowered[place] = lowered[place].min((KEPT - kept) / slopes[place]);
                });
                continue;
            }
            for _ in 0..DECADES {
                let mut least = f64::INFINITY;
                self.each_wet_energy(&lowered, |_, kept, _| least = least.min(kept));
                if least >= KEPT {
                    break;
                }
                lowered[place] *= 0.1;
            }
        }
        lowered
    }

    /// Hands on every wet rebound, by its number, with its r and the slopes of that in the shared parameters.
    fn each_wet_energy(&self, point: &[f64], mut hand_on: impl FnMut(usize, f64, &[f64])) {
        for part in self.joint.wet_parts() {
            let range = part.rebounds.clone();
            self.joint.each_with(part, range, point, |row, at, at_setting| {
                let slopes: Vec<f64> = at_setting.slopes.iter().map(|own| own.slope_of_kept(at)).collect();
                hand_on(row.run, row.kept, &slopes);
            });
        }
    }
}

/// Every combination of the values to try of parameters that do not enter linearly; `None` of one that does.
fn grid(shared: &[Coefficient]) -> Vec<Vec<Option<f64>>> {
    shared.iter().fold(vec![vec![]], |so_far, coefficient| {
        let values: Vec<Option<f64>> = match coefficient.describe().grid {
            [] => vec![None],
            grid => grid.iter().copied().map(Some).collect(),
        };
        let longer = |start: &Vec<Option<f64>>| -> Vec<_> {
            let with = |value: &Option<f64>| [&start[..], &[*value]].concat();
            values.iter().map(with).collect()
        };
        so_far.iter().flat_map(longer).collect()
    })
}

impl ResidualProblem for JointFit<'_> {
    fn parameters(&self) -> usize {
        self.joint.parameters()
    }
    fn runs(&self) -> usize {
        self.rebounds() + self.known.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        if !self.joint.holds(b) {
            return Err(OutOfDomain);
        }
        self.each_rebound(b, |row, _, root, one| residuals[row] = root * one.residual);
        for (residual, known) in residuals[self.rebounds()..].iter_mut().zip(&self.known) {
            *residual = (b[known.place] - known.value) * known.root;
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        jacobian.fill(0.0);
        self.each_rebound(b, |row, part, root, one| {
            for (place, slope) in part.slopes(&one, root) {
                jacobian[(row, place)] = slope;
            }
        });
        for (row, known) in (self.rebounds()..).zip(&self.known) {
            jacobian[(row, known.place)] = known.root;
        }
        Ok(())
    }
    fn scale(&self) -> f64 {
        1.0
    }
}

impl SpeedDependent for JointFit<'_> {
    fn own_freedom(&self) -> usize {
        self.dry_roots.len() - self.joint.dry_spheres().len()
    }
    fn own_squares(&self) -> f64 {
        // no dry run reads the shared parameters
        let mut own = vec![0.0; self.joint.shared.len()];
        own.extend(&self.own_k);
        let (mut squares, mut row) = (0.0, 0);
        for part in self.joint.dry_parts() {
            self.joint.each(part, part.rebounds.clone(), &own, |one| {
                squares += self.joint.runs.count(one.run) * (self.dry_roots[row] * one.residual).powi(2);
                row += 1;
            });
        }
        squares
    }
    fn each_in_speed(&self, b: &[f64], _: &ErrorColumns, hand_on: RunInSpeed) -> Result<(), OutOfDomain> {
        if !self.joint.holds(b) {
            return Err(OutOfDomain);
        }
        for part in self.joint.wet_parts() {
            let range = part.rebounds.clone();
            self.joint.each_in_log_speed(part, range, b, |one, by_speed| {
                let both = part.places.iter().zip(one.slopes.iter().zip(&by_speed.slopes));
                let slopes: Vec<_> = both
                    .map(|(place, (own, in_speed))| (*place, [*own, *in_speed]))
                    .collect();
                hand_on(by_speed.response, &slopes);
            });
        }
        Ok(())
    }
}

/// Fits; no starting values asked.
pub fn fit_joint(problem: &JointFit) -> Fit {
    let [line, lowered] = problem.starts();
    let (wet, shared) = (problem.joint.wet_rebounds(), problem.joint.shared.len());
    if wet < shared {
        return Fit::without_enough_runs(&line, wet, shared);
    }
    let first = fit(problem, &line);
    if lowered == line {
        return with_wet_spread(problem, first);
    }
    let second = fit(problem, &lowered);
    let rank = |fit: &Fit| (!fit.converged(), fit.residual_sum_of_squares);
    let best = if rank(&second) < rank(&first) { second } else { first };
    with_wet_spread(problem, best)
}

/// The fit with the spread of the wet runs about the law that is theirs: what the dry runs scatter by about their own k has
/// been weighed to be as large, and is taken off.
fn with_wet_spread(problem: &JointFit, fit: Fit) -> Fit {
    let wet = problem.joint.measured_rebounds();
    let freedom = wet.saturating_sub(problem.joint.shared.len());
    if fit.residual_sd.is_none() || freedom == 0 {
        let why = fit.covariance.err();
        return Fit {
            covariance: Err(why.unwrap_or_else(|| no_scatter_left(problem.joint.shared.len()))),
            residual_sd: None,
            degrees_of_freedom: freedom,
            ..fit
        };
    }
    let squares = (fit.residual_sum_of_squares - problem.own_squares()).max(0.0);
    fit.with_spread(squares, freedom)
}
