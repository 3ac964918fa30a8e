//! Holds what `track` makes of positions against flights that are known.

use crate::common::{binomial_z, mean, normal, seed_of, table_of, Folder, Says};
use crate::flight::{Bounces, GRAVITY};
use crate::render;
use nalgebra::DMatrix;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use wetcor::recordings::{track, Campaign, ContactSpeeds, Refusal, TrackOptions, Tracked};

/// A camera that sees a sphere well.
#[derive(Debug, Clone, Copy)]
struct Camera {
    frame_rate: f64,
    /// pixels per m
    scale: f64,
    /// sd of a position in pixels
    noise: f64,
    /// share of frames without a position
    missing: f64,
    /// share of frames in which something else is taken for the sphere
    wrong: f64,
}

const CAMERA: Camera = Camera {
    frame_rate: 1000.0,
    scale: 20_000.0,
    noise: 0.5,
    missing: 0.0,
    wrong: 0.0,
};

const PLATE_ROW: f64 = 900.0;

fn fall(contact: f64, impact_speed: f64, restitution: f64) -> Bounces {
    Bounces {
        contact,
        impact_speed,
        restitution,
    }
}

fn rng_of(test: &str) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed_of(test))
}

/// A table of positions, a row a frame.
fn frames(rows: impl Iterator<Item = f64>) -> String {
    let rows = rows.enumerate().map(|(frame, row)| format!("{frame},{row}\n"));
    format!("frame,y_px\n{}", rows.collect::<String>())
}

/// A sphere a recording, and until when it is seen.
struct Seen {
    bounces: Bounces,
    until: f64,
    /// further cells of its line, under the header's `more`
    more: String,
}

fn drops(count: usize, rng: &mut ChaCha8Rng) -> Vec<Seen> {
    let drop = |rng: &mut ChaCha8Rng| {
        let bounces = Bounces {
            contact: rng.random_range(0.060..0.064),
            impact_speed: rng.random_range(0.7..1.5),
            restitution: rng.random_range(0.4..0.8),
        };
        // two flights, and no more
        let until = bounces.second_contact() - 0.002;
        Seen {
            bounces,
            until,
            more: "20".to_owned(),
        }
    };
    (0..count).map(|_| drop(rng)).collect()
}

/// Positions as a table of frames, rows downwards.
fn positions(seen: &Seen, camera: Camera, rng: &mut ChaCha8Rng) -> String {
    let mut text = "frame,y_px\n".to_owned();
    for frame in 0..(seen.until * camera.frame_rate) as usize {
        let noise = normal(rng);
        let height = seen.bounces.height(frame as f64 / camera.frame_rate);
        let mut row = PLATE_ROW - height * camera.scale + camera.noise * noise;
        if rng.random_bool(camera.wrong) {
            row = rng.random_range(0.0..PLATE_ROW);
        }
        if !rng.random_bool(camera.missing) {
            text.push_str(&format!("{frame},{row}\n"));
        }
    }
    text
}

const HEADER: &str = "file,particle,liquid,diameter_mm,film_um,frame_rate_Hz";

/// A folder with a list and its tables.
fn written(all: &[Seen], camera: Camera, more: &str, rng: &mut ChaCha8Rng) -> Folder {
    let folder = Folder::new();
    let mut list = format!("{HEADER},{more}\n");
    for (place, seen) in all.iter().enumerate() {
        let name = format!("drop{place}.csv");
        folder.write(&name, positions(seen, camera, rng));
        list.push_str(&format!("{name},PTFE,dry,4.762,,{},{}\n", camera.frame_rate, seen.more));
    }
    folder.write("recordings.csv", list);
    folder
}

fn tracked(folder: &Folder) -> Campaign {
    let list = folder.join("recordings.csv");
    track(&list, TrackOptions::default(), &|_| ()).unwrap_or_else(|error| panic!("{error}"))
}

/// Tracks what a list names, under the usual header and `more` of it.
fn listed(folder: &Folder, more: &str, lines: &str) -> Campaign {
    folder.write("recordings.csv", format!("{HEADER}{more}\n{lines}"));
    tracked(folder)
}

fn each(campaign: &Campaign) -> impl Iterator<Item = Option<&Tracked>> {
    campaign.outcomes.iter().map(|outcome| outcome.tracked.as_ref().ok())
}

/// Errors of v and v_r, each with the sd that is stated; of e; all runs are there.
#[derive(Default)]
struct Errors {
    speeds: Vec<[f64; 2]>,
    restitution: Vec<f64>,
}

/// Errors of v and of v_r, each with the sd that is stated.
fn speed_errors(of: &ContactSpeeds, seen: &Seen) -> [[f64; 2]; 2] {
    let v = seen.bounces.impact_speed;
    let v_r = seen.bounces.restitution * v;
    [
        [of.impact_speed - v, of.impact_speed_sd],
        [of.rebound_speed - v_r, of.rebound_speed_sd],
    ]
}

fn errors(campaign: &Campaign, all: &[Seen]) -> Errors {
    let mut errors = Errors::default();
    for (tracked, seen) in each(campaign).zip(all) {
        let impact = &tracked.expect("it gives a run").impacts[0];
        assert_eq!((impact.stuck, &impact.verdict), (false, &None));
        let of = &impact.speeds;
        errors.speeds.extend(speed_errors(of, seen));
        let e = of.rebound_speed / of.impact_speed;
        errors.restitution.push(e - seen.bounces.restitution);
    }
    errors
}

/// How many standard deviations the coverage of 95 % intervals, made narrower by a factor, is from theirs.
fn coverage_z(errors: &[[f64; 2]], factor: f64) -> f64 {
    binomial_z(covered(errors, factor * 1.959_963_985), errors.len(), 0.95)
}

fn covered(errors: &[[f64; 2]], sds: f64) -> usize {
    errors.iter().filter(|[error, sd]| error.abs() < sds * sd).count()
}

