//! Finds few of many weighted points that have the same moments with weights of their own.
//!
//! Of M functions over any number of points with positive weights, at most M of the points can be given positive weights
//! that leave every function's sum as it was (Carathéodory's theorem). Found as Litterer & Lyons 2012 do, Ann. Appl.
//! Probab. 22, 1301: points are gathered in groups, the groups' means reduced to M, and the points of the groups that are
//! left gathered anew.

use super::polynomials::Polynomials;

/// A point that is left, by its index, with its weight.
pub(crate) type Kept = (usize, f64);

/// Points that stand for all with these weights: the sums of all polynomials are kept to rounding.
///
/// At most as many as there are polynomials; weights are positive.
pub(crate) fn recombine(weight: &[f64], polynomials: &Polynomials) -> Vec<Kept> {
    let functions = polynomials.len();
    let mut kept: Vec<Kept> = weight.iter().copied().enumerate().collect();
    let mut room = polynomials.room();
    while kept.len() > functions {
        let groups = (2 * functions).min(kept.len());
        // neighbours together, in groups of nearly one size
        let bounds: Vec<usize> = (0..=groups).map(|group| group * kept.len() / groups).collect();
        let mut means = vec![vec![0.0; groups]; functions];
        let mut masses = vec![0.0; groups];
        for (group, ends) in bounds.windows(2).enumerate() {
            for &(point, weight) in &kept[ends[0]..ends[1]] {
                polynomials.write(point, &mut room);
                masses[group] += weight;
                let sums = means.iter_mut().zip(&room.values);
                sums.for_each(|(of_function, value)| of_function[group] += weight * value);
            }
            means.iter_mut().for_each(|mean| mean[group] /= masses[group]);
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

/// Weights of the groups of which no more are above 0 than there are functions, with the same sums; `rows` holds the mean of
/// each function over every group.
fn reduce(mut rows: Vec<Vec<f64>>, weight: &[f64]) -> Vec<f64> {
    /// what is left of a function in no group beyond rounding
    const NOTHING: f64 = 1e-10;
    let groups = weight.len();
    let mut weight = weight.to_vec();
    // columns of a basis with the function that each stands for: by elimination, the largest entry first
    let mut basis: Vec<Option<usize>> = vec![None; groups];
    let mut is_used = vec![false; rows.len()];
    for _ in 0..rows.len() {
        let mut best = (NOTHING, 0, 0);
        for (row, values) in rows.iter().enumerate().filter(|(row, _)| !is_used[*row]) {
            for (group, value) in values.iter().enumerate().filter(|(group, _)| basis[*group].is_none()) {
                if value.abs() > best.0 {
                    best = (value.abs(), row, group);
                }
            }
        }
        let (size, row, group) = best;
        if size <= NOTHING {
            break;
        }
        pivot(&mut rows, row, group);
        is_used[row] = true;
        basis[group] = Some(row);
    }
    // a group outside the basis leaves, or takes the place of one that leaves
    for group in 0..groups {
        if basis[group].is_some() {
            continue;
        }
        let own = weight[group];
        // taking t off this group adds t times its coefficient to each of the basis
        let of_basis = |(other, row): (usize, &Option<usize>)| row.map(|row| (other, row));
        let others: Vec<(usize, usize)> = basis.iter().enumerate().filter_map(of_basis).collect();
        let falling = others.iter().filter(|(_, row)| rows[*row][group] < -NOTHING);
        let emptied = falling.map(|&(other, row)| (weight[other] / -rows[row][group], other, row));
        let first = emptied.reduce(|least, next| if next.0 < least.0 { next } else { least });
        let leaves = first.filter(|(most, ..)| *most < own);
        let taken = leaves.map_or(own, |(most, ..)| most);
        for (other, row) in others {
            weight[other] = (weight[other] + taken * rows[row][group]).max(0.0);
        }
        weight[group] = own - taken;
        match leaves {
            Some((_, other, row)) => {
                weight[other] = 0.0;
                pivot(&mut rows, row, group);
                basis[other] = None;
                basis[group] = Some(row);
            }
            None => weight[group] = 0.0,
        }
    }
    weight
}

/// Makes a column that of one row alone.
fn pivot(rows: &mut [Vec<f64>], row: usize, column: usize) {
    let over = 1.0 / rows[row][column];
    rows[row].iter_mut().for_each(|value| *value *= over);
    let own = rows[row].clone();
    for (_, other) in rows.iter_mut().enumerate().filter(|(index, _)| *index != row) {
        let factor = other[column];
        if factor != 0.0 {
            other
                .iter_mut()
                .zip(&own)
                .for_each(|(value, own)| *value -= factor * own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::condensing::polynomials::Axis;

    /// Sums of the polynomials over points.
    fn sums(polynomials: &Polynomials, points: &[Kept]) -> Vec<f64> {
        let mut room = polynomials.room();
        let mut sums = vec![0.0; polynomials.len()];
        for (point, weight) in points {
            polynomials.write(*point, &mut room);
            let terms = sums.iter_mut().zip(&room.values);
            terms.for_each(|(sum, value)| *sum += weight * value);
        }
        sums
    }

    #[test]
    fn few_points_have_the_moments_of_all() {
        let column = |step: f64| -> Vec<f64> { (0..5000).map(|i| (f64::from(i) * step).fract()).collect() };
        let columns = [0.618_034, 0.754_877_7].map(column);
        let axes: Vec<Axis> = columns.iter().filter_map(|column| Axis::new(column)).collect();
        let polynomials = Polynomials::new(&axes, 4);
        let weight: Vec<f64> = (0..5000).map(|i| f64::from(1 + i % 4)).collect();
        let kept = recombine(&weight, &polynomials);
        assert!(
            kept.len() <= 15 && kept.iter().all(|(_, weight)| *weight > 0.0),
            "{kept:?}"
        );
        let all: Vec<Kept> = weight.iter().copied().enumerate().collect();
        for (few, all) in sums(&polynomials, &kept).into_iter().zip(sums(&polynomials, &all)) {
            assert!((few - all).abs() < 1e-9 * weight.len() as f64, "{few} {all}");
        }
    }

    /// A function that is another one twice is no hindrance.
    #[test]
    fn points_on_a_line_have_the_moments_of_a_line() {
        let x: Vec<f64> = (0..300).map(f64::from).collect();
        let twice: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
        let axes: Vec<Axis> = [&x, &twice]
            .into_iter()
            .filter_map(|column| Axis::new(column))
            .collect();
        let polynomials = Polynomials::new(&axes, 2);
        let kept = recombine(&[1.0; 300], &polynomials);
        assert!(kept.len() <= 6, "{kept:?}");
        let all: Vec<Kept> = (0..300).map(|point| (point, 1.0)).collect();
        for (few, all) in sums(&polynomials, &kept).into_iter().zip(sums(&polynomials, &all)) {
            assert!((few - all).abs() < 1e-9 * 300.0, "{few} {all}");
        }
    }
}
