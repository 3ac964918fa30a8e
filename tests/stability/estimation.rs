//! Takes units, counts, noise, designs and priors to their extremes, each to an answer or a verdict with a reason.

use rayon::prelude::*;
use wetcor::findings::estimate::Estimate;
use wetcor::findings::verdicts::quotable;
use wetcor::inference::kernel;
use wetcor::inference::law::Law;
use wetcor::inference::nuts::{Effort, SamplingPlan, TARGET_ACCEPT};
use wetcor::inference::prepared_posterior::PreparedPosterior;
use wetcor::inference::regression::Regression;
use wetcor::inference::sampling::sample_by_nuts;
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::{ModelParameters, ParameterKind};
use wetcor::physics::inertia::Inertia;
use wetcor::physics::{DrySpeed, Form};
use wetcor::runs::NewRun;
use wetcor::scene::{Prior, PriorChoice, Scene};
use wetcor::seed::StreamName;

use super::asking::{both, chance, draw, dry_run, least_squares, of_draws, rounded_up, scene, table, wet_run, Told};
use crate::common::{mean, Told as _};

/// A line of the table.
pub struct Row {
    pub case: String,
    pub asked: &'static str,
    pub came_out: String,
}

/// A line for runs whose truth is known; what may be quoted must be right.
fn row(case: impl Into<String>, asked: &'static str, told: &Told) -> Row {
    let near = |distance: Option<f64>| distance.is_none_or(|distance| distance < 5.0);
    let case_told = &told.text;
    assert!(
        !quotable(&told.findings.remarks) || near(told.distance) && near(told.posterior_distance),
        "{case_told}"
    );
    let case = case.into();
    Row {
        case,
        asked,
        came_out: told.text.clone(),
    }
}

/// The same of runs, asked of both.
fn asked(case: impl Into<String>, scene: &Scene, runs: &[NewRun]) -> Row {
    row(case, BOTH, &both(scene, &table(scene, runs)))
}

const LS: &str = "least squares";
const BOTH: &str = "least squares, posterior";

/// Every case that takes no more than a second or two.
pub fn fast() -> Vec<Row> {
    let parts: [fn() -> Vec<Row>; 9] = [units, counts, noise, speeds, outliers, stuck, films, priors, bounds];
    // in their order, however many at a time
    let rows: Vec<Vec<Row>> = parts.into_par_iter().map(|part| part()).collect();
    rows.into_iter().flatten().collect()
}

fn is_wet(run: &NewRun) -> bool {
    run.liquid.is_some()
}

fn counts() -> Vec<Row> {
    let scene = scene(&[]);
    let mut rows = vec![];
    for n in [1, 2, 3] {
        let case = format!("{n} wet runs at as many speeds, no dry ones");
        let mut rng = chance(&case);
        let runs: Vec<NewRun> = (0..n)
            .map(|i| wet_run(&scene, 4.762e-3, 0.06, 0.8 + 0.4 * f64::from(i), &mut rng))
            .collect();
        rows.push(asked(case, &scene, &runs));
        let case = format!("{n} wet runs, {n} dry ones");
        let dry = draw(&scene, &case, None)
            .into_iter()
            .filter(|run| !is_wet(run))
            .step_by(5)
            .take(n as usize);
        let runs: Vec<NewRun> = runs.into_iter().chain(dry).collect();
        rows.push(asked(case, &scene, &runs));
    }
    rows
}

