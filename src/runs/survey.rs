//! Surveys the columns of a table without a scene: what each is called, and what stands in it.

use std::collections::HashSet;

use super::columns::present;
use super::decimals::parse_number;

/// A column of a table of which nothing is known but its cells.
#[derive(Debug, Clone, Default)]
pub(super) struct SurveyedColumn {
    /// its name
    pub name: String,
    /// the first different words in it, at most [`SurveyedColumn::MOST_WORDS`], in the order they come
    pub words: Vec<String>,
    known: HashSet<String>,
    /// whether it has more words than are kept
    pub has_more: bool,
    /// largest number
    pub largest: Option<f64>,
}

/// A table of which nothing is known but its cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Survey {
    pub columns: Vec<SurveyedColumn>,
    pub rows: usize,
}

impl Survey {
    pub fn new(names: Vec<String>) -> Survey {
        let column = |name| SurveyedColumn {
            name,
            ..SurveyedColumn::default()
        };
        Survey {
            columns: names.into_iter().map(column).collect(),
            rows: 0,
        }
    }

    /// Adds a row; cells that it lacks are missing, those beyond the header are not seen.
    pub fn add<'c>(&mut self, cells: impl IntoIterator<Item = Option<&'c str>>) {
        self.rows += 1;
        let mut cells = cells.into_iter();
        for column in &mut self.columns {
            column.add(cells.next().flatten());
        }
    }
}

impl SurveyedColumn {
    /// Names of particles or liquids that one table may well have.
    pub const MOST_WORDS: usize = 100;

    /// Adds a cell.
    pub fn add(&mut self, cell: Option<&str>) {
        let Some(cell) = cell.and_then(present) else {
            return;
        };
        if let Ok(number) = parse_number(cell) {
            self.largest = Some(self.largest.map_or(number.value, |most| most.max(number.value)));
        }
        if self.known.contains(cell) {
            return;
        }
        if self.words.len() == SurveyedColumn::MOST_WORDS {
            self.has_more = true;
            return;
        }
        self.known.insert(cell.to_owned());
        self.words.push(cell.to_owned());
    }
}
