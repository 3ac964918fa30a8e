//! Draws each parameter's density before and after the runs.

use super::super::super::chart::{Axis, Chart, Dash, Layer, Style};
use super::super::super::quantities::{in_scripts, unit_in_brackets};
use super::super::super::ReportInput;
use super::panels::{draws, first_places, symbol, MOST_PANELS};
use crate::findings::posterior::Posterior;
use crate::inference::density::smoothed;
use crate::model::parameters::ModelParameter;
use crate::scene::Prior;

/// Points along a density.
const CURVE: usize = 120;
/// A prior is shown where it has more than this share of its highest density.
const SHOWN: f64 = 0.02;
/// Spread of a prior about its median within which it is looked for.
const REACH: f64 = 6.0;
/// SpreadTest in which a prior of usual tails has all but a thousandth on each side.
const MOSTLY: f64 = 5.0;

/// A panel a parameter.
pub(super) fn charts(input: ReportInput, posterior: &Posterior) -> Vec<Chart> {
    let panel = |place: usize| {
        let parameter = &posterior.sampled.parameters.sampled[place];
        let mut chart = chart(parameter, &draws(posterior, place));
        let unit = match parameter.kind.unit() {
            "1" => String::new(),
            unit => format!(" / {}", in_scripts(&unit_in_brackets(unit))),
        };
        chart.x.label = format!("{}{unit}", symbol(input, parameter));
        chart
    };
    first_places(posterior, MOST_PANELS).into_iter().map(panel).collect()
}

fn chart(parameter: &ModelParameter, draws: &[f64]) -> Chart {
    let after = smoothed(draws, parameter.bounds);
    let before = prior_range(parameter);
    let ends = after.iter().map(|point| point.0).chain([before.0, before.1]);
    let (lo, hi) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)));
    let prior = over_highest(along(lo, hi).map(|x| (x, parameter.prior_density(x))).collect());
    let named = |name: &str| Some(name.to_owned());
    Chart {
        title: None,
        x: Axis::new("").between(lo, hi),
        y: Axis::new("").between(0.0, 1.1),
        layers: vec![
            Layer::Band {
                name: named("posterior"),
                edges: after.iter().map(|(x, y)| (*x, 0.0, *y)).collect(),
                style: Style::group(1),
            },
            // a posterior narrower than a pixel is still a line
            Layer::Line {
                name: named("posterior"),
                xy: after,
                style: Style::group(1),
                dash: Dash::Solid,
            },
            Layer::Line {
                name: named("prior"),
                xy: prior,
                style: Style::group(2),
                dash: Dash::Dashed,
            },
        ],
    }
}

fn along(lo: f64, hi: f64) -> impl Iterator<Item = f64> {
    (0..=CURVE).map(move |i| lo + (hi - lo) * i as f64 / CURVE as f64)
}

/// Where a prior has most of its density.
fn prior_range(parameter: &ModelParameter) -> (f64, f64) {
    let median = parameter.prior.median();
    let spread = match parameter.prior {
        // may have no sd
        Prior::StudentT(_, _, scale) => 2.0 * scale,
        prior => prior.sd().unwrap_or(f64::INFINITY),
    };
    // a heavy tail may have its sd far beyond whatever is drawn
    let ends = [0.001, 0.999].map(|p| parameter.prior.quantile(p).unwrap_or(median));
    let spread = spread.min((ends[1] - ends[0]) / MOSTLY);
    let lo = (median - REACH * spread).max(parameter.bounds.0);
    let hi = (median + REACH * spread).min(parameter.bounds.1);
    let curve: Vec<(f64, f64)> = over_highest(along(lo, hi).map(|x| (x, parameter.prior_density(x))).collect());
    let mut dense = curve.iter().filter(|point| point.1 > SHOWN).map(|point| point.0);
    let first = dense.next().unwrap_or(lo);
    let step = (hi - lo) / CURVE as f64;
    (
        (first - step).max(lo),
        (dense.next_back().unwrap_or(first) + step).min(hi),
    )
}

fn over_highest(mut curve: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let highest = curve.iter().map(|point| point.1).fold(0.0, f64::max);
    for point in &mut curve {
        point.1 /= highest;
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::parameters::ParameterKind;

    fn parameter(prior: Prior, bounds: (f64, f64)) -> ModelParameter {
        ModelParameter {
            kind: ParameterKind::LUBRICATION_LOG,
            name: "lubrication_log".to_owned(),
            bounds,
            prior,
            source: "a test",
        }
    }

    #[test]
    fn a_prior_is_shown_where_it_has_density_and_never_beyond_its_bounds() {
        let above = (0.0, f64::INFINITY);
        let (lo, hi) = prior_range(&parameter(Prior::LogNormal(3.0, 0.5), above));
        assert!(lo < 1.0 && lo > 0.0 && hi > 7.0 && hi < 14.0, "{lo} {hi}");
        let (lo, hi) = prior_range(&parameter(Prior::Normal(0.5, 1.0), (0.0, 0.9)));
        assert!(lo == 0.0 && (hi - 0.9).abs() < 1e-12, "{lo} {hi}");
        // a Student-t without a variance
        let (lo, hi) = prior_range(&parameter(Prior::StudentT(1.0, 2.0, 0.1), above));
        assert!(lo > 0.7 && hi < 3.3 && hi - lo > 1.0, "{lo} {hi}");
        let (lo, hi) = prior_range(&parameter(Prior::Uniform(1.0, 2.0), (1.0, 2.0)));
        assert!((1.0..1.1).contains(&lo) && (1.9..=2.0).contains(&hi), "{lo} {hi}");
    }
}
