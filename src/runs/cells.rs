//! Reads a table whose columns are not those of runs: its rows as texts.

use super::refusals::whole_file;
use super::source::TableSource;
use super::workbook::{Workbook, NONE_HIDDEN};
use crate::error::{Error, Problem};
use crate::scene::{Naming, TableFile};

/// A row of a table that is not blank.
#[derive(Debug, Clone)]
pub(crate) struct TextRow {
    /// its line or row, from 1
    pub line: u64,
    /// as they stand there; those of a header without blanks around them
    pub cells: Vec<String>,
    /// whether it is of a sheet, where a row ends with its last cell that is not empty
    pub is_of_sheet: bool,
}

/// The header of a CSV, or of a sheet of a workbook, and every row below it in order.
pub(crate) fn text_rows(file: &TableFile) -> Result<(TextRow, Vec<TextRow>), Error> {
    let path = file.path.as_path();
    let naming = Naming::default();
    let refused = |problems: Vec<Problem>| Error::input(&file.shown(), problems);
    let is_of_sheet = file.ends_with(TableFile::WORKBOOK);
    let row = |line, cells| TextRow {
        line,
        cells,
        is_of_sheet,
    };
    let mut source = TableSource::open(path)?;
    if file.ends_with(".parquet") {
        return Err(refused(vec![whole_file("a Parquet table", "a CSV or a workbook")]));
    }
    let mut rows = vec![];
    if is_of_sheet {
        let bytes = source.workbook(path)?;
        let mut book = Workbook::open(&bytes).map_err(refused)?;
        if file.sheet.is_none() {
            book.refuse_several_sheets().map_err(refused)?;
        }
        let mut sheet = book.sheet(file.sheet.as_deref()).map_err(refused)?;
        let header = sheet.names(&naming).map_err(refused)?;
        sheet.refuse_hidden_columns(&header).map_err(refused)?;
        let header = row(header.line.unwrap_or(1), header.names);
        while let Some(found) = sheet.next_row().map_err(refused)? {
            rows.push(row(found.number, found.texts(found.width())));
        }
        sheet.refuse_hidden_rows(NONE_HIDDEN).map_err(refused)?;
        return Ok((header, rows));
    }
    let mut table = source.csv(path, &naming)?;
    let header = table.names(None).map_err(refused)?;
    let header = row(header.line.unwrap_or(1), header.names);
    while let Some(record) = table.next_record().map_err(refused)? {
        if !record.is_empty() {
            rows.push(row(record.line, record.texts()));
        }
    }
    Ok((header, rows))
}
