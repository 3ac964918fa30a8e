//! Holds what `track` makes of positions against flights that are known.

use crate::common::scenes::{scene_of, AK10, PTFE};
use crate::common::{binomial_z, in_project, mean, normal, seed_of, Folder, Place, Says};
use crate::flight::{Bounces, GRAVITY};
use crate::render;
use nalgebra::DMatrix;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::path::Path;
use wetcor::recordings::{track, Campaign, ContactSpeeds, Impact, Refusal, TrackOptions, Tracked};

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
    /// its scale in px/mm, as the list has it
    scale: String,
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
            scale: "20".to_owned(),
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
fn written(all: &[Seen], camera: Camera, rng: &mut ChaCha8Rng) -> Folder {
    let folder = Folder::new();
    let mut list = format!("{HEADER},scale_px_per_mm\n");
    for (place, seen) in all.iter().enumerate() {
        let name = format!("drop{place}.csv");
        folder.write(&name, positions(seen, camera, rng));
        list.push_str(&format!(
            "{name},PTFE,dry,4.762,,{},{}\n",
            camera.frame_rate, seen.scale
        ));
    }
    folder.write("recordings.csv", list);
    folder
}

fn tracked(folder: impl AsRef<Path>) -> Campaign {
    let list = folder.as_ref().join("recordings.csv");
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

/// What is printed of recordings that leave no run.
fn printed_without_runs(folder: &Folder) -> String {
    let (status, stdout, stderr) = folder.run("track recordings.csv --out runs.csv");
    assert_eq!(status, Some(1), "no run is left: {stderr}");
    stdout
}

/// The first impact of each recording, all of which give one.
fn impacts(campaign: &Campaign) -> Vec<&Impact> {
    each(campaign)
        .map(|tracked| &tracked.expect("a run").impacts[0])
        .collect()
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

/// The same of all recordings, and the errors of e.
fn errors(campaign: &Campaign, all: &[Seen]) -> (Vec<[f64; 2]>, Vec<f64>) {
    let (mut speeds, mut restitution) = (vec![], vec![]);
    for (impact, seen) in impacts(campaign).into_iter().zip(all) {
        assert_eq!((impact.stuck, &impact.verdict), (false, &None));
        let of = &impact.speeds;
        speeds.extend(speed_errors(of, seen));
        restitution.push(of.rebound_speed / of.impact_speed - seen.bounces.restitution);
    }
    (speeds, restitution)
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
        let folder = written(&seen, CAMERA, &mut rng);
        let (speeds, restitutions) = errors(&tracked(&folder), &seen);
        bound.extend(bounds(&seen, CAMERA));
        all.extend(speeds);
        restitution.extend(restitutions);
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
    let folder = written(&seen, camera, &mut rng);
    let (speeds, restitutions) = errors(&tracked(&folder), &seen);
    let z = coverage_z(&speeds, 1.0);
    assert!(z.abs() < 4.0, "{z}");
    let (bias, _) = mean(&restitutions);
    assert!(bias.abs() < 0.001, "{bias}");
}

#[test]
fn a_scale_that_nobody_measured_is_that_of_gravity() {
    let mut rng = rng_of("a_scale_that_nobody_measured_is_that_of_gravity");
    let mut seen = drops(60, &mut rng);
    seen.iter_mut().for_each(|seen| seen.scale = String::new());
    let folder = written(&seen, CAMERA, &mut rng);
    let campaign = tracked(&folder);
    assert_eq!(campaign.gravity.measured, None);
    let [scale, se] = campaign.gravity.scale.expect("the scale of all");
    assert!(
        (scale - CAMERA.scale).abs() < 4.0 * se && se < 1e-3 * scale,
        "{scale} {se}"
    );
    let (bias, _) = mean(&errors(&campaign, &seen).1);
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
        seen[1].scale = scale.to_string();
        let folder = written(&seen, CAMERA, &mut rng);
        let list = folder.read("recordings.csv");
        for (unit, cells) in [("px", "250,20"), ("mm", "250,")] {
            let rows = positions(&seen[0], coarse, &mut rng);
            let in_mm = |line: &str| {
                let (frame, row) = line.split_once(',').expect("two columns");
                format!("{frame},{}\n", (PLATE_ROW - row.parse::<f64>().expect("a row")) / 20.0)
            };
            let heights = || rows.lines().skip(1).map(in_mm).collect::<String>();
            let table = if unit == "px" {
                rows.clone()
            } else {
                format!("frame,y_mm\n{}", heights())
            };
            folder.write("drop0.csv", table);
            folder.write("recordings.csv", list.replacen("1000,20", cells, 1));
            let campaign = tracked(&folder);
            let [right, wrong] = impacts(&campaign)[..] else {
                panic!("two recordings")
            };
            assert_eq!(right.verdict, None, "{scale} {unit}");
            let [error, sd] = speed_errors(&right.speeds, &seen[0])[0];
            assert!(error.abs() < 4.0 * sd, "{scale} {unit}: {error}");
            let verdict = wrong.verdict.as_ref().expect("it is left out");
            verdict.says("it falls at");
            verdict.says("scale_px_per_mm would be 20.");
            // it falls by its own gravity, so that its speeds are wrong by the scale and by nothing else
            let ratio = wrong.speeds.impact_speed / seen[1].bounces.impact_speed * scale / 20.0;
            assert!((ratio - 1.0).abs() < 0.01, "{scale} {unit}: {ratio}");
            let shared = campaign.gravity.shared_error();
            assert!(shared.is_some_and(|shared| shared < 0.02), "{scale} {unit}: {shared:?}");
        }
    }
    // none that falls as things do: a mistake is not offered as an error that speeds share
    seen[0].scale = "10".to_owned();
    let folder = written(&seen, CAMERA, &mut rng);
    let stdout = printed_without_runs(&folder);
    stdout.lacks("speed_rel_sd");
    stdout.says("no recording shows a fall at 9.81");
}

/// Nor is a scale by gravity that of the recording with most frames, where the others share another.
#[test]
fn a_long_recording_at_another_scale_condemns_no_others() {
    let mut rng = rng_of("a_long_recording_at_another_scale_condemns_no_others");
    let mut seen = drops(4, &mut rng);
    seen.iter_mut().for_each(|seen| seen.scale = String::new());
    for place in [0, 3] {
        let folder = written(&seen, CAMERA, &mut rng);
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
        for (of, impact) in impacts(&tracked(&folder)).into_iter().enumerate() {
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
    let folder = written(&seen, CAMERA, &mut rng);
    let campaign = tracked(&folder);
    let mut errors = vec![];
    for (place, (impact, seen)) in impacts(&campaign).into_iter().zip(&seen).enumerate() {
        assert_eq!(impact.stuck, place < 20);
        if impact.stuck {
            errors.push(speed_errors(&impact.speeds, seen)[0]);
        }
    }
    assert!(covered(&errors, 4.0) == 20 && covered(&errors, 1.96) > 14, "{errors:?}");
}

#[test]
fn a_sphere_too_narrow_for_its_positions_questions_the_frame_rate() {
    let mut rng = rng_of("a_sphere_too_narrow_for_its_positions_questions_the_frame_rate");
    let mut seen = drops(6, &mut rng);
    let folder = written(&seen, CAMERA, &mut rng);
    let list = folder.read("recordings.csv");
    let verdicts = |list: &str| -> Vec<Option<String>> {
        folder.write("recordings.csv", list);
        let campaign = tracked(&folder);
        impacts(&campaign).iter().map(|impact| impact.verdict.clone()).collect()
    };
    // filmed at 1000 frames a second and played at 125: by gravity the sphere of 95 px has 1.5 px
    let slow = list.replace(",1000,20\n", ",125,\n");
    for verdict in verdicts(&slow) {
        let verdict = verdict.expect("it is questioned");
        verdict.says("sphere 1.5 px wide");
        verdict.says("frame_rate_Hz");
    }
    printed_without_runs(&folder).says("the spheres are then 1.5 px wide");
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
        impacts(&listed(&folder, ",scale_px_per_mm", &line))[0].verdict.clone()
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
    let (speeds, _) = errors(&campaign, &seen);
    for (tracked, faults) in each(&campaign).zip(&faults) {
        let told: Vec<i32> = tracked.expect("a run").jumps.iter().map(|jump| jump.missing).collect();
        let made: Vec<i32> = faults.iter().map(|(_, lost)| *lost).collect();
        assert_eq!(told, made);
    }
    // what is left of them is far below what they do: 1 to 2 % of each speed
    for [error, sd] in &speeds {
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

/// Positions of a sphere, each frame as often as `times` says, and with so much noise of its own each time.
fn seen_unevenly(
    seen: &Seen,
    camera: Camera,
    own_noise: f64,
    times: &dyn Fn(usize, &mut ChaCha8Rng) -> usize,
    rng: &mut ChaCha8Rng,
) -> String {
    let mut rows = vec![];
    for frame in 0..(seen.until * camera.frame_rate) as usize {
        let height = seen.bounces.height(frame as f64 / camera.frame_rate);
        let row = PLATE_ROW - camera.scale * height + camera.noise * normal(rng);
        for _ in 0..times(frame, rng) {
            rows.push(row + own_noise * normal(rng));
        }
    }
    frames(rows.into_iter())
}

/// Cameras of common rates, with the pixels that they have for a sphere.
fn cameras() -> [Camera; 3] {
    let of = |frame_rate, scale, noise| Camera {
        frame_rate,
        scale,
        noise,
        ..CAMERA
    };
    [
        of(1000.0, 20_000.0, 0.5),
        of(240.0, 5_000.0, 0.2),
        of(60.0, 2_000.0, 0.2),
    ]
}

/// Tracks drops at a scale that nobody measured: no gravity contradicts a wrong frame rate.
fn unevenly_tracked(
    seen: &[Seen],
    camera: Camera,
    own_noise: f64,
    times: &dyn Fn(usize, &mut ChaCha8Rng) -> usize,
    rng: &mut ChaCha8Rng,
) -> Campaign {
    let folder = Folder::new();
    let mut lines = String::new();
    for (place, seen) in seen.iter().enumerate() {
        folder.write(
            &format!("drop{place}.csv"),
            seen_unevenly(seen, camera, own_noise, times, rng),
        );
        lines.push_str(&format!("drop{place}.csv,PTFE,dry,4.762,,{}\n", camera.frame_rate));
    }
    listed(&folder, "", &lines)
}

/// Recordings that are refused for their frames, and used ones whose speeds are off by more than four standard deviations and
/// a frame that is missing at the contact, where no flight shows it.
fn refused_and_wrong(campaign: &Campaign, seen: &[Seen], camera: Camera) -> [usize; 2] {
    let shared = campaign.gravity.shared_error().unwrap_or(0.0);
    let at_contact = GRAVITY / camera.frame_rate;
    let (mut refused, mut wrong) = (0, 0);
    for (outcome, seen) in campaign.outcomes.iter().zip(seen) {
        match &outcome.tracked {
            Err(reason) => refused += usize::from(*reason == Refusal::Uneven),
            Ok(tracked) => {
                let impact = &tracked.impacts[0];
                let errors = speed_errors(&impact.speeds, seen);
                let known = |sd: f64| 4.0 * sd.hypot(shared * seen.bounces.impact_speed) + at_contact;
                let is_wrong = errors.iter().any(|[error, sd]| error.abs() > known(*sd));
                wrong += usize::from(is_wrong && impact.verdict.is_none());
            }
        }
    }
    [refused, wrong]
}

#[test]
fn frames_that_are_often_repeated_or_missing_give_no_wrong_speeds() {
    const DROPS: usize = 10;
    let mut rng = rng_of("frames_that_are_often_repeated_or_missing_give_no_wrong_speeds");
    let (mut tracked, mut all_wrong) = (0, 0);
    for camera in &cameras()[..2] {
        let is_fast = camera.frame_rate > 500.0;
        let seen = drops(DROPS, &mut rng);
        let mut count = |times: &dyn Fn(usize, &mut ChaCha8Rng) -> usize, own_noise: f64| {
            let campaign = unevenly_tracked(&seen, *camera, own_noise, times, &mut rng);
            let [refused, wrong] = refused_and_wrong(&campaign, &seen, *camera);
            tracked += DROPS;
            all_wrong += wrong;
            refused
        };
        for own_noise in [0.0, 0.5 * camera.noise] {
            for every in 2..=10 {
                let often = |times: usize| {
                    move |frame: usize, _: &mut ChaCha8Rng| if frame % every == every - 1 { times } else { 1 }
                };
                let refused = count(&often(2), own_noise);
                assert!(!is_fast || refused >= DROPS - 2, "repeated every {every}: {refused}");
                // every other frame alone shows nothing of those between
                if every > 2 {
                    let refused = count(&often(0), own_noise);
                    let is_told = is_fast && (5..9).contains(&every);
                    assert!(!is_told || refused >= DROPS - 3, "missing every {every}: {refused}");
                }
            }
            for share in [0.05, 0.1, 0.2] {
                for times in [0, 2] {
                    let at_random = |_: usize, rng: &mut ChaCha8Rng| if rng.random_bool(share) { times } else { 1 };
                    count(&at_random, own_noise);
                }
            }
        }
        // the planted fault: right recordings, none of which is refused
        assert_eq!(count(&|_, _| 1, 0.0), 0, "{camera:?}");
    }
    // where one in three is missing, moves of one and of two frames alternate, which noise can hide
    assert!(25 * all_wrong < tracked, "{all_wrong} of {tracked}");
}

/// Slow and resting spheres, many bounces, whole pixels: nothing of them looks like frames that are repeated or missing.
#[test]
fn right_recordings_are_not_said_to_lack_frames() {
    let mut rng = rng_of("right_recordings_are_not_said_to_lack_frames");
    let cameras = cameras();
    let mut used = 0;
    for round in 0..60 {
        let camera = Camera {
            frame_rate: [60.0, 120.0, 240.0, 1000.0, 4000.0, 10_000.0][round % 6],
            ..cameras[round % 3]
        };
        let grid = [1.0, 0.1, 1e-6][round / 6 % 3];
        let bounces = fall(
            rng.random_range(0.1..0.3),
            rng.random_range(0.2..1.5),
            rng.random_range(0.0..0.85),
        );
        let until = bounces.second_contact() + rng.random_range(-0.002..0.3);
        let row = |frame: usize| {
            let time = frame as f64 / camera.frame_rate;
            PLATE_ROW - camera.scale * bounces.height(time) + camera.noise * normal(&mut rng)
        };
        let rows = (0..(until * camera.frame_rate) as usize).map(row);
        let folder = Folder::new();
        folder.write("drop.csv", frames(rows.map(|row| (row / grid).round() * grid)));
        let campaign = listed(
            &folder,
            "",
            &format!("drop.csv,PTFE,dry,4.762,,{}\n", camera.frame_rate),
        );
        match &campaign.outcomes[0].tracked {
            Err(reason) => assert_ne!(*reason, Refusal::Uneven, "{round}"),
            Ok(tracked) => {
                let verdict = tracked.impacts[0].verdict.as_deref().unwrap_or_default();
                verdict.lacks("repeated or missing");
                used += usize::from(verdict.is_empty());
            }
        }
    }
    assert!(used > 30, "{used}");
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
    let apart = |campaign: &Campaign| {
        let all = impacts(campaign).into_iter();
        all.filter(|impact| impact.apart.is_some()).count()
    };
    let (seen, folder, campaign) = lost_at_the_contact(3, &mut rng);
    assert!(apart(&campaign) >= 38, "{}", apart(&campaign));
    // both speeds are too small by what their sd says, together
    let mut used = 0;
    for (impact, seen) in impacts(&campaign).into_iter().zip(&seen) {
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

/// The first frame after the contact.
fn first_after(seen: &Seen) -> usize {
    (CAMERA.frame_rate * seen.bounces.contact).ceil() as usize
}

#[test]
fn a_frame_repeated_beside_the_contact_is_told_and_mended() {
    let mut rng = rng_of("a_frame_repeated_beside_the_contact_is_told_and_mended");
    let seen = drops(60, &mut rng);
    // the second and the last frame before the contact, the first and the second after it
    let faults: Vec<Vec<(usize, i32)>> = seen
        .iter()
        .map(|seen| vec![(first_after(seen) - 1 + rng.random_range(0..4), -1)])
        .collect();
    let (_folder, campaign) = faulty_campaign(&seen, &faults, &mut rng);
    let mut mended = 0;
    for (tracked, seen) in each(&campaign).zip(&seen) {
        let tracked = tracked.expect("a run");
        let jumps: Vec<i32> = tracked.jumps.iter().map(|jump| jump.missing).collect();
        let impact = &tracked.impacts[0];
        if jumps == [-1] {
            mended += 1;
            // a frame too many makes each speed too large by 0.003 to 0.008
            for [error, sd] in speed_errors(&impact.speeds, seen) {
                assert!(error.abs() < 0.002 && error.abs() < 3.0 * sd, "{error} {sd}");
            }
        }
    }
    // very near to the plate a repeated position is on its flight at both times
    assert!(mended >= 48, "{mended}");
}

/// Positions in whole pixels are often equal before and after a contact, and no frame is repeated then.
#[test]
fn equal_heights_before_and_after_a_contact_are_two_frames() {
    let mut rng = rng_of("equal_heights_before_and_after_a_contact_are_two_frames");
    let seen = drops(400, &mut rng);
    let folder = Folder::new();
    let (mut lines, mut equal) = (String::new(), 0);
    for (place, seen) in seen.iter().enumerate() {
        let row = |frame: usize| PLATE_ROW - CAMERA.scale * seen.bounces.height(frame as f64 / CAMERA.frame_rate);
        let rows: Vec<f64> = (0..(seen.until * CAMERA.frame_rate) as usize)
            .map(|frame| row(frame).round())
            .collect();
        let after = first_after(seen);
        equal += usize::from(rows[after - 1] == rows[after]);
        folder.write(&format!("drop{place}.csv"), frames(rows.into_iter()));
        lines.push_str(&format!("drop{place}.csv,PTFE,dry,4.762,,1000,20\n"));
    }
    assert!(equal >= 2, "{equal}");
    let campaign = listed(&folder, ",scale_px_per_mm", &lines);
    let tracked: Vec<&Tracked> = each(&campaign).flatten().collect();
    assert!(tracked.len() > 390, "{}", tracked.len());
    assert!(tracked.iter().all(|tracked| tracked.jumps.is_empty()));
}

/// How many recordings are said to meet the plate elsewhere than the others.
fn elsewhere(campaign: &Campaign) -> usize {
    let all = each(campaign).flatten().map(|tracked| &tracked.impacts[0]);
    all.filter(|impact| impact.apart_from_others.is_some()).count()
}

#[test]
fn a_frame_lost_at_one_contact_is_seen_beside_the_other_recordings() {
    let mut rng = rng_of("a_frame_lost_at_one_contact_is_seen_beside_the_other_recordings");
    for count in [3, 12] {
        for lost in [1, 2] {
            let mut seen = drops(count, &mut rng);
            seen[1].bounces = fall(0.0623, 1.0, 0.6);
            seen[1].until = seen[1].bounces.second_contact() - 0.002;
            let mut faults = vec![vec![]; count];
            faults[1] = vec![(first_after(&seen[1]), lost)];
            let (folder, campaign) = faulty_campaign(&seen, &faults, &mut rng);
            assert_eq!(elsewhere(&campaign), 1, "{count} {lost}");
            let impact = impacts(&campaign)[1];
            assert!(
                impact.apart_from_others.is_some() && impact.verdict.is_none(),
                "{impact:?}"
            );
            for [error, sd] in speed_errors(&impact.speeds, &seen[1]) {
                assert!((-1.2..-0.8).contains(&(error / sd)), "{error} {sd}");
            }
            let (_, _, stderr) = folder.run("track recordings.csv --out runs.csv");
            stderr.says("line 3, drop1.csv: its flights meet 0.");
            stderr.says("mm from the height at which the other recordings meet the plate: a frame is missing");
            // nobody knows which of two is right
            let (_folder, two) = faulty_campaign(&seen[..2], &faults[..2], &mut rng);
            assert_eq!(elsewhere(&two), 0);
        }
    }
}

/// Right recordings, on a plate that stays and on one that is moved before each.
#[test]
fn right_recordings_are_not_said_to_meet_the_plate_elsewhere() {
    let mut rng = rng_of("right_recordings_are_not_said_to_meet_the_plate_elsewhere");
    for round in 0..40 {
        let seen = drops(5, &mut rng);
        let folder = Folder::new();
        let mut lines = String::new();
        for (place, seen) in seen.iter().enumerate() {
            let lifted = if round % 2 == 0 {
                0.0
            } else {
                rng.random_range(-200.0..200.0)
            };
            let row = |frame: usize, noise: f64| {
                let height = seen.bounces.height(frame as f64 / CAMERA.frame_rate);
                PLATE_ROW + lifted - CAMERA.scale * height + CAMERA.noise * noise
            };
            let count = (seen.until * CAMERA.frame_rate) as usize;
            let rows: Vec<f64> = (0..count).map(|frame| row(frame, normal(&mut rng))).collect();
            folder.write(&format!("drop{place}.csv"), frames(rows.into_iter()));
            lines.push_str(&format!("drop{place}.csv,PTFE,dry,4.762,,1000,20\n"));
        }
        let campaign = listed(&folder, ",scale_px_per_mm", &lines);
        assert_eq!(elsewhere(&campaign), 0, "{round}");
        assert!(
            impacts(&campaign).iter().all(|impact| impact.verdict.is_none()),
            "{round}"
        );
    }
}

#[test]
fn times_rounded_to_few_digits_are_frames_of_the_rate_or_say_so() {
    const RATE: f64 = 480.0;
    let mut rng = rng_of("times_rounded_to_few_digits_are_frames_of_the_rate_or_say_so");
    let sphere = fall(0.092, 0.9, 0.78);
    let until = sphere.second_contact() - 0.004;
    let rows: Vec<(f64, f64)> = (0..(until * RATE) as usize)
        .map(|frame| frame as f64 / RATE)
        .map(|time| (time, 1e3 * sphere.height(time) + 0.01 * normal(&mut rng)))
        .collect();
    let table = |digits: usize| -> String {
        let row = |(time, height): &(f64, f64)| format!("{time:.digits$},{height:.4}\n");
        format!("time_s,y_mm\n{}", rows.iter().map(row).collect::<String>())
    };
    let folder = Folder::new();
    for name in ["told", "untold", "wrong"] {
        folder.write(&format!("{name}.csv"), table(3));
    }
    folder.write("coarse.csv", table(2));
    let twice = rows
        .iter()
        .map(|(time, height)| format!("{time:.3},{height}\n{time:.3},30.2\n"));
    folder.write("twice.csv", format!("time_s,y_mm\n{}", twice.collect::<String>()));
    let line = |(name, rate): (&str, &str)| format!("{name}.csv,PTFE,dry,4.762,,{rate}\n");
    let all = [
        ("told", "480"),
        ("untold", ""),
        ("wrong", "450"),
        ("coarse", "480"),
        ("twice", "480"),
    ];
    let campaign = listed(&folder, "", &all.map(line).concat());
    let told = campaign.outcomes[0].tracked.as_ref().expect("a run");
    let speeds = told.impacts[0].speeds;
    assert_eq!(told.impacts[0].verdict, None);
    assert!(
        (speeds.impact_speed - 0.9).abs() < 4.0 * speeds.impact_speed_sd,
        "{speeds:?}"
    );
    assert_eq!(campaign.notices.len(), 1);
    campaign.notices[0]
        .text
        .says("line 2, told.csv: its times are rounded to 1 ms");
    let reason = |place: usize| {
        campaign.outcomes[place]
            .tracked
            .as_ref()
            .expect_err("no run")
            .words()
            .to_owned()
    };
    for place in [1, 2] {
        reason(place).says("its times are rounded to too few digits");
    }
    reason(3).says("times are rounded to 10 ms");
    // the planted fault: two things in each frame are no rounding
    reason(4).says("has another position");
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
    let reason = seen_but_for(240..620, &mut rng).expect_err("no rebound is seen");
    reason.words().says("it ends before the sphere has rebounded");
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
        frames((0..(seen.until * CAMERA.frame_rate) as usize).map(|frame| (10.0 * row(frame)).round() / 10.0))
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
    for impact in impacts(&listed(&folder, "", lines)) {
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
        let speeds = impacts(&campaign)[0].speeds;
        assert!((speeds.impact_speed - 1.1).abs() < 0.01, "{speeds:?}");
        let object = campaign.outcomes[0]
            .shown
            .as_ref()
            .and_then(|shown| shown.object.clone());
        (object, campaign.notices.len())
    };
    assert_eq!(taken(&text), (Some("7".to_owned()), 0));
    // of two that fall the choice is told
    assert_eq!(taken(&with_second), (Some("7".to_owned()), 1));
}

#[test]
fn tables_of_other_programs_are_read() {
    let campaign = tracked(in_project("tests/data/positions"));
    assert_eq!(campaign.outcomes.len(), 4);
    for impact in impacts(&campaign) {
        let speeds = impact.speeds;
        let off = [speeds.impact_speed - 1.0, speeds.rebound_speed - 0.6];
        assert!(off.iter().all(|off| off.abs() < 0.003), "{off:?}");
    }
}

/// What follows detection, attacked: whatever a table holds, runs that are written are such as `check` takes.
#[test]
fn whatever_was_seen_the_runs_are_ones_that_check_takes() {
    /// scenes of motion, of which each has tables
    const ROUNDS: usize = 25;
    let mut rng = rng_of("whatever_was_seen_the_runs_are_ones_that_check_takes");
    let place = Place::new(&scene_of("seen", &[PTFE, AK10]));
    let folder = &place.folder;
    let mut used = 0;
    for round in 0..ROUNDS {
        let mut lines = String::new();
        for drop in 0..4 {
            let mut ten_to = |range: std::ops::Range<f64>| 10f64.powf(rng.random_range(range));
            let (impact_speed, rate, film) = (ten_to(-2.0..1.5), ten_to(1.0..4.5), ten_to(1.0..4.5));
            let noise = ten_to(-4.0..-0.5) * impact_speed.powi(2) / 20.0;
            // most fall at another rate than things do, which leaves them out
            let (scale, is_scaled) = (ten_to(-3.0..7.0), rng.random_bool(0.7));
            let bounces = fall(rng.random_range(0.0..0.3), impact_speed, rng.random_range(0.0..0.95));
            // some gain speed, as no sphere does
            let (kick, is_kicked) = (rng.random_range(1.0..3.0), rng.random_bool(0.2));
            let mut text = "frame,y_m\n".to_owned();
            for frame in 0..rng.random_range(5..400) {
                if rng.random_bool(0.02) {
                    continue;
                }
                let time = f64::from(frame) / rate;
                let mut height = bounces.height(time);
                if is_kicked && time > bounces.contact {
                    height *= kick;
                }
                height += noise * normal(&mut rng);
                if rng.random_bool(0.01) {
                    height *= rng.random_range(-2.0..2.0);
                }
                text.push_str(&format!(
                    "{frame},{:e}\n",
                    if is_scaled { scale * height } else { height }
                ));
            }
            folder.write(&format!("drop{drop}.csv"), &text);
            let wet = if rng.random_bool(0.5) {
                format!("AK10,4.762,{film}")
            } else {
                "dry,4.762,".to_owned()
            };
            let density = if rng.random_bool(0.5) { "2150" } else { "" };
            lines.push_str(&format!("drop{drop}.csv,PTFE,{wet},{rate},{density}\n"));
        }
        // the last is a good one, of which every table has a run
        let good = fall(0.1, 1.0, 0.6);
        let rows = (0..200).map(|frame| format!("{frame},{:.6}\n", good.height(f64::from(frame) / 1000.0)));
        folder.write("good.csv", format!("frame,y_m\n{}", rows.collect::<String>()));
        lines.push_str("good.csv,PTFE,dry,4.762,,1000,\n");
        folder.write("recordings.csv", format!("{HEADER},density_kg_m3\n{lines}"));
        let more = if round % 2 == 0 { "--all-rebounds" } else { "" };
        let (status, stdout, stderr) = folder.run(&format!(
            "track recordings.csv --out runs.csv --report out --force {more}"
        ));
        assert!(matches!(status, Some(0 | 1)), "{round}: {stderr}");
        for told in [stdout, folder.read("out/report.md")] {
            told.lacks("NaN");
            told.lacks("inf ");
        }
        place.read();
        let runs = folder.read("runs.csv");
        used += runs.lines().filter(|line| line.ends_with(',')).count();
    }
    assert!(used > ROUNDS, "{used}");
}

#[test]
fn damaged_tables_do_no_harm() {
    let mut rng = rng_of("damaged_tables_do_no_harm");
    let seen = drops(2, &mut rng);
    let folder = written(&seen, CAMERA, &mut rng);
    let [path, table] = ["recordings.csv", "drop1.csv"].map(|name| folder.join(name));
    let originals = [&path, &table].map(|path| std::fs::read(path).expect("readable"));
    let mut refused = 0;
    for round in 0..300 {
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
                    let speeds = [of.impact_speed, of.rebound_speed, of.correlation];
                    let numbers = [speeds.as_slice(), &[of.impact_speed_sd, of.rebound_speed_sd]].concat();
                    assert!(numbers.iter().all(|number| number.is_finite()), "{impact:?}");
                }
            }
        }
        std::fs::write([&path, &table][which], &originals[which]).expect("writable");
    }
    assert!((25..275).contains(&refused), "{refused}");
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
        let error = |(impact, truth): (&Impact, &[f64; 2])| {
            let of = impact.speeds;
            if !density.is_empty() && !scale.is_empty() {
                // what is left lies inside what is stated
                let errors = [of.impact_speed - truth[0], of.rebound_speed - truth[1]];
                let within = errors[0].abs() < of.impact_speed_sd && errors[1].abs() < of.rebound_speed_sd;
                assert!(within, "{of:?} {truth:?}");
            }
            (of.rebound_speed / of.impact_speed - truth[1] / truth[0]).abs()
        };
        impacts(&campaign)
            .into_iter()
            .zip(&truths)
            .map(error)
            .fold(0.0, f64::max)
    };
    assert!(largest_error("20", "940") < 1e-4);
    assert!(largest_error("", "940") < 1e-4);
    // the planted fault: air that nobody takes off
    let left = largest_error("20", "");
    assert!((0.01..0.02).contains(&left), "{left}");
}