/// The Cramér–Rao bounds of v and v_r of each recording: height and time of the contact and both speeds are its own, one
/// gravity is shared, and every frame whose exposure cannot hold the contact is seen.
fn bounds(all: &[Seen], camera: Camera) -> Vec<f64> {
    let sd = camera.noise / camera.scale;
    // of each recording the information about its own four, and what it shares with g
    let mut own = vec![];
    let mut of_gravity = 0.0;
    for Seen { bounces, until, .. } in all {
        let (v, v_r) = (bounces.impact_speed, bounces.restitution * bounces.impact_speed);
        let mut information = DMatrix::zeros(5, 5);
        for frame in 0..(until * camera.frame_rate) as usize {
            let x = frame as f64 / camera.frame_rate - bounces.contact;
            if x.abs() < 0.5 / camera.frame_rate {
                continue;
            }
            // y = h ∓ … : slopes in h, t_c, v, v_r, g
            let slopes = if x < 0.0 {
                [1.0, v + GRAVITY * x, -x, 0.0, -0.5 * x * x]
            } else {
                [1.0, GRAVITY * x - v_r, 0.0, x, -0.5 * x * x]
            };
            let slopes = DMatrix::from_row_slice(1, 5, &slopes) / sd;
            information += slopes.transpose() * slopes;
        }
        let of_own = information.view((0, 0), (4, 4)).into_owned();
        let with_g = information.view((0, 4), (4, 1)).into_owned();
        let inverse = of_own.try_inverse().expect("what two flights tell");
        let explained = (with_g.transpose() * &inverse * &with_g)[(0, 0)];
        of_gravity += information[(4, 4)] - explained;
        own.push((inverse, with_g));
    }
    let mut bounds = vec![];
    for (inverse, with_g) in own {
        let moved = &inverse * with_g;
        for of in [2, 3] {
            bounds.push((inverse[(of, of)] + moved[(of, 0)] * moved[(of, 0)] / of_gravity).sqrt());
        }
    }
    bounds
}

#[test]
fn speeds_are_as_good_as_they_can_be_and_their_sds_cover() {
    let mut rng = rng_of("speeds_are_as_good_as_they_can_be_and_their_sds_cover");
    let (mut all, mut bound, mut restitution) = (vec![], vec![], vec![]);
    for _ in 0..20 {
        let seen = drops(20, &mut rng);
        let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
        let found = errors(&tracked(&folder), &seen);
        bound.extend(bounds(&seen, CAMERA));
        all.extend(found.speeds);
        restitution.extend(found.restitution);
    }
    // an error beside the bound has a mean square of 1 where the bound is met
    let square = |(error, bound): (&[f64; 2], &f64)| (error[0] / bound).powi(2);
    let beside = (all.iter().zip(&bound).map(square).sum::<f64>() / all.len() as f64).sqrt();
    assert!((0.9..1.3).contains(&beside), "{beside} of the bound");
    let z = coverage_z(&all, 1.0);
    assert!(z.abs() < 4.0, "{z}");
    // the planted fault: sds a quarter too small
    let z = coverage_z(&all, 0.75);
    assert!(z < -4.0, "{z}");
    let (bias, se) = mean(&restitution);
    assert!(bias.abs() < 0.001 && bias.abs() < 4.0 * se, "{bias} {se}");
}

#[test]
fn missing_frames_and_other_objects_cost_no_truth() {
    let mut rng = rng_of("missing_frames_and_other_objects_cost_no_truth");
    let camera = Camera {
        missing: 0.1,
        wrong: 0.03,
        ..CAMERA
    };
    let seen = drops(300, &mut rng);
    let folder = written(&seen, camera, "scale_px_per_mm", &mut rng);
    let found = errors(&tracked(&folder), &seen);
    let z = coverage_z(&found.speeds, 1.0);
    assert!(z.abs() < 4.0, "{z}");
    let (bias, _) = mean(&found.restitution);
    assert!(bias.abs() < 0.001, "{bias}");
}

#[test]
fn a_scale_that_nobody_measured_is_that_of_gravity() {
    let mut rng = rng_of("a_scale_that_nobody_measured_is_that_of_gravity");
    let mut seen = drops(60, &mut rng);
    seen.iter_mut().for_each(|seen| seen.more = String::new());
    let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&folder);
    assert_eq!(campaign.gravity.measured, None);
    let [scale, se] = campaign.gravity.scale.expect("the scale of all");
    assert!(
        (scale - CAMERA.scale).abs() < 4.0 * se && se < 1e-3 * scale,
        "{scale} {se}"
    );
    let (bias, _) = mean(&errors(&campaign, &seen).restitution);
    assert!(bias.abs() < 0.001, "{bias}");
}

/// A recording whose scale is wrong is named, and moves neither its neighbours' speeds nor the error that all are to share:
/// not where it has most of the frames, and not where its heights are of another kind.
#[test]
fn a_wrong_scale_is_its_own_recordings_alone() {
    let mut rng = rng_of("a_wrong_scale_is_its_own_recordings_alone");
    let mut seen = drops(2, &mut rng);
    let coarse = Camera {
        frame_rate: 250.0,
        ..CAMERA
    };
    for scale in [10.0, 18.0, 40.0, 2_000.0] {
        // its frames are four times as many as those of the right one, of pixels or of lengths
        seen[1].more = format!("{scale},");
        seen[0].more = "20,".to_owned();
        let folder = written(&seen, CAMERA, "scale_px_per_mm,y_unit", &mut rng);
        let list = folder.read("recordings.csv");
        for (rows, cells) in [("px", "250,20,"), ("mm", "250,,")] {
            let heights = positions(&seen[0], coarse, &mut rng);
            let in_mm = |line: &str| {
                let (frame, row) = line.split_once(',').expect("two columns");
                format!("{frame},{}\n", (PLATE_ROW - row.parse::<f64>().expect("a row")) / 20.0)
            };
            folder.write(
                "drop0.csv",
                match rows {
                    "px" => heights,
                    _ => "frame,y_mm\n".to_owned() + &heights.lines().skip(1).map(in_mm).collect::<String>(),
                },
            );
            folder.write("recordings.csv", list.replacen("1000,20,", cells, 1));
            let campaign = tracked(&folder);
            let impacts: Vec<_> = each(&campaign)
                .map(|of| of.expect("a run").impacts[0].clone())
                .collect();
            let [right, wrong] = [&impacts[0], &impacts[1]];
            assert_eq!(right.verdict, None, "{scale} {rows}");
            let error = right.speeds.impact_speed - seen[0].bounces.impact_speed;
            assert!(
                error.abs() < 4.0 * right.speeds.impact_speed_sd,
                "{scale} {rows}: {error}"
            );
            let verdict = wrong.verdict.as_ref().expect("it is left out");
            verdict.says("it falls at");
            verdict.says("scale_px_per_mm would be 20.");
            // it falls by its own gravity, so that its speeds are wrong by the scale and by nothing else
            let ratio = wrong.speeds.impact_speed / seen[1].bounces.impact_speed * scale / 20.0;
            assert!((ratio - 1.0).abs() < 0.01, "{scale} {rows}: {ratio}");
            let shared = campaign
                .gravity
                .shared_error()
                .expect("one recording falls as things do");
            assert!(shared < 0.02, "{scale} {rows}: {shared}");
        }
    }
    // none that falls as things do: a mistake is not offered as an error that speeds share
    seen[0].more = "10,".to_owned();
    let folder = written(&seen, CAMERA, "scale_px_per_mm,y_unit", &mut rng);
    let (status, stdout, stderr) = folder.run("track recordings.csv --out runs.csv");
    assert_eq!(status, Some(1), "no run is left: {stderr}");
    assert!(!stdout.contains("speed_rel_sd"), "{stdout}");
    stdout.says("no recording shows a fall at 9.81");
}

