//! Holds symmetric matrices of parameters in which each particle's k meets the parameters that all runs share, and no
//! other k: memory and work are linear in the particles.
//!
//! Order: the shared parameters, then one k a particle. The k that meet no shared parameter stand alone, and only the
//! others are ever put into one dense matrix.

use std::ops::Index;

use nalgebra::linalg::{Cholesky, SymmetricEigen};
use nalgebra::{DMatrix, DVector, Dyn};

/// A symmetric matrix with entries where a shared parameter takes part, and on the diagonal.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrow {
    /// shared with shared
    pub corner: DMatrix<f64>,
    /// shared with each k, a column a k
    border: DMatrix<f64>,
    /// each k with itself
    diagonal: DVector<f64>,
}

impl Arrow {
    /// Zeros: so many shared parameters, and so many k.
    pub fn zeros(shared: usize, own: usize) -> Arrow {
        Arrow {
            corner: DMatrix::zeros(shared, shared),
            border: DMatrix::zeros(shared, own),
            diagonal: DVector::zeros(own),
        }
    }

    /// How many parameters it is of.
    pub fn len(&self) -> usize {
        self.corner.nrows() + self.diagonal.len()
    }

    /// Whether it is of none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Its diagonal, in the order of the parameters.
    pub fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        let corner = (0..self.corner.nrows()).map(|j| self.corner[(j, j)]);
        corner.chain(self.diagonal.iter().copied())
    }

    /// Adds weight · slopes · slopesᵀ, the slopes each with its parameter's place; at most one is that of a k.
    pub fn add_square(&mut self, weight: f64, slopes: &[(usize, f64)]) {
        let shared = self.corner.nrows();
        for &(j, slope) in slopes {
            let weighted = weight * slope;
            let (all, column) = match j.checked_sub(shared) {
                None => (self.corner.as_mut_slice(), j),
                Some(own) => {
                    self.diagonal[own] += weighted * slope;
                    (self.border.as_mut_slice(), own)
                }
            };
            let column = &mut all[column * shared..(column + 1) * shared];
            for &(i, other) in slopes {
                // below the shared parameters nothing is kept
                if let Some(sum) = column.get_mut(i) {
                    *sum += weighted * other;
                }
            }
        }
    }

    /// Adds to an entry above the diagonal or on it; below it, nothing is kept.
    #[inline]
    pub fn add(&mut self, (i, j): (usize, usize), value: f64) {
        let shared = self.corner.nrows();
        if i < shared {
            if j < shared {
                self.corner[(i, j)] += value;
            } else {
                self.border[(i, j - shared)] += value;
            }
        } else if i == j {
            self.diagonal[i - shared] += value;
        }
    }

    /// Adds to every element of the diagonal.
    pub fn change_diagonal(&mut self, of: impl Fn(f64) -> f64) {
        for j in 0..self.corner.nrows() {
            self.corner[(j, j)] = of(self.corner[(j, j)]);
        }
        self.diagonal.apply(|x| *x = of(*x));
    }

    /// Every entry times the factors of its row and its column.
    pub fn scaled(mut self, factors: &[f64]) -> Arrow {
        let (shared, own) = factors.split_at(self.corner.nrows());
        for (i, of_row) in shared.iter().enumerate() {
            for (j, of_column) in shared.iter().enumerate() {
                self.corner[(i, j)] *= of_row * of_column;
            }
            for (j, of_column) in own.iter().enumerate() {
                self.border[(i, j)] *= of_row * of_column;
            }
        }
        for (x, factor) in self.diagonal.iter_mut().zip(own) {
            *x *= factor * factor;
        }
        self
    }

    /// Adds another, times a weight.
    pub fn add_weighted(&mut self, other: &Arrow, weight: f64) {
        self.corner.zip_apply(&other.corner, |x, y| *x += weight * y);
        self.border.zip_apply(&other.border, |x, y| *x += weight * y);
        self.diagonal.zip_apply(&other.diagonal, |x, y| *x += weight * y);
    }

    /// The matrix times a vector.
    pub fn times(&self, vector: &DVector<f64>) -> DVector<f64> {
        let shared = self.corner.nrows();
        let (of_shared, of_own) = (vector.rows(0, shared), vector.rows(shared, self.diagonal.len()));
        let mut found = DVector::zeros(self.len());
        found
            .rows_mut(0, shared)
            .copy_from(&(&self.corner * of_shared + &self.border * of_own));
        let own = self.border.tr_mul(&of_shared) + self.diagonal.component_mul(&of_own);
        found.rows_mut(shared, self.diagonal.len()).copy_from(&own);
        found
    }

    /// The matrix of some of the parameters, ascending.
    pub fn select(&self, kept: &[usize]) -> Arrow {
        let (shared, own) = kept.split_at(kept.partition_point(|place| *place < self.corner.nrows()));
        let own: Vec<usize> = own.iter().map(|place| place - self.corner.nrows()).collect();
        Arrow {
            corner: self.corner.select_rows(shared).select_columns(shared),
            border: self.border.select_rows(shared).select_columns(&own),
            diagonal: self.diagonal.select_rows(&own),
        }
    }

    /// Whether every entry is finite.
    pub fn is_finite(&self) -> bool {
        let parts = self.corner.iter().chain(&self.border).chain(&self.diagonal);
        parts.into_iter().all(|x| x.is_finite())
    }

    /// Cholesky's factors, each k eliminated first; `None` unless the matrix is positive definite.
    pub fn root(&self) -> Option<ArrowFactor<'_>> {
        if !self.diagonal.iter().all(|pivot| *pivot > 0.0) {
            return None;
        }
        let mut left = self.corner.clone();
        for (column, pivot) in self.border.column_iter().zip(&self.diagonal) {
            left.ger(-1.0 / pivot, &column, &column, 1.0);
        }
        let shared = match left.is_empty() {
            true => None,
            false => Some(left.cholesky()?),
        };
        Some(ArrowFactor { of: self, shared })
    }

    /// Its eigenvalues and directions; `None` where they are not found.
    pub fn axes(&self) -> Option<Axes> {
        const TURNS: usize = 10_000;
        let shared = self.corner.nrows();
        let meets = |own: &usize| self.border.column(*own).iter().any(|x| *x != 0.0);
        let meeting = (0..self.diagonal.len()).filter(meets).map(|own| shared + own);
        let places = Places::new(self.len(), (0..shared).chain(meeting).collect());
        let n = places.together.len();
        let dense = DMatrix::from_fn(n, n, |i, j| self[(places.together[i], places.together[j])]);
        // there are no axes of nothing
        let (strengths, axes) = match dense.is_empty() {
            true => (vec![], dense),
            false => {
                let found = SymmetricEigen::try_new(dense, f64::EPSILON, TURNS)?;
                (found.eigenvalues.iter().copied().collect(), found.eigenvectors)
            }
        };
        let alone = self.diagonal().collect();
        Some(Axes {
            places,
            strengths,
            axes,
            alone,
        })
    }
}

