//! Holds where each main number comes from, and that the dry law and one k for all diameters are tested before it is quoted.

use crate::common::scenes::{design, scene_of, truth, HEADER, PTFE, THIN};
use crate::common::{
    binomial_z, counts, holds, normal, sample, sample_as_usual, seed_of, study, table_of, Place, Says, Told,
};
use wetcor::findings::balance::DerivedEstimate;
use wetcor::findings::estimate::Estimate;
use wetcor::findings::estimates::Source;
use wetcor::findings::scaling::Scaling;
use wetcor::findings::{self, Findings};
use wetcor::physics::loss::Film;
use wetcor::physics::Quantity::{EInf, StC};
use wetcor::physics::{Coefficient, Inertia};
use wetcor::runs::Table;
use wetcor::scene::WetLaw;
use wetcor::seed::stream;

/// Two liquids of one density, so that the law may take them as one.
fn scene_text() -> String {
    let thick = "[liquids.thick]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 20\n";
    let asked =
        "[model]\ninertia = \"saturating\"\n[sampler]\nwarmup = 300\ndraws = 300\n[bootstrap]\nreplicates = 200\n";
    let more = "inertia = \"saturating\"\nfilm_scale = 0.069\ndry_speed_m_s = 2.0\n";
    let truth = truth([1.85, 0.47, 0.009, 0.02], more);
    let speeds = ["30, 60, 100, 150", "0.4, 0.8, 1.2, 1.6, 2.0"];
    let design = design(["3.175, 8.0", "0.04, 0.1"], &["thin", "thick"], speeds, "repeats = 4\n");
    scene_of("main numbers", &[PTFE, THIN, thick, asked, &truth, &design])
}

fn fit(scene: &str, table: impl FnOnce(&Place) -> Table) -> Findings {
    let place = Place::new(scene);
    let table = table(&place);
    let mut findings = findings::fit_least_squares(&place.scene, &table, 1, true);
    sample(&mut findings, &place.scene, &table.runs);
    findings
}

fn simulated(name: &str, scene: &str) -> Findings {
    fit(scene, |place| place.draw(seed_of(name), None))
}

/// Sources at a film ratio, with the liquid each stands for.
fn sources(findings: &Findings, film_ratio: f64) -> Vec<(Source, Option<&str>)> {
    let rows = findings.main.places.iter().map(|[e_inf, _]| e_inf);
    let here = rows.filter(|row| row.of.film_ratio == Some(film_ratio));
    here.map(|row| (row.source, row.of.liquid.as_deref())).collect()
}

#[test]
fn parameters_come_from_the_posterior_and_e_inf_from_the_law_where_every_run_rebounded() {
    let findings = simulated("parameters_come_from_the_posterior", &scene_text());
    let main = &findings.main;
    assert!(main.verdict.passed && !main.provisional, "{:?}", main.verdict);
    let names: Vec<String> = main.parameters.iter().map(|own| own.name()).collect();
    let expected = "dry_k[PTFE] lubrication_log inertial_prefactor film_scale delta_c_over_roughness";
    names.join(" ").reads(expected);
    let posterior = findings.posterior.as_ref().expect("sampled");
    for own in &main.parameters {
        assert_eq!(own.source, Source::Posterior, "{own:?}");
        let mut all = posterior.parameters.iter().chain(&posterior.derived);
        let summary = all.find(|summary| summary.name == own.name()).expect("summarised");
        assert_eq!((own.number.value, own.number.se), (summary.mean, summary.sd));
        let (lo, hi) = summary.q025.zip(summary.q975).expect("quantiles");
        let [low, high] = own.number.interval.expect("an interval");
        assert!((low - lo).abs() < 1e-12 && (high - hi).abs() < 1e-12, "{own:?}");
    }
    let of_posterior = ["thin", "thick"].map(|liquid| (Source::Posterior, Some(liquid)));
    let expected = [&[(Source::SquareRootLaw, None)][..], &of_posterior].concat();
    for film_ratio in [0.04, 0.1] {
        assert_eq!(sources(&findings, film_ratio), expected);
    }
    let [_, law] = &main.places[0];
    let mut rows = findings.scaling.iter();
    let row = rows.find(|row| row.law == WetLaw::Sqrt && row.film_ratio == law.of.film_ratio);
    let row = row.expect("fitted");
    assert_eq!(law.number.value, row.estimates[StC].value);
    assert_eq!(law.number.interval, row.estimates[StC].interval);
    assert_eq!(law.number.method, "percentile");
}

