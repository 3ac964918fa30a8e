//! Holds that unequal spreads and shared offsets are told when they matter, with what standard errors lack by them.

use super::{fit, noise_of, offset, plain, scattered, tells, Design, SIGMA, USUAL};
use crate::common::{self, binomial_z, rows, seed_of};
use wetcor::findings::noise::LINE;
use wetcor::findings::Findings;
use wetcor::runs::NewRun;
use wetcor::scene::WetLaw;

/// Three times the spread for one particle is told, with the sds; a twentieth more is none of the reader's business.
#[test]
fn unequal_spreads_are_told_when_they_matter() {
    const SETS: u64 = 50;
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let told = |factor: f64| {
        let count = |set: &u64| {
            let seed = seed_of("unequal_spreads_are_told_when_they_matter").wrapping_add(*set);
            let wider = |run: &NewRun| {
                if run.particle == "PE" {
                    factor * plain(run)
                } else {
                    plain(run)
                }
            };
            let found = fit(&place.scene, &scattered(&exact, seed, wider), (1, false));
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
                assert!(spread.worst().expect("a parameter").ratio > LINE, "{spread:?}");
                // each group has a spread of its own: its tails are no outliers
                assert!(noise.outliers_found < 3, "{:?}", noise.outliers);
            }
            tells(&found, "unequal_spread")
        };
        (0..SETS).filter(count).count()
    };
    assert_eq!(told(3.0), SETS as usize);
    let slight = told(1.05);
    assert!(binomial_z(slight, SETS as usize, 0.01) < 4.0, "{slight}");
}

/// The factor is what the standard error lacks: the spread of the estimate over many tables.
#[test]
fn the_factor_is_what_a_standard_error_lacks() {
    const SETS: u64 = 600;
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let name = seed_of("the_factor_is_what_a_standard_error_lacks");
    // for unequal spreads, and for shared offsets
    for offsets in [false, true] {
        let names = ["lubrication_log", "inertial_prefactor"];
        let mut values: [Vec<f64>; 2] = Default::default();
        let (mut ses, mut ratios) = (values.clone(), values.clone());
        for set in 0..SETS {
            let seed = name.wrapping_add(set);
            let wider = |run: &NewRun| match run.particle {
                "PE" if !offsets && run.liquid.is_some() => 3.0 * SIGMA,
                _ => plain(run),
            };
            let mut runs = scattered(&exact, seed, wider);
            if offsets {
                offset(&mut runs, seed, 0.5 * SIGMA);
            }
            let found = fit(&place.scene, &runs, (1, false));
            let balance = found.energy_balance.as_ref().expect("a balance");
            let noise = noise_of(&found);
            let lacking = if offsets {
                &noise.offsets.as_ref().expect("series").standard_errors
            } else {
                &noise.spread.as_ref().expect("groups").standard_errors
            };
            for (index, name) in names.into_iter().enumerate() {
                let of = balance.parameters.iter().find(|parameter| parameter.name == name);
                let (value, se) = of.expect("a parameter").estimate.pair().expect("a number");
                values[index].push(value);
                ses[index].push(se);
                let of = lacking.iter().find(|lacking| lacking.parameter == name);
                ratios[index].push(of.expect("a parameter").ratio);
            }
        }
        for (index, name) in names.into_iter().enumerate() {
            let sd = common::mean(&values[index]).1 * (SETS as f64).sqrt();
            let lacks = sd / common::mean(&ses[index]).0;
            let told = common::mean(&ratios[index]).0;
            println!("offsets {offsets}, {name}: lacks {lacks:.3}, told {told:.3}");
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
fn shared_offsets_are_told_and_the_series_bootstrap_covers_them() {
    const SETS: u64 = 200;
    let of_scheme = |scheme: &'static str| {
        let design = Design {
            bootstrap: scheme,
            particles: &["PE"],
            films: "0.06",
            diameters: "3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0",
            repeats: 3,
            ..USUAL
        };
        let place = design.place();
        let exact = rows(&place.scene, 1);
        // without noise the law returns its own truth
        let truth = fit(&place.scene, &scattered(&exact, 1, |_| 1e-9), (1, false));
        let of = |findings: &Findings| {
            let laws = findings.scaling.iter();
            let law = laws
                .filter(|row| row.law == WetLaw::Sqrt)
                .find(|row| row.film_ratio.is_some());
            let law = law.expect("the film ratio");
            [law.e_inf.clone(), law.st_c.clone()]
        };
        let truth = of(&truth).map(|estimate| estimate.value.expect("a number"));
        let (mut covered, mut told) = ([0; 2], 0);
        for set in 0..SETS {
            let seed = seed_of("shared_offsets_are_told").wrapping_add(set);
            let mut runs = scattered(&exact, seed, plain);
            offset(&mut runs, seed, 0.5 * SIGMA);
            let found = fit(&place.scene, &runs, (seed, true));
            told += usize::from(tells(&found, "series_offsets"));
            for ((covered, truth), estimate) in covered.iter_mut().zip(truth).zip(of(&found)) {
                let [lo, hi] = estimate.interval.expect("an interval");
                *covered += usize::from((lo..=hi).contains(&truth));
            }
        }
        println!("{scheme}: told {told}, covered {covered:?} of {SETS}");
        (told, covered)
    };
    let (told, series) = of_scheme("scheme = \"series\"\nreplicates = 400");
    let (_, cases) = of_scheme("scheme = \"cases\"\nreplicates = 400");
    assert!(told * 20 > SETS as usize * 19, "{told}");
    for (series, cases) in series.into_iter().zip(cases) {
        let z = |count| binomial_z(count, SETS as usize, 0.95);
        assert!(z(series).abs() < 4.0, "{series}: {}", z(series));
        assert!(z(cases) < -8.0, "{cases}: {}", z(cases));
    }
}

/// A wet law that does not hold bends the runs of each series alike: of two series no sd of offsets can be had, however
/// much better an offset for each fits.
#[test]
fn a_law_that_does_not_hold_in_two_series_is_no_offset() {
    let design = Design {
        particles: &["PTFE"],
        films: "0.06",
        diameters: "5.0",
        speeds: "0.5, 0.8, 1.3, 2.0, 3.0",
        ..USUAL
    };
    let place = design.place();
    let seed = seed_of("a_law_that_does_not_hold_in_two_series_is_no_offset");
    let mut runs = rows(&place.scene, 1);
    for run in runs.iter_mut().filter(|run| run.liquid.is_some()) {
        // a line in 1/v, where the law has the root of one
        run.restitution = 0.75 * (1.0 - 0.2 / run.impact_speed);
    }
    let found = fit(&place.scene, &scattered(&runs, seed, |_| 0.002), (seed, false));
    assert_eq!(noise_of(&found).offsets, None);
    assert!(!tells(&found, "series_offsets"));
}
