//! Holds what the fits say of simulated runs against the truth they were drawn from.

use crate::common::scenes::{design, scene_of, truth, AK10, M20, M50, PE, PTFE};
use crate::common::{assert_expected, binomial_z, counts, mean, study, Place, Told};
use wetcor::findings::estimate::Estimate;
use wetcor::findings::scaling::Scaling;
use wetcor::findings::Findings;
use wetcor::physics::Quantity::{EInf, StC};
use wetcor::scene::WetLaw;

/// Spheres well above the threshold: nothing sticks, so every formula holds as it stands.
pub fn clear() -> String {
    let model = "[model]\ninertia = \"saturating\"\n";
    let truth = truth([1.9, 0.45, 0.01, 0.02], "inertia = \"saturating\"\nfilm_scale = 0.07\n");
    let films = ["4.762, 8.0", "0.04, 0.06, 0.10, 0.15"];
    let speeds = ["30, 60, 100, 150", "0.5, 1.0, 1.5, 2.0"];
    let design = design(films, &["AK10", "M20"], speeds, "repeats = 4\n");
    scene_of("clear of the threshold", &[PTFE, AK10, M20, model, &truth, &design])
}

/// One film ratio near the threshold: most of the runs stick.
fn sticking() -> String {
    scene_of("mostly stuck", &["smallest_restitution = 0.05\n", PE, M50])
        + r#"[model]
inertia = "none"
[truth]
dry_k = { PE = 0.123 }
lubrication_log = 1.9
inertia = "none"
sigma_dry = 0.01
sigma_wet = 0.05
[design]
diameter_mm = { PE = [3.175, 3.969] }
liquids = ["M50"]
film_ratio = { PE = [0.06] }
height_mm = [30, 50, 70, 90, 110, 130, 150]
dry_impact_speed_m_s = [0.5, 1.0, 2.0]
repeats = 20
"#
}

fn pooled(findings: &Findings, law: WetLaw) -> &Scaling {
    let mut rows = findings.scaling.iter();
    let found = rows.find(|row| row.law == law && row.film_ratio.is_some());
    found.expect("the scene has one particle and wet runs")
}

fn value(estimate: &Estimate) -> f64 {
    estimate.value.expect("the fit converged")
}

/// Of k, L, C, δ̃0, and e_inf and St_c at the thickest film.
#[test]
fn the_intervals_cover_the_truth() {
    const SETS: u64 = 200;
    let e_dry = 1.0 - 0.183 * 2f64.powf(0.2);
    let e_inf2 = e_dry * e_dry - 0.45 * 930.0 / 2150.0 * (1.0 - (-0.15f64 / 0.07).exp());
    let truth = [0.183, 1.9, 0.45, 0.07, e_inf2.sqrt(), 2.0 * 1.9 / e_inf2];
    // a standard error without its square root, or a one-sided quantile, would narrow intervals about to the second
    let covered = study("the_intervals_cover_the_truth", SETS, |seed| {
        let findings = Place::new(&clear()).infer(seed);
        let balance = findings.balance();
        let [l, c, scale] = [0, 1, 2].map(|place| &balance.parameters[place].estimate);
        let thickest = balance.derived.last().expect("four film ratios");
        let estimates = [
            &findings.dry[0].dry_k,
            l,
            c,
            scale,
            &thickest.estimates[EInf],
            &thickest.estimates[StC],
        ];
        [1.0, 0.6].map(|shrink| {
            std::array::from_fn(|place| {
                let [lo, hi] = estimates[place].interval.expect("the fit converged");
                (truth[place] - (lo + hi) / 2.0).abs() <= shrink * (hi - lo) / 2.0
            })
        })
    });
    let of = |which: usize| counts::<6>(&covered.iter().map(|both| both[which]).collect::<Vec<_>>());
    for covered in of(0) {
        assert_expected("95 % intervals", covered, SETS, 0.95);
    }
    // no more than 86 %
    for covered in of(1) {
        assert!(binomial_z(covered, SETS as usize, 0.95) < -5.6, "{covered} of {SETS}");
    }
}

/// Slip 6 of the paper: leaving stuck runs out takes the linear law too high, the square root hardly.
#[test]
fn leaving_stuck_runs_out_spoils_the_linear_law_and_hardly_the_square_root() {
    let e_dry = 1.0 - 0.123 * 2f64.powf(0.2);
    let (e_inf, st_c) = (e_dry, 2.0 * 1.9 / (e_dry * e_dry));
    let name = "leaving_stuck_runs_out_spoils_the_linear_law_and_hardly_the_square_root";
    const SETS: u64 = 60;
    let found = study(name, SETS, |seed| {
        let findings = Place::new(&sticking()).infer(seed);
        let (root, line) = (pooled(&findings, WetLaw::Sqrt), pooled(&findings, WetLaw::Linear));
        let shift = |estimate, truth: f64| value(estimate) / truth - 1.0;
        let [of_root, of_line] =
            [root, line].map(|law| [shift(&law.estimates[EInf], e_inf), shift(&law.estimates[StC], st_c)]);
        let stuck = root.stuck as f64 / (root.stuck + root.runs) as f64;
        [of_root[0], of_root[1], of_line[0], of_line[1], stuck]
    });
    let [root_e, root_st, line_e, line_st, stuck] =
        std::array::from_fn(|place| mean(&found.iter().map(|each| each[place]).collect::<Vec<_>>()).0);
    assert!((0.5..0.8).contains(&stuck), "{stuck}");
    assert!(root_e.abs() < 0.04 && root_st.abs() < 0.04, "{root_e} {root_st}");
    assert!(line_e > 0.05 && line_st > 0.3, "{line_e} {line_st}");
}

/// Slip 7 of the paper: the linear law fitted to a square root is biased, and the printed bias is that bias.
#[test]
fn the_linear_laws_printed_bias_is_the_one_of_a_noise_free_fit() {
    // no noise at all: the linear fit's distance from the square root is the bias itself
    let quiet = clear().replace("sigma_wet = 0.02", "sigma_wet = 1e-9");
    let findings = Place::new(&quiet).infer(1);
    let of = |law: WetLaw| {
        findings
            .scaling
            .iter()
            .filter(move |row| row.law == law && row.film_ratio.is_some())
    };
    for law in of(WetLaw::Linear) {
        let mut roots = of(WetLaw::Sqrt);
        let root = roots.find(|row| row.film_ratio == law.film_ratio);
        let root = root.expect("both laws are fitted");
        let bias = law.bias.expect("the fit converged");
        let of_e_inf = value(&law.estimates[EInf]) - value(&root.estimates[EInf]);
        let of_st_c = value(&law.estimates[StC]) - value(&root.estimates[StC]);
        assert!((of_e_inf - bias.e_inf).abs() < 1e-6, "{of_e_inf} {bias:?}");
        assert!((of_st_c - bias.st_c).abs() < 1e-4, "{of_st_c} {bias:?}");
        assert!(bias.e_inf > 0.002 && bias.st_c > 0.5, "{bias:?}");
    }
}
