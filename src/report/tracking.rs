//! Writes the report of tracked recordings: a page, a figure each, and `tracking.json`.

use serde::Serialize;

use super::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::folder::{Files, TRACKING_SCHEMA};
use super::json;
use super::markdown::escape::literal;
use super::markdown::page::Page;
use super::markdown::table::ReportTable;
use super::numbers::{significant, with_se, NONE};
use crate::error::Error;
use crate::recordings::{
    Campaign, FreeFlight, GravityCheck, Impact, Jump, Outcome, Recording, ScaleSource, Shown, SphereInAir, Tracked,
    FAR, GRAVITY, OFF,
};
use crate::units::{micrometres, millimetres, milliseconds, pixels_per_millimetre};

/// Points of a kind that a figure shows; of more, evenly spaced ones.
const MOST_POINTS: usize = 1_000;

/// The same of positions that lie on a parabola: few enough that it is seen between them.
const MOST_ON_PARABOLAS: usize = 120;

/// Every file of the report; `title` is what the list is called.
pub fn files(title: &str, campaign: &Campaign) -> Result<Files<'static>, Error> {
    let figures: Vec<(String, String)> = campaign
        .outcomes
        .iter()
        .filter_map(|outcome| {
            let figure = match &outcome.tracked {
                Ok(tracked) => figure(tracked),
                Err(_) => figure_of_heights(outcome.shown.as_ref()?),
            };
            Some((figure_name(&outcome.recording), figure))
        })
        .collect();
    let names: Vec<&str> = figures.iter().map(|(name, _)| name.as_str()).collect();
    let mut whole = vec![
        ("report.md".to_owned(), page(title, campaign, &names).into_bytes()),
        (
            "tracking.json".to_owned(),
            summary_json(title, campaign, &names)?.into_bytes(),
        ),
    ];
    whole.extend(
        figures
            .into_iter()
            .map(|(name, svg)| (format!("figures/{name}"), svg.into_bytes())),
    );
    Ok(Files {
        whole,
        ..Files::default()
    })
}

/// By the line of the list, since names may hold what no file is called.
fn figure_name(recording: &Recording) -> String {
    format!("line_{}.svg", recording.line)
}

/// How many recordings gave runs, what became of the others, and the gravity, a line each.
pub fn summary(campaign: &Campaign) -> String {
    let impacts = || {
        campaign
            .outcomes
            .iter()
            .filter_map(|outcome| outcome.tracked.as_ref().ok())
            .flat_map(|of| &of.impacts)
    };
    let used = impacts().filter(|impact| impact.verdict.is_none());
    let stuck = used.clone().filter(|impact| impact.stuck).count();
    let verdicts = impacts().count() - used.clone().count();
    let refused = || {
        campaign
            .outcomes
            .iter()
            .filter_map(|outcome| outcome.tracked.as_ref().err())
    };
    let mistakes = refused().filter(|refusal| refusal.is_mistake()).count();
    let mut text = format!(
        "{} recordings: {} runs, {stuck} of them stuck; {} left out with a reason",
        campaign.outcomes.len(),
        used.count(),
        verdicts + refused().count()
    );
    if mistakes > 0 {
        text.push_str(&format!(", {mistakes} of them unread or without a fall"));
    }
    text.push('\n');
    for line in gravity_lines(campaign) {
        text.push_str(&line);
        text.push('\n');
    }
    text
}

/// Whether every recording is one that was meant, and any gives a run that is used.
pub fn is_usable(campaign: &Campaign) -> bool {
    let is_mistake = |outcome: &Outcome| outcome.tracked.as_ref().is_err_and(|refusal| refusal.is_mistake());
    let is_used = |(.., impact): Row| impact.verdict.is_none();
    !campaign.outcomes.iter().any(is_mistake) && rows(campaign).any(is_used)
}

