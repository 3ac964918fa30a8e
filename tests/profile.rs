//! Holds the profile's intervals, and when they are quoted, against simulated runs near the threshold.

use crate::common::scenes::{self, design, scene_of, M50, PTFE, STEPWISE};
use crate::common::{binomial_z, counts, study, Place, Told};
use wetcor::findings::estimate::Estimate;
use wetcor::findings::scaling::Scaling;
use wetcor::physics::Quantity::StC;
use wetcor::scene::WetLaw;

/// Three heights, the lowest of which is within two standard deviations of no rebound at the thicker film: a lucky run
/// there pins the fit at the edge of the square root.
fn near_threshold() -> String {
    let bootstrap = "[bootstrap]\nreplicates = 500\nlevel = 0.95\n";
    let truth = scenes::truth([2.75, 1.0, 0.01, 0.03], "");
    let design = design(
        ["4.762", "0.04, 0.08"],
        &["M50"],
        ["39, 75, 150", "0.5, 1.0, 2.0"],
        "repeats = 3\n",
    );
    scene_of("near the threshold", &[PTFE, M50, STEPWISE, bootstrap, &truth, &design])
}

/// St_c at a film ratio, of the truth above.
fn truth(film_ratio: f64) -> f64 {
    let e_dry = 1.0 - 0.183 * 2f64.powf(0.2);
    let nominal: f64 = if film_ratio < 0.06 { 0.04 } else { 0.08 };
    let shape = nominal * (3.0 - 6.0 * nominal + 4.0 * nominal * nominal);
    2.0 * 2.75 / (e_dry * e_dry - 965.0 / 2150.0 * shape)
}

/// Whether the truth lies beyond t's 99.73 % quantile of the ± of an estimate of St_c, and of the delta method's ±, quoted or
/// not, and whether there is an interval; `None` without a value. `wide` is the same estimate at the level 99.73 %.
fn judged(estimate: &Estimate, wide: &Estimate, truth: f64) -> Option<[bool; 3]> {
    estimate.value?;
    assert_eq!(
        estimate.why_none.is_some(),
        estimate.se.is_none() || estimate.interval.is_none()
    );
    let mut intervals = wide.intervals.iter();
    let delta = intervals.find(|made| made.is_delta() && made.level == wide.level);
    let delta = delta.expect("every fit here has a covariance");
    let is_beyond = !(delta.lo..=delta.hi).contains(&truth);
    let is_quoted = estimate.se.is_some();
    Some([is_quoted && is_beyond, is_beyond, estimate.interval.is_some()])
}

#[test]
fn a_quoted_se_holds_near_the_threshold() {
    const SETS: u64 = 600;
    let place = Place::new(&near_threshold());
    let wide = Place::new(&near_threshold().replace("level = 0.95", "level = 0.9973"));
    let sets = study("a_quoted_se_holds_near_the_threshold", SETS, |seed| {
        let [plain, wide] = [&place, &wide].map(|place| place.infer(seed));
        // by the square-root law at each film ratio, and by the energy balance over both
        let mut found: [Vec<[bool; 3]>; 3] = Default::default();
        let own = |row: &&Scaling| row.law == WetLaw::Sqrt && row.film_ratio.is_some();
        for (row, wide) in plain.scaling.iter().filter(own).zip(wide.scaling.iter().filter(own)) {
            let film_ratio = row.film_ratio.expect("filtered");
            let of_film = &mut found[usize::from(film_ratio > 0.06)];
            of_film.extend(judged(&row.estimates[StC], &wide.estimates[StC], truth(film_ratio)));
        }
        for (row, wide) in plain.balance().derived.iter().zip(&wide.balance().derived) {
            found[2].extend(judged(&row.estimates[StC], &wide.estimates[StC], truth(row.film_ratio)));
        }
        found
    });
    for which in 0..3 {
        let found: Vec<[bool; 3]> = sets.iter().flat_map(|found| found[which].clone()).collect();
        let fits = found.len();
        let [beyond, beyond_delta, with_interval] = counts(&found);
        assert!(fits >= 590 && 100 * beyond <= fits, "{which}: {beyond} of {fits}");
        assert!(10 * with_interval >= 9 * fits, "{which}: {with_interval} of {fits}");
        // at the thicker film, where runs are pinned, the delta method's ± alone fails by a wide margin
        let z = binomial_z(beyond_delta, fits, 0.01);
        assert!(which != 1 || z > 8.0, "{z}: {beyond_delta} of {fits}");
    }
}
