//! Estimates densities of draws: smoothed ones of one quantity, and the curves around the densest shares of two.
//!
//! The density of two is a Gaussian kernel estimate with one and a half times Scott's bandwidth n^(−1/6), in coordinates in
//! which the cloud is round (Scott 1992, Multivariate Density Estimation, eq. 6.42), on a grid; a curve's level is the density
//! that the share of the points exceeds, so that it holds its share whatever the smoothing.

/// Points along a smoothed density.
const CURVE: usize = 60;
/// Draws a smoothed density is made of.
const SMOOTHED: usize = 1000;
/// Grid points along each axis.
const GRID: usize = 96;
/// Times Scott's bandwidth: draws that follow one another are fewer than they look, and their ripples are no islands.
const SMOOTHING: f64 = 1.5;
/// Fewer points have no shape.
const LEAST_POINTS: usize = 200;
/// Points beyond these quantiles of each axis do not stretch the grid.
const OUTERMOST: f64 = 0.001;

/// A density on a grid, and the transformation to and from the cloud's own coordinates.
pub struct CloudDensity {
    centre: [f64; 2],
    /// lower triangle of the cloud's covariance root: x = centre + root u
    root: [f64; 3],
    first: [f64; 2],
    step: [f64; 2],
    /// GRID × GRID, rows of the first coordinate
    values: Vec<f64>,
    /// density at each point of the cloud, from the largest
    at_points: Vec<f64>,
}

impl CloudDensity {
    /// Estimates the density of the finite points; `None` where they are few or lie on a line.
    pub fn new(pairs: &[[f64; 2]]) -> Option<CloudDensity> {
        let finite: Vec<[f64; 2]> = pairs
            .iter()
            .copied()
            .filter(|p| p.iter().all(|x| x.is_finite()))
            .collect();
        if finite.len() < LEAST_POINTS {
            return None;
        }
        let (centre, root) = round(&finite)?;
        let inward = |[x, y]: [f64; 2]| {
            let u = (x - centre[0]) / root[0];
            [u, (y - centre[1] - root[1] * u) / root[2]]
        };
        let rounded: Vec<[f64; 2]> = finite.into_iter().map(inward).collect();
        let bandwidth = SMOOTHING * (rounded.len() as f64).powf(-1.0 / 6.0);
        let [lows, highs] = [OUTERMOST, 1.0 - OUTERMOST].map(|p| [0, 1].map(|axis| quantile(&rounded, axis, p)));
        let first = lows.map(|low| low - 4.0 * bandwidth);
        let step = [0, 1].map(|axis| (highs[axis] + 4.0 * bandwidth - first[axis]) / (GRID as f64 - 1.0));
        let mut density = CloudDensity {
            centre,
            root,
            first,
            step,
            values: vec![0.0; GRID * GRID],
            at_points: vec![],
        };
        for point in &rounded {
            for (index, share) in density.corners(point).into_iter().flatten() {
                density.values[index] += share;
            }
        }
        for (axis, step) in step.into_iter().enumerate() {
            density.smooth(axis, bandwidth / step);
        }
        density.at_points = rounded.iter().map(|point| density.at(point)).collect();
        density.at_points.sort_unstable_by(|a, b| b.total_cmp(a));
        Some(density)
    }

    /// The four grid points around a point in round coordinates, with their shares of it; `None` outside the grid.
    fn corners(&self, point: &[f64; 2]) -> Option<[(usize, f64); 4]> {
        let place = [0, 1].map(|axis| (point[axis] - self.first[axis]) / self.step[axis]);
        let inside = place.iter().all(|p| (0.0..GRID as f64 - 1.0).contains(p));
        inside.then(|| {
            let [i, j] = place.map(|p| p as usize);
            let [s, t] = place.map(f64::fract);
            let at = i * GRID + j;
            [
                (at, (1.0 - s) * (1.0 - t)),
                (at + 1, (1.0 - s) * t),
                (at + GRID, s * (1.0 - t)),
                (at + GRID + 1, s * t),
            ]
        })
    }

    fn at(&self, point: &[f64; 2]) -> f64 {
        let corners = self.corners(point).into_iter().flatten();
        corners.map(|(index, share)| share * self.values[index]).sum()
    }

    /// Spreads along one axis by a Gaussian of this many steps.
    fn smooth(&mut self, axis: usize, sd: f64) {
        let reach = (4.0 * sd).ceil() as usize;
        let weight = |away: usize| (-0.5 * (away as f64 / sd).powi(2)).exp();
        let kernel: Vec<f64> = (0..=reach).map(weight).collect();
        let index = |line: usize, along: usize| {
            if axis == 0 {
                along * GRID + line
            } else {
                line * GRID + along
            }
        };
        for line in 0..GRID {
            let before: Vec<f64> = (0..GRID).map(|along| self.values[index(line, along)]).collect();
            for along in 0..GRID {
                let near = along.saturating_sub(reach)..(along + reach + 1).min(GRID);
                self.values[index(line, along)] = near.map(|at| before[at] * kernel[at.abs_diff(along)]).sum();
            }
        }
    }

