//! Writes how results move with the constants taken as exact, and what is known of these.

use super::super::{numbers, quantities, ReportInput};
use super::cells::place_name;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::constants::Sensitivity;
use crate::findings::main_numbers::MainNumber;
use crate::physics::Quantity;

pub(super) fn constants(page: &mut Page, input: ReportInput) {
    let rows = &input.findings.constants;
    if rows.is_empty() {
        return;
    }
    page.heading("Constants taken as exact");
    let names = constant_names(rows);
    let offset = if names.iter().any(|own| own == "film_offset") {
        ", `film_offset` all films by one length, as a share of their mean"
    } else {
        ""
    };
    page.paragraph(&format!(
        "The table has d ln(result)/d ln(constant): −1.00 says that 1 % more of the constant gives 1 % less of the result, an \
         empty cell that it does not move it. A column moves all constants of its kind by one factor, one with a name in \
         brackets that one alone{offset}."
    ));
    let mut table = ReportTable::of(rows).column("result", |row| row.label());
    for own in &names {
        table = table.column(own, |row| {
            let found = row.by.iter().find(|moves| moves.constant == *own);
            found.map_or(String::new(), |moves| numbers::signed(moves.elasticity))
        });
    }
    page.table(&table);
    let given: Vec<&Sensitivity> = rows.iter().filter(|row| row.combined.is_some()).collect();
    if given.is_empty() {
        return;
    }
    page.paragraph(&format!(
        "The scene says how well some are known, as sd over value: {}. Taken as independent of each other they add to the \
         standard error of the runs by squares: combined = √(se² + Σ (result · elasticity · sd)²). Constants it says \
         nothing of stay exact.",
        uncertainties(rows).join(", ")
    ));
    let with = |row: &Sensitivity, error: f64| numbers::with_se(in_unit(row, row.value), in_unit(row, error));
    let table = ReportTable::of(given)
        .column("result", label_with_unit)
        .column("± standard error", |row| row.se.map(|se| with(row, se)))
        .column("sd from the constants", |row| {
            numbers::optional(row.constants_sd.map(|sd| in_unit(row, sd)), 2)
        })
        .column("± combined", |row| row.combined.map(|combined| with(row, combined)));
    page.table(&table);
}

/// The combined uncertainty of the main numbers, in a line; `None` where the scene gives none.
pub(super) fn combined(input: ReportInput) -> Option<String> {
    let main = &input.findings.main;
    let rows = &input.findings.constants;
    let parameters = main.parameters.iter().filter_map(|own| {
        let row = rows.iter().find(|row| row.is_of_balance() && row.result == own.name)?;
        Some(format!(
            "{} {}",
            own.quantity.describe().symbol,
            widened(row, &own.number)?
        ))
    });
    let places = main.at.iter().flat_map(|place| {
        rows.iter().filter_map(move |row| {
            let (quantity, number) = place.of_result(row)?;
            let (symbol, place) = (quantity.describe().symbol, place_name(place));
            Some(format!("{symbol} ({place}) {}", widened(row, number)?))
        })
    });
    let texts: Vec<String> = parameters.chain(places).collect();
    (!texts.is_empty()).then(|| {
        format!(
            "With what the scene says of its constants, ± is (combined, see Constants taken as exact): {}.",
            texts.join("; ")
        )
    })
}

/// A number with what the constants add to its ±, as a share of it that all fits have in common.
fn widened(row: &Sensitivity, number: &MainNumber) -> Option<String> {
    let (value, se) = number.value.zip(number.se)?;
    let of_constants = row.constants_sd? * value / row.value;
    Some(numbers::with_se(value, se.hypot(of_constants)))
}

/// Whether the result is a length, which is printed in µm.
fn is_length(row: &Sensitivity) -> bool {
    row.result == Quantity::DeltaC.describe().name
}

fn in_unit(row: &Sensitivity, x: f64) -> f64 {
    if is_length(row) {
        quantities::in_unit(Quantity::DeltaC, x)
    } else {
        x
    }
}

fn label_with_unit(row: &Sensitivity) -> String {
    if is_length(row) {
        format!("{} / µm", row.label())
    } else {
        row.label()
    }
}

/// Every constant that moves some result, in the order of the scene.
fn constant_names(rows: &[Sensitivity]) -> Vec<String> {
    let mut names: Vec<(usize, String)> = vec![];
    for moves in rows.iter().flat_map(|row| &row.by) {
        if !names.iter().any(|(_, name)| *name == moves.constant) {
            names.push((order(&moves.constant), moves.constant.clone()));
        }
    }
    // stable: those of one kind keep the order they were met in
    names.sort_by_key(|(order, _)| *order);
    names.into_iter().map(|(_, name)| name).collect()
}

fn order(constant: &str) -> usize {
    let kinds = ["viscosity", "liquid_density", "particle_density", "roughness", "film"];
    let kind = constant.split('[').next();
    let place = kinds.iter().position(|name| kind == Some(*name));
    place.unwrap_or(kinds.len())
}

/// The constants whose uncertainty is given and moves a result.
fn uncertainties(rows: &[Sensitivity]) -> Vec<String> {
    let mut texts: Vec<String> = vec![];
    for moves in rows.iter().flat_map(|row| &row.by) {
        if let Some(rel_sd) = moves.rel_sd {
            let text = format!("{} {} %", moves.constant, numbers::significant(100.0 * rel_sd, 2));
            if !texts.contains(&text) {
                texts.push(text);
            }
        }
    }
    texts
}
