//! The sphere is found where it was rendered, whatever else is in the frames.

use std::path::Path;

use crate::common::{seed_of, Folder, Says};
use crate::render::{self, render, Picture, Scene};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use wetcor::recordings::frames::{find_sphere, Sightings};

/// Errors of positions, px.
#[derive(Debug, Clone, Copy)]
struct Errors {
    bias: [f64; 2],
    sd: [f64; 2],
    largest: f64,
}

impl Errors {
    fn of(each: &[[f64; 2]]) -> Errors {
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| each.iter().map(of).sum::<f64>() / each.len().max(1) as f64;
        let bias = [0, 1].map(|axis: usize| mean(&|one| one[axis]));
        Errors {
            bias,
            sd: [0, 1].map(|axis: usize| mean(&|one| (one[axis] - bias[axis]).powi(2)).sqrt()),
            largest: each.iter().flatten().fold(0.0, |most, error| error.abs().max(most)),
        }
    }

    /// The line of the requirement, with three standard errors of the mean for chance.
    fn are_small(&self, frames: usize) -> bool {
        let chance = 3.0 / (frames as f64).sqrt();
        let mut axes = self.bias.iter().zip(self.sd);
        axes.all(|(bias, sd)| bias.abs() < 0.02 + chance * sd && sd < 0.05)
    }
}

/// The plainest scene, with the noise of a test.
fn seeded(test: &str) -> Scene {
    Scene {
        seed: seed_of(test),
        ..Scene::default()
    }
}

fn sized([width, height]: [usize; 2], radius: f64, test: &str) -> Scene {
    Scene {
        width,
        height,
        radius,
        ..seeded(test)
    }
}

fn written(scene: &Scene, centre: impl Fn(f64) -> (f64, f64) + Sync, frames: usize) -> Folder {
    let folder = Folder::new();
    (0..frames).into_par_iter().for_each(|frame| {
        let picture = render(scene, &centre, frame);
        picture.png(&folder.path().join(format!("frame{frame}.png")));
    });
    folder
}

fn found(path: &Path) -> Sightings {
    find_sphere(path, &|_, _| ()).expect("a sphere")
}

/// What is found in so many frames.
fn found_in(scene: &Scene, centre: impl Fn(f64) -> (f64, f64) + Sync, frames: usize) -> Sightings {
    found(written(scene, centre, frames).path())
}

fn errors_between(sightings: &Sightings, centre: impl Fn(f64) -> (f64, f64), which: impl Fn(usize) -> bool) -> Errors {
    let each = sightings.seen.iter().filter(|one| which(one.frame)).map(|one| {
        let (x, y) = centre(one.frame as f64);
        [one.x_px - x, one.y_px - y]
    });
    Errors::of(&Vec::from_iter(each))
}

/// The height of the plate in frames of the default size.
const PLATE: f64 = 190.0;

/// Everything that a wet plate adds, of a sphere whose outline has a contrast of 20 times the noise.
fn wet_plate(bright: bool, test: &str) -> Scene {
    let scene = Scene {
        gradient: 0.4,
        shading: 0.3,
        highlight: true,
        plate: Some(PLATE),
        mirror: 0.5,
        meniscus: 4.0,
        shadow: 0.15,
        ..seeded(test)
    };
    if bright {
        // a lamp from above leaves 70 % of the contrast at the outline
        Scene { noise: 3.5, ..scene }
    } else {
        Scene {
            background: 170.0,
            contrast: -130.0,
            ..scene
        }
    }
}

/// A fall to the plate in 150 frames and a rebound of half the speed, over all parts of a pixel.
fn impact(time: f64) -> (f64, f64) {
    let from = time - 150.37;
    let height = if from < 0.0 { -0.9 * from } else { 0.45 * from };
    (95.0 + 0.0713 * from, PLATE - 20.0 - height)
}

/// The centre of mass of what differs from the level of most pixels by half of the contrast.
fn centre_of_mass(picture: &Picture, scene: &Scene) -> (f64, f64) {
    let mut sorted = picture.levels.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
    for (at, level) in picture.levels.iter().enumerate() {
        if (level - usual) / scene.contrast > 0.4 {
            sum += 1.0;
            x += (at % picture.width) as f64;
            y += (at / picture.width) as f64;
        }
    }
    (x / sum, y / sum)
}

