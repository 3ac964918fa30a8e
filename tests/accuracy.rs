//! Holds `--accuracy` and `trade` to what they say.

use crate::common::scenes::{design, scene_of, truth, AK10, M50, PTFE};
use crate::common::{self, rows_from, Place, Says};
use rand::RngExt;
use wetcor::findings;
use wetcor::findings::posterior::{fit_posterior, MethodChoice, SamplingSetup};
use wetcor::inference::accuracy::SURE;
use wetcor::inference::diagnostics::summary::Summary;
use wetcor::inference::mixing::summary_of;
use wetcor::inference::nuts::{Effort, SamplingPlan, TARGET_ACCEPT};
use wetcor::inference::prepared_posterior::PreparedPosterior;
use wetcor::inference::sampling::{sample_by_nuts, Method, Sampled};
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::ModelParameters;
use wetcor::runs::{self, Table};
use wetcor::scene::Scene;
use wetcor::seed::{stream, StreamName};
use wetcor::study::trade;

/// Accuracies that are requested.
const REQUESTED: [f64; 4] = [0.3, 0.2, 0.1, 0.05];

/// A long run's Monte Carlo error is at most this share of the accuracy.
const SHARE: f64 = 0.1;

/// Simulated scenes.
const SCENES: u64 = 200;

/// The share of scenes in which an accuracy must be kept.
const KEPT: f64 = 0.95;

/// What came out where an accuracy was asked for, and reached by the method's own word.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Answer {
    /// the method taken
    method: Method,
    /// the true error
    error: f64,
    /// whether every check of the sampling passed
    quotable: bool,
}

/// Simulates so many scenes, asks each accuracy of each, and holds the answers against a long run over every row: each
/// accuracy with the answers to it, and how many scenes are left out, which have no long run.
fn measure(scenes: u64, seed: u64) -> (Vec<(f64, Vec<Answer>)>, usize) {
    // one after the other: the chains of each take every thread, and many long runs at once would fill the memory
    let found: Vec<_> = (0..scenes).filter_map(|index| one(index, seed)).collect();
    let of = |(place, requested): (usize, &f64)| {
        let answers = found.iter().filter_map(|answers| answers[place]);
        (*requested, answers.collect())
    };
    let by_accuracy = REQUESTED.iter().enumerate().map(of).collect();
    (by_accuracy, scenes as usize - found.len())
}

/// Answers whose true error is no larger than a line.
fn within(answers: &[Answer], line: f64) -> Vec<Answer> {
    answers.iter().filter(|answer| answer.error <= line).copied().collect()
}

fn quotable(answers: &[Answer]) -> usize {
    answers.iter().filter(|answer| answer.quotable).count()
}

/// Draws a scene with its runs, and fits it as `wetcor fit --accuracy X` does, for each X; `None` without a long run.
fn one(index: u64, seed: u64) -> Option<Vec<Option<Answer>>> {
    let scene = simulated(index, seed);
    let drawn = rows_from(&scene, stream(seed, "accuracy runs", index));
    let table = Table::of(runs::arrange(&scene, &drawn));
    let form = scene.model.form();
    let parameters = ModelParameters::of(&scene, &table.runs, form).unwrap_or_else(|error| panic!("{error}"));
    let rows = Likelihood::new(&scene, &table.runs, form);
    let truth = long_run(&parameters, &rows, seed, index)?;
    let seed_of_fits = stream(seed, "accuracy fits", index).random();
    let found = findings::fit_least_squares(&scene, &table, seed_of_fits, false);
    let answer = |requested: &f64| {
        let method = MethodChoice::Accuracy(*requested);
        let setup = SamplingSetup { form, method };
        let fitted = fit_posterior(&scene, &table.runs, &found.fits, setup, &|_, _| ());
        let fitted = fitted.unwrap_or_else(|error| panic!("{error}")).ok()?;
        let accuracy = fitted.sampled.accuracy.as_ref()?;
        let answer = || Answer {
            method: fitted.sampled.method,
            error: error(&summaries(&fitted.sampled), &truth),
            quotable: fitted.sampling_holds(),
        };
        (accuracy.vouched? <= accuracy.requested).then(answer)
    };
    Some(REQUESTED.iter().map(answer).collect())
}

