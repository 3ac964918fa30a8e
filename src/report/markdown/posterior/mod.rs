//! Writes the posterior, step by step as a referee asks for it.
//!
//! | file | job |
//! |---|---|
//! | `cells.rs` | what several of its tables share |
//! | `model.rs` | how the runs are taken to come about |
//! | `parameters.rs` | the parameters with their priors |
//! | `computation.rs` | how it was sampled |
//! | `offsets.rs` | the offsets that series have |
//! | `predictions.rs` | whether new runs would look like the ones made, and which form of the law predicts best |
//! | `questions.rs` | whether L and C are the same at every film ratio |
//!
//! The order of the steps is that of the Bayesian Analysis Reporting Guidelines (Kruschke 2021, Nature Human Behaviour
//! 5, 1282).

mod cells;
mod computation;
mod model;
mod offsets;
mod parameters;
mod predictions;
mod questions;

pub(super) use parameters::held;

use super::super::ReportInput;
use super::cells::fitted_runs;
use super::page::Page;
use crate::findings::posterior::{Posterior, PosteriorRefusal};
use crate::report::draws::posterior::{stores_every_run, stores_runs};

/// The section; nothing where no posterior was asked for, and the reason where nothing was sampled.
pub(super) fn posterior(page: &mut Page, input: ReportInput) {
    let Some(posterior) = input.posterior else {
        if let Some(why) = PosteriorRefusal::among(&input.findings.remarks) {
            page.section("Posterior", &format!("Nothing was sampled: {}.", why.text));
        }
        return;
    };
    page.section(
        "Posterior",
        &format!(
            "A joint fit to {}, in the order of the Bayesian Analysis Reporting Guidelines (Kruschke 2021, Nature Human \
             Behaviour 5, 1282).",
            fitted_runs(input)
        ),
    );
    model::model(page, input, posterior);
    parameters::parameters(page, input, posterior);
    computation::computation(page, input, posterior);
    offsets::series_offsets(page, input, posterior);
    predictions::predictive(page, posterior);
    predictions::forms(page, input);
    questions::questions(page, input);
    draws(page, input, posterior);
}

fn draws(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subsection(
        "Draws",
        "The command under How to reproduce makes the same draws again, to the byte and for any number of threads. They \
         lie beside this report: `draws/draws.zarr`, which `arviz.from_zarr(\"draws/draws.zarr\")` opens in Python, and \
         `draws/draws.csv`, a line a draw, for everything else.",
    );
    let left_out = match (stores_runs(input.runs), stores_every_run(input.runs, posterior)) {
        (true, true) => return,
        (true, false) => "The likelihood and a new draw of every run",
        (false, _) => "The runs themselves, and the likelihood and a new draw of each,",
    };
    page.paragraph(&format!(
        "{left_out} are not among them: they would be too many numbers."
    ));
}
