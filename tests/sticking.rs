//! Measures what becomes of L where runs stick, by each way of taking them, and compares it with `reports/sticking.md`.

use crate::common::scenes::HEADER;
use std::fmt::Write;

use crate::common::{
    assert_expected, binomial_z, draws_of, holds, is_update, kept, mean, normal, read_in_project, study,
    weighed_or_sampled, Place,
};
use wetcor::findings::posterior::effort;
use wetcor::findings::{self, Findings};
use wetcor::inference::diagnostics::pareto::khat_threshold;
use wetcor::inference::importance::DrawCounts;
use wetcor::inference::nuts::Effort;
use wetcor::physics::rebound::mean_restitution;
use wetcor::physics::Order;
use wetcor::physics::Quantity::StCEInf2;
use wetcor::runs;
use wetcor::scene::{NoiseOn, Scene, Sticking, WetLaw};
use wetcor::seed::StreamName;

const L: f64 = 1.85;
const K: f64 = 0.123;
const NOISE: f64 = 0.03;
/// What measuring a restitution adds where the noise is on the energy.
const MEASUREMENT: f64 = 0.01;
const LIMIT: f64 = 0.05;
const SETS: u64 = 100;

/// Where the noise acts.
#[derive(Clone, Copy, PartialEq)]
enum On {
    /// e* = m(r) + σ z, as the likelihood has it
    Restitution,
    /// e* = m(r + σ_r z′) + σ z, mostly the former
    Energy,
}

/// One film ratio; the viscosity, mPa s, decides at how many of its ten speeds nothing rebounds.
fn scene(viscosity: f64) -> String {
    format!(
        "title = \"sticking\"\n[data]\nruns = \"runs.csv\"\nsmallest_restitution = {LIMIT}\n[particles.PE]\n\
         density_kg_m3 = 940\nroughness_um = 5\n[liquids.oil]\ndensity_kg_m3 = 965\nviscosity_mPa_s = {viscosity}\n\
         [model]\ninertia = \"none\"\nterms = [\"viscous\"]\n"
    )
}

/// Viscosities at which about these shares of the runs stick, in per cent.
const SHARES: [(u32, f64); 3] = [(10, 71.1), (40, 97.1), (80, 127.2)];

const DIAMETER: f64 = 7.938e-3;

fn table(viscosity: f64, on: On, seed: u64) -> String {
    let mut rng = wetcor::seed::stream(seed, "sticking", 0);
    let mut normal = || normal(&mut rng);
    let mut text = HEADER.to_owned();
    for i in 0..30 {
        let v = 0.5 + 0.05 * f64::from(i);
        let e = Order::First.restitution(K, v) + 0.01 * normal();
        let _ = writeln!(text, "PE,dry,7.938,,{v},{e}");
    }
    for i in 0..120 {
        let v = 0.8 + 0.1 * f64::from(i % 10);
        let stokes = wetcor::physics::numbers::stokes(940.0, DIAMETER, v, 1e-3 * viscosity);
        let r = Order::First.restitution(K, 2.0).powi(2) - 4.0 * L / stokes;
        let e = match on {
            On::Restitution => mean_restitution(r) + NOISE * normal(),
            On::Energy => mean_restitution(r + NOISE * normal()) + MEASUREMENT * normal(),
        };
        let e = if e > LIMIT { e } else { 0.0 };
        let _ = writeln!(text, "PE,oil,7.938,{},{v},{e}", 0.06 * 7938.0);
    }
    text
}

/// L with its 90 % and 95 % intervals.
#[derive(Clone, Copy)]
struct Found {
    value: f64,
    intervals: [[f64; 2]; 2],
}

fn by_law(found: &Findings, law: WetLaw) -> Option<Found> {
    let mut rows = found.scaling.iter();
    let row = rows.find(|row| row.law == law && row.film_ratio.is_some())?;
    // twice L
    let of = &row.estimates[StCEInf2];
    let at = |level: f64| {
        let interval = of.intervals.iter().find(|interval| interval.level == level)?;
        Some([0.5 * interval.lo, 0.5 * interval.hi])
    };
    Some(Found {
        value: 0.5 * of.value?,
        intervals: [at(0.9)?, at(0.95)?],
    })
}

fn by_posterior(place: &Place, (sticking, noise): (Sticking, NoiseOn), seed: u64) -> Option<Found> {
    let mut scene: Scene = place.scene.clone();
    (scene.model.sticking, scene.model.noise) = (sticking, noise);
    let table = runs::read(&scene).expect("good runs");
    const CHAINS: usize = 2;
    const DRAWS: usize = 500;
    let size = DrawCounts {
        chains: CHAINS,
        draws: DRAWS,
    };
    let effort = Effort {
        chains: CHAINS,
        warmup: 300,
        draws: DRAWS,
        ..effort(&scene)
    };
    let stream = StreamName::new(seed, "sticking posterior");
    let line = khat_threshold(CHAINS * DRAWS);
    let sampled = weighed_or_sampled((&scene, &table), (size, line), effort, stream)?;
    let mut draws = draws_of(&sampled, "lubrication_log");
    draws.sort_by(f64::total_cmp);
    let at = |p: f64| draws[((draws.len() - 1) as f64 * p).round() as usize];
    Some(Found {
        value: mean(&draws).0,
        intervals: [[at(0.05), at(0.95)], [at(0.025), at(0.975)]],
    })
}

/// A way of taking stuck runs, by the name that the table has for it.
enum Way {
    Law(WetLaw),
    Posterior(Sticking, NoiseOn),
}

