//! Reduces the slopes at one point to a triangle, by Householder reflections of unit columns.

use nalgebra::linalg::SVD;
use nalgebra::{DMatrix, DVector, DVectorViewMut};

/// Bound on the sweeps of one singular value decomposition, so that it always ends.
const SVD_SWEEPS: usize = 500;

/// All that the solver uses of one point: where it is, how well it fits, and the
/// triangle of its slopes. With unit columns J = Q R diag(lengths); JᵀJ is never formed.
pub(super) struct Linearised {
    pub(super) parameters: DVector<f64>,
    pub(super) residual_sum_of_squares: f64,
    /// Lengths of the Jacobian's columns; 0 for a parameter that moves nothing.
    pub(super) lengths: DVector<f64>,
    /// R, p × p, upper triangle.
    pub(super) triangle: DMatrix<f64>,
    /// The first p entries of Qᵀ residuals: the part a change of the parameters can still remove.
    pub(super) removable: DVector<f64>,
    /// Length of the rest of Qᵀ residuals: the part it cannot.
    pub(super) rest: f64,
    /// Typical size of the model's values, at least that of any one parameter's share in it.
    pub(super) scale: f64,
    runs: usize,
    reflections: Reflections,
}

impl Linearised {
    /// Builds the triangle in the Jacobian's own memory; `None` if a slope is not finite.
    /// `work` has the length of the residuals and is overwritten.
    pub(super) fn new(
        parameters: DVector<f64>,
        residuals: &DVector<f64>,
        mut jacobian: DMatrix<f64>,
        work: &mut DVector<f64>,
        observed_scale: f64,
    ) -> Option<Self> {
        let (n, p) = jacobian.shape();
        let mut lengths = DVector::zeros(p);
        for (column, length) in jacobian.column_iter_mut().zip(lengths.iter_mut()) {
            *length = to_unit_length(column)?;
        }
        let share = lengths
            .iter()
            .zip(parameters.iter())
            .fold(0.0_f64, |m, (l, b)| m.max(l * b.abs()));
        let reflections = Reflections::new(jacobian);
        work.copy_from(residuals);
        reflections.apply(work);
        Some(Self {
            residual_sum_of_squares: residuals.norm_squared(),
            triangle: reflections.triangle(),
            removable: work.rows(0, p).into_owned(),
            rest: work.rows(p, n - p).norm(),
            scale: observed_scale.abs().max(share / (n as f64).sqrt()),
            parameters,
            lengths,
            runs: n,
            reflections,
        })
    }

    /// Bates and Watts' relative offset: how far, in units of the scatter, the residuals still
    /// lean into the plane of the slopes. It does not depend on units or on the parameters'
    /// scales. 0 at a stationary point. The scatter counts for at least one rounding error.
    pub(super) fn relative_offset(&self) -> f64 {
        let lean = self.removable.norm() / (self.removable.len() as f64).sqrt();
        if lean == 0.0 {
            0.0
        } else {
            lean / self.scatter().max(f64::EPSILON * self.scale)
        }
    }

    /// Standard deviation of the part of the residuals that no step removes.
    pub(super) fn scatter(&self) -> f64 {
        let freedom = (self.runs as f64 - self.removable.len() as f64).max(1.0);
        self.rest / freedom.sqrt()
    }

    /// Steps of the parameters, one a column, each of which changes the residuals by a vector of
    /// length 1 at right angles to the others': D⁻¹R⁻¹. `None` where the triangle is singular.
    pub(super) fn axes(&self) -> Option<DMatrix<f64>> {
        let p = self.removable.len();
        let mut axes = self.triangle.solve_upper_triangular(&DMatrix::identity(p, p))?;
        for (mut row, length) in axes.row_iter_mut().zip(self.lengths.iter()) {
            row /= *length;
        }
        Some(axes)
    }

    /// Gradient of half the sum of squares along `axes`; along one's own it is `removable`.
    pub(super) fn gradient_along(&self, axes: &DMatrix<f64>) -> DVector<f64> {
        axes.tr_mul(&self.triangle.tr_mul(&self.removable).component_mul(&self.lengths))
    }

    /// Whether what could still be removed is rounding error of the residuals themselves.
    pub(super) fn at_rounding(&self) -> bool {
        self.removable_share() <= 16.0 * f64::EPSILON
    }

    /// What could still be removed, as a part of the model's values.
    pub(super) fn removable_share(&self) -> f64 {
        let values = self.scale * (self.runs as f64).sqrt();
        let lean = self.removable.norm();
        if lean == 0.0 {
            0.0
        } else {
            lean / values
        }
    }

    /// The undamped Gauss–Newton step; `None` where the triangle is singular.
    pub(super) fn gauss_newton_step(&self) -> Option<DVector<f64>> {
        let mut step = self.triangle.solve_upper_triangular(&self.removable)?;
        for (s, length) in step.iter_mut().zip(self.lengths.iter()) {
            *s /= -length;
        }
        step.iter().all(|s| s.is_finite()).then_some(step)
    }

