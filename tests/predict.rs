//! Holds predictions to brute-force sampling, and to the truth of the simulated example; `data/transcripts` has refusals.

use crate::common::{
    ask, binomial_z, fitted_example as example, in_project, normal, parameters_of, rows, seed_of, setting,
};
use crate::laws;
use rand::RngExt;
use wetcor::findings::predict::{Covered, CoveredIn, Draw, LiquidBasis, ParticleBasis, ParticleLaw, Predicted};
use wetcor::model::likelihood::tails::Tails;
use wetcor::physics::rebound::mean_restitution;
use wetcor::physics::{kept_energy, DrySpeed, Form, Inertia, Parameters, Setting};
use wetcor::report::finished::Finished;
use wetcor::runs::NewRun;
use wetcor::scene::{self, LikelihoodFamily};
use wetcor::seed::stream;

/// PE in M50, δ/D = 0.06: near the threshold at the speeds of the example.
const SLOW: Setting = setting([940.0, 4.762e-3], [965.0, 48.3e-3], 0.06 * 4.762e-3);

fn truth_parameters() -> Parameters {
    parameters_of([0.123, 1.85, 0.47, 0.069])
}

fn law(test: &str) -> ParticleLaw {
    let mut rng = stream(seed_of(test), "draws", 0);
    let mut near = |value: f64, relative_sd: f64| {
        let z = normal(&mut rng);
        value * (relative_sd * z).exp()
    };
    let draws = (0..300).map(|_| Draw {
        parameters: parameters_of([near(0.123, 0.02), near(1.85, 0.02), near(0.47, 0.05), near(0.069, 0.05)]),
        sigma_dry: 0.01,
        sigma_wet: near(0.02, 0.1),
        sigma_energy: 0.0,
        tails: Tails::Normal,
        series_offset: 0.0,
    });
    ParticleLaw {
        form: Form::new(Inertia::Saturating, DrySpeed::Impact),
        smallest_restitution: 0.05,
        particle: ParticleBasis::default(),
        liquids: vec![],
        draws: draws.collect(),
    }
}

/// How many standard errors the predictions lie from the shares of sampled runs: the worst of sticking and four points.
fn worst_z(law: &ParticleLaw, predicted: &Predicted, test: &str) -> f64 {
    const RUNS: usize = 200_000;
    let v = predicted.impact_speed_m_s;
    let mut rng = stream(seed_of(test), "runs", 0);
    let runs: Vec<f64> = (0..RUNS)
        .map(|_| {
            let draw = &law.draws[rng.random_range(0..law.draws.len())];
            let kept = kept_energy(&SLOW, law.form, &draw.parameters, v);
            let e = mean_restitution(kept) + draw.sigma_wet * draw.tails.draw(&mut rng);
            Some(e).filter(|e| *e > law.smallest_restitution).unwrap_or(0.0)
        })
        .collect();
    let share = |of: &dyn Fn(f64) -> bool| runs.iter().filter(|e| of(**e)).count();
    let stuck = share(&|e| e == 0.0);
    let mut worst = match predicted.stuck_probability {
        p if p > 1e-6 && p < 1.0 - 1e-6 => binomial_z(stuck, RUNS, p).abs(),
        _ => 0.0,
    };
    let points = [
        (0.05, predicted.run_q05),
        (0.25, predicted.run_q25),
        (0.75, predicted.run_q75),
        (0.95, predicted.run_q95),
    ];
    for (p, point) in points {
        let z = if point == 0.0 {
            // that many stick at least
            -binomial_z(stuck, RUNS, p)
        } else {
            binomial_z(share(&|e| e <= point), RUNS, p).abs()
        };
        worst = worst.max(z);
    }
    worst
}

/// Speeds from never to always stuck, those between with about these probabilities of sticking.
fn speeds(law: &ParticleLaw) -> Vec<f64> {
    let sticking_at = |p: f64| {
        let (mut slow, mut fast) = (1.0, 3.0);
        for _ in 0..40 {
            let v = 0.5 * (slow + fast);
            if law.curve(Some(&SLOW)).predict(&[v])[0].stuck_probability > p {
                slow = v;
            } else {
                fast = v;
            }
        }
        fast
    };
    let between = [0.02, 0.2, 0.5, 0.9].map(sticking_at);
    [&[3.5][..], &between, &[1.0]].concat()
}

