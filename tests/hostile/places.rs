//! Attacks the places that files are written to: the user's own files, links, names and folders that refuse.

use std::os::unix::fs::{symlink, PermissionsExt};
use std::path::Path;
use std::process::Command;

use super::attack::{finish, Place};

const FIT: [&str; 5] = ["fit", "scene.toml", "--stages", "least_squares", "--out"];

/// Lines of a scene that make its fit slow.
const SLOW: &str = "[sampler]\nchains = 4\nwarmup = 100000\ndraws = 100000\n[model]\nlikelihood = \"student\"";

fn fit(place: &Place, out: &str) -> super::attack::Outcome {
    place.run(&[&FIT[..], &[out]].concat(), 60.0)
}

/// A place with a report in `report`.
fn fitted() -> Place {
    let place = Place::plain();
    let fitted = fit(&place, "report");
    assert!(matches!(fitted.status, Some(0 | 1)), "{fitted:?}");
    place
}

#[test]
fn d01_and_d10_are_held_by_the_kills_of_replacing() {
    // here only that an interrupted fit says so, with the status of one that could not run
    let place = fitted();
    let before = place.read("report/findings.json");
    // minutes of sampling, so that the signal finds it at work on any machine
    place.add_to_scene(SLOW);
    let mut command = place.command(&["fit", "scene.toml", "--out", "other"]);
    command
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped());
    let child = command.spawn().expect("it can be started");
    std::thread::sleep(std::time::Duration::from_secs(1));
    let kill = format!("kill -s INT {}", child.id());
    assert!(Command::new("sh")
        .args(["-c", &kill])
        .status()
        .is_ok_and(|s| s.success()));
    let ended = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(2), "{said}");
    assert!(said.contains("error: interrupted; nothing was written"), "{said}");
    assert_eq!(place.entries(), ["report", "runs.csv", "scene.toml"]);
    assert_eq!(place.read("report/findings.json"), before);
}

#[test]
fn d02_a_folder_that_holds_the_scene_is_refused() {
    let place = fitted();
    for name in ["scene.toml", "runs.csv"] {
        std::fs::copy(place.path(name), place.path("report").join(name)).expect("writable");
    }
    let outcome = place.ask("fit report/scene.toml --stages least_squares --out report", 60.0);
    outcome.assert_refused("scene inside", &["report", "holds scene.toml"]);
    assert!(place.path("report/scene.toml").exists() && place.path("report/runs.csv").exists());
    // and where only the runs lie inside, under a name that is ours
    for name in ["report/scene.toml", "report/runs.csv"] {
        std::fs::remove_file(place.path(name)).expect("it is there");
    }
    std::fs::create_dir(place.path("report/draws")).expect("writable");
    std::fs::rename(place.path("runs.csv"), place.path("report/draws/draws.csv")).expect("writable");
    let scene = place.read("scene.toml").replace("runs.csv", "report/draws/draws.csv");
    place.write("scene.toml", scene);
    fit(&place, "report").assert_refused("runs inside", &["holds draws/draws.csv"]);
    assert!(place.path("report/draws/draws.csv").exists());
    // and in a folder below
    std::fs::create_dir(place.path("report/sub")).expect("writable");
    std::fs::rename(place.path("report/draws/draws.csv"), place.path("report/sub/runs.csv")).expect("writable");
    let scene = place.read("scene.toml").replace("report/draws/draws.csv", "runs.csv");
    place.write("report/sub/scene.toml", scene);
    place
        .ask("fit report/sub/scene.toml --stages least_squares --out report", 60.0)
        .assert_refused("scene below", &["report", "holds sub/scene.toml"]);
    assert!(place.path("report/sub/scene.toml").exists());
}