/// Four rebounds at each film ratio: the law's two degrees of freedom do not tell its spread.
#[test]
fn e_inf_of_few_degrees_of_freedom_comes_from_the_posterior_alone() {
    let few = scene_text()
        .replace("repeats = 4", "repeats = 1")
        .replace("PTFE = [3.175, 8.0]", "PTFE = [4.762]")
        .replace("liquids = [\"thin\", \"thick\"]", "liquids = [\"thin\"]");
    let place = Place::new(&few);
    let table = place.draw(seed_of("e_inf_of_few_degrees_of_freedom"), None);
    let alone = findings::fit_least_squares(&place.scene, &table, 1, true);
    // without a posterior the ± is as wide as Student's interval
    let numbers = alone.main.places.iter().flatten();
    let of_law = numbers.filter(|row| row.source == Source::SquareRootLaw && row.number.method == "delta");
    let width = |estimate: &Estimate| {
        let [lo, hi] = estimate.interval.expect("an interval");
        0.5 * (hi - lo) / estimate.se.expect("a standard error")
    };
    let widths: Vec<f64> = of_law.map(|row| width(&row.number)).collect();
    let is_wide = |width: &f64| (width - 1.959_964).abs() < 1e-5;
    assert!(!widths.is_empty() && widths.iter().all(is_wide), "{widths:?}");
    assert!(width(&alone.square_root().estimates[EInf]) > 2.5);
    let sampled = fit(&few, |_| table);
    assert_from_posterior(&sampled, &[0.04, 0.1]);
}

#[test]
fn what_follows_from_a_held_parameter_has_a_value_and_no_interval() {
    let scene = scene_text().replace("[truth]", "[priors]\nlubrication_log = { fixed = 1.85 }\n[truth]");
    let findings = simulated("what_follows_from_a_held_parameter", &scene);
    let held = findings.main_number("delta_c_over_roughness");
    assert!((held.number.value.expect("a value") - 1.85f64.exp()).abs() < 1e-9);
    assert_eq!((held.number.se, held.number.interval), (None, None));
    assert!(held.number.why_none.is_some());
}

/// Where a scene sets a prior, what the runs say without it is held against it, whatever its family.
#[test]
fn a_prior_of_any_kind_is_held_against_the_runs() {
    let fit = |key: &str, prior: &str| {
        let scene = scene_text().replace("[truth]", &format!("[priors]\n{key} = {{ {prior} }}\n[truth]"));
        simulated("a_prior_of_any_kind", &scene)
    };
    let own = |findings: &Findings, key: &str| {
        let mut all = findings.main.parameters.iter();
        all.find(|own| own.quantity == key).map(|own| own.prior_led)
    };
    for [key, symbol, prior] in table_of(
        "lubrication_log | L:  | uniform = [2.2, 4.0]
         lubrication_log | L:  | fixed = 2.3
         dry_k | k of  | normal = [0.15, 0.001]
         sigma_wet | σ_wet:  | lognormal = [0.002, 0.1]
         sigma_dry | σ_dry:  | fixed = 0.1",
    ) {
        let findings = fit(key, prior);
        let check = findings.check("prior_conflict");
        let is_quoted = findings.main.verdict.passed;
        let is_held = findings.forbids("prior_conflict") && !is_quoted;
        assert!(is_held, "{key} {prior}: {check:?}");
        // what follows from it comes after it
        let first = findings.checks().find(|check| !check.passed && check.gates());
        assert_eq!(first.map(|check| check.code), Some("prior_conflict"), "{key} {prior}");
        check.text.begins(symbol);
        assert_ne!(own(&findings, key), Some(true), "{key} {prior}");
    }
    // its tails let the runs lead
    let heavy = fit("lubrication_log", "student_t = [3.0, 4.0, 0.02]");
    let check = heavy.check("prior_conflict");
    let is_quoted = heavy.main.verdict.passed;
    assert!(!check.passed && !check.gates() && is_quoted, "{check:?}");
    assert_eq!(own(&heavy, "lubrication_log"), Some(false));
    for [key, prior] in table_of(
        "lubrication_log | uniform = [0.5, 4.0]
         lubrication_log | fixed = 1.85
         dry_k | normal = [0.183, 0.001]",
    ) {
        let findings = fit(key, prior);
        let holds = findings.made("prior_conflict").is_none_or(|check| check.passed);
        assert!(holds && findings.main.verdict.passed, "{key} {prior}");
    }
}

