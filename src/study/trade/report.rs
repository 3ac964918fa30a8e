//! Writes a trade of speed against accuracy: a page, a figure, and `trade.json`.

use super::results::{MarginalError, Rung, Trade};
use crate::error::Error;
use crate::inference::accuracy::SURE;
use crate::inference::sampling::Method;
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

/// The methods that no other beats, a line each.
pub fn summary(trade: &Trade) -> String {
    let line = |rung: &Rung| {
        format!(
            "{}: {} s, error {}\n",
            rung.name,
            numbers::significant(rung.seconds, 2),
            numbers::optional(rung.error(), 2)
        )
    };
    let best = trade.rungs.iter().filter(|rung| stands(rung));
    best.map(line).collect()
}

/// Whether a method answers everything, is reliable, and is beaten by none.
fn stands(rung: &Rung) -> bool {
    rung.dominated_by.is_none() && rung.failed.is_none() && rung.error().is_some()
}

fn page(scene: &Scene, trade: &Trade) -> String {
    let mut page = Page::titled(&format!("Speed against accuracy: {}", literal(&scene.title)), &[]);
    let reference = &trade.reference;
    page.paragraph(&format!(
        "What each way to the posterior of these {} runs costs, and how far it is off, on {} threads, by wetcor {} with \
         seed {}. Times are the shortest of up to five, from runs in memory to the parameters. Errors are against a long \
         run (`{}`, {} chains of {} draws, {} s, largest R-hat {:.4}), whose own Monte Carlo error is at most {} posterior \
         sds for a mean and {} % for an sd. The error of a way is the largest of any mean, in posterior sds, and of any \
         sd, relative, and at least {SURE}/√ESS, what chance leaves to its draws.",
        trade.runs,
        trade.threads,
        trade.wetcor,
        trade.seed,
        reference.method,
        reference.chains,
        reference.draws,
        numbers::significant(reference.seconds, 2),
        reference.rhat,
        numbers::significant(reference.mcse_mean, 2),
        numbers::significant(100.0 * reference.mcse_sd, 2),
    ));
    page.paragraph(&format!("![time and error of each way]({FIGURE})"));
    methods(&mut page, trade);
    parameters(&mut page, trade);
    linear(&mut page, trade);
    page.text.trim_end().to_owned() + "\n"
}

fn methods(page: &mut Page, trade: &Trade) {
    page.heading("The ways");
    let table = ReportTable::of(&trade.rungs)
        .whole()
        .column("way", |rung| format!("`{}`", rung.name))
        .column("what it is", |rung| what(&rung.name))
        .column("nodes", |rung| rung.nodes)
        .column("time / s", |rung| numbers::significant(rung.seconds, 2))
        .column("largest error of a mean / sd", |rung| {
            numbers::optional(rung.worst_mean, 2)
        })
        .column("of an sd / %", |rung| {
            numbers::optional(rung.worst_sd.map(|sd| 100.0 * sd), 2)
        })
        .column("error it vouches for", |rung| numbers::optional(rung.vouched, 2))
        .column("effective draws", |rung| rung.effective.map(|n| format!("{n:.0}")))
        .column("a second", |rung| rung.effective_per_second.map(|n| format!("{n:.0}")))
        .column("beside the others", verdict);
    page.table(&table);
    page.paragraph(
        "Nodes stand for the wet runs; a block of runs with no more settings than nodes keeps them all. A way is beaten \
         where another has less than 0.8 of its time or of its error, and not more than 1.25 of the other; ways that made \
         the same draws do not beat each other. `wetcor fit --accuracy X` takes the cheapest way that can vouch for X.",
    );
}

