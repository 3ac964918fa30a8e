//! Matches the header of a table with the columns it may have, whatever their units.

use super::columns::{present, ColumnPlace};
use super::decimals::Decimals;
use super::refusals::CellPlace;
use crate::error::{quoted, Problem};
use crate::scene::{closest, letters_apart};
use crate::units::{names_in_words, Dimension};

/// A column that a table may have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    /// its name, without a unit
    pub base: &'static str,
    /// `One` of words and plain numbers
    pub dimension: Dimension,
    pub needed: bool,
}

/// A column of such a table.
pub(crate) const fn column(base: &'static str, dimension: Dimension, needed: bool) -> Column {
    Column {
        base,
        dimension,
        needed,
    }
}

/// The columns that were asked for, in their order, and the names of those that nobody reads.
#[derive(Debug)]
pub(crate) struct FoundColumns {
    pub columns: Vec<Option<ColumnPlace>>,
    pub unread: Vec<String>,
    /// by their places among the columns
    decimals: Decimals<usize>,
}

impl FoundColumns {
    /// Those of a header that is yet to come.
    pub fn none() -> FoundColumns {
        FoundColumns {
            columns: vec![],
            unread: vec![],
            decimals: Decimals::new(),
        }
    }

    /// The number of a cell in a column, in its unit; `None` of a missing one, or what was expected.
    pub fn number(&mut self, column: usize, cell: &str, line: u64) -> Result<Option<f64>, String> {
        let Some(text) = present(cell) else {
            return Ok(None);
        };
        let number = self.decimals.read(text, column, CellPlace::Line(line))?;
        let is_finite = number.is_finite();
        is_finite
            .then_some(Some(number))
            .ok_or("expected a finite number".to_owned())
    }

    /// The problem of a number with a comma where none of all commas tells what they set off.
    pub fn doubt(&mut self) -> Option<Problem> {
        let doubt = self.decimals.doubt()?;
        Some(Problem {
            line: Some(doubt.place.number()),
            place: self.columns[doubt.column].as_ref()?.name.clone(),
            found: Some(quoted(&doubt.text)),
            expected: doubt.expected,
        })
    }
}

/// Letters by which the name of a column may differ from a known one and be it misspelt.
const MISSPELT: usize = 2;

/// Finds columns in a header. Fails where one is missing, stands twice or is misspelt.
pub(crate) fn find(names: &[String], line: u64, wanted: &[Column]) -> Result<FoundColumns, Vec<Problem>> {
    let mut found = FoundColumns {
        columns: vec![None; wanted.len()],
        ..FoundColumns::none()
    };
    let mut problems = vec![];
    let problem = |named: Option<&str>, expected: String| Problem {
        line: Some(line),
        place: "header".to_owned(),
        found: named.map(quoted),
        expected,
    };
    let all = || {
        wanted
            .iter()
            .flat_map(|column| column.dimension.units().iter().map(move |unit| (column, unit)))
    };
    for (index, name) in names.iter().enumerate() {
        let named = wanted.iter().enumerate().find_map(|(place, column)| {
            let suffix = name.strip_prefix(column.base)?;
            let unit = column.dimension.units().iter().find(|unit| unit.suffix == suffix)?;
            Some((place, unit))
        });
        let Some((place, unit)) = named else {
            let known: Vec<String> = all()
                .map(|(column, unit)| format!("{}{}", column.base, unit.suffix))
                .collect();
            let near = known
                .iter()
                .find(|known| letters_apart(name, known, MISSPELT).is_some());
            match near {
                Some(near) if near.len() > 2 * MISSPELT => {
                    problems.push(problem(Some(name), format!("expected `{near}`")))
                }
                _ if name.is_empty() => {}
                _ => found.unread.push(quoted(name)),
            }
            continue;
        };
        if let Some(before) = &found.columns[place] {
            let expected = format!("expected one column for it; {} is there already", quoted(&before.name));
            problems.push(problem(Some(name), expected));
            continue;
        }
        found.columns[place] = Some(ColumnPlace {
            index,
            name: name.clone(),
            unit,
        });
    }
    for (column, place) in wanted.iter().zip(&found.columns) {
        if column.needed && place.is_none() {
            let names = names_in_words(column.base, column.dimension);
            let near = closest(column.base, found.unread.iter().map(|name| name.trim_matches('`')));
            let hint = near.map_or(String::new(), |near| format!("; {} may be it", quoted(near)));
            problems.push(problem(None, format!("expected a column {names}{hint}")));
        }
    }
    if problems.is_empty() {
        Ok(found)
    } else {
        Err(problems)
    }
}
