//! Surveys the columns of a table without a scene: what each is called, and what stands in it.

use super::columns::{present, TableHeader};
use super::decimals::parse_number;
use super::headers::called::columns_called;
use super::headers::units::is_row_of_units;
use super::labels::{is_count, NamesForAll};
use super::raw_row::{IMPACTS, REBOUNDS};
use crate::scene::RunColumn;

/// A column of a table of which nothing is known but its cells.
#[derive(Debug, Clone, Default)]
pub(super) struct SurveyedColumn {
    /// its name
    pub name: String,
    /// what stands below it in a row of units, else the unit above it, else nothing
    pub unit: String,
    /// whether that unit stands above it
    pub is_unit_above: bool,
    /// cells that are not empty
    pub filled: usize,
    /// the first different words in it, at most [`SurveyedColumn::MOST_WORDS`], in the order they come
    pub words: Vec<String>,
    /// whether it has more words than are kept
    pub has_more: bool,
    /// largest number
    pub largest: Option<f64>,
    /// the line or row of it
    pub largest_at: u64,
    /// numbers above the one before
    rises: usize,
    last: Option<f64>,
}

/// A table of which nothing is known but its cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Survey {
    pub columns: Vec<SurveyedColumn>,
    pub rows: usize,
    /// the line or row of the names
    pub header: Option<u64>,
    /// whether rows stand above it
    pub has_titles: bool,
    /// what these say
    pub titles: Vec<String>,
    /// sheets of a workbook that were read, each with all columns; empty where the table has no others
    pub sheets: Vec<String>,
    /// sheets with other columns, and hidden ones
    pub sheets_left: Vec<String>,
    /// hidden rows, which are not surveyed
    pub hidden_rows: usize,
    /// names of hidden columns, which are, as a message shows them
    pub hidden_columns: Vec<String>,
    /// rows whose labels say that they are no runs, which are not surveyed either
    pub labelled: Vec<LabelledRow>,
    /// rows of one word alone, as footnotes are, nor these
    pub notes: Vec<LabelledRow>,
    names_for_all: NamesForAll,
}

/// A row that a label marks as the mean, total, spread or count of others.
#[derive(Debug, Clone)]
pub(super) struct LabelledRow {
    /// its line, or its row in a sheet
    pub line: u64,
    /// that sheet; `None` in a table without any
    pub sheet: Option<String>,
    pub label: String,
    cells: Vec<String>,
}

impl Survey {
    pub fn new(header: TableHeader) -> Survey {
        let mut units = header.units.into_iter();
        let mut above = header.units_above.into_iter();
        let column = |name| {
            let [below, above] = [units.next(), above.next()].map(Option::unwrap_or_default);
            let is_unit_above = below.is_empty() && !above.is_empty();
            SurveyedColumn {
                name,
                unit: if is_unit_above { above } else { below },
                is_unit_above,
                ..SurveyedColumn::default()
            }
        };
        Survey {
            columns: header.names.into_iter().map(column).collect(),
            header: header.line,
            ..Survey::default()
        }
    }

    /// Whether its columns have names.
    pub fn is_table(&self) -> bool {
        self.columns.iter().filter(|column| !column.name.is_empty()).count() >= 2
    }

    /// Takes what stands above the names, of the first rows of the table.
    pub fn take_titles(&mut self, first: Vec<(u64, Vec<String>)>) {
        let above = first.into_iter().filter(|(row, _)| Some(*row) < self.header);
        let titles = above.flat_map(|(_, cells)| cells);
        self.titles = titles.filter(|cell| present(cell).is_some()).collect();
        self.has_titles = !self.titles.is_empty();
    }

    /// Keeps what the titles of another sheet say, too: what they say alone holds there alone.
    pub fn keep_titles(&mut self, first: &[(u64, Vec<String>)]) {
        let above = || first.iter().filter(|(row, _)| Some(*row) < self.header);
        self.titles
            .retain(|title| above().any(|(_, cells)| cells.contains(title)));
    }