impl Index<(usize, usize)> for Arrow {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        let shared = self.corner.nrows();
        match (i.min(j), i.max(j)) {
            (_, high) if high < shared => &self.corner[(i, j)],
            (low, high) if low < shared => &self.border[(low, high - shared)],
            (low, high) if low == high => &self.diagonal[low - shared],
            _ => &0.0,
        }
    }
}

/// The factors of a positive definite matrix.
pub struct ArrowFactor<'a> {
    of: &'a Arrow,
    /// of what is left of the shared parameters once every k is eliminated; `None` without any
    shared: Option<Cholesky<f64, Dyn>>,
}

impl ArrowFactor<'_> {
    /// What the matrix takes to `wanted`.
    pub fn solve(&self, wanted: &DVector<f64>) -> DVector<f64> {
        let shared = self.of.corner.nrows();
        let mut found = wanted.clone();
        let mut left = wanted.rows(0, shared).into_owned();
        let own = wanted.rows(shared, wanted.len() - shared);
        let columns = || self.of.border.column_iter().zip(&self.of.diagonal);
        for ((column, pivot), own) in columns().zip(own.iter()) {
            left.axpy(-own / pivot, &column, 1.0);
        }
        if let Some(root) = &self.shared {
            root.solve_mut(&mut left);
        }
        for (own, (column, pivot)) in found.iter_mut().skip(shared).zip(columns()) {
            *own = (*own - column.dot(&left)) / pivot;
        }
        found.rows_mut(0, shared).copy_from(&left);
        found
    }

    /// The diagonal of the inverse.
    pub fn inverse_diagonal(&self) -> Vec<f64> {
        let shared = self.shared.as_ref().map(Cholesky::inverse);
        let corner = shared
            .iter()
            .flat_map(|inverse| inverse.diagonal().iter().copied().collect::<Vec<f64>>());
        let own = self
            .of
            .border
            .column_iter()
            .zip(&self.of.diagonal)
            .map(|(column, pivot)| {
                let by_shared = shared.as_ref().map_or(0.0, |inverse| (inverse * column).dot(&column));
                (1.0 + by_shared / pivot) / pivot
            });
        corner.chain(own).collect()
    }
}