#[test]
fn d02_whatever_else_lies_in_a_report_stands_in_the_way_by_name() {
    let listed = "raw/monday.csv notes.txt figures/mine.svg figures/photo.png draws/draws.zarr/notes.txt \
        draws/draws.zarr/posterior/c.0.txt draws/other.csv .hidden trade.md";
    for stranger in listed.split(' ') {
        let place = fitted();
        let path = place.path("report").join(stranger);
        std::fs::create_dir_all(path.parent().expect("it lies inside")).expect("writable");
        std::fs::write(&path, "a week of work").expect("writable");
        fit(&place, "report").assert_refused(stranger, &["report: holds ", stranger, "nothing was written"]);
        assert_eq!(std::fs::read_to_string(&path).ok().as_deref(), Some("a week of work"));
        assert_eq!(place.entries(), ["report", "runs.csv", "scene.toml"]);
        // without it the report is ours to replace
        std::fs::remove_file(&path).expect("it is there");
        assert!(matches!(fit(&place, "report").status, Some(0 | 1)), "{stranger}");
    }
}

#[test]
fn d03_a_fit_from_inside_the_report_replaces_it() {
    let place = fitted();
    let before = place.read("report/findings.json");
    let mut command = Command::new(env!("CARGO_BIN_EXE_wetcor"));
    let words = "fit ../scene.toml --stages least_squares --seed 2 --out ../report";
    command.current_dir(place.path("report")).args(words.split(' '));
    let outcome = finish(command, 60.0);
    assert!(matches!(outcome.status, Some(0 | 1)), "{outcome:?}");
    assert_eq!(place.entries(), ["report", "runs.csv", "scene.toml"]);
    assert_ne!(place.read("report/findings.json"), before);
}

const DESIGN: &str = r#"[truth]
dry_k = { PTFE = 0.18 }
lubrication_log = 1.9
inertial_prefactor = 0.6
sigma_dry = 0.01
sigma_wet = 0.01
[design]
diameter_mm = [4.762]
liquids = ["AK10"]
film_ratio = [0.06]
impact_speed_m_s = [1.0, 2.0]
dry_impact_speed_m_s = [1.0]
repeats = 1
"#;

#[test]
fn d04_simulate_keeps_what_is_there() {
    let place = Place::plain();
    place.add_to_scene(DESIGN);
    let (scene, runs) = (place.read("scene.toml"), place.read("runs.csv"));
    let simulate = |out: &str, more: &[&str]| {
        let arguments = [&["simulate", "scene.toml", "--out", out], more].concat();
        place.run(&arguments, 60.0)
    };
    // the scene's own runs, by any way to them
    symlink(place.path("runs.csv"), place.path("link.csv")).expect("writable");
    for out in ["runs.csv", "./runs.csv", "link.csv"] {
        for more in [&[][..], &["--force"]] {
            simulate(out, more).assert_refused(out, &["holds the runs of scene.toml"]);
        }
    }
    // a scene, this one or another, and the runs of a neighbour
    std::fs::copy(place.path("scene.toml"), place.path("scene.csv")).expect("writable");
    place.write("neighbour.toml", scene.replace("runs.csv", "measured.csv"));
    place.write("measured.csv", &runs);
    for more in [&[][..], &["--force"]] {
        simulate("scene.csv", more).assert_refused("a scene", &["scene.csv: is a scene"]);
        simulate("measured.csv", more).assert_refused("measured", &["holds the runs of", "neighbour.toml"]);
    }
    // anything else wants --force
    place.write("other.csv", "mine");
    let read_only = std::fs::Permissions::from_mode(0o444);
    std::fs::set_permissions(place.path("other.csv"), read_only).expect("ours");
    simulate("other.csv", &[]).assert_refused("other", &["other.csv: exists; --force replaces it"]);
    assert_eq!(place.read("other.csv"), "mine");
    let forced = simulate("other.csv", &["--force"]);
    assert_eq!(forced.status, Some(0), "{forced:?}");
    assert!(place.read("other.csv").starts_with("particle,liquid,"));
    let fresh = simulate("fresh.parquet", &[]);
    assert_eq!(fresh.status, Some(0), "{fresh:?}");
    assert_eq!(
        (place.read("scene.toml"), place.read("runs.csv")),
        (scene, runs.clone())
    );
    assert_eq!(
        (place.read("measured.csv"), place.read("link.csv")),
        (runs.clone(), runs)
    );
}

