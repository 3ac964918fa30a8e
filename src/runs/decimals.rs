//! Finds how a text separates its columns, and reads its numbers, whichever mark their decimals have.

use super::refusals::CellPlace;
use crate::files::MOST_COLUMNS;
use crate::scene::{Naming, RunColumn};

/// What may stand between columns; of those that part a header into as many, the first.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

/// The byte between two columns: that which parts a header into most names that are known, of such into most names, and of
/// such into most parts.
pub(super) fn separator_of(header: &str, naming: &Naming) -> u8 {
    let is_known = |name: &str| {
        let theirs = naming.columns.iter().any(|(_, theirs)| theirs == name);
        theirs || RunColumn::named(name).is_some()
    };
    let names = |separator: &u8| {
        let mut is_quoted = false;
        let parted = header.split(|letter: char| {
            is_quoted ^= letter == '"';
            !is_quoted && letter == char::from(*separator)
        });
        let names: Vec<&str> = parted
            .take(MOST_COLUMNS)
            .map(|name| name.trim().trim_matches('"').trim())
            .collect();
        // blanks beside a separator name nothing, but beside a title alone they tell the separator
        let named = names.iter().filter(|name| name.contains(char::is_alphanumeric));
        let known = names.iter().filter(|name| is_known(name));
        (known.count(), named.count(), names.len())
    };
    // of equals the last
    SEPARATORS.into_iter().rev().max_by_key(names).unwrap_or(b',')
}

/// What sets off the decimals of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecimalMark {
    Point,
    Comma,
    /// a comma that may set off thousands, since three digits come after it and others before
    CommaOrThousands,
}

/// A number as a cell has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WrittenNumber {
    pub value: f64,
    /// `None` without decimals
    pub mark: Option<DecimalMark>,
}

/// The number a cell that is not missing holds, or what was expected of it.
pub(super) fn parse_number(cell: &str) -> Result<WrittenNumber, String> {
    let with_point = || {
        let mark = cell.as_bytes().contains(&b'.').then_some(DecimalMark::Point);
        let value = cell.parse().ok()?;
        Some(WrittenNumber { value, mark })
    };
    if let Some(number) = with_point().or_else(|| with_comma(cell)) {
        // one that is too small to be held became 0
        let has_digits = || {
            let mantissa = cell.split(['e', 'E']).next().unwrap_or_default();
            mantissa.contains(|c: char| c.is_ascii_digit() && c != '0')
        };
        return match number.value == 0.0 && has_digits() {
            true => Err("expected 0, or a number that is not so small".to_owned()),
            false => Ok(number),
        };
    }
    let has_both = cell.contains(',') && cell.contains('.');
    let hint = if has_both {
        " with one decimal mark and none for thousands"
    } else if cell.ends_with('%') {
        " without %; restitutions in per cent stand in a column `restitution_percent`"
    } else {
        ""
    };
    Err(format!("expected a number{hint}"))
}

/// Half of the last digit that is written, as a share of the number; 0 of no number.
pub(super) fn rounding_of(cell: &str) -> f64 {
    let cell = cell.trim();
    let digits = cell.find(['e', 'E']).map_or(cell, |end| &cell[..end]);
    let decimals = digits.find(['.', ',']).map_or(0, |mark| digits.len() - mark - 1);
    let value = parse_number(digits).map_or(0.0, |number| number.value.abs());
    let decimals = i32::try_from(decimals).unwrap_or(i32::MAX);
    if value > 0.0 {
        0.5 * 0.1f64.powi(decimals) / value
    } else {
        0.0
    }
}

/// A number whose decimals a comma sets off.
fn with_comma(cell: &str) -> Option<WrittenNumber> {
    let (whole, decimals) = cell.split_once(',')?;
    if decimals.contains(['.', ',']) || whole.contains('.') {
        return None;
    }
    let value = format!("{whole}.{decimals}").parse().ok()?;
    let digits = whole.trim_start_matches(['+', '-']);
    let may_be_thousands = decimals.len() == 3 && !digits.is_empty() && !digits.starts_with('0') && digits.len() <= 3;
    let mark = match may_be_thousands {
        true => DecimalMark::CommaOrThousands,
        false => DecimalMark::Comma,
    };
    Some(WrittenNumber {
        value,
        mark: Some(mark),
    })
}

