//! Writes the report of tracked recordings: a page, a figure each, and `tracking.json`.

use std::collections::BTreeSet;

use minijinja::{context, Value};
use serde_json::json;

use super::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::folder::{Files, TRACKING_SCHEMA};
use super::json;
use super::template::{self, with};
use crate::error::Error;
use crate::findings::range::range;
use crate::recordings::{
    Campaign, FreeFlight, ImageScale, Impact, Jump, Outcome, Recording, Refusal, ScaleSource, Shown, Track, Tracked,
    APART_FROM_OTHERS_SINCE, APART_SINCE, FAR, GRAVITY, OFF,
};
use crate::rounding::significant;
use crate::scene::DRY;
use crate::units::{micrometres, millimetres, milliseconds, pixels_per_millimetre};

/// Points of a kind that a figure shows; of more, evenly spaced ones.
const MOST_POINTS: usize = 1_000;

/// The same of positions that lie on a parabola: few enough that it is seen between them.
const MOST_ON_PARABOLAS: usize = 120;

/// Every file of the report; `title` is what the list is called.
pub fn files(title: &str, campaign: &Campaign) -> Result<Files<'static>, Error> {
    let mut figures = vec![];
    for outcome in &campaign.outcomes {
        let figure = match (&outcome.tracked, &outcome.shown) {
            (Ok(tracked), _) => figure(
                &tracked.track,
                &tracked.flights,
                "height over the contact / mm",
                millimetres,
            ),
            (Err(_), Some(shown)) if shown.in_pixels => figure(&shown.track, &[], "height / px", |height| height),
            (Err(_), Some(shown)) => figure(&shown.track, &[], "height / mm", millimetres),
            (Err(_), None) => continue,
        };
        figures.push((figure_name(&outcome.recording), figure));
    }
    let names: Vec<&str> = figures.iter().map(|(name, _)| name.as_str()).collect();
    let (page, json) = (page(title, campaign, &names)?, summary_json(title, campaign, &names)?);
    let figures = figures.into_iter().map(|(name, svg)| (format!("figures/{name}"), svg));
    let texts = [("report.md".to_owned(), page), ("tracking.json".to_owned(), json)];
    Ok(Files::of(texts.into_iter().chain(figures)))
}

/// By the line of the list, since names may hold what no file is called.
fn figure_name(recording: &Recording) -> String {
    format!("line_{}.svg", recording.line)
}

/// The recordings that gave runs.
fn tracked(campaign: &Campaign) -> impl Iterator<Item = (&Recording, &Tracked)> {
    let outcomes = campaign.outcomes.iter();
    outcomes.filter_map(|outcome| Some((&outcome.recording, outcome.tracked.as_ref().ok()?)))
}

/// Why the others gave none.
fn refused(campaign: &Campaign) -> impl Iterator<Item = &Refusal> {
    campaign
        .outcomes
        .iter()
        .filter_map(|outcome| outcome.tracked.as_ref().err())
}

/// The impacts, each with the recording it is of.
fn rows(campaign: &Campaign) -> impl Iterator<Item = (&Recording, &Impact)> {
    tracked(campaign).flat_map(|(recording, tracked)| tracked.impacts.iter().map(move |impact| (recording, impact)))
}

/// Those that are used.
fn used(campaign: &Campaign) -> impl Iterator<Item = (&Recording, &Impact)> {
    rows(campaign).filter(|(_, impact)| impact.verdict.is_none())
}

/// How many recordings gave runs, what became of the others, and what the gravity says of scales and frame rates, a line each.
pub fn summary(campaign: &Campaign) -> Result<String, Error> {
    let gravity = campaign.gravity;
    let runs = used(campaign).count();
    // how wide the spheres then are shows a wrong frame rate to whoever saw the images
    let by_gravity = tracked(campaign).filter(|(_, tracked)| tracked.scale.source == ScaleSource::Gravity);
    let widths = range(by_gravity.map(|(recording, tracked)| tracked.scale.value * recording.diameter));
    let measured = gravity.measured.map(|g| {
        let off = format!("{:+.2}", 100.0 * (g.value / GRAVITY - 1.0));
        context! { value => g.value, se => g.se, flights => g.flights, off }
    });
    let values = context! {
        recordings => campaign.outcomes.len(),
        runs,
        stuck => used(campaign).filter(|(_, impact)| impact.stuck).count(),
        left_out => rows(campaign).count() - runs + refused(campaign).count(),
        mistakes => refused(campaign).filter(|refusal| refusal.is_mistake()).count(),
        gravity => measured,
        scale => gravity.scale.map(|of| of.map(pixels_per_millimetre)),
        widths => widths.map(|ends| ends.map(|width| significant(width, 2))),
        shared_error => gravity.shared_error(),
        any_tracked => tracked(campaign).next().is_some(),
        free_fall => GRAVITY,
    };
    template::plain("tracking.txt", &values)
}

