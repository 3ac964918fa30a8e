//! Holds the posterior of small scenes against an independent answer by importance sampling.
//!
//! `tests/data/posterior/reference.py` states the model anew in NumPy; its output lies beside it.

use crate::common;
use crate::common::assembled::{Assembled, Fault};
use crate::posterior::draws_of;
use serde_json::Value;
use wetcor::findings::posterior::derived;
use wetcor::inference::diagnostics::summary::{summarise, Summary};
use wetcor::inference::nuts::{Effort, SamplingPlan, TARGET_ACCEPT};
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::{ModelParameters, ParameterKind};
use wetcor::runs::{self, Table};
use wetcor::scene::{self, Prior, Scene};
use wetcor::seed::StreamName;

/// Monte Carlo standard errors, of both answers together, that an agreement may miss by.
const WITHIN: f64 = 4.5;

const EFFORT: Effort = Effort {
    chains: 4,
    warmup: 1000,
    draws: 5000,
    target_accept: TARGET_ACCEPT,
};

fn reference() -> Value {
    serde_json::from_str(&common::read_in_project("tests/data/posterior/reference.json")).expect("JSON")
}

fn read(name: &str) -> (Scene, Table) {
    let path = common::in_project(&format!("tests/data/posterior/{name}/scene.toml"));
    let scene = scene::read(&path).unwrap_or_else(|e| panic!("{e}"));
    let table = runs::read(&scene).unwrap_or_else(|e| panic!("{e}"));
    (scene, table)
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Largest distance of mean, sd, 5 %, 50 % and 95 % points from the reference, in Monte Carlo standard errors.
fn distance(answer: &Value, ours: &Summary, chains: &[&[f64]]) -> (f64, &'static str) {
    let mcse = wetcor::inference::diagnostics::mcse::of_quantile;
    let median = mcse(chains, 0.5);
    let found = [
        ("mean", ours.mean, ours.mcse_mean),
        ("sd", ours.sd, ours.mcse_sd),
        ("q05", ours.q05, ours.mcse_q05),
        ("median", ours.median, median),
        ("q95", ours.q95, ours.mcse_q95),
    ];
    // moments that need not exist are not in the reference
    let found = found.into_iter().filter(|(name, ..)| !answer[*name].is_null());
    let distances = found.map(|(name, value, mcse)| {
        let of = &answer[name];
        let error = mcse.expect("mixed").hypot(number(&of["mcse"]));
        ((value.expect("finite") - number(&of["value"])).abs() / error, name)
    });
    distances
        .into_iter()
        .fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a })
}

fn scenes(reference: &Value) -> Vec<String> {
    reference["scenes"]
        .as_object()
        .expect("scenes by name")
        .keys()
        .cloned()
        .collect()
}

#[test]
#[ignore = "slow: run with --ignored"]
fn moments_and_quantiles_agree_with_importance_sampling() {
    let reference = reference();
    for name in scenes(&reference) {
        let answers = &reference["scenes"][&name];
        let (scene, table) = read(&name);
        let form = scene.model.form();
        let seed = common::seed_of("moments_and_quantiles_agree_with_importance_sampling");
        let (_, sampled) = common::sampled(&scene, &table, EFFORT, StreamName::new(seed, &name));
        let told = answers["parameters"].as_object().expect("parameters by name");
        assert_eq!(told.len(), sampled.parameters.sampled.len(), "{name}");
        let derived = derived::derived_draws(&scene, &table.runs, form, &sampled);
        let parameters = sampled.parameters.sampled.iter().zip(&sampled.values);
        let quantities = parameters
            .map(|(parameter, values)| (parameter.name.as_str(), values, &answers["parameters"]))
            .chain(
                derived
                    .iter()
                    .map(|d| (d.name.as_str(), &d.values, &answers["derived"])),
            );
        let mut compared = 0;
        for (quantity, values, of) in quantities {
            let answer = &of[quantity];
            // δc in metres is δc/ε in another unit; where no draw will ever be without the quantity it is defined
            if answer.is_null() || number(&answer["undefined_share"]) > 1e-6 {
                continue;
            }
            compared += 1;
            let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            let ours = summarise(&chains);
            assert!(ours.ess_bulk.expect("mixed") > 400.0, "{name} {quantity}");
            let (far, what) = distance(answer, &ours, &chains);
            assert!(
                far < WITHIN,
                "{name}: {what} of {quantity} is {far} Monte Carlo errors off"
            );
        }
        assert!(compared > told.len(), "{name}: {compared}");
    }
}