/// Nor is a scale by gravity that of the recording with most frames, where the others share another.
#[test]
fn a_long_recording_at_another_scale_condemns_no_others() {
    let mut rng = rng_of("a_long_recording_at_another_scale_condemns_no_others");
    let mut seen = drops(4, &mut rng);
    seen.iter_mut().for_each(|seen| seen.more = String::new());
    for place in [0, 3] {
        let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
        let near = Camera {
            frame_rate: 8_000.0,
            scale: 40_000.0,
            ..CAMERA
        };
        let name = format!("drop{place}.csv");
        folder.write(&name, positions(&seen[place], near, &mut rng));
        let list = folder.read("recordings.csv");
        let line = format!("{name},PTFE,dry,4.762,,");
        let list = list.replace(&format!("{line}1000"), &format!("{line}8000"));
        folder.write("recordings.csv", list);
        for (of, tracked) in each(&tracked(&folder)).enumerate() {
            let impact = &tracked.expect("a run").impacts[0];
            assert_eq!(impact.verdict.is_some(), of == place, "{of}: {:?}", impact.verdict);
            if let Some(verdict) = &impact.verdict {
                verdict.says("by the scale of the others it falls at 19.");
            }
        }
    }
}

#[test]
fn a_sphere_that_stays_is_a_run_that_stuck() {
    let mut rng = rng_of("a_sphere_that_stays_is_a_run_that_stuck");
    let mut seen = drops(40, &mut rng);
    for seen in &mut seen[..20] {
        seen.bounces.restitution = 0.0;
        seen.until = 0.4;
    }
    let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&folder);
    let mut errors = vec![];
    for (place, (tracked, seen)) in each(&campaign).zip(&seen).enumerate() {
        let impact = &tracked.expect("a run").impacts[0];
        assert_eq!(impact.stuck, place < 20);
        if impact.stuck {
            let off = impact.speeds.impact_speed - seen.bounces.impact_speed;
            errors.push([off, impact.speeds.impact_speed_sd]);
        }
    }
    assert!(covered(&errors, 4.0) == 20 && covered(&errors, 1.96) > 14, "{errors:?}");
}

#[test]
fn a_recording_is_refused_by_name_and_never_in_silence() {
    let mut rng = rng_of("a_recording_is_refused_by_name_and_never_in_silence");
    let mut seen = drops(5, &mut rng);
    seen[1].until = seen[1].bounces.contact - 0.004;
    seen[3].until = seen[3].bounces.contact + 0.002;
    let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&folder);
    let refused = campaign.outcomes.iter().map(|outcome| outcome.tracked.is_err());
    assert_eq!(refused.collect::<Vec<_>>(), [false, true, false, true, false]);
    let (status, stdout, stderr) = folder.run("track recordings.csv --out runs.csv --report out");
    assert_eq!(status, Some(0), "{stderr}");
    stdout.begins("5 recordings: 3 runs, 0 of them stuck; 2 left out with a reason\n");
    for line in [3, 5] {
        stderr.says(&format!("line {line}, drop{}.csv: ", line - 2));
    }
    let runs = folder.read("runs.csv");
    assert_eq!(runs.lines().count(), 6);
    let report = folder.read("out/report.md");
    assert!(report.contains("it ends before the sphere has rebounded"), "{report}");
    // the list may say so itself, and then nothing of it is read
    let list = folder.read("recordings.csv");
    let mut lines: Vec<String> = list.lines().map(|line| format!("{line},")).collect();
    lines[0] = lines[0].replace(",scale_px_per_mm,", ",scale_px_per_mm,exclude");
    lines[2] = "no_such_file.csv,PTFE,dry,4.762,,1000,,lens cap on".to_owned();
    folder.write("recordings.csv", lines.join("\n"));
    let campaign = tracked(&folder);
    let excluded = |reason: &str| -> Result<Tracked, Refusal> { Err(Refusal::Excluded(reason.to_owned())) };
    assert_eq!(campaign.outcomes[1].tracked, excluded("lens cap on"));
    // or say yes and no of each
    lines[1].push_str("no");
    lines[2] = lines[2].replace("lens cap on", "yes");
    folder.write("recordings.csv", lines.join("\n"));
    let campaign = tracked(&folder);
    let first = &campaign.outcomes[0].tracked;
    assert!(first.is_ok(), "{first:?}");
    assert_eq!(campaign.outcomes[1].tracked, excluded("yes"));
}

