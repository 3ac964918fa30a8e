//! Holds how results move with the constants taken as exact, and what that adds to their error.

use crate::common::scenes::{scene_of, AK10, DESIGN, M50, PTFE, SATURATING};
use crate::common::{seed_of, Place, Says, Told};
use crate::degenerate;
use wetcor::findings::constants::Sensitivity;
use wetcor::findings::{self, Findings};
use wetcor::runs::{Runs, Table};
use wetcor::scene::Scene;

fn scene_text() -> String {
    scene_of("constants", &[PTFE, AK10, M50, SATURATING, DESIGN, "repeats = 3\n"])
}

/// The sds that are given, as lines below `[data]`, the particle's and each liquid's density.
fn with_sds([data, particle, ak10, m50]: [&str; 4]) -> String {
    scene_text()
        .replace("[data]", &format!("[data]\n{data}"))
        .replace("roughness_um = 5", &format!("roughness_um = 5\n{particle}"))
        .replace("viscosity_mPa_s = 9.3", &format!("viscosity_mPa_s = 9.3\n{ak10}"))
        .replace("viscosity_mPa_s = 48.3", &format!("viscosity_mPa_s = 48.3\n{m50}"))
}

fn all_given() -> String {
    with_sds([
        "film_sd_um = 4",
        "density_rel_sd = 0.01\nroughness_rel_sd = 0.02",
        "density_rel_sd = 0.02\nviscosity_rel_sd = 0.03",
        "viscosity_rel_sd = 0.02",
    ])
}

/// A result and the fit it is from, whatever the film ratio is.
fn row<'f>(findings: &'f Findings, result: &str, fit: &str) -> &'f Sensitivity {
    let mut rows = findings.constants.iter();
    let found = rows.find(|row| row.result == result && row.fit == fit);
    found.unwrap_or_else(|| panic!("no {result} by {fit}"))
}

/// What is not told does not move.
fn elasticity(row: &Sensitivity, constant: &str) -> f64 {
    let found = row.by.iter().find(|moves| moves.constant == constant);
    found.map_or(0.0, |moves| moves.elasticity)
}

const RESULTS: [(&str, &str); 8] = [
    ("lubrication_log", "balance"),
    ("inertial_prefactor", "balance"),
    ("film_scale", "balance"),
    ("delta_c_m", "balance"),
    ("e_inf", "balance"),
    ("st_c", "balance"),
    ("e_inf", "sqrt"),
    ("st_c", "sqrt"),
];