    /// Closed curves around the densest `share` of the points, in the cloud's own coordinates.
    pub fn around(&self, share: f64) -> Vec<Vec<(f64, f64)>> {
        let last = self.at_points.len() - 1;
        let level = self.at_points[((share * self.at_points.len() as f64) as usize).min(last)];
        let mut pieces = vec![];
        for i in 0..GRID - 1 {
            for j in 0..GRID - 1 {
                pieces.extend(self.crossings(i, j, level));
            }
        }
        let outward = |edge: Edge| {
            let [u, v] = self.crossing(edge, level);
            (
                self.centre[0] + self.root[0] * u,
                self.centre[1] + self.root[1] * u + self.root[2] * v,
            )
        };
        joined(pieces)
            .into_iter()
            .map(|curve| curve.into_iter().map(outward).collect())
            .collect()
    }

    /// The pieces of a level inside one cell, from edge to edge with the dense side on the left.
    fn crossings(&self, i: usize, j: usize, level: f64) -> Vec<(Edge, Edge)> {
        let corner = |k: usize| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)][k % 4];
        let above = |k: usize| {
            let (i, j) = corner(k);
            self.values[i * GRID + j] > level
        };
        let edge = |k: usize| {
            let (a, b) = (corner(k), corner(k + 1));
            (a.min(b), a.max(b))
        };
        let leaves: Vec<usize> = (0..4).filter(|k| above(*k) && !above(k + 1)).collect();
        // from where the border of the cell leaves the dense side back to where that side began
        let begins = |leave: usize| (1..4).map(|back| leave + 4 - back).find(|k| !above(*k) && above(k + 1));
        leaves
            .into_iter()
            .filter_map(|leave| Some((edge(leave), edge(begins(leave)? % 4))))
            .collect()
    }

    /// Where an edge of the grid crosses a level, in round coordinates.
    fn crossing(&self, (a, b): Edge, level: f64) -> [f64; 2] {
        let value = |(i, j): (usize, usize)| self.values[i * GRID + j];
        let share = (level - value(a)) / (value(b) - value(a));
        let along = |from: usize, to: usize| from as f64 + share * (to as f64 - from as f64);
        [
            self.first[0] + self.step[0] * along(a.0, b.0),
            self.first[1] + self.step[1] * along(a.1, b.1),
        ]
    }
}

/// Two neighbouring grid points, the lesser first.
type Edge = ((usize, usize), (usize, usize));

/// Joins pieces end to end into closed curves.
fn joined(pieces: Vec<(Edge, Edge)>) -> Vec<Vec<Edge>> {
    let mut next: std::collections::BTreeMap<Edge, Edge> = pieces.into_iter().collect();
    let mut curves = vec![];
    while let Some((start, mut at)) = next.pop_first() {
        let mut curve = vec![start];
        while at != start {
            curve.push(at);
            match next.remove(&at) {
                Some(further) => at = further,
                None => break,
            }
        }
        curve.push(start);
        curves.push(curve);
    }
    curves
}

/// Centre and covariance root of the points inside the outermost quantiles; `None` where they lie on a line.
fn round(points: &[[f64; 2]]) -> Option<([f64; 2], [f64; 3])> {
    let bounds = [0, 1].map(|axis| [0.01, 0.99].map(|p| quantile(points, axis, p)));
    let inside = |p: &&[f64; 2]| (0..2).all(|axis| (bounds[axis][0]..=bounds[axis][1]).contains(&p[axis]));
    let inner: Vec<&[f64; 2]> = points.iter().filter(inside).collect();
    let n = inner.len() as f64;
    let centre = [0, 1].map(|axis| inner.iter().map(|p| p[axis]).sum::<f64>() / n);
    let moment = |a: usize, b: usize| {
        let products = inner.iter().map(|p| (p[a] - centre[a]) * (p[b] - centre[b]));
        products.sum::<f64>() / n
    };
    let first = moment(0, 0).sqrt();
    let shared = moment(0, 1) / first;
    let own = (moment(1, 1) - shared * shared).sqrt();
    let spread = first > 0.0 && own > 1e-6 * moment(1, 1).sqrt();
    spread.then_some((centre, [first, shared, own]))
}

