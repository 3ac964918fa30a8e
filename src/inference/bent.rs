//! The place and shape of a cloud of weighed draws, bent as they are.
//!
//! A posterior in which three parameters do each other's work lies along a surface that is thin and curved: no ellipsoid
//! holds it without much beside it. The principal axes of its correlations are taken in the order of their variances, and
//! the place of a draw on each is a quadratic of its places on those before, fitted to the draws, and a rest. A normal cloud
//! has no such quadratics, and a term stands only where its draws tell it from none. What bends though its parameters are
//! not correlated is missed: its axes have one variance, and none comes before another.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::laplace::Laplace;

/// A place, principal axes, and how each of these is bent.
#[derive(Debug, Clone, PartialEq)]
pub struct Bent {
    mean: Vec<f64>,
    /// a column an axis, as long as the standard deviation there
    axes: DMatrix<f64>,
    /// one entry an axis
    bends: Vec<Bend>,
}

/// An axis: the place there is `offset` + `sd` z + Σ b z_i z_k over axes before it.
#[derive(Debug, Clone, PartialEq)]
struct Bend {
    offset: f64,
    sd: f64,
    products: Vec<Product>,
}

/// A term of a bend.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Product {
    axes: [usize; 2],
    factor: f64,
}

impl Bend {
    const STRAIGHT: Bend = Bend {
        offset: 0.0,
        sd: 1.0,
        products: Vec::new(),
    };

    /// What the axes before say of the place on this one.
    fn expected(&self, before: &[f64]) -> f64 {
        let terms = self.products.iter();
        self.offset
            + terms
                .map(|Product { axes: [i, k], factor }| factor * before[*i] * before[*k])
                .sum::<f64>()
    }

    /// Of an axis, with those before it unbent; `None` where nothing of it is left.
    fn fitted(places: &[DVector<f64>], weights: &[f64], axis: usize) -> Option<Bend> {
        /// Monte Carlo errors that tell a term from none
        const TOLD: f64 = 3.0;
        let mut products = Vec::new();
        let mut offset = 0.0;
        for i in 0..axis {
            for k in 0..=i {
                // second Hermite polynomials, which are orthogonal under a standard normal
                let (centre, square) = if i == k { (1.0, 2.0) } else { (0.0, 1.0) };
                let (mut sum, mut squares) = (0.0, 0.0);
                for (place, weight) in places.iter().zip(weights) {
                    let term = weight * place[axis] * (place[i] * place[k] - centre);
                    sum += term;
                    squares += term * term;
                }
                if sum.abs() > TOLD * squares.sqrt() {
                    let factor = sum / square;
                    offset -= factor * centre;
                    products.push(Product { axes: [i, k], factor });
                }
            }
        }
        let mut bend = Bend {
            offset,
            sd: 1.0,
            products,
        };
        let rest = |place: &DVector<f64>| place[axis] - bend.expected(place.as_slice());
        let each = || places.iter().zip(weights);
        let mean: f64 = each().map(|(place, weight)| weight * rest(place)).sum();
        let square: f64 = each().map(|(place, weight)| weight * rest(place) * rest(place)).sum();
        let variance = square - mean * mean;
        bend.offset += mean;
        bend.sd = variance.sqrt();
        (variance > 0.0).then_some(bend)
    }
}

/// Rotations in which principal axes are found; more are none.
const TURNS: usize = 1000;

impl Bent {
    /// The shape of a normal, which is straight.
    pub fn of_normal(about: &Laplace) -> Bent {
        Bent {
            mean: about.mode.clone(),
            axes: about.scale.clone(),
            bends: vec![Bend::STRAIGHT; about.mode.len()],
        }
    }

