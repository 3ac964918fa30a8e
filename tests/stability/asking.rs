//! Asks least squares and the posterior of runs made in memory, and tells in a line what came out.

use rand::Rng;
use wetcor::findings::estimate::Estimate;
use wetcor::findings::verdicts::quotable;
use wetcor::findings::{self, Findings};
use wetcor::model::simulate::Simulation;
use wetcor::physics::rebound::mean_restitution;
use wetcor::physics::{kept_energy, Coefficient, Order};
use wetcor::runs::{self, NewRun, Table};
use wetcor::scene::Scene;
use wetcor::seed::stream;

use crate::common::scenes::{design, scene_of, truth, AK10, PTFE, STEPWISE};
use crate::common::{normal, parameters_of, sample, seed_of, setting, Place};
use crate::degenerate;

/// A scene whose least squares and posterior are plainly right, before anything is taken to an extreme.
pub fn base() -> String {
    let m20 = "[liquids.M20]\ndensity_kg_m3 = 950\nviscosity_mPa_s = 20\n";
    let truth = truth([1.9, 0.6, 0.01, 0.02], "");
    let speeds = ["30, 60, 100, 150", "0.5, 1.0, 1.5, 2.0"];
    let design = design(["4.762, 8.0", "0.04, 0.10"], &["AK10", "M20"], speeds, "repeats = 4\n");
    scene_of("extremes", &[PTFE, AK10, m20, STEPWISE, &truth, &design])
}

/// The base scene with some lines replaced.
pub fn scene(changes: &[(&str, &str)]) -> Scene {
    let text = changes.iter().fold(base(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    Place::new(&text).scene
}

/// The design's runs drawn from the scene's truth, by the name of the case.
pub fn draw<'s>(scene: &'s Scene, case: &str, runs: Option<u64>) -> Vec<NewRun<'s>> {
    let simulation = Simulation::new(scene, runs).unwrap_or_else(|error| panic!("{error}"));
    simulation.under(seed_of(case)).all()
}

/// A wet run at a setting of its own, by the truth of the scene; AK10 and PTFE.
pub fn wet_run<'s, R: Rng>(scene: &'s Scene, diameter: f64, film_ratio: f64, v: f64, rng: &mut R) -> NewRun<'s> {
    let truth = scene.truth.as_ref().expect("a truth");
    let (particle, liquid) = (&scene.particles[0], &scene.liquids[0]);
    let film = film_ratio * diameter;
    let setting = setting([particle.density, diameter], [liquid.density, liquid.viscosity], film);
    let of = |coefficient| truth.value(coefficient);
    let (l, c) = (of(Coefficient::LubricationLog), of(Coefficient::InertialPrefactor));
    let scale = of(Coefficient::FilmScale).unwrap_or(1.0);
    let parameters = parameters_of([truth.dry_k[0].expect("k"), l.expect("L"), c.expect("C"), scale]);
    let z = normal(rng);
    let kept = kept_energy(&setting, truth.form(), &parameters, v);
    let e = mean_restitution(kept) + truth.sigma_wet.expect("sigma") * z;
    NewRun {
        particle: &particle.name,
        liquid: Some(&liquid.name),
        diameter,
        film: Some((setting.film, film_ratio)),
        impact_speed: v,
        restitution: e.max(0.0),
    }
}

/// A dry run of the first particle, by the truth of the scene.
pub fn dry_run<'s, R: Rng>(scene: &'s Scene, v: f64, rng: &mut R) -> NewRun<'s> {
    let truth = scene.truth.as_ref().expect("a truth");
    let z = normal(rng);
    NewRun {
        particle: &scene.particles[0].name,
        liquid: None,
        diameter: 4.762e-3,
        film: None,
        impact_speed: v,
        restitution: Order::First.restitution(truth.dry_k[0].expect("k"), v) + truth.sigma_dry.expect("sigma") * z,
    }
}

/// The stream of a case.
pub fn chance(case: &str) -> impl Rng {
    stream(seed_of(case), "stability", 0)
}

pub fn table(scene: &Scene, new: &[NewRun]) -> Table {
    Table::of(runs::arrange(scene, new))
}

/// What was found, and how it is told.
pub struct Told {
    pub findings: Findings,
    /// largest distance from the truth of k, L, C and δ̃0, in standard errors; `None` where the balance has no answer
    pub distance: Option<f64>,
    /// the same of the posterior's means, in posterior standard deviations
    pub posterior_distance: Option<f64>,
    pub text: String,
}

/// Least squares of a table.
pub fn least_squares(scene: &Scene, table: &Table) -> Told {
    tell(scene, findings::fit_least_squares(scene, table, 1, false), false)
}

/// Least squares and posterior of a table.
pub fn both(scene: &Scene, table: &Table) -> Told {
    let mut findings = findings::fit_least_squares(scene, table, 1, false);
    sample(&mut findings, scene, &table.runs);
    tell(scene, findings, true)
}

/// The truth of a parameter by its name.
fn truth_of(scene: &Scene, name: &str) -> f64 {
    let truth = scene.truth.as_ref().expect("a truth");
    let found = match name {
        "lubrication_log" => truth.value(Coefficient::LubricationLog),
        "inertial_prefactor" => truth.value(Coefficient::InertialPrefactor),
        "film_scale" => truth.value(Coefficient::FilmScale),
        "sigma_dry" => truth.sigma_dry,
        "sigma_wet" => truth.sigma_wet,
        // of a noise that stands beside the truth
        "sigma_energy" => Some(truth.sigma_energy.unwrap_or(0.0)),
        _ => truth.dry_k[0],
    };
    found.unwrap_or_else(|| panic!("{name} has no truth"))
}