#[test]
fn d04_calibrate_replaces_nothing_but_its_own_page() {
    let place = Place::plain();
    let before = place.read("runs.csv");
    let outcome = place.run(&["calibrate", "--sets", "1", "--out", "runs.csv"], 60.0);
    outcome.assert_refused("calibrate", &["runs.csv: exists and is no page of `wetcor calibrate`"]);
    assert_eq!(place.read("runs.csv"), before);
}

#[test]
fn d15_a_link_to_a_report_is_followed() {
    let place = fitted();
    std::fs::create_dir(place.path("kept")).expect("writable");
    std::fs::rename(place.path("report"), place.path("kept/first")).expect("writable");
    symlink("kept/first", place.path("report")).expect("writable");
    let before = place.read("kept/first/findings.json");
    let arguments = [&FIT[..], &["report", "--seed", "7"]].concat();
    let outcome = place.run(&arguments, 60.0);
    assert!(matches!(outcome.status, Some(0 | 1)), "{outcome:?}");
    assert!(place.path("report").symlink_metadata().is_ok_and(|of| of.is_symlink()));
    assert_ne!(place.read("kept/first/findings.json"), before);
    assert_eq!(std::fs::read_dir(place.path("kept")).map(Iterator::count).ok(), Some(1));
    symlink("nowhere", place.path("lost")).expect("writable");
    fit(&place, "lost").assert_refused("a link to nothing", &["lost: is a link to nothing"]);
    symlink("round", place.path("round")).expect("writable");
    fit(&place, "round").assert_refused("a link to itself", &["round: cannot write"]);
}

#[test]
fn d15_places_that_cannot_be_are_refused_before_the_fit() {
    let place = fitted();
    // so slow a fit that a refusal after it would be cut off
    place.add_to_scene(SLOW);
    let long = "n".repeat(256);
    let deep = format!("new/{}", "folder/".repeat(600));
    for (out, words) in [
        ("report/.", "expected a name that does not end in `.` or `..`"),
        ("report/..", "expected a name"),
        (".", "expected a name"),
        ("..", "expected a name"),
        ("/", "expected a name"),
        ("new/.", "expected a name"),
        (long.as_str(), "cannot write"),
        (&format!("new/folder/{long}"), "cannot write"),
        (&deep, "cannot write"),
        ("/proc/report", "cannot write"),
        ("/proc/new/report", "cannot write"),
        ("scene.toml", "exists and is no folder"),
        ("scene.toml/report", "cannot write"),
        ("nowhere/../report", "cannot write"),
        ("", "a value is required"),
    ] {
        let outcome = place.run(&["fit", "scene.toml", "--out", out], 10.0);
        outcome.assert_refused(out, &[words]);
        assert_eq!(place.entries(), ["report", "runs.csv", "scene.toml"], "{out}");
    }
}

#[test]
fn d17_a_limit_on_file_sizes_leaves_nothing() {
    let place = fitted();
    let before = place.read("report/findings.json");
    let fit = "ulimit -f 8; exec \"$0\" fit scene.toml --stages least_squares,figures --out report";
    let mut command = Command::new("sh");
    command
        .current_dir(place.folder.path())
        .args(["-c", fit, env!("CARGO_BIN_EXE_wetcor")]);
    finish(command, 60.0).assert_refused("ulimit -f", &["cannot write", "File too large"]);
    assert_eq!(place.entries(), ["report", "runs.csv", "scene.toml"]);
    assert_eq!(place.read("report/findings.json"), before);
}

/// What a run leaves that was killed while it wrote.
const HALF: &str = "lock=wetcor makes report; new/report.md=half";