/// Whether every recording is one that was meant, and any gives a run that is used.
pub fn is_usable(campaign: &Campaign) -> bool {
    !refused(campaign).any(Refusal::is_mistake) && used(campaign).next().is_some()
}

/// What ± includes besides the scatter of positions: of each recording which frames are repeated or missing, and how far the
/// contacts of its impacts lie apart.
pub fn doubts(campaign: &Campaign) -> Vec<String> {
    let mut lines = vec![];
    for outcome in &campaign.outcomes {
        let (Ok(tracked), Some(shown)) = (&outcome.tracked, &outcome.shown) else {
            continue;
        };
        let Recording { line, run, .. } = &outcome.recording;
        if let Some(frames) = uneven_frames(&outcome.recording, shown, &tracked.jumps) {
            lines.push(format!(
                "line {line}, {run}: {frames}; its times are mended, and ± holds what they may do at the contact and to the \
                 frame rate"
            ));
        }
        let used = tracked.impacts.iter().filter(|impact| impact.verdict.is_none());
        for gap in used.clone().filter_map(|impact| impact.apart_from_others) {
            lines.push(format!(
                "line {line}, {run}: its flights meet {} mm from the height at which the other recordings meet the plate: \
                 {APART_FROM_OTHERS_SINCE}; ± includes it",
                significant(millimetres(gap), 2)
            ));
        }
        for gap in used.filter_map(|impact| impact.apart) {
            lines.push(format!(
                "line {line}, {run}: the flights before and after an impact meet {} mm from the height of the other contacts or of \
                 the sphere at rest: {APART_SINCE}; ± includes it",
                significant(millimetres(gap), 2)
            ));
        }
    }
    lines
}

/// Which frames are repeated, and before which some are missing; nothing where none are.
fn uneven_frames(recording: &Recording, shown: &Shown, jumps: &[Jump]) -> Option<String> {
    let name = |jump: &Jump| match (shown.counted_from, recording.frame_rate) {
        (Some(first), Some(rate)) => format!("{}", (jump.time * rate).round() + f64::from(first)),
        _ => format!("{} ms", significant(milliseconds(jump.time), 5)),
    };
    let told = |is_missing: bool, verb: &str, place: &str| {
        let of = jumps.iter().filter(|jump| (jump.missing > 0) == is_missing);
        let count: i32 = of.clone().map(|jump| jump.missing.abs()).sum();
        let noun = if count == 1 { "frame is" } else { "frames are" };
        let names: Vec<String> = of.map(&name).collect();
        (count > 0).then(|| format!("{count} {noun} {verb} ({place} {})", names.join(", ")))
    };
    let both = [told(false, "repeated", "at"), told(true, "missing", "before")];
    let both: Vec<String> = both.into_iter().flatten().collect();
    (!both.is_empty()).then(|| both.join(" and "))
}

/// Each recording or impact that is left out, with its reason.
pub fn left_out(campaign: &Campaign) -> Vec<String> {
    let mut lines = vec![];
    for Outcome { recording, tracked, .. } in &campaign.outcomes {
        let reasons: Vec<&str> = match tracked {
            Err(refusal) => vec![refusal.words()],
            Ok(tracked) => tracked
                .impacts
                .iter()
                .filter_map(|impact| impact.verdict.as_deref())
                .collect(),
        };
        let line = |reason| format!("line {}, {}: {reason}", recording.line, recording.run);
        lines.extend(reasons.into_iter().map(line));
    }
    lines
}

