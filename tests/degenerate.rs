//! Holds that runs which determine nothing end in a verdict, a notice and a reason, never in an invented ±: by least squares,
//! and where they leave a posterior without ground.

use crate::common::scenes::{scene_of, AK10, HEADER, PE, PTFE};
use crate::common::{self, Place, Says, Told};
use wetcor::findings::estimate::{Estimate, QuantityEstimates};
use wetcor::findings::posterior::Posterior;
use wetcor::findings::{self, Findings};
use wetcor::physics::Quantity::{Alpha, Beta, StC, ThresholdSpeed};

/// Speeds and restitutions.
type Pairs<'p> = &'p [(f64, f64)];

pub fn pairs(speeds: [f64; 6], restitutions: [f64; 6]) -> Vec<(f64, f64)> {
    speeds.into_iter().zip(restitutions).collect()
}

fn dry() -> Vec<(f64, f64)> {
    pairs([0.5, 1.0, 1.5, 2.0, 2.0, 0.8], [0.841, 0.818, 0.80, 0.79, 0.788, 0.83])
}

fn wet() -> Vec<(f64, f64)> {
    pairs([0.8, 1.0, 1.2, 1.4, 1.6, 1.8], [0.55, 0.60, 0.61, 0.65, 0.64, 0.67])
}

/// Rows of PTFE: dry ones, and wet ones of one film.
fn rows(dry: Pairs, wet: Pairs) -> String {
    let of = |start: &'static str| move |(v, e): &(f64, f64)| format!("PTFE,{start},{v},{e}\n");
    let (dry, wet) = (dry.iter().map(of("dry,4.762,")), wet.iter().map(of("AK10,4.762,286")));
    dry.chain(wet).collect()
}

/// Fits wet runs of one series beside some dry runs.
pub fn fit(wet: Pairs) -> Findings {
    Place::new(&scene_of("degenerate", &[PTFE, AK10])).fit_rows(&(HEADER.to_owned() + &rows(&dry()[..5], wet)))
}

/// Every estimate of the wet runs.
pub fn estimates(findings: &Findings) -> Vec<&Estimate> {
    let series = findings.series.iter().map(|fit| &fit.estimates);
    let laws = findings.scaling.iter().map(|law| &law.estimates);
    let each = series.chain(laws).flat_map(QuantityEstimates::iter);
    each.map(|(_, estimate)| estimate).collect()
}

/// A reason stands exactly where an uncertainty is missing; nothing is infinite, and no ± is zero.
fn assert_honest(findings: &Findings) {
    estimates(findings).into_iter().for_each(assert_estimate_is_honest);
}

pub fn assert_estimate_is_honest(estimate: &Estimate) {
    let complete = estimate.se.is_some() && estimate.interval.is_some();
    assert_eq!(estimate.why_none.is_none(), complete, "{estimate:?}");
    let interval = estimate.interval.iter().flatten();
    let mut numbers = estimate.value.iter().chain(&estimate.se).chain(interval);
    assert!(numbers.all(|x| x.is_finite()), "{estimate:?}");
    assert!(estimate.se.is_none_or(|se| se > 0.0), "{estimate:?}");
    assert!(estimate.why_none.as_deref() != Some(""), "{estimate:?}");
}

fn assert_no_uncertainty(findings: &Findings, stop: &str, words: &str) {
    assert_honest(findings);
    let series = &findings.series[0];
    assert_eq!(series.stop, stop);
    assert!(!series.verdict.passed, "{:?}", series.verdict);
    series.verdict.reason.says(words);
    for estimate in estimates(findings) {
        assert!(estimate.se.is_none(), "{estimate:?}");
    }
}

