//! Sums the weighted squares of a joint fit anywhere about its minimum, without a pass over all runs for each point.
//!
//! Inside the region of a fit's limits most residuals are series of the third order in the parameters, so that their
//! squares are ψᵀGψ: ψ holds the products of up to three of the shared parameters and a k, and G the sums over a sphere's
//! runs of the products of a residual's coefficients. A run that may come near r = 0 there turns too sharply, and is evaluated at every
//! point. The sums are held against the runs' own at the ends of every parameter: where they are off, and at points outside
//! the region, all runs are evaluated.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{DMatrix, DVector};

use super::information::{add_square, Sums};
use super::joint::{JointFit, JointRow, Part, MOST_SLOPES};
use super::profile::{Region, Squares};
use crate::physics::rebound::{bend_mean_restitution, slope_mean_restitution, TURN};

/// Coefficients of a series in as many parameters as a run has slopes in.
const MOST_COEFFICIENTS: usize = coefficients(MOST_SLOPES);

/// A run is evaluated at every point where its r at the minimum lies within so many times what r moves by in the region:
/// from there on the fourth order of √r is below 4e-4 of the first.
const FROM_ZERO: f64 = 6.0;

/// Nor is one expanded below this many times the width of the turn in r, τ².
const FROM_TURN: f64 = 10.0;

/// Difference from the runs' own sum, as a share of the rise to a limit, above which no run is expanded; it moves a limit by
/// half of that of its half-width.
const WRONG: f64 = 2e-3;

/// How far beyond the region points may lie, in its radii.
const BEYOND: f64 = 2.0;

/// Neighbouring runs of a part.
#[derive(Debug, Clone, PartialEq)]
struct Neighbours {
    /// index into the parts of the joint fit
    part: usize,
    /// a range of every column of the runs
    runs: Range<usize>,
    /// which residual of the fit is that of the first
    first: usize,
}

/// The weighted squares of a joint fit.
pub struct JointSquares<'p, 'r> {
    problem: &'p JointFit<'r>,
    /// the root of the weight of each residual beside the fit's own; empty for none
    roots: &'p [f64],
    /// every run that rebounded
    all: Vec<Neighbours>,
    /// how many of them are wet
    wet: usize,
    expanded: Option<Expanded>,
    evaluated: AtomicUsize,
}

/// The residuals of most runs as series about a point.
struct Expanded {
    about: Vec<f64>,
    /// G of each sphere of the fit
    products: Vec<DMatrix<f64>>,
    /// the other runs
    turning: Vec<Neighbours>,
    /// rise of the squares to the ends of the region
    rise: f64,
}

impl<'p, 'r> JointSquares<'p, 'r> {
    /// Of the fit with these roots of weights, to be asked about a region.
    pub fn new(problem: &'p JointFit<'r>, roots: &'p [f64], region: &Region) -> JointSquares<'p, 'r> {
        let mut first = 0;
        let parts = problem.joint.parts.iter().enumerate();
        let all = parts.map(|(part, own)| {
            let runs = own.rebounds.clone();
            first += runs.len();
            Neighbours {
                part,
                first: first - runs.len(),
                runs,
            }
        });
        let mut squares = JointSquares {
            problem,
            roots,
            all: all.collect(),
            wet: problem.joint.wet_rebounds(),
            expanded: None,
            evaluated: AtomicUsize::new(0),
        };
        squares.expanded = squares.expand(region);
        if !squares.agree(region) {
            squares.expanded = None;
        }
        squares
    }

    /// The same without series.
    #[cfg(test)]
    pub(crate) fn evaluating_all(self) -> Self {
        JointSquares { expanded: None, ..self }
    }

    /// How many runs are evaluated at every point inside the region.
    pub fn runs_a_point(&self) -> usize {
        let each = self.expanded.as_ref().map_or(&self.all, |expanded| &expanded.turning);
        each.iter().map(|some| some.runs.len()).sum()
    }

