//! Reads a table whose columns are not those of runs: its rows as texts, one after the other.

use super::csv::other_width;
use super::refusals::whole_file;
use super::source::TableSource;
use super::workbook::Workbook;
use crate::error::{Error, Problem};
use crate::scene::{Naming, TableFile};

/// What takes the rows of a table.
pub(crate) trait TakesRows {
    /// Whether a row may go on with empty cells; where words follow numbers, these may as well be shifted by a decimal comma.
    const MAY_END_BLANK: bool = false;

    /// Takes the names in the header, without blanks around them, and the line it stands on. What it refuses ends the
    /// reading.
    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>>;

    /// Takes the cells of a row that is not blank, as they stand there, as many as the header has.
    fn row(&mut self, line: u64, cells: &[&str]);

    /// How many cells a row must have; `None` where any number will do, as before the names are found.
    fn width(&self) -> Option<usize>;

    /// Takes what is wrong with a row as a whole.
    fn refuse(&mut self, problem: Problem);
}

/// Gives every row of a CSV, or of a sheet of a workbook, in its order.
pub(crate) fn each_row<T: TakesRows>(file: &TableFile, to: &mut T) -> Result<(), Error> {
    let path = file.path.as_path();
    let refused = |problems: Vec<Problem>| Error::input(&file.shown(), problems);
    let mut source = TableSource::open(path)?;
    if file.ends_with(".parquet") {
        return Err(refused(vec![whole_file("a Parquet table", "a CSV or a workbook")]));
    }
    if file.ends_with(TableFile::WORKBOOK) {
        let bytes = source.workbook(path)?;
        let mut book = Workbook::open(&bytes).map_err(refused)?;
        let mut sheet = book.sheet(file.sheet.as_deref()).map_err(refused)?;
        let header = sheet.names(&Naming::default()).map_err(refused)?;
        to.header(&header.names, header.line.unwrap_or(1)).map_err(refused)?;
        while let Some(row) = sheet.next_row().map_err(refused)? {
            let width = to.width().unwrap_or(row.width());
            if row.width() > width {
                to.refuse(other_width(row.number, row.width(), width, false));
                continue;
            }
            let texts = row.texts(width);
            let cells: Vec<&str> = texts.iter().map(|text| text.as_deref().unwrap_or_default()).collect();
            to.row(row.number, &cells);
        }
        return sheet.refuse_hidden_rows().map_err(refused);
    }
    let mut table = source.csv(path, &Naming::default())?;
    let header = table.names(None).map_err(refused)?;
    to.header(&header.names, header.line.unwrap_or(1)).map_err(refused)?;
    while let Some(record) = table.next_record().map_err(refused)? {
        if record.is_empty() {
            continue;
        }
        let cells: Vec<&str> = record.cells().collect();
        let width = to.width().unwrap_or(cells.len());
        let ends_blank = || cells.len() > width && cells[width..].iter().all(|cell| cell.trim().is_empty());
        let is_meant = cells.len() == width || T::MAY_END_BLANK && ends_blank();
        if is_meant {
            to.row(record.line, &cells[..width]);
        } else {
            to.refuse(other_width(record.line, cells.len(), width, record.has_line_ends()));
        }
    }
    Ok(())
}