    /// Adds a row, which stands on this line; cells that it lacks or that are empty are missing, those beyond the header are
    /// not seen.
    pub fn add<'c>(&mut self, line: u64, cells: impl IntoIterator<Item = &'c str> + Clone) {
        /// rows with a label that are kept until it is known whether labels are names here
        const MOST: usize = 10_000;
        let texts = || cells.clone().into_iter().take(self.columns.len());
        self.names_for_all.see(texts());
        let mut places = texts().enumerate();
        let label = places.find(|(index, cell)| self.names_for_all.label(*index, cell).is_some() || is_count(cell));
        let label = label.map(|(_, cell)| cell);
        let mut filled = texts().filter_map(present);
        let only = filled
            .next()
            .filter(|_| filled.next().is_none() && self.columns.len() > 2);
        let note = only.filter(|cell| parse_number(cell).is_err());
        let (rows, label) = match (label, note) {
            (Some(label), _) => (&mut self.labelled, label),
            (None, Some(note)) => (&mut self.notes, note),
            (None, None) => return self.add_run(line, cells),
        };
        if rows.len() >= MOST {
            return self.add_run(line, cells);
        }
        rows.push(LabelledRow {
            line,
            sheet: self.sheets.last().cloned(),
            label: label.trim().to_owned(),
            cells: cells.into_iter().map(str::to_owned).collect(),
        });
    }

    fn add_run<'c>(&mut self, line: u64, cells: impl IntoIterator<Item = &'c str>) {
        self.rows += 1;
        let mut cells = cells.into_iter();
        for column in &mut self.columns {
            column.add(line, cells.next().unwrap_or_default());
        }
    }

    /// Takes rows with labels for runs where they are most of the table: the words are names then, or each row is a mean.
    pub fn settle_labels(&mut self) {
        if self.labelled.len() <= self.rows {
            return;
        }
        for row in std::mem::take(&mut self.labelled) {
            self.add_run(row.line, row.cells.iter().map(String::as_str));
        }
    }
}

/// Rows among which the names of columns are looked for.
pub(super) const ROWS_OF_HEADER: usize = 40;

/// Rows of numbers below the names of runs, at least, where other words stand above numbers, too.
const FEWEST_RUNS: usize = 3;

/// The row that names the columns, of the first rows of a table with their numbers: words alone, with numbers in the row
/// below it or below its units. Of several those come first that name an impact and a rebound, then those with more than two
/// rows of numbers, which a table of constants above the runs has not; then the first with more than half as many cells that
/// are called like columns as any of them or, where hardly any is, more than two thirds as wide as the widest. A line about
/// the whole table is none of these. `None` where no row is like that.
pub(super) fn row_of_names(rows: &[(u64, Vec<String>)]) -> Option<u64> {
    let filled = |row: &[String]| row.iter().filter(|cell| present(cell).is_some()).count();
    let has_number = |row: &[String]| row.iter().any(|cell| parse_number(cell.trim()).is_ok());
    // as a date is, which is no number either
    let is_value = |cell: &String| cell.contains(|c: char| c.is_ascii_digit()) && !cell.contains(char::is_alphabetic);
    let runs_below = |at: usize| {
        let below = rows.iter().skip(at + 1).map(|(_, row)| row);
        let below = below.skip_while(|row| is_row_of_units(row.iter().map(String::as_str)));
        below.take_while(|row| has_number(row)).count()
    };
    let called = |row: &[String]| -> Vec<Vec<RunColumn>> {
        let all = row.iter().filter_map(|cell| present(cell)).map(columns_called);
        all.filter(|columns| !columns.is_empty()).collect()
    };
    let names_runs = |at: &usize| {
        let called = called(&rows[*at].1);
        let has = |one_of: [RunColumn; 3]| called.iter().flatten().any(|column| one_of.contains(column));
        has(IMPACTS) && has(REBOUNDS)
    };
    let is_of_names = |at: &usize| {
        let (_, names) = &rows[*at];
        filled(names) >= 2 && !names.iter().any(is_value) && runs_below(*at) >= 1
    };
    let mut found: Vec<usize> = (0..rows.len()).filter(is_of_names).collect();
    let mut prefer = |is_better: &dyn Fn(&usize) -> bool| {
        if found.iter().any(is_better) {
            found.retain(is_better);
        }
    };
    prefer(&names_runs);
    prefer(&|at| runs_below(*at) >= FEWEST_RUNS);
    let names = |at: &usize| rows[*at].1.as_slice();
    let known = |at: &usize| called(names(at)).len();
    let most = found.iter().map(known).max()?;
    let widest = found.iter().map(|at| filled(names(at))).max()?;
    let first = found.iter().find(|at| match most {
        0 | 1 => 3 * filled(names(at)) > 2 * widest,
        _ => 2 * known(at) > most,
    });
    first.map(|at| rows[*at].0)
}