    /// How many times a run was evaluated so far.
    pub fn evaluated(&self) -> usize {
        self.evaluated.load(Ordering::Relaxed)
    }

    /// Hands on some runs about a point, each with the root of its weight.
    fn each(&self, some: &Neighbours, b: &[f64], mut hand_on: impl FnMut(&Part, f64, JointRow)) {
        self.evaluated.fetch_add(some.runs.len(), Ordering::Relaxed);
        let part = &self.problem.joint.parts[some.part];
        self.problem.joint.each(part, some.runs.clone(), b, |row| {
            let residual = some.first + row.run - some.runs.start;
            let own = residual
                .checked_sub(self.wet)
                .map_or(1.0, |dry| self.problem.dry_roots[dry]);
            let root = self.roots.get(residual).map_or(1.0, |root| *root);
            let of_count = self.problem.joint.runs.count(row.run).sqrt();
            hand_on(part, own * root * of_count, row);
        });
    }

    /// What is known of each k beyond the runs: its residual with the slope.
    fn each_known(&self, b: &[f64], mut hand_on: impl FnMut(f64, (usize, f64))) {
        let rebounds = self.wet + self.problem.dry_roots.len();
        for (known, residual) in self.problem.known.iter().zip(rebounds..) {
            let root = known.root * self.roots.get(residual).map_or(1.0, |root| *root);
            hand_on((b[known.place] - known.value) * root, (known.place, root));
        }
    }

    /// The runs to evaluate at a point, and what to take from the sums of the others; all of them outside the region.
    fn at_point(&self, b: &[f64]) -> (&[Neighbours], Option<&Expanded>) {
        match &self.expanded {
            Some(expanded) if expanded.holds(self.shared(), b) => (&expanded.turning, Some(expanded)),
            _ => (&self.all, None),
        }
    }

    fn shared(&self) -> usize {
        self.problem.joint.shared.len()
    }

    fn squares_of(&self, some: &[Neighbours], b: &[f64]) -> f64 {
        let mut squares = 0.0;
        for some in some {
            self.each(some, b, |_, root, row| squares += (root * row.residual).powi(2));
        }
        self.each_known(b, |residual, _| squares += residual * residual);
        squares
    }

    fn zeros(&self) -> Sums {
        Sums::new(self.problem.joint.parameters())
    }

    fn add(sums: &mut Sums, part: &Part, root: f64, row: &JointRow) {
        let mut slopes = [(0, 0.0); MOST_SLOPES];
        for (own, (place, slope)) in slopes.iter_mut().zip(part.places.iter().zip(row.slopes)) {
            *own = (*place, root * slope);
        }
        sums.add(root * row.residual, &slopes[..part.places.len()]);
    }

    /// The same, and to the information what the bend of m(r) has of the squares' curvature where it adds to it: without it,
    /// steps leap to and fro over a run near r = 0 that rebounded by luck.
    fn add_bent(sums: &mut Sums, part: &Part, root: f64, row: &JointRow) {
        Self::add(sums, part, root, row);
        if part.series.is_none() {
            return;
        }
        let slope = slope_mean_restitution(row.kept);
        let bent = row.residual * bend_mean_restitution(row.kept) / (slope * slope);
        if bent > 0.0 {
            let slopes: [(usize, f64); MOST_SLOPES] = std::array::from_fn(|i| match part.places.get(i) {
                Some(place) => (*place, row.slopes[i]),
                None => (0, 0.0),
            });
            let weight = root * root * bent;
            add_square(&mut sums.information, weight, &slopes[..part.places.len()]);
        }
    }

