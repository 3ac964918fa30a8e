//! Tells which quantity a header names in place of the one that its column takes.

use super::super::words::{is_among, words_of};
use super::called::columns_called;
use super::header::{in_few_words, Header, Instead, ROOTS, SOURCES};
use super::quantities::{quantities_in, quantities_of_symbol, QUANTITIES};
use crate::scene::RunColumn;
use crate::units::Dimension;

/// Symbols of dimensionless numbers, which begin a name.
const NUMBERS: &str = "We Re Fr Bo Oh Ca St";

/// What a length or speed is divided by in a name: no unit is written so.
const DIVISORS: &str = "d r 2r dp d_p rp r_p ds d_s h0 h_0 v0 v_0 vi v_i diameter durchmesser radius";

/// Words for what has no unit, and for what was divided by another of its kind.
const PLAIN_NUMBERS: &str = "dimensionless dimensionslos scaled rescaled skaliert";
const NORMALISED: &str = "normalised normalized normiert";

/// Words for the direction along the plate.
const ALONG: &str = "tangential tangentiell tangentielle horizontal transverse";

/// Words of what comes before an impact, and of what comes after it.
pub(super) const ROLES: [&str; 2] = [
    "impact incoming incident aufprall auftreff aufprallgeschwindigkeit auftreffgeschwindigkeit drop release fallhöhe impacto impatto",
    "rebound reb bounce outgoing rückprall rücksprung rückprallgeschwindigkeit rückprallhöhe rücksprunghöhe rebond out rebote rimbalzo отскока",
];

/// Words that say that a quantity was taken before one of the two, and after it.
pub(super) const MOMENTS: [&str; 2] = ["before vor avant prior pre до", "after nach après post danach после"];

/// Words of what comes before the impact, after which a speed is that of the impact.
const FALLS: &str = "release drop fall";

/// What else has a size, as the first word of a header.
const OTHER_BODIES: &str = "container vessel nozzle plate wall tube pixel penetration capillary contact wetted";

/// Words for what was worked out and not measured.
const MODELS: &str = "theory theoretical theorie model modell fit fitted predicted calc calculated berechnet";

/// What a header that is no run's column names of the constants of materials: a viscosity or a density itself, by a word or the
/// usual symbol, and no spread, quotient or other kind of it.
pub(in crate::runs) fn constant_named(name: &str) -> Option<Dimension> {
    const SYMBOLS: [(&str, Dimension); 2] = [
        ("η eta visc", Dimension::Viscosity),
        ("ρ ρp ρs ρl ρf rho rhop rhos rhol rhof dens", Dimension::Density),
    ];
    const OTHERS: &str =
        "sd std se sem err error rel relative unc uncertainty kinematic kinematische cinématique number energy \
                          bulk packing air gas temperature";
    let header = Header::new(name);
    if header.has(OTHERS) || header.is_called_ratio() {
        return None;
    }
    let by_word = header.named.iter().find_map(|quantity| match quantity.name {
        "a viscosity" => Some(Dimension::Viscosity),
        "a density" => Some(Dimension::Density),
        _ => None,
    });
    let symbol = header.symbol.trim_end_matches(char::is_numeric);
    let is_meant = |symbols: &str| is_among(symbols, symbol) && !header.outside.contains('/');
    let by_symbol = SYMBOLS.into_iter().find(|(symbols, _)| is_meant(symbols));
    by_word.or(by_symbol.map(|(_, dimension)| dimension))
}

