//! Holds that plain noise raises alarms as rarely as claimed, and that there are none where nothing can be told.

use super::{fit, noise_of, plain, scattered, tells, Design, SIGMA, USUAL};
use crate::common::{binomial_z, rows, seed_of};
use wetcor::findings::noise::{Outlier, FALSE_ALARM};
use wetcor::runs::NewRun;

/// The claims under the noise every interval assumes: alarms as rare as they are said to be, and an exact test of the
/// offsets whose probabilities are even over [0, 1].
#[test]
fn plain_noise_alarms_as_rarely_as_claimed() {
    const SETS: u64 = 600;
    let place = USUAL.place();
    let exact = rows(&place.scene, 1);
    let (mut outliers, mut notices) = (0, [0; 2]);
    let mut below: [[usize; 3]; 2] = [[0; 3]; 2];
    let levels = [0.01, 0.1, 0.5];
    for set in 0..SETS {
        let seed = seed_of("plain_noise_alarms_as_rarely_as_claimed").wrapping_add(set);
        let found = fit(&place.scene, &scattered(&exact, seed, plain), (1, false));
        let noise = noise_of(&found);
        outliers += usize::from(noise.outliers_found > 0);
        assert_eq!(tells(&found, "outlier"), noise.outliers_found > 0);
        let [spread, offsets] = [
            &noise.spread.as_ref().expect("groups").test,
            &noise.offsets.as_ref().expect("series").test,
        ];
        for (below, test) in below.iter_mut().zip([spread, offsets]) {
            for (below, level) in below.iter_mut().zip(levels) {
                *below += usize::from(test.p < level);
            }
        }
        for (count, code) in notices.iter_mut().zip(["unequal_spread", "series_offsets"]) {
            *count += usize::from(tells(&found, code));
        }
    }
    println!("outliers {outliers}, p of spreads and offsets below {levels:?}: {below:?}, notices {notices:?}");
    let z = |count: usize, level: f64| binomial_z(count, SETS as usize, level);
    assert!(z(outliers, FALSE_ALARM).abs() < 4.0, "{outliers}");
    for (level, count) in levels.into_iter().zip(below[1]) {
        assert!(z(count, level).abs() < 4.0, "offsets: {count} below {level}");
    }
    for (level, count) in levels.into_iter().zip(below[0]) {
        assert!(z(count, level) < 4.0, "spreads: {count} below {level}");
    }
    for count in notices {
        assert!(z(count, 0.01) < 4.0, "{count}");
    }
}

/// Few runs: the scale by medians is off by a third or more, and no more of the tables have an outlier for it.
#[test]
fn few_runs_raise_no_more_alarms() {
    const SETS: u64 = 1500;
    for repeats in [1, 2] {
        let design = Design {
            particles: &["PE"],
            films: "0.06",
            diameters: "5.0",
            repeats,
            ..USUAL
        };
        let place = design.place();
        let exact = rows(&place.scene, 1);
        let mut outliers = 0;
        for set in 0..SETS {
            let seed = seed_of("few_runs_raise_no_more_alarms").wrapping_add(set);
            let found = fit(&place.scene, &scattered(&exact, seed, plain), (1, false));
            outliers += usize::from(noise_of(&found).outliers_found > 0);
        }
        println!("{outliers} of {SETS} tables of {} runs", exact.len());
        let z = binomial_z(outliers, SETS as usize, FALSE_ALARM);
        assert!(z.abs() < 4.0, "{outliers}: {z}");
    }
}

/// Near the threshold runs stick or bounce by luck, which is no mistake; one that sticks far above it is.
#[test]
fn runs_that_stick_near_the_threshold_raise_no_alarm() {
    const SETS: u64 = 600;
    let design = Design {
        speeds: "0.35, 0.45, 0.55, 0.7, 0.9, 1.2, 1.6",
        sigma: SIGMA,
        ..USUAL
    };
    let place = design.place();
    let (mut alarms, mut stuck, mut all) = ([0; 3], 0, 0);
    for set in 0..SETS {
        let seed = seed_of("runs_that_stick_near_the_threshold_raise_no_alarm").wrapping_add(set);
        let mut runs = rows(&place.scene, seed);
        all += runs.len();
        stuck += runs.iter().filter(|run| run.restitution == 0.0).count();
        let found = fit(&place.scene, &runs, (1, false));
        for (count, code) in alarms.iter_mut().zip(["outlier", "unequal_spread", "series_offsets"]) {
            *count += usize::from(tells(&found, code));
        }
        let fast = |run: &NewRun| run.liquid.is_some() && run.restitution > 0.5;
        let at = runs.iter().position(fast).expect("a fast run");
        runs[at].restitution = 0.0;
        let found = fit(&place.scene, &runs, (1, false));
        let named = |one: &Outlier| one.row as usize == at + 1;
        assert!(noise_of(&found).outliers.iter().any(named), "{set}");
    }
    println!("{alarms:?} of {SETS} tables, in which {stuck} of {all} runs stuck");
    assert!(stuck * 50 > all);
    for count in alarms {
        assert!(binomial_z(count, SETS as usize, 0.01) < 4.0, "{alarms:?}");
    }
}

/// One series, series of one run, a handful of runs, none that scatter: no test where there is nothing to test.
#[test]
fn where_nothing_can_be_told_nothing_is() {
    let one = Design {
        particles: &["PE"],
        films: "0.06",
        diameters: "5.0",
        ..USUAL
    };
    let single = Design {
        speeds: "2.4",
        repeats: 1,
        ..USUAL
    };
    let seed = seed_of("where_nothing_can_be_told_nothing_is");
    for design in [one, single] {
        let place = design.place();
        let exact = rows(&place.scene, 1);
        let mut runs = scattered(&exact, seed, plain);
        runs.retain(|run| run.liquid != Some("AK20"));
        let found = fit(&place.scene, &runs, (1, false));
        let noise = noise_of(&found);
        assert!(
            noise.offsets.as_ref().is_none_or(|offsets| offsets.test.p > 0.001),
            "{noise:?}"
        );
        assert!(
            !tells(&found, "series_offsets") && !tells(&found, "unequal_spread"),
            "{noise:?}"
        );
        for few in 1..12 {
            let found = fit(&place.scene, &runs[runs.len() - few..], (1, false));
            assert!(found.noise.is_none_or(|noise| noise.outliers_found == 0));
            fit(&place.scene, &runs[..few], (1, false));
        }
    }
    let place = USUAL.place();
    let found = fit(&place.scene, &rows(&place.scene, 1), (1, false));
    assert!(found
        .noise
        .is_none_or(|noise| noise.outliers_found == 0 && noise.offsets.is_none_or(|one| one.share < 1.0)));
}
