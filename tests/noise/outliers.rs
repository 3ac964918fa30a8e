//! Holds that outliers are named wherever they lie, and do not hide each other.

use super::{fit, noise_of, plain, scattered, series_of, Design, ALARMS, SIGMA, USUAL};
use crate::common::{assert_seldom, counts, rows, seed_of, study, Says, Told};
use wetcor::findings::noise::Outlier;
use wetcor::findings::{self, Findings};
use wetcor::runs::{arrange, NewRun, RunError, Table};

/// Wherever it lies in [0, 1], and stuck or not.
#[test]
fn an_outlier_is_named() {
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let seed = seed_of("an_outlier_is_named");
    for (index, e) in [0.0, 0.05, 0.3, 0.6, 1.0].into_iter().enumerate() {
        for dry in [true, false] {
            let mut runs = scattered(&exact, seed.wrapping_add(index as u64), plain);
            let fits = |run: &NewRun| run.liquid.is_none() == dry && (run.restitution - e).abs() > 8.0 * plain(run);
            // not the first: a row that is always the same is no proof
            let at = (0..runs.len())
                .filter(|run| fits(&runs[*run]))
                .nth(30 + index)
                .expect("such a run");
            let expected = exact[at].restitution;
            runs[at].restitution = e;
            let found = fit(&place.scene, &runs);
            let noise = noise_of(&found);
            assert_eq!(noise.outliers_found, 1, "{e}: {:?}", noise.outliers);
            let one = &noise.outliers[0];
            assert_eq!((one.row as usize, one.restitution), (at + 1, e), "{one:?}");
            assert!((one.expected - expected).abs() < 0.01, "{one:?} {expected}");
            let sds = (e - expected) / plain(&runs[at]);
            assert!(
                (one.sds / sds - 1.0).abs() < 0.2 && one.moves_in_se > 0.0,
                "{one:?} {sds}"
            );
            let notice = found.notice("outlier").expect("told");
            notice.text.says(&format!("row {} of the table", at + 1));
        }
    }
}

/// Where no k is known, or the runs cannot tell all parameters apart, there are restitutions to be expected all the same.
#[test]
fn an_outlier_is_named_where_not_every_parameter_is_known() {
    const SETS: u64 = 50;
    let one_film = Design {
        model: "inertia = \"saturating\"",
        films: "0.06",
        ..USUAL
    };
    for (design, has_dry) in [(USUAL, false), (one_film, true)] {
        let place = design.place();
        let mut exact = rows(&place.scene, 1);
        exact.retain(|run| has_dry || run.liquid.is_some());
        let alarms = study("an_outlier_is_named_where_not_every_parameter_is_known", SETS, |seed| {
            let mut runs = scattered(&exact, seed, plain);
            let found = fit(&place.scene, &runs);
            let at = runs.len() / 2;
            runs[at].restitution -= 0.25;
            let with = fit(&place.scene, &runs);
            let named = |one: &Outlier| one.row as usize == at + 1;
            assert!(noise_of(&with).outliers.iter().any(named), "{:?}", noise_of(&with));
            ALARMS.map(|code| found.tells(code))
        });
        for count in counts(&alarms) {
            assert_seldom("alarms", count, SETS, 0.01);
        }
    }
}

/// What is said of the parameter it moves most is what a fit without the run does.
#[test]
fn the_move_is_that_of_a_fit_without_the_run() {
    let design = Design { repeats: 2, ..USUAL };
    let place = design.place();
    let exact = rows(&place.scene, 1);
    let mut runs = scattered(&exact, seed_of("the_move_is_that_of_a_fit_without_the_run"), plain);
    let at = 110;
    runs[at].restitution -= 0.2;
    let with = fit(&place.scene, &runs);
    let one = noise_of(&with).outliers[0].clone();
    assert_eq!(one.row as usize, at + 1);
    runs.remove(at);
    let without = fit(&place.scene, &runs);
    let of = |findings: &Findings| findings.fitted(&one.moves).pair().expect("a number");
    let (after, se) = of(&without);
    let moved = (of(&with).0 - after).abs() / se;
    assert!((one.moves_in_se / moved - 1.0).abs() < 0.1, "{one:?} {moved}");
}

/// Twelve mistakes, half of them in one series of fifteen runs: none hides another.
#[test]
fn outliers_do_not_hide_each_other() {
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let mut runs = scattered(&exact, seed_of("outliers_do_not_hide_each_other"), plain);
    let one = series_of(&exact[400]);
    let of_one = (0..runs.len()).filter(|run| series_of(&exact[*run]) == one).step_by(4);
    let mut bad: Vec<usize> = of_one.take(6).chain([10, 31, 200, 250, 300, 350]).collect();
    for (index, run) in bad.iter().enumerate() {
        runs[*run].restitution += [0.25, -0.3, 0.2][index % 3];
    }
    let found = fit(&place.scene, &runs);
    let noise = noise_of(&found);
    assert_eq!(noise.outliers_found, 12, "{:?}", noise.outliers);
    bad.sort_unstable();
    for outlier in &noise.outliers {
        assert!(bad.binary_search(&(outlier.row as usize - 1)).is_ok(), "{outlier:?}");
    }
    let notice = found.notice("outlier").expect("told");
    assert_eq!(notice.count(), 12);
    assert!(notice.text.ends_with("and 9 more"), "{}", notice.text);
    // they are taken out before spreads and offsets are looked at
    assert!(!found.tells("unequal_spread") && !found.tells("series_offsets"));
}

/// Student's t has room for them.
#[test]
fn under_a_student_likelihood_no_outlier_is_told() {
    let design = Design {
        model: "inertia = \"stepwise\"\nlikelihood = \"student\"",
        ..USUAL
    };
    let place = design.place();
    let mut runs = scattered(&rows(&place.scene, 1), seed_of("under_a_student_likelihood"), plain);
    runs[200].restitution -= 0.3;
    let found = fit(&place.scene, &runs);
    assert_eq!((noise_of(&found).outliers_found, found.tells("outlier")), (0, false));
}

/// A run whose table says that it was measured badly is not far for lying further away; without that it would be.
#[test]
fn runs_are_held_against_their_own_measurement_errors() {
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let own = 8.0 * SIGMA;
    // every seventh run
    let badly = |row: u32| row.is_multiple_of(7);
    let mut count = 0;
    let wider = |run: &NewRun| f64::hypot(plain(run), own);
    let seed = seed_of("runs_are_held_against_their_own_measurement_errors");
    let (mut runs, wide) = (scattered(&exact, seed, plain), scattered(&exact, seed, wider));
    for (index, (run, wide)) in runs.iter_mut().zip(wide).enumerate() {
        if badly(index as u32 + 1) {
            *run = wide;
            count += 1;
        }
    }
    let mut table = Table::of(arrange(&place.scene, &runs));
    let unknown = findings::fit_least_squares(&place.scene, &table, 1, false);
    let outliers = noise_of(&unknown).outliers_found;
    assert!(outliers > count / 6, "{outliers} of {count}");
    let of_run = |row: &u32| RunError {
        restitution_sd: if badly(*row) { own } else { 0.0 },
        ..RunError::default()
    };
    table.runs.errors = table.runs.row.iter().map(of_run).collect();
    let known = findings::fit_least_squares(&place.scene, &table, 1, false);
    assert_eq!(noise_of(&known).outliers_found, 0, "{:?}", noise_of(&known).outliers);
}