/// Checks of chains, and of what their draws say.
const OF_CHAINS: [&str; 5] = ["rhat", "ess_bulk", "ess_tail", "e_bfmi", "divergences"];
const OF_DRAWS: [&str; 6] = [
    "dry_consistency",
    "predictive_50",
    "predictive_90",
    "predictive_residual",
    "predictive_stuck",
    "compression_error",
];

fn tell(scene: &Scene, findings: Findings, sampled: bool) -> Told {
    honest(&findings);
    let balance = findings.energy_balance.as_ref();
    let passed = |check: &str| findings.checks().all(|c| c.code != check || c.passed);
    let distance = balance
        .filter(|b| b.verdict.passed && passed("energy_balance"))
        .and_then(|balance| {
            let each = balance.parameters.iter().filter_map(|p| {
                let (value, se) = p.estimate.pair()?;
                Some((value - truth_of(scene, &p.name)).abs() / se)
            });
            each.reduce(f64::max)
        });
    let posterior_distance = findings.posterior.as_ref().and_then(|posterior| {
        let each = posterior
            .parameters
            .iter()
            .filter_map(|q| Some((q.mean? - truth_of(scene, &q.name)).abs() / q.sd?));
        each.reduce(f64::max)
    });
    let failed: Vec<&str> = findings
        .checks()
        .filter(|c| c.gates() && !c.passed)
        .map(|c| c.code)
        .collect();
    let chains = failed.iter().any(|check| OF_CHAINS.contains(check));
    let mut parts = vec![];
    parts.push(match distance {
        Some(distance) => format!("least squares within {} se", rounded_up(distance)),
        None => {
            let of_balance = balance.map(|balance| &balance.verdict);
            let of_dry = findings.dry.iter().map(|dry| &dry.verdict);
            let of_series = findings.series.iter().map(|series| &series.verdict);
            let mut verdicts = of_balance.into_iter().chain(of_dry).chain(of_series);
            let reason = verdicts
                .find(|verdict| !verdict.passed)
                .map(|verdict| verdict.reason.as_str());
            format!(
                "least squares: no balance ({})",
                reason.unwrap_or("no dry runs, no k to begin with")
            )
        }
    });
    if sampled {
        parts.push(match posterior_distance {
            _ if chains => "posterior: the chains are not trusted".to_owned(),
            Some(distance) => format!("posterior within {} sd", of_draws(distance)),
            None => "posterior declined".to_owned(),
        });
    }
    // which checks fail besides where chains lost themselves is up to chance
    let told: Vec<String> = failed
        .iter()
        .filter(|check| !(OF_CHAINS.contains(check) || chains && OF_DRAWS.contains(check)))
        .map(|check| format!("`{check}`"))
        .collect();
    parts.push(match (quotable(&findings.remarks), told.is_empty()) {
        (true, _) => "may be quoted".to_owned(),
        (false, false) => format!("not to be quoted: {}", told.join(", ")),
        (false, true) => "not to be quoted".to_owned(),
    });
    let notices: Vec<String> = findings.notices().map(|n| format!("`{}`", n.code)).collect();
    if !notices.is_empty() {
        parts.push(format!("notices: {}", notices.join(", ")));
    }
    Told {
        distance,
        posterior_distance,
        text: parts.join("; "),
        findings,
    }
}

/// Half units, upwards: no processor's rounding shows in it.
pub fn rounded_up(x: f64) -> String {
    if x > 1e3 {
        return format!("10^{}", x.log10().ceil());
    }
    format!("{}", (2.0 * x + 0.02).ceil() / 2.0)
}

/// Steps between which draws of another processor do not stray: 3.5, 5, powers of ten.
pub fn of_draws(x: f64) -> String {
    match x {
        x if x <= 3.5 => "3.5".to_owned(),
        x if x <= 5.0 => "5".to_owned(),
        x => format!("10^{}", x.log10().ceil()),
    }
}

fn estimates(findings: &Findings) -> Vec<&Estimate> {
    let dry = findings.dry.iter().map(|d| &d.dry_k);
    let balance = findings.energy_balance.iter().flat_map(|b| {
        let parameters = b.parameters.iter().map(|p| &p.estimate);
        let derived = b.derived.iter().flat_map(|d| [&d.e_inf, &d.st_c]);
        parameters.chain(derived).chain([&b.delta_c_over_roughness])
    });
    dry.chain(degenerate::estimates(findings)).chain(balance).collect()
}

/// Everything told is finite, or is missing with its reason; no ± is zero; no failed check is without words.
fn honest(findings: &Findings) {
    estimates(findings)
        .into_iter()
        .for_each(degenerate::assert_estimate_is_honest);
    degenerate::assert_posterior_is_honest(findings);
    for check in findings.checks() {
        assert!(
            check.value.is_none_or(f64::is_finite) && !check.text.is_empty(),
            "{check:?}"
        );
    }
    for series in &findings.series {
        assert!(
            !series.verdict.reason.is_empty() && series.residual_sd.is_none_or(f64::is_finite),
            "{series:?}"
        );
    }
}
