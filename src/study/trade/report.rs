//! Writes a trade of speed against accuracy: a page, a figure, and `trade.json`.

use super::{MeasuredMethod, Trade};
use crate::error::Error;
use crate::inference::accuracy::SURE;
use crate::report::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Style};
use crate::report::folder::Files;
use crate::report::json;
use crate::report::markdown::escape::literal;
use crate::report::markdown::page::Page;
use crate::report::markdown::table::ReportTable;
use crate::report::numbers;
use crate::scene::Scene;

/// File of the figure.
const FIGURE: &str = "trade.svg";

/// Every file of a trade.
pub fn files(scene: &Scene, trade: &Trade) -> Result<Files<'static>, Error> {
    let whole = vec![
        ("trade.md".to_owned(), page(scene, trade).into_bytes()),
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
            numbers::significant(method.seconds, 2),
            numbers::optional(method.error(), 2)
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

fn page(scene: &Scene, trade: &Trade) -> String {
    let mut page = Page::titled(&format!("Speed against accuracy: {}", literal(&scene.title)), &[]);
    let reference = &trade.reference;
    page.paragraph(&format!(
        "What each method for the parameters of these {} runs costs, and how far it is off, on {} threads, by wetcor {} \
         with seed {}. Times are the shortest of up to five, from runs in memory to the parameters. Errors are against a \
         long run of the No-U-Turn sampler ({} chains of {} draws, largest R-hat {:.4}), whose own Monte Carlo error \
         is at most {} posterior sds for a mean and {} % for an sd.",
        trade.runs,
        trade.threads,
        trade.wetcor,
        trade.seed,
        reference.chains,
        reference.draws,
        reference.rhat,
        numbers::significant(reference.mcse_mean, 2),
        numbers::significant(100.0 * reference.mcse_sd, 2),
    ));
    page.paragraph(&format!("![time and error of each method]({FIGURE})"));
    methods(&mut page, trade);
    page.text.trim_end().to_owned() + "\n"
}

fn methods(page: &mut Page, trade: &Trade) {
    page.heading("The methods");
    let table = ReportTable::of(&trade.methods)
        .whole()
        .column("method", |method| format!("`{}`", method.name))
        .column("time / s", |method| numbers::significant(method.seconds, 2))
        .column("largest error of a mean / sd", |method| {
            numbers::optional(method.worst_mean, 2)
        })
        .column("of an sd / %", |method| {
            numbers::optional(method.worst_sd.map(|sd| 100.0 * sd), 2)
        })
        .column("error it vouches for", |method| numbers::optional(method.vouched, 2))
        .column("to be trusted", |method| match (&method.failed, method.error()) {
            (Some(why), _) => format!("no: {why}"),
            (None, None) => "does not give every parameter".to_owned(),
            (None, Some(_)) if method.vouched.is_none() => "has no check of its own".to_owned(),
            _ => "yes".to_owned(),
        });
    page.table(&table);
    page.paragraph(
        "`linear` and `sqrt`: the laws by least squares with the delta method. `laplace`: the normal about the posterior's \
         mode. `laplace_psis`: the same with importance weights. `nuts`: the No-U-Turn sampler, the default.",
    );
    page.paragraph(&format!(
        "A method vouches for {SURE} Monte Carlo errors, and for what its own check finds beside. \
         `wetcor fit --accuracy X` takes the first method of the last three that vouches for X, with as many draws as that \
         takes. `trade.json` has the errors of each parameter."
    ));
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
