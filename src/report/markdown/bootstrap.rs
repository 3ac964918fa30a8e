//! Tells where the bootstrap and the delta method part.

use super::super::numbers::{self, NONE};
use super::super::Told;
use super::cells::law_name;
use super::page::Page;
use crate::findings::estimate::Estimate;
use crate::scene::ResamplingScheme;

/// The section; nothing where no replicates were made.
pub(super) fn bootstrap(page: &mut Page, told: Told) {
    let mut rows = vec![];
    for dry in &told.findings.dry {
        rows.extend(row(
            [dry.particle.clone(), "k".to_owned(), "all".to_owned(), NONE.to_owned()],
            &dry.dry_k,
        ));
    }
    for fitted in &told.findings.scaling {
        for (symbol, estimate) in [("e_inf", &fitted.e_inf), ("St_c", &fitted.st_c)] {
            let ratio = fitted.film_ratio.map_or("all".to_owned(), numbers::short);
            let cells = [fitted.particle.clone(), symbol.to_owned(), ratio, law_name(fitted.law)];
            rows.extend(row(cells, estimate));
        }
    }
    if rows.is_empty() {
        return;
    }
    page.heading("Bootstrap");
    let choices = &told.scene.bootstrap;
    let scheme = match choices.scheme {
        ResamplingScheme::Cases => "runs resampled inside each series",
        ResamplingScheme::Residuals => "leverage-corrected residuals resampled",
        ResamplingScheme::Parametric => "normal noise of the fitted spread",
        ResamplingScheme::Series => "whole series resampled",
    };
    page.paragraph(&format!(
        "{} replicates, {scheme}. A stratum of n runs resampled by cases gives a standard error √(1 − 1/n) too small. \
         The other tables quote these intervals wherever replicates were made.",
        choices.replicates
    ));
    page.table(
        &[
            "particle",
            "quantity",
            "δ/D",
            "law",
            "delta",
            "bootstrap",
            "method",
            "se over delta's",
            "bias",
            "failed",
        ],
        &rows,
    );
}

fn row(mut cells: [String; 4], estimate: &Estimate) -> Option<Vec<String>> {
    let boot = estimate.bootstrap.as_ref()?;
    let se = estimate.se?;
    let delta = estimate
        .intervals
        .iter()
        .find(|made| made.method == "delta" && made.level == estimate.level);
    let method = match boot.fallback {
        Some(reason) => format!("{} ({reason})", estimate.method),
        None => estimate.method.to_owned(),
    };
    let mut row: Vec<String> = cells.iter_mut().map(std::mem::take).collect();
    row.extend([
        delta.map_or(NONE.to_owned(), |made| numbers::between(made.lo, made.hi, se)),
        numbers::interval(estimate),
        method,
        numbers::significant(boot.se / se, 3),
        numbers::shift(boot.bias, Some(se)),
        boot.failed.to_string(),
    ]);
    Some(row)
}
