//! Holds that no single run carries a main number unseen, and that barely rebounding runs are not taken at their word.

use crate::common::scenes::{scene_of, HEADER, PE, THIN};
use crate::common::{counts, normal, sample, seed_of, study, Place, Says, Told};
use wetcor::findings::estimates::Source;
use wetcor::findings::remarks::in_order;
use wetcor::findings::Findings;
use wetcor::seed::stream;

fn scene_text() -> String {
    scene_of(
        "single runs",
        &[PE, THIN, "[liquids.thick]\ndensity_kg_m3 = 965\nviscosity_mPa_s = 48\n"],
    ) + r#"[model]
inertia = "stepwise"
[sampler]
chains = 2
warmup = 200
draws = 200
"#
}

const K: f64 = 0.12;
const L: f64 = 1.85;
const C: f64 = 0.8;
const SIGMA: f64 = 0.015;
const DIAMETER: f64 = 4.762e-3;
const FILM_RATIOS: [f64; 2] = [0.05, 0.1];

/// Density and viscosity of a liquid, SI.
fn of_liquid(thick: bool) -> (&'static str, f64, f64) {
    [("thin", 930.0, 0.0093), ("thick", 965.0, 0.048)][usize::from(thick)]
}

/// e_inf² of a liquid at a film ratio, and what the viscous loss takes of it at 1 m/s.
fn law(thick: bool, film_ratio: f64) -> (f64, f64) {
    let (_, density, viscosity) = of_liquid(thick);
    let e_dry = 1.0 - K * 2f64.powf(0.2);
    let shape = film_ratio * (3.0 - 6.0 * film_ratio + 4.0 * film_ratio * film_ratio);
    let at_infinity = e_dry * e_dry - C * density / 940.0 * shape;
    (at_infinity, 4.0 * L * 9.0 * viscosity / (940.0 * DIAMETER))
}

fn line(thick: bool, film_ratio: f64, speed: f64, e: f64) -> String {
    let (name, ..) = of_liquid(thick);
    format!("PE,{name},4.762,{:.3},{speed:.5},{e:.5}\n", 1e6 * film_ratio * DIAMETER)
}

/// Runs as the model has them: 9 dry, and 2 of each liquid, film ratio and speed; runs that fall short stick.
fn table(name: &str, speeds: &[f64]) -> String {
    let mut rng = stream(seed_of(name), name, 0);
    let mut normal = move || normal(&mut rng);
    let mut rows = HEADER.to_owned();
    for v in [0.5f64, 1.0, 2.0] {
        for _ in 0..3 {
            rows += &format!("PE,dry,4.762,,{v},{:.5}\n", 1.0 - K * v.powf(0.2) + 0.009 * normal());
        }
    }
    for thick in [false, true] {
        for film_ratio in FILM_RATIOS {
            for speed in speeds {
                for _ in 0..2 {
                    let (at_infinity, lost) = law(thick, film_ratio);
                    let kept = at_infinity - lost / speed;
                    let e = if kept > 0.0 { kept.sqrt() } else { -1.0 } + SIGMA * normal();
                    rows += &line(thick, film_ratio, *speed, e.max(0.0));
                }
            }
        }
    }
    rows
}

/// The speed at which a run keeps so much.
fn speed_of(thick: bool, film_ratio: f64, e: f64) -> f64 {
    let (at_infinity, lost) = law(thick, film_ratio);
    lost / (at_infinity - e * e)
}

/// The usual rows, and one of the thick liquid that keeps so little, its speed written too large by a factor.
fn with_slow(e: f64, factor: f64) -> String {
    table("a_barely_rebounding_run", &SPEEDS) + &line(true, 0.1, factor * speed_of(true, 0.1, e), e)
}

/// How the last of some rows is named.
fn last_of(rows: &str) -> String {
    format!("runs.csv, line {} ", rows.lines().count())
}

fn fit(rows: &str) -> Findings {
    fit_with(&scene_text(), rows)
}

fn fit_with(scene: &str, rows: &str) -> Findings {
    let place = Place::new(scene);
    let mut findings = place.fit_rows(rows);
    sample(&mut findings, &place.scene, &place.read().runs);
    findings
}

/// The place of a notice among all by weight, and its text.
fn told(findings: &Findings, code: &str) -> Option<(usize, String)> {
    let all = in_order(&findings.remarks);
    let place = all.iter().position(|notice| notice.code == code)?;
    Some((place, all[place].text.clone()))
}

