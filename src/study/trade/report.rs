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
    let whole = vec![
        ("trade.md".to_owned(), page(scene, trade)?.into_bytes()),
        ("trade.json".to_owned(), json::text(trade)?.into_bytes()),
        (FIGURE.to_owned(), figure(trade).into_bytes()),
    ];
    Ok(Files {
        whole,
        ..Files::default()
    })
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
        let point = ChartPoint {
            x: method.seconds.log10(),
            y: mean.max(sd).log10(),
            y_se: None,
        };
        (lo, hi) = (lo.min(point.x), hi.max(point.x));
        let style = Style::group(group);
        layers.push(Layer::Points {
            name: Some(method.name.to_owned()),
            points: vec![point],
            style: if is_whole(method) { style } else { style.open() },
        });
    }
    let floor = (SURE * trade.reference.mcse_mean.max(trade.reference.mcse_sd)).log10();
    layers.push(Layer::Line {
        name: Some("the long run's own error".to_owned()),
        xy: vec![(lo.floor(), floor), (hi.ceil(), floor)],
        style: Style::group(0),
        dash: Dash::Dashed,
    });
    svg(&[Chart {
        title: None,
        x: Axis::new("time / s").of_decades(),
        y: Axis::new("largest error of a mean / sd, or of an sd").of_decades(),
        layers,
    }])
}
