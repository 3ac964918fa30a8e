//! Holds that runs which leave a posterior without ground end in a verdict, a notice or a message, in bounded time.

use crate::common::scenes::{scene_of, AK10, HEADER, PE, PTFE};
use crate::common::{self, Place, Says, Told};
use wetcor::findings::posterior::Posterior;
use wetcor::findings::verdicts::quotable;
use wetcor::findings::{self, Findings};

fn scene_text() -> String {
    scene_of("degenerate", &[PTFE, PE, AK10])
        + r#"[sampler]
chains = 4
"#
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

/// Rows of a particle: dry ones as (v, e), wet ones as (film in µm, v, e).
fn rows(particle: &str, dry: &[(f64, f64)], wet: &[(f64, f64, f64)]) -> String {
    let mut csv = String::new();
    for (v, e) in dry {
        csv.push_str(&format!("{particle},dry,4.762,,{v},{e}\n"));
    }
    for (film, v, e) in wet {
        csv.push_str(&format!("{particle},AK10,4.762,{film},{v},{e}\n"));
    }
    csv
}

fn at(film: f64, runs: &[(f64, f64)]) -> Vec<(f64, f64, f64)> {
    runs.iter().map(|(v, e)| (film, *v, *e)).collect()
}

fn sample(rows: &str) -> (Findings, Option<Posterior>) {
    sample_scene(&scene_text(), rows)
}

fn sample_scene(scene: &str, rows: &str) -> (Findings, Option<Posterior>) {
    let place = Place::new(scene);
    let csv = format!("{HEADER}{rows}");
    let table = place.read_rows(&csv);
    let mut findings = findings::fit_least_squares(&place.scene, &table, 1, false);
    let posterior = common::sample(&mut findings, &place.scene, &table.runs);
    assert_honest(&findings);
    (findings, posterior)
}

/// What is told is finite, or is missing with its reason.
pub fn assert_honest(findings: &Findings) {
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
    let (findings, posterior) = sample(&rows("PTFE", &DRY, &[]));
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
    let (findings, _) = sample(&rows("PTFE", &[], &at(286.0, &WET)));
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
    let stuck: Vec<(f64, f64, f64)> = at(286.0, &WET).into_iter().map(|(film, v, _)| (film, v, 0.0)).collect();
    let (findings, posterior) = sample(&rows("PTFE", &[], &stuck));
    assert!(posterior.is_none() && findings.forbids("rebounds"));
    let short = scene_text().replace("chains = 4", "chains = 2\nwarmup = 100\ndraws = 25");
    let (findings, posterior) = sample_scene(&short, &rows("PTFE", &DRY, &stuck));
    assert!(posterior.is_some());
    let notice = findings.notice("prior_rules").expect("told");
    notice.text.says("σ_wet");
}

/// Restitutions of one value at one setting have no spread: no likelihood, but an end.
#[test]
fn very_many_identical_runs_end_in_a_verdict() {
    let row = "PTFE,AK10,4.762,286,1.2,0.61\n";
    let (findings, posterior) = sample(&(rows("PTFE", &DRY, &[]) + &row.repeat(100_000)));
    assert!(posterior.is_none());
    assert!(findings.forbids("noise"), "{:?}", failed(&findings));
}

#[test]
fn every_prior_fixed_leaves_nothing_to_sample() {
    let fixed = "[priors]\ndry_k = { fixed = 0.18 }\nlubrication_log = { fixed = 2 }\ninertial_prefactor = { fixed = 0 }\nsigma_dry = { fixed = 0.01 }\nsigma_wet = { fixed = 0.02 }\n";
    let (findings, posterior) = sample_scene(
        &format!("{}{fixed}", scene_text()),
        &rows("PTFE", &DRY, &at(286.0, &WET)),
    );
    assert!(posterior.is_none());
    // least squares, which knows no prior, finds an L here whose δc is thicker than the film
    assert_eq!(failed(&findings), ["plausible_result", "posterior"]);
}

#[test]
fn too_few_draws_fail_by_name() {
    let of = |sampler: &str| {
        let short = scene_text().replace("chains = 4", sampler);
        sample_scene(&short, &rows("PTFE", &DRY, &at(286.0, &WET))).0
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
    let wet: Vec<(f64, f64, f64)> = (0..60)
        .map(|i| (286.0, 0.8 + 0.02 * f64::from(i), 0.93 + 0.005 * f64::from(i % 3)))
        .collect();
    let (findings, _) = sample(&rows("PTFE", &DRY, &wet));
    assert!(
        failed(&findings).contains(&"dry_consistency"),
        "{:?}",
        failed(&findings)
    );
}