fn what(name: &str) -> String {
    let is = |method: Method| name == method.name();
    match name {
        "linear" => "linear law by least squares, delta method".to_owned(),
        "sqrt" => "square-root law by least squares, delta method".to_owned(),
        _ if is(Method::Laplace) => "normal about the mode".to_owned(),
        _ if is(Method::LaplacePsis) => "the same, resampled by importance weights".to_owned(),
        _ if is(Method::NutsExact) => "trajectories on every row".to_owned(),
        _ if is(Method::NutsCompressed) => "trajectories on nodes to the default bound".to_owned(),
        _ => match name.split_once('/') {
            Some((_, nodes)) => format!("trajectories on {nodes} nodes a block"),
            None => String::new(),
        },
    }
}

fn verdict(rung: &Rung) -> String {
    match (&rung.failed, &rung.dominated_by, rung.error()) {
        (Some(why), _, _) => format!("not to be trusted: {why}"),
        (_, Some(other), _) => format!("beaten by `{other}`"),
        (_, _, None) => "does not give every parameter".to_owned(),
        _ => "not beaten".to_owned(),
    }
}

fn parameters(page: &mut Page, trade: &Trade) {
    page.heading("Each parameter");
    page.paragraph("Errors of mean, 5 % point and 95 % point in posterior sds, of the sd in per cent.");
    let cell = |miss: &MarginalError| {
        format!(
            "{}, {}, {}, {} %",
            signed(miss.mean),
            signed(miss.q05),
            signed(miss.q95),
            signed(100.0 * miss.sd)
        )
    };
    let mut table = ReportTable::of(&trade.rungs)
        .whole()
        .column("way", |rung| format!("`{}`", rung.name));
    for (place, parameter) in trade.reference.parameters.iter().enumerate() {
        table = table.column(&parameter.name, |rung| rung.errors[place].as_ref().map(cell));
    }
    page.table(&table);
}

/// Two digits, with a sign.
fn signed(x: f64) -> String {
    let text = numbers::significant(x.abs(), 2);
    if x < 0.0 {
        format!("−{text}")
    } else {
        text
    }
}

fn linear(page: &mut Page, trade: &Trade) {
    if trade.linear_bias.is_empty() {
        return;
    }
    page.heading("What the linear law gets wrong on this design");
    let cell = |bias: f64, in_se: Option<f64>| match in_se {
        Some(in_se) => format!("{} ({} se)", signed(bias), signed(in_se)),
        None => signed(bias),
    };
    let table = ReportTable::of(&trade.linear_bias)
        .whole()
        .column("particle", |bias| &bias.particle)
        .column("film ratio", |bias| {
            bias.film_ratio.map_or("all".to_owned(), |ratio| format!("{ratio:.3}"))
        })
        .column("bias of e_inf", |bias| cell(bias.e_inf, bias.e_inf_se))
        .column("bias of St_c", |bias| cell(bias.st_c, bias.st_c_se));
    page.table(&table);
    page.paragraph(
        "Fitted to the square-root law at the same runs without noise, minus that law. No number of runs mends it, and no \
         resampling shows it.",
    );
}

fn figure(trade: &Trade) -> String {
    let mut layers = vec![];
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut names: Vec<&str> = vec![];
    for rung in &trade.rungs {
        // trajectories on different numbers of nodes share a name: their points say the rest
        let name = rung.name.split_once('/').map_or(rung.name.as_str(), |_| "few nodes");
        let group = names.iter().position(|other| *other == name).unwrap_or(names.len());
        if group == names.len() {
            names.push(name);
        }
        let (Some(mean), Some(sd)) = (rung.worst_mean, rung.worst_sd) else {
            continue;
        };
        let chance = rung.effective.map_or(0.0, |effective| SURE / effective.sqrt());
        let point = ChartPoint {
            x: rung.seconds.log10(),
            y: mean.max(sd).max(chance).log10(),
            y_se: None,
        };
        (lo, hi) = (lo.min(point.x), hi.max(point.x));
        let style = Style::group(group);
        layers.push(Layer::Points {
            name: Some(name.to_owned()),
            points: vec![point],
            style: if stands(rung) { style } else { style.open() },
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
