//! Says what each figure shows: points, laws and axes, as the paper's figs. 2 to 5 have them.

use super::chart::{svg, Axis, Chart, Dash, Layer, Point, Style};
use super::{numbers, Told};
use crate::findings::estimate::Estimate;
use crate::findings::scaling::{reference_dry_speed, Scaling};
use crate::findings::series::SeriesFit;
use crate::physics::impact::DrySpeed;
use crate::physics::inertia::Inertia;
use crate::physics::numbers::stokes;
use crate::physics::{dry, rebound};
use crate::runs::Series;
use crate::scene::Law;
use crate::units::{micrometres, millimetres};

/// A finished figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// file name
    pub name: String,
    /// the picture
    pub svg: String,
}

/// File of the figure of e_inf and St_c against the film ratio.
pub const FILM: &str = "e_inf-st_c-film_ratio.svg";
/// File of the figure of the energy balance against the film ratio.
pub const ENERGY: &str = "energy-film_ratio.svg";

/// File of a particle's figure of restitution against impact speed.
pub fn speed_name(particle: &str) -> String {
    format!("restitution-speed-{particle}.svg")
}

/// File of a particle's figure of restitution against 1/St at one film ratio.
pub fn stokes_name(particle: &str) -> String {
    format!("restitution-stokes-{particle}.svg")
}

/// File of a particle's figure of restitution against 1/St at every film ratio.
pub fn film_ratios_name(particle: &str) -> String {
    format!("restitution-film_ratios-{particle}.svg")
}

/// More points than this are joined into wider bins.
const MOST_POINTS: usize = 2000;
/// Runs whose abscissae agree to this share are one point; wider bins follow where there are too many.
const BIN_WIDTHS: [f64; 4] = [0.02, 0.05, 0.1, 0.3];
/// Points along a curve.
const CURVE: usize = 160;

const RESTITUTION: &str = "restitution e_{n}";
const INVERSE_STOKES: &str = "St^{−1}";

/// Every figure the scene has something to show in.
pub fn all(told: Told) -> Vec<Figure> {
    let mut figures = vec![];
    let mut add = |name: String, charts: Vec<Chart>| {
        let drawn = |chart: &Chart| chart.layers.iter().any(has_points);
        if charts.iter().any(drawn) {
            figures.push(Figure {
                name,
                svg: svg(&charts),
            });
        }
    };
    for particle in 0..told.scene.particles.len() {
        let name = &told.scene.particles[particle].name;
        add(speed_name(name), vec![against_speed(told, particle)]);
        add(stokes_name(name), vec![against_stokes(told, particle)]);
        add(film_ratios_name(name), vec![every_film_ratio(told, particle)]);
    }
    add(FILM.to_owned(), film(told));
    add(ENERGY.to_owned(), energy(told));
    figures
}

fn has_points(layer: &Layer) -> bool {
    matches!(layer, Layer::Points { points, .. } if !points.is_empty())
}

fn points(name: impl Into<String>, points: Vec<Point>, style: Style) -> Layer {
    Layer::Points {
        name: Some(name.into()),
        points,
        style,
    }
}

fn curve(name: impl Into<String>, xy: Vec<(f64, f64)>, style: Style, dash: Dash) -> Layer {
    Layer::Line {
        name: Some(name.into()),
        xy,
        style,
        dash,
    }
}

fn chart(x: Axis, y: Axis, layers: Vec<Layer>) -> Chart {
    Chart {
        title: None,
        x,
        y,
        layers,
    }
}

/// Points of (x, e): runs whose x agree are one mean with its standard error.
fn means(pairs: &mut [(f64, f64)], width: f64) -> Vec<Point> {
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
        points.push(Point { x, y, y_se });
        rest = after;
    }
    points
}

/// The same for several groups at once, with the narrowest bins that keep the figure readable.
fn means_of(mut groups: Vec<Vec<(f64, f64)>>) -> Vec<Vec<Point>> {
    let mut joined = vec![];
    for width in BIN_WIDTHS {
        joined = groups.iter_mut().map(|pairs| means(pairs, width)).collect();
        if joined.iter().map(Vec::len).sum::<usize>() <= MOST_POINTS {
            break;
        }
    }
    joined
}

fn steps(lo: f64, hi: f64) -> impl Iterator<Item = f64> {
    (0..=CURVE).map(move |i| lo + (hi - lo) * i as f64 / CURVE as f64)
}

fn largest(points: &[Vec<Point>]) -> Option<f64> {
    points.iter().flatten().map(|p| p.x).reduce(f64::max)
}