/// What a header names that its column does not take, with the column that does.
pub(super) fn named_quantity(header: &Header, column: RunColumn) -> Option<Instead> {
    if let Some(found) = other_function(header, column) {
        return Some((found, None));
    }
    let symbol = header.symbol;
    let is_stokes = symbol == "St";
    let is_number = is_among(NUMBERS, symbol) && !header.name[symbol.len()..].starts_with('-');
    if is_number && !(is_stokes && column == RunColumn::Stokes) {
        return Some(("a dimensionless number", is_stokes.then_some(RunColumn::Stokes)));
    }
    if let Some(right) = other_side(header, column) {
        return Some((in_few_words(right), Some(right)));
    }
    // a unit that the symbol cannot have says what it is
    if let Some(found) = header.of_unit.filter(|_| header.named.is_empty()) {
        let mut of_symbol = quantities_of_symbol(symbol).into_iter();
        // of the right symbol, one that another column has is refused as a unit
        let is_told = ["a length", "a speed"].contains(&found.name) && of_symbol.any(|own| own.is_of(column));
        return (!is_told && !found.shares_units_with(column)).then_some((found.name, None));
    }
    let is_own_symbol = header.of_symbol.iter().any(|quantity| quantity.is_of(column));
    let has_symbol = is_own_symbol || columns_called(symbol).contains(&column);
    if takes_ratios(column) && (header.is_quotient() || header.has("relative") || has_symbol) {
        return None;
    }
    if let Some(right) = column_elsewhere(header, column, is_own_symbol) {
        return Some((in_few_words(right), Some(right)));
    }
    // behind a symbol, brackets tell more of it, as the `(time of flight)` of a `v`
    let outside = has_symbol.then(|| quantities_in(&header.outside));
    let named = outside.as_ref().unwrap_or(&header.named);
    if named.iter().any(|quantity| quantity.is_of(column)) || header.has(SOURCES) {
        return None;
    }
    // one of its words is what the column is called
    let is_within = || header.words.iter().any(|word| columns_called(word).contains(&column));
    let is_known = has_symbol || !header.called.is_empty() || is_within();
    let by_symbol = header.of_symbol.first().filter(|_| !is_known);
    let found = named.first().or(by_symbol)?;
    let is_beside = |other: &RunColumn| other.is_of_rebound() == column.is_of_rebound();
    let right = found.columns().find(is_beside).or(found.columns().next());
    Some((found.name, right))
}

fn takes_ratios(column: RunColumn) -> bool {
    matches!(
        column,
        RunColumn::Restitution | RunColumn::FilmRatio | RunColumn::Stokes
    )
}

/// A function of its quantity that a header names, or one of another.
fn other_function(header: &Header, column: RunColumn) -> Option<&'static str> {
    let words: Vec<&str> = header.words.iter().map(String::as_str).collect();
    let outside: Vec<&str> = words_of(&header.outside).collect();
    let ends = [words.first(), words.last()];
    if ends.into_iter().flatten().any(|word| is_among("ln log lg log10", word)) {
        return Some("a logarithm");
    }
    let is_normal = matches!(
        column,
        RunColumn::Restitution | RunColumn::ImpactSpeed | RunColumn::ReboundSpeed
    );
    if is_normal && (header.has(ALONG) || matches!(words[..], ["e" | "cor" | "ε", "t", ..])) {
        return Some("what happens along the plate, not normal to it");
    }
    if column.is_of_rebound() && matches!(outside[..], [_, second] if is_among(MODELS, second)) {
        return Some("what a model gives, not what was measured");
    }
    let is_size = matches!(column, RunColumn::Diameter | RunColumn::Film);
    if is_size && words.first().is_some_and(|word| is_among(OTHER_BODIES, word)) && !header.has("film sphere ball") {
        return Some("the size of something else");
    }
    let is_length = matches!(column.dimension(), Dimension::Length | Dimension::Thickness);
    let is_quotient = header.is_quotient() || header.has("relative");
    let of_symbol = column == RunColumn::Restitution && !is_quotient && !header.has_square_sign();
    if header.contains(ROOTS) && (is_length || of_symbol && header.named.is_empty()) {
        return Some("a square root");
    }
    if is_inverse(&header.lower, column) {
        return Some("the inverse of what is expected");
    }
    // over that of dry runs, or over the threshold
    let is_over = |start: &str| header.divisor().is_some_and(|after| after.starts_with(start));
    let is_relative = match column {
        RunColumn::Restitution => header.has(NORMALISED) || !header.contains(ROOTS) && (is_over("e_") || is_over("e0")),
        RunColumn::Stokes => is_over("st") || header.has("critical crit kritisch kritische"),
        _ => false,
    };
    if is_relative {
        return Some("a ratio to another of its kind, or that other");
    }
    let is_power = ["^1/", "^(1/", "^0."].iter().any(|power| header.lower.contains(power));
    if is_power && !header.contains(ROOTS) {
        return Some("a power of what is expected");
    }
    let is_plain = header.contains("/√ /sqrt") || header.has(PLAIN_NUMBERS) || header.has(NORMALISED);
    let is_divided = header.divisor().is_some_and(|after| is_among(DIVISORS, after));
    let is_ratio = header.is_called_ratio() || is_plain || is_divided;
    (is_ratio && !takes_ratios(column) && !header.has(SOURCES)).then_some("a ratio")
}

