//! Writes a trade of speed against accuracy: a page, a figure, and `trade.json`.

use minijinja::context;

use super::{MeasuredMethod, Trade};
use crate::error::Error;
use crate::inference::accuracy::SURE;
use crate::report::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Style};
use crate::report::folder::Files;
use crate::report::json;
use crate::report::template::{self, serialized, with};
use crate::rounding;
use crate::scene::Scene;

/// File of the figure.
const FIGURE: &str = "trade.svg";

/// Every file of a trade.
pub fn files(scene: &Scene, trade: &Trade) -> Result<Files<'static>, Error> {
    Ok(Files::of([
        ("trade.md".to_owned(), page(scene, trade)?),
        ("trade.json".to_owned(), json::text(trade)?),
        (FIGURE.to_owned(), figure(trade)),
    ]))
}

/// The methods that may be trusted, a line each.
pub fn summary(trade: &Trade) -> String {
    let line = |method: &MeasuredMethod| {
        format!(
            "{}: {} s, error {}\n",
            method.name,
            rounding::significant(method.seconds, 2),
            rounding::optional(method.error(), 2)
        )
    };
    trade
        .methods
        .iter()
        .filter(|method| is_whole(method))
        .map(line)
        .collect()
}

/// Whether a method gives every parameter, and may be trusted.
fn is_whole(method: &MeasuredMethod) -> bool {
    method.failed.is_none() && method.error().is_some()
}

fn page(scene: &Scene, trade: &Trade) -> Result<String, Error> {
    let method = |own: &MeasuredMethod| with(own, context! { error => own.error() });
    let values = context! {
        title => scene.title.as_str(),
        trade => serialized(trade),
        methods => trade.methods.iter().map(method).collect::<Vec<_>>(),
        sure => SURE,
    };
    template::page("trade.md", &values, &[])
}

fn figure(trade: &Trade) -> String {
    let mut layers = vec![];
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for (group, method) in trade.methods.iter().enumerate() {
        let (Some(mean), Some(sd)) = (method.worst_mean, method.worst_sd) else {
            continue;
        };
        let point = ChartPoint::at(method.seconds.log10(), mean.max(sd).log10());
        (lo, hi) = (lo.min(point.x), hi.max(point.x));
        let style = Style::group(group);
        let style = if is_whole(method) { style } else { style.open() };
        layers.push(Layer::points(Some(method.name.to_owned()), vec![point], style));
    }
    let floor = (SURE * trade.reference.mcse_mean.max(trade.reference.mcse_sd)).log10();
    let across = vec![(lo.floor(), floor), (hi.ceil(), floor)];
    layers.push(Layer::curve(
        "the long run's own error",
        across,
        Style::group(0),
        Dash::Dashed,
    ));
    let x = Axis::new("time / s").of_decades();
    let y = Axis::new("largest error of a mean / sd, or of an sd").of_decades();
    svg(&[Chart::new(x, y, layers)])
}
