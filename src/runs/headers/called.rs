//! Knows what laboratories call the columns of runs, by `called.txt`.

use super::super::words::{is_among, without_brackets};
use super::units::{unit_in_brackets, unit_of, StatedUnit};
use crate::scene::RunColumn;

/// A line a column.
const CALLED: &str = include_str!("called.txt");

/// The columns of the lines that begin with a word, each with what it is called.
pub(in crate::runs) fn called(start: &str) -> impl Iterator<Item = (RunColumn, &'static str)> + '_ {
    CALLED.lines().filter_map(move |line| {
        let (column, names) = line.strip_prefix(start)?.split_once(": ")?;
        Some((RunColumn::of_base(column)?, names))
    })
}

/// What a header is called without its unit, in letters and digits, and the columns that are called so.
pub(super) fn called_as(header: &str) -> (String, Vec<RunColumn>) {
    let of = |letters: String| {
        let is_meant = |names: &str| is_among(names, &letters) || is_short_for(names, header);
        let all = called("").filter(|(column, names)| is_meant(names) || self::letters(column.base()) == letters);
        let columns: Vec<RunColumn> = all.map(|(column, _)| column).collect();
        (letters, columns)
    };
    // the `in` of `v_in` is a part of the name
    let whole = of(letters(header));
    if whole.1.is_empty() {
        of(parted(header).0)
    } else {
        whole
    }
}

/// The columns that are called like a header, its unit aside.
pub(in crate::runs) fn columns_called(header: &str) -> Vec<RunColumn> {
    called_as(header).1
}

/// Whether a name with a point at its end is one of a list cut short, as `Fallgeschw.` is.
pub(in crate::runs) fn is_short_for(names: &str, header: &str) -> bool {
    const FEWEST: usize = 5;
    let name = without_brackets(header);
    let start = name.trim_end().strip_suffix('.').map(letters).unwrap_or_default();
    start.chars().count() >= FEWEST && names.split(' ').any(|own| own.starts_with(&start))
}

/// The letters and digits of a name, in lower case.
pub(in crate::runs) fn letters(name: &str) -> String {
    let lower = name.to_lowercase();
    lower.chars().filter(|c| c.is_alphanumeric()).collect()
}

/// A name without its unit, by letters and digits alone, and that unit.
pub(in crate::runs) fn parted(name: &str) -> (String, Option<StatedUnit>) {
    // in brackets, or after a slash, a comma, a blank or an underscore
    if let Some((before, unit)) = unit_in_brackets(name) {
        return (letters(before), Some(unit));
    }
    for (at, mark) in name.char_indices().filter(|(_, c)| " /,_".contains(*c)) {
        let after = name[at + mark.len_utf8()..].trim_start_matches("in ");
        // the m/s of `v / m/s` is whole, and of `v_m_s` too
        if let Some(unit) = unit_of(after).or_else(|| unit_of(&after.replace('_', "/"))) {
            return (letters(&name[..at]), Some(unit));
        }
    }
    (letters(name), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_names_is_of_a_column() {
        let lines = CALLED.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        assert_eq!(called("").chain(called("like ")).count(), lines.count());
    }
}