/// Each recording with frames that are repeated or missing, and which.
pub fn uneven(campaign: &Campaign) -> Vec<String> {
    let lines = campaign.outcomes.iter().filter_map(|outcome| {
        let (tracked, shown) = (outcome.tracked.as_ref().ok()?, outcome.shown.as_ref()?);
        let recording = &outcome.recording;
        let frames = uneven_frames(recording, shown, &tracked.jumps)?;
        Some(format!(
            "line {}, {}: {frames}; its times are mended, and ± holds what they may do at the contact and to the frame rate",
            recording.line, recording.run
        ))
    });
    lines.collect()
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
        let begin = |reason: &str| format!("line {}, {}: {reason}", recording.line, recording.run);
        match tracked {
            Err(refusal) => lines.push(begin(refusal.words())),
            Ok(tracked) => lines.extend(
                tracked
                    .impacts
                    .iter()
                    .filter_map(|impact| Some(begin(impact.verdict.as_deref()?))),
            ),
        }
    }
    lines
}

/// What the gravity says of scales and frame rates.
fn gravity_lines(campaign: &Campaign) -> Vec<String> {
    let gravity: GravityCheck = campaign.gravity;
    let mut lines = vec![];
    if let Some(g) = gravity.measured {
        lines.push(format!(
            "gravity: {} m/s² from {} flights by scales that were measured ({:+.2} % of {GRAVITY})",
            with_se(g.value, g.se),
            g.flights,
            100.0 * (g.value / GRAVITY - 1.0)
        ));
    }
    if let Some([scale, se]) = gravity.scale {
        lines.push(format!(
            "scale: {} px/mm by gravity, where none was measured{}",
            with_se(pixels_per_millimetre(scale), pixels_per_millimetre(se)),
            widths_by_gravity(campaign)
        ));
    }
    if gravity.measured.is_some() || gravity.scale.is_some() {
        lines.push(format!(
            "an error that all speeds share: `speed_rel_sd = {}` in [data] of the scene",
            significant(gravity.shared_error(), 2)
        ));
    }
    lines
}

/// How wide the spheres are by the scale that gravity gives: what shows a wrong frame rate to whoever saw the images.
fn widths_by_gravity(campaign: &Campaign) -> String {
    let by_gravity = campaign.outcomes.iter().filter_map(|outcome| {
        let scale = outcome.tracked.as_ref().ok()?.scale;
        (scale.source == ScaleSource::Gravity).then_some(scale.value * outcome.recording.diameter)
    });
    let widths: Vec<f64> = by_gravity.collect();
    let least = widths.iter().copied().fold(f64::INFINITY, f64::min);
    let most = widths.iter().copied().fold(0.0, f64::max);
    if !least.is_finite() {
        return String::new();
    }
    let [least, most] = [least, most].map(|width| significant(width, 2));
    let widths = if least == most {
        least
    } else {
        format!("{least} to {most}")
    };
    format!("; the spheres are then {widths} px wide in the images")
}