/// Reads the numbers of a table, all of which must have one decimal mark: with both in it no number is sure. `C` says in which
/// column a number stands.
#[derive(Debug)]
pub(crate) struct Decimals<C> {
    /// whether the first mark is a point, and where it stands
    first: Option<(bool, CellPlace)>,
    /// whether a comma sets off decimals for certain
    has_comma: bool,
    /// the first number with a comma that may set off thousands
    ambiguous: Option<(CellPlace, C, String)>,
}

impl<C> Decimals<C> {
    /// Of a table of which no number was read yet.
    pub fn new() -> Decimals<C> {
        Decimals {
            first: None,
            has_comma: false,
            ambiguous: None,
        }
    }

    /// The number of a cell that is not missing, or what was expected of it.
    pub fn read(&mut self, cell: &str, column: C, place: CellPlace) -> Result<f64, String> {
        let WrittenNumber { value, mark } = parse_number(cell)?;
        let Some(mark) = mark else {
            return Ok(value);
        };
        let is_point = mark == DecimalMark::Point;
        let (has_points, first) = *self.first.get_or_insert((is_point, place));
        let may_be_thousands = mark == DecimalMark::CommaOrThousands;
        if is_point != has_points {
            let mark = if has_points { "decimal point" } else { "decimal comma" };
            let or_thousands = if may_be_thousands {
                ", and no mark for thousands"
            } else {
                ""
            };
            let first = first.words();
            return Err(format!("expected a {mark}, as {first} has{or_thousands}"));
        }
        self.has_comma |= mark == DecimalMark::Comma;
        if may_be_thousands {
            self.ambiguous.get_or_insert_with(|| (place, column, cell.to_owned()));
        }
        Ok(value)
    }

    /// The first number with a comma where none of all commas tells what they set off: its place and column, its text, and what
    /// was expected.
    pub fn doubt(&mut self) -> Option<(CellPlace, C, String, String)> {
        let (place, column, text) = self.ambiguous.take().filter(|_| !self.has_comma)?;
        let expected = format!(
            "expected a decimal point, or elsewhere in the file a decimal comma that cannot set off thousands: this may be \
             {} or {}",
            text.replacen(',', "", 1),
            text.replacen(',', ".", 1)
        );
        Some((place, column, text, expected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_separator_is_the_one_that_parts_most() {
        for (header, separator) in [
            ("\"a;b;c;d\",liquid", b','),
            ("\"v, m/s\";\"D, mm\"", b';'),
            ("particle", b','),
            ("ball 3\t\t", b'\t'),
            ("particle\t,\tliquid \t,film_um", b','),
            ("", b','),
        ] {
            assert_eq!(separator_of(header, &Naming::default()), separator, "{header}");
        }
    }

    #[test]
    fn a_comma_sets_off_decimals_unless_it_may_be_thousands() {
        let read = |cell: &str| {
            parse_number(cell).map(|number| (number.value, number.mark == Some(DecimalMark::CommaOrThousands)))
        };
        for (cell, value, ambiguous) in [
            ("1,5e-3", 1.5e-3, false),
            ("-0,5", -0.5, false),
            (",5", 0.5, false),
            ("0,714", 0.714, false),
            ("4,762", 4.762, true),
            ("0e-400", 0.0, false),
            ("4762,125", 4762.125, false),
        ] {
            assert_eq!(read(cell), Ok((value, ambiguous)), "{cell}");
        }
        for cell in ["1.234,5", "1,234.5", "1,2,3", "high", ",", "1e-400", "0,1e-400"] {
            assert!(read(cell).is_err(), "{cell}");
        }
    }
}