fn noise() -> Vec<Row> {
    let mut rows = vec![];
    for sigma in ["0", "1e-15", "1e-6", "0.1", "1"] {
        let sigma_text = if sigma == "0" { "1e-300" } else { sigma };
        let scene = scene(&[
            ("sigma_dry = 0.01", &format!("sigma_dry = {sigma_text}")),
            ("sigma_wet = 0.02", &format!("sigma_wet = {sigma_text}")),
            (
                "[truth]",
                "[priors]\nsigma_dry = { half_normal = 1 }\nsigma_wet = { half_normal = 1 }\n[truth]",
            ),
        ]);
        let case = format!("noise of {sigma}");
        let told = both(&scene, &table(&scene, &draw(&scene, &case, Some(1600))));
        let mut line = row(case, BOTH, &told);
        if told.findings.posterior.is_none() {
            let k = told.findings.dry[0].dry_k.value.expect("the law meets the runs");
            line.came_out += &format!("; k right to {}", digits(k / 0.183 - 1.0));
        }
        rows.push(line);
    }
    rows
}

/// The power of ten that a relative error stays below.
fn digits(error: f64) -> String {
    assert!(error.is_finite());
    format!("10^{:.0}", error.abs().max(2e-14).log10().ceil())
}

fn speeds() -> Vec<Row> {
    let scene = scene(&[]);
    let mut rows = vec![];
    for gap in [0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
        let case = format!("all speeds equal up to {gap:e}");
        let mut rng = chance(&case);
        let mut runs: Vec<NewRun> = (0..160)
            .map(|i| {
                let v = 1.0 + gap * f64::from(i % 7);
                let ratio = [0.04, 0.1][i as usize % 2];
                wet_run(&scene, [4.762e-3, 8e-3][i as usize / 2 % 2], ratio, v, &mut rng)
            })
            .collect();
        runs.extend((0..32).map(|i| dry_run(&scene, 1.0 + gap * f64::from(i % 7), &mut rng)));
        rows.push(asked(case, &scene, &runs));
    }
    rows
}

fn outliers() -> Vec<Row> {
    let scene = scene(&[]);
    let mut worst = 0.0_f64;
    for place in [40, 80, 120, 159] {
        for e in [0.0, 1e-9, 0.01, 0.2, 0.4, 0.6, 0.8, 0.99, 1.0] {
            let mut runs = draw(&scene, "one outlier anywhere in [0, 1]", None);
            runs[place].restitution = e;
            let told = least_squares(&scene, &table(&scene, &runs));
            worst = worst.max(told.distance.unwrap_or(f64::INFINITY));
        }
    }
    let mut runs = draw(&scene, "one outlier anywhere in [0, 1]", None);
    runs[100].restitution = 1e-9;
    let told = both(&scene, &table(&scene, &runs));
    vec![
        Row {
            case: "one outlier: 4 runs at 9 values from 0 to 1".to_owned(),
            asked: LS,
            came_out: format!("least squares within {} se at the worst", rounded_up(worst)),
        },
        row("one wet run at 1e-9", BOTH, &told),
    ]
}

fn stuck() -> Vec<Row> {
    let mut rows = vec![];
    let near = |viscosity: &str| {
        scene(&[
            ("viscosity_mPa_s = 9.3", &format!("viscosity_mPa_s = {viscosity}")),
            ("viscosity_mPa_s = 20", &format!("viscosity_mPa_s = {viscosity}")),
            ("sigma_wet = 0.02", "sigma_wet = 0.1"),
        ])
    };
    let half = near("140");
    let runs = draw(&half, "half the runs stuck", Some(1600));
    let wet = runs.iter().filter(|run| is_wet(run)).count() as f64;
    let stuck = runs.iter().filter(|run| is_wet(run) && run.restitution == 0.0).count() as f64;
    assert!((0.4..0.6).contains(&(stuck / wet)), "{}", stuck / wet);
    rows.push(asked("half the wet runs stuck", &half, &runs));
    let all = near("2000");
    let mut runs = draw(&all, "all runs stuck", None);
    assert!(runs.iter().all(|run| !is_wet(run) || run.restitution == 0.0));
    rows.push(asked("all wet runs stuck", &all, &runs));
    runs.iter_mut().for_each(|run| run.restitution = 0.0);
    rows.push(asked("all runs stuck", &all, &runs));
    // every setting keeps no energy on average: r within 1e-3 of 0
    let base = scene(&[("sigma_wet = 0.02", "sigma_wet = 1e-3")]);
    let mut rng = chance("r touches the threshold");
    let e_dry = 1.0 - 0.183 * 2f64.powf(0.2);
    let mut runs: Vec<NewRun> = draw(&base, "r touches the threshold", None)
        .into_iter()
        .filter(|run| !is_wet(run))
        .collect();
    for i in 0..200 {
        let (d, x) = (4.762e-3, [0.04, 0.1][i % 2]);
        let left = e_dry * e_dry - 0.6 * 930.0 / 2150.0 * x * (3.0 - 6.0 * x + 4.0 * x * x);
        // St at which r = 0, and speeds within a thousandth of it
        let v = 4.0 * 1.9 / left * 9.0 * 9.3e-3 / (2150.0 * d) * (1.0 + 1e-3 * ((i as f64) / 100.0 - 1.0));
        runs.push(wet_run(&base, d, x, v, &mut rng));
    }
    rows.push(asked("r within 1e-3 of zero at every wet run", &base, &runs));
    rows
}

