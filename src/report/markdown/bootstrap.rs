//! Writes where the bootstrap and the delta method part.

use super::super::numbers;
use super::super::ReportInput;
use super::cells::law_name;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::bootstrap::{Resampling, MOST_RESAMPLED};
use crate::findings::estimate::{Bootstrapped, Estimate};
use crate::findings::notices::SERIES_SCHEME_CHANGES;
use crate::findings::Findings;
use crate::inference::delta::Interval;
use crate::physics::Quantity;
use crate::rounding::by_number;
use crate::scene::{ResamplingScheme, WetLaw};

/// The section; nothing where no replicates were made.
pub(super) fn bootstrap(page: &mut Page, input: ReportInput) {
    let rows = resampled(input.findings);
    let Some(resampling) = input.findings.bootstrap.as_ref().filter(|_| !rows.is_empty()) else {
        return;
    };
    page.section(
        "Bootstrap",
        "How uncertain the laws' numbers are when their runs are drawn again, beside the delta method.",
    );
    let own = input.scene.bootstrap.scheme;
    page.paragraph(&if resampling.by_sandwich {
        by_sandwich(resampling)
    } else {
        by_replicates(own, resampling)
    });
    let table = ReportTable::of(&rows)
        .column("particle", |row| row.particle.clone())
        .column("quantity", |row| row.quantity.describe().symbol)
        .column("δ/D", |row| row.film_ratio.map_or("all".to_owned(), numbers::short))
        .column("law", |row| row.law.map(law_name))
        .column("delta", |row| {
            let of_delta = |made: &&Interval| made.method == "delta" && made.level == row.estimate.level;
            let delta = row.estimate.intervals.iter().find(of_delta);
            delta.map(|made| numbers::between(made.lo, made.hi, row.se))
        })
        .column("bootstrap", |row| match own_of_curved(row.estimate) {
            Some(made) => numbers::between(made.lo, made.hi, row.se),
            None => numbers::interval(row.estimate),
        })
        .column("method", |row| {
            match (row.bootstrapped.fallback, own_of_curved(row.estimate)) {
                (Some(reason), _) => format!("{} ({reason})", row.estimate.method),
                (None, Some(made)) => format!("{}; the profile's is quoted", made.method),
                (None, None) => row.estimate.method.to_owned(),
            }
        })
        .column("se over delta's", |row| {
            let own = row.bootstrapped.se;
            let both = own.zip(row.estimate.se);
            both.map(|(own, of_delta)| numbers::significant(own / of_delta, 3))
        })
        .column("bias", |row| {
            let bias = row.bootstrapped.bias;
            bias.map(|bias| numbers::shift(bias, Some(row.se)))
        })
        .column("failed", |row| failed(row.bootstrapped));
    page.table(&table);
}

/// How replicates were made, and what is quoted of them.
fn by_replicates(own: ResamplingScheme, resampling: &Resampling) -> String {
    format!(
        "{} replicates, {}.{} Percentile and BCa limits are widened as Student's t is, by the degrees of \
         freedom of the strata. The other tables quote these intervals wherever replicates were made, {REST}",
        resampling.replicates,
        scheme(own),
        single_runs(own, resampling)
    )
}

/// What stands for replicates where runs are too many to be resampled.
fn by_sandwich(resampling: &Resampling) -> String {
    let rest = match resampling.resampled_fits {
        0 => String::new(),
        fits => format!(
            " {fits} fits have too few runs for that: these were resampled, {} replicates each.",
            resampling.replicates
        ),
    };
    format!(
        "Of more than {MOST_RESAMPLED} runs the standard error is the one that resampling inside each series and impact speed \
         tends to, by the sandwich covariance, which takes neither the spreads as equal nor the law as true; the intervals are \
         normal.{rest} The other tables quote these intervals, {REST}"
    )
}

const REST: &str = "but the profile's where the curvature of a fit forbids a ±; ± is the delta method's throughout. Below: fits \
                    that are usable. How often each kind of interval covers the truth of simulated runs: `wetcor calibrate`.";

/// An estimate with replicates beside its standard error.
struct Resampled<'a> {
    particle: String,
    quantity: Quantity,
    film_ratio: Option<f64>,
    law: Option<WetLaw>,
    estimate: &'a Estimate,
    bootstrapped: &'a Bootstrapped,
    /// the standard error, or what its interval says of one
    se: f64,
}

/// The bootstrap's interval of an estimate that quotes the profile's.
fn own_of_curved(estimate: &Estimate) -> Option<&Interval> {
    let own = |made: &&Interval| made.is_bootstrap() && made.level == estimate.level;
    estimate.intervals.iter().find(own).filter(|_| estimate.is_curved())
}

/// k of each particle, then e_inf and St_c of each fit that may be used.
fn resampled(findings: &Findings) -> Vec<Resampled<'_>> {
    let of_dry = findings.dry.iter().filter_map(|dry| {
        Some(Resampled {
            particle: dry.words(),
            quantity: Quantity::DryK,
            film_ratio: None,
            law: None,
            estimate: &dry.dry_k,
            bootstrapped: dry.dry_k.bootstrap.as_ref()?,
            se: dry.dry_k.scale()?,
        })
    });
    let usable = findings.scaling.iter().filter(|fitted| fitted.verdict.passed);
    let of_laws = usable.flat_map(|fitted| {
        let both = [(Quantity::EInf, &fitted.e_inf), (Quantity::StC, &fitted.st_c)].into_iter();
        both.filter_map(|(quantity, estimate)| {
            Some(Resampled {
                particle: fitted.words(),
                quantity,
                film_ratio: fitted.film_ratio,
                law: Some(fitted.law),
                estimate,
                bootstrapped: estimate.bootstrap.as_ref()?,
                se: estimate.scale()?,
            })
        })
    });
    of_dry.chain(of_laws).collect()
}

/// What was resampled.
fn scheme(scheme: ResamplingScheme) -> String {
    let text = match scheme {
        ResamplingScheme::Cases => {
            "runs resampled inside each series and impact speed, so that only the noise varies. From n runs n − 1 are \
             drawn with the weight n/(n − 1): n of n would give a standard error √(1 − 1/n) too small"
        }
        ResamplingScheme::Series => {
            return format!(
                "whole series resampled. From n series n − 1 are drawn with the weight n/(n − 1): n of n would give a \
                 standard error √(1 − 1/n) too small. That {SERIES_SCHEME_CHANGES}"
            )
        }
    };
    text.to_owned()
}

/// How many strata no resample can vary.
fn single_runs(scheme: ResamplingScheme, resampling: &Resampling) -> String {
    let strata = resampling.strata;
    match (scheme, resampling.single_run_strata) {
        (ResamplingScheme::Cases, 0) => format!(" None of the {strata} strata holds a single run."),
        (ResamplingScheme::Cases, n) => {
            let hold = by_number(n, "holds", "hold");
            format!(" Of {strata} strata {n} {hold} a single run, which no resample can vary.")
        }
        _ => String::new(),
    }
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