/// The column of the same quantity on the other side of the impact, where a header names that side.
fn other_side(header: &Header, column: RunColumn) -> Option<RunColumn> {
    let right = column.other_side()?;
    let (own, other) = if column.is_of_rebound() { (1, 0) } else { (0, 1) };
    let is_of = |side: usize| header.has_end(ROLES[side]);
    // the prime of a `v'`; what goes on behind it is the apostrophe of a word
    let behind = header.lower.trim_start_matches(char::is_alphanumeric);
    let is_primed = behind
        .strip_prefix(['\'', '′'])
        .is_some_and(|after| !after.starts_with(char::is_alphabetic));
    let is_other = if MOMENTS.iter().any(|side| header.has(side)) {
        // what comes before a rebound is the impact, and what comes after an impact the rebound
        let is_of_another = header.has(FALLS) || own == 1 && is_of(own);
        header.has(MOMENTS[other]) && !header.has(MOMENTS[own]) && !is_of_another
    } else {
        is_of(other) && !is_of(own) && !header.has(SOURCES) || is_primed && other == 1
    };
    is_other.then_some(right)
}

/// The first of the columns that a header is called like, if the own one is none of them.
fn column_elsewhere(header: &Header, column: RunColumn, is_own_symbol: bool) -> Option<RunColumn> {
    // a column of spheres may hold their diameters, and one of liquids the films
    let may_hold = match column {
        RunColumn::Diameter => Some(RunColumn::Particle),
        RunColumn::Film => Some(RunColumn::Liquid),
        RunColumn::FilmRatio => Some(RunColumn::Film),
        _ => None,
    };
    let is_own = |of: &RunColumn| *of == column || Some(*of) == may_hold;
    let stem_of = |name: &str| name.to_lowercase().trim_end_matches(char::is_numeric).to_owned();
    let stem = stem_of(&header.letters);
    // the `v` of a rebound, the `h0` of a film; a number says before or after an impact
    let has_number = stem != header.letters && column.other_side().is_some();
    let is_symbol = !has_number && is_own_symbol && stem_of(header.symbol) == stem;
    let mut own = QUANTITIES.iter().filter(|quantity| quantity.is_of(column));
    let is_word = own.any(|quantity| is_among(quantity.words, &header.letters));
    let is_elsewhere = !is_symbol && !is_word && !header.called.iter().any(is_own);
    header.called.first().copied().filter(|_| is_elsewhere)
}

/// Whether a quotient stands upside down, as `v_i/v_r` does of a restitution.
fn is_inverse(lower: &str, column: RunColumn) -> bool {
    let has_power = ["^-1", "⁻¹", "inverse"].iter().any(|power| lower.contains(power));
    if lower.starts_with("1/") || takes_ratios(column) && has_power {
        return true;
    }
    let below = match column {
        RunColumn::Restitution => [RunColumn::ReboundSpeed, RunColumn::Restitution],
        RunColumn::FilmRatio => [RunColumn::Film, RunColumn::FilmRatio],
        _ => return false,
    };
    let after = lower.split_once(['/', ':']).map(|(_, after)| columns_called(after));
    after.is_some_and(|called| !called.is_empty() && called.iter().all(|of| below.contains(of)))
}
