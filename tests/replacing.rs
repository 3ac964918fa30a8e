//! Kills fits while they write: the old report or the new one always stands whole.
//!
//! This file starts itself again to be killed: what is killed is a fit through the library whose report is written slowly,
//! so that most signals arrive while it is written.

use crate::common::{self, contents, entries, in_project, Folder};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use wetcor::findings;
use wetcor::report::folder::{Contents, Destination, File, Fill, Streamed};
use wetcor::report::{self, ReportInput};
use wetcor::staging;
use wetcor::{interruption, runs, scene};

/// What the child is told: where to write, with which seed, and how.
const OUT: &str = "REPLACING_OUT";
const SEED: &str = "REPLACING_SEED";
const HOW: &str = "REPLACING_HOW";

/// What the child says on a line of its own: that it begins to write, that a slow part is written, that the last file is.
const WRITING: &str = "writing";
const PART: &str = "part";
const LAST: &str = "last";

/// Files that make a report large, so that it takes a while to remove.
const MANY_FILES: usize = 200;

/// Files that the child writes slowly, and how slowly.
const SLOW_FILES: usize = 40;
const SLOWNESS: Duration = Duration::from_millis(2);

/// Milliseconds between the two steps where there is no exchange in one.
const BETWEEN_STEPS: u64 = 40;

/// Says something to the parent, who may be gone.
fn say(word: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "\n{word}").and_then(|()| out.flush());
}

const SIGNALS: [&str; 4] = ["INT", "TERM", "HUP", "KILL"];

fn plain() -> PathBuf {
    in_project("tests/data/good/plain/scene.toml")
}

/// The child: fits the plain example and writes its report slowly.
fn fit_slowly(out: &Path) {
    let seed = std::env::var(SEED).expect("the seed is set").parse().expect("a number");
    let how = std::env::var(HOW).expect("the way is set");
    if how == "two steps" {
        staging::take_two_steps(BETWEEN_STEPS);
    }
    interruption::watch(|why| eprintln!("{why}")).expect("signals can be waited for");
    let path = plain();
    let scene = scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let destination = Destination::prepare(out, Contents::Fit, &scene.title, &[&path, &scene.data.runs[0].path]);
    let table = runs::read(&scene).unwrap_or_else(|error| panic!("{error}"));
    let findings = findings::fit_least_squares(&scene, &table, seed, false);
    let input = ReportInput {
        command: "wetcor fit scene.toml",
        scene: &scene,
        runs: &table.runs,
        findings: &findings,
        posterior: None,
    };
    let mut files = report::files(input, true).unwrap_or_else(|error| panic!("{error}"));
    for part in 0..MANY_FILES {
        let name = format!("draws/draws.zarr/many/c.{part}");
        files.whole.push((name, format!("{seed} {part}").into_bytes()));
    }
    for part in 0..SLOW_FILES {
        let fill: Box<Fill> = Box::new(move |both| {
            for (part, file) in both.iter_mut().enumerate() {
                std::thread::sleep(SLOWNESS);
                write!(file, "{seed} {part}")?;
            }
            say(PART);
            Ok(())
        });
        let names = ["one", "other"].map(|name| format!("draws/draws.zarr/slow/{name}/c.{part}"));
        files.streamed.push(Streamed { names, fill });
    }
    let last = move || -> File {
        say(LAST);
        ("timing.json".to_owned(), format!("{seed}").into_bytes())
    };
    files.last = Some(Box::new(last));
    say(WRITING);
    destination
        .and_then(|destination| destination.write(files))
        .unwrap_or_else(|error| panic!("{error}"));
}

/// Starts the child and waits until it has said a word so many times, or has ended.
fn start(out: &Path, seed: u64, how: &str, (word, times): (&str, usize)) -> Child {
    let mut command = Command::new(std::env::current_exe().expect("this test has a file"));
    command
        .args([
            "--exact",
            "replacing::a_slow_fit_that_nobody_kills_is_whole",
            "--nocapture",
            "--test-threads=1",
        ])
        .env(OUT, out)
        .env(SEED, seed.to_string())
        .env(HOW, how)
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut child = command.spawn().expect("it can be started");
    let mut said = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    let mut heard = 0;
    while heard < times && said.read_line(&mut line).expect("text") > 0 {
        heard += usize::from(line.trim() == word);
        line.clear();
    }
    // what it says after is nobody's concern, but it must find somebody to say it to
    std::thread::spawn(move || std::io::copy(&mut said, &mut std::io::sink()));
    child
}

fn kill(child: &Child, signal: &str) {
    let id = child.id().to_string();
    // a child that has ended and was not waited for still has its number
    let sent = Command::new("sh")
        .args(["-c", &format!("kill -s {signal} {id}")])
        .status();
    assert!(sent.expect("there is a shell").success());
}

/// A folder with a report in it, and what the reports of two seeds hold.
struct Scene {
    place: Folder,
    whole: [BTreeMap<PathBuf, Vec<u8>>; 2],
}

/// What stands at the place: the report of this seed, or neither.
#[derive(Debug, PartialEq)]
enum Stands {
    Whole(u64),
    Nothing,
    Mixed,
}