#[test]
fn one_liquid_is_named_by_the_law() {
    let scene = scene_text().replace("[\"thin\", \"thick\"]", "[\"thick\"]");
    let findings = simulated("one_liquid_is_named_by_the_law", &scene);
    let both = [Source::SquareRootLaw, Source::Posterior].map(|source| (source, Some("thick")));
    assert_eq!(sources(&findings, 0.1), both);
}

/// At each of these film ratios, of which there must be some.
fn assert_from_posterior(findings: &Findings, film_ratios: &[f64]) {
    assert!(!film_ratios.is_empty());
    for ratio in film_ratios {
        let of = sources(findings, *ratio);
        let is_own = |(source, liquid): &(Source, Option<&str>)| *source == Source::Posterior && liquid.is_some();
        assert!(!of.is_empty() && of.iter().all(is_own), "{ratio}: {of:?}");
    }
}

#[test]
fn stuck_runs_noise_on_the_energy_errors_and_liquids_that_differ_leave_the_posterior_alone() {
    let stuck = scene_text().replace("viscosity_mPa_s = 20", "viscosity_mPa_s = 48.3");
    let findings = simulated("stuck", &stuck);
    let laws = findings.scaling.iter().filter(|row| row.stuck > 0);
    assert_from_posterior(&findings, &Vec::from_iter(laws.filter_map(|row| row.film_ratio)));
    let both = scene_text().replace("\n[sampler]", "\nnoise = \"both\"\n[sampler]");
    // an integral a run
    let both = both
        .replace("repeats = 4", "repeats = 2")
        .replace("warmup = 300\ndraws = 300", "chains = 2\nwarmup = 200\ndraws = 100");
    let findings = simulated("both", &both);
    assert_from_posterior(&findings, &[0.04, 0.1]);
    let thick = "density_kg_m3 = 930\nviscosity_mPa_s = 20";
    let differ = scene_text().replacen(thick, &thick.replace("930", "1400"), 1);
    let findings = simulated("differ", &differ);
    let biased = |row: &&Scaling| row.bias_in_se().is_some_and(|bias| bias > 0.25);
    let laws = findings.scaling.iter().filter(|row| row.law == WetLaw::Sqrt);
    // a density ratio that differs biases the law
    let ratios: Vec<f64> = laws.filter(biased).filter_map(|row| row.film_ratio).collect();
    assert_from_posterior(&findings, &ratios);
}

#[test]
fn without_a_posterior_least_squares_stands_in_and_is_called_provisional() {
    let place = Place::new(&scene_text());
    let table = place.draw(seed_of("provisional"), None);
    let findings = findings::fit_least_squares(&place.scene, &table, 1, false);
    let main = &findings.main;
    assert!(main.provisional);
    let of: Vec<Source> = main.parameters.iter().map(|own| own.source).collect();
    assert_eq!(of[0], Source::DryLaw);
    assert!(of[1..].iter().all(|source| *source == Source::EnergyBalance), "{of:?}");
    let laws = main.places.iter().map(|[e_inf, _]| e_inf.source);
    assert_eq!(laws.collect::<Vec<_>>(), [Source::SquareRootLaw; 2]);
}

/// Fits dry runs whose e is that of a diameter and a speed, and a residual.
fn fit_dry(of: impl Fn(f64, f64) -> f64) -> Findings {
    let mut csv = HEADER.to_owned();
    // fixed patterns of residuals with sd 0.009 and no trend, of either diameter its own
    let residuals = [0.009, -0.011, 0.004, -0.007, 0.005];
    for (diameter, sign) in [(3.175, 1.0), (8.0, -1.0)] {
        for speed in [0.4, 0.8, 1.2, 1.6, 2.0] {
            for residual in residuals {
                let e = of(diameter, speed) + sign * residual;
                csv.push_str(&format!("PTFE,dry,{diameter},,{speed},{e:.4}\n"));
            }
        }
    }
    Place::new(&scene_text()).fit_rows(&csv)
}