/// The ways, in the order of the table.
const WAYS: [(&str, Way); 6] = [
    ("linear law, rebounds", Way::Law(WetLaw::Linear)),
    ("square root, rebounds", Way::Law(WetLaw::Sqrt)),
    (
        "posterior, excluded",
        Way::Posterior(Sticking::Excluded, NoiseOn::Restitution),
    ),
    (
        "posterior, truncated",
        Way::Posterior(Sticking::Truncated, NoiseOn::Restitution),
    ),
    (
        "posterior, censored",
        Way::Posterior(Sticking::Censored, NoiseOn::Restitution),
    ),
    (
        "posterior, censored, noise = \"both\"",
        Way::Posterior(Sticking::Censored, NoiseOn::Both),
    ),
];

impl Way {
    /// Whether the way is measured: for the page every way is; else, of posteriors, the default and those whose noise acts where
    /// that of the runs does.
    fn is_measured(&self, on: On) -> bool {
        let is_default = matches!(self, Way::Posterior(Sticking::Censored, NoiseOn::Restitution));
        let is_own = match self {
            Way::Law(_) => true,
            Way::Posterior(_, noise) => (*noise == NoiseOn::Both) == (on == On::Energy),
        };
        is_update() || is_default || is_own
    }
}

/// The share that stuck, and what each way found of each set, where it found something.
fn measured((share, viscosity): (u32, f64), on: On) -> (f64, [Vec<Found>; WAYS.len()]) {
    let noise = if on == On::Energy { "energy" } else { "restitution" };
    let sets = study(&format!("sticking {share} {noise}"), SETS, |seed| {
        let place = Place::new(&scene(viscosity));
        let read = place.read_rows(&table(viscosity, on, seed));
        let least_squares = findings::fit_least_squares(&place.scene, &read, 1, false);
        let found = WAYS.map(|(_, way)| match way {
            _ if !way.is_measured(on) => None,
            Way::Law(law) => by_law(&least_squares, law),
            Way::Posterior(sticking, noise) => by_posterior(&place, (sticking, noise), seed),
        });
        (read.runs.stuck(), found)
    });
    let stuck: usize = sets.iter().map(|(stuck, _)| stuck).sum();
    let of_way = |way: usize| sets.iter().filter_map(|(_, found)| found[way]).collect();
    (stuck as f64 / (120 * SETS) as f64, std::array::from_fn(of_way))
}

/// How many intervals of a level hold the truth.
fn covered(found: &[Found], level: usize) -> usize {
    found.iter().filter(|own| holds(Some(own.intervals[level]), L)).count()
}

/// The rows of the table of one noise and share.
fn rows(on: On, stuck: f64, by_way: &[Vec<Found>]) -> String {
    let mut text = String::new();
    for ((name, way), found) in WAYS.iter().zip(by_way) {
        if !way.is_measured(on) {
            continue;
        }
        let sets = found.len();
        let values: Vec<f64> = found.iter().map(|own| own.value).collect();
        let (average, se) = mean(&values);
        let percent = |level: usize| format!("{:.1} %", 100.0 * covered(found, level) as f64 / sets as f64);
        let _ = writeln!(
            text,
            "| {} | {:.0} % | {name} | {sets} | {:.3} ± {se:.3} | {} | {} |",
            if on == On::Energy { "r" } else { "e" },
            100.0 * stuck,
            average - L,
            percent(0),
            percent(1)
        );
    }
    text
}

/// Measures rows of the middle share of stuck runs; all of them, which take ten minutes, where the page is to be written.
#[test]
#[ignore = "slow: run with --ignored"]
fn the_committed_table_is_measured_and_the_censored_posterior_covers() {
    let is_written = is_update();
    let mut text = format!(
        "# Where runs stick\n\nWhat becomes of L = ln(δc/ε), whose truth is {L}, by each way of taking stuck runs: bias, and \
         how many of {SETS} simulated sets have it in their 90 % and 95 % intervals. A set has 120 wet runs at ten speeds \
         and one film ratio, and 30 dry ones. The noise has the sd {NOISE}, on e as the likelihood has it, or on the energy \
         kept r (and {MEASUREMENT} on e), as `noise = \"both\"` has it. A share of {:.1} % is one binomial standard deviation at 95 %.\n\n\
         Made by `UPDATE_EXPECTED=1 cargo test --release --test all sticking:: -- --ignored`.\n\n\
         | noise on | stuck | way | sets with a number | bias of L | in its 90 % interval | in its 95 % interval |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
        100.0 * (0.95 * 0.05 / SETS as f64).sqrt()
    );
    let committed = read_in_project("reports/sticking.md");
    assert!(is_written || committed.starts_with(&text), "{text}");
    let shares = if is_written { &SHARES[..] } else { &SHARES[1..2] };
    for on in [On::Restitution, On::Energy] {
        for share in shares {
            let (stuck, found) = measured(*share, on);
            let rows = rows(on, stuck, &found);
            let is_committed = |row: &str| committed.lines().any(|line| line == row);
            assert!(is_written || rows.lines().all(is_committed), "{rows}");
            text.push_str(&rows);
            // the way whose noise is that of the runs
            let matching = &found[if on == On::Restitution { 4 } else { 5 }];
            for (level, nominal) in [0.9, 0.95].into_iter().enumerate() {
                assert_expected("L", covered(matching, level), SETS, nominal);
            }
            if on == On::Restitution {
                // the planted fault: the linear law knows nothing of the threshold
                let z = binomial_z(covered(&found[0], 1), SETS as usize, 0.95);
                assert!(z < -4.0, "linear, {stuck}: {z}");
            }
        }
    }
    kept("reports/sticking.md", &text);
}