#[test]
fn a_single_runs_bands_are_those_of_brute_force_sampling() {
    let test = "a_single_runs_bands_are_those_of_brute_force_sampling";
    let law = law(test);
    let rows = law.curve(Some(&SLOW)).predict(&speeds(&law));
    assert!(rows[0].stuck_probability < 1e-6 && rows[5].stuck_probability > 0.999);
    for row in &rows {
        let z = worst_z(&law, row, test);
        assert!(z < 4.5, "{z} at {} m/s", row.impact_speed_m_s);
    }
    // tails that are longer, and of different length
    for tails in [
        Tails::of(LikelihoodFamily::Student, 3.0),
        Tails::of(LikelihoodFamily::AsymmetricLaplace, -0.8),
    ] {
        let mut own = law.clone();
        own.draws.iter_mut().for_each(|draw| draw.tails = tails);
        for row in &own.curve(Some(&SLOW)).predict(&speeds(&law)[1..5]) {
            let z = worst_z(&own, row, test);
            assert!(z < 4.5, "{z} at {} m/s, {tails:?}", row.impact_speed_m_s);
        }
    }
    // the planted fault: twice the noise
    let mut wrong = law.clone();
    wrong.draws.iter_mut().for_each(|draw| draw.sigma_wet *= 2.0);
    for row in &wrong.curve(Some(&SLOW)).predict(&speeds(&law)[..2]) {
        let z = worst_z(&law, row, test);
        assert!(z > 40.0, "{z} at {} m/s", row.impact_speed_m_s);
    }
}

#[test]
fn the_curve_is_the_energy_balance_of_the_draws_and_its_bands_hold_their_shares() {
    let test = "the_curve_is_the_energy_balance_of_the_draws_and_its_bands_hold_their_shares";
    let law = law(test);
    let n = law.draws.len() as f64;
    for row in law.curve(Some(&SLOW)).predict(&speeds(&law)) {
        let v = row.impact_speed_m_s;
        let e = |draw: &Draw| {
            let kept = kept_energy(&SLOW, law.form, &draw.parameters, v);
            kept.max(0.0).sqrt()
        };
        for (p, point) in [
            (0.05, row.restitution_q05),
            (0.25, row.restitution_q25),
            (0.5, row.restitution),
            (0.75, row.restitution_q75),
            (0.95, row.restitution_q95),
        ] {
            let below = law.draws.iter().filter(|draw| e(draw) <= point + 1e-12).count() as f64;
            assert!(
                point == 0.0 && below >= p * n - 1.0 || (below - p * n).abs() <= 1.5,
                "{v} {p} {below}"
            );
        }
        // about where half the draws rebound, the curve's slope has no median
        assert_eq!(row.log_slope.is_some(), row.restitution > 0.0, "{v}");
        assert!(row.extrapolated, "no runs, nothing covered");
    }
}

/// Speeds at which a law that covered this in all liquids, and these ranges in liquids of these viscosities, is extrapolated.
fn extrapolated(covered: Covered, ranges: &[(f64, [f64; 2])], speeds: &[f64]) -> Vec<bool> {
    let liquids = ranges.iter().map(|(viscosity, _)| LiquidBasis {
        name: viscosity.to_string(),
        density_kg_m3: SLOW.liquid_density,
        viscosity_pa_s: *viscosity,
        surface_tension_n_m: None,
    });
    let covered_in = ranges.iter().map(|(viscosity, speeds)| CoveredIn {
        liquid: viscosity.to_string(),
        impact_speed_m_s: *speeds,
        covered,
    });
    let law = ParticleLaw {
        particle: ParticleBasis {
            covered: Some(covered),
            covered_in: covered_in.collect(),
            ..ParticleBasis::default()
        },
        liquids: liquids.collect(),
        ..law("what_the_runs_covered_is_not_extrapolated_and_its_ends_belong_to_it")
    };
    let rows = law.curve(Some(&SLOW)).predict(speeds);
    rows.iter().map(|row| row.extrapolated).collect()
}

