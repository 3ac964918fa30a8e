//! Makes layers of points and curves: means of repeated runs, laws in steps.

use super::super::chart::{ChartPoint, Layer, Style};

/// More points than this are joined into wider bins.
const MOST_POINTS: usize = 2000;
/// Runs whose abscissae agree to this share are one point; wider bins follow where there are too many.
const BIN_WIDTHS: [f64; 5] = [SAME, 0.02, 0.05, 0.1, 0.3];
/// Share by which abscissae of repeats may differ: more than rounding, less than neighbouring drop heights do.
pub(in crate::report) const SAME: f64 = 0.001;
/// Points along a curve.
const CURVE: usize = 160;

/// A layer of points; `None` without any.
pub(super) fn points(name: impl Into<String>, points: Vec<ChartPoint>, style: Style) -> Option<Layer> {
    (!points.is_empty()).then(|| Layer::points(Some(name.into()), points, style))
}

/// Points of (x, e): runs whose x agree are one mean with its standard error.
pub(in crate::report) fn means(pairs: &mut [(f64, f64)], width: f64) -> Vec<ChartPoint> {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut points = vec![];
    let mut rest = &*pairs;
    while let Some((first, _)) = rest.first() {
        let count = rest
            .iter()
            .take_while(|(x, _)| *x <= first * (1.0 + width))
            .count()
            .max(1);
        let (bin, after) = rest.split_at(count);
        let n = count as f64;
        let x = bin.iter().map(|(x, _)| x).sum::<f64>() / n;
        let y = bin.iter().map(|(_, e)| e).sum::<f64>() / n;
        let spread: f64 = bin.iter().map(|(_, e)| (e - y) * (e - y)).sum();
        let y_se = (count > 1).then(|| (spread / (n - 1.0) / n).sqrt());
        points.push(ChartPoint { x, y, y_se });
        rest = after;
    }
    points
}

/// The same for several groups at once, with the narrowest bins that keep the figure readable.
pub(super) fn means_of(mut groups: Vec<Vec<(f64, f64)>>) -> Vec<Vec<ChartPoint>> {
    let mut joined = vec![];
    for width in BIN_WIDTHS {
        joined = groups.iter_mut().map(|pairs| means(pairs, width)).collect();
        if joined.iter().map(Vec::len).sum::<usize>() <= MOST_POINTS {
            break;
        }
    }
    joined
}

pub(super) fn steps(lo: f64, hi: f64) -> impl Iterator<Item = f64> {
    (0..=CURVE).map(move |i| lo + (hi - lo) * i as f64 / CURVE as f64)
}

pub(super) fn largest<'p>(points: impl Iterator<Item = &'p Vec<ChartPoint>>) -> Option<f64> {
    points.flatten().map(|p| p.x).reduce(f64::max)
}
