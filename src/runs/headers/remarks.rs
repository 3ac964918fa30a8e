//! Asks about a word in the place of a unit that is neither a unit nor a remark that is known.

use super::super::words::{ends_like, without_brackets, words_of};
use super::called::columns_called;
use super::heights::OF_HEIGHTS;
use super::named::{MOMENTS, ROLES};
use super::quantities::{quantities_in, quantities_of_symbol};
use super::units::{in_brackets, unit_of};
use crate::units::Dimension;

/// Words before a unit.
const BEFORE_UNITS: [&str; 3] = ["in ", "en ", "em "];

/// The first word in the place of a unit in the name of a length or a speed that is neither one nor a remark that is known, as
/// in `h (cubits)`, `h, cubits`, `h / cubits` or `h en cubits`.
pub(in crate::runs) fn unknown_word(name: &str, dimension: Dimension) -> Option<String> {
    if !matches!(dimension, Dimension::Length | Dimension::Thickness | Dimension::Speed) {
        return None;
    }
    let outside = without_brackets(name);
    let inside = in_brackets(name).map(|own| own.inside);
    let behind_slash = outside.rsplit_once('/').map(|(_, after)| after);
    let behind_word = BEFORE_UNITS
        .iter()
        .filter_map(|word| Some(outside.rsplit_once(&format!(" {word}"))?.1));
    let places = inside
        .chain(outside.split([',', ';']).skip(1))
        .chain(behind_slash)
        .chain(behind_word);
    let mut texts = places.flat_map(|place| place.split([',', ';']).map(str::trim));
    texts.find(|text| is_unknown(text)).map(str::to_owned)
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
    if unit_of(word).is_some() {
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
}