/// Runs in a thinner liquid have larger Stokes numbers at the same speed: they are not runs of faster spheres in this one.
#[test]
fn what_was_covered_in_this_liquid_is_not_extrapolated_and_its_ends_belong_to_it() {
    let covered = |speeds: [f64; 2], film_ratio| Covered {
        stokes: speeds.map(|speed| SLOW.stokes(speed)),
        film_ratio,
    };
    let in_all = |film_ratio| extrapolated(covered([1.0, 2.0], film_ratio), &[], &[0.999, 1.0, 1.5, 2.0, 2.001]);
    assert_eq!(in_all([0.03, 0.06]), [true, false, false, false, true]);
    assert_eq!(in_all([0.03, 0.059]), [true; 5]);
    assert_eq!(in_all([0.061, 0.08]), [true; 5]);
    let wide = covered([0.1, 50.0], [0.03, 0.06]);
    let own = (SLOW.viscosity, [1.0, 2.0]);
    let thinner = (0.1 * SLOW.viscosity, [0.5, 4.0]);
    let of = |ranges: &[(f64, [f64; 2])]| extrapolated(wide, ranges, &[0.5, 1.0, 2.0, 4.0]);
    assert_eq!(of(&[thinner, own]), [true, false, false, true]);
    assert_eq!(of(&[thinner]), [true; 4]);
    // the planted fault: the range of the particle in all liquids
    assert_eq!(of(&[]), [false; 4]);
}

/// What repeats of a run share.
fn key<'s>(run: &NewRun<'s>) -> (Option<&'s str>, Option<(f64, f64)>, f64, f64) {
    (run.liquid, run.film, run.diameter, run.impact_speed)
}

/// New runs of the example's truth, and its own curve, beside what was inferred from its 1,500 runs.
#[test]
fn the_truth_of_the_example_and_new_runs_of_it_lie_where_they_are_predicted() {
    let test = "the_truth_of_the_example_and_new_runs_of_it_lie_where_they_are_predicted";
    let finished = Finished::read(example()).unwrap_or_else(|error| panic!("{error}"));
    let scene = scene::read(&in_project("datasets/mueller2016/scene.toml")).unwrap_or_else(|error| panic!("{error}"));
    let truth = scene.truth.as_ref().expect("the example has a truth");
    let runs = rows(&scene, seed_of(test));
    let (mut inside, mut inside_curve, mut certain) = ([0; 2], 0, 0);
    let (mut stuck, mut expected, mut variance) = (0, 0.0, 0.0);
    let mut worst = 0.0f64;
    for (index, particle) in scene.particles.iter().enumerate() {
        let law = finished
            .law(&particle.name, 4.762e-3, true)
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(law.draws.len(), 1000);
        let own = runs
            .iter()
            .filter(|run| run.particle == particle.name && run.film.is_some());
        let own: Vec<&NewRun> = own.collect();
        for repeats in own.chunk_by(|a, b| key(a) == key(b)) {
            let (Some(name), Some((film, _)), diameter, v) = key(repeats[0]) else {
                unreachable!("a wet run has a liquid")
            };
            let liquid = scene.liquids.iter().find(|l| l.name == name).expect("its liquid");
            let setting = setting([particle.density, diameter], [liquid.density, liquid.viscosity], film);
            let row = law.curve(Some(&setting)).predict(&[v]).remove(0);
            assert!(!row.extrapolated, "these very settings were run");
            let own_truth = Parameters {
                dry_k: truth.dry_k[index].expect("given"),
                ..truth_parameters()
            };
            let kept = kept_energy(&setting, truth.form, &own_truth, v);
            let width = row.restitution_q95 - row.restitution_q05;
            if kept > 0.05 && width > 0.0 {
                // a 90 % band is 3.29 standard deviations wide
                worst = worst.max((kept.sqrt() - row.restitution).abs() / (width / 3.29));
            }
            let p = row.stuck_probability;
            for e in repeats.iter().map(|run| run.restitution) {
                if p < 1e-6 {
                    certain += 1;
                    inside[0] += usize::from((row.run_q25..=row.run_q75).contains(&e));
                    inside[1] += usize::from((row.run_q05..=row.run_q95).contains(&e));
                    inside_curve += usize::from((row.restitution_q05..=row.restitution_q95).contains(&e));
                }
                stuck += usize::from(e == 0.0);
                expected += p;
                variance += p * (1.0 - p);
            }
        }
    }
    assert!(worst > 0.01 && worst < 4.5, "the true curve is {worst} sd away");
    assert!(certain > 1000, "{certain}");
    let z = [binomial_z(inside[0], certain, 0.5), binomial_z(inside[1], certain, 0.9)];
    assert!(z.iter().all(|z| z.abs() < 4.5), "{z:?}");
    let z = (stuck as f64 - expected) / f64::max(variance, 1.0).sqrt();
    assert!(z.abs() < 4.5, "{stuck} stuck, {expected} expected");
    // the planted fault: the curve's band taken for that of runs
    let z = binomial_z(inside_curve, certain, 0.9);
    assert!(z < -40.0, "{z}");
}

