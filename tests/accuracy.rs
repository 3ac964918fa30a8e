//! Holds `--accuracy` and `trade` to what they say.

mod common;

use std::path::Path;
use std::process::Command;

use common::Place;
use wetcor::inference::accuracy::SURE;
use wetcor::inference::mixing::MixingLines;
use wetcor::ranks::Ranks;
use wetcor::study::accuracy::SimulatedRuns;
use wetcor::study::{accuracy, trade};

/// Every accuracy is kept in its share of scenes; with Monte Carlo errors counted once instead of [`SURE`] times, none
/// would be.
#[test]
#[ignore = "slow: twenty-five long runs, a sample of what `wetcor calibrate` measures"]
fn an_accuracy_is_kept() {
    let seed = common::seed_of("an_accuracy_is_kept");
    let table = accuracy::measure(accuracy::SCENES / 8, seed, &Ranks::alone(), &|| ())
        .unwrap_or_else(|error| panic!("{error}"));
    print!("{}", accuracy::markdown(&table));
    // of 200 scenes 5 have no run to hold answers to
    let left_out = common::binomial_z(table.left_out as usize, table.scenes as usize, 0.05);
    assert!(left_out < 4.0, "{} of {}", table.left_out, table.scenes);
    for promise in &table.promises {
        let reached = promise.answers.len() as u64;
        assert!(reached * 20 >= (table.scenes - table.left_out) * 19, "{reached}");
        assert!(
            promise.z(promise.requested) > -4.0,
            "{}: {}",
            promise.requested,
            promise.z(promise.requested)
        );
        let kept = promise.within(promise.requested);
        let quotable = common::binomial_z(promise.quotable_where_kept(), kept, accuracy::KEPT);
        assert!(quotable > -4.0, "{}: {quotable}", promise.requested);
    }
    let once = |promise: &accuracy::Promise| promise.within(promise.requested / SURE);
    let once: usize = table.promises.iter().map(once).sum();
    let all: usize = table.promises.iter().map(|promise| promise.answers.len()).sum();
    let z = common::binomial_z(once, all, accuracy::KEPT);
    assert!(z < -6.0, "{once} of {all}: {z}");
}

/// What vouches for an accuracy passes its own checks; the lines of sampling without one would refuse most of a coarse one.
#[test]
#[ignore = "slow: sixty posteriors"]
fn an_accuracy_that_is_vouched_for_may_be_quoted() {
    const SCENES: u64 = 20;
    let seed = common::seed_of("an_accuracy_that_is_vouched_for_may_be_quoted");
    let requested = [0.3, 0.1, 0.05];
    let mut reached = [0; 3];
    let (mut quotable, mut by_the_usual_lines) = ([0; 3], [0; 3]);
    for index in 0..SCENES {
        let runs = SimulatedRuns::new(index, seed).unwrap_or_else(|error| panic!("{error}"));
        let fits = runs.fit(&requested).unwrap_or_else(|error| panic!("{error}"));
        for (place, fitted) in fits.iter().enumerate() {
            let Some(fitted) = fitted else { continue };
            let sampled = &fitted.sampled;
            reached[place] += 1;
            quotable[place] += usize::from(fitted.sampling_holds());
            let usual = MixingLines::of_chains(sampled.chains.len());
            by_the_usual_lines[place] += usize::from(usual.hold(&sampled.values, sampled.mcse_factor));
        }
    }
    println!("{reached:?} {quotable:?} {by_the_usual_lines:?}");
    for place in 0..requested.len() {
        assert!(reached[place] * 20 >= SCENES as usize * 19, "{reached:?}");
        let z = common::binomial_z(quotable[place], reached[place], accuracy::KEPT);
        assert!(z > -4.0, "{}: {quotable:?} of {reached:?}", requested[place]);
    }
    let z = common::binomial_z(by_the_usual_lines[0], reached[0], accuracy::KEPT);
    assert!(z < -6.0, "{by_the_usual_lines:?} of {reached:?}");
}

const SCENE: &str = "title = \"trade\"
[data]
runs = \"runs.csv\"
[particles.PTFE]
density_kg_m3 = 2150
roughness_um = 5
[liquids.M50]
density_kg_m3 = 965
viscosity_mPa_s = 48.3
[sampler]
draws = 500
[truth]
dry_k = { PTFE = 0.183 }
lubrication_log = 1.85
inertia = \"stepwise\"
inertial_prefactor = 0.5
sigma_dry = 0.009
sigma_wet = 0.02
[design]
diameter_mm = { PTFE = [4.762, 8.0] }
liquids = [\"M50\"]
film_ratio = { PTFE = [0.03, 0.08] }
height_mm = [30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150]
dry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]
repeats = 3
";