    /// Largest and smallest singular value of the unit-column triangle; `None` if they cannot be had.
    pub(super) fn extreme_singular_values(&self) -> Option<[f64; 2]> {
        if self.triangle.len() == 4 {
            let [a, b, c] = [(0, 0), (0, 1), (1, 1)].map(|at| self.triangle[at]);
            // σ₁ ± σ₂ are the lengths of (a ± c, b), and σ₁ σ₂ is |a c|, in which nothing cancels
            let largest = 0.5 * ((a + c).hypot(b) + (a - c).hypot(b));
            return Some([largest, (a * c).abs() / largest]);
        }
        let svd = SVD::try_new(self.triangle.clone(), false, false, f64::EPSILON, SVD_SWEEPS)?;
        Some([svd.singular_values.max(), svd.singular_values.min()])
    }

    /// First p entries of Qᵀ `vector`, which is overwritten.
    pub(super) fn project(&self, vector: &mut DVector<f64>) -> DVector<f64> {
        self.reflections.apply(vector);
        vector.rows(0, self.removable.len()).into_owned()
    }
}

/// Divides `column` by its length, which is returned; `None` if that is not finite.
fn to_unit_length(mut column: DVectorViewMut<'_, f64>) -> Option<f64> {
    let square = column.norm_squared();
    if (1e-200..1e200).contains(&square) {
        let length = square.sqrt();
        column *= 1.0 / length;
        return Some(length);
    }
    // The largest entry first: the squares of 1e-170 vanish, those of 1e170 overflow.
    let largest = column
        .iter()
        .fold(0.0_f64, |m, x| if x.is_nan() { f64::INFINITY } else { m.max(x.abs()) });
    if largest == 0.0 {
        return Some(0.0);
    }
    if !largest.is_finite() {
        return None;
    }
    column /= largest;
    let shape = column.norm();
    column /= shape;
    Some(largest * shape).filter(|length| length.is_finite())
}

/// The reflections I − t v vᵀ whose product is Qᵀ, and R, in the Jacobian's own memory: v from
/// the diagonal downwards, R above it, R's diagonal apart. (nalgebra's own normalises each v,
/// which on a fit of 40 runs is a third of the whole.)
struct Reflections {
    packed: DMatrix<f64>,
    /// R's diagonal.
    diagonal: DVector<f64>,
    /// The factor t of each reflection; 0 for a column with nothing left.
    factors: DVector<f64>,
}

impl Reflections {
    fn new(mut packed: DMatrix<f64>) -> Self {
        let p = packed.ncols();
        let mut diagonal = DVector::zeros(p);
        let mut factors = DVector::zeros(p);
        for k in 0..p {
            let (mut left, mut right) = packed.columns_range_pair_mut(k, k + 1..);
            let mut axis = left.rows_range_mut(k..);
            let length = axis.norm();
            if length > 0.0 {
                // The sign that adds, so that nothing cancels.
                let to = if axis[0] > 0.0 { -length } else { length };
                factors[k] = 1.0 / (length * (length + axis[0].abs()));
                axis[0] -= to;
                diagonal[k] = to;
                for mut column in right.column_iter_mut() {
                    let mut tail = column.rows_range_mut(k..);
                    let along = factors[k] * axis.dot(&tail);
                    tail.axpy(-along, &axis, 1.0);
                }
            }
        }
        Self {
            packed,
            diagonal,
            factors,
        }
    }

    fn triangle(&self) -> DMatrix<f64> {
        let p = self.packed.ncols();
        let mut triangle = self.packed.rows(0, p).upper_triangle();
        triangle.set_diagonal(&self.diagonal);
        triangle
    }

    /// Turns `vector` into Qᵀ `vector`.
    fn apply(&self, vector: &mut DVector<f64>) {
        for (k, column) in self.packed.column_iter().enumerate() {
            let axis = column.rows_range(k..);
            let mut tail = vector.rows_range_mut(k..);
            let along = self.factors[k] * axis.dot(&tail);
            tail.axpy(-along, &axis, 1.0);
        }
    }
}

/// The triangle in parameters measured by `yardsticks`, taken apart once so that each damping
/// afterwards costs p².
pub(super) struct Damped {
    u: DMatrix<f64>,
    singular_values: DVector<f64>,
    v_t: DMatrix<f64>,
}

impl Damped {
    /// `None` where the decomposition does not come to an end.
    pub(super) fn new(point: &Linearised, yardsticks: &DVector<f64>) -> Option<Self> {
        let mut scaled = point.triangle.clone();
        for (j, mut column) in scaled.column_iter_mut().enumerate() {
            column *= point.lengths[j] / yardsticks[j];
        }
        let svd = SVD::try_new_unordered(scaled, true, true, f64::EPSILON, SVD_SWEEPS)?;
        Some(Self {
            u: svd.u?,
            singular_values: svd.singular_values,
            v_t: svd.v_t?,
        })
    }

    /// The scaled u that minimises ‖scaled triangle · u + removable‖² + damping ‖u‖².
    pub(super) fn step(&self, removable: &DVector<f64>, damping: f64) -> DVector<f64> {
        let mut along = self.u.tr_mul(removable);
        for (a, s) in along.iter_mut().zip(self.singular_values.iter()) {
            let bottom = s * s + damping;
            *a *= if bottom > 0.0 { -s / bottom } else { 0.0 };
        }
        self.v_t.tr_mul(&along)
    }

    /// Scaled triangle · u.
    pub(super) fn apply(&self, u: &DVector<f64>) -> DVector<f64> {
        &self.u * (&self.v_t * u).component_mul(&self.singular_values)
    }
}
