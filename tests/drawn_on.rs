//! Holds that right scenes of few runs are seldom refused for their sampling, and that sampling which fails says so.

use crate::common::scenes::{design, scene_of, truth, M50, PTFE, STEPWISE};
use crate::common::{self, seed_of, Place};
use wetcor::findings;
use wetcor::findings::posterior::{fit_posterior, MethodChoice, SamplingSetup};
use wetcor::inference::mixing::MixingLines;
use wetcor::runs::Table;
use wetcor::scene::Scene;
use wetcor::seed::stream;

/// Three heights, three repeats, two film ratios of one liquid, nine dry runs; 18 % of the wet runs stick.
fn poor() -> String {
    let truth = truth([1.85, 0.5, 0.01, 0.02], "");
    let speeds = ["15, 60, 150", "0.7, 1.2, 1.7"];
    let design = design(["4.762", "0.03, 0.08"], &["M50"], speeds, "repeats = 3\n");
    scene_of("poor", &[PTFE, M50, STEPWISE, &truth, &design])
}

/// Whether the sampling of one simulated set fails, as `wetcor fit` samples it, and by a quarter of the draws asked for.
fn fail(scene: &Scene, seed: u64) -> [bool; 2] {
    let runs = wetcor::runs::arrange(scene, &common::rows_from(scene, stream(seed, "poor runs", 0)));
    let table = Table::of(runs);
    let found = findings::fit_least_squares(scene, &table, seed, false);
    let setup = SamplingSetup {
        form: found.form,
        method: MethodChoice::Sampler,
    };
    let fitted = fit_posterior(scene, &table.runs, &found.fits, setup, &|_, _| ())
        .unwrap_or_else(|error| panic!("{error}"))
        .unwrap_or_else(|refused| panic!("{}", refused.text));
    let asked = fitted.findings.draws_asked.expect("no accuracy was asked for");
    let mut quarter = fitted.sampled.values.clone();
    quarter.iter_mut().flatten().for_each(|chain| chain.truncate(asked / 4));
    let lines = MixingLines::of_chains(quarter[0].len());
    [!fitted.sampling_holds(), !lines.hold(&quarter, 1.0)]
}

/// At most one in a hundred is allowed to fail, at four standard deviations; with a quarter of the draws more do.
#[test]
#[ignore = "slow: a hundred and fifty posteriors"]
fn right_scenes_of_a_poor_design_seldom_fail_by_their_sampling() {
    const SETS: u64 = 150;
    let place = Place::new(&poor());
    let seed = seed_of("right_scenes_of_a_poor_design_seldom_fail_by_their_sampling");
    let found = Vec::from_iter((0..SETS).map(|set| fail(&place.scene, seed.wrapping_add(set))));
    let [fitted, by_a_quarter] = common::counts(&found);
    common::assert_seldom("fail", fitted, SETS, 0.01);
    let z = common::binomial_z(by_a_quarter, found.len(), 0.01);
    assert!(z > 6.0, "{by_a_quarter} of {SETS}");
}