/// The film ratio shown where one must be chosen: a published one, else the one with most rebounds.
fn shown_film_ratio(told: Told, particle: usize) -> Option<f64> {
    let groups: Vec<_> = told
        .runs
        .film_groups
        .iter()
        .filter(|g| g.particle == particle)
        .collect();
    let mut published = told.scene.published.iter().filter(|p| p.particle == particle);
    let wanted = published.find_map(|p| p.film_ratio);
    let near = wanted.and_then(|wanted| {
        let distance = |ratio: f64| (ratio - wanted).abs();
        let nearest = groups
            .iter()
            .min_by(|a, b| distance(a.film_ratio).total_cmp(&distance(b.film_ratio)))?;
        (distance(nearest.film_ratio) <= told.scene.data.film_ratio_gap).then_some(nearest.film_ratio)
    });
    let rebounds = |series: &[Series]| series.iter().map(|s| s.rebounds.len()).sum::<usize>();
    near.or_else(|| {
        let most = groups
            .iter()
            .max_by_key(|g| rebounds(&told.runs.series[g.series.clone()]))?;
        Some(most.film_ratio)
    })
}

/// The series of a particle at a film ratio, with the fit of each.
fn series_at(told: Told<'_>, particle: usize, ratio: Option<f64>) -> Vec<(&Series, &SeriesFit)> {
    let both = told.runs.series.iter().zip(&told.findings.series);
    both.filter(|(s, _)| s.particle == particle && ratio.is_none_or(|r| s.film_ratio == r))
        .collect()
}

fn series_name(told: Told, series: &Series) -> String {
    let liquid = &told.scene.liquids[series.liquid].name;
    let diameter = numbers::short(millimetres(series.diameter));
    format!("{liquid}, D = {diameter} mm, δ = {:.0} µm", micrometres(series.film))
}

fn against_speed(told: Told, particle: usize) -> Chart {
    let chosen = shown_film_ratio(told, particle);
    let series = series_at(told, particle, chosen);
    let runs = told.runs;
    let mut groups: Vec<Vec<(f64, f64)>> = series
        .iter()
        .map(|(s, _)| {
            pairs(
                &runs.impact_speed[s.rebounds.clone()],
                &runs.restitution[s.rebounds.clone()],
            )
        })
        .collect();
    let dry_runs: Vec<(f64, f64)> = runs
        .dry
        .iter()
        .filter(|group| group.particle == particle)
        .flat_map(|g| {
            pairs(
                &runs.impact_speed[g.rebounds.clone()],
                &runs.restitution[g.rebounds.clone()],
            )
        })
        .collect();
    groups.push(dry_runs);
    let mut joined = means_of(groups);
    let fastest = largest(&joined).unwrap_or(1.0);
    let dry_points = joined.pop().unwrap_or_default();
    let mut layers = vec![];
    let name = &told.scene.particles[particle].name;
    let dry_k = told
        .findings
        .dry
        .iter()
        .find(|d| d.particle == *name)
        .and_then(|d| d.dry_k.value);
    if !dry_points.is_empty() {
        layers.push(points("dry", dry_points, Style::group(0)));
    }
    if let Some(k) = dry_k {
        let law = steps(0.0, fastest).map(|v| (v, dry::restitution(k, v))).collect();
        layers.push(curve("dry, 1 − k v^{1/5}", law, Style::group(0), Dash::Dashed));
    }
    for (group, ((s, fit), points_of)) in series.iter().zip(joined).enumerate() {
        let style = Style::group(group + 1);
        let label = series_name(told, s);
        if let Some(law) = series_curve(told, fit, dry_k, fastest) {
            layers.push(curve(label.clone(), law, style, Dash::Solid));
        }
        if !points_of.is_empty() {
            layers.push(points(label, points_of, style));
        }
    }
    let mut drawn = chart(
        Axis::new("impact speed v / (m s^{−1})").between(0.0, 1.05 * fastest),
        Axis::new(RESTITUTION).between(0.0, 1.0),
        layers,
    );
    drawn.title = chosen.map(|ratio| format!("{name}, δ/D = {}", numbers::short(ratio)));
    widen_to_data(&mut drawn);
    drawn
}

/// Keeps restitutions above one in the picture.
fn widen_to_data(chart: &mut Chart) {
    let highest = chart.layers.iter().filter_map(|layer| match layer {
        Layer::Points { points, .. } => points.iter().map(|p| p.y + p.y_se.unwrap_or(0.0)).reduce(f64::max),
        _ => None,
    });
    if highest.reduce(f64::max).is_some_and(|y| y > 0.99) {
        chart.y = chart.y.clone().between(0.0, 1.15);
    }
}

fn pairs(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    x.iter().copied().zip(y.iter().copied()).collect()
}