#[test]
fn dry_runs_of_two_k_or_of_another_law_gate() {
    let one = fit_dry(|_, v| 1.0 - 0.183 * v.powf(0.2));
    assert!(one.main.verdict.passed, "{:?}", one.main.verdict);
    assert!(one.check("dry_law_holds").passed);
    let two = fit_dry(|diameter, v| 1.0 - if diameter > 5.0 { 0.19 } else { 0.175 } * v.powf(0.2));
    assert!(two.forbids("one_dry_k_for_all_diameters") && !two.main.verdict.passed);
    let advice = &two.check("one_dry_k_for_all_diameters").next_step;
    advice.says("dry_k = \"diameter\"");
    two.main.verdict.reason.says("one k for all diameters");
    // a restitution that rises with v, as that of a marble on two sheets of paper
    let rising = fit_dry(|_, v| 0.44 + 0.02 * v);
    assert!(rising.forbids("dry_law_holds") && !rising.main.verdict.passed);
    rising.check("dry_law_holds").text.says("scatter at each speed");
}

/// The runs of the example, with a truth of this form; C is that of the formula as derived.
fn table_of_form(inertia: Inertia) -> String {
    let prefactor = if inertia == Inertia::Saturating {
        "= 0.47"
    } else {
        "= 1.0"
    };
    scene_text()
        .replace("[model]\ninertia = \"saturating\"", "[model]")
        .replace("= 0.47", prefactor)
        .replace("saturating", inertia.name())
        .replace("[0.04, 0.1]", "[0.03, 0.06, 0.09, 0.12, 0.15]")
        .replace("repeats = 4", "repeats = 6")
}

/// The same with 135 runs.
fn small_table_of_form(inertia: Inertia) -> String {
    table_of_form(inertia)
        .replace("PTFE = [3.175, 8.0]", "PTFE = [3.175]")
        .replace("repeats = 6", "repeats = 3")
}

/// e_inf of the scene's truth at a film ratio.
fn true_e_inf(place: &Place, film_ratio: f64) -> f64 {
    let truth = place.scene.truth.as_ref().expect("the scene has one");
    let film = Film {
        film_ratio,
        density_ratio: 930.0 / 2150.0,
    };
    truth.wetted(0.183, film, 2.0).expect("complete").e_inf
}

/// How often least squares took the form of the truth, or one that predicts within its error: e_inf of every film ratio
/// within 3 of its standard errors.
fn as_good_forms(scene: &str, inertia: Inertia, sets: u64) -> usize {
    let place = Place::new(scene);
    let is_as_good = study("the_form_that_fits_is_chosen", sets, |seed| {
        let findings = place.infer(seed);
        let balance = findings.balance();
        let is_near = |row: &DerivedEstimate| {
            let (value, se) = row.estimates[EInf].pair().expect("a ±");
            (value - true_e_inf(&place, row.film_ratio)).abs() < 3.0 * se
        };
        [balance.inertia == inertia || balance.derived.iter().all(is_near)]
    });
    counts(&is_as_good)[0]
}

#[test]
#[ignore = "slow: fits 900 tables, most of them in four forms"]
fn the_form_that_fits_is_chosen() {
    const SETS: u64 = 100;
    for inertia in [Inertia::Stepwise, Inertia::Cap, Inertia::Saturating, Inertia::None] {
        for scene in [table_of_form(inertia), small_table_of_form(inertia)] {
            let found = as_good_forms(&scene, inertia, SETS);
            // 135 runs do not always tell the saturating form
            let is_hard = inertia == Inertia::Saturating && scene.contains("repeats = 3");
            let share = if is_hard { 0.85 } else { 0.95 };
            assert!(found as f64 >= share * SETS as f64, "{}: {found}", inertia.name());
        }
    }
    // the planted fault: cap only where it gains four standard errors, which is never
    let named = table_of_form(Inertia::Cap).replace("[model]", "[model]\ninertia = \"stepwise\"");
    let found = as_good_forms(&named, Inertia::Cap, SETS);
    assert!(found as f64 <= 0.90 * SETS as f64, "{found}");
}