fn page(title: &str, campaign: &Campaign, figures: &[&str]) -> String {
    let mut page = Page::titled(&format!("Recordings of {}", literal(title)), figures);
    page.list(&summary(campaign).lines().map(str::to_owned).collect::<Vec<_>>());
    let mut looks: Vec<String> = campaign.notices.iter().map(|notice| literal(&notice.text)).collect();
    looks.extend(uneven(campaign).iter().map(|line| literal(line)));
    if !looks.is_empty() {
        page.heading("Notices");
        page.list(&looks);
    }
    page.section(
        "Runs",
        "Both speeds are those at the plate, where the flights before and after the contact meet, and beside them those at \
         the film's surface. ± is the standard deviation of the scatter of positions.",
    );
    runs(&mut page, campaign);
    let left_out = left_out(campaign);
    if !left_out.is_empty() {
        page.section(
            "Left out",
            "Their lines in the table of runs carry the reason in `exclude`.",
        );
        page.list(&left_out.iter().map(|line| literal(line)).collect::<Vec<_>>());
    }
    page.section(
        "Scale and gravity",
        &format!(
            "Every flight is fitted with one gravity. A flight whose own is off by more than {:.0} % and {FAR} standard \
             deviations leaves its run out, since its scale or frame rate is then wrong. What falls faster than {GRAVITY} \
             m/s² by a measured scale was nearer than it says, or taken at more frames a second.",
            100.0 * OFF
        ),
    );
    scales(&mut page, campaign);
    page.section(
        "Air",
        "What the drag of the air is at the impact speed, over the weight. It is computed, not fitted, and taken off where the \
         list has the density of the sphere.",
    );
    air(&mut page, campaign);
    page.section(
        "Recordings",
        "Heights of the sphere over the contact, the frames that each flight is fitted with, and what the parabolas leave.",
    );
    for outcome in &campaign.outcomes {
        let Some(shown) = &outcome.shown else { continue };
        let told = match &outcome.tracked {
            Ok(tracked) => caption(tracked),
            Err(refusal) => format!(
                "{} positions in {} frames; left out: {}",
                shown.track.times.len(),
                shown.frames,
                literal(refusal.words())
            ),
        };
        let object = shown
            .object
            .as_ref()
            .map_or(String::new(), |object| format!(", object {}", literal(object)));
        let caption = format!("{}{object}: {told}.", literal(&outcome.recording.run));
        page.figure(&figure_name(&outcome.recording), "heights over time", &caption);
    }
    page.text.trim_end().to_owned() + "\n"
}

fn caption(tracked: &Tracked) -> String {
    let frames: usize = tracked.flights.iter().map(|flight| flight.frames.len()).sum();
    let rest = tracked.rest.map_or(String::new(), |rest| {
        format!(", at rest {} µm over the contact", significant(micrometres(rest), 2))
    });
    format!(
        "{} positions, {frames} in {} flights, which scatter by {} µm{rest}",
        tracked.track.times.len(),
        tracked.flights.len(),
        significant(micrometres(tracked.noise), 2)
    )
}

/// An impact with the recording it is of.
type Row<'c> = (&'c Recording, &'c Tracked, &'c Impact);

fn rows(campaign: &Campaign) -> impl Iterator<Item = Row<'_>> {
    campaign.outcomes.iter().flat_map(|outcome| {
        let tracked = outcome.tracked.as_ref().ok();
        tracked.into_iter().flat_map(move |tracked| {
            tracked
                .impacts
                .iter()
                .map(move |impact| (&outcome.recording, tracked, impact))
        })
    })
}

fn runs(page: &mut Page, campaign: &Campaign) {
    let rebound = |impact: &Impact| {
        if impact.stuck {
            "stuck".to_owned()
        } else {
            with_se(impact.speeds.rebound_speed, impact.speeds.rebound_speed_sd)
        }
    };
    let table = ReportTable::of(rows(campaign))
        .whole()
        .column("run", |(recording, ..): Row| literal(&recording.run))
        .column("particle", |(recording, ..): Row| literal(&recording.particle))
        .column("liquid", |(recording, ..): Row| {
            recording
                .liquid
                .as_deref()
                .map_or(crate::scene::DRY.to_owned(), literal)
        })
        .column("v / (m/s)", |(.., impact): Row| {
            with_se(impact.speeds.impact_speed, impact.speeds.impact_speed_sd)
        })
        .column("v_r / (m/s)", |(.., impact): Row| rebound(impact))
        .column("correlation", |(.., impact): Row| {
            if impact.stuck {
                NONE.to_owned()
            } else {
                format!("{:.2}", impact.speeds.correlation)
            }
        })
        .column("e", |(.., impact): Row| {
            significant(impact.speeds.rebound_speed / impact.speeds.impact_speed, 4)
        })
        .column("v, v_r at the film", |(recording, _, impact): Row| {
            let [v, v_r] = impact.at_film.map(|v| significant(v, 4));
            if recording.liquid.is_some() {
                format!("{v}, {v_r}")
            } else {
                NONE.to_owned()
            }
        })
        .column("verdict", |(.., impact): Row| {
            impact.verdict.as_deref().map_or("used".to_owned(), literal)
        });
    page.table(&table);
}

