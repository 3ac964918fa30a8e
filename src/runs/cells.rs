//! Reads a table whose columns are not those of runs: its rows as texts, one after the other.

use super::columns::Header;
use super::refusals::whole_file;
use super::source::TableSource;
use super::workbook::{Workbook, NONE_HIDDEN};
use crate::error::{Error, Problem};
use crate::scene::{Naming, TableFile};

/// A row of a table that is not blank.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TextRow<'r> {
    /// its line or row, from 1
    pub line: u64,
    /// as they stand there; those of a header without blanks around them
    pub cells: &'r [&'r str],
    /// whether it is of a sheet, where a row ends with its last cell that is not empty
    pub is_of_sheet: bool,
}

/// Gives the header of a CSV, or of a sheet of a workbook, and every row below it in order. What `take` refuses ends the
/// reading.
pub(crate) fn each_row(
    file: &TableFile,
    mut take: impl FnMut(TextRow) -> Result<(), Vec<Problem>>,
) -> Result<(), Error> {
    let path = file.path.as_path();
    let naming = Naming::default();
    let refused = |problems: Vec<Problem>| Error::input(&file.shown(), problems);
    let is_of_sheet = file.ends_with(TableFile::WORKBOOK);
    let mut take = |line, cells: &[&str]| {
        let row = TextRow {
            line,
            cells,
            is_of_sheet,
        };
        take(row).map_err(refused)
    };
    let mut source = TableSource::open(path)?;
    if file.ends_with(".parquet") {
        return Err(refused(vec![whole_file("a Parquet table", "a CSV or a workbook")]));
    }
    if is_of_sheet {
        let bytes = source.workbook(path)?;
        let mut book = Workbook::open(&bytes).map_err(refused)?;
        if file.sheet.is_none() {
            book.refuse_several_sheets().map_err(refused)?;
        }
        let mut sheet = book.sheet(file.sheet.as_deref()).map_err(refused)?;
        let header = sheet.names(&naming).map_err(refused)?;
        sheet.refuse_hidden_columns(&header).map_err(refused)?;
        take(header.line.unwrap_or(1), &names_of(&header))?;
        while let Some(row) = sheet.next_row().map_err(refused)? {
            let texts = row.texts(row.width());
            let cells: Vec<&str> = texts.iter().map(|text| text.as_deref().unwrap_or_default()).collect();
            take(row.number, &cells)?;
        }
        return sheet.refuse_hidden_rows(NONE_HIDDEN).map_err(refused);
    }
    let mut table = source.csv(path, &naming)?;
    let header = table.names(None).map_err(refused)?;
    take(header.line.unwrap_or(1), &names_of(&header))?;
    while let Some(record) = table.next_record().map_err(refused)? {
        if !record.is_empty() {
            let cells: Vec<&str> = record.cells().collect();
            take(record.line, &cells)?;
        }
    }
    Ok(())
}

fn names_of(header: &Header) -> Vec<&str> {
    header.names.iter().map(String::as_str).collect()
}
