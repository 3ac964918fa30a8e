//! Tells the posterior, step by step as a referee asks for it.
//!
//! | file | job |
//! |---|---|
//! | `model.rs` | what was assumed: the model, its priors, what was left out |
//! | `computation.rs` | how it was sampled, and whether the chains agree |
//! | `numbers.rs` | what the parameters are, and what follows from them |
//! | `predictions.rs` | whether new runs would look like the ones made, and which form of the law predicts best |
//! | `questions.rs` | whether L and C are the same at every film ratio |
//!
//! The order of the steps is that of the Bayesian Analysis Reporting Guidelines (Kruschke 2021, Nature Human Behaviour
//! 5, 1282).

mod computation;
mod model;
mod numbers;
mod predictions;
mod questions;

pub(super) use model::held;

use super::super::numbers::{self as print, NONE};
use super::super::Told;
use super::page::Page;
use crate::findings::posterior::{Declined, Posterior, Quantity};
use crate::findings::verdicts::Check;

/// The section; nothing where no posterior was asked for, and the reason where nothing was sampled.
pub(super) fn posterior(page: &mut Page, told: Told) {
    let Some(posterior) = told.posterior else {
        if let Some(why) = Declined::among(&told.findings.verdicts) {
            page.heading("Posterior");
            page.paragraph(&format!("Nothing was sampled: {}.", why.text));
        }
        return;
    };
    page.heading("Posterior");
    page.paragraph(
        "All runs at once, the stuck ones with them, under stated priors. The order is that of the Bayesian Analysis \
         Reporting Guidelines (Kruschke 2021, Nature Human Behaviour 5, 1282): model and priors, computation, what the \
         posterior says, how it predicts, other forms of the model, how to make it again.",
    );
    model::model(page, told, posterior);
    model::priors(page, posterior);
    computation::computation(page, told, posterior);
    numbers::parameters(page, posterior);
    numbers::derived(page, told, posterior);
    numbers::beside_the_prior(page, posterior);
    numbers::correlations(page, posterior);
    predictions::predictive(page, posterior);
    predictions::forms(page, told);
    questions::questions(page, told, posterior);
    draws(page);
}

fn draws(page: &mut Page) {
    page.subheading("Draws");
    page.paragraph(
        "The command under How to reproduce makes the same draws again, to the byte and for any number of threads. They \
         lie beside this report: `draws/draws.zarr`, which `arviz.from_zarr(\"draws/draws.zarr\")` opens in Python, and \
         `draws/draws.csv`, a line a draw, for everything else.",
    );
}

/// How the tables name a parameter: `k, PTFE`.
pub(super) fn label(quantity: &Quantity) -> String {
    let symbol = quantity
        .prior
        .as_ref()
        .map_or(quantity.name.as_str(), |prior| prior.symbol);
    match quantity.name.split_once('[') {
        Some((_, particle)) => format!("{symbol}, {}", particle.trim_end_matches(']')),
        None => symbol.to_owned(),
    }
}

/// R-hat, to the thousandths its line of 1.01 asks for.
fn rhat(value: Option<f64>) -> String {
    value.map_or(NONE.to_owned(), |rhat| format!("{rhat:.3}"))
}

/// A table of checks with what was found, the line it is held against, and whether it holds.
fn checks<'c>(page: &mut Page, checks: impl Iterator<Item = &'c Check>) {
    let rows: Vec<Vec<String>> = checks
        .map(|check| {
            vec![
                check.text.clone(),
                print::optional(check.value, 4),
                print::significant(check.threshold, 3),
                if check.passed { "holds" } else { "fails" }.to_owned(),
                check.source.to_owned(),
            ]
        })
        .collect();
    page.table(&["check", "value", "line", "outcome", "why this line"], &rows);
}

/// Whether a check asks how the model predicts, not how it was sampled.
fn of_prediction(check: &Check) -> bool {
    check.check.starts_with("predictive") || check.check == "dry_consistency"
}

/// Checks told here, which the table of cautions need not tell again where they hold.
pub(super) fn tells(told: Told, check: &Check) -> bool {
    let same = |own: &&Check| own.check == check.check;
    told.posterior
        .is_some_and(|posterior: &Posterior| posterior.checks.iter().find(same).is_some())
}