#[test]
#[ignore = "slow: run with --ignored"]
fn positions_are_within_hundredths_of_a_pixel() {
    for bright in [true, false] {
        let scene = wet_plate(bright, "positions_are_within_hundredths_of_a_pixel");
        let sightings = found_in(&scene, impact, 240);
        assert!(sightings.missed.is_empty(), "{bright}");
        let near = |frame: usize| PLATE - 20.0 - impact(frame as f64).1 < 6.0;
        let free = errors_between(&sightings, impact, |frame| !near(frame));
        let wet = errors_between(&sightings, impact, near);
        assert!(free.are_small(200), "{free:?}");
        assert!(wet.are_small(20), "{wet:?}");
        assert!((sightings.radius_px - 20.0).abs() < 0.1, "{}", sightings.radius_px);
        let ratio = sightings.contrast / sightings.noise;
        assert!((15.0..28.0).contains(&ratio), "{ratio}");

        // the simple method goes red
        let simple = (0..240).into_par_iter().step_by(4).map(|frame| {
            let (x, y) = centre_of_mass(&render(&scene, impact, frame), &scene);
            let truth = impact(frame as f64);
            [x - truth.0, y - truth.1]
        });
        let simple = Errors::of(&simple.collect::<Vec<_>>());
        assert!(!simple.are_small(60) && simple.bias[1].abs() > 0.2, "{simple:?}");
    }
}

#[test]
fn the_background_is_without_a_sphere_at_rest() {
    /// Rests for a part of 120 frames at the beginning, falls, and rests at the plate.
    fn held(first: f64, last: f64) -> impl Fn(f64) -> (f64, f64) {
        let fall = 120.0 - first - last;
        move |time| {
            let part = ((time - first) / fall).clamp(0.0, 1.0);
            (100.3, 40.6 + 129.0 * part)
        }
    }
    for (bright, first, last) in [(true, 84.0, 0.0), (false, 0.0, 84.0)] {
        let scene = wet_plate(bright, "the_background_is_without_a_sphere_at_rest");
        let centre = held(first, last);
        let sightings = found_in(&scene, &centre, 120);
        assert!(sightings.missed.is_empty(), "{bright}");
        // at rest on the plate all frames have the one error of its meniscus
        let rests = |frame: usize| frame as f64 > 120.0 - last;
        let free = errors_between(&sightings, &centre, |frame| !rests(frame));
        let at_rest = errors_between(&sightings, &centre, rests);
        let [across, down] = at_rest.bias.map(f64::abs);
        let are_good = free.are_small(30) && across < 0.03 && down < 0.08;
        let is_none_far = free.largest < 0.25 && at_rest.largest < 0.25;
        assert!(are_good && is_none_far, "{bright} {free:?} {at_rest:?}");
    }
}

#[test]
fn light_that_changes_and_other_things_move_nothing() {
    let scene = Scene {
        flicker: 0.03,
        drift: 0.3,
        droplet: 7.0,
        bar: true,
        background: 60.0,
        ..seeded("light_that_changes_and_other_things_move_nothing")
    };
    let centre = |time: f64| (110.0 + 0.11 * time, 30.0 + 0.83 * time);
    let sightings = found_in(&scene, centre, 200);
    let all = errors_between(&sightings, centre, |_| true);
    assert!(sightings.missed.is_empty());
    assert!(all.are_small(200), "{all:?}");
    assert!((sightings.radius_px - 20.0).abs() < 0.1, "{}", sightings.radius_px);
}

