//! Writes what a terminal shows of a fit: the verdict, and the main numbers in columns.

use std::collections::HashSet;

use textwrap::core::display_width;

use super::super::{quantities, ReportInput};
use super::cells::place_name;
use super::main_numbers::{others, places_shown, source};
use super::verdict::{carried, cautions_line, verdict};
use crate::findings::learnt::capital;
use crate::findings::main_numbers::{MainPlace, Source};
use crate::findings::Findings;
use crate::physics::Quantity;

/// The main numbers as lines for a terminal.
pub fn summary(input: ReportInput) -> String {
    let main = &input.findings.main;
    let mut text = verdict_lines(input.findings);
    if let Some(carried) = carried(input.findings) {
        text.push_str(&format!("{}.\n", capital(&carried.text)));
    }
    if main.provisional {
        text.push_str("Provisional: the posterior was not sampled.\n");
    }
    let form = input.findings.inertia.as_ref().map(|choice| {
        let others = format!("(log density against it: {})", others(choice));
        ["inertia".to_owned(), format!("= {}", choice.inertia.name()), others]
    });
    let parameters = main.parameters.iter().map(|parameter| {
        let value = quantities::main(parameter.quantity, &parameter.number);
        [
            parameter.name.clone(),
            format!("= {value}"),
            format!("({})", source(parameter)),
        ]
    });
    let parameters = form.into_iter().chain(parameters);
    text.push_str(&first_of(aligned(parameters)));
    let [e_inf, st_c] = [Quantity::EInf, Quantity::StC].map(|quantity| quantity.describe().symbol);
    let shown = places(input);
    let of_one_source = shown.windows(2).all(|pair| pair[0].source == pair[1].source);
    let places = shown.iter().map(|place| {
        [
            format!("{}:", place_name(place)),
            format!("{e_inf} = {},", quantities::main(Quantity::EInf, &place.e_inf)),
            format!("{st_c} = {}", quantities::main(Quantity::StC, &place.st_c)),
            if of_one_source {
                String::new()
            } else {
                format!("({})", place.source.name())
            },
        ]
    });
    text.push_str(&first_of(aligned(places)));
    if let Some(first) = shown.first().filter(|_| of_one_source) {
        text.push_str(&format!("{e_inf} and {st_c} from: {}.", first.source.name()));
        let others = shown.len() < main.at.len();
        text.push_str(if others {
            " Those of every film ratio and liquid stand in the report.\n"
        } else {
            "\n"
        });
    }
    text
}

/// Whether the main numbers may be quoted; where not, a line for each check that forbids it, with what to do.
fn verdict_lines(findings: &Findings) -> String {
    let (lead, checks) = verdict(findings, str::to_owned);
    let lines: Vec<String> = checks.iter().map(|check| format!("- {check}\n")).collect();
    format!("Verdict: {lead}.{}\n{}", cautions_line(findings), lines.concat())
}

/// The places that stand for the others; where the square-root law serves, the posterior of each liquid stands in the
/// report alone.
fn places(input: ReportInput<'_>) -> Vec<&MainPlace> {
    let is_law = |place: &MainPlace| place.source == Source::SquareRootLaw;
    let here = |place: &MainPlace| {
        let diameter = place.diameter_m.map(f64::to_bits);
        (place.particle.clone(), place.film_ratio.to_bits(), diameter)
    };
    let mut shown = places_shown(&input.findings.main, input);
    let with_law: HashSet<_> = shown
        .iter()
        .filter(|place| is_law(place))
        .map(|place| here(place))
        .collect();
    shown.retain(|place| is_law(place) || !with_law.contains(&here(place)));
    shown
}

/// Rows as lines, each column as wide as its widest cell on a terminal.
fn aligned<const COLUMNS: usize>(rows: impl Iterator<Item = [String; COLUMNS]>) -> Vec<String> {
    let rows: Vec<[String; COLUMNS]> = rows.collect();
    let width = |column: usize| rows.iter().map(|row| display_width(&row[column])).max().unwrap_or(0);
    let widths: [usize; COLUMNS] = std::array::from_fn(width);
    let padded = |row: &[String; COLUMNS]| {
        let cells = row.iter().zip(widths);
        let cells = cells.map(|(cell, width)| format!("{cell}{}", " ".repeat(width - display_width(cell))));
        format!("{}\n", cells.collect::<Vec<_>>().join(" ").trim_end())
    };
    rows.iter().map(padded).collect()
}

/// The first of some lines, and how many more there are.
fn first_of(lines: Vec<String>) -> String {
    const SHOWN: usize = 20;
    let mut text = lines.iter().take(SHOWN).map(String::as_str).collect::<String>();
    if lines.len() > SHOWN {
        text.push_str(&format!(
            "and {} more lines of this kind in findings.json\n",
            lines.len() - SHOWN
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stand_below_each_other_whatever_the_letters() {
        let rows = [["k[球]", "= 0.18 ± 0.01", "(a)"], ["L", "= 2", "(posterior)"]];
        let lines = aligned(rows.into_iter().map(|row| row.map(str::to_owned)));
        assert_eq!(
            lines,
            ["k[球] = 0.18 ± 0.01 (a)\n", "L     = 2           (posterior)\n"]
        );
    }
}