/// Each fault on the scene where it shows: the sampler is the same, so only the fault can tell.
#[test]
#[ignore = "slow: run with --ignored"]
fn planted_faults_move_the_moments() {
    let reference = reference();
    for (fault, name) in [
        (Fault::LogJacobianForgotten, "few"),
        (Fault::BoundOnKForgotten, "bound"),
        (Fault::SigmaSquaredForSigma, "few"),
        (Fault::PriorForgotten(ParameterKind::INERTIAL_PREFACTOR), "weak"),
        (Fault::TwoLForFourL, "stepwise"),
        (Fault::StuckRunsDropped, "stepwise_stuck"),
    ] {
        let (scene, table) = read(name);
        let far = |fault: Fault| {
            let target = Assembled::new(&scene, &table.runs, fault);
            let stream = StreamName::new(common::seed_of("planted_faults_move_the_moments"), name);
            let drawn = draws_of(&target, SamplingPlan::new(EFFORT, stream));
            let mut worst = (0.0, String::new());
            for (parameter, chains) in target.parameters.sampled.iter().zip(&drawn) {
                let chains: Vec<&[f64]> = chains.iter().map(Vec::as_slice).collect();
                let answer = &reference["scenes"][name]["parameters"][&parameter.name];
                let (far, what) = distance(answer, &summarise(&chains), &chains);
                if far > worst.0 {
                    worst = (far, format!("{what} of {}", parameter.name));
                }
            }
            worst
        };
        let (right, wrong) = (far(Fault::Nothing), far(fault));
        assert!(right.0 < WITHIN, "{name}: {right:?}");
        assert!(wrong.0 > 3.0 * WITHIN, "{fault:?} on {name}: {wrong:?}");
    }
}

#[test]
fn densities_and_slopes_are_the_references() {
    let reference = reference();
    for name in scenes(&reference) {
        let (scene, table) = read(&name);
        let form = scene.model.form();
        let parameters = ModelParameters::of(&scene, &table.runs, form).unwrap_or_else(|e| panic!("{e}"));
        let rows = Likelihood::new(&scene, &table.runs, form);
        let points = reference["scenes"][&name]["densities"]
            .as_array()
            .expect("points")
            .clone();
        assert!(points.len() >= 5);
        for point in points {
            let draw = parameters.sampled.iter();
            let draw: Vec<f64> = draw.map(|p| number(&point["at"][&p.name])).collect();
            let mut slopes = vec![0.0; parameters.template.len()];
            let value = rows
                .ln_density(&parameters.full(&draw), &mut slopes)
                .expect("a density");
            let close = |what: &str, ours: f64, theirs: f64, scale: f64| {
                assert!(
                    (ours - theirs).abs() <= 1e-10 * scale.max(1.0),
                    "{name} {what}: {ours} {theirs}"
                );
            };
            let expected = number(&point["log_likelihood"]);
            close("log likelihood", value, expected, expected.abs());
            let of_prior = parameters
                .sampled
                .iter()
                .zip(&draw)
                .map(|(own, x)| own.prior.ln_density(*x));
            let ln_prior: f64 = of_prior.map(|of| of.expect("inside").0).sum();
            close("log prior", ln_prior, number(&point["log_prior"]), ln_prior.abs());
            for (parameter, x) in parameters.sampled.iter().zip(&draw) {
                let theirs = number(&point["gradient_log_likelihood"][&parameter.name]);
                // terms as large as the curvature times the value cancel in a slope
                close(
                    &parameter.name,
                    slopes[parameter.kind.slot()],
                    theirs,
                    theirs.abs() + value.abs() / x,
                );
                let (_, slope) = parameter.prior.ln_density(*x).expect("inside");
                let theirs = number(&point["gradient_log_prior"][&parameter.name]);
                close(&parameter.name, slope, theirs, theirs.abs());
            }
        }
    }
}

#[test]
fn the_priors_are_the_references() {
    let reference = reference();
    for row in reference["priors"].as_array().expect("rows") {
        let args: Vec<f64> = match &row["args"] {
            Value::Array(args) => args.iter().map(number).collect(),
            one => vec![number(one)],
        };
        let prior = match (row["family"].as_str().expect("a name"), args.as_slice()) {
            ("lognormal", &[median, sd]) => Prior::LogNormal(median, sd),
            ("half_normal", &[scale]) => Prior::HalfNormal(scale),
            ("normal", &[mean, sd]) => Prior::Normal(mean, sd),
            ("gamma", &[shape, rate]) => Prior::Gamma(shape, rate),
            ("uniform", &[lo, hi]) => Prior::Uniform(lo, hi),
            ("student_t", &[df, loc, scale]) => Prior::StudentT(df, loc, scale),
            other => panic!("{other:?}"),
        };
        let (value, slope) = prior.ln_density(number(&row["x"])).expect("inside the support");
        let (theirs, their_slope) = (number(&row["log_density"]), number(&row["slope"]));
        assert!((value - theirs).abs() < 1e-12 * theirs.abs().max(1.0), "{row} {value}");
        assert!(
            (slope - their_slope).abs() < 1e-12 * their_slope.abs().max(1.0),
            "{row} {slope}"
        );
    }
}