impl Scene {
    fn new(how: &str) -> Scene {
        let place = Folder::new();
        let out = place.join("report");
        let whole = [1, 2].map(|seed| {
            let mut child = start(&out, seed, how, (WRITING, 1));
            assert!(child.wait().expect("it ends").success());
            contents(&out)
        });
        assert!(whole[0].len() > 2 * SLOW_FILES + MANY_FILES && whole[0] != whole[1]);
        Scene { place, whole }
    }

    fn out(&self) -> PathBuf {
        self.place.join("report")
    }

    fn stands(&self) -> Stands {
        let now = contents(&self.out());
        match self.whole.iter().position(|whole| *whole == now) {
            Some(place) => Stands::Whole(place as u64 + 1),
            None if !self.out().exists() => Stands::Nothing,
            None => Stands::Mixed,
        }
    }
}

/// What became of many kills while a child was writing.
#[derive(Debug, Default)]
struct Tally {
    kills: usize,
    old_stood: usize,
    new_stood: usize,
    /// nothing stood until the next run put the old report back
    put_back: usize,
    /// the next run had something to clear
    left: usize,
}

/// Kills children at times spread over their writing, and holds that the old report or the new one stands after each.
fn kill_many(test: &str, how: &str) -> Tally {
    let scene = Scene::new(how);
    let is_two_steps = how == "two steps";
    let mut rng = rand::rngs::ChaCha8Rng::seed_from_u64(common::seed_of(test));
    let mut tally = Tally::default();
    let mut old = 2;
    // some children are faster than their signal
    for signal in SIGNALS.iter().cycle().take(3 * KILLS) {
        if tally.kills == KILLS {
            break;
        }
        let new = 3 - old;
        // half of them while the files are written, the others while the report is put in its place
        let at_most = Duration::from_millis(if is_two_steps { BETWEEN_STEPS + 10 } else { 8 });
        let (after, at_most) = if rng.random::<f64>() < 0.5 {
            ((PART, rng.random_range(1..=SLOW_FILES)), SLOWNESS)
        } else {
            ((LAST, 1), at_most)
        };
        let wait = at_most.mul_f64(rng.random::<f64>());
        let mut child = start(&scene.out(), new, how, after);
        std::thread::sleep(wait);
        if child.try_wait().expect("it can be asked").is_none() {
            kill(&child, signal);
            tally.kills += 1;
        }
        let status = child.wait().expect("it ends");
        let why = format!("{how}, SIG{signal} {wait:?} after {after:?}, {status}");
        let stood = scene.stands();
        let left = entries(scene.place.path()).len() - usize::from(stood != Stands::Nothing);
        if *signal == "KILL" {
            let may_stand = stood != Stands::Mixed && (is_two_steps || stood != Stands::Nothing);
            assert!(may_stand, "{why}: {stood:?}");
            tally.left += usize::from(left > 0);
            // the next run, whatever it is of
            staging::prepare(&scene.out()).unwrap_or_else(|error| panic!("{error}"));
            if stood == Stands::Nothing {
                tally.put_back += 1;
                assert_eq!(scene.stands(), Stands::Whole(old), "{why}: not put back");
            }
        } else {
            assert_eq!(left, 0, "{why}: {:?}", entries(scene.place.path()));
            assert!(matches!(status.code(), Some(0 | interruption::STATUS)), "{why}");
        }
        assert_eq!(entries(scene.place.path()), ["report"], "{why}");
        let Stands::Whole(stands) = scene.stands() else {
            panic!("{why}: {:?}", scene.stands());
        };
        tally.old_stood += usize::from(stands == old);
        tally.new_stood += usize::from(stands == new);
        old = stands;
    }
    // half of the kills while files are written, less two standard deviations
    assert_eq!(tally.kills, KILLS, "{tally:?}");
    assert!(tally.old_stood > 13 && tally.new_stood > 0, "{tally:?}");
    tally
}

#[test]
fn a_slow_fit_that_nobody_kills_is_whole() {
    if let Some(out) = std::env::var_os(OUT) {
        return fit_slowly(Path::new(&out));
    }
    let scene = Scene::new("exchange");
    assert_eq!(scene.stands(), Stands::Whole(2));
    assert_eq!(entries(scene.place.path()), ["report"]);
}

/// Kills by all signals.
const KILLS: usize = 40;

/// Also where there is no exchange: then the next run puts the old report back. Both at once, since they mostly wait.
#[test]
#[ignore = "slow: run with --ignored"]
fn under_every_signal_the_old_report_or_the_new_one_stands_whole() {
    let two_steps = std::thread::spawn(|| {
        let test = "where_there_is_no_exchange_the_next_run_puts_the_old_report_back";
        kill_many(test, "two steps")
    });
    let test = "under_every_signal_the_old_report_or_the_new_one_stands_whole";
    let tally = kill_many(test, "exchange");
    assert!(tally.left > 1 && tally.put_back == 0, "{tally:?}");
    let tally = two_steps.join().expect("reports that stand whole");
    assert!(tally.put_back > 0, "{tally:?}");
}
