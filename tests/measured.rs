//! Holds the posterior and the joint least squares of runs with measurement errors to the truth those were drawn from.

use crate::common::scenes::{design, scene_of, truth, AK10, PTFE};
use crate::common::{add_errors, binomial_z, draws_of, holds, mean, normal, rows_from, sampled, seed_of, Place, Told};
use rand::rngs::ChaCha8Rng;
use rand::RngExt;
use rayon::prelude::*;
use wetcor::findings::posterior::effort;
use wetcor::inference::nuts::Effort;
use wetcor::physics::numbers::stokes;
use wetcor::runs::{self, Runs, Table};
use wetcor::scene::Scene;
use wetcor::seed::{stream, StreamName};

fn scene_text() -> String {
    let m20 = "[liquids.M20]\ndensity_kg_m3 = 950\nviscosity_mPa_s = 19.0\n";
    let model = "[model]\ndry_speed_m_s = \"impact\"\n";
    let truth = truth([1.85, 0.8, 0.003, 0.003], "");
    let design = design(
        ["4.762, 7.938", "0.05, 0.12"],
        &["AK10", "M20"],
        ["50, 70, 90, 110, 130, 150", "0.5, 0.8, 1.1, 1.4, 1.7, 2.0"],
        "repeats = 6\n",
    );
    let limit = "smallest_restitution = 0.05\n";
    scene_of(
        "measured with errors",
        &[limit, PTFE, AK10, m20, model, &truth, &design],
    )
}

/// Name and truth of what is held.
const TRUTH: [(&str, f64); 5] = [
    ("dry_k[PTFE]", 0.183),
    ("lubrication_log", 1.85),
    ("inertial_prefactor", 0.8),
    ("sigma_dry", 0.003),
    ("sigma_wet", 0.003),
];

/// What v of a run is read with an error of, as a share of it.
type Share = fn(&mut ChaCha8Rng) -> f64;

/// The scene's runs with v read with an error, and v_r with half as much.
fn measured(scene: &Scene, share: Share, (seed, set): (u64, u64)) -> Runs {
    let mut rows = rows_from(scene, stream(seed, "runs", set));
    let mut rng = stream(seed, "errors", set);
    let mut told: Vec<[f64; 2]> = vec![];
    for row in &mut rows {
        let (v, e) = (row.impact_speed, row.restitution);
        let share = share(&mut rng);
        let sds = [share * v, 0.5 * share * v];
        let rebound = e * v + if e > 0.0 { sds[1] * normal(&mut rng) } else { 0.0 };
        row.impact_speed = v + sds[0] * normal(&mut rng);
        row.restitution = rebound / row.impact_speed;
        told.push([sds[0], sds[1] / row.impact_speed]);
    }
    let mut runs = runs::arrange(scene, &rows);
    add_errors(&mut runs, &told);
    runs
}

/// What a fit forgets of the errors.
#[derive(Clone, Copy, PartialEq)]
enum Forgets {
    Nothing,
    /// that e and v share the error of v: what that does to the residual enters as an error of e alone
    Covariance,
    /// all of them
    Errors,
}

/// Mean and 95 % interval of each parameter, by the posterior; and of k, L and C by the joint least squares.
type Found = Vec<(f64, [f64; 2])>;

fn fitted(scene: &Scene, mut runs: Runs, forgets: Forgets, stream: StreamName) -> [Found; 2] {
    if forgets == Forgets::Errors {
        runs.errors.clear();
    } else if forgets == Forgets::Covariance {
        let viscosity = |run: usize| {
            let series = runs.series.iter().find(|series| series.runs().contains(&run))?;
            Some(scene.liquids[series.liquid].viscosity)
        };
        for (run, error) in runs.errors.iter_mut().enumerate() {
            let (v, e) = (runs.impact_speed[run], runs.restitution[run]);
            let share = error.impact_speed_sd / v;
            // v dm/dv at the truth
            let loss = 0.183 * v.powf(0.2);
            let slope = viscosity(run).map_or(-0.2 * loss, |viscosity| {
                let viscous = 4.0 * 1.85 / stokes(2150.0, runs.diameter[run], v, viscosity);
                (viscous - 0.4 * (1.0 - loss) * loss) / (2.0 * e)
            });
            let own = error.restitution_sd;
            error.restitution_sd = (own * own + share * share * (e * e + slope * slope)).sqrt();
            error.impact_speed_sd = 0.0;
        }
    }
    let effort = Effort {
        chains: 1,
        warmup: 300,
        draws: 600,
        ..effort(scene)
    };
    let (least_squares, sampled) = sampled(scene, &Table::of(runs), effort, stream);
    let of_draws = |(name, _): &(&str, f64)| {
        let mut draws = draws_of(&sampled, name);
        draws.sort_by(f64::total_cmp);
        let at = |p: f64| draws[((draws.len() - 1) as f64 * p).round() as usize];
        (mean(&draws).0, [at(0.025), at(0.975)])
    };
    let of_balance = |(name, _): &(&str, f64)| {
        let own = least_squares.fitted(name);
        let mut intervals = own.intervals.iter();
        let interval = intervals.find(|interval| interval.level == 0.95).expect("delta");
        (own.value.expect("converged"), [interval.lo, interval.hi])
    };
    [
        TRUTH.iter().map(of_draws).collect(),
        TRUTH[..3].iter().map(of_balance).collect(),
    ]
}