/// A list or a table that cannot be used, and what is said of it.
#[test]
fn bad_input_is_named_by_its_line() {
    let folder = Folder::new();
    let write = |name: &str, text: &str| folder.write(name, text);
    let rows = |height: &dyn Fn(usize) -> f64| frames((0..600).map(height));
    let sphere = fall(0.06, 1.2, 0.7);
    let seen = |frame: usize| 900.0 - 20_000.0 * sphere.height(frame as f64 / 1000.0);
    write("good.csv", &rows(&seen));
    write("still.csv", &rows(&|frame| 400.0 + (frame % 3) as f64 * 0.1));
    write("up.csv", &rows(&|frame| -seen(frame)));
    write("twice.csv", "frame,y_px\n1,5\n1,6\n");
    write("words.csv", "frame,y_px\n1,high\n");
    write("none.csv", "frame,y_px\n");
    write("no_header.csv", "of 3 May\n1,2\n");
    write("no_unit.csv", "frame,y\n1,2\n");
    write("far.csv", "frame,y_px\n1,1e148\n");
    // a recording with its diameter, film and frame rate, and what is said of it
    let bad = table_of(
        "twice.csv,PTFE,dry,4.762,,1000 | line 3: the frame of line 2 has another position
        words.csv,PTFE,dry,4.762,,1000 | line 2, y_px: found `high`, expected a number
        no_header.csv,PTFE,dry,4.762,,1000 | found `of 3 May`, expected columns
        no_unit.csv,PTFE,dry,4.762,,1000 | expected the unit of `y`: px, mm, cm or m as `y_unit` in the list
        far.csv,PTFE,dry,4.762,,1000 | line 2, y_px: found `1e148`, expected a number from -1e12 to 1e12
        good.csv,PTFE,dry,4.762,,1e12 | line 2, frame_rate: found `1000000000000`, expected a rate
        none.csv,PTFE,dry,4.762,,1000 | no positions below the header
        missing.csv,PTFE,dry,4.762,,1000 | line 2, missing.csv
        good.csv,PTFE,dry,4.762,, | frame_rate_Hz
        good.csv,PTFE,AK10,4.762,,1000 | line 2, film: expected a number above 0
        good.csv,PT FE,dry,4.762,,1000 | line 2, particle: found `PT FE`
        ,PTFE,dry,4.762,,1000 | line 2, file: expected a folder of frames",
    );
    let twice = "good.csv,PTFE,dry,4.762,,1000\ngood.csv,PTFE,dry,4.762,,1000";
    let other_name = "line 3, run: found `good.csv`, expected another name than that of line 2";
    let more = [["", "no recordings below the header"], [twice, other_name]];
    for [lines, expected] in bad.into_iter().chain(more) {
        write("recordings.csv", &format!("{HEADER}\n{lines}"));
        let stderr = folder.refused("track recordings.csv --out runs.csv");
        stderr.says(expected);
        stderr.lacks("\\n");
        assert!(!folder.join("runs.csv").exists(), "{lines}");
    }
    // one that is a mistake stops no other
    for (lines, runs, expected) in [
        (
            "good.csv,PTFE,dry,4.762,,1000\nstill.csv,PTFE,dry,4.762,,1000\n",
            "2 recordings: 1 run, 0 of them stuck; 1 left out with a reason, 1 of them unread or without a fall\n",
            "line 3, still.csv: nothing falls in it",
        ),
        (
            "good.csv,PTFE,dry,4.762,,1000\nwords.csv,PTFE,dry,4.762,,1000\n",
            "2 recordings: 1 run,",
            "line 3, words.csv: words.csv: line 2, y_px: found `high`, expected a number",
        ),
        (
            "up.csv,PTFE,dry,4.762,,1000\n",
            "1 recording: 0 runs,",
            "line 2, up.csv: it falls upwards",
        ),
    ] {
        write("recordings.csv", &format!("{HEADER}\n{lines}"));
        let (status, stdout, stderr) = folder.run("track recordings.csv --out some.csv --force --report some");
        assert_eq!(status, Some(1), "{lines}{stderr}");
        assert!(stdout.starts_with(runs), "{lines}{stdout}");
        assert!(stderr.contains(expected), "{lines}{stderr}");
        let written = folder.read("some.csv");
        assert_eq!(written.lines().count(), lines.lines().count() + 1, "{written}");
        // what was seen of a recording that gives no run is drawn
        let drawn = folder.join("some/figures").join("line_2.svg");
        assert!(drawn.exists(), "{lines}");
    }
    // the last has a density in g/cm³
    let no_file = [
        "particle,diameter_mm\nPTFE,4\n",
        "line 1, header: expected a column `file`",
    ];
    let misspelt = "file,particle,diametre_mm\ngood.csv,PTFE,4\n";
    let misspelt = [misspelt, "found `diametre_mm`, expected `diameter_mm`"];
    let dense = "file,particle,liquid,diameter_mm,frame_rate_Hz,density_kg_m3\ngood.csv,PTFE,dry,4.762,1000,2.15\n";
    let dense = [dense, "line 2, density: found `2.15`, expected at least 25 kg/m^3"];
    for [text, expected] in [no_file, misspelt, dense] {
        write("recordings.csv", text);
        folder.refused("track recordings.csv --out runs.csv").says(expected);
    }
    write("drop.mp4", "a video");
    let stderr = folder.refused("track drop.mp4 --out runs.csv");
    stderr.says("a video: expected a list of recordings");
    stderr.says("mkdir frames && ffmpeg");
    write("recordings.csv", &format!("{HEADER}\ngood.csv,PTFE,dry,4.762,,1000\n"));
    let track = |more: &str| folder.run(&format!("track recordings.csv {more}"));
    // not over what it reads, and both outputs or none
    for (more, expected) in [
        ("--out runs.txt", "expected a file ending in .csv"),
        ("--out recordings.csv", "exists"),
        ("--out none/runs.csv", "there is no folder none"),
        ("--out recordings.csv --force", "is the list of recordings"),
        ("--out good.csv --force", "is the recording of line 2"),
        ("--out both.csv --report both.csv", "lies in the folder of the report"),
        ("--out both/runs.csv --report both", "there is no folder both"),
    ] {
        let before = folder.read("good.csv");
        let (status, _, stderr) = track(more);
        assert!(status == Some(2) && stderr.contains(expected), "{more:?}{stderr}");
        assert_eq!(folder.read("good.csv"), before);
        assert!(!folder.join("both").exists() && !folder.join("both.csv").exists());
    }
    assert_eq!(track("--out runs.csv").0, Some(0));
    assert!(track("--out runs.csv").2.contains("--force replaces it"));
    assert_eq!(track("--out runs.csv --force --all-rebounds").0, Some(0));
    let runs = folder.read("runs.csv");
    assert!(runs.contains("good.csv rebound 2,"), "{runs}");
}

#[test]
fn a_sphere_too_narrow_for_its_positions_questions_the_frame_rate() {
    let mut rng = rng_of("a_sphere_too_narrow_for_its_positions_questions_the_frame_rate");
    let mut seen = drops(6, &mut rng);
    let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let list = folder.read("recordings.csv");
    let verdicts = |list: &str| -> Vec<Option<String>> {
        folder.write("recordings.csv", list);
        let campaign = tracked(&folder);
        each(&campaign)
            .map(|tracked| tracked.expect("a run").impacts[0].verdict.clone())
            .collect()
    };
    // filmed at 1000 frames a second and played at 125: by gravity the sphere of 95 px has 1.5 px
    let slow = list.replace(",1000,20\n", ",125,\n");
    for verdict in verdicts(&slow) {
        let verdict = verdict.expect("it is questioned");
        verdict.says("sphere 1.5 px wide");
        verdict.says("frame_rate_Hz");
    }
    let (status, stdout, stderr) = folder.run("track recordings.csv --out runs.csv");
    assert_eq!(status, Some(1), "no run is left: {stderr}");
    assert!(stdout.contains("the spheres are then 1.5 px wide"), "{stdout}");
    // the same with the right rate, and with a scale that was measured
    let right = list.replace(",1000,20\n", ",1000,\n");
    assert!(verdicts(&right).iter().all(Option::is_none));
    let with_scale = list.replace(",1000,20\n", ",125,20\n");
    for verdict in verdicts(&with_scale) {
        let verdict = verdict.expect("it is refused");
        verdict.says("not 9.81");
        verdict.says("frame_rate_Hz would be 1000");
    }
    // one recording whose rate alone is wrong
    seen.truncate(1);
    let one = list.replacen(",1000,20\n", ",500,20\n", 1);
    let found = verdicts(&one);
    let verdict = found[0].as_ref().expect("it is refused");
    assert!(verdict.contains("frame_rate_Hz would be 1000"), "{verdict}");
    assert!(found[1..].iter().all(Option::is_none));
}

