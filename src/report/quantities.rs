//! Writes quantities under their symbols, in the units they are printed in.

use crate::model::parameters::ParameterKind;
use crate::physics::Quantity;
use crate::runs::Runs;
use crate::scene::Scene;
use crate::units::micrometres;

/// What a quantity is printed in, and how many of it its own unit has: a length in µm, everything else in its own unit.
fn printed_unit(quantity: Quantity) -> (&'static str, f64) {
    match quantity.describe().unit {
        "m" => ("µm", micrometres(1.0)),
        own => (own, 1.0),
    }
}

/// How many of the unit that a quantity is printed in its own unit has.
pub fn factor(quantity: Quantity) -> f64 {
    printed_unit(quantity).1
}

/// A unit as it stands behind a symbol: one that is a quotient in brackets, with the minus of formulas.
pub fn unit_in_brackets(unit: &str) -> String {
    let unit = unit.replace('-', "−");
    if unit.contains('/') && !unit.starts_with('(') {
        format!("({unit})")
    } else {
        unit
    }
}

/// The symbol with the unit it is printed in: `δc / µm`.
pub fn label(quantity: Quantity) -> String {
    let symbol = quantity.describe().symbol;
    match printed_unit(quantity).0 {
        "1" => symbol.to_owned(),
        unit => format!("{symbol} / {}", unit_in_brackets(unit)),
    }
}

/// A parameter's symbol, with its particle and diameter where it is of one.
pub fn parameter_label(scene: &Scene, runs: &Runs, kind: ParameterKind, symbol: &str) -> String {
    match kind {
        ParameterKind::DryK(sphere) => format!("{symbol}, {}", runs.spheres[sphere].words(scene)),
        _ => symbol.to_owned(),
    }
}

/// A symbol or unit as a chart sets it, `e_inf²` as `e_{inf}^{2}`: what follows an underscore below the line, and so a
/// digit behind a letter; squares and powers above it.
pub fn in_scripts(text: &str) -> String {
    let mut label = String::new();
    let mut letters = text.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '_' => {
                label.push_str("_{");
                while let Some(letter) = letters.next_if(|c| c.is_alphanumeric() && *c != '²') {
                    label.push(letter);
                }
                label.push('}');
            }
            '²' => label.push_str("^{2}"),
            '^' if letters.next_if_eq(&'(').is_some() => {
                let power: String = letters.by_ref().take_while(|c| *c != ')').collect();
                label.push_str(&format!("^{{{power}}}"));
            }
            digit if digit.is_ascii_digit() && letters.peek().is_none() && !label.is_empty() => {
                label.push_str(&format!("_{{{digit}}}"));
            }
            other => label.push(other),
        }
    }
    label
}
