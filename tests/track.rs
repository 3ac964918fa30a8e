//! Holds what `track` makes of positions against flights that are known.

mod common;
mod flight;

use std::path::{Path, PathBuf};

use common::{binomial_z, mean, seed_of, wetcor};
use flight::{Bounces, GRAVITY};
use nalgebra::DMatrix;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use tempfile::TempDir;
use wetcor::recordings::{track, Campaign, Refusal, TrackOptions, Tracked};

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
        let noise: f64 = StandardNormal.sample(rng);
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
fn written(all: &[Seen], camera: Camera, more: &str, rng: &mut ChaCha8Rng) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut list = format!("{HEADER},{more}\n");
    for (place, seen) in all.iter().enumerate() {
        let name = format!("drop{place}.csv");
        std::fs::write(folder.path().join(&name), positions(seen, camera, rng)).expect("writable");
        list.push_str(&format!("{name},PTFE,dry,4.762,,{},{}\n", camera.frame_rate, seen.more));
    }
    let path = folder.path().join("recordings.csv");
    std::fs::write(&path, list).expect("writable");
    (folder, path)
}

fn tracked(path: &Path) -> Campaign {
    track(path, TrackOptions::default(), &|_| ()).unwrap_or_else(|error| panic!("{error}"))
}

fn each(campaign: &Campaign) -> impl Iterator<Item = Option<&Tracked>> {
    campaign.outcomes.iter().map(|outcome| outcome.tracked.as_ref().ok())
}

/// Errors of v and v_r, each with the sd that is stated; of e; all runs are there.
struct Errors {
    speeds: Vec<[f64; 2]>,
    restitution: Vec<f64>,
}

