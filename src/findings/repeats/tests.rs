//! Tests of the search for rows that repeat others.

use std::path::Path;

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::physics::numbers::GRAVITY;
use crate::runs::{arrange, NewRun};
use crate::scene::{self, Scene};
use crate::seed::stream;

fn scene() -> Scene {
    let text = "[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n\
                [liquids.oil]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
    scene::parse(text, Path::new("a/scene.toml"), String::new()).unwrap_or_else(|error| panic!("{error}"))
}

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

fn rounded(x: f64, step: f64) -> f64 {
    format!("{:.6}", (x / step).round() * step).parse().unwrap_or(x)
}

/// A run of a sphere on a dry plate, or on one with this film and film ratio.
fn run(film: Option<(f64, f64)>, impact_speed: f64, restitution: f64) -> NewRun<'static> {
    NewRun {
        particle: "PTFE",
        liquid: film.map(|_| "oil"),
        diameter: 4.762e-3,
        film,
        impact_speed,
        restitution,
    }
}

/// The mean of some runs, its speed and restitution rounded to these steps.
fn mean(block: &[NewRun<'static>], steps: [f64; 2]) -> NewRun<'static> {
    let mean = |of: fn(&NewRun) -> f64| block.iter().map(of).sum::<f64>() / block.len() as f64;
    NewRun {
        impact_speed: rounded(mean(|run| run.impact_speed), steps[0]),
        restitution: rounded(mean(|run| run.restitution), steps[1]),
        ..block[0]
    }
}

/// Dry runs and those of two films, down to near sticking; a few scatter more than the others.
fn table(kind: Kind, set: u64) -> Vec<NewRun<'static>> {
    let mut rng = stream(7, "tables without repeats", set);
    let mut all = vec![];
    for film in [None, Some((286e-6, 0.06)), Some((381e-6, 0.08))] {
        for speed in [0.45, 0.77, 1.08, 1.4, 1.71] {
            for _ in 0..kind.repeats {
                let noise: f64 = StandardNormal.sample(&mut rng);
                let wider = if rng.random_range(0..20) == 0 { 3.0 } else { 1.0 };
                let spread: f64 = StandardNormal.sample(&mut rng);
                let v = rounded(speed * (1.0 + kind.speeds * spread), 0.001);
                let loss = film.map_or(0.0, |_| 0.15 / v);
                let e = (1.0 - 0.18 * v.powf(0.2) - loss + wider * kind.sd * noise).max(0.0);
                all.push(run(film, v, rounded(e, kind.step)));
            }
        }
    }
    all
}

fn codes(rows: &[NewRun]) -> Vec<&'static str> {
    let found = check_rows(&arrange(&scene(), rows), None);
    let forbidding = found.iter().filter(|remark| remark.forbids());
    forbidding.map(|remark| remark.code).collect()
}

fn kinds() -> Vec<Kind> {
    const DIGITS: [(f64, f64); 5] = [
        (0.01, 0.015),
        (0.01, 0.003),
        (0.001, 0.015),
        (0.001, 0.004),
        (1e-4, 0.01),
    ];
    let mut kinds = vec![];
    for of_setting in [&[3, 10][..], &[2]] {
        for (step, sd) in DIGITS {
            for repeats in of_setting {
                for speeds in [0.0, 0.01] {
                    kinds.push(Kind {
                        step,
                        sd,
                        repeats: *repeats,
                        speeds,
                    });
                }
            }
        }
    }
    kinds
}

#[test]
fn runs_that_agree_by_rounding_are_let_be() {
    const SETS: u64 = 100;
    let mut found = vec![];
    for (place, kind) in kinds().into_iter().enumerate() {
        let alarms = (0..SETS).filter(|set| !codes(&table(kind, 1000 * place as u64 + set)).is_empty());
        found.push(alarms.count());
    }
    // 1 % of 3,000 tables, and no kind of table with many
    assert!(
        found.iter().sum::<usize>() <= 30 && found.iter().all(|alarms| *alarms <= 3),
        "{found:?}"
    );
}

