//! Tests that profile limits cost few evaluations of runs, and are those of every run.

use std::path::Path;

use super::*;
use crate::inference::delta::PROFILE;
use crate::inference::profile::Squares;
use crate::model::simulate::Simulation;
use crate::runs;
use crate::scene;

const QUOTING: Quoting = Quoting { level: 0.95 };

/// The example's scene and design, with every film measured: the column `film_ratio` is each run's own.
fn films_of_their_own(count: u64) -> (Scene, Runs) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
    let scene = scene::read(&path).expect("the example's scene is good");
    let simulation = Simulation::new(&scene, Some(count)).expect("the example has a truth and a design");
    let mut rows = simulation.under(7).all();
    for (row, run) in rows.iter_mut().enumerate() {
        // no two within rounding of each other
        let share = 1.0 + 0.02 * ((0.618 * row as f64).fract() - 0.5);
        run.film = run.film.map(|(film, ratio)| (film * share, ratio * share));
    }
    let runs = runs::arrange(&scene, &rows);
    (scene, runs)
}

fn fitted<'r>(scene: &Scene, runs: &'r Runs) -> FittedBalance<'r> {
    let dry = dry::fit_dry_laws(scene, runs, QUOTING);
    let known = spheres_with_known_k(runs, &dry);
    let form = Form::new(Inertia::Saturating, scene.model.dry_speed);
    let weighed = fit_weighed(Joint::new(scene, runs, form, &known, &known), &dry, 1.0);
    FittedBalance {
        uncertain: uncertain(&weighed.fit),
        roots: vec![],
        bias: vec![],
        spread: weighed.spread,
        problem: weighed.problem,
        fit: weighed.fit,
    }
}

/// What the estimates at every place cost.
#[derive(Debug)]
struct Cost {
    places: usize,
    /// of them, those whose limits were searched
    curved: usize,
    /// how many times a run was evaluated
    evaluated: usize,
}

fn cost(count: u64) -> Cost {
    let (scene, runs) = films_of_their_own(count);
    let fitted = fitted(&scene, &runs);
    assert!(fitted.converged());
    let minimum = fitted.minimum();
    let estimates = BalanceEstimates::new(&fitted, &minimum, QUOTING);
    let places = WetPlace::all(&runs, fitted.joint().form);
    let derived = places.iter().enumerate();
    let derived = derived.filter_map(|(index, place)| derive(&scene, index, place, &estimates));
    let is_curved = |row: &DerivedEstimate| row.st_c.intervals.iter().any(|own| own.method == PROFILE);
    let curved = derived.filter(is_curved).count();
    let profile = estimates.profile.as_ref().expect("the fit has a covariance");
    Cost {
        places: places.len(),
        curved,
        evaluated: profile.squares().evaluated(),
    }
}

#[test]
fn the_cost_of_a_place_does_not_grow_with_the_runs() {
    let [few, many] = [1_000, 4_000].map(cost);
    assert!(few.curved > 0, "{few:?}");
    assert!(many.places > 3 * few.places, "{few:?} {many:?}");
    // the two quantities of a place would take six passes of 4,000 runs each, were there no series
    assert!(many.evaluated < 1_500 * many.places, "{many:?}");
    // and four times the runs sixteen times the evaluations
    assert!(many.evaluated < 8 * few.evaluated, "{few:?} {many:?}");
}

#[test]
fn limits_are_those_with_every_run_evaluated() {
    let (scene, runs) = films_of_their_own(1_000);
    let fitted = fitted(&scene, &runs);
    let minimum = fitted.minimum();
    let region = fitted.region(&minimum, QUOTING).expect("the fit has a covariance");
    let by_series = JointSquares::new(&fitted.problem, &[], &region);
    let [few, all] = [by_series.runs_a_point(), fitted.problem.runs()];
    assert!(10 * few < all, "{few} of {all} runs are evaluated");
    let by_runs = JointSquares::new(&fitted.problem, &[], &region).evaluating_all();
    let (least, of_runs) = (by_series.at(&minimum), by_runs.at(&minimum));
    let off = least.zip(of_runs).map(|(own, other)| (own / other - 1.0).abs());
    assert!(off.is_some_and(|off| off < 1e-12), "{least:?} {of_runs:?}");
    let by_series = ProblemProfile::new(by_series, region).expect("finite squares");
    let by_runs = ProblemProfile::new(by_runs, region).expect("finite squares");
    let mut checked = 0;
    for place in WetPlace::all(&runs, fitted.joint().form).iter().step_by(25) {
        let st_c = |point: &[f64]| {
            let at = at_place(&scene, fitted.joint(), point, place)?;
            Some(WithSlopes {
                value: at.value(Quantity::StC),
                slopes: at.slopes(Quantity::StC),
            })
        };
        let both = [by_series.limits(st_c), by_runs.limits(st_c)];
        let [Some(of_series), Some(of_runs)] = both.map(|limits| limits.and_then(Limits::both)) else {
            assert_eq!(both[0].is_some(), both[1].is_some());
            continue;
        };
        let width = of_runs[1] - of_runs[0];
        for (own, other) in of_series.iter().zip(of_runs) {
            assert!((own - other).abs() < 1e-3 * width, "{of_series:?} {of_runs:?}");
        }
        checked += 1;
    }
    assert!(checked >= 3, "{checked}");
}