/// Which parameters meet others.
#[derive(Debug, Clone, PartialEq)]
struct Places {
    /// those that do, ascending
    together: Vec<usize>,
    /// where each parameter stands among them
    at: Vec<Option<usize>>,
}

impl Places {
    fn new(parameters: usize, together: Vec<usize>) -> Places {
        let mut at = vec![None; parameters];
        together
            .iter()
            .enumerate()
            .for_each(|(place, of)| at[*of] = Some(place));
        Places { together, at }
    }
}

/// The directions of an arrow with the eigenvalue of each; a parameter that stands alone is a direction of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    places: Places,
    /// eigenvalues of the parameters that meet others
    strengths: Vec<f64>,
    /// their directions, a column each
    axes: DMatrix<f64>,
    /// the diagonal of the matrix, read where a parameter stands alone
    alone: Vec<f64>,
}

impl Axes {
    /// Every eigenvalue.
    pub fn strengths(&self) -> impl Iterator<Item = f64> + '_ {
        let alone = self.places.at.iter().zip(&self.alone);
        let alone = alone.filter(|(at, _)| at.is_none()).map(|(_, strength)| *strength);
        self.strengths.iter().copied().chain(alone)
    }

    /// Σ of(λ) · axis · axisᵀ: a function of the matrix.
    pub fn function(&self, of: impl Fn(f64) -> f64) -> Blocks {
        let n = self.strengths.len();
        let mut dense = DMatrix::zeros(n, n);
        for (axis, strength) in self.axes.column_iter().zip(&self.strengths) {
            let factor = of(*strength);
            if factor != 0.0 {
                dense.ger(factor, &axis, &axis, 1.0);
            }
        }
        Blocks {
            places: self.places.clone(),
            dense,
            alone: self.alone.iter().map(|strength| of(*strength)).collect(),
        }
    }

    /// The share of some parameters in the directions with some eigenvalues: the squares of what these have of them.
    pub fn share(&self, members: &[usize], wanted: impl Fn(f64) -> bool) -> f64 {
        let together: Vec<usize> = members.iter().filter_map(|place| self.places.at[*place]).collect();
        let axes = self.axes.column_iter().zip(&self.strengths);
        let of_axes = axes.filter(|(_, strength)| wanted(**strength));
        let shared: f64 = of_axes
            .map(|(axis, _)| together.iter().map(|place| axis[*place] * axis[*place]).sum::<f64>())
            .sum();
        let alone = members.iter().filter(|place| self.places.at[**place].is_none());
        shared + alone.filter(|place| wanted(self.alone[**place])).count() as f64
    }
}

/// A symmetric matrix of parameters of which some meet each other, and the others nobody.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
    places: Places,
    /// of those that meet
    dense: DMatrix<f64>,
    /// the diagonal, read where a parameter stands alone
    alone: Vec<f64>,
}

impl Blocks {
    /// Zeros for so many parameters, which all stand alone.
    pub fn zeros(parameters: usize) -> Blocks {
        Blocks {
            places: Places::new(parameters, vec![]),
            dense: DMatrix::zeros(0, 0),
            alone: vec![0.0; parameters],
        }
    }

    /// The parameters that meet others, ascending.
    pub fn together(&self) -> &[usize] {
        &self.places.together
    }

    /// An entry.
    #[inline]
    pub fn get(&self, i: usize, j: usize) -> f64 {
        match (self.places.at[i], self.places.at[j]) {
            (Some(i), Some(j)) => self.dense[(i, j)],
            _ if i == j => self.alone[i],
            _ => 0.0,
        }
    }

