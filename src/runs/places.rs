//! Says where a row stands as a person sees it: by file, sheet, line or row, and the label of its run.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::error::{and_more, quoted};

/// Lines, or rows of a sheet, on which the rows of a table stand, with the labels of their runs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct RowLines {
    /// rows, from 1, whose line does not follow that of the row before, with their lines
    breaks: Vec<(u32, u64)>,
    /// labels with their rows, in order
    labels: Vec<(u32, String)>,
    /// last line that was read
    last: u64,
}

impl RowLines {
    /// Labels that are kept: of longer tables runs are named by their lines alone.
    const MOST_LABELS: usize = 100_000;

    /// Adds the next row.
    pub fn push(&mut self, row: usize, line: u64, label: Option<&str>) {
        if line != self.last + 1 || self.breaks.is_empty() {
            self.breaks.push((short(row), line));
        }
        self.last = line;
        if let Some(label) = label.filter(|_| self.labels.len() < RowLines::MOST_LABELS) {
            self.labels.push((short(row), label.to_owned()));
        }
    }

    /// The line of a row.
    fn line(&self, row: u32) -> Option<u64> {
        let at = self.breaks.partition_point(|(first, _)| *first <= row).checked_sub(1)?;
        let (first, line) = self.breaks[at];
        Some(line + u64::from(row - first))
    }

    fn label(&self, row: u32) -> Option<&str> {
        let at = self.labels.binary_search_by_key(&row, |(row, _)| *row).ok()?;
        Some(&self.labels[at].1)
    }
}

/// Rows that a message names.
const NAMED: usize = 5;

/// The first of some rows, each with what is to be said of it, and how many there are.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct NamedRows<T> {
    pub first: Vec<(u32, T)>,
    pub count: usize,
}

impl<T: Clone> NamedRows<T> {
    pub fn push(&mut self, row: u32, with: T) {
        self.count += 1;
        if self.first.len() < NAMED {
            self.first.push((row, with));
        }
    }

    /// Adds those of the next table, before which so many rows come.
    pub fn extend(&mut self, table: &NamedRows<T>, rows_before: u32) {
        let later = table.first.iter().cloned();
        let later = later.map(|(row, with)| (row.saturating_add(rows_before), with));
        self.first.extend(later);
        self.first.truncate(NAMED);
        self.count += table.count;
    }

    /// Where the first of them stand, each with these words behind it, and how many more there are.
    pub fn in_words(&self, places: &RowPlaces, between: &str, words: impl Fn(&T) -> String) -> String {
        let rows: Vec<u32> = self.first.iter().map(|(row, _)| *row).collect();
        let each = places.of_each(&rows).into_iter().zip(&self.first);
        let told = each.map(|(row, (_, with))| format!("{row}{}", words(with)));
        and_more(told.collect(), self.count, between)
    }
}

/// The number of a row as runs hold it.
pub(super) fn short(row: usize) -> u32 {
    u32::try_from(row).unwrap_or(u32::MAX)
}

/// Where the rows of all tables of a scene stand.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RowPlaces {
    tables: Vec<TableRows>,
}

#[derive(Debug, Clone, PartialEq)]
struct TableRows {
    /// rows of the tables before it
    rows_before: u32,
    /// what its lines are called
    noun: &'static str,
    /// file and sheet
    name: String,
    lines: RowLines,
}

impl RowPlaces {
    /// Adds a table after so many rows: its file, its sheet where it is one of a workbook, and whether its lines are those of
    /// a text.
    pub(super) fn add(
        &mut self,
        rows_before: usize,
        (file, sheet): (&str, Option<&str>),
        is_text: bool,
        lines: RowLines,
    ) {
        self.tables.push(TableRows {
            rows_before: short(rows_before),
            noun: if is_text { "line" } else { "row" },
            name: sheet.map_or_else(|| file.to_owned(), |sheet| format!("{file}, sheet {}", quoted(sheet))),
            lines,
        });
    }

    /// The table of a row, and its line there.
    fn line(&self, row: u32) -> Option<(&TableRows, u64)> {
        let table = self.tables.get(self.table(row))?;
        Some((table, table.lines.line(row - table.rows_before)?))
    }

    /// Which table a row is of.
    pub fn table(&self, row: u32) -> usize {
        let before = self.tables.partition_point(|table| table.rows_before < row);
        before.saturating_sub(1)
    }

    /// Where the rows from one to another stand: `runs.csv, lines 18 to 20`; in the table of a row that is named before them,
    /// `lines 18 to 20`.
    pub fn of_range(&self, [from, to]: [u32; 2], named: Option<u32>) -> String {
        let (Some((table, first)), Some((last_table, last))) = (self.line(from), self.line(to)) else {
            return if from == to {
                format!("row {from}")
            } else {
                format!("rows {from} to {to}")
            };
        };
        if !std::ptr::eq(table, last_table) {
            return format!("{} to {}", self.of(from), self.of(to));
        }
        let lines = if first == last {
            format!("{} {first}", table.noun)
        } else {
            format!("{}s {first} to {last}", table.noun)
        };
        let is_named = named
            .and_then(|row| self.line(row))
            .is_some_and(|(other, _)| std::ptr::eq(table, other));
        if is_named {
            lines
        } else {
            format!("{}, {lines}", table.name)
        }
    }

    /// Where each of some rows stands, the name of their table before the first: `runs.csv, line 18, line 24`.
    pub fn of_each(&self, rows: &[u32]) -> Vec<String> {
        let before = std::iter::once(None).chain(rows.iter().copied().map(Some));
        rows.iter()
            .zip(before)
            .map(|(row, before)| self.of_range([*row; 2], before))
            .collect()
    }

    /// Where a row of [`super::Runs::row`] stands, as a person sees it: `runs.csv, line 18 (run 17)`.
    pub fn of(&self, row: u32) -> impl Display {
        let Some((table, line)) = self.line(row) else {
            return format!("row {row} of the table");
        };
        let label = table.lines.label(row - table.rows_before);
        let label = label.map_or(String::new(), |label| format!(" (run {})", quoted(label)));
        format!("{}, {} {line}{label}", table.name, table.noun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_told_by_its_line_across_tables() {
        // line 1 is the header, line 4 is blank
        let mut lines = RowLines::default();
        lines.push(1, 2, Some("a"));
        lines.push(2, 3, None);
        lines.push(3, 5, Some("c"));
        let mut places = RowPlaces::default();
        places.add(0, ("May.csv", None), true, lines);
        let mut sheet = RowLines::default();
        sheet.push(1, 6, Some("7"));
        places.add(3, ("book.xlsx", Some("Öl")), false, sheet);
        let ranges = [([1, 3], None), ([2, 2], Some(1)), ([3, 4], None)];
        let told = ranges.map(|(rows, named)| places.of_range(rows, named));
        assert_eq!(
            told,
            [
                "May.csv, lines 2 to 5",
                "line 3",
                "May.csv, line 5 (run `c`) to book.xlsx, sheet `Öl`, row 6 (run `7`)"
            ]
        );
        assert_eq!(places.of_each(&[1, 3]), ["May.csv, line 2", "line 5"]);
        assert_eq!(RowPlaces::default().of(5).to_string(), "row 5 of the table");
    }
}
