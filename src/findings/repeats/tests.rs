//! Tests of the search for rows that repeat others.

use std::ops::Range;
use std::path::Path;
use std::sync::LazyLock;

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::physics::numbers::GRAVITY;
use crate::runs::{arrange, NewRun};
use crate::scene::{self, Scene};
use crate::seed::stream;

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let text = "[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n\
                [liquids.oil]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
    scene::parse(text, Path::new("a/scene.toml"), String::new()).unwrap_or_else(|error| panic!("{error}"))
});

/// How the tables of one kind are made.
#[derive(Clone, Copy)]
struct Kind {
    /// the last digit of a restitution
    step: f64,
    /// what restitutions scatter by
    sd: f64,
    /// runs of a setting
    repeats: usize,
    /// what speeds are spread by about the set ones, as a share
    speeds: f64,
}

fn kind([step, sd]: [f64; 2], repeats: usize, speeds: f64) -> Kind {
    Kind {
        step,
        sd,
        repeats,
        speeds,
    }
}

fn rounded(x: f64, step: f64) -> f64 {
    format!("{:.6}", (x / step).round() * step).parse().unwrap_or(x)
}

type Run = NewRun<'static>;

/// A run of a sphere on a dry plate, or on one with this film and film ratio.
fn run(film: Option<(f64, f64)>, impact_speed: f64, restitution: f64) -> Run {
    NewRun {
        particle: "PTFE",
        liquid: film.map(|_| "oil"),
        diameter: 4.762e-3,
        film,
        impact_speed,
        restitution,
    }
}

const FILMS: [Option<(f64, f64)>; 3] = [None, Some((286e-6, 0.06)), Some((381e-6, 0.08))];

/// The restitution about which runs scatter.
fn law(film: Option<(f64, f64)>, v: f64) -> f64 {
    1.0 - 0.18 * v.powf(0.2) - film.map_or(0.0, |_| 0.15 / v)
}

/// Runs with their speeds and restitutions rounded to these steps.
fn coarse(rows: &[Run], steps: [f64; 2]) -> Vec<Run> {
    let coarse = |run: &Run| NewRun {
        impact_speed: rounded(run.impact_speed, steps[0]),
        restitution: rounded(run.restitution, steps[1]),
        ..*run
    };
    rows.iter().map(coarse).collect()
}

/// The mean of some runs, its speed and restitution rounded to these steps.
fn mean(block: &[Run], steps: [f64; 2]) -> Run {
    let mean = |of: fn(&Run) -> f64| block.iter().map(of).sum::<f64>() / block.len() as f64;
    let exact = NewRun {
        impact_speed: mean(|run| run.impact_speed),
        restitution: mean(|run| run.restitution),
        ..block[0]
    };
    coarse(&[exact], steps)[0]
}

/// The table of these blocks with the mean of each below it, above it, and at the foot of the table.
fn with_means(blocks: &[&[Run]], steps: [f64; 2]) -> [Vec<Run>; 3] {
    let below = blocks.iter().flat_map(|block| [*block, &[mean(block, steps)]].concat());
    let above = blocks.iter().flat_map(|block| [&[mean(block, steps)], *block].concat());
    let foot = blocks.iter().map(|block| mean(block, steps));
    let foot = blocks.concat().into_iter().chain(foot);
    [below.collect(), above.collect(), foot.collect()]
}

/// Dry runs and those of two films, down to near sticking; a few scatter more than the others.
fn table(kind: Kind, set: u64) -> Vec<Run> {
    let mut rng = stream(7, "tables without repeats", set);
    let mut all = vec![];
    for film in FILMS {
        for speed in [0.45, 0.77, 1.08, 1.4, 1.71] {
            for _ in 0..kind.repeats {
                let noise: f64 = StandardNormal.sample(&mut rng);
                let wider = if rng.random_range(0..20) == 0 { 3.0 } else { 1.0 };
                let spread: f64 = StandardNormal.sample(&mut rng);
                let v = rounded(speed * (1.0 + kind.speeds * spread), 0.001);
                let e = (law(film, v) + wider * kind.sd * noise).max(0.0);
                all.push(run(film, v, rounded(e, kind.step)));
            }
        }
    }
    all
}

/// What forbids quoting these rows.
fn forbidding(rows: &[Run], residual_sd: Option<f64>) -> Vec<Remark> {
    let mut found = check_rows(&arrange(&SCENE, rows), residual_sd);
    found.retain(Remark::forbids);
    found
}