#[test]
fn a_motion_blur_is_borne() {
    // a fall from rest to a radius a frame, and as fast up again
    let path = |time: f64| match time - 40.0 {
        rise if rise < 0.0 => (30.0 + 0.25 * time * time, 0.5 * time),
        rise => (430.0 - 20.0 * rise + 0.15 * rise * rise, -20.0 + 0.3 * rise),
    };
    let speed = |time: f64| path(time).1.abs();
    let centre = |time: f64| (70.2 + 0.37 * time, path(time).0);
    let scene = Scene {
        width: 160,
        height: 480,
        exposure: 1.0,
        shading: 0.2,
        highlight: true,
        ..seeded("a_motion_blur_is_borne")
    };
    let sightings = found_in(&scene, centre, 58);
    assert!(sightings.missed.len() <= 1, "{:?}", sightings.missed);
    let moved = [(0.0..5.0, 0.2), (5.0..12.0, 0.4), (12.0..16.0, 1.0), (16.0..20.1, 5.0)];
    for (speeds, most) in moved {
        let is_own = |frame| frame != 40 && speeds.contains(&speed(frame as f64));
        let found = errors_between(&sightings, centre, is_own);
        assert!(found.largest < most, "{speeds:?}: {found:?}");
        assert!(most > 1.0 || found.bias[1].abs() < 0.4, "{speeds:?}: {found:?}");
    }
    // a frame says how far it is blurred
    for one in sightings.seen.iter().filter(|one| one.frame != 40) {
        let length = speed(one.frame as f64);
        let off = (one.blur_px - length.max(1.5)).abs();
        assert!(off < 0.35 * length + 1.5, "{length} {one:?}");
    }
}

#[test]
fn a_sphere_that_is_not_whole_is_missed() {
    let centre = |time: f64| (60.0, -30.0 + 1.3 * time);
    let scene = sized([120, 160], 20.0, "a_sphere_that_is_not_whole_is_missed");
    let sightings = found_in(&scene, centre, 180);
    for frame in 0..180 {
        let (x, y) = centre(frame as f64);
        let seen = sightings.seen.iter().find(|one| one.frame == frame);
        let (is_whole, is_in_part) = (y > 20.5 && y < 160.0 - 21.5, !(19.0..=140.0).contains(&y));
        assert!(if seen.is_some() { !is_in_part } else { !is_whole }, "{frame} {y}");
        let is_near = seen.is_none_or(|one| (one.x_px - x).hypot(one.y_px - y) < 0.25);
        assert!(is_near, "{seen:?}");
    }
    assert_eq!(sightings.seen.len() + sightings.missed.len(), sightings.frames);
}

#[test]
#[ignore = "slow: run with --ignored"]
fn a_mirror_image_is_no_sphere() {
    // the plate is in the middle: the mirror image comes into view before the sphere
    let centre = |time: f64| (60.0, -60.0 + 1.1 * time);
    let scene = Scene {
        width: 120,
        height: 320,
        plate: Some(110.0),
        mirror: 0.8,
        ..seeded("a_mirror_image_is_no_sphere")
    };
    let sightings = found_in(&scene, centre, 135);
    let all = errors_between(&sightings, centre, |_| true);
    let missed = &sightings.missed;
    assert!(all.largest < 0.3, "{all:?}");
    assert!(sightings.seen.len() > 50 && missed.contains(&60), "{missed:?}");
}

fn falling(time: f64) -> (f64, f64) {
    (50.3 + 0.05 * time, 25.2 + 1.63 * time)
}