fn scales(page: &mut Page, campaign: &Campaign) {
    let of = campaign
        .outcomes
        .iter()
        .filter_map(|outcome| Some((&outcome.recording, outcome.tracked.as_ref().ok()?)));
    let of: Vec<(&Recording, &Tracked)> = of.collect();
    let source = |tracked: &Tracked| match tracked.scale.source {
        ScaleSource::Lengths => "positions are lengths",
        ScaleSource::Stated => "the list",
        ScaleSource::Diameter => "the diameter",
        ScaleSource::Gravity => "gravity",
    };
    let own = |tracked: &Tracked| {
        let best = tracked
            .flights
            .iter()
            .min_by(|a, b| a.own_gravity[1].total_cmp(&b.own_gravity[1]));
        best.map_or(NONE.to_owned(), |flight| {
            with_se(flight.own_gravity[0], flight.own_gravity[1])
        })
    };
    let table = ReportTable::of(of)
        .whole()
        .column("run", |(recording, _): (&Recording, &Tracked)| literal(&recording.run))
        .column("px/mm used", |(_, tracked): (&Recording, &Tracked)| {
            match tracked.scale.source {
                ScaleSource::Lengths => NONE.to_owned(),
                _ => significant(pixels_per_millimetre(tracked.scale.value), 5),
            }
        })
        .column("from", |(_, tracked): (&Recording, &Tracked)| source(tracked))
        .column("by the diameter", |(_, tracked): (&Recording, &Tracked)| {
            tracked.scale.by_diameter.map_or(NONE.to_owned(), |[value, se]| {
                with_se(pixels_per_millimetre(value), pixels_per_millimetre(se))
            })
        })
        .column("own gravity / (m/s²)", |(_, tracked): (&Recording, &Tracked)| {
            own(tracked)
        });
    page.table(&table);
}

/// What is to be said of runs whose drag is not taken off; nothing where it is, or is less than matters.
pub fn drag_left(campaign: &Campaign) -> Option<String> {
    /// of the weight: e is then off by a thousandth
    const MATTERS: f64 = 0.003;
    let left = rows(campaign).filter(|(recording, ..)| recording.density.is_none());
    let most = left
        .map(|(recording, _, impact)| drag(recording, impact))
        .fold(0.0, f64::max);
    (most > MATTERS).then(|| {
        format!(
            "the drag of the air is not taken off, since the list has no density_kg_m3: of a sphere of {LIGHT} kg/m³ it is up to \
             {} % of the weight, and makes e too small by about a third of that share",
            significant(100.0 * most, 2)
        )
    })
}

/// Density of a light sphere in kg/m³, where the list has none.
const LIGHT: f64 = 1000.0;

/// Drag at the impact speed over the weight.
fn drag(recording: &Recording, impact: &Impact) -> f64 {
    let sphere = SphereInAir {
        diameter: recording.diameter,
        density: recording.density.unwrap_or(LIGHT),
    };
    sphere.deceleration(impact.speeds.impact_speed) / GRAVITY
}

fn air(page: &mut Page, campaign: &Campaign) {
    let known = rows(campaign).filter(|(recording, ..)| recording.density.is_some());
    let shares: Vec<f64> = known.map(|(recording, _, impact)| drag(recording, impact)).collect();
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let most = shares.iter().copied().fold(0.0, f64::max);
    if least.is_finite() {
        page.paragraph(&format!(
            "{} to {} % of the weight was taken off.",
            significant(100.0 * least, 2),
            significant(100.0 * most, 2)
        ));
    }
    match drag_left(campaign) {
        Some(left) => page.paragraph(&format!("Notice: {left}.")),
        None if shares.is_empty() => page.paragraph("It is too small to matter here."),
        None => {}
    }
}

