//! Finds few of many weighted points that have the same moments with weights of their own.
//!
//! Of M functions over any number of points with positive weights, at most M of the points can be given positive weights
//! that leave every function's sum as it was (Carathéodory's theorem). Found as Litterer & Lyons 2012 do, Ann. Appl.
//! Probab. 22, 1301: points are gathered in groups, the groups' means reduced to M, and the points of the groups that are
//! left gathered anew.

/// A point that is left, by its index, with its weight.
pub(super) type Kept = (usize, f64);

/// Points that stand for all: `count` of them with `weight`, on which `functions` writes the values of one point, of which
/// the first is 1 everywhere.
///
/// At most as many as there are functions; weights are positive, and the sums kept to rounding.
pub(super) fn recombine(weight: &[f64], functions: usize, mut at: impl FnMut(usize, &mut [f64])) -> Vec<Kept> {
    let mut kept: Vec<Kept> = weight.iter().copied().enumerate().collect();
    let mut value = vec![0.0; functions];
    while kept.len() > functions {
        let groups = (2 * functions).min(kept.len());
        // neighbours together, in groups of nearly one size
        let bounds: Vec<usize> = (0..=groups).map(|group| group * kept.len() / groups).collect();
        let mut means = vec![0.0; groups * functions];
        let mut masses = vec![0.0; groups];
        for (group, ends) in bounds.windows(2).enumerate() {
            let mean = &mut means[group * functions..][..functions];
            for &(point, weight) in &kept[ends[0]..ends[1]] {
                at(point, &mut value);
                masses[group] += weight;
                mean.iter_mut()
                    .zip(&value)
                    .for_each(|(sum, value)| *sum += weight * value);
            }
            mean.iter_mut().for_each(|sum| *sum /= masses[group]);
        }
        let new = reduce(means, &masses, functions);
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

/// Weights of the groups of which no more than `functions` are above 0, with the same sums; `means` holds the functions of
/// each group in turn.
fn reduce(mut means: Vec<f64>, weight: &[f64], functions: usize) -> Vec<f64> {
    /// what is left of a function in no group beyond rounding
    const NOTHING: f64 = 1e-10;
    let groups = weight.len();
    let mut weight = weight.to_vec();
    // columns of a basis with the function that each stands for: by elimination, the largest entry first
    let mut basis: Vec<Option<usize>> = vec![None; groups];
    let mut rows: Vec<Vec<f64>> = (0..functions)
        .map(|function| (0..groups).map(|group| means[group * functions + function]).collect())
        .collect();
    means.clear();
    let mut is_used = vec![false; functions];
    for _ in 0..functions {
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
        let mut first: Option<(f64, usize, usize)> = None;
        for (other, row) in basis
            .iter()
            .enumerate()
            .filter_map(|(other, row)| Some((other, (*row)?)))
        {
            let coefficient = rows[row][group];
            if coefficient < -NOTHING {
                let most = weight[other] / -coefficient;
                if first.is_none_or(|(least, ..)| most < least) {
                    first = Some((most, other, row));
                }
            }
        }
        let leaves = first.filter(|(most, ..)| *most < own);
        let taken = leaves.map_or(own, |(most, ..)| most);
        for (other, row) in basis
            .iter()
            .enumerate()
            .filter_map(|(other, row)| Some((other, (*row)?)))
        {
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

    #[test]
    fn few_points_have_the_moments_of_all() {
        let point = |i: usize| {
            let i = i as f64;
            [(i * 0.618_034).fract(), (i * 0.754_877_7).fract()]
        };
        let powers = |i: usize, into: &mut [f64]| {
            let [x, y] = point(i).map(|x| 2.0 * x - 1.0);
            let mut place = 0;
            for degree in 0..=4i32 {
                for of_y in 0..=degree {
                    into[place] = x.powi(degree - of_y) * y.powi(of_y);
                    place += 1;
                }
            }
        };
        let weight: Vec<f64> = (0..5000).map(|i| f64::from(1 + i % 4)).collect();
        let kept = recombine(&weight, 15, powers);
        assert!(
            kept.len() <= 15 && kept.iter().all(|(_, weight)| *weight > 0.0),
            "{kept:?}"
        );
        let sums = |points: &[Kept]| {
            let mut sums = [0.0; 15];
            let mut value = [0.0; 15];
            for (point, weight) in points {
                powers(*point, &mut value);
                sums.iter_mut()
                    .zip(value)
                    .for_each(|(sum, value)| *sum += weight * value);
            }
            sums
        };
        let all: Vec<Kept> = weight.iter().copied().enumerate().collect();
        for (few, all) in sums(&kept).into_iter().zip(sums(&all)) {
            assert!((few - all).abs() < 1e-9 * weight.len() as f64, "{few} {all}");
        }
    }

    /// A function that is another one twice asks for no point of its own.
    #[test]
    fn points_on_a_line_need_no_more_than_a_line_does() {
        let functions = |i: usize, into: &mut [f64]| {
            let x = i as f64 / 300.0;
            into.copy_from_slice(&[1.0, x, 2.0 * x, x * x, x * x]);
        };
        let kept = recombine(&[1.0; 300], 5, functions);
        assert!(kept.len() <= 3, "{kept:?}");
    }
}
