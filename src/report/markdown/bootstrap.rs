//! Tells where the bootstrap and the delta method part.

use super::super::figures;
use super::super::numbers::{self, NONE};
use super::super::Told;
use super::cells::{interval_header, law_name};
use super::page::Page;
use crate::findings::estimate::Bootstrapped;
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
    for fitted in told.findings.scaling.iter().filter(|fitted| fitted.verdict.passed) {
        for (symbol, estimate) in [("e_inf", &fitted.e_inf), ("St_c", &fitted.st_c)] {
            let ratio = fitted.film_ratio.map_or("all".to_owned(), numbers::short);
            let cells = [fitted.particle.clone(), symbol.to_owned(), ratio, law_name(fitted.law)];
            rows.extend(row(cells, estimate));
        }
    }
    if rows.is_empty() {
        return;
    }
    let Some(resampling) = &told.findings.bootstrap else {
        return;
    };
    page.heading("Bootstrap");
    let scheme = match told.scene.bootstrap.scheme {
        ResamplingScheme::Cases => {
            "runs resampled inside each series and impact speed, so that only the noise varies. From n runs n − 1 are \
             drawn with the weight n/(n − 1): n of n would give a standard error √(1 − 1/n) too small"
        }
        ResamplingScheme::Residuals => "residuals resampled, each over √(1 − leverage)",
        ResamplingScheme::Parametric => "normal noise of the fitted spread about each law",
        ResamplingScheme::Series => {
            "whole series resampled. From n series n − 1 are drawn with the weight n/(n − 1): n of n would give a \
             standard error √(1 − 1/n) too small"
        }
    };
    let single = match (told.scene.bootstrap.scheme, resampling.single_run_strata) {
        (ResamplingScheme::Cases, n) if n > 0 => {
            format!(
                " Of {} strata {n} hold a single run, which no resample can vary.",
                resampling.strata
            )
        }
        (ResamplingScheme::Cases, _) => format!(" None of the {} strata holds a single run.", resampling.strata),
        _ => String::new(),
    };
    page.paragraph(&format!(
        "{} replicates, {scheme}.{single} Percentile and BCa limits are widened as Student's t is, by the degrees of \
         freedom of the strata. The other tables quote these intervals wherever replicates were made; ± is the delta \
         method's throughout. Below: fits that are usable. How often each kind of interval covers the truth of simulated runs: `wetcor calibrate`.",
        resampling.replicates
    ));
    let names = figures::Names::of(told.scene);
    for particle in &told.scene.particles {
        for over_all in [false, true] {
            page.figure(
                &names.joint(&particle.name, over_all),
                &format!("{}: e_inf and St_c together", particle.name),
                &format!(
                    "{}: the replicates of e_inf and St_c together; contours hold 50 % and 95 % of them. The bars along \
                     the axes are the {} intervals of each quantity alone.{}",
                    particle.name,
                    interval_header(told).replace(" interval", ""),
                    if told.posterior.is_some() && !over_all {
                        " The posterior of the square root is that of all runs at once, at the density ratio of these."
                    } else {
                        ""
                    }
                ),
            );
        }
    }
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
        boot.se.map_or(NONE.to_owned(), |own| numbers::significant(own / se, 3)),
        boot.bias.map_or(NONE.to_owned(), |bias| numbers::shift(bias, Some(se))),
        failed(boot),
    ]);
    Some(row)
}

/// How many replicates gave no number, and why.
fn failed(boot: &Bootstrapped) -> String {
    let reasons: Vec<String> = boot
        .failures
        .iter()
        .map(|failed| format!("{} {}", failed.replicates, failed.reason))
        .collect();
    match reasons.as_slice() {
        [] => boot.failed.to_string(),
        reasons => reasons.join(", "),
    }
}