/// Heights with the parabolas, and what these leave.
fn figure(tracked: &Tracked) -> String {
    let track = &tracked.track;
    let start = track.times.first().copied().unwrap_or(0.0);
    let time = |t: f64| milliseconds(t - start);
    let point = |x: f64, y: f64| ChartPoint { x, y, y_se: None };
    let positions = |name: &str, frames: &[usize], (group, most): (usize, usize)| Layer::Points {
        name: Some(name.to_owned()),
        points: thinned(frames, most)
            .map(|frame| point(time(track.times[*frame]), millimetres(track.heights[*frame])))
            .collect(),
        style: Style::group(group).open(),
    };
    let fitted: Vec<usize> = tracked
        .flights
        .iter()
        .flat_map(|flight| flight.frames.iter().copied())
        .collect();
    let is_fitted: std::collections::BTreeSet<usize> = fitted.iter().copied().collect();
    let others: Vec<usize> = (0..track.times.len())
        .filter(|frame| !is_fitted.contains(frame))
        .collect();
    let mut heights = vec![positions("fitted", &fitted, (0, MOST_ON_PARABOLAS))];
    if !others.is_empty() {
        heights.push(positions("not fitted", &others, (2, MOST_POINTS)));
    }
    let mut residuals = vec![];
    for flight in &tracked.flights {
        heights.push(parabola(track.times.as_slice(), flight, time));
        let left: Vec<(usize, f64)> = flight
            .frames
            .iter()
            .copied()
            .zip(flight.residuals.iter().copied())
            .collect();
        residuals.push(Layer::Points {
            name: None,
            points: thinned(&left, MOST_POINTS)
                .map(|(frame, left)| point(time(track.times[*frame]), micrometres(*left)))
                .collect(),
            style: Style::group(0).open(),
        });
    }
    let chart = |label: &str, layers: Vec<Layer>| Chart {
        title: None,
        x: Axis::new("time / ms"),
        y: Axis::new(label),
        layers,
    };
    svg(&[
        chart("height over the contact / mm", heights),
        chart("residual / µm", residuals),
    ])
}

/// Heights of a recording that gives no run, as they were seen.
fn figure_of_heights(shown: &Shown) -> String {
    let track = &shown.track;
    let start = track.times.first().copied().unwrap_or(0.0);
    let (label, scale): (&str, fn(f64) -> f64) = if shown.in_pixels {
        ("height / px", |height| height)
    } else {
        ("height / mm", millimetres)
    };
    let frames: Vec<usize> = (0..track.times.len()).collect();
    let point = |frame: &usize| ChartPoint {
        x: milliseconds(track.times[*frame] - start),
        y: scale(track.heights[*frame]),
        y_se: None,
    };
    svg(&[Chart {
        title: None,
        x: Axis::new("time / ms"),
        y: Axis::new(label),
        layers: vec![Layer::Points {
            name: Some("not fitted".to_owned()),
            points: thinned(&frames, MOST_POINTS).map(point).collect(),
            style: Style::group(2).open(),
        }],
    }])
}

/// At most so many, evenly spaced.
fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(most).max(1))
}

/// The parabola of a flight over its frames.
fn parabola(times: &[f64], flight: &FreeFlight, time: impl Fn(f64) -> f64) -> Layer {
    const STEPS: usize = 60;
    let at = |frame: Option<&usize>| frame.map_or(f64::NAN, |frame| times[*frame]);
    let (first, last) = (at(flight.frames.first()), at(flight.frames.last()));
    let [middle, height, velocity, gravity] = flight.parabola;
    let xy = (0..=STEPS).map(|step| {
        let t = first + (last - first) * step as f64 / STEPS as f64;
        let x = t - middle;
        (time(t), millimetres(height + velocity * x - 0.5 * gravity * x * x))
    });
    Layer::Line {
        name: Some("parabolas of one gravity".to_owned()),
        xy: xy.collect(),
        style: Style::group(1),
        dash: Dash::Solid,
    }
}

