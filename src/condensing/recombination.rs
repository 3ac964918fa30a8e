//! Finds few of many weighted points that have the same moments with weights of their own.
//!
//! Of M functions over any number of points with positive weights, at most M of the points can be given positive weights
//! that leave every function's sum as it was (Carathéodory's theorem). Found as Litterer & Lyons 2012 do, Ann. Appl.
//! Probab. 22, 1301: points are gathered in groups, the groups' means reduced to M, and the points of the groups that are
//! left gathered anew.

use nalgebra::{DMatrix, DVector};

use super::polynomials::Polynomials;

/// A point that is left, by its index, with its weight.
pub(crate) type Kept = (usize, f64);

/// Points that stand for all with these weights: the sums of all polynomials are kept to rounding.
///
/// At most as many as there are polynomials; weights are positive.
pub(crate) fn recombine(weight: &[f64], polynomials: &Polynomials) -> Vec<Kept> {
    let functions = polynomials.len();
    let mut kept: Vec<Kept> = weight.iter().copied().enumerate().collect();
    while kept.len() > functions {
        let groups = (2 * functions).min(kept.len());
        // neighbours together, in groups of nearly one size
        let bounds: Vec<usize> = (0..=groups).map(|group| group * kept.len() / groups).collect();
        let mut means = DMatrix::zeros(functions, groups);
        let mut masses = DVector::zeros(groups);
        for (group, ends) in bounds.windows(2).enumerate() {
            for &(point, weight) in &kept[ends[0]..ends[1]] {
                masses[group] += weight;
                let sums = means.column_mut(group);
                (sums.into_iter().zip(polynomials.at(point))).for_each(|(sum, value)| *sum += weight * value);
            }
            means.column_mut(group).unscale_mut(masses[group]);
        }
        let new = reduce(means, &masses);
        let mut next = Vec::with_capacity(kept.len() / 2 + 1);
        for (group, ends) in bounds.windows(2).enumerate() {
            if new[group] > 0.0 {
                let factor = new[group] / masses[group];
                let of_group = &kept[ends[0]..ends[1]];
                next.extend(of_group.iter().map(|(point, weight)| (*point, weight * factor)));
            }
        }
        if next.len() >= kept.len() {
            break;
        }
        kept = next;
    }
    kept
}

/// Weights of the groups of which no more are above 0 than there are functions, with the same sums; `means` holds the mean of
/// each function over every group in a column.
fn reduce(means: DMatrix<f64>, weight: &DVector<f64>) -> DVector<f64> {
    /// what is left of a function in no group, and of a group in no move, beyond rounding
    const NOTHING: f64 = 1e-10;
    let groups = weight.len();
    let elimination = means.full_piv_lu();
    let upper = elimination.u();
    let rank = upper
        .columns(0, upper.nrows())
        .diagonal()
        .iter()
        .take_while(|own| own.abs() > NOTHING)
        .count();
    // moves of weight between groups that no function sees: one more group each, with what the first ones give for it
    let mut moves = DMatrix::identity(groups, groups).remove_columns(0, rank);
    let given = upper.view((0, rank), (rank, groups - rank));
    if let Some(given) = upper.view((0, 0), (rank, rank)).solve_upper_triangular(&given) {
        moves.rows_mut(0, rank).copy_from(&-given);
    }
    elimination.q().inv_permute_rows(&mut moves);
    let mut weight = weight.clone();
    for place in (0..moves.ncols()).rev() {
        let own = moves.column(place).into_owned();
        // gone along until the first group is empty, which the other moves then leave as it is
        let emptied = own.iter().zip(&weight).enumerate();
        let emptied = emptied.filter(|(_, (part, _))| **part > NOTHING);
        let first = emptied.map(|(group, (part, weight))| (group, weight / part));
        let Some((group, most)) = first.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        weight.axpy(-most, &own, 1.0);
        weight.apply(|left| *left = left.max(0.0));
        weight[group] = 0.0;
        for other in 0..place {
            let factor = moves[(group, other)] / own[group];
            moves.column_mut(other).axpy(-factor, &own, 1.0);
            moves[(group, other)] = 0.0;
        }
    }
    weight
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::condensing::polynomials::{functions, Axis};

    /// Sums of x^a y^b over points, for all powers up to a degree together.
    fn moments([x, y]: &[Vec<f64>; 2], degree: u8, points: &[Kept]) -> Vec<f64> {
        let degree = i32::from(degree);
        let powers = (0..=degree).flat_map(|a| (0..=degree - a).map(move |b| (a, b)));
        let moment = |(a, b): (i32, i32)| -> f64 {
            let terms = points
                .iter()
                .map(|(at, weight)| weight * x[*at].powi(a) * y[*at].powi(b));
            terms.sum()
        };
        powers.map(moment).collect()
    }

    /// Holds that as many points as there are polynomials stand for all of two columns, with the same moments.
    fn assert_kept(columns: [Vec<f64>; 2], weight: &[f64], degree: u8) {
        let axes: Vec<Axis> = columns.iter().filter_map(|column| Axis::new(column)).collect();
        let kept = recombine(weight, &Polynomials::new(&axes, degree.into()));
        let most = functions(2, degree.into());
        assert!(
            kept.len() <= most && kept.iter().all(|(_, weight)| *weight > 0.0),
            "{kept:?}"
        );
        let all: Vec<Kept> = weight.iter().copied().enumerate().collect();
        let [few, all] = [kept, all].map(|points| moments(&columns, degree, &points));
        for (few, all) in few.iter().zip(&all) {
            assert!((few - all).abs() < 1e-9 * weight.len() as f64, "{few} {all}");
        }
    }

    #[test]
    fn few_points_have_the_moments_of_all() {
        let column = |step: f64| -> Vec<f64> { (0..5000).map(|i| (f64::from(i) * step).fract()).collect() };
        let weight: Vec<f64> = (0..5000).map(|i| f64::from(1 + i % 4)).collect();
        assert_kept([0.618_034, 0.754_877_7].map(column), &weight, 4);
        // a column that is another one twice is no hindrance
        let line = |step: f64| -> Vec<f64> { (0..300).map(|i| f64::from(i) * step / 300.0).collect() };
        assert_kept([1.0, 2.0].map(line), &[1.0; 300], 2);
    }
}