/// Where each speed was set once a film, a copy is all that the rows at it tell of their scatter: the laws tell it.
#[test]
fn copies_in_another_order_at_set_speeds_are_found() {
    const SCATTER: f64 = 0.015;
    let is_found = |rows: &[NewRun], residual_sd: Option<f64>| {
        let found = check_rows(&arrange(&scene(), rows), residual_sd);
        let mut forbidding = found.iter().filter(|remark| remark.forbids());
        forbidding.any(|remark| remark.code == "repeated_rows")
    };
    for set in 0..3 {
        let mut rng = stream(7, "copies in another order", set);
        let mut rows = vec![];
        for film in (0..12).map(|film| (140.0 + 20.0 * f64::from(film)) * 1e-6) {
            for v in [0.45, 0.77, 1.08f64] {
                let noise: f64 = StandardNormal.sample(&mut rng);
                let e = 1.0 - 0.18 * v.powf(0.2) - 0.15 / v + SCATTER * noise;
                rows.push(run(Some((film, film / 4.762e-3)), v, rounded(e, 1e-4)));
            }
        }
        let again: Vec<NewRun> = rows.iter().chain(rows[..12].iter().rev()).copied().collect();
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
            let again: Vec<NewRun> = [&rows[..], &pasted].concat();
            let found = codes(&again);
            // where nearly every run has the same digits as its neighbours, nobody can tell, nor by pairs of two digits
            let is_plain = kind.sd < 0.5 * kind.step || kind.repeats == 2 && kind.step >= 0.01;
            assert!(is_plain || found.contains(&"repeated_rows"), "{place}: {found:?}");
        }
        let mean = |block: &[NewRun<'static>], step: f64| mean(block, [0.001, step]);
        let blocks = || rows.chunks(kind.repeats);
        let below = blocks().flat_map(|block| [block, &[mean(block, kind.step)]].concat());
        let above = blocks().flat_map(|block| [&[mean(block, kind.step)], block].concat());
        let foot = rows.iter().copied().chain(blocks().map(|block| mean(block, kind.step)));
        let coarse = blocks().flat_map(|block| [block, &[mean(block, 0.01)]].concat());
        let tables: [Vec<NewRun>; 4] = [below.collect(), above.collect(), foot.collect(), coarse.collect()];
        let is_fine = kind.step <= 0.1 * kind.sd;
        for (at, table) in tables.iter().enumerate() {
            // where the mean is known to about the digits that the last has, nobody can tell
            let is_told = is_fine && (at < 3 || kind.repeats > 3 && kind.sd > 0.01);
            assert!(!is_told || codes(table).contains(&"mean_rows"), "{place}, {at}");
        }
    }
}

/// Of three repeats with two values between them the mean is halfway, and both are it.
#[test]
fn repeats_of_two_values_are_no_means() {
    let mut alarms = 0;
    for set in 0..300 {
        let kind = Kind {
            step: 0.01,
            sd: [0.004, 0.005, 0.006][set as usize % 3],
            repeats: 3,
            speeds: 0.0,
        };
        alarms += usize::from(!codes(&table(kind, 210_000 + set)).is_empty());
    }
    assert!(alarms <= 3, "{alarms}");
}

/// With two digits in both, so that chance makes every sixth run the mean of the others.
#[test]
fn means_of_two_digits_stand_at_the_end_of_their_setting() {
    let rounded_to_two = |run: &NewRun<'static>| NewRun {
        impact_speed: rounded(run.impact_speed, 0.01),
        restitution: rounded(run.restitution, 0.01),
        ..*run
    };
    let mean = |block: &[NewRun<'static>]| {
        let mean = |of: fn(&NewRun) -> f64| block.iter().map(of).sum::<f64>() / block.len() as f64;
        rounded_to_two(&NewRun {
            impact_speed: mean(|run| run.impact_speed),
            restitution: mean(|run| run.restitution),
            ..block[0]
        })
    };
    let (mut alarms, mut missed) = (0, vec![]);
    for set in 0..300 {
        let kind = Kind {
            step: 0.01,
            sd: [0.005, 0.01, 0.02][set as usize % 3],
            repeats: [4, 5, 8][set as usize / 3 % 3],
            speeds: [0.003, 0.006, 0.01][set as usize / 9 % 3],
        };
        let rows: Vec<NewRun> = table(kind, 200_000 + set).iter().map(rounded_to_two).collect();
        alarms += usize::from(!codes(&rows).is_empty());
        let blocks = || rows.chunks(kind.repeats);
        let below: Vec<NewRun> = blocks().flat_map(|block| [block, &[mean(block)]].concat()).collect();
        let above: Vec<NewRun> = blocks().flat_map(|block| [&[mean(block)], block].concat()).collect();
        for table in [below, above] {
            // where nearly every run has the digits of the mean, nobody can tell
            let is_plain = kind.sd < 0.01 && kind.speeds < 0.01;
            if !is_plain && !codes(&table).contains(&"mean_rows") {
                missed.push((kind.sd, kind.repeats, kind.speeds));
            }
        }
    }
    assert!(alarms <= 3 && missed.is_empty(), "{alarms} {missed:?}");
}