fn errors(campaign: &Campaign, all: &[Seen]) -> Errors {
    let mut errors = Errors {
        speeds: vec![],
        restitution: vec![],
    };
    for (tracked, seen) in each(campaign).zip(all) {
        let impact = &tracked.expect("it gives a run").impacts[0];
        assert_eq!((impact.stuck, &impact.verdict), (false, &None));
        let (of, v) = (&impact.speeds, seen.bounces.impact_speed);
        let v_r = seen.bounces.restitution * v;
        errors.speeds.push([of.impact_speed - v, of.impact_speed_sd]);
        errors.speeds.push([of.rebound_speed - v_r, of.rebound_speed_sd]);
        errors
            .restitution
            .push(of.rebound_speed / of.impact_speed - seen.bounces.restitution);
    }
    errors
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
    const NAME: &str = "speeds_are_as_good_as_they_can_be_and_their_sds_cover";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let (mut all, mut bound, mut restitution) = (vec![], vec![], vec![]);
    for _ in 0..20 {
        let seen = drops(20, &mut rng);
        let (_folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
        let found = errors(&tracked(&path), &seen);
        bound.extend(bounds(&seen, CAMERA));
        all.extend(found.speeds);
        restitution.extend(found.restitution);
    }
    // an error beside the bound has a mean square of 1 where the bound is met
    let square = |(error, bound): (&[f64; 2], &f64)| (error[0] / bound).powi(2);
    let beside = (all.iter().zip(&bound).map(square).sum::<f64>() / all.len() as f64).sqrt();
    println!("{beside:.3} of the bound");
    assert!((0.9..1.3).contains(&beside), "{beside} of the bound");
    let z = binomial_z(covered(&all, 1.959_963_985), all.len(), 0.95);
    assert!(z.abs() < 4.0, "{z}");
    // the planted fault: sds a quarter too small
    let z = binomial_z(covered(&all, 0.75 * 1.959_963_985), all.len(), 0.95);
    assert!(z < -4.0, "{z}");
    let (bias, se) = mean(&restitution);
    assert!(bias.abs() < 0.001 && bias.abs() < 4.0 * se, "{bias} {se}");
}

#[test]
fn missing_frames_and_other_objects_cost_no_truth() {
    const NAME: &str = "missing_frames_and_other_objects_cost_no_truth";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let camera = Camera {
        missing: 0.1,
        wrong: 0.03,
        ..CAMERA
    };
    let seen = drops(300, &mut rng);
    let (_folder, path) = written(&seen, camera, "scale_px_per_mm", &mut rng);
    let found = errors(&tracked(&path), &seen);
    let z = binomial_z(covered(&found.speeds, 1.959_963_985), found.speeds.len(), 0.95);
    assert!(z.abs() < 4.0, "{z}");
    let (bias, _) = mean(&found.restitution);
    assert!(bias.abs() < 0.001, "{bias}");
}

#[test]
fn a_scale_that_nobody_measured_is_that_of_gravity() {
    const NAME: &str = "a_scale_that_nobody_measured_is_that_of_gravity";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let mut seen = drops(60, &mut rng);
    seen.iter_mut().for_each(|seen| seen.more = String::new());
    let (_folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&path);
    assert_eq!(campaign.gravity.measured, None);
    let [scale, se] = campaign.gravity.scale.expect("the scale of all");
    assert!(
        (scale - CAMERA.scale).abs() < 4.0 * se && se < 1e-3 * scale,
        "{scale} {se}"
    );
    let (bias, _) = mean(&errors(&campaign, &seen).restitution);
    assert!(bias.abs() < 0.001, "{bias}");
}

#[test]
fn what_falls_at_another_rate_is_left_out_with_the_reason() {
    const NAME: &str = "what_falls_at_another_rate_is_left_out_with_the_reason";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let mut seen = drops(12, &mut rng);
    // a scale that is 10 % off
    seen[4].more = "22".to_owned();
    let (_folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&path);
    for (place, tracked) in each(&campaign).enumerate() {
        let verdict = &tracked.expect("a run").impacts[0].verdict;
        assert_eq!(verdict.is_some(), place == 4, "{place}: {verdict:?}");
    }
    let gravity = campaign.gravity.measured.expect("scales are measured");
    assert!((gravity.value / GRAVITY - 1.0).abs() < 0.002, "{gravity:?}");
    // all of them
    seen.iter_mut().for_each(|seen| seen.more = "22".to_owned());
    let (_folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&path);
    let verdicts = each(&campaign).map(|tracked| tracked.expect("a run").impacts[0].verdict.clone());
    assert!(verdicts
        .into_iter()
        .all(|verdict| verdict.is_some_and(|reason| reason.contains("not 9.81"))));
}

#[test]
fn a_sphere_that_stays_is_a_run_that_stuck() {
    const NAME: &str = "a_sphere_that_stays_is_a_run_that_stuck";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let mut seen = drops(40, &mut rng);
    for seen in &mut seen[..20] {
        seen.bounces.restitution = 0.0;
        seen.until = 0.4;
    }
    let (_folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&path);
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
    const NAME: &str = "a_recording_is_refused_by_name_and_never_in_silence";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let mut seen = drops(5, &mut rng);
    seen[1].until = seen[1].bounces.contact - 0.004;
    seen[3].until = seen[3].bounces.contact + 0.002;
    let (folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let campaign = tracked(&path);
    let refused = campaign.outcomes.iter().map(|outcome| outcome.tracked.is_err());
    assert_eq!(refused.collect::<Vec<_>>(), [false, true, false, true, false]);
    let (status, stdout, stderr) = wetcor(
        folder.path(),
        &["track", "recordings.csv", "--out", "runs.csv", "--report", "out"],
    );
    assert_eq!(status, Some(0), "{stderr}");
    assert!(
        stdout.starts_with("5 recordings: 3 runs, 0 of them stuck; 2 left out with a reason\n"),
        "{stdout}"
    );
    for line in [3, 5] {
        assert!(
            stderr.contains(&format!("line {line}, drop{}.csv: ", line - 2)),
            "{stderr}"
        );
    }
    let runs = std::fs::read_to_string(folder.path().join("runs.csv")).expect("written");
    assert_eq!(runs.lines().count(), 6);
    let report = std::fs::read_to_string(folder.path().join("out/report.md")).expect("written");
    assert!(report.contains("it ends before the sphere has rebounded"), "{report}");
    // the list may say so itself, and then nothing of it is read
    let list = std::fs::read_to_string(&path).expect("readable");
    let mut lines: Vec<String> = list.lines().map(|line| format!("{line},")).collect();
    lines[0] = lines[0].replace(",scale_px_per_mm,", ",scale_px_per_mm,exclude");
    lines[2] = "no_such_file.csv,PTFE,dry,4.762,,1000,,lens cap on".to_owned();
    std::fs::write(&path, lines.join("\n")).expect("writable");
    let campaign = tracked(&path);
    assert_eq!(
        campaign.outcomes[1].tracked,
        Err(Refusal::Excluded("lens cap on".to_owned()))
    );
}

/// A list or a table that cannot be used, and what is said of it.
#[test]
fn bad_input_is_named_by_its_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("writable");
    let rows = |height: &dyn Fn(usize) -> f64| -> String {
        let rows = (0..600).map(|frame| format!("{frame},{}\n", height(frame)));
        format!("frame,y_px\n{}", rows.collect::<String>())
    };
    let sphere = Bounces {
        contact: 0.06,
        impact_speed: 1.2,
        restitution: 0.7,
    };
    let seen = |frame: usize| 900.0 - 20_000.0 * sphere.height(frame as f64 / 1000.0);
    write("good.csv", &rows(&seen));
    write("still.csv", &rows(&|frame| 400.0 + (frame % 3) as f64 * 0.1));
    write("up.csv", &rows(&|frame| -seen(frame)));
    write("twice.csv", "frame,y_px\n1,5\n1,6\n");
    write("words.csv", "frame,y_px\n1,high\n");
    write("header.csv", "frame,z\n1,2\n");
    write("none.csv", "frame,y_px\n");
    let header = "file,particle,liquid,diameter_mm,film_um,frame_rate_Hz\n";
    for (lines, expected) in [
        ("", "no recordings below the header"),
        (
            "good.csv,PTFE,dry,4.762,,1000\nstill.csv,PTFE,dry,4.762,,1000\n",
            "line 3, still.csv: nothing falls in it",
        ),
        ("up.csv,PTFE,dry,4.762,,1000\n", "line 2, up.csv: it falls upwards"),
        (
            "twice.csv,PTFE,dry,4.762,,1000\n",
            "line 3: the frame of line 2 has another position",
        ),
        (
            "words.csv,PTFE,dry,4.762,,1000\n",
            "line 2, y_px: found `high`, expected a number",
        ),
        ("header.csv,PTFE,dry,4.762,,1000\n", "expected one column of heights"),
        ("none.csv,PTFE,dry,4.762,,1000\n", "no positions below the header"),
        ("missing.csv,PTFE,dry,4.762,,1000\n", "line 2, missing.csv"),
        ("good.csv,PTFE,dry,4.762,,\n", "frame_rate_Hz"),
        (
            "good.csv,PTFE,AK10,4.762,,1000\n",
            "line 2, film: expected a number above 0",
        ),
        (
            "good.csv,PTFE,dry,-4,,1000\n",
            "line 2, diameter_mm: found `-4`, expected a number above 0",
        ),
        ("good.csv,PT FE,dry,4.762,,1000\n", "line 2, particle: found `PT FE`"),
        (",PTFE,dry,4.762,,1000\n", "line 2, file: expected a folder of frames"),
        (
            "good.csv,PTFE,dry,4.762,,1000\ngood.csv,PTFE,dry,4.762,,1000\n",
            "line 3, run: found `good.csv`, expected another name than that of line 2",
        ),
    ] {
        write("recordings.csv", &format!("{header}{lines}"));
        let (status, stdout, stderr) = wetcor(folder.path(), &["track", "recordings.csv", "--out", "runs.csv"]);
        assert_eq!((status, stdout.as_str()), (Some(2), ""), "{lines}{stderr}");
        assert!(stderr.contains(expected), "{lines}{stderr}");
        assert!(!folder.path().join("runs.csv").exists(), "{lines}");
    }
    for (text, expected) in [
        (
            "particle,diameter_mm\nPTFE,4\n",
            "line 1, header: expected a column `file`",
        ),
        (
            "file,particle,diametre_mm\ngood.csv,PTFE,4\n",
            "found `diametre_mm`, expected `diameter_mm`",
        ),
        (
            "file,particle,diameter_mm,diameter_m\ngood.csv,PTFE,4,4\n",
            "`diameter_mm` is there already",
        ),
    ] {
        write("recordings.csv", text);
        let (status, _, stderr) = wetcor(folder.path(), &["track", "recordings.csv", "--out", "runs.csv"]);
        assert_eq!(status, Some(2), "{stderr}");
        assert!(stderr.contains(expected), "{text}{stderr}");
    }
    write("recordings.csv", &format!("{header}good.csv,PTFE,dry,4.762,,1000\n"));
    let track = |more: &[&str]| {
        let words: Vec<&str> = ["track", "recordings.csv"].iter().chain(more).copied().collect();
        wetcor(folder.path(), &words)
    };
    for (more, expected) in [
        (["--out", "runs.txt"], "expected a file ending in .csv"),
        (["--out", "recordings.csv"], "exists"),
        (["--out", "none/runs.csv"], "there is no folder none"),
    ] {
        let (status, _, stderr) = track(&more);
        assert!(status == Some(2) && stderr.contains(expected), "{more:?}{stderr}");
    }
    assert!(track(&["--out", "recordings.csv", "--force"])
        .2
        .contains("is the list of recordings"));
    assert_eq!(track(&["--out", "runs.csv"]).0, Some(0));
    assert!(track(&["--out", "runs.csv"]).2.contains("--force replaces it"));
    assert_eq!(track(&["--out", "runs.csv", "--force", "--all-rebounds"]).0, Some(0));
    let runs = std::fs::read_to_string(folder.path().join("runs.csv")).expect("written");
    assert!(runs.contains("good.csv rebound 2,"), "{runs}");
}

#[test]
fn damaged_tables_do_no_harm() {
    const NAME: &str = "damaged_tables_do_no_harm";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let seen = drops(2, &mut rng);
    let (folder, path) = written(&seen, CAMERA, "scale_px_per_mm", &mut rng);
    let table = folder.path().join("drop1.csv");
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
        match track(
            &path,
            TrackOptions {
                axis: None,
                all_rebounds: round % 3 == 0,
            },
            &|_| (),
        ) {
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
    const NAME: &str = "what_the_air_takes_is_taken_off_where_the_density_is_known";
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut truths = vec![];
    for place in 0..10 {
        let (heights, truth) = in_air(0.03 + 0.01 * f64::from(place), 0.75, 940.0);
        let row = |(frame, height): (usize, &f64)| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            format!("{frame},{}\n", PLATE_ROW - height * CAMERA.scale + 0.1 * noise)
        };
        let rows: String = heights.iter().enumerate().map(row).collect();
        std::fs::write(
            folder.path().join(format!("drop{place}.csv")),
            format!("frame,y_px\n{rows}"),
        )
        .expect("writable");
        truths.push(truth);
    }
    let path = folder.path().join("recordings.csv");
    let largest_error = |scale: &str, density: &str| {
        let lines = (0..10).map(|place| format!("drop{place}.csv,PE,dry,3.175,,1000,{scale},{density}\n"));
        let lines: String = lines.collect();
        std::fs::write(&path, format!("{HEADER},scale_px_per_mm,density_kg_m3\n{lines}")).expect("writable");
        let campaign = tracked(&path);
        let error = |(tracked, truth): (Option<&Tracked>, &[f64; 2])| {
            let of = tracked.expect("a run").impacts[0].speeds;
            if !density.is_empty() && !scale.is_empty() {
                // what is left lies inside what is stated
                assert!(
                    (of.impact_speed - truth[0]).abs() < of.impact_speed_sd,
                    "{of:?} {truth:?}"
                );
                assert!(
                    (of.rebound_speed - truth[1]).abs() < of.rebound_speed_sd,
                    "{of:?} {truth:?}"
                );
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