/// Which share of the main intervals hold the truth, of k, L, C, e_inf and St_c, over tables of a scene.
fn covered_main_numbers(scene: &str, sets: u64) -> [f64; 5] {
    let place = Place::new(scene);
    let truth = place.scene.truth.as_ref().expect("the scene has one");
    let prefactor = truth.value(Coefficient::InertialPrefactor).expect("the scene has one");
    let of_set = |seed: u64| {
        let table = place.table(seed);
        let mut findings = findings::fit_least_squares(&place.scene, &table, seed, true);
        sample_as_usual(&mut findings, &place.scene, &table.runs);
        let is_held = |number: &Estimate, truth: f64| {
            assert!(number.interval.is_some(), "{number:?}");
            holds(number.interval, truth)
        };
        let of = |name: &str, truth: f64| vec![is_held(&findings.main_number(name).number, truth)];
        let at = |which: usize, truth_of: fn(f64) -> f64| {
            let places = findings.main.places.iter();
            let held = places.map(|numbers| {
                let e_inf = true_e_inf(&place, numbers[which].of.film_ratio.expect("a film"));
                is_held(&numbers[which].number, truth_of(e_inf))
            });
            held.collect()
        };
        [
            of("dry_k[PTFE]", 0.183),
            of("lubrication_log", 1.85),
            of("inertial_prefactor", prefactor),
            at(0, |e_inf| e_inf),
            at(1, |e_inf| 2.0 * 1.85 / (e_inf * e_inf)),
        ]
    };
    let outcomes = study("main_numbers_cover_with_the_form_left_open", sets, of_set);
    std::array::from_fn(|which| {
        let all: Vec<bool> = outcomes.iter().flat_map(|set| set[which].iter().copied()).collect();
        all.iter().filter(|held| **held).count() as f64 / all.len() as f64
    })
}

#[test]
#[ignore = "samples four forms of 40 tables: a quarter of a minute"]
fn main_numbers_cover_with_the_form_left_open() {
    const SETS: u64 = 20;
    for inertia in [Inertia::Stepwise, Inertia::Cap] {
        let shares = covered_main_numbers(&small_table_of_form(inertia), SETS);
        for (share, name) in shares.into_iter().zip(["k", "L", "C", "e_inf", "St_c"]) {
            // of 300 tables: k 95 %, L 96 to 98 %, C 93 % of stepwise and 89 % of cap, since C is another one in the other form;
            // places of one table are as good as one
            let least = if name == "C" { 0.89 } else { 0.95 };
            let z = (share - least) / (least * (1.0 - least) / SETS as f64).sqrt();
            assert!(z > -4.0, "{} {name}: {share}: {z}", inertia.name());
        }
    }
    // the planted fault: stepwise whatever the runs say
    let named = small_table_of_form(Inertia::Cap).replace("[model]", "[model]\ninertia = \"stepwise\"");
    let [_, _, of_c, ..] = covered_main_numbers(&named, SETS);
    assert!(of_c < 0.1, "{of_c}");
}

/// The interval quoted for k covers, however few dry runs there are.
#[test]
#[ignore = "slow: run with --ignored"]
fn intervals_of_few_dry_runs_cover() {
    const SETS: u64 = 200;
    let seed = seed_of("intervals_of_few_dry_runs_cover");
    let covered = |scene: &str, speeds: &[f64]| {
        let place = Place::new(scene);
        let of_set = |set: &u64| {
            let mut rng = stream(seed, "few dry runs", *set);
            let mut csv = HEADER.to_owned();
            for v in speeds {
                let z = normal(&mut rng);
                let e = 1.0 - 0.183 * v.powf(0.2) + 0.01 * z;
                csv.push_str(&format!("PTFE,dry,4.762,,{v},{e:.6}\n"));
            }
            let found = findings::fit_least_squares(&place.scene, &place.read_rows(&csv), *set, true);
            holds(found.dry[0].dry_k.interval, 0.183)
        };
        binomial_z((0..SETS).filter(of_set).count(), SETS as usize, 0.95)
    };
    let designs: [&[f64]; 5] = [
        &[0.5, 1.0, 2.0],
        &[0.5, 1.0, 1.5, 2.0],
        &[0.5, 0.9, 1.2, 1.6, 2.0],
        &[0.5, 0.5, 1.0, 1.0, 2.0, 2.0],
        &[0.5, 0.5, 1.0, 1.0, 1.5, 1.5, 2.0, 2.0],
    ];
    for speeds in designs {
        let z = covered(&scene_text(), speeds);
        assert!(z > -4.0, "{speeds:?}: {z}");
    }
    // the planted fault: percentiles of three dry runs
    let named = scene_text().replace("[bootstrap]", "[bootstrap]\ninterval = \"percentile\"");
    let z = covered(&named, designs[0]);
    assert!(z < -8.0, "{z}");
}