    /// `None` where the runs that do not turn leave a parameter open, where most do turn, or where a point to expand by lies
    /// outside the domain.
    fn expand(&self, region: &Region) -> Option<Expanded> {
        let about = region.minimum;
        let joint = &self.problem.joint;
        let sums = self.sums_without_turns(about);
        let (smooth, turning) = self.apart(
            about,
            &local_covariances(sums.information.clone(), self.shared())?,
            region.rise(),
        );
        let count = |some: &[Neighbours]| some.iter().map(|some| some.runs.len()).sum::<usize>();
        if count(&turning) > count(&smooth) {
            return None;
        }
        let probes = Probes::new(about, &sums, self.shared(), region.rise());
        if !probes.points().all(|point| joint.holds(point)) {
            return None;
        }
        let in_all = 1 + self.shared();
        let mut products = vec![DMatrix::zeros(coefficients(in_all), coefficients(in_all)); joint.spheres.len()];
        let mut rows = vec![];
        for some in &smooth {
            self.expand_rows(some, about, &probes, &mut rows);
            let sphere = joint.parts[some.part].places[0] - self.shared();
            for row in &rows {
                add_products(&mut products[sphere], row);
            }
        }
        for own in &mut products {
            own.fill_lower_triangle_with_upper_triangle();
        }
        Some(Expanded {
            about: about.to_vec(),
            products,
            turning,
            rise: region.rise(),
        })
    }

    /// Sums over the runs that lie far from r = 0.
    fn sums_without_turns(&self, b: &[f64]) -> Sums {
        /// r at which a run may stand within a few per cent of no rebound
        const FAR: f64 = 0.02;
        let mut sums = self.zeros();
        for some in &self.all {
            self.each(some, b, |part, root, row| {
                if row.kept.abs() >= FAR {
                    Self::add(&mut sums, part, root, &row);
                }
            });
        }
        self.each_known(b, |residual, slope| sums.add(residual, &[slope]));
        sums
    }

    /// The runs that a series describes in the region, and those that turn.
    fn apart(&self, b: &[f64], covariances: &[DMatrix<f64>], rise: f64) -> (Vec<Neighbours>, Vec<Neighbours>) {
        let (mut smooth, mut turning) = (vec![], vec![]);
        let least = FROM_TURN * TURN * TURN;
        for some in &self.all {
            let sphere = self.problem.joint.parts[some.part].places[0] - self.shared();
            let covariance = &covariances[sphere];
            self.each(some, b, |part, root, row| {
                let slopes = &row.slopes[..part.places.len()];
                let of_one = |(i, own): (usize, &f64)| -> f64 {
                    let others = slopes.iter().enumerate();
                    own * others.map(|(j, other)| covariance[(i, j)] * other).sum::<f64>()
                };
                let variance: f64 = slopes.iter().enumerate().map(of_one).sum();
                let moves = (rise * variance.max(0.0)).sqrt() / slope_mean_restitution(row.kept);
                let turns = part.series.is_some() && row.kept.abs() <= least.max(FROM_ZERO * moves);
                let own: &mut Vec<Neighbours> = if turns { &mut turning } else { &mut smooth };
                // a run without weight is in neither
                if root != 0.0 {
                    append(own, some, row.run);
                }
            });
        }
        (smooth, turning)
    }

