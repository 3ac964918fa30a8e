//! Sums residuals and slopes over the rows of a least-squares problem, at one point.

use nalgebra::{DMatrix, DVector};

/// Sums over runs that share a spread, at one point, in the parameters' own units.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// how many runs
    pub runs: usize,
    /// Σ residual²
    pub squares: f64,
    /// Σ residual · slope
    pub gradient: DVector<f64>,
    /// Σ slope · slopeᵀ
    pub information: DMatrix<f64>,
}

impl Sums {
    /// No runs yet, of so many parameters.
    pub fn new(parameters: usize) -> Sums {
        Sums {
            runs: 0,
            squares: 0.0,
            gradient: DVector::zeros(parameters),
            information: DMatrix::zeros(parameters, parameters),
        }
    }

    /// Adds a run by its residual (model − observed) and the slopes of its model, each with its parameter's place.
    pub fn add(&mut self, residual: f64, slopes: &[(usize, f64)]) {
        self.runs += 1;
        self.squares += residual * residual;
        for &(i, slope) in slopes {
            self.gradient[i] += residual * slope;
        }
        add_square(&mut self.information, 1.0, slopes);
    }

    /// Adds the sums of other runs with a weight, in the parameters that come first among theirs.
    pub fn add_weighted(&mut self, other: &Sums, weight: f64) {
        let n = self.gradient.len();
        self.runs += other.runs;
        self.squares += weight * other.squares;
        self.gradient += other.gradient.rows(0, n) * weight;
        self.information += other.information.view((0, 0), (n, n)) * weight;
    }

    /// The sums of some of the parameters, ascending.
    pub fn of(&self, kept: &[usize]) -> Sums {
        Sums {
            runs: self.runs,
            squares: self.squares,
            gradient: self.gradient.select_rows(kept),
            information: self.information.select_rows(kept).select_columns(kept),
        }
    }

    /// The spread the residuals leave; `before` counts as one residual, so that no number of runs leaves none.
    pub(super) fn spread(&self, before: f64) -> f64 {
        let spent = self.information.diagonal().iter().filter(|sum| **sum > 0.0).count();
        let left = self.runs.saturating_sub(spent) + 1;
        ((self.squares + before * before) / left as f64).sqrt()
    }
}

/// Adds weight · slopes · slopesᵀ, the slopes each with its parameter's place.
pub fn add_square(matrix: &mut DMatrix<f64>, weight: f64, slopes: &[(usize, f64)]) {
    for &(j, of_column) in slopes {
        for &(i, of_row) in slopes {
            matrix[(i, j)] += weight * of_row * of_column;
        }
    }
}

/// slopesᵀ · matrix · slopes, the slopes each with its parameter's place.
pub fn square(matrix: &DMatrix<f64>, slopes: &[(usize, f64)]) -> f64 {
    let of = |&(i, a): &(usize, f64)| slopes.iter().map(|&(j, b)| a * b * matrix[(i, j)]).sum::<f64>();
    slopes.iter().map(of).sum()
}

/// slopesᵀ · step, the slopes each with its parameter's place.
pub fn along(slopes: &[(usize, f64)], step: &DVector<f64>) -> f64 {
    slopes.iter().map(|(place, slope)| slope * step[*place]).sum()
}