/// What is found of so many sets by the posterior, and by least squares.
fn found(place: &Place, share: Share, forgets: Forgets, (seed, sets): (u64, u64)) -> Vec<[Found; 2]> {
    let each = (0..sets).into_par_iter().map(|set| {
        let runs = measured(&place.scene, share, (seed, set));
        let stream = format!("posterior {set}");
        fitted(&place.scene, runs, forgets, StreamName::new(seed, &stream))
    });
    each.collect()
}

/// z of the coverage of each parameter, and the spread of its estimates: by the posterior, by least squares.
fn held(sets: u64, forgets: Forgets) -> [Vec<(f64, f64)>; 2] {
    let seed = seed_of("fits_of_measured_runs_cover_the_truth_and_are_sharper");
    let twentyfold: Share = |rng| 0.001 * 20f64.powf(rng.random::<f64>());
    let all = found(&Place::new(&scene_text()), twentyfold, forgets, (seed, sets));
    [0, 1].map(|way| {
        let of = |parameter: usize| {
            let each = || all.iter().map(|found| found[way][parameter]);
            let inside = each().filter(|(_, interval)| holds(Some(*interval), TRUTH[parameter].1));
            let values: Vec<f64> = each().map(|(value, _)| value).collect();
            let z = binomial_z(inside.count(), sets as usize, 0.95);
            (z, mean(&values).1 * (sets as f64).sqrt())
        };
        (0..all[0][way].len()).map(of).collect()
    })
}

#[test]
#[ignore = "slow: samples 250 posteriors"]
fn fits_of_measured_runs_cover_the_truth_and_are_sharper() {
    let [posterior, balance] = held(150, Forgets::Nothing);
    for (way, found) in [("posterior", &posterior), ("least squares", &balance)] {
        for ((name, _), (z, _)) in TRUTH.iter().zip(found) {
            assert!(z.abs() < 4.0, "{way}, {name}: {z}");
        }
    }
    let [plain, of_balance] = held(100, Forgets::Errors);
    // errors twentyfold apart are worth telling: L and C
    for parameter in [1, 2] {
        assert!(posterior[parameter].1 < 0.8 * plain[parameter].1);
        assert!(balance[parameter].1 < 0.8 * of_balance[parameter].1);
    }
    // what is not told is taken for scatter of the runs
    assert!(plain[4].0 < -20.0, "{plain:?}");
}

/// Where errors are nearly all there is they leave little to the scatter of the runs; with the covariance of e and v
/// forgotten they explain too little, and it is taken for what it is not.
#[test]
#[ignore = "slow: samples 80 posteriors"]
fn a_forgotten_covariance_is_seen() {
    // so viscous that a restitution changes with its speed by half of itself
    let place = Place::new(&scene_text().replace("= 9.3", "= 52.0").replace("= 19.0", "= 58.0"));
    let seed = seed_of("a_forgotten_covariance_is_seen");
    let scatter = |forgets: Forgets| {
        let found = found(&place, |_| 0.01, forgets, (seed, 40));
        mean(&Vec::from_iter(found.iter().map(|[posterior, _]| posterior[4].0)))
    };
    let (right, se) = scatter(Forgets::Nothing);
    let (wrong, _) = scatter(Forgets::Covariance);
    let near = |found: f64| (found - TRUTH[4].1).abs() < 0.0005 + 4.0 * se;
    assert!(near(right), "{right} {se}");
    assert!(!near(wrong), "{wrong} {se}");
}