/// A long run over every row, whose Monte Carlo error is small beside the finest accuracy; `None` where it does not
/// converge.
fn long_run(parameters: &ModelParameters, rows: &Likelihood, seed: u64, index: u64) -> Option<Vec<Summary>> {
    const FIRST: usize = 10_000;
    const MOST: usize = 200_000;
    let finest = REQUESTED[REQUESTED.len() - 1];
    let prepared = PreparedPosterior::new(parameters.clone(), rows, &vec![]).ok()?;
    let mut draws = FIRST;
    loop {
        let name = format!("accuracy long run {index}");
        let effort = Effort {
            chains: 4,
            warmup: 1000,
            draws,
            target_accept: TARGET_ACCEPT,
        };
        let plan = SamplingPlan::new(effort, StreamName::new(seed, &name));
        let sampled = sample_by_nuts(&prepared, plan, &mut |_| 0).ok()?;
        let found = summaries(&sampled);
        let agreed = found.iter().all(|one| one.rhat.is_some_and(|rhat| rhat < 1.01));
        let mcse = found.iter().map(largest_mcse).fold(0.0, f64::max);
        if agreed && mcse <= SHARE * finest {
            return Some(found);
        }
        // the error falls as the root of the draws
        let wanted = draws as f64 * (1.2 * (mcse / (SHARE * finest)).powi(2)).max(1.5);
        if !agreed || wanted > MOST as f64 {
            return None;
        }
        draws = wanted.ceil() as usize;
    }
}

fn summaries(sampled: &Sampled) -> Vec<Summary> {
    sampled.values.iter().map(|values| summary_of(values)).collect()
}

/// Monte Carlo error of mean or sd, in sds.
fn largest_mcse(found: &Summary) -> f64 {
    match (found.sd, found.mcse_mean, found.mcse_sd) {
        (Some(sd), Some(mean), Some(of_sd)) => mean.max(of_sd) / sd,
        _ => f64::INFINITY,
    }
}

/// Largest error of a mean, in sds, or of an sd, relative.
fn error(found: &[Summary], truth: &[Summary]) -> f64 {
    let of = |(found, truth): (&Summary, &Summary)| match (found.mean, found.sd, truth.mean, truth.sd) {
        (Some(mean), Some(sd), Some(true_mean), Some(true_sd)) => {
            ((mean - true_mean) / true_sd).abs().max((sd / true_sd - 1.0).abs())
        }
        _ => f64::INFINITY,
    };
    found.iter().zip(truth).map(of).fold(0.0, f64::max)
}

/// A scene of its own: its design, its truth and its noise are drawn.
fn simulated(index: u64, seed: u64) -> Scene {
    let mut rng = stream(seed, "accuracy scenes", index);
    let mut between = |lo: f64, hi: f64| lo + (hi - lo) * rng.random::<f64>();
    let k = between(0.1, 0.2);
    let l = between(1.4, 2.6);
    let c = between(0.3, 0.7);
    let sigma = 0.005 * 10f64.powf(between(0.0, 1.0));
    let sigma_dry = 0.005 * 10f64.powf(between(0.0, 0.7));
    let repeats = 2 + (between(0.0, 4.0) as u32);
    let form = ["stepwise", "saturating", "none"][between(0.0, 3.0) as usize];
    let films = ["[0.06]", "[0.03, 0.1]", "[0.02, 0.05, 0.1]"][between(0.0, 3.0) as usize];
    let liquids = ["\"M50\"", "\"AK10\", \"M50\""][between(0.0, 2.0) as usize];
    let text = format!(
        "[model]\ninertia = \"{form}\"\n[truth]\ndry_k = {{ PTFE = {k} }}\n\
         lubrication_log = {l}\ninertia = \"{form}\"\ninertial_prefactor = {c}\nfilm_scale = 0.07\n\
         sigma_dry = {sigma_dry}\nsigma_wet = {sigma}\n[design]\ndiameter_mm = {{ PTFE = [4.762, 8.0] }}\n\
         liquids = [{liquids}]\nfilm_ratio = {{ PTFE = {films} }}\nheight_mm = [30, 60, 100, 150]\n\
         dry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]\nrepeats = {repeats}\n"
    );
    let text = scene_of(&format!("accuracy {index}"), &[PTFE, AK10, M50, &text]);
    common::parsed(&text)
}