fn quantile(points: &[[f64; 2]], axis: usize, p: f64) -> f64 {
    let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
    let at = (p * (values.len() as f64 - 1.0)).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Density of draws from lo to hi as the heights of so many equal bars; what lies beyond counts to the outer ones.
pub fn bars(draws: &[f64], (lo, hi): (f64, f64), count: usize) -> Vec<f64> {
    let width = (hi - lo) / count as f64;
    let mut heights = vec![0.0; count];
    for draw in draws {
        // a float too large for an index saturates, and one of draws all the same is NaN, which becomes 0
        heights[(((draw - lo) / width) as usize).min(count - 1)] += 1.0;
    }
    let share = 1.0 / (draws.len() as f64 * width);
    heights.iter_mut().for_each(|height| *height *= share);
    heights
}

/// The density of draws inside bounds over its highest, at points from lowest to highest, some four standard deviations
/// about the mean: a normal kernel of Silverman's width, 1.06 sd n^(−1/5).
pub fn smoothed(draws: &[f64], (lower, upper): (f64, f64)) -> Vec<(f64, f64)> {
    let step = draws.len().div_ceil(SMOOTHED).max(1);
    let some: Vec<f64> = draws.iter().copied().step_by(step).collect();
    let n = some.len() as f64;
    let mean = some.iter().sum::<f64>() / n;
    let sd = (some.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt();
    let width = 1.06 * sd * n.powf(-0.2);
    let (lo, hi) = ((mean - 4.0 * sd).max(lower), (mean + 4.0 * sd).min(upper));
    let at = |x: f64| -> f64 {
        let kernel = some.iter().map(|draw| (x - draw) / width);
        kernel.map(|z| (-0.5 * z * z).exp()).sum()
    };
    let along = (0..=CURVE).map(|i| lo + (hi - lo) * i as f64 / CURVE as f64);
    let mut curve: Vec<(f64, f64)> = along.map(|x| (x, at(x))).collect();
    let highest = curve.iter().map(|point| point.1).fold(0.0, f64::max);
    for point in &mut curve {
        point.1 /= highest;
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::stream;
    use rand_distr::{Distribution, StandardNormal};

    /// Strongly correlated, bent, with the scales of e_inf and St_c.
    fn cloud(name: &str, points: usize) -> Vec<[f64; 2]> {
        let mut rng = stream(1, name, 0);
        let mut z = || -> f64 { StandardNormal.sample(&mut rng) };
        let one = |_| {
            let (a, b) = (z(), z());
            [0.7 + 0.01 * a, 8.0 + 0.5 * a + 0.1 * b + 0.05 * a * a]
        };
        (0..points).map(one).collect()
    }

    fn held(curves: &[Vec<(f64, f64)>], points: &[[f64; 2]]) -> f64 {
        let inside = |p: &&[f64; 2]| {
            let crossed = curves.iter().flat_map(|curve| curve.windows(2)).filter(|piece| {
                let ((x1, y1), (x2, y2)) = (piece[0], piece[1]);
                (y1 > p[1]) != (y2 > p[1]) && p[0] < x1 + (p[1] - y1) / (y2 - y1) * (x2 - x1)
            });
            crossed.count() % 2 == 1
        };
        points.iter().filter(inside).count() as f64 / points.len() as f64
    }

    #[test]
    fn a_curve_holds_its_share() {
        let points = cloud("a_curve_holds_its_share", 10_000);
        let fresh = cloud("a_curve_holds_its_share of fresh points", 10_000);
        let density = CloudDensity::new(&points).expect("a cloud");
        for share in [0.5, 0.95] {
            let curves = density.around(share);
            assert_eq!(curves.len(), 1, "one curve around one hill");
            assert_eq!(curves[0].first(), curves[0].last(), "closed");
            assert!(
                (held(&curves, &points) - share).abs() < 0.005,
                "{}",
                held(&curves, &points)
            );
            // 4.5 binomial standard errors
            let error = 4.5 * (share * (1.0 - share) / 10_000.0f64).sqrt();
            assert!(
                (held(&curves, &fresh) - share).abs() < error,
                "{}",
                held(&curves, &fresh)
            );
            // the planted fault: the coordinates not turned back, which leaves the correlation out
            let upright: Vec<Vec<(f64, f64)>> = curves
                .iter()
                .map(|curve| curve.iter().map(|(x, y)| (*x, y - 50.0 * (x - 0.7))).collect())
                .collect();
            assert!(held(&upright, &points) < 0.7 * share);
        }
    }

    #[test]
    fn two_hills_have_two_curves_and_a_line_none() {
        let mut points = cloud("two_hills_have_two_curves", 4_000);
        let far = points.iter().map(|[x, y]| [x + 0.2, *y]).collect::<Vec<_>>();
        points.extend(far);
        let curves = CloudDensity::new(&points).expect("a cloud").around(0.5);
        assert_eq!(curves.len(), 2);
        assert!((held(&curves, &points) - 0.5).abs() < 0.01);
        let line: Vec<[f64; 2]> = (0..1000).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
        assert!(CloudDensity::new(&line).is_none());
        assert!(CloudDensity::new(&points[..50]).is_none());
    }

    #[test]
    fn a_smoothed_density_is_highest_where_most_draws_are() {
        let draws: Vec<f64> = (0..1000)
            .map(|i| 1.0 + ((f64::from(i) * 0.618).fract() - 0.5).powi(3))
            .collect();
        let curve = smoothed(&draws, (0.0, f64::INFINITY));
        let highest = curve.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("points");
        assert!((highest.0 - 1.0).abs() < 0.02 && highest.1 == 1.0, "{highest:?}");
    }
}