/// Dry runs and those of two films at varied speeds, in blocks: measured ones anywhere, or set ones, evenly and not, the mean
/// of which is one of them, with a scatter about them and without.
fn varied(count: usize, [speed_step, step]: [f64; 2], set: u64) -> Vec<Vec<NewRun<'static>>> {
    const SET: [[f64; 5]; 2] = [[0.5, 0.9, 1.3, 1.7, 2.1], [0.5, 0.8, 1.0, 1.2, 1.5]];
    let mut rng = stream(7, "tables at varied speeds", set);
    let design = set as usize % 5;
    let mut block = |film: Option<(f64, f64)>, count: usize| -> Vec<NewRun<'static>> {
        let draw = |at: usize| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            let spread: f64 = StandardNormal.sample(&mut rng);
            let speed = match design {
                0 => rng.random_range(0.5..2.4),
                1 | 2 => SET[design - 1][at % 5],
                _ => SET[design - 3][at % 5] * (1.0 + 0.01 * spread),
            };
            let v = rounded(speed, speed_step);
            let e = 1.0 - 0.18 * v.powf(0.2) - film.map_or(0.0, |_| 0.15 / v) + 0.01 * noise;
            run(film, v, rounded(e, step))
        };
        (0..count).map(draw).collect()
    };
    let films = [None, Some((286e-6, 0.06)), Some((381e-6, 0.08))];
    (0..3).map(|at| block(films[at], (count + at) / 3)).collect()
}

#[test]
fn means_of_groups_at_all_speeds_are_found() {
    for (set, steps) in (0..40).zip([[1e-3, 1e-3], [1e-3, 1e-4], [1e-4, 1e-3], [1e-4, 1e-4]].iter().cycle()) {
        // measured speeds: one that was set may be a mean by design
        let blocks = varied(12 + 3 * set as usize, *steps, 5 * set);
        let below = blocks
            .iter()
            .flat_map(|block| [&block[..], &[mean(block, *steps)]].concat());
        let means = blocks.iter().map(|block| mean(block, *steps));
        let foot = blocks.concat().into_iter().chain(means);
        for (at, table) in [below.collect::<Vec<_>>(), foot.collect()].iter().enumerate() {
            assert!(codes(table).contains(&"mean_rows"), "{set} {at} {steps:?}");
        }
    }
}

#[test]
fn right_tables_of_varied_speeds_have_no_means() {
    const STEPS: [f64; 3] = [1e-2, 1e-3, 1e-4];
    let is_questioned = |set: &u64| {
        let at = *set as usize;
        let steps = [STEPS[at / 5 % 3], STEPS[at / 15 % 3]];
        let table = varied(12 + at * 7 % 289, steps, 1000 + set).concat();
        codes(&table).contains(&"mean_rows")
    };
    let questioned: Vec<u64> = (0..900).filter(is_questioned).collect();
    assert_eq!(questioned, [0; 0]);
}

/// Written with four digits, but made from heights of rebound read to a millimetre, or from speeds read to 0.01 m/s.
#[test]
fn restitutions_of_coarse_readings_are_let_be() {
    // without the digits of its own a table is as fine as it is read
    for (place, kind) in kinds().into_iter().enumerate().filter(|(_, kind)| kind.step < 0.01) {
        let made = |one: &NewRun<'static>, by_height: bool| {
            let v = one.impact_speed;
            let rebound = v * one.restitution;
            let e = if by_height {
                let height = rounded(rebound * rebound / (2.0 * GRAVITY), 0.001);
                (2.0 * GRAVITY * height).sqrt() / v
            } else {
                rounded(rebound, 0.01) / v
            };
            NewRun {
                restitution: rounded(e, 1e-4),
                ..*one
            }
        };
        let is_clear = |one: &NewRun| one.impact_speed > 0.7;
        for by_height in [true, false] {
            let alarms = (0..20).filter(|set| {
                let rows = table(kind, 70_000 + 100 * place as u64 + set);
                let rows: Vec<NewRun> = rows
                    .iter()
                    .filter(|one| is_clear(one))
                    .map(|one| made(one, by_height))
                    .collect();
                !codes(&rows).is_empty()
            });
            assert!(alarms.count() <= 1, "{place} {by_height}");
        }
    }
}