#[test]
fn runs_that_determine_no_law_have_no_uncertainty() {
    let of_one_speed = [0.70, 0.71, 0.69, 0.705].map(|e| (1.0, e));
    assert_no_uncertainty(&fit(&of_one_speed), "degenerate", "cannot tell the parameters apart");
    for wet in [&[(0.8, 0.66)][..], &[(0.8, 0.0), (1.0, 0.0)]] {
        assert_no_uncertainty(&fit(wet), "degenerate", "cannot determine");
    }
    // the law through two runs is known, only its uncertainty is not
    let two = fit(&[(0.8, 0.66), (1.6, 0.70)]);
    assert_no_uncertainty(&two, "converged", "as many parameters as runs");
    assert!(two.series[0].estimates[Alpha].value.is_some());
}

#[test]
fn laws_without_scatter_or_threshold_say_why() {
    let equal = fit(&[0.8, 1.0, 1.2, 1.6].map(|v| (v, 0.7)));
    assert!(estimates(&equal).iter().all(|estimate| estimate.se.is_none()));
    let restitutions = [0.74, 0.733, 0.73, 0.722, 0.712, 0.711];
    let rising = fit(&pairs([0.8, 0.9, 1.0, 1.2, 1.4, 1.6], restitutions));
    for findings in [&equal, &rising] {
        assert_honest(findings);
        let series = &findings.series[0];
        assert!(!series.verdict.passed, "{:?}", series.verdict);
        let threshold = &series.estimates[ThresholdSpeed];
        assert!(threshold.value.is_none() && threshold.why_none.is_some());
    }
    let series = &rising.series[0];
    assert_eq!(series.stop, "converged");
    series.verdict.reason.says("does not fall");
    assert!(series.estimates[Beta].value.is_some_and(|beta| beta > 0.0) && series.estimates[Beta].se.is_some());
    let why = &series.estimates[ThresholdSpeed].why_none;
    why.as_ref().expect("a reason").says("β");
    for row in &rising.scaling {
        assert!(row.estimates[StC].value.is_none() && !row.verdict.passed, "{row:?}");
    }
}

const SAMPLER: &str = "chains = 4\nwarmup = 500\ndraws = 500\n";

fn sampled_text() -> String {
    scene_of("degenerate", &[PTFE, PE, AK10]) + "[sampler]\n" + SAMPLER
}

fn sample(rows: &str) -> (Findings, Option<Posterior>) {
    sample_scene(&sampled_text(), rows)
}

fn sample_scene(scene: &str, rows: &str) -> (Findings, Option<Posterior>) {
    let place = Place::new(scene);
    let csv = format!("{HEADER}{rows}");
    let table = place.read_rows(&csv);
    let mut findings = findings::fit_least_squares(&place.scene, &table, 1, false);
    let posterior = common::sample(&mut findings, &place.scene, &table.runs);
    assert_posterior_is_honest(&findings);
    (findings, posterior)
}

/// What a posterior tells is finite, or is missing with its reason.
pub fn assert_posterior_is_honest(findings: &Findings) {
    let Some(posterior) = &findings.posterior else {
        return;
    };
    for quantity in posterior.parameters.iter().chain(&posterior.derived) {
        let places = [quantity.mean, quantity.median, quantity.q05, quantity.q95];
        let of_draws = [quantity.rhat, quantity.ess_bulk, quantity.ess_tail];
        let numbers = [&places[..], &of_draws, &[quantity.sd, quantity.mcse_mean]].concat();
        assert!(numbers.iter().flatten().all(|x| x.is_finite()), "{quantity:?}");
        let complete = numbers.iter().all(Option::is_some);
        assert_eq!(complete, quantity.why_none.is_none(), "{quantity:?}");
    }
}

fn names(findings: &Findings) -> Vec<&str> {
    let posterior = findings.posterior.as_ref().expect("sampled");
    posterior.parameters.iter().map(|q| q.name.as_str()).collect()
}

/// The gating checks that failed.
fn failed(findings: &Findings) -> Vec<&str> {
    let checks = findings.checks().filter(|check| check.gates() && !check.passed);
    checks.map(|check| check.code).collect()
}

