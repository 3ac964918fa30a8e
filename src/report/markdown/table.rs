//! Makes a table of its columns, each with what stands over it and what of a row stands in it.

use super::super::numbers::NONE;
use super::super::quantities::{self, label};
use crate::findings::estimate::Estimate;
use crate::physics::Quantity;

/// Longer tables of a report are cut to so many rows: nobody reads more, and a file has them all.
pub(super) const MOST_ROWS: usize = 60;

/// A table in the making: its rows, and the columns made of them so far.
pub(crate) struct ReportTable<R> {
    rows: Vec<R>,
    columns: Vec<Column>,
    most_rows: usize,
}

struct Column {
    header: String,
    cells: Vec<String>,
}

/// What may stand in a cell.
pub(crate) trait Cell {
    fn text(self) -> String;
}

impl<R: Copy> ReportTable<R> {
    /// A table of these rows, without a column.
    pub(crate) fn of(rows: impl IntoIterator<Item = R>) -> ReportTable<R> {
        ReportTable {
            rows: rows.into_iter().collect(),
            columns: vec![],
            most_rows: MOST_ROWS,
        }
    }

    /// The same with every row, where no file has what would be left out.
    pub(crate) fn whole(self) -> ReportTable<R> {
        ReportTable {
            most_rows: usize::MAX,
            ..self
        }
    }

    pub(super) fn rows(&self) -> &[R] {
        &self.rows
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Adds a column under its header.
    pub(crate) fn column<C: Cell>(mut self, header: impl Into<String>, cell: impl Fn(R) -> C) -> ReportTable<R> {
        let header = header.into();
        let cells = self.rows.iter().map(|row| cell(*row).text()).collect();
        self.columns.push(Column { header, cells });
        self
    }

    /// The same, where something stands in the cell of any row.
    pub(super) fn column_if_any<C: Cell>(self, header: impl Into<String>, cell: impl Fn(R) -> C) -> ReportTable<R> {
        let mut table = self.column(header, cell);
        let is_empty = |column: &mut Column| column.cells.iter().all(|cell| cell.is_empty() || cell == NONE);
        table.columns.pop_if(is_empty);
        table
    }

    /// Adds the estimates of a quantity under its symbol.
    pub(super) fn estimate<'e>(self, quantity: Quantity, of: impl Fn(R) -> &'e Estimate) -> ReportTable<R> {
        self.column(label(quantity), |row| quantities::estimate(quantity, of(row)))
    }

    /// Estimates with their intervals behind them, each with whether its fit is usable: one that is not has neither ± nor
    /// interval.
    pub(super) fn estimate_and_interval<'e>(
        self,
        quantity: Quantity,
        of: impl Fn(R) -> (bool, &'e Estimate),
        interval: &str,
    ) -> ReportTable<R> {
        self.column(label(quantity), |row| match of(row) {
            (true, estimate) => quantities::beside_interval(quantity, estimate),
            (false, estimate) => quantities::value(quantity, estimate),
        })
        .column_if_any(interval, |row| match of(row) {
            (true, estimate) => quantities::interval(quantity, estimate),
            (false, _) => String::new(),
        })
    }

    /// What to say of the rows that do not stand in it; `None` where all do.
    pub(super) fn left_out(&self) -> Option<String> {
        let rows = self.rows.len();
        let most = self.most_rows;
        (rows > most).then(|| format!("The first {most} of {rows} rows; findings.json has all."))
    }

    /// Its lines, the headers first and no more rows than are read.
    pub(super) fn lines(&self) -> impl Iterator<Item = Vec<&str>> {
        let headers = self.columns.iter().map(|column| column.header.as_str());
        let row = |row: usize| self.columns.iter().map(|column| column.cells[row].as_str()).collect();
        std::iter::once(headers.collect()).chain((0..self.rows.len().min(self.most_rows)).map(row))
    }

    /// The table for a terminal: columns as wide as what stands in them.
    pub(super) fn plain(&self) -> String {
        let length = |text: &str| text.chars().count();
        let width = |column: &Column| {
            let cells = column.cells.iter().take(self.most_rows);
            cells
                .chain([&column.header])
                .map(|cell| length(cell))
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = self.columns.iter().map(width).collect();
        let mut text = String::new();
        for line in self.lines() {
            let padded = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
            text.push_str(padded.collect::<Vec<_>>().join("  ").trim_end());
            text.push('\n');
        }
        if let Some(left_out) = self.left_out() {
            text.push_str(&left_out);
            text.push('\n');
        }
        text
    }
}

impl Cell for String {
    fn text(self) -> String {
        self
    }
}

impl Cell for &String {
    fn text(self) -> String {
        self.clone()
    }
}

impl Cell for &str {
    fn text(self) -> String {
        self.to_owned()
    }
}

impl Cell for usize {
    fn text(self) -> String {
        self.to_string()
    }
}

/// A dash where there is nothing.
impl<C: Cell> Cell for Option<C> {
    fn text(self) -> String {
        self.map_or(NONE.to_owned(), Cell::text)
    }
}