fn films() -> Vec<Row> {
    let mut rows = vec![];
    let one = scene(&[("film_ratio = { PTFE = [0.04, 0.10] }", "film_ratio = { PTFE = [0.06] }")]);
    let runs = draw(&one, "film ratios all equal", None);
    rows.push(asked("film ratios all equal", &one, &runs));
    let wet: Vec<NewRun> = runs.into_iter().filter(is_wet).collect();
    rows.push(asked("film ratios all equal, no dry runs", &one, &wet));
    let saturating = |films: &str| {
        scene(&[
            ("inertia = \"stepwise\"", "inertia = \"saturating\""),
            (
                "inertial_prefactor = 0.6",
                "inertial_prefactor = 0.6\nfilm_scale = 0.07",
            ),
            ("film_ratio = { PTFE = [0.04, 0.10] }", films),
        ])
    };
    let collinear = saturating("film_ratio = { PTFE = [0.060000001, 0.06] }");
    let runs = draw(&collinear, "two collinear groups", None);
    rows.push(asked("two film ratios 1e-9 apart, saturating", &collinear, &runs));
    let thin = saturating("film_ratio = { PTFE = [1e-6, 2e-6] }");
    let runs = draw(&thin, "two film ratios where the loss is a line", None);
    rows.push(asked("film ratios 1e-6 and 2e-6, saturating", &thin, &runs));
    rows
}

