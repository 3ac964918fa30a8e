//! Puts every run in a row of one joint fit, the dry law for dry runs and the energy balance for wet ones: what it leaves,
//! with its slopes.
//!
//! The restitution of a wet run is m(r), defined where the square root is not: a lucky rebound at a setting that keeps no
//! energy on average is noise, and must not bound the parameters as the square root's domain would. Parameters are those
//! of the form that particles share, then k of each sphere. Whatever wants residuals, slopes or sums of them over runs
//! takes them from here.

use std::ops::{Deref, Range};

use nalgebra::{DMatrix, DVector};

use super::effective_variance::{ErrorColumns, SpeedDependent, SpeedDerivatives};
use super::law::SpeedResponse;
use super::least_squares::{fit, no_scatter_left, Fit, OutOfDomain, ResidualProblem, Stop};
use super::sums::Sums;
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
    /// The slopes of one of its runs, times a factor.
    pub fn slopes(&self, row: &JointRow, factor: f64) -> RowSlopes {
        let blank = RowSlopes {
            all: [(0, 0.0); 1 + MOST_SLOPES],
            used: 0,
        };
        let own = self.places.iter().zip(row.slopes);
        own.fold(blank, |slopes, (place, slope)| slopes.and(*place, factor * slope))
    }
}

/// The slopes of one run, each with its parameter's place.
#[derive(Debug, Clone, Copy)]
pub struct RowSlopes {
    all: [(usize, f64); 1 + MOST_SLOPES],
    used: usize,
}

impl RowSlopes {
    /// The same and the slope in one number besides the parameters.
    pub fn and(mut self, place: usize, slope: f64) -> RowSlopes {
        self.all[self.used] = (place, slope);
        self.used += 1;
        self
    }
}

impl Deref for RowSlopes {
    type Target = [(usize, f64)];
    fn deref(&self) -> &[(usize, f64)] {
        &self.all[..self.used]
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
    /// τ², what the measurement errors of the run add to the variance about the model; 0 unless asked for by
    /// [`Joint::each_measured`]
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
    slopes: [Option<Lost>; MOST_SLOPES - 1],
}

impl AtSetting {
    fn new(form: Form, part: &Part, film_ratio: f64, parameters: &Parameters) -> AtSetting {
        let at_film = BalanceAtFilm::new(form, film_ratio, &parameters.shared);
        let mut slopes = [None; MOST_SLOPES - 1];
        for (own, lost) in slopes.iter_mut().zip(at_film.lost_slopes(&form, part.density_ratio)) {
            *own = Some(lost);
        }
        AtSetting {
            balance: Balance::at(form, parameters.dry_k, at_film.share, part.density_ratio),
            slopes,
        }
    }
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
        for (index, series) in runs.series.iter().enumerate() {
            let place = joint.places[series.sphere].filter(|_| wet.binary_search(&series.sphere).is_ok());
            if let Some(place) = place {
                joint.add_wet(scene, series, index, place);
            }
        }
        for group in &runs.dry {
            let place = joint.places[group.sphere].filter(|_| dry.binary_search(&group.sphere).is_ok());
            if let Some(place) = place {
                joint.add_dry(group, place);
            }
        }
        joint
    }

    fn add_wet(&mut self, scene: &Scene, series: &Series, index: usize, place: usize) {
        self.parts.push(Part {
            sphere: series.sphere,
            series: Some(index),
            diameter: series.diameter,
            density_ratio: series.density_ratio(scene),
            rebounds: series.rebounds.clone(),
            stuck: series.stuck.clone(),
            places: std::iter::once(place).chain(0..self.shared.len()).collect(),
        });
    }

    fn add_dry(&mut self, group: &DryGroup, place: usize) {
        self.parts.push(Part {
            sphere: group.sphere,
            series: None,
            diameter: group.diameter,
            density_ratio: f64::NAN,
            rebounds: group.rebounds.clone(),
            stuck: group.stuck.clone(),
            places: vec![place],
        });
    }

    /// The spheres of the dry parts, in their order.
    pub fn dry_spheres(&self) -> impl Iterator<Item = usize> + '_ {
        let parts: Vec<&Part> = self.dry_parts().collect();
        let of_one = parts.chunk_by(|a, b| a.sphere == b.sphere).map(|parts| parts[0].sphere);
        of_one.collect::<Vec<usize>>().into_iter()
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