    /// The shape that weighed draws have, one point after the other, with weights that sum to 1; `None` where these span no
    /// volume.
    pub fn of_draws(points: &[f64], weights: &[f64], dimension: usize) -> Option<Bent> {
        let each = || points.chunks_exact(dimension.max(1)).zip(weights);
        let mut mean = DVector::zeros(dimension);
        for (point, weight) in each() {
            mean += *weight * DVector::from_column_slice(point);
        }
        let mut covariance = DMatrix::zeros(dimension, dimension);
        for (point, weight) in each() {
            let from = DVector::from_column_slice(point) - &mean;
            covariance.ger(*weight, &from, &from, 1.0);
        }
        let sd: Vec<f64> = covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
        let correlation = DMatrix::from_fn(dimension, dimension, |i, j| covariance[(i, j)] / (sd[i] * sd[j]));
        if correlation.iter().any(|entry| !entry.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::try_new(correlation, f64::EPSILON, TURNS)?;
        let mut order: Vec<usize> = (0..dimension).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let root = |axis: usize| eigen.eigenvalues[order[axis]].sqrt();
        let spans = |axis: usize| root(axis) > 0.0;
        if !(0..dimension).all(spans) {
            return None;
        }
        let vector = |i: usize, axis: usize| eigen.eigenvectors[(i, order[axis])];
        let axes = DMatrix::from_fn(dimension, dimension, |i, axis| sd[i] * vector(i, axis) * root(axis));
        let across = DMatrix::from_fn(dimension, dimension, |axis, i| vector(i, axis) / (sd[i] * root(axis)));
        // place of each draw on each axis, straight at first and then unbent
        let mut places: Vec<DVector<f64>> = each()
            .map(|(point, _)| &across * (DVector::from_column_slice(point) - &mean))
            .collect();
        let mut bends = Vec::with_capacity(dimension);
        for axis in 0..dimension {
            let bend = Bend::fitted(&places, weights, axis)?;
            for place in &mut places {
                place[axis] = (place[axis] - bend.expected(place.as_slice())) / bend.sd;
            }
            bends.push(bend);
        }
        Some(Bent {
            mean: mean.as_slice().to_vec(),
            axes,
            bends,
        })
    }

    /// The point at z, which is taken for the places on the axes.
    pub fn point(&self, z: &mut [f64], point: &mut [f64]) {
        // from the last: those before are still z
        for (axis, bend) in self.bends.iter().enumerate().rev() {
            z[axis] = bend.expected(z) + bend.sd * z[axis];
        }
        point.copy_from_slice(&self.mean);
        for (column, place) in self.axes.column_iter().zip(&*z) {
            for (x, s) in point.iter_mut().zip(&column) {
                *x += s * place;
            }
        }
    }

    /// Logarithm of the volume that a unit of z has: a bend moves places along an axis and changes none.
    pub fn ln_volume(&self) -> f64 {
        let bends: f64 = self.bends.iter().map(|bend| bend.sd.ln()).sum();
        self.axes.determinant().abs().ln() + bends
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::inference::importance::{propose, DrawCounts, Proposal, Proposed, Weights};
    use crate::model::likelihood::OutsideDomain;
    use crate::model::posterior::LogDensity;
    use crate::seed::{stream, StreamName};

    /// Two standard deviations along a diagonal and a half across it, which bends by so many with the square of the place along.
    struct Banana {
        bend: f64,
    }

    impl Banana {
        /// ln of the square root of the covariance's determinant: a bend changes no volume
        const LN_VOLUME: f64 = 0.0;
    }

    impl LogDensity for Banana {
        fn dimension(&self) -> usize {
            2
        }
        fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
            let along = FRAC_1_SQRT_2 * (point[0] + point[1]) / 2.0;
            let bent = FRAC_1_SQRT_2 * (point[1] - point[0]);
            let across = (bent - self.bend * along * along) / 0.5;
            let of_bent = -across / 0.5;
            let of_along = -along / 2.0 - of_bent * self.bend * along;
            slopes[0] = FRAC_1_SQRT_2 * (of_along - of_bent);
            slopes[1] = FRAC_1_SQRT_2 * (of_along + of_bent);
            Ok(-0.5 * (along * along + across * across))
        }
    }

    fn drawn(target: &Banana, shape: &Bent, stream: &str) -> (Vec<Proposed>, Weights) {
        let size = DrawCounts { chains: 4, draws: 1000 };
        let proposed = propose(target, &Proposal::Student(shape), size, StreamName::new(1, stream));
        let weights = Weights::of(&proposed).expect("densities");
        (proposed, weights)
    }

    fn adapted(target: &Banana, shape: &Bent, stream: &str) -> Bent {
        let (proposed, weights) = drawn(target, shape, stream);
        let points: Vec<f64> = proposed.iter().flat_map(|one| &one.points).copied().collect();
        Bent::of_draws(&points, &weights.weights, 2).expect("a volume")
    }

    fn round() -> Bent {
        Bent {
            mean: vec![0.0; 2],
            axes: DMatrix::from_diagonal_element(2, 2, 2.0),
            bends: vec![Bend::STRAIGHT; 2],
        }
    }

    /// Draws of the shape that was learnt weigh nearly the same, and their mean weight is the integral; without its bends they
    /// do not.
    #[test]
    fn a_bent_density_is_drawn_from_as_well_as_a_straight_one() {
        let share = |target: &Banana, shape: &Bent| drawn(target, shape, "shares").1.effective() / 4000.0;
        let learnt = |target: &Banana| {
            let shape = adapted(target, &round(), "first");
            adapted(target, &shape, "second")
        };
        let (straight, banana) = (Banana { bend: 0.0 }, Banana { bend: 1.0 });
        let of_straight = share(&straight, &learnt(&straight));
        let bent = learnt(&banana);
        assert!(
            share(&banana, &bent) > 0.95 * of_straight,
            "{} {of_straight}",
            share(&banana, &bent)
        );
        let (proposed, weights) = drawn(&banana, &bent, "integral");
        let sum: f64 = proposed.iter().flat_map(|one| &one.ln_ratio).map(|ln| ln.exp()).sum();
        let integral = (sum / 4000.0).ln() + bent.ln_volume();
        let error = (1.0 / weights.effective() - 1.0 / 4000.0).sqrt();
        assert!((integral - Banana::LN_VOLUME).abs() < 4.0 * error, "{integral} {error}");
        let ellipse = Bent {
            bends: vec![Bend::STRAIGHT; 2],
            ..bent
        };
        assert!(
            share(&banana, &ellipse) < 0.75 * of_straight,
            "{} {of_straight}",
            share(&banana, &ellipse)
        );
    }

    #[test]
    fn a_normal_cloud_has_no_bends() {
        let mut rng = stream(1, "a_normal_cloud_has_no_bends", 0);
        let mut points = Vec::new();
        for _ in 0..1000 {
            let [a, b, c]: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
            points.extend([1e-6 * a, 1e3 * (0.99 * a + 0.1 * b) + 7.0, b + c]);
        }
        let shape = Bent::of_draws(&points, &[1e-3; 1000], 3).expect("a volume");
        assert!(shape.bends.iter().all(|bend| bend.products.is_empty()), "{shape:?}");
        let expected = (1e-6f64 * 100.0).ln();
        assert!((shape.ln_volume() - expected).abs() < 0.2, "{}", shape.ln_volume());
        // draws of a line and of a point span no volume
        let line: Vec<f64> = points.chunks(3).flat_map(|p| [p[0], 2.0 * p[0]]).collect();
        assert_eq!(Bent::of_draws(&line, &[1e-3; 1000], 2), None);
        assert_eq!(Bent::of_draws(&[1.0; 20], &[0.1; 10], 2), None);
    }
}
