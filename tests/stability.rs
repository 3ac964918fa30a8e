//! Holds that formulas and estimates stay right at the extremes, and that `reports/stability.md` says how right formulas are.
//!
//! `UPDATE_EXPECTED=1 cargo test --release --test all stability::` rewrites the tables of the page. Figures are rounded up so
//! far that another processor gives the same.

mod extremes;
mod formulas;

use crate::common::{is_update, kept, read_in_project};
use formulas::{measure, ours, NOTHING, ROUNDINGS};

const PAGE: &str = "reports/stability.md";
const BEGIN: &str = "<!-- formulas -->\n";
const END: &str = "<!-- end of formulas -->";

/// Holds the tables of the page against what was measured, or rewrites them.
fn compare(measured: &str) {
    let page = read_in_project(PAGE);
    let (head, rest) = page.split_once(BEGIN).expect("the tables begin");
    let (before, tail) = rest.split_once(END).expect("the tables end");
    kept(PAGE, &format!("{head}{BEGIN}{measured}{END}{tail}"));
    assert!(is_update() || before == measured, "{before}\n{measured}");
}

/// The next power of two, or of ten where that is too fine.
fn at_most(x: f64) -> String {
    match x {
        x if x <= 64.0 => format!("{}", x.max(0.25).log2().ceil().exp2()),
        x => format!("10^{}", x.log10().ceil()),
    }
}

#[test]
fn no_formula_cancels_worse_than_its_condition_number_excuses() {
    let (formulas, laws) = measure(ours);
    assert!(formulas.len() > 30 && laws.len() == 3);
    let mut table = String::from(
        "| formula with its slopes | answers | largest error where the condition number is 10 or less | largest condition \
         number | largest error over 1 + condition number |\n| --- | --- | --- | --- | --- |\n",
    );
    for (name, measured) in &formulas {
        assert!(measured.worst_share <= ROUNDINGS, "{name}: {measured:?}");
        table += &format!(
            "| {name} | {} | {} | {} | {} |\n",
            measured.answers,
            at_most(measured.worst_of_tame),
            at_most(measured.largest_condition),
            at_most(measured.worst_share),
        );
    }
    table += "\n| law fitted | fits | largest distance from the exact fit, se | largest relative error of an se |\n| --- | --- | --- | --- |\n";
    for (name, fitted) in &laws {
        assert!(
            fitted.distance <= NOTHING && fitted.of_se <= NOTHING,
            "{name}: {fitted:?}"
        );
        table += &format!("| {name} | {} | below {NOTHING:e} | below {NOTHING:e} |\n", fitted.fits);
    }
    compare(&table);
}

/// The planted faults: formulas as one would first write them, right in exact arithmetic.
#[test]
fn formulas_that_cancel_are_found() {
    let naive = |scene: &mut _, name: &str, x: &[f64]| {
        let mut answers = ours(scene, name, x);
        match name {
            "inertia::stepwise" => answers[1] = 3.0 + x[0] * (-12.0 + 12.0 * x[0]),
            "inertia::saturating" => answers[0] = 1.0 - (-x[0] / x[1]).exp(),
            "normal::ln_normal_cdf" => {
                let density = (-0.5 * x[0] * x[0]).exp() / (2.0 * std::f64::consts::PI).sqrt();
                answers[1] = density / (0.5 * libm::erfc(-x[0] / std::f64::consts::SQRT_2));
            }
            _ => {}
        }
        answers
    };
    let (formulas, _) = measure(naive);
    for name in ["inertia::stepwise", "inertia::saturating", "normal::ln_normal_cdf"] {
        assert!(
            formulas[name].worst_share > 50.0 * ROUNDINGS,
            "{name}: {:?}",
            formulas[name]
        );
    }
}