fn codes(rows: &[Run]) -> Vec<&'static str> {
    forbidding(rows, None).iter().map(|remark| remark.code).collect()
}

fn tells(rows: &[Run], code: &str) -> bool {
    codes(rows).contains(&code)
}

#[track_caller]
fn assert_codes(rows: &[Run], expected: &[&str]) {
    assert_eq!(codes(rows), expected);
}

/// How many of these tables are questioned.
fn alarms(sets: Range<u64>, table: impl Fn(u64) -> Vec<Run>) -> usize {
    sets.filter(|set| !codes(&table(*set)).is_empty()).count()
}

fn kinds() -> Vec<Kind> {
    const DIGITS: [[f64; 2]; 5] = [
        [0.01, 0.015],
        [0.01, 0.003],
        [0.001, 0.015],
        [0.001, 0.004],
        [1e-4, 0.01],
    ];
    let mut kinds = vec![];
    for of_setting in [&[3, 10][..], &[2]] {
        for digits in DIGITS {
            for repeats in of_setting {
                for speeds in [0.0, 0.01] {
                    kinds.push(kind(digits, *repeats, speeds));
                }
            }
        }
    }
    kinds
}

#[test]
fn runs_that_agree_by_rounding_are_let_be() {
    let of_kind = |(place, kind): (usize, Kind)| alarms(0..100, |set| table(kind, 1000 * place as u64 + set));
    let found: Vec<usize> = kinds().into_iter().enumerate().map(of_kind).collect();
    // 1 % of 3,000 tables, and no kind of table with many
    assert!(
        found.iter().sum::<usize>() <= 30 && found.iter().all(|alarms| *alarms <= 3),
        "{found:?}"
    );
    // of three repeats with two values between them the mean is halfway, and both are it
    let of_two_values = |set: u64| kind([0.01, [0.004, 0.005, 0.006][set as usize % 3]], 3, 0.0);
    let found = alarms(0..300, |set| table(of_two_values(set), 210_000 + set));
    assert!(found <= 3, "{found}");
}

/// Where each speed was set once a film, a copy is all that the rows at it tell of their scatter: the laws tell it.
#[test]
fn copies_in_another_order_at_set_speeds_are_found() {
    const SCATTER: f64 = 0.015;
    let is_found = |rows: &[Run], residual_sd: Option<f64>| {
        let found = forbidding(rows, residual_sd);
        found.iter().any(|remark| remark.code == "repeated_rows")
    };
    for set in 0..3 {
        let mut rng = stream(7, "copies in another order", set);
        let mut rows = vec![];
        for film in (0..12).map(|film| (140.0 + 20.0 * f64::from(film)) * 1e-6) {
            for v in [0.45, 0.77, 1.08f64] {
                let noise: f64 = StandardNormal.sample(&mut rng);
                let film = Some((film, film / 4.762e-3));
                rows.push(run(film, v, rounded(law(film, v) + SCATTER * noise, 1e-4)));
            }
        }
        let again: Vec<Run> = rows.iter().chain(rows[..12].iter().rev()).copied().collect();
        assert!(
            is_found(&again, Some(SCATTER)) && !is_found(&rows, Some(SCATTER)),
            "{set}"
        );
        // the planted fault: what the laws leave is not known
        assert!(!is_found(&again, None), "{set}");
    }
}

#[test]
fn pasted_blocks_and_means_are_found() {
    for (place, kind) in kinds().into_iter().enumerate() {
        let rows = table(kind, 50_000 + place as u64);
        // half of the table pasted below it, all of it, and all of it twice
        let (half, all) = (&rows[..rows.len() / 2], &rows[..]);
        for pasted in [[half].concat(), [all].concat(), [all, all].concat()] {
            let is_found = tells(&[&rows[..], &pasted].concat(), "repeated_rows");
            // where nearly every run has the same digits as its neighbours, nobody can tell, nor by pairs of two digits
            let is_plain = kind.sd < 0.5 * kind.step || kind.repeats == 2 && kind.step >= 0.01;
            assert!(is_plain || is_found, "{place}");
        }
        let blocks: Vec<&[Run]> = rows.chunks(kind.repeats).collect();
        let fine = with_means(&blocks, [0.001, kind.step]);
        let [coarse, ..] = with_means(&blocks, [0.001, 0.01]);
        let is_fine = kind.step <= 0.1 * kind.sd;
        for (at, table) in fine.iter().chain([&coarse]).enumerate() {
            // where the mean is known to about the digits that the last has, nobody can tell
            let is_told = is_fine && (at < 3 || kind.repeats > 3 && kind.sd > 0.01);
            assert!(!is_told || tells(table, "mean_rows"), "{place}, {at}");
        }
    }
}