/// The table as markdown.
fn markdown(found: &[(f64, Vec<Answer>)], left_out: usize) -> String {
    const METHODS: [Method; 3] = [Method::Laplace, Method::LaplacePsis, Method::Nuts];
    let mut text = String::from("# Is an accuracy that was asked for kept?\n\n");
    text.push_str(&format!(
        "`wetcor fit --accuracy X` on {} simulated scenes, whose design (16 to 240 wet runs of 1 or 2 liquids, 2 diameters, \
         1 to 3 film ratios, 4 heights, 2 to 5 repeats; 16 to 40 dry ones), truth, noise (σ from 0.005 to 0.05) and form of \
         inertia are drawn anew for each. The true error is the largest of any mean, in posterior sds, and of any sd, \
         relative, against trajectories over every row that are followed until their Monte Carlo error is at most {} of \
         the finest X; {} scenes without such a run are left out. X must be kept in {:.0} % of the scenes; z is the \
         distance from that in standard errors. Quotable: of those that kept it, the share whose checks of the sampling \
         (R-hat, effective draws, divergences, energy fraction, weights, nodes, the accuracy itself) all pass.\n\nMade by `UPDATE_EXPECTED=1 cargo test --release --test all -- --ignored the_page_of_accuracy`.\n\n",
        SCENES,
        SHARE,
        left_out,
        100.0 * KEPT
    ));
    let methods = METHODS.map(|method| format!(" `{}` |", method.name())).concat();
    text.push_str(&format!(
        "| X | reached | kept | share / % | z | quotable / % | largest true error |{methods}\n\
         | --- | --- | --- | --- | --- | --- | --- |{}\n",
        " --- |".repeat(METHODS.len())
    ));
    for (requested, answers) in found {
        let kept = within(answers, *requested);
        let taken = METHODS.map(|method| answers.iter().filter(|answer| answer.method == method).count());
        text.push_str(&format!(
            "| {requested} | {} | {} | {:.1} | {:.1} | {:.1} | {:.3} |{}\n",
            answers.len(),
            kept.len(),
            100.0 * kept.len() as f64 / answers.len() as f64,
            common::binomial_z(kept.len(), answers.len(), KEPT),
            100.0 * quotable(&kept) as f64 / kept.len() as f64,
            answers.iter().map(|answer| answer.error).fold(0.0, f64::max),
            taken.map(|count| format!(" {count} |")).concat()
        ));
    }
    text
}

/// Writes `reports/accuracy.md`.
#[test]
#[ignore = "minutes: UPDATE_EXPECTED=1 cargo test --release --test all -- --ignored the_page_of_accuracy"]
fn the_page_of_accuracy() {
    if common::is_update() {
        let (found, left_out) = measure(SCENES, 1);
        common::kept("reports/accuracy.md", &markdown(&found, left_out));
    }
}