#[test]
fn a_copy_with_fewer_digits_is_one() {
    let fewer = |run: &NewRun<'static>, speed: f64, restitution: f64| NewRun {
        impact_speed: rounded(run.impact_speed, speed),
        restitution: rounded(run.restitution, restitution),
        ..*run
    };
    for (place, kind) in kinds().into_iter().enumerate() {
        let rows = table(kind, 90_000 + place as u64);
        // where nearly every run of a setting has the same digits then, nobody can tell
        let is_told = kind.sd > 0.0075 && kind.step < 0.01;
        let from = [0, rows.len() / 3];
        for (speed, from) in [(0.01, from[0]), (1e-3, from[0]), (0.01, from[1])] {
            let copied = rows[from..].iter().map(|run| fewer(run, speed, 0.01));
            let copied: Vec<NewRun> = copied.collect();
            // fewer digits repeat each other, too, which may be what is told
            let is_found = codes(&[&rows[..], &copied].concat()).contains(&"repeated_rows");
            assert!(is_found || !is_told || copied.len() < 40, "{place} {speed} {from}");
            // the same design anew, written with fewer digits
            let anew = table(kind, 95_000 + place as u64);
            let anew: Vec<NewRun> = anew.iter().map(|run| fewer(run, speed, 0.01)).collect();
            let found = codes(&[&rows[..], &anew].concat());
            assert!(!found.contains(&"repeated_rows"), "{place} {speed}");
        }
        // in the order of what was rounded
        let mut sorted: Vec<NewRun> = rows.iter().map(|run| fewer(run, 1e-3, 0.01)).collect();
        sorted.sort_by(|one, other| one.restitution.total_cmp(&other.restitution));
        let is_measured = kind.speeds > 0.0 && kind.repeats < 10;
        let is_found = codes(&[&rows[..], &sorted].concat()).contains(&"repeated_rows");
        assert!(is_found || !is_told || !is_measured, "{place}");
    }
}