const ASKED: &str = "--particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286 --speed-m-s 0.05:2:6";

#[test]
fn both_formats_hold_the_same_numbers_and_reynolds_over_stokes_is_nine_ratios() {
    let (status, csv, err) = ask("predict", example(), ASKED);
    assert_eq!(status, Some(0), "{err}");
    // M50 has the smaller Stokes numbers: they are none of these speeds in AK10
    let covered = "notice: 3 of 6 speeds extrapolated: runs of PTFE in AK10 covered 0.767 to 1.716 m/s, Stokes numbers 62.6 to 352.5";
    assert!(err.starts_with(covered), "{err}");
    let (_, json, _) = ask("predict", example(), &format!("{ASKED} --format json"));
    let json: serde_json::Value = serde_json::from_str(&json).expect("valid JSON");
    assert_eq!((&json["quotable"], &json["draws"]), (&true.into(), &1000.into()));
    let rows = json["predicted"].as_array().expect("a list");
    let mut lines = csv.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    assert_eq!(lines.clone().count(), rows.len());
    for (line, row) in lines.zip(rows) {
        let keys = row.as_object().expect("an object").len() - usize::from(row["log_slope"].is_null());
        assert_eq!(keys, header.len(), "{row}");
        for (name, cell) in header.iter().zip(line.split(',')) {
            match &row[*name] {
                serde_json::Value::Null => assert_eq!((*name, cell), ("log_slope", "")),
                value => assert_eq!(cell.parse::<serde_json::Value>().expect("a value"), *value, "{name}"),
            }
        }
        let number = |name: &str| row[name].as_f64().expect("a number");
        let ratio = 9.0 * json["density_ratio"].as_f64().expect("ρ̃") * json["film_ratio"].as_f64().expect("δ̃");
        assert!((number("reynolds") / number("stokes") / ratio - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_dry_impact_is_predicted_from_k_and_the_scatter_of_dry_runs() {
    let asked = "--particle PTFE --liquid dry --diameter-mm 4.762 --speed-m-s 0.3:2.1:4";
    let (status, out, err) = ask("predict", example(), asked);
    assert_eq!(status, Some(0), "{err}");
    let finished = Finished::read(example()).unwrap_or_else(|error| panic!("{error}"));
    let law = finished
        .law("PTFE", 4.762e-3, false)
        .unwrap_or_else(|error| panic!("{error}"));
    let mut k: Vec<f64> = law.draws.iter().map(|draw| draw.parameters.dry_k).collect();
    k.sort_by(f64::total_cmp);
    let sigma = law.draws.iter().map(|draw| draw.sigma_dry).sum::<f64>() / law.draws.len() as f64;
    for row in laws::rows(&out) {
        let number = |name: &str| row[name].parse::<f64>().expect("a number");
        let v = number("impact_speed_m_s");
        let median = 1.0 - 0.5 * (k[499] + k[500]) * v.powf(0.2);
        assert!((number("restitution") - median).abs() < 1e-9, "{v}");
        // k is known to a fiftieth of a run's own scatter
        let half = 0.5 * (number("run_q95") - number("run_q05"));
        assert!((half / (1.645 * sigma) - 1.0).abs() < 0.01, "{half} {sigma}");
        assert_eq!((row["stokes"].as_str(), row["reynolds"].as_str()), ("", ""));
    }
}
