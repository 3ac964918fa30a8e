//! Asks about a word in the place of a unit that is neither a unit nor a remark that is known.

use super::super::words::{ends_like, is_among, without_brackets, words_of};
use super::called::columns_called;
use super::heights::OF_HEIGHTS;
use super::named::{MOMENTS, ROLES};
use super::quantities::{quantities_in, quantities_of_symbol, Quantity, QUANTITIES};
use super::units::{in_brackets, unit_of, unit_of_kind, StatedUnit, MARKS};
use crate::error::quoted;
use crate::scene::RunColumn;
use crate::units::Dimension;

/// Words before a unit.
const BEFORE_UNITS: [&str; 3] = ["in ", "en ", "em "];

/// The first word in the place of a unit in the name of a length or a speed that is neither one nor a remark that is known, as
/// in `h (cubits)`, `h, cubits`, `h / cubits`, `h en cubits` or, if it alone stands behind the quantity, `h cubits`.
pub(in crate::runs) fn unknown_word(name: &str, dimension: Dimension) -> Option<String> {
    /// letters of a word behind a quantity: fewer may be an index
    const FEWEST: usize = 4;
    if !matches!(dimension, Dimension::Length | Dimension::Thickness | Dimension::Speed) {
        return None;
    }
    let outside = without_brackets(name);
    let inside = in_brackets(name).map(|own| own.inside);
    let behind_slash = outside.rsplit_once('/').map(|(_, after)| after);
    let behind_word = BEFORE_UNITS
        .iter()
        .filter_map(|word| Some(outside.rsplit_once(&format!(" {word}"))?.1));
    // the last word, or the last quotient
    let ends = [
        outside.trim_end().rsplit_once(MARKS),
        outside.trim_end().rsplit_once(' '),
    ];
    let is_alone = |(before, after): &(&str, &str)| {
        let is_word = after.chars().count() >= FEWEST && !after.contains('-');
        is_word && is_quantity(before.trim_end_matches(MARKS))
    };
    let behind_name = ends.into_iter().flatten().filter(is_alone);
    let places = inside
        .chain(outside.split([',', ';']).skip(1))
        .chain(behind_slash)
        .chain(behind_word)
        .chain(behind_name.map(|(_, after)| after));
    let mut texts = places.flat_map(|place| place.split([',', ';']).map(str::trim));
    texts.find(|text| is_unknown(text)).map(str::to_owned)
}

/// The unit that a line about a table states for a column, as `Drop heights in inches` or `all lengths in cm`, of which the
/// former goes first.
pub(in crate::runs) fn unit_in_line(line: &str, column: RunColumn) -> Option<StatedUnit> {
    const LENGTHS: &str =
        "lengths längen longueurs dimensions maße units unit einheit einheiten unités unidades ruler lineal";
    /// letters of what stands before a colon: fewer are the name of a column
    const FEWEST: usize = 4;
    let is_length = matches!(column.dimension(), Dimension::Length | Dimension::Thickness);
    let is_own = |of: RunColumn| of == column || Some(of) == column.other_side();
    let is_of_column = |quantity: &&Quantity| quantity.columns().next().is_some_and(is_own);
    let is_named = |word: &str| quantities_in(word).iter().any(is_of_column) || columns_called(word).contains(&column);
    let is_any_length = |word: &str| is_length && is_among(LENGTHS, word);
    let lower = line.to_lowercase();
    let stated_by = |is_meant: &dyn Fn(&str) -> bool| {
        lower.split([',', ';', '.']).find_map(|part| {
            let behind_word = BEFORE_UNITS
                .iter()
                .find_map(|word| part.rsplit_once(&format!(" {word}")));
            // what stands before a colon is the name of another column
            let behind_word = behind_word.filter(|(what, _)| !what.trim_end().ends_with(':'));
            let inside = in_brackets(part).map(|place| (place.before, place.inside));
            let behind_colon = part.rsplit_once(':');
            let behind_colon = behind_colon.filter(|(what, _)| what.trim().chars().count() >= FEWEST);
            let mut places = behind_word.into_iter().chain(inside).chain(behind_colon);
            let stated = |(what, unit): (&str, &str)| {
                unit_of_kind(unit.trim(), column.dimension()).filter(|_| words_of(what).any(is_meant))
            };
            places.find_map(stated)
        })
    };
    stated_by(&is_named).or_else(|| stated_by(&is_any_length))
}

/// What is said of such a word.
pub(in crate::runs) fn in_no_unit(word: &str) -> String {
    format!("may be in {}, which is no unit that is known", quoted(word))
}

