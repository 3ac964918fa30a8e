//! Draws runs from designs: films and speeds of their own and blocks that anyone may draw.

use crate::common::scenes::{design, scene_of, truth, AK10, PTFE};
use crate::common::{mean, seed_of, Place};
use wetcor::model::simulate::{Simulation, BLOCK};
use wetcor::physics::rebound::mean_restitution;
use wetcor::runs::NewRun;
use wetcor::seed::stream;

/// One particle and liquid clear of the threshold, with two film ratios and three speeds.
fn scene_text() -> String {
    let truth = truth(
        [1.9, 0.45, 0.01, 0.005],
        "inertia = \"saturating\"\nfilm_scale = 0.07\n",
    );
    let own = "film_rel_sd = 0.1\nimpact_speed_rel_sd = 0.05\n";
    let design = design(["4.762", "0.06, 0.12"], &["AK10"], ["0.9, 1.3, 1.7", "0.5, 1.5"], own);
    let design = design.replace("height_mm", "impact_speed_m_s");
    scene_of("films and speeds of their own", &[PTFE, AK10, &truth, &design])
}

/// A number in units of the sd that it should have, or its mean and square over many runs.
fn moments(numbers: &[f64]) -> [f64; 2] {
    let squares: Vec<f64> = numbers.iter().map(|z| z * z).collect();
    [(numbers, 0.0), (&squares[..], 1.0)].map(|(numbers, expected)| {
        let (found, se) = mean(numbers);
        (found - expected) / se
    })
}

/// How far the noise of wet runs is from standard normal, taken about the law at the film that `film` makes of a run's own
/// and its setting's.
fn noise(runs: &[NewRun], film: fn(f64, f64) -> f64) -> [f64; 2] {
    let e_dry = 1.0 - 0.183 * 2f64.powf(0.2);
    let z = runs.iter().filter_map(|run| {
        let (own, nominal) = run.film?;
        let film_ratio = film(own / run.diameter, nominal);
        let stokes = 2150.0 * run.diameter * run.impact_speed / (9.0 * 9.3e-3);
        let lost = 0.45 * 930.0 / 2150.0 * (1.0 - (-film_ratio / 0.07).exp());
        let kept = e_dry * e_dry - lost - 4.0 * 1.9 / stokes;
        Some((run.restitution - mean_restitution(kept)) / 0.005)
    });
    moments(&z.collect::<Vec<_>>())
}

#[test]
fn every_run_has_a_film_and_a_speed_of_its_own_and_the_restitution_that_belongs_to_them() {
    let place = Place::new(&scene_text());
    let simulation = Simulation::new(&place.scene, Some(20_000)).expect("a truth and a design");
    let runs = simulation.under(seed_of("films_and_speeds_of_their_own")).all();
    let logs = |of: &dyn Fn(&NewRun) -> Option<f64>, sd: f64| -> Vec<f64> {
        runs.iter().filter_map(|run| Some(of(run)?.ln() / sd)).collect()
    };
    let films = logs(&|run| run.film.map(|(own, nominal)| own / run.diameter / nominal), 0.1);
    // the settings are many sds apart: the nearest is a run's own
    let relative = |run: &NewRun| {
        let settings: &[f64] = if run.film.is_some() {
            &[0.9, 1.3, 1.7]
        } else {
            &[0.5, 1.5]
        };
        let v = run.impact_speed;
        let nearest = settings.iter().min_by(|a, b| (*a - v).abs().total_cmp(&(*b - v).abs()));
        Some(v / nearest?)
    };
    let speeds = logs(&relative, 0.05);
    for z in [moments(&films), moments(&speeds), noise(&runs, |own, _| own)] {
        assert!(z.iter().all(|z| z.abs() < 4.0), "{z:?}");
    }
    // the planted fault: a restitution that belongs to the setting's film goes red
    let z = noise(&runs, |_, nominal| nominal);
    assert!(z[1].abs() > 10.0, "{z:?}");
}

#[test]
fn the_first_block_is_drawn_as_runs_of_one_stream_are_and_no_block_repeats_another() {
    let place = Place::new(&scene_text().replace("sigma_wet = 0.005", "sigma_wet = 0.005\nsigma_series = 0.01"));
    let drawn = |runs: u64| Simulation::new(&place.scene, Some(runs)).expect("a truth and a design");
    // 8 settings, of which 5 have a run more
    let few = drawn(1_005);
    let one_stream = few.draw_from(stream(3, "simulate", 0));
    assert_eq!(few.under(3).all(), one_stream);
    assert_eq!(one_stream.len(), 1_005);
    let many = drawn(2 * BLOCK + 7);
    let runs = many.under(3);
    assert_eq!(runs.blocks(), 3);
    let [first, second, last] = [0, 1, 2].map(|block| runs.block(block));
    assert_eq!(
        [first.len(), second.len(), last.len()].map(|runs| runs as u64),
        [BLOCK, BLOCK, 7]
    );
    assert_ne!(first[..7], last);
    // every setting has its share, in turn
    let all = runs.all();
    let settings = all.chunk_by(|a, b| a.film.map(|film| film.1) == b.film.map(|film| film.1));
    let counts: Vec<u64> = settings.map(|runs| runs.len() as u64).collect();
    let share = BLOCK / 4;
    assert_eq!(counts, [2 * share + 2, 3 * share + 3, 3 * share + 2]);
}