#[test]
fn a_diameter_that_its_scale_contradicts_is_questioned() {
    // of frames, where both are seen
    let scene = render::Scene {
        width: 80,
        height: 260,
        radius: 20.0,
        seed: seed_of("a_diameter_that_its_scale_contradicts_is_questioned"),
        ..render::Scene::default()
    };
    let sphere = fall(0.1, 0.8, 0.7);
    let folder = Folder::new();
    let centre = |frame: f64| (40.0, 235.0 - 5_000.0 * sphere.height(frame / 500.0));
    let frames = (0..100).map(|frame| render::render(&scene, centre, frame));
    render::tiff(&folder.join("drop.tif"), false, frames);
    let verdict = |diameter: &str| {
        let line = format!("drop.tif,PTFE,dry,{diameter},,500,5\n");
        let campaign = listed(&folder, ",scale_px_per_mm", &line);
        let tracked = campaign.outcomes[0].tracked.as_ref().expect("a run");
        tracked.impacts[0].verdict.clone()
    };
    assert_eq!(verdict("8"), None);
    let told = verdict("4").expect("it is questioned");
    told.says("by the sphere's diameter the scale is 10.");
    told.says("by the list 5");
}

/// Rows of heights, frame by frame, as a camera delivers them that now and then repeats a frame or loses some.
fn with_faults(heights: &[f64], faults: &[(usize, i32)]) -> Vec<f64> {
    let mut seen = vec![];
    for (frame, height) in heights.iter().enumerate() {
        // a fault is before a frame: so many are lost, or the one before is repeated so often
        let here: i32 = faults
            .iter()
            .filter(|(at, _)| *at == frame)
            .map(|(_, lost)| *lost)
            .sum();
        for _ in here..0 {
            seen.push(*seen.last().unwrap_or(height));
        }
        let lost = |(at, lost): &(usize, i32)| (*at..*at + (*lost).max(0) as usize).contains(&frame);
        if !faults.iter().any(lost) {
            seen.push(*height);
        }
    }
    seen
}

/// Tracks drops with faults of `faults`, a list of them each.
fn faulty_campaign(seen: &[Seen], faults: &[Vec<(usize, i32)>], rng: &mut ChaCha8Rng) -> (Folder, Campaign) {
    let folder = Folder::new();
    let mut lines = String::new();
    for (place, (seen, faults)) in seen.iter().zip(faults).enumerate() {
        let noise = |frame: usize| -> f64 {
            let height = seen.bounces.height(frame as f64 / CAMERA.frame_rate);
            PLATE_ROW - CAMERA.scale * height + 0.2 * normal(rng)
        };
        let rows: Vec<f64> = (0..(seen.until * CAMERA.frame_rate) as usize).map(noise).collect();
        let rows = with_faults(&rows, faults);
        folder.write(&format!("drop{place}.csv"), frames(rows.into_iter()));
        lines.push_str(&format!("drop{place}.csv,PTFE,dry,4.762,,1000,20\n"));
    }
    let campaign = listed(&folder, ",scale_px_per_mm", &lines);
    (folder, campaign)
}

#[test]
fn frames_that_are_repeated_or_missing_are_told_and_mended() {
    let mut rng = rng_of("frames_that_are_repeated_or_missing_are_told_and_mended");
    let seen = drops(60, &mut rng);
    // in the second half of the fall, where a frame is longer than any scatter, and soon after the contact
    let faults: Vec<Vec<(usize, i32)>> = (0..60)
        .map(|_| {
            let lost = (rng.random_range(30..38), rng.random_range(1..3));
            let repeated = (rng.random_range(46..54), -1);
            let later = (rng.random_range(75..80), 1);
            vec![lost, repeated, later]
        })
        .collect();
    let (folder, campaign) = faulty_campaign(&seen, &faults, &mut rng);
    let found = errors(&campaign, &seen);
    for (tracked, faults) in each(&campaign).zip(&faults) {
        let told: Vec<i32> = tracked.expect("a run").jumps.iter().map(|jump| jump.missing).collect();
        let made: Vec<i32> = faults.iter().map(|(_, lost)| *lost).collect();
        assert_eq!(told, made);
    }
    // what is left of them is far below what they do: 1 to 2 % of each speed
    for [error, sd] in &found.speeds {
        assert!(error.abs() < 0.004 && error.abs() < 3.0 * sd, "{error} {sd}");
    }
    let (_, _, stderr) = folder.run("track recordings.csv --out runs.csv --report out");
    let [(lost, count), (repeated, _), (later, _)] = faults[0][..] else {
        panic!("three faults")
    };
    // as they are numbered where they are gone
    let (repeated, later) = (repeated as i32 - count, later as i32 - count + 1);
    let told = format!(
        "line 2, drop0.csv: 1 frame is repeated (at {repeated}) and {} frames are missing (before {lost}, {later})",
        count + 1
    );
    assert!(stderr.contains(&told), "{told}\n{stderr}");
    let report = folder.read("out/report.md");
    assert!(report.contains("1 frame is repeated"), "{report}");
    // the planted fault: a camera without any is told nothing of it
    let none = vec![vec![]; 60];
    let (_folder, campaign) = faulty_campaign(&seen, &none, &mut rng);
    assert!(each(&campaign).all(|tracked| tracked.expect("a run").jumps.is_empty()));
}

#[test]
fn lost_frames_anywhere_are_covered_by_what_is_stated() {
    let mut rng = rng_of("lost_frames_anywhere_are_covered_by_what_is_stated");
    let seen = drops(200, &mut rng);
    let faults: Vec<Vec<(usize, i32)>> = (0..200)
        .map(|_| vec![(rng.random_range(30..58), 1), (rng.random_range(30..100), 1)])
        .collect();
    let (_folder, campaign) = faulty_campaign(&seen, &faults, &mut rng);
    let mut speeds = vec![];
    for (tracked, seen) in each(&campaign).zip(&seen) {
        // a recording may be left out for it, but not be wrong
        let Some(impact) = tracked
            .map(|tracked| &tracked.impacts[0])
            .filter(|of| of.verdict.is_none())
        else {
            continue;
        };
        speeds.extend(speed_errors(&impact.speeds, seen));
    }
    assert!(speeds.len() >= 340, "{}", speeds.len());
    let z = coverage_z(&speeds, 1.0);
    assert!(z > -4.0, "{z}");
}