    /// Its diagonal, in the order of the parameters.
    pub fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.alone.len()).map(|j| self.get(j, j))
    }

    /// Every entry times the factors of its row and its column.
    pub fn scaled(mut self, factors: &[f64]) -> Blocks {
        let of: Vec<f64> = self.places.together.iter().map(|place| factors[*place]).collect();
        for (i, of_row) in of.iter().enumerate() {
            for (j, of_column) in of.iter().enumerate() {
                self.dense[(i, j)] *= of_row * of_column;
            }
        }
        for (x, factor) in self.alone.iter_mut().zip(factors) {
            *x *= factor * factor;
        }
        self
    }

    /// The matrix times a vector.
    pub fn times(&self, vector: &DVector<f64>) -> DVector<f64> {
        let together = &self.dense * vector.select_rows(&self.places.together);
        DVector::from_fn(vector.len(), |j, _| match self.places.at[j] {
            Some(place) => together[place],
            None => self.alone[j] * vector[j],
        })
    }

    /// The diagonal of this · inner · this.
    pub fn around(&self, inner: &Arrow) -> Vec<f64> {
        let n = self.places.together.len();
        let place = |i: usize| self.places.together[i];
        let within = DMatrix::from_fn(n, n, |i, j| inner[(place(i), place(j))]);
        let half = &within * &self.dense;
        let of = |(j, at): (usize, &Option<usize>)| match at {
            Some(at) => self.dense.row(*at).transpose().dot(&half.column(*at)),
            None => self.alone[j] * inner[(j, j)] * self.alone[j],
        };
        self.places.at.iter().enumerate().map(of).collect()
    }

    /// slopesᵀ · this · slopes, the slopes each with its parameter's place.
    pub fn square(&self, slopes: &[(usize, f64)]) -> f64 {
        let of = |&(i, a): &(usize, f64)| slopes.iter().map(|&(j, b)| a * b * self.get(i, j)).sum::<f64>();
        slopes.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two shared parameters and four k, of which the last two meet no shared one.
    fn arrow() -> Arrow {
        let mut arrow = Arrow::zeros(2, 4);
        let runs: [&[(usize, f64)]; 7] = [
            &[(0, 1.3), (1, -0.4), (2, 2.0)],
            &[(0, 0.7), (1, 0.9), (2, -0.5)],
            &[(0, 0.2), (1, 1.9), (3, 0.8)],
            &[(0, -1.1), (1, 0.3), (3, 1.7)],
            &[(3, 0.6)],
            &[(4, 1.5)],
            &[(5, 0.3)],
        ];
        for (slopes, weight) in runs.iter().zip([1.0, 2.0, 0.5, 1.5, 1.0, 3.0, 0.2]) {
            arrow.add_square(weight, slopes);
        }
        arrow
    }

    fn dense(arrow: &Arrow) -> DMatrix<f64> {
        DMatrix::from_fn(arrow.len(), arrow.len(), |i, j| arrow[(i, j)])
    }

    #[test]
    fn it_is_solved_as_the_dense_matrix_is() {
        let arrow = arrow();
        let wanted = DVector::from_fn(6, |i, _| 1.0 - 0.3 * i as f64);
        let root = arrow.root().expect("positive definite");
        let inverse = dense(&arrow).try_inverse().expect("regular");
        assert!((root.solve(&wanted) - &inverse * &wanted).amax() < 1e-12);
        for (found, expected) in root.inverse_diagonal().iter().zip(inverse.diagonal().iter()) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        let part = arrow.select(&[1, 2, 5]);
        let expected = dense(&arrow).select_rows(&[1, 2, 5]).select_columns(&[1, 2, 5]);
        assert_eq!(dense(&part), expected);
        let mut none = arrow.clone();
        none.change_diagonal(|x| x - 3.0);
        assert!(none.root().is_none());
    }

    #[test]
    fn its_functions_are_those_of_the_dense_matrix() {
        let arrow = arrow();
        let axes = arrow.axes().expect("found");
        let inverse = axes.function(|strength| 1.0 / strength);
        assert_eq!(inverse.together(), [0, 1, 2, 3]);
        let expected = dense(&arrow).try_inverse().expect("regular");
        let found = DMatrix::from_fn(6, 6, |i, j| inverse.get(i, j));
        assert!((&found - &expected).amax() < 1e-12);
        let vector = DVector::from_fn(6, |i, _| 0.2 + i as f64);
        assert!((inverse.times(&vector) - &expected * &vector).amax() < 1e-12);
        let slopes: Vec<(usize, f64)> = vector.iter().copied().enumerate().collect();
        assert!((inverse.square(&slopes) - (&expected * &vector).dot(&vector)).abs() < 1e-12);
        for (found, expected) in inverse.around(&arrow).iter().zip(expected.diagonal().iter()) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        let trace: f64 = axes.strengths().sum();
        assert!((trace / arrow.diagonal().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((axes.share(&[0, 1, 2, 3], |_| true) - 4.0).abs() < 1e-12);
        assert_eq!(axes.share(&[4, 5], |strength| strength > 1.0), 1.0);
    }
}