/// The median of an odd number of runs is one of them, as a repeat is that chance may make.
#[test]
fn medians_without_a_name_are_found() {
    for (place, step) in [0.001, 1e-4].into_iter().enumerate() {
        let rows = table(kind([step, 0.012], 5, 0.01), 60_000 + place as u64);
        let middle = |block: &[Run], of: fn(&Run) -> f64| {
            let mut values: Vec<f64> = block.iter().map(of).collect();
            crate::distributions::median(&mut values).expect("some runs")
        };
        let with_median = |block: &[Run]| {
            let median = NewRun {
                impact_speed: middle(block, |run| run.impact_speed),
                restitution: middle(block, |run| run.restitution),
                ..block[0]
            };
            [block, &[median]].concat()
        };
        let below: Vec<Run> = rows.chunks(5).flat_map(with_median).collect();
        assert!(tells(&below, "mean_rows") && !tells(&rows, "mean_rows"), "{step}");
    }
}

/// With two digits in both, so that chance makes every sixth run the mean of the others.
#[test]
fn means_of_two_digits_stand_at_the_end_of_their_setting() {
    const TWO_DIGITS: [f64; 2] = [0.01; 2];
    let (mut questioned, mut missed) = (0, vec![]);
    for set in 0..300 {
        let sd = [0.005, 0.01, 0.02][set as usize % 3];
        let speeds = [0.003, 0.006, 0.01][set as usize / 9 % 3];
        let kind = kind([0.01, sd], [4, 5, 8][set as usize / 3 % 3], speeds);
        let rows = coarse(&table(kind, 200_000 + set), TWO_DIGITS);
        questioned += usize::from(!codes(&rows).is_empty());
        let blocks: Vec<&[Run]> = rows.chunks(kind.repeats).collect();
        let [below, above, _] = with_means(&blocks, TWO_DIGITS);
        for table in [below, above] {
            // where nearly every run has the digits of the mean, nobody can tell
            let is_plain = kind.sd < 0.01 && kind.speeds < 0.01;
            if !is_plain && !tells(&table, "mean_rows") {
                missed.push((kind.sd, kind.repeats, kind.speeds));
            }
        }
    }
    assert!(questioned <= 3 && missed.is_empty(), "{questioned} {missed:?}");
}

/// Dry runs and those of two films at varied speeds, in blocks: measured ones anywhere, or set ones, evenly and not, the mean
/// of which is one of them, with a scatter about them and without.
fn varied(count: usize, [speed_step, step]: [f64; 2], set: u64) -> Vec<Vec<Run>> {
    const SET: [[f64; 5]; 2] = [[0.5, 0.9, 1.3, 1.7, 2.1], [0.5, 0.8, 1.0, 1.2, 1.5]];
    let mut rng = stream(7, "tables at varied speeds", set);
    let design = set as usize % 5;
    let mut block = |film: Option<(f64, f64)>, count: usize| -> Vec<Run> {
        let draw = |at: usize| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            let spread: f64 = StandardNormal.sample(&mut rng);
            let speed = match design {
                0 => rng.random_range(0.5..2.4),
                1 | 2 => SET[design - 1][at % 5],
                _ => SET[design - 3][at % 5] * (1.0 + 0.01 * spread),
            };
            let v = rounded(speed, speed_step);
            run(film, v, rounded(law(film, v) + 0.01 * noise, step))
        };
        (0..count).map(draw).collect()
    };
    (0..3).map(|at| block(FILMS[at], (count + at) / 3)).collect()
}

#[test]
fn means_of_groups_at_all_speeds_are_found() {
    for (set, steps) in (0..40).zip([[1e-3, 1e-3], [1e-3, 1e-4], [1e-4, 1e-3], [1e-4, 1e-4]].iter().cycle()) {
        // measured speeds: one that was set may be a mean by design
        let blocks = varied(12 + 3 * set as usize, *steps, 5 * set);
        let blocks: Vec<&[Run]> = blocks.iter().map(Vec::as_slice).collect();
        let [below, _, foot] = with_means(&blocks, *steps);
        for (at, table) in [below, foot].iter().enumerate() {
            assert!(tells(table, "mean_rows"), "{set} {at} {steps:?}");
        }
    }
}