    /// The coefficients of the residuals of some runs, from their slopes to either side.
    fn expand_rows(&self, some: &Neighbours, about: &[f64], probes: &Probes, rows: &mut Vec<[f64; MOST_COEFFICIENTS]>) {
        rows.clear();
        self.each(some, about, |part, root, row| {
            let mut own = [0.0; MOST_COEFFICIENTS];
            own[0] = root * row.residual;
            for (own, slope) in own[1..].iter_mut().zip(&row.slopes[..part.places.len()]) {
                *own = root * slope;
            }
            rows.push(own);
        });
        let (parameters, part) = (1 + self.shared(), &self.problem.joint.parts[some.part]);
        for (i, place) in part.places.iter().enumerate() {
            let step = probes.steps[*place];
            for (side, there) in [-1.0, 1.0].into_iter().zip(&probes.of_local[i]) {
                let mut rows = rows.iter_mut();
                self.each(some, there, |part, root, at| {
                    let Some(own) = rows.next() else { return };
                    for (j, slope) in at.slopes[..part.places.len()].iter().enumerate() {
                        let change = root * slope - own[1 + j];
                        // half of the second derivative; of a mixed one, the other half comes from the other parameter
                        own[of_product(parameters, i, j)] += 0.25 * side * change / step;
                        own[of_cubic(parameters, [i, i, j])] += change / (step * step * if i == j { 6.0 } else { 2.0 });
                    }
                });
            }
        }
        for ([i, j], there) in probes.of_pairs.iter().filter(|([_, j], _)| *j < part.places.len()) {
            let mut rows = rows.iter_mut();
            let moved = [i, j].map(|place| probes.steps[part.places[*place]]);
            self.each(some, there, |part, root, at| {
                let Some(own) = rows.next() else { return };
                for (k, slope) in at.slopes[..part.places.len()].iter().enumerate().skip(j + 1) {
                    let one_by_one = |(moved, i): (f64, &usize)| {
                        moved * (own[of_product(parameters, *i, k)] + moved * own[of_cubic(parameters, [*i, *i, k])])
                    };
                    let expected: f64 = own[1 + k] + moved.into_iter().zip([i, j]).map(one_by_one).sum::<f64>();
                    own[of_cubic(parameters, [*i, *j, k])] = (root * slope - expected) / (moved[0] * moved[1]);
                }
            });
        }
    }

    /// Whether the sums are those of the runs at both ends of every shared parameter, and of all k together.
    fn agree(&self, region: &Region) -> bool {
        let p = self.problem.joint.parameters();
        let unit = |places: Range<usize>| DVector::from_fn(p, |j, _| f64::from(u8::from(places.contains(&j))));
        let shared = self.shared();
        let directions = (0..shared).map(|j| unit(j..j + 1)).chain([unit(shared..p)]);
        let steps: Vec<DVector<f64>> = directions
            .filter_map(|direction| Some(region.along(&direction)?.step))
            .collect();
        let is_near = |(step, side): (&DVector<f64>, f64)| {
            let there = region.moved(step, side);
            let (Some(expanded), true) = (&self.expanded, self.problem.joint.holds(&there)) else {
                return false;
            };
            let by_sums = expanded.squares(shared, &there) + self.squares_of(&expanded.turning, &there);
            (by_sums - self.squares_of(&self.all, &there)).abs() <= WRONG * region.rise()
        };
        [-1.0, 1.0]
            .into_iter()
            .all(|side| steps.iter().all(|step| is_near((step, side))))
    }
}

impl Squares for JointSquares<'_, '_> {
    fn at(&self, b: &[f64]) -> Option<f64> {
        if !self.problem.joint.holds(b) {
            return None;
        }
        let (runs, expanded) = self.at_point(b);
        let of_others = expanded.map_or(0.0, |expanded| expanded.squares(self.shared(), b));
        let squares = of_others + self.squares_of(runs, b);
        squares.is_finite().then_some(squares)
    }

    fn sums_at(&self, b: &[f64]) -> Option<Sums> {
        if !self.problem.joint.holds(b) {
            return None;
        }
        let (runs, expanded) = self.at_point(b);
        let mut sums = self.zeros();
        if let Some(expanded) = expanded {
            expanded.add_to(&mut sums, self.shared(), b);
        }
        for some in runs {
            self.each(some, b, |part, root, row| Self::add_bent(&mut sums, part, root, &row));
        }
        self.each_known(b, |residual, slope| sums.add(residual, &[slope]));
        sums.squares.is_finite().then_some(sums)
    }
}

impl Expanded {
    /// The changes of a sphere's k and of the shared parameters.
    fn moved(&self, shared: usize, sphere: usize, b: &[f64]) -> [f64; MOST_SLOPES] {
        let mut moved = [0.0; MOST_SLOPES];
        let places = std::iter::once(shared + sphere).chain(0..shared);
        for (own, place) in moved.iter_mut().zip(places) {
            *own = b[place] - self.about[place];
        }
        moved
    }