    /// The same with the derivatives in the logarithm of the speed.
    pub fn each_in_log_speed(
        &self,
        part: &Part,
        range: Range<usize>,
        point: &[f64],
        mut hand_on: impl FnMut(JointRow, InLogSpeed),
    ) {
        self.each_with(part, range, point, |row, at, at_setting| {
            hand_on(row, self.in_log_speed(part, &row, at, at_setting))
        });
    }

    /// The same with what the runs are measured to err by.
    pub fn each_measured(&self, part: &Part, range: Range<usize>, point: &[f64], mut hand_on: impl FnMut(JointRow)) {
        let Some(errors) = &self.runs.errors else {
            return self.each(part, range, point, hand_on);
        };
        self.each_in_log_speed(part, range, point, |row, by_speed| {
            let [of_speed, own] = errors.of(row.run);
            let with_speed = of_speed / self.runs.impact_speed[row.run] * (row.model + by_speed.response.slope);
            hand_on(JointRow {
                measured: own * own + with_speed * with_speed,
                ..row
            });
        });
    }

    fn each_with(
        &self,
        part: &Part,
        range: Range<usize>,
        point: &[f64],
        mut hand_on: impl FnMut(JointRow, &Impact, &AtSetting),
    ) {
        let k = point[part.places[0]];
        if part.series.is_none() {
            let at_setting = AtSetting {
                balance: Balance::dry(self.form.dry, k),
                slopes: [None; MOST_SLOPES - 1],
            };
            for run in range {
                let at = self.conditions.dry(run);
                let [model, slope, _] = at_setting.balance.e_dry(at.dry_root);
                let mut slopes = [0.0; MOST_SLOPES];
                slopes[0] = slope;
                let row = JointRow {
                    run,
                    kept: 1.0,
                    model,
                    residual: model - self.runs.restitution[run],
                    slopes,
                    measured: 0.0,
                };
                hand_on(row, &at, &at_setting);
            }
            return;
        }
        let parameters = self.of_sphere(k, point);
        let of_film = |run: usize| AtSetting::new(self.form, part, self.runs.impacts.film_ratio[run], &parameters);
        by_film(self.runs, range, of_film, |run, at_setting| {
            let at = self.conditions.wet(run);
            let (kept, of_k) = at_setting.balance.kept(&at);
            let (model, root) = rebound::mean_and_slope(kept);
            let mut slopes = [0.0; MOST_SLOPES];
            slopes[0] = root * of_k;
            for (own, slope) in slopes[1..].iter_mut().zip(at_setting.slopes.iter().flatten()) {
                *own = root * slope.slope_of_kept(&at);
            }
            let row = JointRow {
                run,
                kept,
                model,
                residual: model - self.runs.restitution[run],
                slopes,
                measured: 0.0,
            };
            hand_on(row, &at, at_setting);
        });
    }

