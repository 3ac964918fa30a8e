//! Holds that plain noise raises alarms as rarely as claimed, and that there are none where nothing can be told.

use super::{fit, noise_of, plain, scattered, Design, ALARMS, ONE_SERIES, SIGMA, USUAL};
use crate::common::{assert_expected, assert_seldom, counts, rows, seed_of, study, Told};
use wetcor::findings::noise::{Outlier, FALSE_ALARM};
use wetcor::runs::NewRun;

/// The claims under the noise every interval assumes: alarms as rare as they are said to be, and an exact test of the
/// offsets whose probabilities are even over [0, 1].
#[test]
fn plain_noise_alarms_as_rarely_as_claimed() {
    const SETS: u64 = 120;
    const LEVELS: [f64; 3] = [0.01, 0.1, 0.5];
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let found = study("plain_noise_alarms_as_rarely_as_claimed", SETS, |seed| {
        let found = fit(&place.scene, &scattered(&exact, seed, plain));
        let noise = noise_of(&found);
        assert_eq!(found.tells("outlier"), noise.outliers_found > 0);
        let told = ALARMS.map(|code| found.tells(code));
        let spread = &noise.spread.as_ref().expect("groups").test;
        let offsets = &noise.offsets.as_ref().expect("series").test;
        [
            told,
            LEVELS.map(|level| spread.p < level),
            LEVELS.map(|level| offsets.p < level),
        ]
    });
    let of = |which: usize| counts(&found.iter().map(|one| one[which]).collect::<Vec<_>>());
    let [[outliers, notices @ ..], spreads, offsets] = [0, 1, 2].map(of);
    assert_expected("outliers", outliers, SETS, FALSE_ALARM);
    for ((level, spreads), offsets) in LEVELS.into_iter().zip(spreads).zip(offsets) {
        assert_expected("offsets", offsets, SETS, level);
        assert_seldom("spreads", spreads, SETS, level);
    }
    for count in notices {
        assert_seldom("notices", count, SETS, 0.01);
    }
}

/// Few runs: the scale by medians is off by a third or more, and no more of the tables have an outlier for it.
#[test]
fn few_runs_raise_no_more_alarms() {
    const SETS: u64 = 600;
    for repeats in [1, 2] {
        let place = Design { repeats, ..ONE_SERIES }.place();
        let exact = rows(&place.scene, 1);
        let found = study("few_runs_raise_no_more_alarms", SETS, |seed| {
            let found = fit(&place.scene, &scattered(&exact, seed, plain));
            [noise_of(&found).outliers_found > 0]
        });
        let [outliers] = counts(&found);
        assert_expected("outliers", outliers, SETS, FALSE_ALARM);
    }
}

/// Near the threshold runs stick or bounce by luck, which is no mistake; one that sticks far above it is.
#[test]
fn runs_that_stick_near_the_threshold_raise_no_alarm() {
    const SETS: u64 = 40;
    let design = Design {
        speeds: "0.35, 0.45, 0.55, 0.7, 0.9, 1.2, 1.6",
        sigma: SIGMA,
        ..USUAL
    };
    let place = design.place();
    let found = study("runs_that_stick_near_the_threshold_raise_no_alarm", SETS, |seed| {
        let mut runs = rows(&place.scene, seed);
        let stuck = runs.iter().filter(|run| run.restitution == 0.0).count();
        let found = fit(&place.scene, &runs);
        let fast = |run: &NewRun| run.liquid.is_some() && run.restitution > 0.5;
        let at = runs.iter().position(fast).expect("a fast run");
        runs[at].restitution = 0.0;
        let with = fit(&place.scene, &runs);
        let named = |one: &Outlier| one.row as usize == at + 1;
        assert!(noise_of(&with).outliers.iter().any(named), "{seed}");
        (ALARMS.map(|code| found.tells(code)), stuck, runs.len())
    });
    let alarms = counts(&found.iter().map(|one| one.0).collect::<Vec<_>>());
    let (stuck, all): (usize, usize) = (found.iter().map(|one| one.1).sum(), found.iter().map(|one| one.2).sum());
    assert!(stuck * 50 > all);
    for count in alarms {
        assert_seldom("alarms", count, SETS, 0.01);
    }
}

/// One series, series of one run, a handful of runs, none that scatter: no test where there is nothing to test.
#[test]
fn where_nothing_can_be_told_nothing_is() {
    let single = Design {
        speeds: "2.4",
        repeats: 1,
        ..USUAL
    };
    let seed = seed_of("where_nothing_can_be_told_nothing_is");
    for design in [ONE_SERIES, single] {
        let place = design.place();
        let exact = rows(&place.scene, 1);
        let mut runs = scattered(&exact, seed, plain);
        runs.retain(|run| run.liquid != Some("AK20"));
        let found = fit(&place.scene, &runs);
        let noise = noise_of(&found);
        assert!(
            noise.offsets.as_ref().is_none_or(|offsets| offsets.test.p > 0.001),
            "{noise:?}"
        );
        assert!(
            !found.tells("series_offsets") && !found.tells("unequal_spread"),
            "{noise:?}"
        );
        for few in 1..12 {
            let found = fit(&place.scene, &runs[runs.len() - few..]);
            assert!(found.noise.is_none_or(|noise| noise.outliers_found == 0));
            fit(&place.scene, &runs[..few]);
        }
    }
    let place = USUAL.place();
    let found = fit(&place.scene, &rows(&place.scene, 1));
    assert!(found
        .noise
        .is_none_or(|noise| noise.outliers_found == 0 && noise.offsets.is_none_or(|one| one.share < 1.0)));
}