    /// Whether a point lies where the residuals are expanded: by their slopes, the squares rise by less there than at the
    /// region's ends, times the square of [`BEYOND`].
    fn holds(&self, shared: usize, b: &[f64]) -> bool {
        let rise = |(sphere, products): (usize, &DMatrix<f64>)| -> f64 {
            let moved = self.moved(shared, sphere, b);
            let each = moved.iter().enumerate().take(1 + shared);
            each.map(|(i, x)| {
                let column = products.column(1 + i);
                x * moved
                    .iter()
                    .zip(&column.as_slice()[1..2 + shared])
                    .map(|(y, sum)| y * sum)
                    .sum::<f64>()
            })
            .sum()
        };
        let rise: f64 = self.products.iter().enumerate().map(rise).sum();
        rise <= BEYOND * BEYOND * self.rise
    }

    fn squares(&self, shared: usize, b: &[f64]) -> f64 {
        let of_sphere = |(sphere, products): (usize, &DMatrix<f64>)| {
            let psi = monomials(&self.moved(shared, sphere, b)[..1 + shared]);
            psi.dot(&(products * &psi))
        };
        self.products.iter().enumerate().map(of_sphere).sum()
    }

    /// Adds what the expanded runs have of squares, gradient and information; the last is that at the minimum, which changes
    /// little in the region and only sets the way of a step.
    fn add_to(&self, sums: &mut Sums, shared: usize, b: &[f64]) {
        for (sphere, products) in self.products.iter().enumerate() {
            let moved = self.moved(shared, sphere, b);
            let moved = &moved[..1 + shared];
            let psi = monomials(moved);
            let along = products * &psi;
            sums.squares += psi.dot(&along);
            let gradient = slopes_of_monomials(moved, along.as_slice());
            let place = |local: usize| if local == 0 { shared + sphere } else { local - 1 };
            for i in 0..=shared {
                sums.gradient[place(i)] += gradient[i];
                for j in 0..=shared {
                    sums.information[(place(i), place(j))] += products[(1 + i, 1 + j)];
                }
            }
        }
    }
}

/// Points beside the minimum, from whose slopes second derivatives are taken.
struct Probes {
    /// below and above in k, of every sphere at once; then in each shared parameter
    of_local: Vec<[Vec<f64>; 2]>,
    /// above in two of these at once that another stands after, with their places
    of_pairs: Vec<([usize; 2], Vec<f64>)>,
    /// how far, in each parameter
    steps: Vec<f64>,
}

impl Probes {
    fn new(about: &[f64], sums: &Sums, shared: usize, rise: f64) -> Probes {
        /// share of what raises the squares to a limit alone: of this the third order is nothing, and rounding little
        const NEAR: f64 = 1e-2;
        let steps: Vec<f64> = sums
            .information
            .diagonal()
            .iter()
            .map(|sum| NEAR * (rise / sum).sqrt())
            .collect();
        let along = |local: usize, side: f64, mut point: Vec<f64>| {
            let places = if local == 0 {
                shared..about.len()
            } else {
                local - 1..local
            };
            places.for_each(|place| point[place] += side * steps[place]);
            point
        };
        let both = |local: usize| [-1.0, 1.0].map(|side| along(local, side, about.to_vec()));
        let pairs = (0..shared).flat_map(|j| (0..j).map(move |i| [i, j]));
        let of_pair = |[i, j]: [usize; 2]| ([i, j], along(j, 1.0, along(i, 1.0, about.to_vec())));
        Probes {
            of_local: (0..=shared).map(both).collect(),
            of_pairs: pairs.map(of_pair).collect(),
            steps,
        }
    }

    fn points(&self) -> impl Iterator<Item = &Vec<f64>> {
        let of_pairs = self.of_pairs.iter().map(|(_, point)| point);
        self.of_local.iter().flatten().chain(of_pairs)
    }
}