impl SurveyedColumn {
    /// Names of particles or liquids that one table may well have.
    pub const MOST_WORDS: usize = 100;

    /// Adds a cell, which stands on this line.
    pub fn add(&mut self, line: u64, cell: &str) {
        let Some(cell) = present(cell) else {
            return;
        };
        self.filled += 1;
        if let Ok(number) = parse_number(cell) {
            self.rises += usize::from(self.last.is_some_and(|last| last < number.value));
            self.last = Some(number.value);
            if self.largest.is_none_or(|most| most < number.value) {
                (self.largest, self.largest_at) = (Some(number.value), line);
            }
        }
        if self.words.iter().any(|word| word == cell) {
            return;
        }
        if self.words.len() == SurveyedColumn::MOST_WORDS {
            self.has_more = true;
            return;
        }
        self.words.push(cell.to_owned());
    }

    /// The middle one of its different numbers above 0, as far as words are kept.
    pub fn middle(&self) -> Option<f64> {
        let numbers = self.words.iter().filter_map(|word| parse_number(word).ok());
        let mut numbers: Vec<f64> = numbers
            .map(|number| number.value)
            .filter(|value| *value > 0.0)
            .collect();
        numbers.sort_by(f64::total_cmp);
        numbers.get(numbers.len().checked_sub(1)? / 2).copied()
    }

    /// Whether it numbers the rows, perhaps anew in each block: nearly every number is above the one before, or none is there
    /// twice.
    pub fn is_running_number(&self) -> bool {
        /// numbers that tell it from those of repeats
        const FEWEST: usize = 5;
        self.filled >= FEWEST && (self.words.len() == self.filled || 4 * self.rises >= 3 * (self.filled - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<(u64, Vec<String>)> {
        let cells = |line: &str| line.split(',').map(str::to_owned).collect();
        (1..).zip(text.lines().map(cells)).collect()
    }

    #[test]
    fn names_stand_above_numbers_whatever_stands_above_them() {
        let table = "Drops,,\nTrial,,Impact\nNo.,ball,v\n,,[m/s]\n1,PTFE,0.5\n2,PTFE,0.7";
        assert_eq!(row_of_names(&rows(table)), Some(3));
        assert_eq!(row_of_names(&rows("ball,v\nPTFE,0.5\nPE,0.6")), Some(1));
        // lines about the whole table, of a label and a value
        let table =
            "Series,wet drops,,\nDate,2026-03-01,,\nFilm (mm),0.4,,\nOperator,AB,,\nNo.,ball,v,e\n1,PTFE,0.5,0.8";
        assert_eq!(row_of_names(&rows(table)), Some(5));
        // one that is wider than the table
        let table = "Operator,AB,Room,lab,Film,oil,Plate,glass\nNo.,ball,v (m/s),e\n1,PTFE,0.5,0.8";
        assert_eq!(row_of_names(&rows(table)), Some(2));
        // tables of constants and of results
        let table = "particle,diameter_mm,film_um,liquid\nPTFE,4.762,286,AK10\nball,v,e\nPTFE,0.5,0.8\nPTFE,0.6,0.8\nPTFE,0.7,0.8";
        assert_eq!(row_of_names(&rows(table)), Some(3));
        let table = "ball,liquid,e_inf,St_c\nPE,M5,0.7,2\nPE,M9,0.7,2\nPE,M7,0.7,2\nball,v,e\nPE,0.5,0.8";
        assert_eq!(row_of_names(&rows(table)), Some(5));
        // names of numbers are no names, and words below words are not measured
        assert_eq!(row_of_names(&rows("1,2\n3,4")), None);
        assert_eq!(row_of_names(&rows("a,b\nc,d")), None);
    }
}