#[test]
fn right_tables_of_varied_speeds_have_no_means() {
    const STEPS: [f64; 3] = [1e-2, 1e-3, 1e-4];
    let is_questioned = |set: &u64| {
        let at = *set as usize;
        let steps = [STEPS[at / 5 % 3], STEPS[at / 15 % 3]];
        tells(&varied(12 + at * 7 % 289, steps, 1000 + set).concat(), "mean_rows")
    };
    let questioned: Vec<u64> = (0..900).filter(is_questioned).collect();
    assert_eq!(questioned, [0; 0]);
}

/// Holds that hardly a table is questioned of what is made of runs written with steps below this one.
#[track_caller]
fn assert_let_be(coarsest: f64, from: u64, made: impl Fn(&[Run]) -> Vec<Run>) {
    let kinds = kinds().into_iter().enumerate();
    for (place, kind) in kinds.filter(|(_, kind)| kind.step < coarsest) {
        let found = alarms(0..20, |set| made(&table(kind, from + 100 * place as u64 + set)));
        assert!(found <= 1, "{place}: {found}");
    }
}

/// Written with four digits, but made from heights of rebound read to a millimetre, or from speeds read to 0.01 m/s.
#[test]
fn restitutions_of_coarse_readings_are_let_be() {
    let of_height: fn(f64) -> f64 =
        |rebound| (2.0 * GRAVITY * rounded(rebound * rebound / (2.0 * GRAVITY), 0.001)).sqrt();
    for read in [of_height, |rebound| rounded(rebound, 0.01)] {
        let made = |one: &Run| NewRun {
            restitution: rounded(read(one.impact_speed * one.restitution) / one.impact_speed, 1e-4),
            ..*one
        };
        // without the digits of its own a table is as fine as it is read
        assert_let_be(0.01, 70_000, |rows| {
            let clear = rows.iter().filter(|one| one.impact_speed > 0.7);
            clear.map(made).collect()
        });
    }
}

#[test]
fn a_copy_with_fewer_digits_is_one() {
    for (place, kind) in kinds().into_iter().enumerate() {
        let rows = table(kind, 90_000 + place as u64);
        // where nearly every run of a setting has the same digits then, nobody can tell
        let is_told = kind.sd > 0.0075 && kind.step < 0.01;
        let from = [0, rows.len() / 3];
        for (speed, from) in [(0.01, from[0]), (1e-3, from[0]), (0.01, from[1])] {
            let copied = coarse(&rows[from..], [speed, 0.01]);
            // fewer digits repeat each other, too, which may be what is told
            let is_found = tells(&[&rows[..], &copied].concat(), "repeated_rows");
            assert!(is_found || !is_told || copied.len() < 40, "{place} {speed} {from}");
            // the same design anew, written with fewer digits
            let anew = coarse(&table(kind, 95_000 + place as u64), [speed, 0.01]);
            let is_found = tells(&[&rows[..], &anew].concat(), "repeated_rows");
            assert!(!is_found, "{place} {speed}");
        }
        // in the order of what was rounded
        let mut sorted = coarse(&rows, [1e-3, 0.01]);
        sorted.sort_by(|one, other| one.restitution.total_cmp(&other.restitution));
        let is_measured = kind.speeds > 0.0 && kind.repeats < 10;
        let is_found = tells(&[&rows[..], &sorted].concat(), "repeated_rows");
        assert!(is_found || !is_told || !is_measured, "{place}");
    }
}

/// Every other restitution with two digits of four, and speeds in steps of the frames of a camera.
#[test]
fn digits_and_steps_of_their_own_are_let_be() {
    /// m/s between frames
    const FRAME: f64 = 0.0137;
    let mixed = |(at, one): (usize, &Run)| NewRun {
        restitution: rounded(one.restitution, if at % 2 == 0 { 1e-4 } else { 0.01 }),
        ..*one
    };
    let of_frames = |(_, one): (usize, &Run)| {
        let in_frames = |speed: f64| rounded(rounded(speed / FRAME, 1.0) * FRAME, 0.001);
        let speed = in_frames(one.impact_speed);
        NewRun {
            impact_speed: speed,
            restitution: in_frames(one.impact_speed * one.restitution) / speed,
            ..*one
        }
    };
    for made in [mixed, of_frames as fn((usize, &Run)) -> Run] {
        assert_let_be(0.001, 110_000, |rows| rows.iter().enumerate().map(made).collect());
    }
}