/// Every other restitution with two digits of four, speeds in steps of the frames of a camera, and speeds evenly apart.
#[test]
fn digits_and_steps_of_their_own_are_let_be() {
    /// m/s between frames
    const FRAME: f64 = 0.0137;
    let mixed = |(at, one): (usize, &NewRun<'static>)| NewRun {
        restitution: rounded(one.restitution, if at % 2 == 0 { 1e-4 } else { 0.01 }),
        ..*one
    };
    let of_frames = |(_, one): (usize, &NewRun<'static>)| {
        let speed = rounded(rounded(one.impact_speed / FRAME, 1.0) * FRAME, 0.001);
        NewRun {
            impact_speed: speed,
            restitution: rounded(rounded(one.impact_speed * one.restitution / FRAME, 1.0) * FRAME, 0.001) / speed,
            ..*one
        }
    };
    let even = |(at, one): (usize, &NewRun<'static>)| {
        let speed = 0.5 + 0.05 * (at % 45) as f64;
        NewRun {
            impact_speed: rounded(speed, 0.01),
            restitution: rounded(one.restitution - 0.1 * (speed - one.impact_speed), 1e-3),
            ..*one
        }
    };
    let kinds = kinds().into_iter().enumerate().filter(|(_, kind)| kind.step < 0.001);
    for (place, kind) in kinds {
        for make in [
            mixed,
            of_frames,
            even as fn((usize, &NewRun<'static>)) -> NewRun<'static>,
        ] {
            let alarms = (0..20).filter(|set| {
                let rows = table(kind, 110_000 + 100 * place as u64 + set);
                let rows: Vec<NewRun> = rows.iter().enumerate().map(make).collect();
                !codes(&rows).is_empty()
            });
            assert!(alarms.count() <= 1, "{place}");
        }
    }
}

/// Rebounds from speeds evenly apart lie nearly evenly apart, too, and are no steps to which restitutions were rounded; and a
/// few copies of fewer digits are seen although they are few.
#[test]
fn speeds_evenly_apart_and_short_digits_hide_no_copy() {
    let kind = |sd: f64, speeds: f64| Kind {
        step: 1e-4,
        sd,
        repeats: 3,
        speeds,
    };
    let law = |v: f64, film: Option<(f64, f64)>| 1.0 - 0.18 * v.powf(0.2) - film.map_or(0.0, |_| 0.15 / v);
    let even = |(at, one): (usize, &NewRun<'static>)| {
        let v = 0.5 + 0.12 * (at % 15) as f64;
        let restitution = one.restitution + law(v, one.film) - law(one.impact_speed, one.film);
        NewRun {
            impact_speed: rounded(v, 0.01),
            restitution: rounded(restitution, 1e-4),
            ..*one
        }
    };
    let short = |one: &NewRun<'static>| NewRun {
        restitution: rounded(one.restitution, 0.01),
        ..*one
    };
    let mut found = 0;
    for set in 0..20 {
        let rows = table(kind(0.003, 0.0), 130_000 + set);
        let rows: Vec<NewRun> = rows.iter().enumerate().map(even).collect();
        assert_eq!(codes(&rows), Vec::<&str>::new(), "{set}");
        assert_eq!(codes(&[&rows[..], &rows[..]].concat()), ["repeated_rows"], "{set}");
        let rows = table(kind(0.015, 0.1), 140_000 + set);
        let few: Vec<NewRun> = rows[12..22].iter().map(short).collect();
        assert_eq!(codes(&rows), Vec::<&str>::new(), "{set}");
        found += usize::from(codes(&[&rows[..], &few[..]].concat()) == ["repeated_rows"]);
    }
    // where two of the copied runs happen to have one speed, it may be one that was set, and restitutions alone say too little
    assert!(found >= 14, "{found}");
}

#[test]
fn a_copy_in_other_units_is_one() {
    let mut rows = table(kinds()[8], 3);
    let copied = rows.iter().map(|run| NewRun {
        impact_speed: run.impact_speed * 1000.0 / 1e3 * (1.0 + f64::EPSILON),
        film: run.film.map(|(film, ratio)| (film * (1.0 - f64::EPSILON), ratio)),
        ..*run
    });
    let copied: Vec<NewRun> = copied.collect();
    rows.extend(copied);
    assert_eq!(codes(&rows), ["repeated_rows"]);
}

#[test]
fn a_block_is_named_by_its_rows() {
    let kind = Kind {
        step: 0.001,
        sd: 0.01,
        repeats: 3,
        speeds: 0.01,
    };
    let rows = table(kind, 1);
    let found = check_rows(&arrange(&scene(), &[&rows[..], &rows[3..12]].concat()), None);
    let texts: Vec<&str> = found.iter().map(|check| check.text.as_str()).collect();
    assert!(
        texts.len() == 1 && texts[0].contains("rows 46 to 54 repeat rows 4 to 12"),
        "{texts:?}"
    );
}

#[test]
fn runs_that_stuck_repeat_by_nature() {
    let kind = kinds()[6];
    let mut rows = table(kind, 2);
    let stuck = NewRun {
        impact_speed: 0.2,
        restitution: 0.0,
        ..rows[20]
    };
    rows.extend([stuck; 20]);
    assert_eq!(codes(&rows), Vec::<&str>::new());
}

/// Under another film, where a setting of its own has the same speeds by design.
#[test]
fn a_block_pasted_under_another_setting_is_found() {
    for set in 0..10 {
        let kind = Kind {
            step: 1e-3,
            sd: 0.008,
            repeats: 3,
            speeds: [0.0, 0.01][set as usize % 2],
        };
        let mut rows = table(kind, 220_000 + set);
        assert_eq!(codes(&rows), Vec::<&str>::new(), "{set}");
        for at in 30..45 {
            let [from, to] = [rows[at - 15], rows[at]];
            rows[at] = NewRun { film: to.film, ..from };
        }
        assert_eq!(codes(&rows), ["repeated_rows"], "{set}");
        let found = check_rows(&arrange(&scene(), &rows), None);
        assert!(found[0].text.contains("under another setting too"), "{}", found[0].text);
    }
}

#[test]
fn restitutions_that_were_filled_down_are_found() {
    for set in 0..10 {
        let kind = Kind {
            step: 1e-4,
            sd: 0.006,
            repeats: 3,
            speeds: 0.02,
        };
        let mut rows = table(kind, 230_000 + set);
        for at in 0..rows.len() / 3 {
            rows[3 * at + 1].restitution = rows[3 * at].restitution;
        }
        let found = check_rows(&arrange(&scene(), &rows), None);
        let filled = found.iter().filter(|check| check.next_step.contains("filled down"));
        assert!(filled.filter(|check| check.forbids()).count() == 1, "{set}: {found:?}");
    }
}

/// Every other row is the second impact of the drop above it; the twin is a sweep of speeds that were set where rebounds end.
#[test]
fn second_impacts_are_found_and_sweeps_are_not() {
    for set in 0..50 {
        let mut rng = stream(7, "second impacts", set);
        let mut restitution = |v: f64| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            rounded(1.0 - 0.18 * v.powf(0.2) - 0.1 / v + 0.015 * noise, 0.001)
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
                v = rounded(v * (1.0 - 0.18 * v.powf(0.2) - 0.1 / v), 0.001);
            }
        }
        assert_eq!(codes(&drops), ["second_impacts"], "{set}");
        assert_eq!(codes(&sweeps), Vec::<&str>::new(), "{set}");
    }
}
