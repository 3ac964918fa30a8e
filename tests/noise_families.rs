//! Fits noise of every family: Student's tails let no outlier move a parameter, and shapes are those that runs were drawn with.

use crate::common::scenes::{design, scene_of, truth, AK10, M50, PTFE};
use crate::common::{draws_of, mean, rows, sample, sampled, seed_of, Place, Told};
use wetcor::findings::fit_least_squares;
use wetcor::findings::posterior::effort;
use wetcor::inference::nuts::Effort;
use wetcor::model::parameters::ModelParameter;
use wetcor::runs::{arrange, NewRun, Table};
use wetcor::scene::LikelihoodFamily;
use wetcor::seed::StreamName;

fn scene_text() -> String {
    let limit = "smallest_restitution = 0.05\n";
    let dry = "0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0";
    let heights = "40, 60, 80, 100, 120, 150";
    let design = design(
        ["4.762, 7.938", "0.05, 0.12"],
        &["AK10", "M50"],
        [heights, dry],
        "repeats = 3\n",
    );
    scene_of(
        "outliers",
        &[limit, PTFE, AK10, M50, &truth([1.85, 0.8, 0.01, 0.02], ""), &design],
    )
}

/// Name, mean and sd of each parameter.
fn posterior(place: &Place, rows: &[NewRun], likelihood: LikelihoodFamily, seed: u64) -> Vec<(String, f64, f64)> {
    let mut scene = place.scene.clone();
    scene.model.likelihood = likelihood;
    let effort = Effort {
        chains: 2,
        warmup: 500,
        draws: 1000,
        ..effort(&scene)
    };
    let table = Table::of(arrange(&scene, rows));
    let (_, sampled) = sampled(&scene, &table, effort, StreamName::new(seed, "outliers"));
    let marginal = |parameter: &ModelParameter| {
        let draws = draws_of(&sampled, &parameter.name);
        let centre = mean(&draws).0;
        let square = draws.iter().map(|x| (x - centre).powi(2)).sum::<f64>() / draws.len() as f64;
        (parameter.name.clone(), centre, square.sqrt())
    };
    sampled.parameters.sampled.iter().map(marginal).collect()
}

/// How far the means move in the sds they had, the farthest. ν is what takes an outlier, and moves.
fn moved(clean: &[(String, f64, f64)], with: &[(String, f64, f64)]) -> (f64, String) {
    let pairs = clean.iter().zip(with).filter(|((name, ..), _)| name != "nu");
    let each = pairs.map(|((name, from, sd), (_, to, _))| {
        let far = (to - from).abs() / sd;
        (far, format!("{name} by {far:.2} sd, from {from:.4} to {to:.4}"))
    });
    each.fold((0.0, String::new()), |a, b| if b.0 > a.0 { b } else { a })
}

/// A hundred dry runs, so that one at four spreads is a small part of what tells theirs: of 24 it moved σ_dry by 1.6 sd.
///
/// One run of each kind, a wet rebound in the middle, a slow wet one and a dry one, comes out anywhere from stuck to as fast
/// as it fell.
#[test]
#[ignore = "slow: run with --ignored"]
fn an_outlier_anywhere_moves_no_parameter_by_more_than_its_sd() {
    let name = "an_outlier_anywhere_moves_no_parameter_by_more_than_its_sd";
    let place = Place::new(&scene_text());
    let seed = seed_of(name);
    let rows = rows(&place.scene, seed);
    let clean =
        [LikelihoodFamily::Student, LikelihoodFamily::Normal].map(|tails| posterior(&place, &rows, tails, seed));
    let wet = |e: f64| {
        let near = |run: &NewRun| (run.restitution - e).abs();
        let of_wet = (0..rows.len()).filter(|run| rows[*run].liquid.is_some());
        of_wet
            .min_by(|a, b| near(&rows[*a]).total_cmp(&near(&rows[*b])))
            .expect("wet runs")
    };
    let dry = rows.iter().position(|run| run.liquid.is_none()).expect("dry runs");
    let mut worst_normal: f64 = 0.0;
    for run in [wet(0.6), wet(0.3), dry] {
        for e in [0.0, 0.06, 0.4, 0.87, 1.0] {
            let mut rows = rows.clone();
            rows[run].restitution = e;
            let student = moved(&clean[0], &posterior(&place, &rows, LikelihoodFamily::Student, seed));
            assert!(student.0 < 1.0, "run {run} at {e}: {}", student.1);
            if e == 1.0 || e == 0.0 {
                let normal = moved(&clean[1], &posterior(&place, &rows, LikelihoodFamily::Normal, seed));
                worst_normal = worst_normal.max(normal.0);
            }
        }
    }
    // the planted fault: tails that are not heavy
    assert!(worst_normal > 2.0, "{worst_normal}");
}

