//! Holds that unequal spreads and shared offsets are told when they matter, with what standard errors lack by them.

use super::{fit, noise_of, offset, plain, scattered, Design, ONE_SERIES, SIGMA, USUAL};
use crate::common::{assert_expected, assert_seldom, binomial_z, counts, holds, mean, rows, seed_of, study, Told};
use wetcor::findings::noise::LINE;
use wetcor::findings::{self, Findings};
use wetcor::physics::Quantity::{EInf, StC};
use wetcor::runs::{arrange, NewRun, Table};

/// Three times the spread for one particle is told, with the sds; a twentieth more is none of the reader's business.
#[test]
fn unequal_spreads_are_told_when_they_matter() {
    const SETS: u64 = 50;
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let told = |factor: f64| {
        let of_set = |seed: u64| {
            let wider = |run: &NewRun| plain(run) * if run.particle == "PE" { factor } else { 1.0 };
            let found = fit(&place.scene, &scattered(&exact, seed, wider));
            let noise = noise_of(&found);
            let spread = noise.spread.as_ref().expect("groups");
            if factor > 2.0 {
                let ends = (spread.widest.particle.as_str(), spread.narrowest.particle.as_str());
                assert_eq!(ends, ("PE", "PTFE"));
                let sd = if spread.widest.liquid.is_some() {
                    SIGMA
                } else {
                    0.5 * SIGMA
                };
                assert!((spread.widest.sd / (factor * sd) - 1.0).abs() < 0.4, "{spread:?}");
                let affected = spread.affected_standard_error().expect("a parameter");
                assert!(affected.ratio > LINE, "{spread:?}");
                // each group has a spread of its own: its tails are no outliers
                assert!(noise.outliers_found < 3, "{:?}", noise.outliers);
            }
            [found.tells("unequal_spread")]
        };
        counts(&study("unequal_spreads_are_told_when_they_matter", SETS, of_set))[0]
    };
    assert_eq!(told(3.0), SETS as usize);
    let slight = told(1.05);
    assert_seldom("slight", slight, SETS, 0.01);
}

/// The factor is what the standard error lacks: the spread of the estimate over many tables.
#[test]
#[ignore = "slow: fits 1,200 tables"]
fn the_factor_is_what_a_standard_error_lacks() {
    const SETS: u64 = 600;
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    // for unequal spreads, and for shared offsets
    for offsets in [false, true] {
        let names = ["lubrication_log", "inertial_prefactor"];
        let found = study("the_factor_is_what_a_standard_error_lacks", SETS, |seed| {
            let wider = |run: &NewRun| match run.particle {
                "PE" if !offsets && run.liquid.is_some() => 3.0 * SIGMA,
                _ => plain(run),
            };
            let mut runs = scattered(&exact, seed, wider);
            if offsets {
                offset(&mut runs, seed, 0.5 * SIGMA);
            }
            let found = fit(&place.scene, &runs);
            let noise = noise_of(&found);
            let lacking = if offsets {
                &noise.offsets.as_ref().expect("series").standard_errors
            } else {
                &noise.spread.as_ref().expect("groups").standard_errors
            };
            names.map(|name| {
                let (value, se) = found.fitted(name).pair().expect("a number");
                let of = lacking.iter().find(|lacking| lacking.parameter == name);
                [value, se, of.expect("a parameter").ratio]
            })
        });
        for (index, name) in names.into_iter().enumerate() {
            let [value, se, ratio] = [0, 1, 2].map(|what| {
                let all: Vec<f64> = found.iter().map(|of| of[index][what]).collect();
                mean(&all)
            });
            let lacks = value.1 * (SETS as f64).sqrt() / se.0;
            let told = ratio.0;
            // one standard error of an sd of so many sets
            let se = lacks / (2.0 * SETS as f64).sqrt();
            assert!(((lacks - told) / se).abs() < 4.0, "{name}: {lacks} {told}");
            // the planted fault: nothing lacking
            assert!((lacks - 1.0) / se > 5.0, "{name}: {lacks}");
        }
    }
}

/// Where series share offsets this is told, and what is recommended helps: intervals of the `series` bootstrap cover,
/// those of the `cases` bootstrap, the planted fault, do not.
#[test]
#[ignore = "slow: run with --ignored"]
fn shared_offsets_are_told_and_the_series_bootstrap_covers_them() {
    const SETS: u64 = 80;
    let of_scheme = |scheme: &'static str| {
        let design = Design {
            bootstrap: scheme,
            diameters: "3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0",
            repeats: 3,
            ..ONE_SERIES
        };
        let place = design.place();
        let exact = rows(&place.scene, 1);
        // without noise the law returns its own truth
        let truth = fit(&place.scene, &scattered(&exact, 1, |_| 1e-9));
        let of = |findings: &Findings| {
            let law = findings.square_root();
            [law.estimates[EInf].clone(), law.estimates[StC].clone()]
        };
        let truth = of(&truth).map(|estimate| estimate.value.expect("a number"));
        let found = study("shared_offsets_are_told", SETS, |seed| {
            let mut runs = scattered(&exact, seed, plain);
            offset(&mut runs, seed, 0.5 * SIGMA);
            let table = Table::of(arrange(&place.scene, &runs));
            let found = findings::fit_least_squares(&place.scene, &table, seed, true);
            let [e_inf, st_c] = of(&found).map(|estimate| Some(estimate.interval.expect("an interval")));
            [
                found.tells("series_offsets"),
                holds(e_inf, truth[0]),
                holds(st_c, truth[1]),
            ]
        });
        let [told, covered @ ..] = counts(&found);
        (told, covered)
    };
    let (told, series) = of_scheme("scheme = \"series\"\nreplicates = 400");
    let (_, cases) = of_scheme("scheme = \"cases\"\nreplicates = 400");
    assert!(told * 20 > SETS as usize * 19, "{told}");
    for (series, cases) in series.into_iter().zip(cases) {
        let z = |count| binomial_z(count, SETS as usize, 0.95);
        assert_expected("series", series, SETS, 0.95);
        // no more than 83 %
        assert!(z(cases) < -5.0, "{cases}: {}", z(cases));
    }
}

/// A wet law that does not hold bends the runs of each series alike: of two series no sd of offsets can be had, however
/// much better an offset for each fits.
#[test]
fn a_law_that_does_not_hold_in_two_series_is_no_offset() {
    let design = Design {
        particles: &["PTFE"],
        speeds: "0.5, 0.8, 1.3, 2.0, 3.0",
        ..ONE_SERIES
    };
    let place = design.place();
    let seed = seed_of("a_law_that_does_not_hold_in_two_series_is_no_offset");
    let mut runs = rows(&place.scene, 1);
    for run in runs.iter_mut().filter(|run| run.liquid.is_some()) {
        // a line in 1/v, where the law has the root of one
        run.restitution = 0.75 * (1.0 - 0.2 / run.impact_speed);
    }
    let found = fit(&place.scene, &scattered(&runs, seed, |_| 0.002));
    assert_eq!(noise_of(&found).offsets, None);
    assert!(!found.tells("series_offsets"));
}