/// Rebounds from speeds evenly apart lie nearly evenly apart, too, and are no steps to which restitutions were rounded; and a
/// few copies of fewer digits are seen although they are few.
#[test]
fn speeds_evenly_apart_and_short_digits_hide_no_copy() {
    let even = |(at, one): (usize, &Run)| {
        let v = 0.5 + 0.12 * (at % 15) as f64;
        let restitution = one.restitution + law(one.film, v) - law(one.film, one.impact_speed);
        NewRun {
            impact_speed: rounded(v, 0.01),
            restitution: rounded(restitution, 1e-4),
            ..*one
        }
    };
    let mut found = 0;
    for set in 0..20 {
        let rows = table(kind([1e-4, 0.003], 3, 0.0), 130_000 + set);
        let rows: Vec<Run> = rows.iter().enumerate().map(even).collect();
        assert_codes(&rows, &[]);
        assert_codes(&[&rows[..], &rows].concat(), &["repeated_rows"]);
        let rows = table(kind([1e-4, 0.015], 3, 0.1), 140_000 + set);
        let few = coarse(&rows[12..22], [0.001, 0.01]);
        assert_codes(&rows, &[]);
        found += usize::from(codes(&[&rows[..], &few[..]].concat()) == ["repeated_rows"]);
    }
    // where two of the copied runs happen to have one speed, it may be one that was set, and restitutions alone say too little
    assert!(found >= 14, "{found}");
}

#[test]
fn a_copy_in_other_units_is_one() {
    let rows = table(kinds()[8], 3);
    let in_other_units = |run: &Run| NewRun {
        impact_speed: run.impact_speed * (1.0 + f64::EPSILON),
        film: run.film.map(|(film, ratio)| (film * (1.0 - f64::EPSILON), ratio)),
        ..*run
    };
    let copied: Vec<Run> = rows.iter().map(in_other_units).collect();
    assert_codes(&[rows, copied].concat(), &["repeated_rows"]);
}

/// Under another film, where a setting of its own has the same speeds by design.
#[test]
fn a_block_pasted_under_another_setting_is_found() {
    for set in 0..10 {
        let speeds = [0.0, 0.01][set as usize % 2];
        let mut rows = table(kind([1e-3, 0.008], 3, speeds), 220_000 + set);
        assert_codes(&rows, &[]);
        for at in 30..45 {
            let [from, to] = [rows[at - 15], rows[at]];
            rows[at] = NewRun { film: to.film, ..from };
        }
        assert_codes(&rows, &["repeated_rows"]);
        let found = forbidding(&rows, None);
        assert!(found[0].text.contains("under another setting too"), "{}", found[0].text);
    }
}

#[test]
fn restitutions_that_were_filled_down_are_found() {
    for set in 0..10 {
        let mut rows = table(kind([1e-4, 0.006], 3, 0.02), 230_000 + set);
        for at in 0..rows.len() / 3 {
            rows[3 * at + 1].restitution = rows[3 * at].restitution;
        }
        let found = forbidding(&rows, None);
        let filled = found.iter().filter(|check| check.next_step.contains("filled down"));
        assert_eq!(filled.count(), 1, "{set}: {found:?}");
    }
}

/// Every other row is the second impact of the drop above it; the twin is a sweep of speeds that were set where rebounds end.
#[test]
fn second_impacts_are_found_and_sweeps_are_not() {
    for set in 0..50 {
        let mut rng = stream(7, "second impacts", set);
        let law = |v: f64| 1.0 - 0.18 * v.powf(0.2) - 0.1 / v;
        let mut restitution = |v: f64| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            rounded(law(v) + 0.015 * noise, 0.001)
        };
        let row = |v: f64, e: f64| run(Some((286e-6, 0.06)), v, e);
        let (mut drops, mut sweeps) = (vec![], vec![]);
        for drop in 0..20 {
            let first = rounded(1.0 + 0.031 * f64::from(drop), 0.001);
            let e = restitution(first);
            let second = rounded(first * e, 0.001);
            drops.extend([row(first, e), row(second, restitution(second))]);
            let mut v = 1.6;
            for _ in 0..4 {
                sweeps.push(row(v, restitution(v)));
                v = rounded(v * law(v), 0.001);
            }
        }
        assert_codes(&drops, &["second_impacts"]);
        assert_codes(&sweeps, &[]);
    }
}
