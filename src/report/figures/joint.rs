//! Says what the figures of e_inf and St_c together show: clouds as contours, with each quantity's intervals.

use super::super::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::super::quantities::in_scripts;
use super::super::{numbers, ReportInput};
use super::figure::Figure;
use super::names::Names;
use super::of_particle::scaling_of;
use super::points::{chart, curve, points};
use crate::findings::bootstrap::JointReplicates;
use crate::findings::estimate::Estimate;
use crate::findings::regions::{self, Contour, SHARES};
use crate::inference::delta::Interval;
use crate::physics::Quantity;
use crate::scene::WetLaw;

/// How uncertain e_inf and St_c are together by one method, and the intervals of each.
struct Cloud {
    /// text of the legend
    name: &'static str,
    contours: Vec<Contour>,
    /// intervals of e_inf and St_c, where they were made
    intervals: [Option<[f64; 2]>; 2],
    /// colour
    style: Style,
}

/// Intervals of e_inf and St_c by one method, and how they are drawn.
struct IntervalBars {
    /// text of the legend
    name: String,
    intervals: [Option<[f64; 2]>; 2],
    style: Style,
    dash: Dash,
}

/// Strokes of the contours, in the order of their shares.
const STROKES: [Dash; SHARES.len()] = [Dash::Dashed, Dash::Solid];

/// Every joint figure: one a sphere and film ratio, a panel a law.
pub(super) fn joint(input: ReportInput, names: &Names) -> Vec<Figure> {
    let Some(resampling) = &input.findings.bootstrap else {
        return vec![];
    };
    let mut figures = vec![];
    for (index, sphere) in input.runs.spheres.iter().enumerate() {
        for over_all in [false, true] {
            let mine = |joint: &&JointReplicates| joint.sphere == index && joint.film_ratio.is_none() == over_all;
            let panels = resampling.joint.iter().filter(mine);
            let charts: Vec<Chart> = panels.filter_map(|joint| of_bootstrap(input, joint)).collect();
            if !charts.is_empty() {
                figures.push(Figure {
                    name: names.joint(&sphere.label(input.scene), over_all),
                    svg: svg(&charts),
                });
            }
        }
    }
    figures
}

fn of_bootstrap(input: ReportInput, joint: &JointReplicates) -> Option<Chart> {
    let row = scaling_of(input, joint.sphere, joint.film_ratio, joint.law)?;
    let both = [&row.e_inf, &row.st_c];
    let by = |estimate: &Estimate, wanted: &dyn Fn(&Interval) -> bool| {
        let made = estimate
            .intervals
            .iter()
            .find(|made| made.level == estimate.level && wanted(made));
        made.map(|made| [made.lo, made.hi])
    };
    let cloud = Cloud {
        name: "bootstrap",
        contours: regions::contours(&joint.pairs),
        intervals: both.map(|estimate| {
            by(estimate, &|made| {
                made.is_bootstrap() && (made.method == estimate.method || estimate.is_curved())
            })
        }),
        style: Style::group(1),
    };
    let ratio = joint
        .film_ratio
        .map_or("every δ/D".to_owned(), |r| format!("δ/D = {}", numbers::short(r)));
    let law = match joint.law {
        WetLaw::Sqrt => "square-root law",
        WetLaw::Linear => "linear law",
    };
    let title = format!(
        "{}, {ratio}, {law}",
        input.runs.spheres[joint.sphere].words(input.scene)
    );
    let centre = (row.e_inf.value?, row.st_c.value?);
    // where the curvature forbids a ±, the delta method's are not shown
    let of_delta =
        |estimate: &&Estimate| by(estimate, &|made| made.method == "delta").filter(|_| !estimate.is_curved());
    let delta = both.map(|estimate| of_delta(&estimate));
    let posterior = input.posterior.zip(input.findings.energy_balance.as_ref());
    let pairs =
        posterior.and_then(|(posterior, balance)| regions::of_posterior(input.scene, balance, posterior, joint));
    let posterior = pairs.map(|pairs| Cloud {
        name: "posterior",
        contours: regions::contours(&pairs),
        intervals: regions::central(&pairs, row.e_inf.level),
        style: Style::group(2),
    });
    let clouds: Vec<Cloud> = [cloud].into_iter().chain(posterior).collect();
    joint_chart(title, centre, delta, &clouds)
}

/// One set of axes: the estimate, the delta method's intervals, and for each cloud its contours and intervals.
///
/// Intervals of e_inf lie along the lower axis, those of St_c along the left one. `None` where no cloud has a shape.
fn joint_chart(title: String, estimate: (f64, f64), delta: [Option<[f64; 2]>; 2], clouds: &[Cloud]) -> Option<Chart> {
    let mut layers = vec![];
    for cloud in clouds {
        for contour in &cloud.contours {
            let name = format!("{}: {} %", cloud.name, numbers::short(100.0 * contour.share));
            let strokes = SHARES.into_iter().zip(STROKES);
            let dash = strokes
                .filter(|(share, _)| *share == contour.share)
                .map(|(_, dash)| dash);
            for dash in dash {
                layers.push(curve(name.clone(), contour.curve.clone(), cloud.style, dash));
            }
        }
    }
    if layers.is_empty() {
        return None;
    }
    let of_delta = IntervalBars {
        name: "± t · se, delta method".to_owned(),
        intervals: delta,
        style: Style::group(0),
        dash: Dash::Dotted,
    };
    let of_clouds = clouds.iter().map(|cloud| IntervalBars {
        name: format!("{} interval", cloud.name),
        intervals: cloud.intervals,
        style: cloud.style,
        dash: Dash::Solid,
    });
    let bars: Vec<IntervalBars> = [of_delta].into_iter().chain(of_clouds).collect();
    let ends = bars.iter().map(|bars| bars.intervals);
    let [x, y] = [0, 1].map(|axis| {
        let of_bars = ends.clone().filter_map(|intervals| intervals[axis]).flatten();
        let of_curves = layers.iter().flat_map(|layer| match layer {
            Layer::Line { xy, .. } => xy.as_slice(),
            _ => &[],
        });
        let all = of_curves.map(|(x, y)| if axis == 0 { *x } else { *y }).chain(of_bars);
        let (lo, hi) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        // room for the bars below and left of the clouds
        let margin = (0.06 + 0.05 * bars.len() as f64) * (hi - lo);
        (lo - margin, hi + 0.06 * (hi - lo))
    });
    for (number, bars) in bars.iter().enumerate() {
        let off = |(lo, hi): (f64, f64)| lo + 0.04 * (1 + number) as f64 * (hi - lo);
        let [e_inf, st_c] = bars.intervals;
        let along_x = e_inf.map(|[lo, hi]| vec![(lo, off(y)), (hi, off(y))]);
        let along_y = st_c.map(|[lo, hi]| vec![(off(x), lo), (off(x), hi)]);
        let both = along_x.into_iter().chain(along_y);
        layers.extend(both.map(|ends| curve(bars.name.clone(), ends, bars.style, bars.dash)));
    }
    let point = ChartPoint {
        x: estimate.0,
        y: estimate.1,
        y_se: None,
    };
    layers.push(points("least squares", vec![point], Style::group(0)));
    let [e_inf, st_c] = [Quantity::EInf, Quantity::StC].map(|quantity| in_scripts(quantity.describe().symbol));
    let mut drawn = chart(
        Axis::new(e_inf).between(x.0, x.1),
        Axis::new(st_c).between(y.0, y.1),
        layers,
    );
    drawn.title = Some(title);
    Some(drawn)
}