#[test]
#[ignore = "slow: run with --ignored"]
fn formats_tell_the_same() {
    let scene = sized([100, 140], 20.0, "formats_tell_the_same");
    let frames = 50;
    let pictures: Vec<Picture> = (0..frames)
        .into_par_iter()
        .map(|frame| render(&scene, falling, frame))
        .collect();
    let write = |name: fn(usize) -> String, encode: fn(&Picture, &Path)| {
        let folder = Folder::new();
        for (frame, picture) in pictures.iter().enumerate() {
            encode(picture, &folder.path().join(name(frame)));
        }
        // what is no image is left alone
        folder.write("Thumbs.db", "thumbs");
        folder.write("notes.txt", "notes");
        folder.write("._f1.png", "of a system");
        std::fs::create_dir(folder.join("more.png")).expect("a folder");
        folder
    };
    let grey = write(|frame| format!("f{frame}.png"), Picture::png);
    let truth = found(grey.path());
    assert_eq!(truth.frames, frames);
    let near = |path: &Path, most: f64, grey: f64| {
        let sightings = found(path);
        assert_eq!(sightings.missed, truth.missed, "{path:?}");
        for (one, other) in sightings.seen.iter().zip(&truth.seen) {
            let away = (one.x_px - other.x_px).hypot(one.y_px - other.y_px);
            assert!(away < most, "{path:?} {one:?} {other:?}");
        }
        let noise = sightings.noise / truth.noise / grey;
        assert!((noise - 1.0).abs() < 0.1, "{path:?} {noise}");
        let contrast = sightings.contrast / truth.contrast / grey;
        assert!((contrast - 1.0).abs() < 0.02, "{path:?} {contrast}");
    };
    let wide = write(|frame| format!("{frame:05}.PNG"), Picture::png_of_16_bits);
    near(wide.path(), 0.03, 257.0);
    let colours = write(|frame| format!("f{frame}.png"), Picture::png_of_colours);
    near(colours.path(), 0.01, 1.0);
    let jpeg = write(|frame| format!("f{frame}.jpeg"), Picture::jpeg);
    near(jpeg.path(), 0.1, 1.0);
    let single = |picture: &Picture, path: &Path| render::tiff(path, false, std::iter::once(picture));
    let folder = write(|frame| format!("f{frame}.tif"), single);
    near(folder.path(), 1e-6, 1.0);
    for (wide, most, grey) in [(false, 1e-6, 1.0), (true, 0.03, 257.0)] {
        let path = folder.join("pages.tiff");
        render::tiff(&path, wide, pictures.iter());
        near(&path, most, grey);
    }
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let scene = sized([100, 140], 20.0, "any_number_of_threads_finds_the_same");
    let folder = written(&scene, falling, 40);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| found(folder.path()))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}

fn refusal(path: &Path) -> String {
    find_sphere(path, &|_, _| ()).expect_err("no frames")
}

#[cfg(unix)]
#[test]
fn what_has_no_end_is_no_frame() {
    let scene = sized([60, 60], 8.0, "what_has_no_end_is_no_frame");
    let folder = written(&scene, |_| (30.0, 30.0), 6);
    let last = folder.join("f6.png");
    std::os::unix::fs::symlink("/dev/zero", &last).expect("a link");
    let message = refusal(folder.path());
    message.says("f6.png");
    message.says("found a device");
    std::fs::remove_file(&last).expect("it is there");
    // a pipe that nobody writes to is not waited for
    for (name, path) in [
        ("f6.png", folder.path()),
        ("pages.tif", folder.join("pages.tif").as_path()),
    ] {
        let made = std::process::Command::new("mkfifo").arg(folder.join(name)).status();
        assert!(made.is_ok_and(|status| status.success()));
        refusal(path).says("found a pipe, expected a regular file");
    }
}

/// Files of each format with some bits turned, and the rest cut off of every third.
#[test]
fn broken_images_break_nothing() {
    const MUTATIONS: u64 = 300;
    let scene = sized([24, 20], 5.0, "broken_images_break_nothing");
    let centre = |time: f64| (12.0, 6.0 + 0.9 * time);
    let made = Folder::new();
    let path = |name: &str| made.join(name);
    render(&scene, centre, 0).png(&path("0.png"));
    render(&scene, centre, 0).jpeg(&path("0.jpg"));
    render::tiff(&path("0.tif"), false, (0..5).map(|frame| render(&scene, centre, frame)));
    let refused = ["0.png", "0.jpg", "0.tif"].map(|name| {
        let good = std::fs::read(path(name)).expect("a file");
        let is_refused = |number: &u64| {
            let folder = Folder::new();
            let mut rng = ChaCha8Rng::seed_from_u64(*number);
            let mut bytes = good.clone();
            for _ in 0..rng.random_range(1..6) {
                let at = rng.random_range(0..bytes.len());
                bytes[at] ^= 1 << rng.random_range(0..8);
            }
            if rng.random_range(0..3) == 0 {
                bytes.truncate(rng.random_range(0..bytes.len()));
            }
            folder.write(name, bytes);
            if name == "0.tif" {
                return find_sphere(&folder.join(name), &|_, _| ()).is_err();
            }
            for frame in 1..5 {
                folder.write(&name.replace('0', &frame.to_string()), &good);
            }
            find_sphere(folder.path(), &|_, _| ()).is_err()
        };
        (0..MUTATIONS).into_par_iter().filter(is_refused).count()
    });
    assert!(refused.iter().sum::<usize>() > 150, "{refused:?}");
}