/// Tracks drops that are seen over three contacts, of which the first lacks so many frames.
fn lost_at_the_contact(lost: i32, rng: &mut ChaCha8Rng) -> (Vec<Seen>, Folder, Campaign) {
    let mut seen = drops(40, rng);
    for seen in &mut seen {
        seen.until = seen.bounces.second_contact() + 0.08;
    }
    let at = |seen: &Seen| vec![((1000.0 * seen.bounces.contact) as usize - lost as usize / 2, lost)];
    let faults: Vec<Vec<(usize, i32)>> = seen.iter().map(at).collect();
    let (folder, campaign) = faulty_campaign(&seen, &faults, rng);
    (seen, folder, campaign)
}

#[test]
fn frames_lost_at_the_contact_are_seen_by_its_height() {
    let mut rng = rng_of("frames_lost_at_the_contact_are_seen_by_its_height");
    let apart = |campaign: &Campaign| -> usize {
        each(campaign)
            .filter(|tracked| tracked.is_some_and(|tracked| tracked.impacts[0].apart.is_some()))
            .count()
    };
    let (seen, folder, campaign) = lost_at_the_contact(3, &mut rng);
    assert!(apart(&campaign) >= 38, "{}", apart(&campaign));
    // both speeds are too small by what their sd says, together
    let mut used = 0;
    for (tracked, seen) in each(&campaign).zip(&seen) {
        let impact = &tracked.expect("a run").impacts[0];
        if impact.apart.is_none() || impact.verdict.is_some() {
            continue;
        }
        used += 1;
        let errors = speed_errors(&impact.speeds, seen).map(|[error, sd]| error / sd);
        assert!(errors.iter().all(|error| (-1.2..-0.8).contains(error)), "{errors:?}");
        assert!(impact.speeds.correlation > 0.9, "{}", impact.speeds.correlation);
    }
    assert!((5..38).contains(&used), "{used}");
    let (_, _, stderr) = folder.run("track recordings.csv --out runs.csv --report out");
    stderr.says("mm from the height of the other contacts or of the sphere at rest: frames are missing");
    let runs = folder.read("runs.csv");
    runs.says("which puts its rebound speed in doubt by");
    // the planted fault: with all frames nothing is told
    let (_, _folder, campaign) = lost_at_the_contact(0, &mut rng);
    assert_eq!(apart(&campaign), 0);
}

/// The outcome of a sphere that is held, falls and bounces, of which some frames are not seen.
fn seen_but_for(lost: std::ops::Range<usize>, rng: &mut ChaCha8Rng) -> Result<Tracked, Refusal> {
    let bounces = fall(0.250, 1.0, 0.8);
    let held = bounces.contact - bounces.impact_speed / GRAVITY;
    let row =
        |frame: usize, noise: f64| 900.0 - CAMERA.scale * bounces.height((1e-3 * frame as f64).max(held)) + 0.2 * noise;
    let rows = (0..620).map(|frame| (frame, row(frame, normal(rng))));
    let rows = rows.filter(|(frame, _)| !lost.contains(frame));
    let rows: String = rows.map(|(frame, row)| format!("{frame},{row:.3}\n")).collect();
    let folder = Folder::new();
    folder.write("drop.csv", format!("frame,y_px\n{rows}"));
    let mut campaign = listed(&folder, ",scale_px_per_mm", "drop.csv,PTFE,dry,4.762,,1000,20\n");
    campaign.outcomes.remove(0).tracked
}

#[test]
fn a_contact_that_nobody_saw_gives_no_run() {
    let mut rng = rng_of("a_contact_that_nobody_saw_gives_no_run");
    let verdict = |lost, rng: &mut ChaCha8Rng| seen_but_for(lost, rng).expect("two flights").impacts[0].verdict.clone();
    assert_eq!(verdict(0..0, &mut rng), None);
    assert_eq!(verdict(248..253, &mut rng), None);
    // the first and the second contact
    let told = verdict(240..430, &mut rng).expect("left out");
    told.says("nothing is seen for 190 ms about its contact");
    // the whole fall: what is seen first is the rise after it
    let reason = seen_but_for(146..256, &mut rng).expect_err("no fall is seen");
    reason.words().says("begins with a");
}

#[test]
fn frames_at_uneven_times_are_left_out_with_the_true_reason() {
    let mut rng = rng_of("frames_at_uneven_times_are_left_out_with_the_true_reason");
    let seen = &drops(1, &mut rng)[0];
    let folder = Folder::new();
    // after frame 40 two and a half are missing, and in another recording every eighth is repeated
    let late = |frame: usize| frame as f64 + if frame < 40 { 0.0 } else { 2.5 };
    let often = |frame: usize| (frame - frame / 8) as f64;
    let rows = |time: &dyn Fn(usize) -> f64| -> String {
        let row = |frame: usize| 900.0 - CAMERA.scale * seen.bounces.height(time(frame) / CAMERA.frame_rate);
        let rows = (0..(seen.until * CAMERA.frame_rate) as usize).map(|frame| format!("{frame},{:.1}\n", row(frame)));
        format!("frame,y_px\n{}", rows.collect::<String>())
    };
    folder.write("late.csv", rows(&late));
    folder.write("often.csv", rows(&often));
    let lines = "late.csv,PTFE,dry,4.762,,1000,20\noften.csv,PTFE,dry,4.762,,1000,20\n";
    let campaign = listed(&folder, ",scale_px_per_mm", lines);
    let reasons = campaign
        .outcomes
        .iter()
        .map(|outcome| outcome.tracked.as_ref().expect_err("left out").words());
    let reasons: Vec<&str> = reasons.collect();
    reasons[0].says("torn in two, and not by whole frames");
    reasons[1].says("more than one frame in twelve is repeated or missing");
}

#[test]
fn a_sphere_that_rests_long_is_no_fall() {
    let mut rng = rng_of("a_sphere_that_rests_long_is_no_fall");
    // a video's pictures hardly change at rest, and are corrected now and then: positions scatter less, and drift
    let sphere = fall(0.5, 0.9, 0.0);
    let folder = Folder::new();
    for (name, start) in [("long_before", 0.0), ("long_after", 0.4)] {
        let rows = (0..400).map(|frame| {
            let noise = normal(&mut rng);
            let time = start + frame as f64 / 500.0;
            let height = sphere.height(time);
            let sd = if height == sphere.height(time + 0.002) {
                0.004
            } else {
                0.1
            };
            let drift = 0.12 * (frame as f64 / 40.0).sin();
            900.0 - 8_000.0 * height + drift + sd * noise
        });
        folder.write(&format!("{name}.csv"), frames(rows));
    }
    let lines = "long_before.csv,PTFE,dry,4.762,,500\nlong_after.csv,PTFE,dry,4.762,,500\n";
    for tracked in each(&listed(&folder, "", lines)) {
        let impact = &tracked.expect("a run").impacts[0];
        let off = impact.speeds.impact_speed / 0.9 - 1.0;
        assert!(impact.stuck && off.abs() < 0.01, "{impact:?}");
    }
}