fn with_priors(scene: &Scene, priors: &[(&'static str, Prior)]) -> Scene {
    let mut scene = scene.clone();
    scene.priors = priors
        .iter()
        .map(|(name, prior)| PriorChoice {
            parameter: name,
            particle: None,
            prior: *prior,
            line: None,
        })
        .collect();
    scene
}

fn priors() -> Vec<Row> {
    let base = scene(&[]);
    let runs = draw(&base, "priors", None);
    let table = table(&base, &runs);
    let all = |shift: f64, factor: f64| {
        [
            ("dry_k", Prior::LogNormal(0.183 * shift, 0.5 * factor)),
            ("lubrication_log", Prior::LogNormal(1.9 * shift, 0.5 * factor)),
            ("inertial_prefactor", Prior::LogNormal(0.6 * shift, 0.5 * factor)),
            ("sigma_dry", Prior::HalfNormal(0.1 * f64::max(1.0, factor))),
            ("sigma_wet", Prior::HalfNormal(0.1 * f64::max(1.0, factor))),
        ]
    };
    let mut rows = vec![];
    for (case, priors) in [
        // beyond either a scene is refused
        ("priors 20 times too wide", all(1.0, 20.0)),
        ("priors 10^5 times too narrow, at the truth", all(1.0, 1e-5)),
        ("priors 10^5 times too narrow, a third off", all(1.33, 1e-5)),
    ] {
        let scene = with_priors(&base, &priors);
        rows.push(row(case, BOTH, &both(&scene, &table)));
    }
    rows.push(row(
        "sigma_wet's prior 10^6 times too narrow",
        BOTH,
        &both(&with_priors(&base, &[("sigma_wet", Prior::HalfNormal(1e-7))]), &table),
    ));
    rows
}

fn bounds() -> Vec<Row> {
    // k at which e_dry is zero at the fastest dry run, 2 m/s, and a little below
    let mut rows = vec![];
    for k in ["0.8705505632961241", "0.87"] {
        let mut bound = scene(&[
            ("dry_k = { PTFE = 0.183 }", &format!("dry_k = {{ PTFE = {k} }}")),
            ("inertia = \"stepwise\"", "inertia = \"none\""),
            ("viscosity_mPa_s = 9.3", "viscosity_mPa_s = 0.1"),
            ("viscosity_mPa_s = 20", "viscosity_mPa_s = 0.2"),
            ("[30, 60, 100, 150]", "[1, 2, 5, 20, 100, 200]"),
        ]);
        bound.model.dry_speed = DrySpeed::Impact;
        if let Some(truth) = &mut bound.truth {
            truth.dry_speed = DrySpeed::Impact;
        }
        let runs = draw(&bound, "k on its bound", None);
        let case = if k == "0.87" {
            "k 6e-4 below its bound"
        } else {
            "k on its bound"
        };
        let told = both(&bound, &table(&bound, &runs));
        rows.push(row(case, BOTH, &told));
    }
    rows
}

/// The scene and its runs in units so many times smaller.
fn rescaled<'s>(
    scene: &'s Scene,
    runs: &[NewRun<'s>],
    metre: f64,
    kilogram: f64,
    second: f64,
) -> (Scene, Vec<NewRun<'s>>) {
    let density = kilogram / metre.powi(3);
    let speed = metre / second;
    let mut there = scene.clone();
    for particle in &mut there.particles {
        particle.density *= density;
        particle.roughness = particle.roughness.map(|roughness| roughness * metre);
    }
    for liquid in &mut there.liquids {
        liquid.density *= density;
        liquid.viscosity *= kilogram / (metre * second);
    }
    there.model.dry_speed = DrySpeed::Reference(2.0 * speed);
    let prior = Prior::LogNormal(0.15 * speed.powf(-0.2), 0.5);
    there.priors.push(PriorChoice {
        parameter: "dry_k",
        particle: None,
        prior,
        line: None,
    });
    if let Some(truth) = &mut there.truth {
        truth.dry_k[0] = truth.dry_k[0].map(|k| k * speed.powf(-0.2));
    }
    let runs = runs.iter().map(|run| NewRun {
        diameter: run.diameter * metre,
        film: run.film.map(|(film, ratio)| (film * metre, ratio)),
        impact_speed: run.impact_speed * speed,
        ..*run
    });
    (there, runs.collect())
}

/// Everything told that has no unit, or whose unit is undone.
fn pure(told: &Told, metre: f64, second: f64) -> Vec<f64> {
    let speed = metre / second;
    let pair = |e: &Estimate, unit: f64| [e.value, e.se].map(|x| x.unwrap_or(f64::NAN) / unit);
    let findings = &told.findings;
    let mut numbers = vec![];
    for series in &findings.series {
        numbers.extend(pair(&series.alpha, 1.0));
        numbers.extend(pair(&series.beta, speed));
        numbers.extend(pair(&series.threshold_speed_m_s, speed));
    }
    for scaling in &findings.scaling {
        numbers.extend([&scaling.e_inf, &scaling.st_c].into_iter().flat_map(|e| pair(e, 1.0)));
    }
    let balance = findings.balance();
    for parameter in &balance.parameters {
        let unit = if parameter.name.starts_with("dry_k") {
            speed.powf(-0.2)
        } else {
            1.0
        };
        numbers.extend(pair(&parameter.estimate, unit));
    }
    for energy in findings.scaling.iter().filter_map(|law| law.energy.as_ref()) {
        numbers.extend(pair(&energy.delta_c_m, metre));
    }
    numbers
}

fn units() -> Vec<Row> {
    let base = scene(&[]);
    let runs = draw(&base, "units", None);
    let here = both(&base, &table(&base, &runs));
    let mut rows = vec![row("units as they are", BOTH, &here)];
    let numbers = pure(&here, 1.0, 1.0);
    for (unit, [metre, kilogram, second]) in [
        ("metre by 1e9", [1e9, 1.0, 1.0]),
        ("metre by 1e-9", [1e-9, 1.0, 1.0]),
        ("kilogram by 1e9", [1.0, 1e9, 1.0]),
        ("kilogram by 1e-9", [1.0, 1e-9, 1.0]),
        ("second by 1e9", [1.0, 1.0, 1e9]),
        ("second by 1e-9", [1.0, 1.0, 1e-9]),
        ("metre by 1e9, kilogram and second by 1e-9", [1e9, 1e-9, 1e-9]),
        ("metre by 1e-9, kilogram and second by 1e9", [1e-9, 1e9, 1e9]),
    ] {
        let (there, moved) = rescaled(&base, &runs, metre, kilogram, second);
        let told = both(&there, &table(&there, &moved));
        let gap = numbers
            .iter()
            .zip(pure(&told, metre, second))
            .map(|(a, b)| (a / b - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(gap < 1e-6, "{unit}: {gap:e}");
        let mut line = row(unit, BOTH, &told);
        line.came_out += "; no number moved by 10^-6";
        rows.push(line);
    }
    rows
}

/// 10³ groups of 3 runs: as many diameters, each with its own film ratio.
fn groups() -> Row {
    let base = scene(&[]);
    let mut rng = chance("a thousand groups of three runs");
    let mut runs: Vec<NewRun> = (0..40)
        .map(|i| dry_run(&base, 0.5 + 0.04 * f64::from(i), &mut rng))
        .collect();
    for group in 0..1000 {
        let ratio = 0.02 + 1e-4 * f64::from(group);
        runs.extend([0.8, 1.2, 1.7].map(|v| wet_run(&base, 4.762e-3, ratio, v, &mut rng)));
    }
    asked("10^3 groups of 3 runs", &base, &runs)
}

/// The few runs that stand for 10⁶, each at a speed of its own, against all of them.
fn few_runs() -> Vec<Row> {
    let mut rows = vec![];
    for sigma in [1e-6, 1e-4, 1e-2, 1.0] {
        let mut base = scene(&[]);
        if let Some(truth) = &mut base.truth {
            (truth.sigma_wet, truth.sigma_dry) = (Some(sigma), Some(sigma));
        }
        let wide = Prior::HalfNormal(f64::max(0.1, sigma));
        let base = with_priors(&base, &[("sigma_wet", wide), ("sigma_dry", wide)]);
        let mut rng = chance(&format!("a compressed sum at {sigma}"));
        let mut runs: Vec<NewRun> = (0..1000)
            .map(|i| dry_run(&base, 0.5 + 1.5e-3 * f64::from(i), &mut rng))
            .collect();
        runs.iter_mut()
            .for_each(|run| run.restitution = run.restitution.max(0.0));
        for i in 0..1_000_000u32 {
            let v = 0.77 + 1e-6 * f64::from(i);
            runs.push(wet_run(&base, 4.762e-3, [0.04, 0.1][i as usize % 2], v, &mut rng));
        }
        let runs = table(&base, &runs).runs;
        let form = Form::new(Inertia::Stepwise, base.model.dry_speed);
        let parameters = ModelParameters::of(&base, &runs, form).expect("room");
        let few = runs.condensed(0.0).expect("very many");
        let [of_all, of_few] = [&runs, &few].map(|runs| Likelihood::new(&base, runs, form));
        let start = vec![
            (ParameterKind::DryK(0), 0.18),
            (ParameterKind::LUBRICATION_LOG, 1.8),
            (ParameterKind::INERTIAL_PREFACTOR, 0.7),
            (ParameterKind::SigmaWet, sigma),
            (ParameterKind::SigmaDry, sigma),
        ];
        let effort = Effort {
            chains: 2,
            warmup: 500,
            draws: 500,
            target_accept: TARGET_ACCEPT,
        };
        let prepared = PreparedPosterior::new(parameters, &of_few, &start).expect("a start");
        let plan = SamplingPlan::new(effort, StreamName::new(1, "stability"));
        let sampled = sample_by_nuts(&prepared, plan, &mut |_| 0).expect("a posterior");
        let truth = [0.183, 1.9, 0.6];
        let distances = sampled.values.iter().zip(truth).map(|(chains, truth)| {
            let draws: Vec<f64> = chains.iter().flatten().copied().collect();
            let (mean, se) = mean(&draws);
            (mean - truth).abs() / (se * (draws.len() as f64).sqrt())
        });
        let distance = distances.fold(0.0, f64::max);
        let draws: Vec<Vec<f64>> = sampled.full_draws().into_iter().step_by(50).collect();
        let left = draws.iter().map(|full| {
            let mut slopes = vec![0.0; full.len()];
            let [all, few] = [&of_all, &of_few].map(|of| of.ln_density(full, &mut slopes).expect("a density"));
            all - few
        });
        let left: Vec<f64> = left.collect();
        let (centre, _) = mean(&left);
        let error = left.iter().map(|left| (left - centre).abs()).fold(0.0, f64::max);
        rows.push(Row {
            case: format!("few runs for 10^6, σ = {sigma:e}"),
            asked: "posterior by 2 chains, log density of the few against all runs",
            came_out: format!(
                "log density off by less than {} with fewer than {} runs; posterior within {} sd",
                digits(error.max(1e-7)),
                few.len().next_power_of_two(),
                of_draws(distance)
            ),
        });
    }
    rows
}

/// 10⁷ runs made in memory, a hundred thousand a setting.
fn ten_million() -> Vec<Row> {
    const RUNS: u64 = 10_000_000;
    let base = scene(&[]);
    let table = table(&base, &draw(&base, "ten million runs", Some(RUNS)));
    let told = both(&base, &table);
    let mut rows = vec![row("10^7 runs", BOTH, &told)];
    // the kernel of the bootstrap beside the solver, on the longest law of all
    let group = &table.runs.series;
    let range = group[0].rebounds.clone();
    let x: Vec<f64> = table.runs.impact_speed[range.clone()].iter().map(|v| 1.0 / v).collect();
    let e = &table.runs.restitution[range];
    let fit = Regression::new(Law::SQUARE_ROOT, &x, e).fit();
    let ones = vec![1.0; x.len()];
    let by_kernel = kernel::fit(
        &Regression::new(Law::SQUARE_ROOT, &x, e).weighted(&ones),
        [fit.parameters[0] * 1.01, fit.parameters[1] * 1.02],
    )
    .expect("a fit");
    let gap = fit
        .parameters
        .iter()
        .zip(by_kernel)
        .map(|(a, b)| (a / b - 1.0).abs())
        .fold(0.0, f64::max);
    assert!(gap < 1e-9, "{gap:e}");
    rows.push(Row {
        case: format!("the bootstrap's kernel on a series of {} runs", x.len()),
        asked: "the law of all runs",
        came_out: format!("the solver's to {}", digits(gap.max(1e-11))),
    });
    rows
}

/// Every case that takes longer.
pub fn slow() -> Vec<Row> {
    let mut rows = vec![groups()];
    rows.extend(few_runs());
    rows.extend(ten_million());
    rows
}