fn page(title: &str, campaign: &Campaign, figures: &[&str]) -> Result<String, Error> {
    let mut looks: Vec<String> = campaign.notices.iter().map(|notice| notice.text.clone()).collect();
    looks.extend(doubts(campaign));
    let impacts = rows(campaign).map(|(recording, impact)| {
        let Recording { run, particle, .. } = recording;
        with(impact, context! { run, particle, liquid => &recording.liquid })
    });
    let scales = tracked(campaign).map(|(recording, tracked)| {
        let own = tracked.flights.iter().map(|flight| flight.own_gravity);
        let best = own.min_by(|[_, a], [_, b]| a.total_cmp(b));
        with(
            &tracked.scale,
            context! { run => &recording.run, gravity => best.map(|own| own.to_vec()) },
        )
    });
    let known = drags(campaign, |recording| recording.density.is_some());
    let values = context! {
        title,
        summary => summary(campaign)?.lines().map(str::to_owned).collect::<Vec<_>>(),
        looks,
        impacts => impacts.collect::<Vec<_>>(),
        dry => DRY,
        left_out => left_out(campaign),
        gravity => GRAVITY,
        off => OFF,
        far => FAR,
        scales => scales.collect::<Vec<_>>(),
        drags => known.map(|ends| ends.to_vec()),
        drag_left => drag_left(campaign),
        recordings => campaign.outcomes.iter().filter_map(captioned).collect::<Vec<_>>(),
    };
    template::page("tracking.md", &values, figures)
}

/// What the caption of a recording's figure says; `None` of one that was not seen.
fn captioned(outcome: &Outcome) -> Option<Value> {
    let shown = outcome.shown.as_ref()?;
    let of = outcome.tracked.as_ref();
    let tracked = of.ok();
    let track = tracked.map_or(&shown.track, |tracked| &tracked.track);
    let flights = || tracked.into_iter().flat_map(|tracked| &tracked.flights);
    Some(context! {
        figure => figure_name(&outcome.recording),
        run => outcome.recording.run.as_str(),
        object => shown.object.as_deref(),
        positions => track.times.len(),
        frames => shown.frames,
        refused => of.err().map(Refusal::words),
        fitted => flights().map(|flight| flight.frames.len()).sum::<usize>(),
        flights => flights().count(),
        noise => tracked.map(|tracked| tracked.noise),
        rest => tracked.and_then(|tracked| tracked.rest),
    })
}

/// What is to be said of used runs whose drag is not taken off; nothing where it is, or is less than matters.
pub fn drag_left(campaign: &Campaign) -> Option<String> {
    /// of the weight: e is then off by a thousandth
    const MATTERS: f64 = 0.003;
    let most = drags(campaign, |recording| recording.density.is_none()).map_or(0.0, |[_, most]| most);
    let todo = "the drag of the air is not taken off, since the list has no density_kg_m3";
    match most {
        ..=MATTERS => None,
        ..1.0 => Some(format!(
            "{todo}: of a sphere of {LIGHT} kg/m³ it is up to {} % of the weight, and makes e too small by about a third of that \
             share",
            significant(100.0 * most, 2)
        )),
        _ => Some(format!(
            "{todo}; no sphere of {LIGHT} kg/m³ can fall so fast: frame rate or scale is wrong, unless it is much denser"
        )),
    }
}

/// The least and the largest drag at the impact speed over the weight, of the runs of these recordings that are used.
fn drags(campaign: &Campaign, takes: impl Fn(&Recording) -> bool) -> Option<[f64; 2]> {
    let drag = |(recording, impact): (&Recording, &Impact)| {
        let sphere = recording.in_air(recording.density.unwrap_or(LIGHT));
        sphere.deceleration(impact.speeds.impact_speed) / GRAVITY
    };
    range(used(campaign).filter(|(recording, _)| takes(recording)).map(drag))
}

/// Density of a light sphere in kg/m³, where the list has none.
const LIGHT: f64 = 1000.0;

/// Heights, of a recording that gives runs with the parabolas and what these leave.
fn figure(track: &Track, flights: &[FreeFlight], label: &str, unit: fn(f64) -> f64) -> String {
    let at = |frame: &usize| (since_start(track, track.times[*frame]), unit(track.heights[*frame]));
    let fitted: Vec<usize> = flights.iter().flat_map(|flight| flight.frames.clone()).collect();
    let is_fitted: BTreeSet<usize> = fitted.iter().copied().collect();
    let others = (0..track.times.len()).filter(|frame| !is_fitted.contains(frame));
    let others: Vec<usize> = others.collect();
    let (mut heights, mut residuals) = (vec![], vec![]);
    if !flights.is_empty() {
        heights.push(points(Some("fitted"), 0, thinned(&fitted, MOST_ON_PARABOLAS).map(at)));
    }
    if flights.is_empty() || !others.is_empty() {
        heights.push(points(Some("not fitted"), 2, thinned(&others, MOST_POINTS).map(at)));
    }
    for flight in flights {
        heights.push(parabola(track, flight));
        let frames = flight.frames.iter().zip(&flight.residuals);
        let left = frames.map(|(frame, left)| (since_start(track, track.times[*frame]), micrometres(*left)));
        let left: Vec<(f64, f64)> = left.collect();
        residuals.push(points(None, 0, thinned(&left, MOST_POINTS).copied()));
    }
    let mut charts = vec![over_time(label, heights)];
    if !flights.is_empty() {
        charts.push(over_time("residual / µm", residuals));
    }
    svg(&charts)
}