    fn in_log_speed(
        &self,
        part: &Part,
        row: &JointRow,
        at: &Impact,
        AtSetting {
            balance,
            slopes: of_losses,
        }: &AtSetting,
    ) -> InLogSpeed {
        let mut slopes = [0.0; MOST_SLOPES];
        if part.series.is_none() {
            let [slope, bend] = balance.order.in_log_speed(balance.dry_k * at.dry_root);
            // v d/dv is a fifth of k d/dk
            let [_, first, second] = balance.e_dry(at.dry_root);
            slopes[0] = 0.2 * (first + balance.dry_k * second);
            let response = SpeedResponse {
                value: row.model,
                slope,
                bend,
            };
            return InLogSpeed { response, slopes };
        }
        let [first, second] = balance.in_log_speed(at);
        let (root, turn) = (
            rebound::slope_mean_restitution(row.kept),
            rebound::bend_mean_restitution(row.kept),
        );
        let (of_k, in_speed_of_k) = (balance.kept(at).1, balance.in_log_speed_slope_k(at));
        slopes[0] = turn * first * of_k + root * in_speed_of_k;
        for (own, slope) in slopes[1..].iter_mut().zip(of_losses.iter().flatten()) {
            // 4/St falls with 1/v
            *own = turn * first * slope.slope_of_kept(at) + root * slope.over_stokes * at.over_stokes;
        }
        let response = SpeedResponse {
            value: row.model,
            slope: root * first,
            bend: turn * first * first + root * second,
        };
        InLogSpeed { response, slopes }
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

    /// Restitution the model gives each wet rebound, in the order of the parts.
    pub fn wet_model(&self, point: &[f64]) -> Vec<f64> {
        let mut model = vec![];
        for part in self.wet_parts() {
            self.each(part, part.rebounds.clone(), point, |row| model.push(row.model));
        }
        model
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

    /// A point with each sphere's own k, whose shared parameters no dry run reads.
    fn own_start(&self) -> Vec<f64> {
        let mut own = vec![0.0; self.joint.shared.len()];
        own.extend(&self.own_k);
        own
    }

    /// Weighted squares that the dry runs leave of their own k.
    pub fn own_squares(&self) -> f64 {
        self.dry_squares(&self.own_start())
    }

    fn dry_squares(&self, b: &[f64]) -> f64 {
        let (mut squares, mut row) = (0.0, 0);
        for part in self.joint.dry_parts() {
            self.joint.each(part, part.rebounds.clone(), b, |one| {
                squares += self.joint.runs.count(one.run) * (self.dry_roots[row] * one.residual).powi(2);
                row += 1;
            });
        }
        squares
    }

    /// Values to start from: of parameters that enter the energy linearly the best line through e², over a grid of the
    /// others; and the same with the viscous loss lowered until every rebound keeps energy. A run near r = 0 can hold a
    /// fit on its own side of the turn.
    fn starts(&self) -> [Vec<f64>; 2] {
        let mut best: Option<(Vec<f64>, f64)> = None;
        for tried in grid(&self.joint.shared) {
            let (point, squares) = self.line(&tried);
            if best.as_ref().is_none_or(|(_, least)| squares < *least) {
                best = Some((point, squares));
            }
        }
        let line = best.map_or_else(|| self.own_k.clone(), |(point, _)| point);
        let lowered = self.lowered(&line);
        [line, lowered]
    }

    /// The best line through e² with some parameters held at tried values; and its residual sum of squares.
    fn line(&self, tried: &[Option<f64>]) -> (Vec<f64>, f64) {
        let mut point: Vec<f64> = tried.iter().map(|held| held.unwrap_or(0.0)).collect();
        point.extend(&self.own_k);
        let free: Vec<usize> = (0..tried.len()).filter(|place| tried[*place].is_none()).collect();
        let (mut information, mut pull) = (DMatrix::zeros(free.len(), free.len()), DVector::zeros(free.len()));
        let mut squares = 0.0;
        self.each_energy(&point, |left, slopes| {
            squares += left * left;
            for (i, row) in free.iter().enumerate() {
                pull[i] += left * slopes[*row];
                for (j, column) in free.iter().enumerate() {
                    information[(i, j)] += slopes[*row] * slopes[*column];
                }
            }
        });
        let found = solve_leading(&information, &pull);
        for (place, value) in free.iter().zip(&found) {
            point[*place] = *value;
        }
        (point, squares - found.dot(&pull))
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
                self.each_wet_energy(&without, |kept, slopes| {
                    lowered[place] = lowered[place].min((KEPT - kept) / slopes[place]);
                });
                continue;
            }
            for _ in 0..DECADES {
                let mut least = f64::INFINITY;
                self.each_wet_energy(&lowered, |kept, _| least = least.min(kept));
                if least >= KEPT {
                    break;
                }
                lowered[place] *= 0.1;
            }
        }
        lowered
    }

    /// Hands on e² less the energy kept of every wet rebound, with the slopes of the latter in the shared parameters.
    fn each_energy(&self, point: &[f64], mut hand_on: impl FnMut(f64, &[f64; MOST_SLOPES - 1])) {
        let restitution = &self.joint.runs.restitution;
        let mut runs = self.joint.wet_parts().flat_map(|part| part.rebounds.clone());
        self.each_wet_energy(point, |kept, slopes| {
            let (e, count) = runs
                .next()
                .map_or((f64::NAN, 1.0), |run| (restitution[run], self.joint.runs.count(run)));
            let root = count.sqrt();
            hand_on(root * (e * e - kept), &slopes.map(|slope| root * slope));
        });
    }

    /// Hands on r of every wet rebound, and its slopes in the shared parameters.
    fn each_wet_energy(&self, point: &[f64], mut hand_on: impl FnMut(f64, &[f64; MOST_SLOPES - 1])) {
        for part in self.joint.wet_parts() {
            self.joint
                .each_with(part, part.rebounds.clone(), point, |row, at, at_setting| {
                    let mut slopes = [0.0; MOST_SLOPES - 1];
                    for (own, slope) in slopes.iter_mut().zip(at_setting.slopes.iter().flatten()) {
                        *own = slope.slope_of_kept(at);
                    }
                    hand_on(row.kept, &slopes);
                });
        }
    }
}