fn summary_json(title: &str, campaign: &Campaign, figures: &[&str]) -> Result<String, Error> {
    #[derive(Serialize)]
    struct Estimate {
        value: f64,
        se: f64,
    }
    #[derive(Serialize)]
    struct RecordingRow<'c> {
        run: &'c str,
        line: u64,
        reason: Option<&'c str>,
        scale_px_per_m: Option<f64>,
        noise_m: Option<f64>,
        rest_m: Option<f64>,
        frames: Option<usize>,
        positions: Option<usize>,
        object: Option<&'c str>,
        frames_repeated: i32,
        frames_missing: i32,
        own_gravity: Vec<Estimate>,
        impacts: Vec<ImpactRow<'c>>,
    }
    #[derive(Serialize)]
    struct ImpactRow<'c> {
        time_s: f64,
        impact_speed: Estimate,
        rebound_speed: Option<Estimate>,
        speed_correlation: Option<f64>,
        stuck: bool,
        verdict: Option<&'c str>,
    }
    #[derive(Serialize)]
    struct TrackingFile<'c> {
        schema: &'c str,
        title: &'c str,
        wetcor: &'c str,
        gravity: Option<Estimate>,
        scale_px_per_m: Option<Estimate>,
        speed_rel_sd: f64,
        recordings: Vec<RecordingRow<'c>>,
        figures: &'c [&'c str],
    }
    let estimate = |value: f64, se: f64| Estimate { value, se };
    fn impact_row(impact: &Impact) -> ImpactRow<'_> {
        let speeds = impact.speeds;
        let rebounded = !impact.stuck;
        ImpactRow {
            time_s: speeds.time,
            impact_speed: Estimate {
                value: speeds.impact_speed,
                se: speeds.impact_speed_sd,
            },
            rebound_speed: rebounded.then_some(Estimate {
                value: speeds.rebound_speed,
                se: speeds.rebound_speed_sd,
            }),
            speed_correlation: rebounded.then_some(speeds.correlation),
            stuck: impact.stuck,
            verdict: impact.verdict.as_deref(),
        }
    }
    let rows = campaign.outcomes.iter().map(|outcome| {
        let (recording, shown) = (&outcome.recording, outcome.shown.as_ref());
        let tracked = outcome.tracked.as_ref();
        let of = tracked.ok();
        let jumps = || of.iter().flat_map(|of| &of.jumps).map(|jump| jump.missing);
        RecordingRow {
            run: &recording.run,
            line: recording.line,
            reason: tracked.err().map(|refusal| refusal.words()),
            scale_px_per_m: of
                .filter(|of| of.scale.source != ScaleSource::Lengths)
                .map(|of| of.scale.value),
            noise_m: of.map(|of| of.noise),
            rest_m: of.and_then(|of| of.rest),
            frames: shown.map(|shown| shown.frames),
            positions: shown.map(|shown| shown.track.times.len()),
            object: shown.and_then(|shown| shown.object.as_deref()),
            frames_repeated: -jumps().filter(|missing| *missing < 0).sum::<i32>(),
            frames_missing: jumps().filter(|missing| *missing > 0).sum(),
            own_gravity: of.map_or(vec![], |of| {
                of.flights
                    .iter()
                    .map(|flight| estimate(flight.own_gravity[0], flight.own_gravity[1]))
                    .collect()
            }),
            impacts: of.map_or(vec![], |of| of.impacts.iter().map(impact_row).collect()),
        }
    });
    json::text(&TrackingFile {
        schema: TRACKING_SCHEMA,
        title,
        wetcor: env!("CARGO_PKG_VERSION"),
        gravity: campaign.gravity.measured.map(|g| estimate(g.value, g.se)),
        scale_px_per_m: campaign.gravity.scale.map(|[value, se]| estimate(value, se)),
        speed_rel_sd: campaign.gravity.shared_error(),
        recordings: rows.collect(),
        figures,
    })
}