/// √(α + β/v) from its threshold on; `None` where the series has no usable law.
fn series_curve(told: Told, fit: &SeriesFit, dry_k: Option<f64>, fastest: f64) -> Option<Vec<(f64, f64)>> {
    if !fit.verdict.passed {
        return None;
    }
    let (alpha, beta) = (fit.alpha.value?, fit.beta.value?);
    let threshold = rebound::threshold_speed(alpha, beta)?;
    let own = dry_k.filter(|_| told.scene.model.dry_speed == DrySpeed::Impact);
    let reference = reference_dry_speed(told.scene);
    let offset = |v: f64| {
        own.map_or(0.0, |k| {
            dry::restitution(k, v).powi(2) - dry::restitution(k, reference).powi(2)
        })
    };
    // steep at its threshold: steps in the root of the distance from it
    let points = steps(0.0, 1.0).map(|u| {
        let v = threshold + (fastest - threshold) * u * u;
        (v, (alpha + beta / v + offset(v)).max(0.0).sqrt())
    });
    (threshold < fastest).then(|| points.collect())
}

/// (1/St, e) of the rebounds of some series.
fn inverse_stokes(told: Told, series: &Series) -> Vec<(f64, f64)> {
    let density = told.scene.particles[series.particle].density;
    let viscosity = told.scene.liquids[series.liquid].viscosity;
    let runs = told.runs;
    let of = |run: usize| {
        let st = stokes(density, runs.diameter[run], runs.impact_speed[run], viscosity);
        (1.0 / st, runs.restitution[run])
    };
    series.rebounds.clone().map(of).collect()
}

fn scaling_of<'a>(told: Told<'a>, particle: usize, ratio: Option<f64>, law: Law) -> Option<&'a Scaling> {
    let name = &told.scene.particles[particle].name;
    told.findings
        .scaling
        .iter()
        .find(|row| row.particle == *name && row.film_ratio == ratio && row.law == law.name())
}

/// Both laws of 1/St, from 0 to where they vanish or the picture ends.
fn laws(told: Told, particle: usize, ratio: Option<f64>, end: f64) -> Vec<Layer> {
    let mut layers = vec![];
    // drawn whatever the verdict: a law that does not hold for all is best seen beside the runs
    let values = |law: Law| {
        let row = scaling_of(told, particle, ratio, law)?;
        Some((row.e_inf.value?, row.st_c.value?))
    };
    if let Some((e_inf, st_c)) = values(Law::Linear) {
        let last = end.min(1.0 / st_c);
        let line = [0.0, last].map(|x| (x, e_inf * (1.0 - st_c * x))).to_vec();
        layers.push(curve("linear law", line, Style::group(0), Dash::Dashed));
    }
    if let Some((e_inf, st_c)) = values(Law::Sqrt) {
        let last = 0.5 / st_c;
        let root = |u: f64| {
            let x = last * (1.0 - u * u);
            (x, e_inf * (1.0 - 2.0 * st_c * x).max(0.0).sqrt())
        };
        let law = steps(0.0, 1.0).map(root).filter(|(x, _)| *x <= end).collect();
        layers.push(curve("square-root law", law, Style::group(0), Dash::Solid));
    }
    layers
}

fn against_stokes(told: Told, particle: usize) -> Chart {
    let chosen = shown_film_ratio(told, particle);
    let series = series_at(told, particle, chosen);
    let groups = series.iter().map(|(s, _)| inverse_stokes(told, s)).collect();
    let joined = means_of(groups);
    let end = 1.1 * largest(&joined).unwrap_or(0.1);
    let mut layers = laws(told, particle, chosen, end);
    for (group, ((s, _), points_of)) in series.iter().zip(joined).enumerate() {
        if !points_of.is_empty() {
            layers.push(points(series_name(told, s), points_of, Style::group(group + 1)));
        }
    }
    let name = &told.scene.particles[particle].name;
    let mut drawn = chart(
        Axis::new(INVERSE_STOKES).between(0.0, end),
        Axis::new(RESTITUTION).between(0.0, 1.0),
        layers,
    );
    drawn.title = chosen.map(|ratio| format!("{name}, δ/D = {}", numbers::short(ratio)));
    widen_to_data(&mut drawn);
    drawn
}

fn every_film_ratio(told: Told, particle: usize) -> Chart {
    let groups: Vec<_> = told
        .runs
        .film_groups
        .iter()
        .filter(|g| g.particle == particle)
        .collect();
    // one layer a film ratio, but means only inside a series
    let series: Vec<(usize, &Series)> = groups
        .iter()
        .enumerate()
        .flat_map(|(index, g)| told.runs.series[g.series.clone()].iter().map(move |s| (index, s)))
        .collect();
    let joined = means_of(series.iter().map(|(_, s)| inverse_stokes(told, s)).collect());
    let end = 1.1 * largest(&joined).unwrap_or(0.1);
    let mut layers = laws(told, particle, None, end);
    let mut by_ratio: Vec<Vec<Point>> = vec![vec![]; groups.len()];
    for ((index, _), points_of) in series.iter().zip(joined) {
        by_ratio[*index].extend(points_of);
    }
    for (index, (group, points_of)) in groups.iter().zip(by_ratio).enumerate() {
        if !points_of.is_empty() {
            let label = format!("δ/D = {}", numbers::short(group.film_ratio));
            layers.push(points(label, points_of, Style::group(index + 1)));
        }
    }
    let mut drawn = chart(
        Axis::new(INVERSE_STOKES).between(0.0, end),
        Axis::new(RESTITUTION).between(0.0, 1.0),
        layers,
    );
    drawn.title = Some(format!("{}, every film ratio", told.scene.particles[particle].name));
    widen_to_data(&mut drawn);
    drawn
}