/// Every combination of the values to try of parameters that do not enter linearly; `None` of one that does.
fn grid(shared: &[Coefficient]) -> Vec<Vec<Option<f64>>> {
    shared.iter().fold(vec![vec![]], |so_far, coefficient| {
        let values = coefficient.describe().grid;
        let with = |start: &Vec<Option<f64>>, value: Option<f64>| {
            let mut longer = start.clone();
            longer.push(value);
            longer
        };
        let each = |start: &Vec<Option<f64>>| -> Vec<Vec<Option<f64>>> {
            match values {
                [] => vec![with(start, None)],
                _ => values.iter().map(|value| with(start, Some(*value))).collect(),
            }
        };
        so_far.iter().flat_map(each).collect()
    })
}

/// The solution of normal equations in as many leading unknowns as they tell apart; the others are 0.
///
/// One film ratio and one density ratio, say: a line cannot tell the two losses apart, nor need a start.
fn solve_leading(information: &DMatrix<f64>, pull: &DVector<f64>) -> DVector<f64> {
    /// share of its square that a slope must have of its own
    const APART: f64 = 1e-12;
    let mut found = DVector::zeros(pull.len());
    for used in (1..=pull.len()).rev() {
        let part = information.view((0, 0), (used, used)).into_owned();
        let Some(root) = part.clone().cholesky() else { continue };
        let own = |j: usize| root.l_dirty()[(j, j)].powi(2) > APART * part[(j, j)];
        if (0..used).all(own) {
            found.rows_mut(0, used).copy_from(&root.solve(&pull.rows(0, used)));
            break;
        }
    }
    found
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
            for (place, slope) in part.slopes(&one, root).iter() {
                jacobian[(row, *place)] = *slope;
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
        self.dry_roots.len() - self.joint.dry_spheres().count()
    }
    fn own_squares(&self) -> f64 {
        JointFit::own_squares(self)
    }
    fn speed_derivatives(&self, b: &[f64], _: &ErrorColumns) -> Result<SpeedDerivatives, OutOfDomain> {
        if !self.joint.holds(b) {
            return Err(OutOfDomain);
        }
        let zeros = || DMatrix::zeros(self.runs(), self.joint.parameters());
        let mut all = SpeedDerivatives {
            response: vec![],
            jacobian: zeros(),
            jacobian_slope: zeros(),
        };
        for part in self.joint.wet_parts() {
            let range = part.rebounds.clone();
            self.joint.each_in_log_speed(part, range, b, |one, by_speed| {
                let row = all.response.len();
                all.response.push(by_speed.response);
                for (j, place) in part.places.iter().enumerate() {
                    all.jacobian[(row, *place)] = one.slopes[j];
                    all.jacobian_slope[(row, *place)] = by_speed.slopes[j];
                }
            });
        }
        Ok(all)
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
    let rank = |fit: &Fit| (fit.stop != Stop::Converged, fit.residual_sum_of_squares);
    let best = if rank(&second) < rank(&first) { second } else { first };
    with_wet_spread(problem, best)
}

/// The fit with the spread of the wet runs about the law that is theirs: what the dry runs scatter by about their own k has
/// been weighed to be as large, and is taken off.
fn with_wet_spread(problem: &JointFit, fit: Fit) -> Fit {
    let wet = problem.joint.measured_rebounds();
    let freedom = wet.saturating_sub(problem.joint.shared.len());
    if fit.residual_sd.is_none() || freedom == 0 {
        return Fit {
            covariance: None,
            residual_sd: None,
            why_no_covariance: fit
                .why_no_covariance
                .or_else(|| Some(no_scatter_left(problem.joint.shared.len()))),
            degrees_of_freedom: freedom,
            ..fit
        };
    }
    let squares = (fit.residual_sum_of_squares - problem.own_squares()).max(0.0);
    let sd = (squares / freedom as f64).sqrt();
    let over = fit.residual_sd.map_or(1.0, |was| (sd / was).powi(2));
    Fit {
        covariance: fit.covariance.map(|covariance| covariance * over),
        residual_sd: Some(sd),
        residual_sum_of_squares: squares,
        degrees_of_freedom: freedom,
        ..fit
    }
}