#[test]
fn of_several_objects_the_one_that_falls_is_taken() {
    let mut rng = rng_of("of_several_objects_the_one_that_falls_is_taken");
    let sphere = fall(0.2, 1.1, 0.7);
    let mut text = "frame,y_px,object\n".to_owned();
    let mut with_second = text.clone();
    for frame in 0..300 {
        let mut noise = |sd: f64| sd * normal(&mut rng);
        let time = f64::from(frame) / 1000.0;
        let drop = 900.0 - 5_000.0 * sphere.height(time) + noise(0.1);
        // a still speck moves farther in all than the drop, and its mirror image moves as far
        let speck = 200.0 + noise(7.0);
        let image = 900.0 + 5_000.0 * sphere.height(time) + noise(0.1);
        let rows = format!("{frame},{drop},7\n{frame},{speck},1\n{frame},{image},9\n");
        text.push_str(&rows);
        with_second.push_str(&rows);
        let second = 880.0 - 4_000.0 * sphere.height(time + 0.01);
        with_second.push_str(&format!("{frame},{second},8\n"));
    }
    let folder = Folder::new();
    let taken = |text: &str| {
        folder.write("drop.csv", text);
        let campaign = listed(&folder, "", "drop.csv,PTFE,dry,4.762,,1000\n");
        let outcome = &campaign.outcomes[0];
        let speeds = outcome.tracked.as_ref().expect("a run").impacts[0].speeds;
        assert!((speeds.impact_speed - 1.1).abs() < 0.01, "{speeds:?}");
        let object = outcome.shown.as_ref().and_then(|shown| shown.object.clone());
        (object, campaign.notices.len())
    };
    assert_eq!(taken(&text), (Some("7".to_owned()), 0));
    // of two that fall the choice is told
    assert_eq!(taken(&with_second), (Some("7".to_owned()), 1));
}

#[test]
fn tables_of_other_programs_are_read() {
    let sphere = fall(0.1, 1.0, 0.6);
    let rows = |row: &dyn Fn(usize, f64) -> String| -> String {
        (0..200)
            .map(|frame| row(frame, sphere.height(frame as f64 / 1000.0)) + "\n")
            .collect()
    };
    let comma = |x: f64| format!("{x:.5}").replace('.', ",");
    let in_seconds = |frame: usize| frame as f64 / 1000.0;
    let tracker = rows(&|frame, height| format!("{}\t{}\t{}", in_seconds(frame), 0.001, height));
    let tracker_de = rows(&|frame, height| format!("{}\t0,001\t{}", comma(in_seconds(frame)), comma(height)));
    let trackpy = rows(&|frame, height| format!("{frame},{},88.2,5021.1,{frame},0", 900.0 - 20_000.0 * height));
    let trackmate = rows(&|frame, height| format!("ID{frame},0,{},{frame}", 95.0 - 1e3 * height));
    let folder = Folder::new();
    for (file, text, unit, axis) in [
        ("mass A.txt", format!("mass A\t\t\nt\tx\ty\n{tracker}"), "m", ""),
        ("a(1).txt", format!("Masse A\t\t\nt\tx\ty\n{tracker_de}"), "m", ""),
        ("v=0.5.csv", format!(",y,x,mass,frame,particle\n{trackpy}"), "px", ""),
        (
            "spots.csv",
            format!("LABEL,TRACK_ID,POSITION_Y,FRAME\nLabel,Track ID,Y,Frame\n,,(mm),\n{trackmate}"),
            "mm",
            "down",
        ),
    ] {
        folder.write(file, text);
        let line = format!("\"{file}\",PTFE,dry,4.762,,1000,{unit},{axis}\n");
        let campaign = listed(&folder, ",y_unit,y_axis", &line);
        let outcome = campaign.outcomes[0].tracked.as_ref();
        let speeds = outcome.unwrap_or_else(|reason| panic!("{file}: {reason:?}")).impacts[0].speeds;
        let off = [speeds.impact_speed - 1.0, speeds.rebound_speed - 0.6];
        assert!(off.iter().all(|off| off.abs() < 0.003), "{file}: {off:?}");
    }
}