fn estimate_point(film_ratio: f64, estimate: &Estimate) -> Option<Point> {
    Some(Point {
        x: film_ratio,
        y: estimate.value?,
        y_se: estimate.se,
    })
}

/// e_inf and St_c against the film ratio: a colour a particle, hollow for the linear law.
fn film(told: Told) -> Vec<Chart> {
    let panel = |label: &str, of: fn(&Scaling) -> &Estimate| {
        let mut layers = vec![];
        for (index, particle) in told.scene.particles.iter().enumerate() {
            for (law, words) in [(Law::Sqrt, "square root"), (Law::Linear, "linear")] {
                let rows = told.findings.scaling.iter();
                let mine = rows.filter(|r| r.particle == particle.name && r.law == law.name() && r.verdict.passed);
                let points_of: Vec<Point> = mine.filter_map(|r| estimate_point(r.film_ratio?, of(r))).collect();
                let style = Style {
                    group: index + 1,
                    open: law == Law::Linear,
                };
                if !points_of.is_empty() {
                    layers.push(points(format!("{}, {words}", particle.name), points_of, style));
                }
            }
        }
        chart(Axis::new("film ratio δ/D"), Axis::new(label), layers)
    };
    vec![panel("e_{inf}", |row| &row.e_inf), panel("St_{c}", |row| &row.st_c)]
}

/// The inertial loss with both predictions, and St_c e_inf², against the film ratio, by the square-root law.
fn energy(told: Told) -> Vec<Chart> {
    let rows = || told.findings.energy.iter().filter(|row| row.law == Law::Sqrt.name());
    let end = rows().map(|row| row.film_ratio).reduce(f64::max).unwrap_or(0.1) * 1.08;
    let of_particles = |of: fn(&crate::findings::energy::Energy) -> &Estimate| -> Vec<Layer> {
        let names = told.scene.particles.iter().enumerate();
        names
            .filter_map(|(index, particle)| {
                let mine = rows().filter(|row| row.particle == particle.name);
                let points_of: Vec<Point> = mine.filter_map(|row| estimate_point(row.film_ratio, of(row))).collect();
                let style = Style::group(index + 1);
                (!points_of.is_empty()).then(|| points(particle.name.clone(), points_of, style))
            })
            .collect()
    };
    let mut loss = of_particles(|row| &row.loss_over_density_ratio);
    if !loss.is_empty() {
        for (form, words, dash) in [
            (Inertia::Stepwise, "stepwise, eq. Eint2", Dash::Solid),
            (Inertia::Cap, "cap, eq. Eint1", Dash::Dashed),
        ] {
            let last = end.min(form.valid_to());
            let law = steps(0.0, last).map(|x| (x, form.shape(x, 1.0))).collect();
            loss.push(curve(words, law, Style::group(0), dash));
        }
    }
    if let Some((form, c, scale)) = fitted_form(told).filter(|_| !loss.is_empty()) {
        let law = steps(0.0, end.min(form.valid_to()))
            .map(|x| (x, c * form.shape(x, scale)))
            .collect();
        loss.push(curve(
            format!("fitted, {}", form.name()),
            law,
            Style::group(0),
            Dash::Dotted,
        ));
    }
    vec![
        chart(
            Axis::new("film ratio δ/D"),
            Axis::new("(e_{dry}^{2} − e_{inf}^{2})/ρ̃"),
            loss,
        ),
        chart(
            Axis::new("film ratio δ/D"),
            Axis::new("St_{c} e_{inf}^{2}"),
            of_particles(|row| &row.st_c_e_inf2),
        ),
    ]
}

/// The inertial form of the energy balance with its fitted C and δ̃0, where it may be quoted.
fn fitted_form(told: Told) -> Option<(Inertia, f64, f64)> {
    let balance = told
        .findings
        .energy_balance
        .as_ref()
        .filter(|balance| balance.verdict.passed)?;
    let form = Inertia::ALL.into_iter().find(|form| form.name() == balance.inertia)?;
    let value = |name: &str| {
        let parameter = balance.parameters.iter().find(|parameter| parameter.name == name)?;
        parameter.estimate.value
    };
    Some((form, value("inertial_prefactor")?, value("film_scale").unwrap_or(1.0)))
}