/// How many of its sds St_c of the thick liquid in the thicker film is off.
fn z(findings: &Findings) -> f64 {
    let is_thicker = |ratio: Option<f64>| ratio.is_some_and(|ratio| (ratio - 0.1).abs() < 1e-3);
    let mut places = findings.main.places.iter();
    let here = places.find(|[_, st_c]| st_c.of.liquid.as_deref() == Some("thick") && is_thicker(st_c.of.film_ratio));
    let own = &here.expect("a place")[1].number;
    (own.value.expect("a mean") - 2.0 * L / law(true, 0.1).0) / own.se.expect("an sd")
}

const SPEEDS: [f64; 4] = [0.9, 1.2, 1.6, 2.2];

#[test]
fn a_barely_rebounding_run_is_not_taken_at_its_word() {
    let rows = with_slow(0.03, 1.02);
    let with = fit(&rows);
    let (place, text) = told(&with, "slow_rebounds").expect("told");
    assert!(place == 0, "{place}");
    text.says(&last_of(&rows));
    text.says("e = 0.030");
    assert!(z(&with).abs() < 3.0, "{}", z(&with));
    let posterior = with.posterior.as_ref().expect("sampled");
    assert!(posterior.parameters.iter().any(|own| own.name == "sigma_energy"));
    // at its word: the same table where a scene says how well speeds and energies are known
    let known = scene_text() + "[priors]\nsigma_energy = { lognormal = [1e-5, 0.1] }\n";
    let taken = fit_with(&known, &rows);
    assert!(z(&taken).abs() > 4.0, "{}", z(&taken));
    assert!(told(&taken, "slow_rebounds").is_none());
    // nothing is said where no run rebounds barely
    let fast = fit(&with_slow(0.4, 1.0));
    assert!(told(&fast, "slow_rebounds").is_none());
    let posterior = fast.posterior.as_ref().expect("sampled");
    assert!(posterior.parameters.iter().all(|own| own.name != "sigma_energy"));
}

/// A row that no error of a few per cent explains: with noise on the energy its number moves and is known better, which is no
/// care taken. The test above has the row for which it is taken.
#[test]
fn nothing_is_quoted_where_allowing_for_errors_leaves_a_number_no_less_well_known() {
    let with = fit(&with_slow(0.03, 0.85));
    let check = with.check("slow_rebounds");
    assert!(!check.passed && check.gates(), "{check:?}");
    check.text.says("not known less well");
    let posterior = with.posterior.as_ref().expect("sampled");
    assert!(posterior.parameters.iter().all(|own| own.name != "sigma_energy"));
}

/// Runs that stuck may not have been logged, or noise may fall by another length above than below: the same holds.
#[test]
#[ignore = "slow: run with --ignored"]
fn no_sticking_and_no_noise_takes_a_barely_rebounding_run_at_its_word() {
    let rows = with_slow(0.03, 1.02);
    let of = |key: &str| fit_with(&scene_text().replace("[model]", &format!("[model]\n{key}")), &rows);
    let truncated = of("sticking = \"truncated\"");
    told(&truncated, "slow_rebounds").expect("told");
    assert!(z(&truncated).abs() < 3.0, "{}", z(&truncated));
    let two_slopes = of("likelihood = \"asymmetric_laplace\"");
    let check = two_slopes.check("slow_rebounds");
    assert!(!check.passed && check.gates(), "{check:?}");
    check.text.says("without them");
}

/// The same of more runs than a posterior with such noise is sampled of unasked; and a scene that names the noise is believed.
#[test]
#[ignore = "slow: run with --ignored"]
fn many_runs_carry_barely_rebounding_ones_no_better() {
    let speeds: Vec<f64> = (0..80).map(|step| 0.9 + 0.02 * f64::from(step)).collect();
    let mut rows = table("many_runs_carry", &speeds);
    // their speeds written 1.5 % too large
    for step in 0..12 {
        let e = 0.02 + 0.005 * f64::from(step);
        rows += &line(true, 0.1, 1.015 * speed_of(true, 0.1, e), e);
    }
    let with = fit(&rows);
    told(&with, "slow_rebounds").expect("told").1.says("noise = \"both\"");
    assert!(z(&with).abs() < 3.0, "{}", z(&with));
    let named = scene_text().replace("[model]", "[model]\nnoise = \"restitution\"");
    let believed = fit_with(&named, &rows);
    told(&believed, "slow_rebounds")
        .expect("told")
        .1
        .says("taken at their word");
    assert!(z(&believed).abs() > 4.0, "{}", z(&believed));
}