/// What follows detection, attacked: whatever a table holds, runs that are written are such as `check` takes.
#[test]
fn whatever_was_seen_the_runs_are_ones_that_check_takes() {
    /// scenes of motion, of which each has tables
    const ROUNDS: usize = 50;
    let mut rng = rng_of("whatever_was_seen_the_runs_are_ones_that_check_takes");
    let folder = Folder::new();
    let write = |name: &str, text: &str| folder.write(name, text);
    let scene = "[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
                 [liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
    write("scene.toml", scene);
    let mut used = 0;
    for round in 0..ROUNDS {
        let mut lines = String::new();
        for place in 0..4 {
            let bounces = Bounces {
                contact: rng.random_range(0.0..0.3),
                impact_speed: 10f64.powf(rng.random_range(-2.0..1.5)),
                // some gain speed, as no sphere does
                restitution: rng.random_range(0.0..0.95),
            };
            let kick = if rng.random_bool(0.2) {
                rng.random_range(1.0..3.0)
            } else {
                1.0
            };
            // most fall at another rate than things do, which leaves them out
            let scale = if rng.random_bool(0.3) {
                1.0
            } else {
                10f64.powf(rng.random_range(-3.0..7.0))
            };
            let rate = 10f64.powf(rng.random_range(1.0..4.5));
            let noise = 10f64.powf(rng.random_range(-4.0..-0.5)) * bounces.impact_speed.powi(2) / 20.0;
            let mut text = "frame,y_m\n".to_owned();
            for frame in 0..rng.random_range(5..400) {
                if rng.random_bool(0.02) {
                    continue;
                }
                let time = f64::from(frame) / rate;
                let mut height = bounces.height(time);
                if time > bounces.contact {
                    height *= kick;
                }
                let normal = normal(&mut rng);
                height += noise * normal;
                if rng.random_bool(0.01) {
                    height *= rng.random_range(-2.0..2.0);
                }
                text.push_str(&format!("{frame},{:e}\n", scale * height));
            }
            write(&format!("drop{place}.csv"), &text);
            let (liquid, film) = if rng.random_bool(0.5) {
                ("AK10", format!("{}", 10f64.powf(rng.random_range(1.0..4.5))))
            } else {
                ("dry", String::new())
            };
            let more = if rng.random_bool(0.5) { "2150" } else { "" };
            lines.push_str(&format!("drop{place}.csv,PTFE,{liquid},4.762,{film},{rate},{more}\n"));
        }
        // the last is a good one, of which every table has a run
        let good = fall(0.1, 1.0, 0.6);
        let rows = (0..200).map(|frame| format!("{frame},{:.6}\n", good.height(f64::from(frame) / 1000.0)));
        write("good.csv", &format!("frame,y_m\n{}", rows.collect::<String>()));
        lines.push_str("good.csv,PTFE,dry,4.762,,1000,\n");
        write("recordings.csv", &format!("{HEADER},density_kg_m3\n{lines}"));
        let more = if round % 2 == 0 { "--all-rebounds" } else { "" };
        let (status, stdout, stderr) = folder.run(&format!(
            "track recordings.csv --out runs.csv --report out --force {more}"
        ));
        assert!(matches!(status, Some(0 | 1)), "{round}: {stderr}");
        let told = [stdout, folder.read("out/report.md")];
        assert!(
            told.iter().all(|text| !text.contains("NaN") && !text.contains("inf ")),
            "{told:?}"
        );
        let (status, _, stderr) = folder.run("check scene.toml");
        let runs = folder.read("runs.csv");
        assert!(matches!(status, Some(0 | 1)), "{round}: {stderr}\n{runs}");
        used += runs.lines().filter(|line| line.ends_with(',')).count();
    }
    assert!(used > ROUNDS, "{used}");
}

#[test]
fn damaged_tables_do_no_harm() {
    let mut rng = rng_of("damaged_tables_do_no_harm");
    let seen = drops(2, &mut rng);
    let folder = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let [path, table] = ["recordings.csv", "drop1.csv"].map(|name| folder.join(name));
    let originals = [
        std::fs::read(&path).expect("readable"),
        std::fs::read(&table).expect("readable"),
    ];
    let mut refused = 0;
    for round in 0..600 {
        let which = round % 2;
        let mut bytes = originals[which].clone();
        for _ in 0..rng.random_range(1..8) {
            let at = rng.random_range(0..bytes.len());
            match rng.random_range(0..4) {
                0 => bytes[at] = rng.random(),
                1 => bytes[at] = b"0123456789.,-e\n\t; nN"[rng.random_range(0..20)],
                2 => bytes.truncate(at.max(1)),
                _ => bytes.insert(at, b"9e,-\n"[rng.random_range(0..5)]),
            }
        }
        std::fs::write([&path, &table][which], &bytes).expect("writable");
        // whatever it is: numbers that are some, or a message
        let options = TrackOptions {
            axis: None,
            all_rebounds: round % 3 == 0,
        };
        match track(&path, options, &|_| ()) {
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
            Ok(campaign) => {
                for impact in each(&campaign).flatten().flat_map(|tracked| &tracked.impacts) {
                    let of = &impact.speeds;
                    let numbers = [
                        of.impact_speed,
                        of.impact_speed_sd,
                        of.rebound_speed,
                        of.rebound_speed_sd,
                        of.correlation,
                    ];
                    assert!(numbers.iter().all(|number| number.is_finite()), "{impact:?}");
                }
            }
        }
        std::fs::write([&path, &table][which], &originals[which]).expect("writable");
    }
    assert!((50..550).contains(&refused), "{refused}");
}

/// A light sphere in air, step by step: heights over the plate, frame by frame, until the second contact; v and v_r.
fn in_air(height: f64, restitution: f64, density: f64) -> (Vec<f64>, [f64; 2]) {
    let (diameter, step) = (3.175e-3, 2e-6);
    // by Schiller & Naumann, written once more
    let drag = |speed: f64| {
        let reynolds: f64 = speed * diameter / 1.516e-5;
        0.75 * 1.204 / density / diameter * speed * speed * 24.0 / reynolds.max(1e-9)
            * (1.0 + 0.15 * reynolds.powf(0.687))
    };
    let (mut y, mut velocity, mut time) = (height, 0.0f64, 0.0);
    let (mut heights, mut speeds) = (vec![], vec![]);
    loop {
        if time * 1000.0 >= heights.len() as f64 {
            heights.push(y);
        }
        velocity -= step * (GRAVITY + drag(velocity.abs()).copysign(velocity));
        y += step * velocity;
        time += step;
        if y < 0.0 {
            if speeds.len() == 2 {
                return (heights, [speeds[0], speeds[1]]);
            }
            speeds.extend([-velocity, -restitution * velocity]);
            (y, velocity) = (0.0, -restitution * velocity);
        }
    }
}

#[test]
fn what_the_air_takes_is_taken_off_where_the_density_is_known() {
    let mut rng = rng_of("what_the_air_takes_is_taken_off_where_the_density_is_known");
    let folder = Folder::new();
    let mut truths = vec![];
    for place in 0..10 {
        let (heights, truth) = in_air(0.03 + 0.01 * f64::from(place), 0.75, 940.0);
        let rows = heights
            .iter()
            .map(|height| PLATE_ROW - height * CAMERA.scale + 0.1 * normal(&mut rng));
        folder.write(&format!("drop{place}.csv"), frames(rows));
        truths.push(truth);
    }
    let largest_error = |scale: &str, density: &str| {
        let lines = (0..10).map(|place| format!("drop{place}.csv,PE,dry,3.175,,1000,{scale},{density}\n"));
        let lines: String = lines.collect();
        let campaign = listed(&folder, ",scale_px_per_mm,density_kg_m3", &lines);
        let error = |(tracked, truth): (Option<&Tracked>, &[f64; 2])| {
            let of = tracked.expect("a run").impacts[0].speeds;
            if !density.is_empty() && !scale.is_empty() {
                // what is left lies inside what is stated
                let errors = [of.impact_speed - truth[0], of.rebound_speed - truth[1]];
                let within = errors[0].abs() < of.impact_speed_sd && errors[1].abs() < of.rebound_speed_sd;
                assert!(within, "{of:?} {truth:?}");
            }
            (of.rebound_speed / of.impact_speed - truth[1] / truth[0]).abs()
        };
        each(&campaign).zip(&truths).map(error).fold(0.0, f64::max)
    };
    assert!(largest_error("20", "940") < 1e-4);
    assert!(largest_error("", "940") < 1e-4);
    // the planted fault: air that nobody takes off
    let left = largest_error("20", "");
    assert!((0.01..0.02).contains(&left), "{left}");
}