/// Milliseconds since a track begins.
fn since_start(track: &Track, time: f64) -> f64 {
    milliseconds(time - track.times.first().copied().unwrap_or(0.0))
}

fn over_time(label: &str, layers: Vec<Layer>) -> Chart {
    Chart::new(Axis::new("time / ms"), Axis::new(label), layers)
}

fn points(name: Option<&str>, group: usize, at: impl Iterator<Item = (f64, f64)>) -> Layer {
    let points = at.map(|(x, y)| ChartPoint::at(x, y)).collect();
    Layer::points(name.map(str::to_owned), points, Style::group(group).open())
}

/// At most so many, evenly spaced.
fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(most).max(1))
}

/// The parabola of a flight over its frames.
fn parabola(track: &Track, flight: &FreeFlight) -> Layer {
    const STEPS: usize = 60;
    let at = |frame: Option<&usize>| frame.map_or(f64::NAN, |frame| track.times[*frame]);
    let (first, last) = (at(flight.frames.first()), at(flight.frames.last()));
    let [middle, height, velocity, gravity] = flight.parabola;
    let xy = (0..=STEPS).map(|step| {
        let t = first + (last - first) * step as f64 / STEPS as f64;
        let x = t - middle;
        let y = height + velocity * x - 0.5 * gravity * x * x;
        (since_start(track, t), millimetres(y))
    });
    Layer::curve("parabolas of one gravity", xy.collect(), Style::group(1), Dash::Solid)
}

fn summary_json(title: &str, campaign: &Campaign, figures: &[&str]) -> Result<String, Error> {
    let estimate = |[value, se]: [f64; 2]| json!({"value": value, "se": se});
    let impact = |impact: &Impact| {
        let (speeds, rebounded) = (impact.speeds, !impact.stuck);
        json!({
            "time_s": speeds.time,
            "impact_speed": estimate([speeds.impact_speed, speeds.impact_speed_sd]),
            "rebound_speed": rebounded.then(|| estimate([speeds.rebound_speed, speeds.rebound_speed_sd])),
            "speed_correlation": rebounded.then_some(speeds.correlation),
            "stuck": impact.stuck,
            "contact_apart_m": impact.apart.or(impact.apart_from_others),
            "verdict": impact.verdict,
        })
    };
    let in_pixels = |scale: &ImageScale| scale.source != ScaleSource::Lengths;
    let recording = |outcome: &Outcome| {
        let (of, shown) = (outcome.tracked.as_ref().ok(), outcome.shown.as_ref());
        let jumps = || of.iter().flat_map(|of| &of.jumps).map(|jump| jump.missing);
        let gravities = of.iter().flat_map(|of| &of.flights).map(|flight| flight.own_gravity);
        json!({
            "run": outcome.recording.run,
            "line": outcome.recording.line,
            "reason": outcome.tracked.as_ref().err().map(Refusal::words),
            "scale_px_per_m": of.map(|of| of.scale).filter(in_pixels).map(|scale| scale.value),
            "noise_m": of.map(|of| of.noise),
            "rest_m": of.and_then(|of| of.rest),
            "frames": shown.map(|shown| shown.frames),
            "positions": shown.map(|shown| shown.track.times.len()),
            "object": shown.and_then(|shown| shown.object.as_deref()),
            "frames_repeated": -jumps().filter(|missing| *missing < 0).sum::<i32>(),
            "frames_missing": jumps().filter(|missing| *missing > 0).sum::<i32>(),
            "own_gravity": gravities.map(estimate).collect::<Vec<_>>(),
            "impacts": of.iter().flat_map(|of| &of.impacts).map(impact).collect::<Vec<_>>(),
        })
    };
    let gravity = campaign.gravity;
    json::text(&json!({
        "schema": TRACKING_SCHEMA,
        "title": title,
        "wetcor": env!("CARGO_PKG_VERSION"),
        "gravity": gravity.measured.map(|g| estimate([g.value, g.se])),
        "scale_px_per_m": gravity.scale.map(estimate),
        "speed_rel_sd": gravity.shared_error(),
        "recordings": campaign.outcomes.iter().map(recording).collect::<Vec<_>>(),
        "figures": figures,
    }))
}