/// Whether a text is the name of a quantity and nothing else.
fn is_quantity(text: &str) -> bool {
    let is_word = |quantity: &Quantity| is_among(quantity.words, &text.to_lowercase());
    let is_symbol = !quantities_of_symbol(text).is_empty();
    is_symbol || !columns_called(text).is_empty() || QUANTITIES.iter().any(is_word)
}

/// Whether a text is one word, or a quotient of words, and neither a unit nor a remark. What has numbers or several words is
/// prose, in which a unit would have been found.
fn is_unknown(text: &str) -> bool {
    let starts = BEFORE_UNITS.iter().find_map(|word| text.strip_prefix(word));
    let text = starts.unwrap_or(text);
    let mut parts = text.split('/').map(str::trim);
    let is_word = |part: &str| part.contains(char::is_alphabetic) && !part.contains(char::is_whitespace);
    let is_prose = text.contains(char::is_numeric) || !parts.clone().all(is_word);
    !is_prose && unit_of(text).is_none() && !parts.all(is_remark)
}

/// Whether a word is a symbol, an abbreviation in capitals, the name of a quantity or column, or says how, when or of what
/// something was measured.
fn is_remark(word: &str) -> bool {
    /// letters of an abbreviation
    const ABBREVIATION: std::ops::RangeInclusive<usize> = 2..=4;
    /// ends of words that say how something was measured, and letters of such a word, at least
    const FEWEST: usize = 6;
    const ENDS: [&str; 6] = ["ed", "ing", "ly", "tion", "ung", "iert"];
    /// units that are symbols of speeds, too
    const VOLT_AND_WATT: &str = "V W";
    if unit_of(word).is_some() || is_among(VOLT_AND_WATT, word) {
        return false;
    }
    let plain = word.trim_start_matches(|c: char| !c.is_alphanumeric());
    let symbol = plain.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let is_abbreviation = ABBREVIATION.contains(&word.chars().count()) && word.chars().all(char::is_uppercase);
    if is_abbreviation || !quantities_of_symbol(symbol).is_empty() || !columns_called(word).is_empty() {
        return true;
    }
    let remarks = include_str!("remarks.txt")
        .lines()
        .filter(|line| !line.starts_with('#'));
    let lists = || remarks.clone().chain(OF_HEIGHTS).chain(ROLES).chain(MOMENTS);
    let is_known = |word: &str| {
        let is_long = word.chars().count() >= FEWEST;
        let has_end = || ENDS.iter().any(|end| word.ends_with(end));
        is_long && has_end() || !quantities_in(word).is_empty() || lists().any(|list| ends_like(list, word))
    };
    words_of(&word.to_lowercase()).all(is_known)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::tests::examples;

    #[test]
    fn what_is_no_unit_and_no_remark_is_asked_about() {
        for (answer, names) in examples("word") {
            for name in names {
                let expected = Some(answer).filter(|answer| *answer != "none");
                assert_eq!(unknown_word(name, Dimension::Length).as_deref(), expected, "{name}");
            }
        }
        assert_eq!(unknown_word("e (cubits)", Dimension::Share), None);
    }

    #[test]
    fn a_line_about_a_table_states_units_of_what_it_names() {
        let stated = |line: &str| {
            let mut of = vec![];
            for column in [
                RunColumn::DropHeight,
                RunColumn::Film,
                RunColumn::ImpactSpeed,
                RunColumn::Restitution,
            ] {
                of.extend(unit_in_line(line, column).map(|unit| (column.base(), unit)));
            }
            of
        };
        let other = |unit: &str| StatedUnit::Other(unit.to_owned());
        let ours = StatedUnit::Ours;
        for (line, expected) in [
            ("# Drop heights in inches", vec![("drop_height", other("inches"))]),
            (
                "All lengths in ft.",
                vec![("drop_height", other("ft")), ("film", other("ft"))],
            ),
            (
                "film thickness in mm; speeds in cm/s",
                vec![("film", ours("_mm")), ("impact_speed", ours("_cm_s"))],
            ),
            ("Restitution (COR) in %", vec![("restitution", ours("_percent"))]),
            ("Speeds and heights in cm and mm", vec![]),
            ("drop height [inch]", vec![("drop_height", other("inch"))]),
            ("Höhen in Zoll", vec![("drop_height", other("zoll"))]),
            ("drop height: inch", vec![("drop_height", other("inch"))]),
            ("Units: ft", vec![("drop_height", other("ft")), ("film", other("ft"))]),
            (
                "Units: mm; film in µm",
                vec![("drop_height", ours("_mm")), ("film", ours("_um"))],
            ),
            ("h0: ft", vec![]),
            ("Impact speed of 4 mm spheres in air", vec![]),
            ("Heights by ruler, in the new box", vec![]),
        ] {
            assert_eq!(stated(line), expected, "{line}");
        }
    }
}
