//! Holds that runs which determine nothing end in a verdict, a notice and a reason, never in an invented ±: by least squares,
//! and where they leave a posterior without ground.

use crate::common::scenes::{scene_of, AK10, HEADER, PE, PTFE};
use crate::common::{self, Place, Says, Told};
use wetcor::findings::estimate::{Estimate, QuantityEstimates};
use wetcor::findings::posterior::Posterior;
use wetcor::findings::verdicts::quotable;
use wetcor::findings::{self, Findings};
use wetcor::physics::Quantity::{Alpha, Beta, StC, ThresholdSpeed};

fn scene_text() -> String {
    scene_of("degenerate", &[PTFE, AK10])
}

const DRY: [(f64, f64); 6] = [
    (0.5, 0.841),
    (1.0, 0.818),
    (1.5, 0.80),
    (2.0, 0.79),
    (2.0, 0.788),
    (0.8, 0.83),
];
const WET: [(f64, f64); 6] = [
    (0.8, 0.55),
    (1.0, 0.60),
    (1.2, 0.61),
    (1.4, 0.65),
    (1.6, 0.64),
    (1.8, 0.67),
];

/// Rows of PTFE, given as speed and restitution: dry ones, and wet ones of one film.
fn rows(dry: &[(f64, f64)], wet: &[(f64, f64)]) -> String {
    let of = |start: &'static str| move |(v, e): &(f64, f64)| format!("PTFE,{start},{v},{e}\n");
    let (dry, wet) = (dry.iter().map(of("dry,4.762,")), wet.iter().map(of("AK10,4.762,286")));
    dry.chain(wet).collect()
}

/// Fits wet runs of one series beside some dry runs.
pub fn fit(wet: &[(f64, f64)]) -> Findings {
    Place::new(&scene_text()).fit_rows(&(HEADER.to_owned() + &rows(&DRY[..5], wet)))
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
    let degenerate: [(&[(f64, f64)], &str); 3] = [
        (
            &[(1.0, 0.70), (1.0, 0.71), (1.0, 0.69), (1.0, 0.705)],
            "cannot tell the parameters apart",
        ),
        (&[(0.8, 0.66)], "cannot determine"),
        (&[(0.8, 0.0), (1.0, 0.0)], "cannot determine"),
    ];
    for (wet, words) in degenerate {
        assert_no_uncertainty(&fit(wet), "degenerate", words);
    }
    // the law through two runs is known, only its uncertainty is not
    let two = fit(&[(0.8, 0.66), (1.6, 0.70)]);
    assert_no_uncertainty(&two, "converged", "as many parameters as runs");
    assert!(two.series[0].estimates[Alpha].value.is_some());
}

#[test]
fn all_restitutions_equal() {
    let findings = fit(&[(0.8, 0.7), (1.0, 0.7), (1.2, 0.7), (1.6, 0.7)]);
    assert_honest(&findings);
    let series = &findings.series[0];
    assert!(!series.verdict.passed, "{:?}", series.verdict);
    assert!(series.estimates[ThresholdSpeed].value.is_none() && series.estimates[ThresholdSpeed].why_none.is_some());
    for estimate in estimates(&findings) {
        assert!(estimate.se.is_none(), "{estimate:?}");
    }
}

#[test]
fn restitution_that_rises_towards_low_speeds_has_no_threshold() {
    let findings = fit(&[
        (0.8, 0.74),
        (0.9, 0.733),
        (1.0, 0.73),
        (1.2, 0.722),
        (1.4, 0.712),
        (1.6, 0.711),
    ]);
    assert_honest(&findings);
    let series = &findings.series[0];
    assert_eq!(series.stop, "converged");
    assert!(!series.verdict.passed, "{:?}", series.verdict);
    series.verdict.reason.says("does not fall");
    assert!(series.estimates[Beta].value.is_some_and(|beta| beta > 0.0) && series.estimates[Beta].se.is_some());
    assert!(series.estimates[ThresholdSpeed].value.is_none());
    assert!(series.estimates[ThresholdSpeed]
        .why_none
        .as_deref()
        .is_some_and(|why| why.contains("β")));
    for row in &findings.scaling {
        assert!(row.estimates[StC].value.is_none() && !row.verdict.passed, "{row:?}");
    }
}

#[test]
fn a_failed_series_does_not_gate_but_no_law_at_all_does() {
    let good: Vec<(f64, f64)> = [0.8, 1.0, 1.2, 1.4, 1.6]
        .into_iter()
        .flat_map(|v: f64| [0.004, -0.003].map(|noise| (v, (0.5 - 0.1 / v).sqrt() + noise)))
        .collect();
    let gates = |findings: &Findings| findings.checks().any(|check| check.gates() && !check.passed);
    assert!(gates(&fit(&[(1.0, 0.70), (1.0, 0.71), (1.0, 0.69)])));
    let findings = fit(&good);
    let scaling = findings.check("scaling_law");
    assert!(scaling.passed, "{scaling:?}");
    // one film ratio and one density ratio: dry runs tell C, so the stepwise balance is determined
    assert!(!gates(&findings), "{:?}", findings.remarks);
}

