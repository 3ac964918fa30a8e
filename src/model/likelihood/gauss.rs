//! Finds the Gauss quadrature of a set of weighted points, and the polynomial nearest to values given at them.
//!
//! The rule of order q has positive weights, nodes inside the range of the points, and sums every polynomial of degree
//! 2q − 1 over the points exactly. Its polynomials are orthogonal over the points, so that what the nearest polynomial
//! explains of the values' sum of squares is the sum of its squares at the nodes, and what it leaves is not negative.
//! Source: Golub & Welsch 1969 for nodes and weights from the recurrence; the recurrence by Stieltjes' procedure.

use nalgebra::{DMatrix, SymmetricEigen};

/// A rule with the values of the nearest polynomial of degree q − 1 at its nodes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rule {
    pub nodes: Vec<f64>,
    pub weights: Vec<f64>,
    pub values: Vec<f64>,
    /// Σ weight · value² over the nodes: what the polynomial explains
    pub explained: f64,
}

/// The rule of an order for points x with weights and values y.
///
/// `None` with fewer different points than the order, or where the recurrence loses its footing.
pub(super) fn gauss_rule(x: &[f64], weight: &[f64], y: &[f64], order: usize) -> Option<Rule> {
    let (lo, hi) = x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
        (lo.min(*x), hi.max(*x))
    });
    let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
    let total: f64 = weight.iter().sum();
    if half <= 0.0 || total <= 0.0 {
        return None;
    }
    let scaled: Vec<f64> = x.iter().map(|x| (x - middle) / half).collect();
    let mut before = vec![0.0; x.len()];
    let mut here = vec![1.0 / total.sqrt(); x.len()];
    let (mut centres, mut steps, mut coefficients) = (vec![], vec![], vec![]);
    let mut step = 0.0;
    for degree in 0..order {
        let (mut centre, mut coefficient) = (0.0, 0.0);
        for ((t, w), (p, y)) in scaled.iter().zip(weight).zip(here.iter().zip(y)) {
            centre += w * t * p * p;
            coefficient += w * y * p;
        }
        centres.push(centre);
        coefficients.push(coefficient);
        if degree + 1 == order {
            break;
        }
        let mut norm = 0.0;
        for ((t, w), (p, old)) in scaled.iter().zip(weight).zip(here.iter().zip(before.iter_mut())) {
            let next = (t - centre) * p - step * *old;
            norm += w * next * next;
            *old = next;
        }
        step = norm.sqrt();
        if step < 1e-10 {
            return None;
        }
        before.iter_mut().for_each(|next| *next /= step);
        std::mem::swap(&mut before, &mut here);
        steps.push(step);
    }
    let jacobi = DMatrix::from_fn(order, order, |i, j| match i.abs_diff(j) {
        0 => centres[i],
        1 => steps[i.min(j)],
        _ => 0.0,
    });
    let eigen = SymmetricEigen::try_new(jacobi, f64::EPSILON, 1000)?;
    let mut found: Vec<(f64, f64)> = (0..order)
        .map(|m| (eigen.eigenvalues[m], total * eigen.eigenvectors[(0, m)].powi(2)))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let value = |t: f64| {
        let (mut before, mut here) = (0.0, 1.0 / total.sqrt());
        let mut sum = coefficients[0] * here;
        for degree in 1..order {
            let lag = if degree >= 2 { steps[degree - 2] } else { 0.0 };
            let next = ((t - centres[degree - 1]) * here - lag * before) / steps[degree - 1];
            (before, here) = (here, next);
            sum += coefficients[degree] * here;
        }
        sum
    };
    let values: Vec<f64> = found.iter().map(|(t, _)| value(*t)).collect();
    let weights: Vec<f64> = found.iter().map(|(_, w)| *w).collect();
    let explained = weights.iter().zip(&values).map(|(w, y)| w * y * y).sum();
    Some(Rule {
        nodes: found.iter().map(|(t, _)| middle + half * t).collect(),
        weights,
        values,
        explained,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..97)
            .map(|i| 0.3 + (f64::from(i) * 0.618_034).fract().powi(2))
            .collect();
        let weight: Vec<f64> = (0..97).map(|i| f64::from(1 + i % 4)).collect();
        let y: Vec<f64> = (0..97).map(|i| (f64::from(i) * 7.3).sin()).collect();
        (x, weight, y)
    }

    #[test]
    fn polynomials_of_degree_2q_minus_1_are_summed_exactly_and_no_higher_one() {
        let (x, weight, y) = points();
        let rule = gauss_rule(&x, &weight, &y, 6).expect("97 different points");
        assert!(rule.weights.iter().all(|w| *w > 0.0));
        let gap = |degree: i32| {
            let exact: f64 = x.iter().zip(&weight).map(|(x, w)| w * (x - 0.8).powi(degree)).sum();
            let short: f64 = rule
                .nodes
                .iter()
                .zip(&rule.weights)
                .map(|(x, w)| w * (x - 0.8).powi(degree))
                .sum();
            (exact - short).abs()
        };
        for degree in 0..12 {
            assert!(gap(degree) < 1e-11, "{degree} {:e}", gap(degree));
        }
        assert!(gap(12) > 1e-7, "{:e}", gap(12));
    }

    /// Σ w (y − f)² about any polynomial f of degree q − 1 is the nodes' sum of squares plus what is left.
    #[test]
    fn sums_of_squares_about_a_low_polynomial_are_kept() {
        let (x, weight, y) = points();
        let rule = gauss_rule(&x, &weight, &y, 5).expect("97 different points");
        let f = |x: f64| 0.2 - 0.7 * x + 0.4 * x.powi(3) - 0.1 * x.powi(4);
        let exact: f64 = (0..97).map(|i| weight[i] * (y[i] - f(x[i])).powi(2)).sum();
        let total: f64 = (0..97).map(|i| weight[i] * y[i] * y[i]).sum();
        let nodes = rule.nodes.iter().zip(&rule.weights).zip(&rule.values);
        let short: f64 = nodes.map(|((x, w), y)| w * (y - f(*x)).powi(2)).sum();
        assert!(total >= rule.explained);
        assert!((exact - (short + total - rule.explained)).abs() < 1e-10);
    }

    #[test]
    fn too_few_different_points_have_no_rule() {
        assert!(gauss_rule(&[0.1, 0.2, 0.2], &[1.0; 3], &[0.0; 3], 3).is_none());
        assert!(gauss_rule(&[0.2, 0.2], &[1.0; 2], &[0.0; 2], 1).is_none());
    }
}
