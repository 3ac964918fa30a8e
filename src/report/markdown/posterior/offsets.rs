//! Writes the offsets of r that series have, and how much of the scatter between them the runs tell.

use super::super::super::{numbers, ReportInput};
use super::super::cells::diameter;
use super::super::page::Page;
use super::super::table::ReportTable;
use super::cells::rhat;
use crate::findings::posterior::{Posterior, SeriesOffset};
use crate::model::parameters::ParameterKind;

/// So many offsets are told one by one; of more the largest.
const MOST: usize = 60;
/// Largest ones told where there are more.
const LARGEST: usize = 12;

/// The offsets with σ_series; nothing where the model has none.
pub(super) fn series_offsets(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    let all = &posterior.findings.series_offsets;
    if all.is_empty() {
        return;
    }
    page.subsection("Offsets of series", "What the runs of a series share besides the law.");
    page.paragraph(&format!(
        "o_s of the energy kept, one for the wet runs of each series (particle, liquid, diameter, film group), normal about 0 \
         with the standard deviation σ_series{}. What is quoted, e_inf and St_c among it, is of the law itself, o_s = 0: what a \
         mean over many series tends to. Bands in figures and of `wetcor predict` are those of a new series, for which \
         σ_series counts; `--measured-series` gives those of one of these. ± is one standard deviation of the posterior.",
        spread(input, posterior)
    ));
    let mut shown: Vec<&SeriesOffset> = all.iter().collect();
    if shown.len() > MOST {
        let size = |own: &SeriesOffset| own.offset.mean.map_or(0.0, f64::abs);
        shown.sort_by(|a, b| size(b).total_cmp(&size(a)));
        shown.truncate(LARGEST);
        page.paragraph(&format!(
            "The {LARGEST} largest of {}; all of them stand in `findings.json`.",
            all.len()
        ));
    }
    let table = ReportTable::of(shown)
        .column("particle", |own| &own.particle)
        .column("liquid", |own| &own.liquid)
        .column("D / mm", |own| diameter(own.diameter_m))
        .column("δ/D", |own| numbers::short(own.film_ratio))
        .column("runs", |own| own.runs)
        .column("o_s ± sd", |own| numbers::mean_and_sd(&own.offset, |x| x))
        .column("R-hat", |own| rhat(own.offset.rhat));
    page.table(&table);
}

/// σ_series with its interval, and the truth it was simulated from.
fn spread(input: ReportInput, posterior: &Posterior) -> String {
    let name = ParameterKind::SigmaSeries.key();
    let Some(sigma) = posterior.findings.parameters.iter().find(|own| own.name == name) else {
        return String::new();
    };
    let interval = sigma.q025.zip(sigma.q975).map_or(String::new(), |(lo, hi)| {
        let [lo, hi] = [lo, hi].map(|x| numbers::significant(x, 2));
        format!(" (95 % from {lo} to {hi})")
    });
    let truth = input.scene.truth.as_ref().map_or(String::new(), |truth| {
        let value = truth.sigma_series.unwrap_or(0.0);
        format!("; simulated: {}", numbers::significant(value, 3))
    });
    format!(" = {}{interval}{truth}", numbers::mean_and_sd(sigma, |x| x))
}