/// One wet rebound in fifteen is off by −0.35, whose mean is above σ: under Student's tails that is no misfit of its film. The
/// planted fault is a film whose runs are all off, the law being held.
#[test]
fn outliers_are_no_misfit_of_a_film_and_a_film_that_is_off_is_one() {
    let name = "outliers_are_no_misfit_of_a_film";
    let text = scene_text()
        + "[model]\nlikelihood = \"student\"\ninertia = \"stepwise\"\n[sampler]\nwarmup = 400\ndraws = 400\n[priors]\n\
           lubrication_log = { lognormal = [1.85, 0.001] }\ninertial_prefactor = { lognormal = [0.8, 0.001] }\n";
    let place = Place::new(&text);
    let holds = |is_off: &dyn Fn(usize, &NewRun) -> bool, by: f64| {
        let mut rows = rows(&place.scene, seed_of(name));
        for (number, row) in rows.iter_mut().enumerate() {
            if row.liquid.is_some() && row.restitution > 0.45 && is_off(number, row) {
                row.restitution -= by;
            }
        }
        let table = Table::of(arrange(&place.scene, &rows));
        let mut findings = fit_least_squares(&place.scene, &table, 1, false);
        sample(&mut findings, &place.scene, &table.runs).expect("sampled");
        findings.check("predictive_residual").passed
    };
    assert!(holds(&|number, _| number % 15 == 0, 0.35));
    let is_thick = |_: usize, row: &NewRun| row.film.is_some_and(|(_, film_ratio)| film_ratio > 0.1);
    assert!(!holds(&is_thick, 0.1));
}

/// Tails of different length are found: η of simulated runs lies inside its posterior, on its side of 0, and L is told better
/// than where noise is taken for normal.
#[test]
fn the_asymmetry_is_that_of_the_noise() {
    let name = "the_asymmetry_is_that_of_the_noise";
    let truth = "noise = \"asymmetric_laplace\"\nasymmetry = -1\n";
    let text = scene_text()
        .replace("[design]", &format!("{truth}[design]"))
        .replace("repeats = 3", "repeats = 8");
    let place = Place::new(&text);
    let rows = rows(&place.scene, seed_of(name));
    let of = |family: LikelihoodFamily| {
        let found = posterior(&place, &rows, family, seed_of(name));
        move |name: &str| {
            let (_, mean, sd) = found.iter().find(|(own, ..)| own == name).expect("sampled");
            (*mean, *sd)
        }
    };
    let (own, normal) = (of(LikelihoodFamily::AsymmetricLaplace), of(LikelihoodFamily::Normal));
    let (asymmetry, sd) = own("asymmetry");
    assert!(
        (asymmetry + 1.0).abs() < 3.5 * sd && asymmetry < -4.0 * sd,
        "{asymmetry} {sd}"
    );
    for (name, truth) in [
        ("lubrication_log", 1.85),
        ("inertial_prefactor", 0.8),
        ("sigma_wet", 0.02),
    ] {
        let (mean, sd) = own(name);
        assert!((mean - truth).abs() < 3.5 * sd, "{name}: {mean} {sd}");
    }
    let share = own("lubrication_log").1 / normal("lubrication_log").1;
    assert!(share < 0.9, "{share}");
}