#[test]
fn each_way_is_as_far_off_as_its_draws_explain() {
    let place = Place::new(SCENE);
    let table = place.draw(common::seed_of("each_way_is_as_far_off"), None);
    let found = trade::measure(&place.scene, &table, 1, &|| ()).unwrap_or_else(|error| panic!("{error}"));
    assert!(
        found.reference.mcse_mean < 0.01 && found.reference.rhat < 1.01,
        "{:?}",
        found.reference
    );
    let rung = |name: &str| {
        let of_name = found.rungs.iter().find(|rung| rung.name == name);
        of_name.unwrap_or_else(|| panic!("no way named {name}"))
    };
    for name in ["laplace_psis", "nuts_compressed", "nuts_exact"] {
        let rung = rung(name);
        let off = rung.worst_mean.expect("draws").max(rung.worst_sd.expect("draws"));
        let vouched = rung.vouched.expect("its own check");
        // 4.5 in place of the 3.3 Monte Carlo errors it counts
        assert!(
            off < 1.4 * vouched + 4.5 * found.reference.mcse_sd,
            "{name}: {off} {vouched}"
        );
        assert_eq!(rung.failed, None, "{name}");
    }
    let laplace = rung("laplace");
    assert!(laplace.worst_mean < laplace.vouched, "{laplace:?}");
    // each law gives k, L, C and both spreads here; the straight line misses L by far
    let of_law = |name: &str| rung(name).errors[1].expect("L").mean.abs();
    assert_eq!(found.reference.parameters[1].name, "lubrication_log");
    assert!(
        of_law("linear") > 5.0 && of_law("sqrt") < of_law("linear"),
        "{} {}",
        of_law("linear"),
        of_law("sqrt")
    );
    assert!(found.linear_bias.iter().all(|bias| bias.st_c > 0.0) && !found.linear_bias.is_empty());
    // of the 26 settings of a film 4 or 16 nodes are made, and all are kept where an error is asked for
    let nodes = ["nuts_compressed/4", "nuts_compressed/16", "nuts_compressed"].map(|name| rung(name).nodes);
    assert!(nodes[0] < nodes[1] && nodes[1] < nodes[2], "{nodes:?}");
    assert_eq!(nodes[2], Some(52));
}

#[test]
fn the_commands_take_an_accuracy_and_write_a_trade() {
    let place = Place::new(SCENE);
    place.draw(common::seed_of("the_commands_take_an_accuracy"), None);
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_wetcor"))
            .current_dir(place.folder.path())
            .args(arguments)
            .output()
            .expect("the command can be started");
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    let read = |path: &str| -> serde_json::Value {
        let text = std::fs::read_to_string(place.path(path)).expect("just written");
        serde_json::from_str(&text).expect("JSON")
    };
    let stages = "least_squares,posterior";
    let (status, err) = run(&[
        "fit",
        "scene.toml",
        "--stages",
        stages,
        "--accuracy",
        "0.1",
        "--out",
        "out",
    ]);
    assert!(matches!(status, Some(0 | 1)), "{err}");
    let findings = read("out/findings.json");
    let posterior = &findings["posterior"];
    assert_eq!(posterior["accuracy"]["asked"], 0.1);
    assert!(posterior["accuracy"]["vouched"].as_f64().expect("a number") <= 0.1);
    for parameter in posterior["parameters"].as_array().expect("a list") {
        let number = |key: &str| parameter[key].as_f64().expect("a number");
        assert!(SURE * number("mcse_mean") <= 0.1 * number("sd"), "{parameter}");
        assert!(SURE * number("mcse_sd") <= 0.1 * number("sd"), "{parameter}");
    }
    let method = posterior["method"].as_str().expect("a word");
    let report = std::fs::read_to_string(place.path("out/report.md")).expect("just written");
    assert!(report.contains("An accuracy of 0.1 was asked for") && report.contains(method));
    for (x, word) in [("0.001", "0.005"), ("nan", "0.005"), ("few", "0.005")] {
        let (status, err) = run(&["fit", "scene.toml", "--accuracy", x, "--out", "never"]);
        assert!(status == Some(2) && err.contains(word), "{err}");
    }
    let (status, _) = run(&[
        "fit",
        "scene.toml",
        "--accuracy",
        "0.1",
        "--exact-rows",
        "--out",
        "never",
    ]);
    assert_eq!(status, Some(2));

    let (status, err) = run(&["trade", "scene.toml", "--out", "traded"]);
    assert_eq!(status, Some(0), "{err}");
    assert_eq!(read("traded/trade.json")["schema"], trade::SCHEMA);
    for file in ["trade.md", "trade.svg"] {
        assert!(place.path("traded").join(file).exists());
    }
    // a fit's folder is not a trade's to replace
    let (status, err) = run(&["trade", "scene.toml", "--out", "out"]);
    assert!(status == Some(2) && err.contains("trade.json"), "{err}");
    assert!(!Path::new(&place.path("never")).exists());
}
