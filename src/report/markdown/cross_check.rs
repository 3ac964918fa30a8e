//! Writes what least squares over all rebounds at once gives, beside the posterior.

use super::super::{numbers, quantities, ReportInput};
use super::cells::interval_header;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::balance::ParameterEstimate;
use crate::findings::main_numbers::MainParameter;
use crate::physics::Quantity;
use crate::rounding::by_number;
use crate::scene::{LikelihoodFamily, NoiseOn};

/// Posterior sds by which least squares may lie off without a word.
const FAR: f64 = 1.0;

/// A parameter by both.
struct Compared<'a> {
    fitted: &'a ParameterEstimate,
    sampled: Option<&'a MainParameter>,
}

impl Compared<'_> {
    /// Least squares minus the posterior's mean, in its sds.
    fn difference(&self) -> Option<f64> {
        let number = &self.sampled?.number;
        let sd = number.se.filter(|sd| *sd > 0.0)?;
        Some((self.fitted.estimate.value? - number.value?) / sd)
    }
}

pub(super) fn cross_check(page: &mut Page, input: ReportInput) {
    let Some(balance) = &input.findings.energy_balance else {
        return;
    };
    let offsets = if input.scene.model.series_offsets {
        ", and without the offsets of series"
    } else {
        ""
    };
    let purpose = if input.posterior.is_some() {
        ": a check of the posterior"
    } else {
        ""
    };
    page.section(
        "Least squares over all rebounds",
        &format!(
            "All rebounds and dry runs at once by least squares, without stuck runs and priors{offsets}{purpose}. ± is one \
             standard error by the delta method. The fit: {}.",
            balance.verdict.reason
        ),
    );
    let sampled = |row: &ParameterEstimate| {
        let main = &input.findings.main;
        let mut all = main.parameters.iter().filter(|_| !main.provisional);
        all.find(|own| own.name == row.name)
    };
    let rows: Vec<Compared> = balance
        .parameters
        .iter()
        .map(|fitted| Compared {
            fitted,
            sampled: sampled(fitted),
        })
        .collect();
    page.table(&parameters(&rows, input));
    let far = |row: &&Compared| row.difference().is_some_and(|difference| difference.abs() > FAR);
    let symbol = |row: &Compared| {
        let kind = row.fitted.kind;
        quantities::parameter_label(input.scene, input.runs, kind, kind.symbol())
    };
    let far: Vec<String> = rows.iter().filter(far).map(symbol).collect();
    if !far.is_empty() {
        page.paragraph(&format!(
            "More than one posterior sd off: {}. {}.",
            far.join("; "),
            reasons(input, &rows)
        ));
    }
}

fn parameters<'a>(rows: &'a [Compared], input: ReportInput) -> ReportTable<&'a Compared<'a>> {
    let quantity = |row: &Compared| row.fitted.kind.quantity().unwrap_or(Quantity::DryK);
    let label = |row: &Compared| {
        quantities::parameter_label(
            input.scene,
            input.runs,
            row.fitted.kind,
            &quantities::label(quantity(row)),
        )
    };
    let table = ReportTable::of(rows)
        .column("quantity", label)
        .column("least squares", |row| {
            quantities::estimate(quantity(row), &row.fitted.estimate)
        })
        .column(interval_header(input), |row| {
            quantities::interval(quantity(row), &row.fitted.estimate)
        });
    if input.findings.main.provisional {
        return table;
    }
    table.column("minus posterior mean, in its sd", |row| {
        row.difference().map(numbers::signed)
    })
}

/// What of these runs and this model least squares does not know.
fn reasons(input: ReportInput, rows: &[Compared]) -> String {
    let mut all = vec![];
    let findings = input.findings;
    let stuck = findings.counts.stuck;
    if stuck > 0 {
        all.push(format!(
            "{stuck} {} stuck, which the posterior counts and least squares leaves out",
            by_number(stuck, "run", "runs")
        ));
    }
    if input.scene.model.noise == NoiseOn::Both {
        all.push("the noise acts on the energy kept, too".to_owned());
    }
    if input.scene.model.series_offsets {
        all.push("series have offsets of the energy kept".to_owned());
    }
    if input.scene.model.likelihood != LikelihoodFamily::Normal {
        all.push("the posterior's noise is not normal".to_owned());
    }
    if findings.counts.measurement_errors.is_some() {
        all.push("runs carry measurement errors".to_owned());
    }
    let of_scene = input.posterior.is_some_and(|posterior| {
        let mut sampled = posterior
            .findings
            .parameters
            .iter()
            .filter_map(|own| own.prior.as_ref());
        sampled.any(|prior| prior.source == "the scene")
    });
    if of_scene {
        all.push("the scene sets priors, which least squares does not read".to_owned());
    }
    let led = rows.iter().filter_map(|row| row.sampled).filter(|own| own.prior_led);
    let led: Vec<&str> = led.map(|own| own.name.as_str()).collect();
    if !led.is_empty() {
        all.push(format!("the prior leads {}", led.join(", ")));
    }
    let sampled = input.posterior.map(|posterior| posterior.findings.inertia);
    let fitted = findings.energy_balance.as_ref().map(|balance| balance.inertia);
    if sampled != fitted {
        all.push("the posterior holds another form of the inertial loss".to_owned());
    }
    if all.is_empty() {
        return "No stuck run, prior or other noise explains it: look for misfit under Predictive check".to_owned();
    }
    format!("What differs: {}", all.join("; "))
}