/// Where the law is only a function of η/ρp, C ρl/ρp, δ/δ̃0 and ε exp(L), all of a kind at once move the results by known
/// powers: the largest distance from these.
fn worst_of_known(findings: &Findings) -> f64 {
    let l = row(findings, "lubrication_log", "balance").value;
    let known = [
        ("viscosity", [-1.0, 0.0, 0.0, -l, 0.0, -1.0, 0.0, -1.0]),
        ("liquid_density", [0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ("particle_density", [1.0, 1.0, 0.0, l, 0.0, 1.0, 0.0, 1.0]),
        ("roughness", [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
    ];
    let off = |constant: &str, (result, fit): (&str, &str), expected: f64| {
        (elasticity(row(findings, result, fit), constant) - expected).abs()
    };
    let film = RESULTS.into_iter().zip([0.0, 0.0, 1.0, 0.0]);
    let mut all = Vec::from_iter(film.map(|(result, expected)| off("film", result, expected)));
    for (constant, expected) in known {
        let each = RESULTS.into_iter().zip(expected);
        all.extend(each.map(|(result, expected)| off(constant, result, expected)));
    }
    all.into_iter().fold(0.0, f64::max)
}

#[test]
fn all_of_a_kind_move_the_results_by_known_powers() {
    let seed = seed_of("all_of_a_kind_move_the_results_by_known_powers");
    for noise in ["0.02", "0.0001", "0.000001"] {
        let text = scene_text().replace("sigma_wet = 0.02", &format!("sigma_wet = {noise}"));
        let off = worst_of_known(&Place::new(&text).infer(seed));
        assert!(off < 1.5e-5, "{noise}: {off}");
    }
    let mut findings = Place::new(&scene_text()).infer(seed);
    // a sign swapped in one place is seen
    let mut moves = findings.constants[0].by.iter_mut();
    let of_viscosity = moves.find(|moves| moves.constant == "viscosity");
    of_viscosity.expect("viscosity moves L").elasticity *= -1.0;
    assert!(worst_of_known(&findings) > 1.0);
}

/// d ln(result)/d ln(constant) of every result told, by whole fits; `change` moves the constant by a share of itself.
fn by_whole_fits(scene: &Scene, table: &Table, change: Change) -> Vec<f64> {
    const STEP: f64 = 1e-4;
    let at = |share: f64| {
        let findings = changed(scene, table, |scene, runs| change(scene, runs, share));
        Vec::from_iter(findings.constants.iter().map(|row| row.value))
    };
    let both = at(STEP).into_iter().zip(at(-STEP));
    both.map(|(more, less)| (more / less).ln() / (2.0 * STEP)).collect()
}

/// Moves a constant of the scene, or the films, by a share.
type Change = fn(&mut Scene, &mut Runs, f64);

/// Whole fits of a scene and of runs whose films have changed.
fn changed(scene: &Scene, table: &Table, change: impl Fn(&mut Scene, &mut Runs)) -> Findings {
    let mut scene = scene.clone();
    let mut table = Table::of(table.runs.clone());
    change(&mut scene, &mut table.runs);
    table.runs.compute_impacts(&scene);
    findings::fit_least_squares(&scene, &table, 1, false)
}

fn mean_film(runs: &Runs) -> f64 {
    let rebounds = runs.series.iter().flat_map(|series| series.rebounds.clone());
    let films: Vec<f64> = rebounds.map(|run| runs.film[run]).collect();
    films.iter().sum::<f64>() / films.len() as f64
}

const CHANGES: [(&str, Change); 4] = [
    ("viscosity[AK10]", |scene, _, share| {
        scene.liquids[0].viscosity *= share.exp();
    }),
    ("liquid_density[M50]", |scene, _, share| {
        scene.liquids[1].density *= share.exp();
    }),
    ("film", |_, runs, share| {
        runs.film.iter_mut().for_each(|film| *film *= share.exp());
    }),
    ("film_offset", |_, runs, share| {
        let length = share * mean_film(runs);
        runs.film.iter_mut().for_each(|film| *film += length);
    }),
];

/// What all speeds share moves L as St moves, and nothing where the scene does not say that it errs.
#[test]
fn a_scale_of_all_speeds_is_a_constant_like_the_viscosity() {
    let seed = seed_of("a_scale_of_all_speeds_is_a_constant_like_the_viscosity");
    let own = "dry_speed_m_s = \"impact\"";
    let own_speed = scene_text()
        .replace("[model]", &format!("[model]\n{own}"))
        .replace("dry_speed_m_s = 2.0", own);
    let given = own_speed.replace("[data]", "[data]\nspeed_rel_sd = 0.02");
    let place = Place::new(&given);
    let table = place.draw(seed, None);
    let findings = findings::fit_least_squares(&place.scene, &table, 1, false);
    // with e_dry at each run's own speed k v^(1/5) stays as it is, so that L/St is all that moves
    for (result, expected) in [
        ("lubrication_log", 1.0),
        ("inertial_prefactor", 0.0),
        ("film_scale", 0.0),
    ] {
        let moves = elasticity(row(&findings, result, "balance"), "speed");
        assert!((moves - expected).abs() < 2.5e-5, "{result}: {moves}");
    }
    let l = row(&findings, "lubrication_log", "balance");
    let scale = |_: &mut Scene, runs: &mut Runs| runs.impact_speed.iter_mut().for_each(|speed| *speed *= 1.02);
    let moved = changed(&place.scene, &table, scale);
    let by_fit = row(&moved, "lubrication_log", "balance").value - l.value;
    let told = l.constants_sd.expect("constants err");
    assert!((told / by_fit - 1.0).abs() < 1e-3, "{told} {by_fit}");
    let exact = findings::fit_least_squares(&Place::new(&own_speed).scene, &table, 1, false);
    assert_eq!(elasticity(row(&exact, "lubrication_log", "balance"), "speed"), 0.0);
}

/// The largest distance between an elasticity told and that of whole fits, as a share of it where it is above one.
fn worst(findings: &Findings, constant: &str, by_fits: &[f64]) -> f64 {
    let rows = findings.constants.iter().zip(by_fits);
    let off = rows.map(|(row, by_fits)| (elasticity(row, constant) - by_fits).abs() / by_fits.abs().max(1.0));
    off.fold(0.0, f64::max)
}

/// A whole fit also weighs the dry runs' k anew, by the spread it finds, which moves results by some thousandths more;
/// not where k is known as well as here.
#[test]
fn elasticities_are_those_of_whole_fits() {
    let seed = seed_of("elasticities_are_those_of_whole_fits");
    let saturating = "inertia = \"saturating\"\ninertial_prefactor = 0.47\nfilm_scale = 0.069";
    let stepwise = all_given()
        .replace(saturating, "inertia = \"stepwise\"\ninertial_prefactor = 0.9")
        .replace("inertia = \"saturating\"", "inertia = \"stepwise\"");
    for text in [all_given(), stepwise] {
        let place = Place::new(&text.replace("sigma_dry = 0.009", "sigma_dry = 0.0001"));
        let table = place.draw(seed, None);
        let findings = findings::fit_least_squares(&place.scene, &table, 1, false);
        assert!(findings.constants.len() >= 7, "{:?}", findings.constants);
        for (constant, change) in CHANGES {
            let by_fits = by_whole_fits(&place.scene, &table, change);
            let off = worst(&findings, constant, &by_fits);
            assert!(off < 1e-4, "{constant}: {off} {by_fits:?}");
        }
        // one constant for another is seen
        let other = by_whole_fits(&place.scene, &table, CHANGES[0].1);
        assert!(worst(&findings, "viscosity[M50]", &other) > 0.5);
    }
}

/// That nothing else changes `reading` holds, with an example whose constants err.
#[test]
fn combined_adds_squares() {
    let seed = seed_of("combined_adds_squares_and_leaves_the_standard_error_alone");
    for row in Place::new(&all_given()).infer(seed).constants {
        let moved = row
            .by
            .iter()
            .filter_map(|own| Some(row.value * own.elasticity * own.rel_sd?));
        let variance = moved.map(|moved| moved * moved).sum::<f64>();
        let sd = row.constants_sd.expect("given");
        assert!(sd > 0.0 && (variance.sqrt() / sd - 1.0).abs() < 1e-12, "{row:?}");
        // what is too curved for a ± has no combined one
        assert_eq!(row.combined.is_some(), row.se.is_some());
        if let Some((se, combined)) = row.se.zip(row.combined) {
            assert!(
                (combined * combined / (se * se + variance) - 1.0).abs() < 1e-9,
                "{row:?}"
            );
        }
    }
}

fn notice(findings: &Findings) -> Option<&str> {
    findings.notice("constants_exact").map(|notice| notice.text.as_str())
}

#[test]
fn the_notice_names_the_largest_that_is_not_given() {
    let seed = seed_of("the_notice_names_the_largest_that_is_not_given");
    let of = |text: &str| Place::new(text).infer(seed);
    let none = of(&scene_text());
    let text = notice(&none).expect("1 % in η moves L by more than its standard error");
    text.says("viscosity of the liquids");
    let known = all_given().replace("viscosity_rel_sd = 0.02", "viscosity_rel_sd = 0.02\ndensity_rel_sd = 0");
    assert_eq!(notice(&of(&known)), None);
    let one = of(&with_sds([
        "film_sd_um = 4",
        "density_rel_sd = 0\nroughness_rel_sd = 0",
        "viscosity_rel_sd = 0",
        "",
    ]));
    notice(&one).expect("M50 is not given").says("viscosity of M50");
    // runs so uncertain that 1 % does not count
    let noisy = of(&scene_text()
        .replace("sigma_wet = 0.02", "sigma_wet = 0.08")
        .replace("repeats = 3", "repeats = 1"));
    assert!(!noisy.constants.is_empty(), "the fits still converge");
    assert_eq!(notice(&noisy), None, "{:?}", noisy.constants);
}

#[test]
fn fits_that_may_not_be_quoted_have_no_entry() {
    let restitutions = [0.60, 0.63, 0.655, 0.672, 0.682, 0.684];
    let wet = degenerate::pairs([0.7, 0.8, 1.0, 1.2, 1.4, 1.6], restitutions);
    let fits = |wet: &[(f64, f64)]| {
        let findings = degenerate::fit(wet);
        let of_constants: Vec<&str> = findings.constants.iter().map(|row| row.fit).collect();
        assert!(!of_constants.is_empty() || notice(&findings).is_none(), "{wet:?}");
        of_constants
    };
    // one liquid, one particle: L, C, δc, e_inf, St_c
    assert_eq!(fits(&wet), [["balance"; 5].as_slice(), &["sqrt"; 2]].concat());
    let rising = Vec::from_iter(wet.iter().map(|(v, e)| (*v, 1.3 - e)));
    for wet in [&rising[..], &[(0.8, 0.66), (1.6, 0.70)], &[]] {
        assert_eq!(fits(wet), [""; 0], "{wet:?}");
    }
}