/// With Student's tails the integrals over noise on the energy would take minutes of as many runs: runs that barely rebound are
/// held against the posterior without them, and refused where they move a number by more than its ±.
#[test]
fn many_runs_of_heavy_tails_are_quoted_only_where_barely_rebounding_ones_move_nothing() {
    let scene = scene_text().replace("[model]", "[model]\nlikelihood = \"student\"");
    // none of these rebounds barely
    let speeds: Vec<f64> = (0..80).map(|step| 1.5 + 0.02 * f64::from(step)).collect();
    let rows = table("many_runs_of_heavy_tails", &speeds);
    let fit = |slow: String| {
        let place = Place::new(&scene);
        let mut findings = place.fit_rows(&(rows.clone() + &slow));
        findings.made("slow_rebounds").expect("some rebound barely");
        sample(&mut findings, &place.scene, &place.read().runs).expect("sampled");
        findings
    };
    // their speeds written 1.5 % too large
    let errs = |step: i32| {
        let e = 0.02 + 0.005 * f64::from(step);
        line(true, 0.1, 1.015 * speed_of(true, 0.1, e), e)
    };
    let refused = fit((0..12).map(errs).collect());
    let check = refused.check("slow_rebounds");
    assert!(
        !check.passed && check.gates() && !refused.main.verdict.passed,
        "{check:?}"
    );
    check.text.says("without them");
    assert!(z(&refused).abs() > 4.0, "{}", z(&refused));
    // one that is right, and keeps enough to weigh no more than a few of the others
    let quoted = fit(line(true, 0.1, speed_of(true, 0.1, 0.14), 0.14));
    assert!(told(&quoted, "slow_rebounds").is_none());
    assert!(quoted.main.verdict.passed && z(&quoted).abs() < 3.0, "{}", z(&quoted));
    for found in [&refused, &quoted] {
        let posterior = found.posterior.as_ref().expect("sampled");
        assert!(posterior.parameters.iter().all(|own| own.name != "sigma_energy"));
    }
}

/// Least squares knows no noise on the energy: until the posterior is sampled, what such a run pins is not quoted.
#[test]
fn least_squares_alone_quotes_nothing_that_a_barely_rebounding_run_pins() {
    let rows = with_slow(0.03, 1.02);
    let found = Place::new(&scene_text()).fit_rows(&rows);
    let check = found.check("slow_rebounds");
    assert!(!check.passed && !found.main.verdict.passed, "{check:?}");
    check.text.says(&last_of(&rows));
    check.next_step.says("sample the posterior");
    // one that rebounds well is no such run
    let found = Place::new(&scene_text()).fit_rows(&with_slow(0.4, 1.02));
    assert!(found.made("slow_rebounds").is_none());
    assert!(found.main.verdict.passed, "{:?}", found.main.verdict);
}

/// The table of a barely rebounding run with one column more, of which `cell` makes the cells from the speeds.
fn with_column(name: &str, slow: f64, cell: impl Fn(f64) -> String) -> String {
    let rows = table("a_barely_rebounding_run", &SPEEDS) + &line(true, 0.1, slow, 0.03);
    let mut text = format!("{},{name}\n", HEADER.trim_end());
    for row in rows.lines().skip(1) {
        let speed = row.split(',').nth(4).and_then(|cell| cell.parse().ok());
        text += &format!("{row},{}\n", cell(speed.expect("a speed")));
    }
    text
}

/// A column that says how well e is measured says nothing of speeds and films.
#[test]
fn an_error_of_the_restitution_excuses_no_barely_rebounding_run() {
    let rows = with_column("restitution_sd", 1.02 * speed_of(true, 0.1, 0.03), |_| {
        "0.001".to_owned()
    });
    let found = Place::new(&scene_text()).fit_rows(&rows);
    let check = found.check("slow_rebounds");
    assert!(!check.passed && check.gates(), "{check:?}");
}

/// Where a column tells the errors of speeds, what films err by is an error of the restitution: noise on the energy besides
/// would take minutes.
#[test]
fn errors_of_speeds_beside_a_barely_rebounding_run_leave_its_film_to_err() {
    let slow = speed_of(true, 0.1 * 1.04, 0.03);
    let with = fit(&with_column("impact_speed_sd_m_s", slow, |v| {
        format!("{:.5}", 0.001 * v)
    }));
    let text = told(&with, "slow_rebounds").expect("told").1;
    text.says("as errors of their restitutions");
    assert!(z(&with).abs() < 3.0, "{}", z(&with));
    let posterior = with.posterior.as_ref().expect("sampled");
    assert!(posterior.parameters.iter().all(|own| own.name != "sigma_energy"));
}