/// A folder that an earlier run left, without a maker who holds its lock; its files are given as `name=text; name=text`.
fn leave(place: &Place, name: &str, files: &str) {
    for (inside, text) in files.split("; ").filter_map(|file| file.split_once('=')) {
        let path = place.path(name).join(inside);
        std::fs::create_dir_all(path.parent().expect("it lies inside")).expect("writable");
        std::fs::write(path, text).expect("writable");
    }
}

#[test]
fn what_the_dead_left_is_cleared_and_what_others_made_is_not() {
    let place = Place::plain();
    leave(&place, ".wetcor-dead01", HALF);
    leave(&place, ".wetcor-dead02", "lock=");
    std::fs::create_dir(place.path(".wetcor-dead03")).expect("writable");
    let locked = "lock=wetcor makes report; thesis.tex=years";
    leave(&place, ".wetcor-mine01", locked);
    leave(&place, ".wetcor-mine02", "lock=mine; new/a=b");
    leave(&place, ".wetcor-mine03", "thesis.tex=years");
    leave(&place, ".wetcor-mine04", "lock=; old/a=b; new/c=d");
    // waiting for somebody who writes to it would never end
    std::fs::create_dir(place.path(".wetcor-mine05")).expect("writable");
    let made = Command::new("mkfifo").arg(place.path(".wetcor-mine05/lock")).status();
    assert!(made.is_ok_and(|status| status.success()));
    std::fs::write(place.path(".wetcor-note"), "mine").expect("writable");
    leave(&place, ".wetcor-alive1", HALF);
    let alive = std::fs::File::open(place.path(".wetcor-alive1/lock")).expect("readable");
    alive.try_lock().expect("nobody else holds it");
    assert!(matches!(fit(&place, "report").status, Some(0 | 1)));
    let kept = ["alive1", "mine01", "mine02", "mine03", "mine04", "mine05", "note"];
    assert_eq!(place.entries()[..7], kept.map(|name| format!(".wetcor-{name}")));
    assert_eq!(place.entries()[7..], ["report", "runs.csv", "scene.toml"]);
    assert!(place.path(".wetcor-mine04/old/a").exists() && place.path(".wetcor-mine04/new/c").exists());
    assert!(place.path(".wetcor-mine01/thesis.tex").exists() && place.path(".wetcor-mine02/new/a").exists());
    drop(alive);
    assert!(matches!(fit(&place, "report").status, Some(0 | 1)));
    assert!(!place.path(".wetcor-alive1").exists());
}

#[test]
fn what_was_moved_aside_comes_back_where_nothing_took_its_place() {
    let place = fitted();
    let before = place.read("report/findings.json");
    let aside = |place: &Place| {
        leave(place, ".wetcor-dead01", HALF);
        std::fs::rename(place.path("report"), place.path(".wetcor-dead01/old")).expect("writable");
    };
    aside(&place);
    let fitted = fit(&place, "next");
    assert!(matches!(fitted.status, Some(0 | 1)), "{fitted:?}");
    assert_eq!(place.read("report/findings.json"), before);
    assert!(!place.path(".wetcor-dead01").exists());
    // a newer report in its place is kept
    aside(&place);
    std::fs::rename(place.path("next"), place.path("report")).expect("writable");
    let newer = place.read("report/timing.json");
    assert!(matches!(fit(&place, "third").status, Some(0 | 1)));
    assert_eq!(place.read("report/timing.json"), newer);
    assert!(!place.path(".wetcor-dead01").exists());
    // a name that is a way out of the folder is no name
    let escaping = "lock=wetcor makes ../escaped; old/report.md=x";
    leave(&place, ".wetcor-dead04", escaping);
    assert!(matches!(fit(&place, "third").status, Some(0 | 1)));
    assert!(!Path::new(&place.path("../escaped")).exists() && place.path(".wetcor-dead04/old").exists());
}
