//! Holds that runs which determine nothing end in a verdict and a reason, never in an invented ±.

use crate::common::scenes::{scene_of, AK10, HEADER, PTFE};
use crate::common::{Place, Says, Told};
use wetcor::findings::estimate::Estimate;
use wetcor::findings::Findings;

fn scene_text() -> String {
    scene_of("degenerate", &[PTFE, AK10])
}

/// Fits wet runs of one series, given as speed and restitution, beside some dry runs.
pub fn fit(wet: &[(f64, f64)]) -> Findings {
    let mut csv = HEADER.to_owned();
    for (v, e) in [(0.5, 0.841), (1.0, 0.818), (1.5, 0.80), (2.0, 0.79), (2.0, 0.788)] {
        csv.push_str(&format!("PTFE,dry,4.762,,{v},{e}\n"));
    }
    for (v, e) in wet {
        csv.push_str(&format!("PTFE,AK10,4.762,286,{v},{e}\n"));
    }
    Place::new(&scene_text()).fit_rows(&csv)
}

/// Every estimate of the wet runs.
pub fn estimates(findings: &Findings) -> Vec<&Estimate> {
    let series = findings.series.iter();
    let series = series.flat_map(|s| [&s.alpha, &s.beta, &s.e_inf, &s.threshold_speed_m_s]);
    let laws = findings.scaling.iter();
    let laws = laws.flat_map(|s| [&s.e_inf, &s.st_c].into_iter().chain(&s.st_no_rebound));
    let energy = findings.scaling.iter().filter_map(|law| law.energy.as_ref());
    let energy = energy.flat_map(|e| [&e.loss_over_density_ratio, &e.st_c_e_inf2, &e.delta_c_m]);
    series.chain(laws).chain(energy).collect()
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
    assert!(two.series[0].alpha.value.is_some());
}

#[test]
fn all_restitutions_equal() {
    let findings = fit(&[(0.8, 0.7), (1.0, 0.7), (1.2, 0.7), (1.6, 0.7)]);
    assert_honest(&findings);
    let series = &findings.series[0];
    assert!(!series.verdict.passed, "{:?}", series.verdict);
    assert!(series.threshold_speed_m_s.value.is_none() && series.threshold_speed_m_s.why_none.is_some());
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
    assert!(series.beta.value.is_some_and(|beta| beta > 0.0) && series.beta.se.is_some());
    assert!(series.threshold_speed_m_s.value.is_none());
    assert!(series
        .threshold_speed_m_s
        .why_none
        .as_deref()
        .is_some_and(|why| why.contains("β")));
    for row in &findings.scaling {
        assert!(row.st_c.value.is_none() && !row.verdict.passed, "{row:?}");
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