/// Holds that a run which keeps less than expected is named among the first, and ten that carry the number together are not.
fn assert_one_is_named(
    rows: &str,
    (expected, far): (f64, impl Fn(f64) -> String),
    told: impl Fn(&Findings) -> Option<(usize, String)>,
) {
    let one = format!("{rows}{}", far(expected - 0.06));
    let (place, text) = told(&fit(&one)).expect("told");
    assert!(place < 3, "{place}");
    text.says(&last_of(&one));
    let many = (0..10).map(|run| far(expected + 0.015 * f64::from(run % 3 - 1)));
    let named = told(&fit(&format!("{rows}{}", many.collect::<String>())));
    assert!(named.is_none(), "{named:?}");
}

#[test]
fn a_run_that_carries_a_number_is_named_among_the_first() {
    // all wet runs but one at nearly one speed: what speed does, that one says
    let rows = table("a_run_that_carries_a_number", &[2.1, 2.2]);
    let far = |e: f64| line(false, 0.05, 0.35, e);
    let (at_infinity, lost) = law(false, 0.05);
    let expected = (at_infinity - lost / 0.35).sqrt();
    assert_one_is_named(&rows, (expected, far), |found| told(found, "single_run"));
}

#[test]
fn an_outlier_that_carries_a_number_forbids_quoting() {
    let rows = table("an_outlier_that_carries_a_number", &SPEEDS);
    let forbids = |e: f64| {
        let one = format!("{rows}{}", line(true, 0.1, speed_of(true, 0.1, 0.6), e));
        fit(&one).forbids("carrying_outlier")
    };
    assert!(forbids(0.2) && !forbids(0.58));
}

/// Two runs alone in a thick film, of which one is wrong.
#[test]
fn of_two_runs_that_disagree_both_are_named_where_the_others_do_not_tell_which() {
    let (at_infinity, lost) = law(false, 0.15);
    let expected = (at_infinity - lost / 1.5).sqrt();
    let with_neighbour = |off: [f64; 2]| {
        let sets = study("of_two_runs_that_disagree", 12, |seed| {
            let speeds = [0.5, 0.5, 0.7, 0.7, 1.0, 1.0, 1.4, 1.4, 2.0, 2.0];
            let rows = table(&format!("of_two_runs_that_disagree {seed}"), &speeds);
            let is_thin = |row: &&str| !row.contains(",thick,") && !row.contains(",476.200,");
            let mut rows: String = rows.split_inclusive('\n').filter(is_thin).collect();
            rows.extend(off.map(|off| line(false, 0.15, 1.5, expected + off)));
            let found = Place::new(&scene_text()).fit_rows(&rows).noise.expect("it scatters");
            let mut outliers = found.outliers.iter();
            let both = outliers.any(|outlier| outlier.place.contains("do not tell which"));
            [found.outliers_found > 0, both]
        });
        counts(&sets)
    };
    let [found, both] = with_neighbour([0.08, -0.08]);
    assert!(found >= 10 && both >= 3, "{found} {both}");
    let [found, both] = with_neighbour([0.0, -0.15]);
    assert!(found >= 10 && both == 0, "{found} {both}");
}

#[test]
fn a_run_that_carries_a_square_root_law_is_named() {
    // of one liquid, sixteen runs a film ratio at nearly one speed, and one far from them
    let rows = table(
        "a_run_that_carries_a_law",
        &[1.85, 1.9, 1.95, 2.0, 2.05, 2.1, 2.15, 2.2],
    );
    let one_liquid = rows.split_inclusive('\n').filter(|row| !row.contains(",thin,"));
    let rows: String = one_liquid.collect();
    let expected = 0.4;
    let slow = speed_of(true, 0.05, expected);
    let of_law = |found: &Findings| {
        let mut rows = found.main.rows();
        let is_law = rows.any(|row| row.source == Source::SquareRootLaw && row.of.film_ratio < Some(0.06));
        assert!(is_law, "{:?}", found.main.places);
        told(found, "single_run").filter(|(_, text)| text.contains("δ/D = 0.05, square-root law"))
    };
    let far = |e: f64| line(true, 0.05, slow, e);
    assert_one_is_named(&rows, (expected, far), of_law);
}