#[test]
fn no_wet_runs_leave_the_wet_parameters_out() {
    let (findings, posterior) = sample(&rows(&dry(), &[]));
    assert!(posterior.is_some() && findings.posterior.as_ref().is_some_and(|p| p.derived.is_empty()));
    assert_eq!(names(&findings), ["dry_k[PTFE]", "sigma_dry"]);
    let left = findings.posterior.iter().flat_map(|p| &p.left_out);
    let left: Vec<&str> = left.map(|left| left.name.as_str()).collect();
    left.join(" ")
        .reads("dry_k[PE] lubrication_log inertial_prefactor sigma_wet");
    assert_eq!(failed(&findings), [""; 0]);
}

#[test]
#[ignore = "slow: run with --ignored"]
fn one_film_ratio_without_dry_runs_keeps_the_priors_of_k_and_the_prefactor() {
    let (findings, _) = sample(&rows(&[], &wet()));
    let expected = "dry_k[PTFE] lubrication_log inertial_prefactor sigma_wet";
    names(&findings).join(" ").reads(expected);
    let led = findings.main.parameters.iter();
    let led: Vec<(String, bool)> = led.map(|own| (own.name(), own.prior_led)).collect();
    assert!(led.contains(&("inertial_prefactor".to_owned(), true)), "{led:?}");
    findings.notice("prior_rules").expect("told").text.says(" C (");
}

/// Bounds alone mix slowly, and a few draws show what keeps its prior.
#[test]
#[ignore = "slow: run with --ignored"]
fn wet_runs_that_all_stuck_bound_the_parameters_and_without_dry_ones_are_not_sampled() {
    let stuck = Vec::from_iter(wet().into_iter().map(|(v, _)| (v, 0.0)));
    let (findings, posterior) = sample(&rows(&[], &stuck));
    assert!(posterior.is_none() && findings.forbids("rebounds"));
    let short = sampled_text().replace(SAMPLER, "chains = 2\nwarmup = 100\ndraws = 25\n");
    let (findings, posterior) = sample_scene(&short, &rows(&dry(), &stuck));
    assert!(posterior.is_some());
    findings.notice("prior_rules").expect("told").text.says("σ_wet");
}

#[test]
fn every_prior_fixed_leaves_nothing_to_sample() {
    let fixed = "[priors]\ndry_k = { fixed = 0.18 }\nlubrication_log = { fixed = 2 }\ninertial_prefactor = { fixed = 0 }\nsigma_dry = { fixed = 0.01 }\nsigma_wet = { fixed = 0.02 }\n";
    let (findings, posterior) = sample_scene(&format!("{}{fixed}", sampled_text()), &rows(&dry(), &wet()));
    assert!(posterior.is_none());
    // least squares, which knows no prior, finds an L here whose δc is thicker than the film
    assert_eq!(failed(&findings), ["plausible_result", "posterior"]);
}

#[test]
fn too_few_draws_fail_by_name() {
    let of = |sampler: &str| {
        let short = sampled_text().replace(SAMPLER, sampler);
        sample_scene(&short, &rows(&dry(), &wet())).0
    };
    let findings = of("chains = 2\nwarmup = 20\ndraws = 5\n");
    assert!(findings.forbids("ess_bulk"), "{:?}", failed(&findings));
    assert!(!findings.main.verdict.passed);
    let check = findings.check("ess_bulk");
    check.text.says("after 40 draws a chain in place of 5");
    check.next_step.says("raise draws and warmup in [sampler]");
    // fewer than diagnostics need
    assert!(of("chains = 1\nwarmup = 1\ndraws = 1\n").forbids("rhat"));
}

#[test]
fn a_wet_law_that_does_not_fit_leaks_into_k_and_is_caught() {
    // restitutions no film could leave: wet runs faster than dry ones
    let wet = (0..60).map(|i| (0.8 + 0.02 * f64::from(i), 0.93 + 0.005 * f64::from(i % 3)));
    let wet: Vec<(f64, f64)> = wet.collect();
    let (findings, _) = sample(&rows(&dry(), &wet));
    assert!(findings.forbids("dry_consistency"), "{:?}", failed(&findings));
}