fn sampled_text() -> String {
    scene_of("degenerate", &[PTFE, PE, AK10]) + "[sampler]\nchains = 4\n"
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
        let numbers = [
            quantity.mean,
            quantity.sd,
            quantity.median,
            quantity.q05,
            quantity.q95,
            quantity.rhat,
            quantity.ess_bulk,
            quantity.ess_tail,
            quantity.mcse_mean,
        ];
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
    let (findings, posterior) = sample(&rows(&DRY, &[]));
    assert!(posterior.is_some() && findings.posterior.as_ref().is_some_and(|p| p.derived.is_empty()));
    assert_eq!(names(&findings), ["dry_k[PTFE]", "sigma_dry"]);
    let left: Vec<_> = findings
        .posterior
        .iter()
        .flat_map(|p| &p.left_out)
        .map(|l| l.name.as_str())
        .collect();
    assert_eq!(
        left,
        ["dry_k[PE]", "lubrication_log", "inertial_prefactor", "sigma_wet"]
    );
    assert_eq!(failed(&findings), Vec::<&str>::new());
}

#[test]
fn one_film_ratio_without_dry_runs_keeps_the_priors_of_k_and_the_prefactor() {
    let (findings, _) = sample(&rows(&[], &WET));
    assert_eq!(
        names(&findings),
        ["dry_k[PTFE]", "lubrication_log", "inertial_prefactor", "sigma_wet"]
    );
    let led = findings.main.parameters.iter();
    let led: Vec<(String, bool)> = led.map(|own| (own.name(), own.prior_led)).collect();
    assert!(led.contains(&("inertial_prefactor".to_owned(), true)), "{led:?}");
    let notice = findings.notice("prior_rules");
    assert!(notice.is_some_and(|notice| notice.text.contains(" C (")));
}

/// Bounds alone mix slowly, and a few draws show what keeps its prior.
#[test]
fn wet_runs_that_all_stuck_bound_the_parameters_and_without_dry_ones_are_not_sampled() {
    let stuck = WET.map(|(v, _)| (v, 0.0));
    let (findings, posterior) = sample(&rows(&[], &stuck));
    assert!(posterior.is_none() && findings.forbids("rebounds"));
    let short = sampled_text().replace("chains = 4", "chains = 2\nwarmup = 100\ndraws = 25");
    let (findings, posterior) = sample_scene(&short, &rows(&DRY, &stuck));
    assert!(posterior.is_some());
    let notice = findings.notice("prior_rules").expect("told");
    notice.text.says("σ_wet");
}

/// Restitutions of one value at one setting have no spread: no likelihood, but an end.
#[test]
fn very_many_identical_runs_end_in_a_verdict() {
    let row = "PTFE,AK10,4.762,286,1.2,0.61\n";
    let (findings, posterior) = sample(&(rows(&DRY, &[]) + &row.repeat(100_000)));
    assert!(posterior.is_none());
    assert!(findings.forbids("noise"), "{:?}", failed(&findings));
}

#[test]
fn every_prior_fixed_leaves_nothing_to_sample() {
    let fixed = "[priors]\ndry_k = { fixed = 0.18 }\nlubrication_log = { fixed = 2 }\ninertial_prefactor = { fixed = 0 }\nsigma_dry = { fixed = 0.01 }\nsigma_wet = { fixed = 0.02 }\n";
    let (findings, posterior) = sample_scene(&format!("{}{fixed}", sampled_text()), &rows(&DRY, &WET));
    assert!(posterior.is_none());
    // least squares, which knows no prior, finds an L here whose δc is thicker than the film
    assert_eq!(failed(&findings), ["plausible_result", "posterior"]);
}

#[test]
fn too_few_draws_fail_by_name() {
    let of = |sampler: &str| {
        let short = sampled_text().replace("chains = 4", sampler);
        sample_scene(&short, &rows(&DRY, &WET)).0
    };
    let findings = of("chains = 2\nwarmup = 20\ndraws = 5");
    assert!(findings.forbids("ess_bulk"), "{:?}", failed(&findings));
    assert!(!quotable(&findings.remarks));
    let check = findings.check("ess_bulk");
    check.text.says("after 40 draws a chain in place of 5");
    check.next_step.says("raise draws and warmup in [sampler]");
    // fewer than diagnostics need
    assert!(of("chains = 1\nwarmup = 1\ndraws = 1").forbids("rhat"));
}

#[test]
fn a_wet_law_that_does_not_fit_leaks_into_k_and_is_caught() {
    // restitutions no film could leave: wet runs faster than dry ones
    let wet = (0..60).map(|i| (0.8 + 0.02 * f64::from(i), 0.93 + 0.005 * f64::from(i % 3)));
    let wet: Vec<(f64, f64)> = wet.collect();
    let (findings, _) = sample(&rows(&DRY, &wet));
    assert!(
        failed(&findings).contains(&"dry_consistency"),
        "{:?}",
        failed(&findings)
    );
}
