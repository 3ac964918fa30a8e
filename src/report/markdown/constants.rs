//! Tells how results move with the constants taken as exact, and what is known of these.

use super::super::numbers::{self, NONE};
use super::super::Told;
use super::page::Page;
use crate::findings::constants::{Sensitivity, MOST_REBOUNDS};
use crate::units::micrometres;

pub(super) fn constants(page: &mut Page, told: Told) {
    let rows = &told.findings.constants;
    if rows.is_empty() {
        return;
    }
    page.heading("Constants taken as exact");
    let names = names(rows);
    let offset = if names.iter().any(|name| name == "film_offset") {
        ", `film_offset` all films by one length, as a share of their mean"
    } else {
        ""
    };
    let rebounds: usize = told.runs.series.iter().map(|series| series.rebounds.len()).sum();
    let taken = if rebounds > MOST_REBOUNDS {
        format!(" Found on about {MOST_REBOUNDS} of the {rebounds} rebounds.")
    } else {
        String::new()
    };
    page.paragraph(&format!(
        "Every fit takes viscosity, densities, roughness and films as exact. The table has d ln(result)/d ln(constant): \
         −1.00 says that 1 % more of the constant gives 1 % less of the result, an empty cell that it does not move it. \
         A column moves all constants of its kind by one factor, one with a name in brackets that one alone{offset}. A \
         film ratio in brackets stays what it is told to be; the square-root law does not know the films of its runs.{taken}"
    ));
    let mut header = vec!["result"];
    header.extend(names.iter().map(String::as_str));
    let cells = |row: &Sensitivity| {
        let mut cells = vec![row.label()];
        cells.extend(names.iter().map(|name| {
            let found = row.by.iter().find(|moves| moves.constant == *name);
            found.map_or(String::new(), |moves| numbers::signed(moves.elasticity))
        }));
        cells
    };
    page.table(&header, &rows.iter().map(cells).collect::<Vec<_>>());
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
    let cells = |row: &&Sensitivity| {
        let with = |error: f64| numbers::with_se(in_unit(row, row.value), in_unit(row, error));
        vec![
            label_with_unit(row),
            with(row.se),
            numbers::optional(row.constants_sd.map(|sd| in_unit(row, sd)), 2),
            row.combined.map_or(NONE.to_owned(), with),
        ]
    };
    let header = ["result", "± standard error", "sd from the constants", "± combined"];
    page.table(&header, &given.iter().map(cells).collect::<Vec<_>>());
}

/// The combined uncertainty of the main numbers, in a line; `None` where the scene gives none.
pub(super) fn combined(told: Told) -> Option<String> {
    let rows = &told.findings.constants;
    // without an energy balance the direct fits are what there is
    let has_balance = rows.iter().any(|row| row.fit == "balance");
    let main = rows.iter().filter(|row| !has_balance || row.fit == "balance");
    let texts: Vec<String> = main
        .filter_map(|row| {
            let with = numbers::with_se(in_unit(row, row.value), in_unit(row, row.combined?));
            Some(format!("{} {with}", label_with_unit(row)))
        })
        .collect();
    (!texts.is_empty()).then(|| {
        format!(
            "With what the scene says of its constants, ± is (combined, see Constants taken as exact): {}.",
            texts.join("; ")
        )
    })
}

fn in_unit(row: &Sensitivity, x: f64) -> f64 {
    if row.result == "delta_c_m" {
        micrometres(x)
    } else {
        x
    }
}

fn label_with_unit(row: &Sensitivity) -> String {
    if row.result == "delta_c_m" {
        format!("{} / µm", row.label())
    } else {
        row.label()
    }
}

/// Every constant that moves some result, in the order of the scene.
fn names(rows: &[Sensitivity]) -> Vec<String> {
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
    let mut told: Vec<String> = vec![];
    for moves in rows.iter().flat_map(|row| &row.by) {
        if let Some(rel_sd) = moves.rel_sd {
            let text = format!("{} {} %", moves.constant, numbers::significant(100.0 * rel_sd, 2));
            if !told.contains(&text) {
                told.push(text);
            }
        }
    }
    told
}