/// The covariance, for a variance of 1, of each sphere's k and the shared parameters; `None` where the runs leave one open.
fn local_covariances(information: DMatrix<f64>, shared: usize) -> Option<Vec<DMatrix<f64>>> {
    let covariance = information.cholesky()?.inverse();
    let of_sphere = |k: usize| {
        let places: Vec<usize> = std::iter::once(k).chain(0..shared).collect();
        covariance.select_rows(&places).select_columns(&places)
    };
    Some((shared..covariance.nrows()).map(of_sphere).collect())
}

/// Adds a run to the last of its neighbours, or as one of its own.
fn append(to: &mut Vec<Neighbours>, from: &Neighbours, run: usize) {
    match to.last_mut() {
        Some(last) if last.part == from.part && last.runs.end == run => last.runs.end += 1,
        _ => to.push(Neighbours {
            part: from.part,
            runs: run..run + 1,
            first: from.first + run - from.runs.start,
        }),
    }
}

/// How many coefficients a series in so many parameters has.
const fn coefficients(parameters: usize) -> usize {
    of_cubic(parameters, [0, 0, parameters])
}

/// Where the coefficient of a product of two of so many parameters stands.
const fn of_product(parameters: usize, i: usize, j: usize) -> usize {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    1 + parameters + high * (high + 1) / 2 + low
}

/// Where that of a product of three stands.
const fn of_cubic(parameters: usize, [i, j, k]: [usize; 3]) -> usize {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    let (middle, high) = if high < k { (high, k) } else { (k, high) };
    let (low, middle) = if low < middle { (low, middle) } else { (middle, low) };
    of_product(parameters, 0, parameters) + high * (high + 1) * (high + 2) / 6 + middle * (middle + 1) / 2 + low
}

/// ψ: 1, the changes of the parameters, and their products.
fn monomials(moved: &[f64]) -> DVector<f64> {
    let parameters = moved.len();
    let mut psi = DVector::zeros(coefficients(parameters));
    psi[0] = 1.0;
    for (i, x) in moved.iter().enumerate() {
        psi[1 + i] = *x;
        for (j, y) in moved.iter().enumerate().take(i + 1) {
            psi[of_product(parameters, i, j)] = x * y;
            for (k, z) in moved.iter().enumerate().take(j + 1) {
                psi[of_cubic(parameters, [i, j, k])] = x * y * z;
            }
        }
    }
    psi
}

/// The slopes of the sum of ψ with these factors, in each parameter.
fn slopes_of_monomials(moved: &[f64], factors: &[f64]) -> [f64; MOST_SLOPES] {
    let parameters = moved.len();
    let mut slopes = [0.0; MOST_SLOPES];
    for (i, x) in moved.iter().enumerate() {
        slopes[i] += factors[1 + i];
        for (j, y) in moved.iter().enumerate().take(i + 1) {
            let factor = factors[of_product(parameters, i, j)];
            slopes[i] += factor * y;
            slopes[j] += factor * x;
            for (k, z) in moved.iter().enumerate().take(j + 1) {
                let factor = factors[of_cubic(parameters, [i, j, k])];
                slopes[i] += factor * y * z;
                slopes[j] += factor * x * z;
                slopes[k] += factor * x * y;
            }
        }
    }
    slopes
}

/// Adds the products of a residual's coefficients, above the diagonal.
fn add_products(products: &mut DMatrix<f64>, row: &[f64; MOST_COEFFICIENTS]) {
    let size = products.nrows();
    for (j, of_column) in row[..size].iter().enumerate() {
        // dry runs have none in the shared parameters
        if *of_column != 0.0 {
            let column = &mut products.as_mut_slice()[j * size..=j * size + j];
            for (sum, of_row) in column.iter_mut().zip(row) {
                *sum += of_column * of_row;
            }
        }
    }
}