/// Every accuracy is kept in its share of scenes; with Monte Carlo errors counted once instead of [`SURE`] times, none
/// would be.
#[test]
#[ignore = "slow: twelve long runs, a sample of what `the_page_of_accuracy` measures"]
fn an_accuracy_is_kept() {
    const SAMPLE: u64 = 12;
    let (found, left_out) = measure(SAMPLE, common::seed_of("an_accuracy_is_kept"));
    // of 200 scenes 5 have no run to hold answers to
    common::assert_seldom("left out", left_out, SAMPLE, 0.05);
    let (mut once, mut all) = (0, 0);
    for (requested, answers) in found {
        let asked = SAMPLE as usize - left_out;
        assert!(answers.len() * 20 >= asked * 19, "{requested}: {}", answers.len());
        let kept = within(&answers, requested);
        for (part, of) in [(kept.len(), answers.len()), (quotable(&kept), kept.len())] {
            let z = common::binomial_z(part, of, KEPT);
            assert!(z > -4.0, "{requested}: {part} of {of}: {z}");
        }
        once += within(&answers, requested / SURE).len();
        all += answers.len();
    }
    let z = common::binomial_z(once, all, KEPT);
    assert!(z < -6.0, "{once} of {all}: {z}");
}

fn scene_text() -> String {
    let sampler = "[sampler]\ndraws = 500\n";
    let heights = "30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150";
    let [sizes, speeds] = [["4.762, 8.0", "0.03, 0.08"], [heights, "0.5, 1.0, 1.5, 2.0"]];
    let design = design(sizes, &["M50"], speeds, "repeats = 3\n");
    let truth = truth([1.85, 0.5, 0.009, 0.02], "");
    scene_of("trade", &[PTFE, M50, sampler, &truth, &design])
}

#[test]
fn each_method_is_as_far_off_as_its_draws_explain() {
    let place = Place::new(&scene_text());
    let table = place.draw(common::seed_of("each_way_is_as_far_off"), None);
    let found = trade::measure(&place.scene, &table, 1, &|| ()).unwrap_or_else(|error| panic!("{error}"));
    let reference = &found.reference;
    assert!(reference.mcse_mean < 0.01 && reference.rhat < 1.01, "{reference:?}");
    let names: Vec<&str> = found.methods.iter().map(|method| method.name).collect();
    assert_eq!(names, ["linear", "sqrt", "laplace", "laplace_psis", "nuts"]);
    let [linear, sqrt, laplace, by_weights, nuts] = &found.methods[..] else {
        panic!("five methods");
    };
    for method in [by_weights, nuts] {
        let (name, off) = (method.name, method.error().expect("every parameter"));
        let vouched = method.vouched.expect("its own check");
        // 4.5 in place of the 3.3 Monte Carlo errors it counts
        let most = 1.4 * vouched + 4.5 * reference.mcse_sd;
        assert!(off < most, "{name}: {off} {vouched}");
        assert_eq!(method.failed, None, "{name}");
    }
    assert!(laplace.worst_mean < laplace.vouched, "{laplace:?}");
    // each law gives k, L, C and both spreads here; the straight line misses L by far
    assert_eq!(reference.parameters[1].name, "lubrication_log");
    let [linear, sqrt] = [linear, sqrt].map(|law| law.errors[1].expect("L").mean.abs());
    assert!(linear > 5.0 && sqrt < linear, "{linear} {sqrt}");
}

#[test]
fn an_accuracy_that_is_asked_for_is_vouched_for() {
    let place = Place::new(&scene_text());
    place.draw(common::seed_of("the_commands_take_an_accuracy"), None);
    let (status, _, err) = place.run("fit scene.toml --stages least_squares,posterior --accuracy 0.1 --out out");
    assert!(matches!(status, Some(0 | 1)), "{err}");
    let posterior = &place.folder.json("out/findings.json")["posterior"];
    assert_eq!(posterior["accuracy"]["asked"], 0.1);
    assert!(posterior["accuracy"]["vouched"].as_f64().expect("a number") <= 0.1);
    for parameter in posterior["parameters"].as_array().expect("a list") {
        let number = |key: &str| parameter[key].as_f64().expect("a number");
        let largest = number("mcse_mean").max(number("mcse_sd"));
        assert!(SURE * largest <= 0.1 * number("sd"), "{parameter}");
    }
    let report = place.folder.read("out/report.md");
    report.says("An accuracy of 0.1 was asked for");
    report.says(posterior["method"].as_str().expect("a word"));
}
