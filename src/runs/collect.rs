//! Gathers checked runs into columns and counts what was left out and why.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::averaged::MOST_AVERAGED;
use super::columns::HeaderRemarks;
use super::nominal::{compare_film_ratios, FILM_RATIO_OF_EACH_RUN, MANY_FILM_RATIOS};
use super::places::{short, NamedRows, RowLines, RowPlaces};
use super::read_run::ReadRun;
use super::refusals::whole_file;
use super::row::CheckedRow;
use super::screen::{screen, REASONS};
use super::told_twice::{ComparedColumns, Comparison, TOLD_TWICE};
use super::words::words_for_no;
use crate::error::{file_name, quoted, Problem};
use crate::remark::{Level, Remark};
use crate::rounding::{by_number, counted};
use crate::scene::{RunColumn, Scene};

const LIQUIDS_WITHOUT_RUNS: &str = "liquids_without_runs";
const UNKNOWN_COLUMN: &str = "unknown_column";
const UNHEEDED_COLUMN: &str = "unheeded_column";
const RESTITUTION_ABOVE_ONE: &str = "restitution_above_one";
const HEIGHTS_ASSUMED: &str = "heights_assumed";
const LABELLED_ROWS: &str = "labelled_rows";
const AVERAGED_ROWS: &str = "averaged_rows";
const DRY_BESIDE_FILM: &str = "dry_beside_film";
const EXCLUDE_BY_YES: &str = "exclude_by_yes";
const EXCLUDED_MOST: &str = "excluded_most";
const HIDDEN_ROWS: &str = "hidden_rows";
const HIDDEN_COLUMNS: &str = "hidden_columns";
pub(super) const SHEETS_NOT_READ: &str = "sheets_not_read";
pub(super) const CONDENSED_RUNS: &str = "condensed_runs";

/// The codes of what reading says of a table.
pub(crate) const OF_READING: [&str; 16] = [
    SHEETS_NOT_READ,
    LIQUIDS_WITHOUT_RUNS,
    HIDDEN_ROWS,
    HIDDEN_COLUMNS,
    LABELLED_ROWS,
    EXCLUDED_MOST,
    HEIGHTS_ASSUMED,
    UNKNOWN_COLUMN,
    UNHEEDED_COLUMN,
    RESTITUTION_ABOVE_ONE,
    AVERAGED_ROWS,
    DRY_BESIDE_FILM,
    MANY_FILM_RATIOS,
    EXCLUDE_BY_YES,
    FILM_RATIO_OF_EACH_RUN,
    CONDENSED_RUNS,
];

/// What was read of a workbook, and what was not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SheetRead {
    pub name: String,
    pub is_hidden: bool,
    /// the other sheets, each with whether it is hidden
    pub others: Vec<(String, bool)>,
    /// hidden rows with something in them, as they were taken or left out
    pub hidden_rows: Vec<u64>,
    pub are_taken: bool,
    /// names of columns that are read although the sheet hides them, as a message shows them
    pub hidden_columns: Vec<String>,
}

/// Runs left out for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Screened {
    /// why, in words
    pub reason: String,
    /// how many
    pub runs: usize,
    /// what would use them
    #[serde(skip)]
    pub next_step: &'static str,
}

/// Rows of the longest table that is read whole where the scene's model needs every run: some 3 GB.
const MOST_WHOLE: usize = 10_000_000;

/// What is wrong with so many rows, where the scene's model needs every run.
pub(super) fn too_many_rows(rows: usize, scene: &Scene) -> Option<Problem> {
    (rows > MOST_WHOLE && scene.model.needs_every_run()).then(|| {
        let expected = format!(
            "at most {MOST_WHOLE}, or [model] with a named inertia, normal likelihood and noise = \"restitution\": few runs \
             then stand for all"
        );
        whole_file("too many rows for a model that keeps every run", &expected).found(format!("{rows} rows"))
    })
}

/// What uses rows that are left out by their labels, which a remark of its own names.
pub(crate) const OTHER_LABEL: &str = "give those rows another label to use them";

/// What uses runs that the column of reasons leaves out.
const CLEAR_EXCLUDE: &str = "clear the word in the column `exclude` to use those excluded";

/// What stands for the reasons beyond those that are told apart.
const OTHER_REASON: &str = "another reason";

/// A whole file, collected.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Collected {
    /// the runs that are not left out, in the order of the file
    pub in_use: Vec<ReadRun>,
    pub rows: usize,
    /// of its header
    pub remarks: HeaderRemarks,
    pub screened: [usize; REASONS.len()],
    /// left out by the file itself, by its reasons in the order they come
    excluded: Vec<(String, usize)>,
    /// the rows whose labels say that they are no runs, with these labels
    labelled: NamedRows<String>,
    above_one: usize,
    /// the rows that are called dry beside a film
    dry_beside_film: NamedRows<()>,
    /// the words of its column `exclude` that say no, where all its words say yes or no: their runs are kept
    pub kept_by_no: Vec<String>,
    /// rows that are means, and the runs that these stand for
    pub averaged: [usize; 2],
    /// how columns that tell the same thing compare, in the order of [`TOLD_TWICE`]
    told_twice: [Comparison; TOLD_TWICE.len()],
    /// where its rows stand in the file
    pub lines: RowLines,
    /// what was read of a workbook
    pub sheet: Option<SheetRead>,
}

impl Collected {
    /// Of a table with this header of which no row was read yet.
    pub fn new(remarks: &HeaderRemarks) -> Collected {
        Collected {
            remarks: remarks.clone(),
            ..Collected::default()
        }
    }

    /// Counts the next row, which stands on this line; before it is excluded or pushed.
    pub fn count(&mut self, line: u64, label: Option<&str>) {
        self.rows += 1;
        self.lines.push(self.rows, line, label);
    }

    /// Adds the run of the row that was counted last.
    pub fn push(&mut self, row: &CheckedRow, scene: &Scene) {
        for (comparison, ratio) in self.told_twice.iter_mut().zip(row.ratios) {
            if let Some(ratio) = ratio {
                comparison.add(short(self.rows), row.run.setting, ratio);
            }
        }
        let runs = row.mean_of.map_or(1, |mean| mean.runs as usize);
        if row.mean_of.is_some() {
            self.averaged[0] += 1;
            self.averaged[1] += runs;
        }
        if let Some(reason) = screen(&row.run, scene) {
            self.screened[reason] += runs;
            return;
        }
        match row.mean_of {
            // beyond, the table is refused
            Some(mean) if self.averaged[1] <= MOST_AVERAGED => {
                for restitution in mean.restitutions(row.run.restitution) {
                    self.push_run(ReadRun { restitution, ..row.run });
                }
            }
            _ => self.push_run(row.run),
        }
    }

    fn push_run(&mut self, run: ReadRun) {
        self.above_one += usize::from(run.restitution > 1.0);
        let row = short(self.rows);
        self.in_use.push(ReadRun { row, ..run });
    }

    /// Counts the row that was counted last under those that are called dry beside a film.
    pub fn add_dry_beside_film(&mut self) {
        self.dry_beside_film.push(short(self.rows), ());
    }

    /// Counts the row that was counted last under those whose label says that they are no runs.
    pub fn add_labelled(&mut self, label: &str) {
        self.labelled.push(short(self.rows), label.to_owned());
    }

    /// Leaves out so many runs of rows that were counted last, as the file says.
    pub fn exclude(&mut self, reason: &str, runs: usize) {
        /// reasons that are told apart: a report tells them all
        const MOST: usize = 20;
        let is_told = self.excluded.len() < MOST || self.excluded.iter().any(|(known, _)| known == reason);
        let reason = if is_told { reason } else { OTHER_REASON };
        match self.excluded.iter_mut().find(|(known, _)| known == reason) {
            Some((_, all)) => *all += runs,
            None => self.excluded.push((reason.to_owned(), runs)),
        }
    }

    /// The words of the column `exclude` that keep a run, of a table in which each of these was taken for a reason.
    pub fn words_for_no(&self) -> Vec<String> {
        words_for_no(self.excluded.iter().map(|(reason, _)| reason.as_str()))
    }

    /// Says which words of the column `exclude` keep a run.
    pub fn excluded_by_yes(&self, path: &Path) -> Option<Remark> {
        let words: Vec<String> = self.kept_by_no.iter().map(|word| quoted(word)).collect();
        let text = format!(
            "{}: runs with {} in the column `exclude` are kept: none of these is a reason to leave one out",
            file_name(path),
            words.join(" or ")
        );
        let next = "nothing; a run is left out by any other word there";
        let notice = Remark::new(EXCLUDE_BY_YES, words.len(), text, next);
        (!words.is_empty()).then(|| notice.at(Level::Informs))
    }

    /// Questions a word of the column `exclude` that leaves out most rows of the table, as a word for a good run would.
    pub fn excluded_most(&self, path: &Path) -> Option<Remark> {
        let told = self.excluded.iter().filter(|(word, _)| word != OTHER_REASON);
        let (word, runs) = told
            .max_by_key(|(_, runs)| *runs)
            .filter(|(_, runs)| 2 * runs > self.rows)?;
        let text = format!(
            "{}: {} in the column `exclude` leaves out {runs} of {}",
            file_name(path),
            quoted(word),
            counted(self.rows, "run")
        );
        let next = "leave the cells of the runs to keep empty, if the word is no reason to leave a run out";
        Some(Remark::new(EXCLUDED_MOST, *runs, text, next))
    }

    /// Adds the next table, which this may be the first of; what is told of each table by itself is not taken.
    pub fn append(&mut self, table: Collected) {
        if self.rows == 0 {
            *self = table;
            return;
        }
        let rows_before = short(self.rows);
        self.labelled.extend(&table.labelled, rows_before);
        self.dry_beside_film.extend(&table.dry_beside_film, rows_before);
        let counts = self.averaged.iter_mut().chain(&mut self.screened);
        let of_table = table.averaged.iter().chain(&table.screened);
        counts.zip(of_table).for_each(|(all, own)| *all += own);
        if self.averaged[1] <= MOST_AVERAGED {
            self.in_use
                .extend(table.in_use.iter().map(|run| run.after(rows_before)));
        }
        self.rows += table.rows;
        self.above_one += table.above_one;
        for (reason, runs) in &table.excluded {
            self.exclude(reason, *runs);
        }
    }

    pub fn screened(&self) -> Vec<Screened> {
        let by_scene = REASONS.into_iter().zip(self.screened);
        let by_scene = by_scene.map(|((reason, next_step, _), runs)| Screened {
            reason: reason.to_owned(),
            runs,
            next_step,
        });
        let by_file = self.excluded.iter().map(|(reason, runs)| Screened {
            reason: format!("excluded: {}", quoted(reason)),
            runs: *runs,
            next_step: CLEAR_EXCLUDE,
        });
        let labelled = Screened {
            reason: "a label that says mean, total or spread of other rows".to_owned(),
            runs: self.labelled.count,
            next_step: OTHER_LABEL,
        };
        let by_file = by_file.chain([labelled]);
        by_scene.chain(by_file).filter(|screened| screened.runs > 0).collect()
    }

    /// How many runs the rows are, a mean counted as those that it stands for.
    pub fn runs(&self) -> usize {
        self.rows - self.averaged[0] + self.averaged[1]
    }

    /// Says that the scene names liquids and no run in use has one.
    pub fn liquids_without_runs(&self, scene: &Scene) -> Option<Remark> {
        if scene.liquids.is_empty() || self.in_use.iter().any(|run| run.setting.liquid.is_some()) {
            return None;
        }
        let names: Vec<&str> = scene.liquids.iter().map(|liquid| liquid.name.as_str()).collect();
        let text = format!("no run in use has a liquid; the scene names {}", names.join(", "));
        let next = "look whether the column `liquid` says which runs are wet";
        Some(Remark::new(LIQUIDS_WITHOUT_RUNS, names.len(), text, next))
    }

    /// How columns of the table, which stands after so many rows of others, compare where they tell the same thing.
    pub fn compared_columns(&self, rows_before: usize) -> Vec<ComparedColumns> {
        let names = self.remarks.told_twice.iter().cloned();
        let each = TOLD_TWICE.into_iter().zip(names).zip(&self.told_twice);
        let before = short(rows_before);
        let speeds = each.filter_map(|((columns, names), comparison)| comparison.of(columns, names, before));
        let films = compare_film_ratios(&self.in_use);
        let columns = [RunColumn::FilmRatio, RunColumn::Film];
        speeds
            .chain(films.of(columns, self.remarks.films.clone(), before))
            .collect()
    }

    /// Names the rows whose labels say that they are no runs.
    pub fn labelled_rows(&self, places: &RowPlaces) -> Option<Remark> {
        let count = self.labelled.count;
        let rows = self
            .labelled
            .in_words(places, ", ", |label| format!(" {}", quoted(label)));
        let [noun, verb, is] = if count == 1 {
            ["row", "is", "its label says that it is"]
        } else {
            ["rows", "are", "their labels say that they are"]
        };
        let text = format!("{count} {noun} {verb} left out: {is} the mean, total or spread of other rows ({rows})");
        let next =
            "give such a row another word if it is a run; a mean of runs that the table does not have is read with a \
                    column `runs`";
        (count > 0).then(|| Remark::new(LABELLED_ROWS, count, text, next))
    }

    /// Says which rows are called dry beside a film.
    pub fn dry_beside_film(&self, places: &RowPlaces) -> Option<Remark> {
        let count = self.dry_beside_film.count;
        let rows = self.dry_beside_film.in_words(places, "; ", |_| String::new());
        let (noun, verb) = by_number(count, ("row", "is"), ("rows", "are"));
        let text = format!("{count} {noun} {verb} called dry beside a film, which is not read: {rows}");
        let next = "write the liquid where the plate was wet, or leave the film of dry runs empty";
        (count > 0).then(|| Remark::new(DRY_BESIDE_FILM, count, text, next))
    }

    /// Says how many runs the rows that are means stand for.
    pub fn averaged_rows(&self) -> Option<Remark> {
        let [rows, runs] = self.averaged;
        let text = format!(
            "{rows} rows are means and stand for {runs} runs: each is read as normally spread runs of its mean and sd, so that \
             outliers and tails among the single runs cannot be seen"
        );
        let notice = Remark::new(AVERAGED_ROWS, rows, text, "give the single runs where you have them");
        (rows > 0).then(|| notice.at(Level::Informs))
    }

    /// Says what was done with the hidden rows of a sheet.
    pub fn hidden_rows(&self, path: &Path) -> Option<Remark> {
        let sheet = self.sheet.as_ref().filter(|sheet| !sheet.hidden_rows.is_empty())?;
        let done = if sheet.are_taken { "are read" } else { "are left out" };
        let (file, name, rows) = (file_name(path), quoted(&sheet.name), &sheet.hidden_rows);
        let text = format!("{file}, sheet {name}: hidden {} {done}", rows_in_words(rows));
        let next = "nothing, unless `hidden_rows` in [data] should say otherwise";
        Some(Remark::new(HIDDEN_ROWS, rows.len(), text, next))
    }

    /// Says which columns of a sheet are read although it hides them.
    pub fn hidden_columns(&self, path: &Path) -> Option<Remark> {
        let sheet = self.sheet.as_ref().filter(|sheet| !sheet.hidden_columns.is_empty())?;
        let (file, name, hidden) = (file_name(path), quoted(&sheet.name), sheet.hidden_columns.len());
        let (noun, verb) = by_number(hidden, ("column", "is"), ("columns", "are"));
        let columns = sheet.hidden_columns.join(", ");
        let text = format!("{file}, sheet {name}: hidden {noun} {columns} {verb} read");
        let next =
            "show what is hidden in the spreadsheet and see that it is meant; else name another column as `columns` in [data]";
        Some(Remark::new(HIDDEN_COLUMNS, hidden, text, next))
    }

    /// Says which point of the sphere the heights are taken to be of, where the scene does not.
    pub fn heights_assumed(&self) -> Option<Remark> {
        let surface = self.remarks.lowest_point_above.as_ref()?;
        let text = format!(
            "heights are taken as those of the sphere's lowest point above {surface}; of its centre, half a diameter would be \
             taken off"
        );
        let next =
            "say which, as heights_of = \"lowest\" or \"centre\" and heights_to = \"plate\" or \"film\" in [data]";
        Some(Remark::new(HEIGHTS_ASSUMED, self.rows, text, next))
    }

    /// Says which columns of a file are read only where another has nothing.
    pub fn unheeded_columns(&self, path: &Path) -> Option<Remark> {
        let unheeded = &self.remarks.unheeded;
        let each = unheeded
            .iter()
            .map(|[column, other]| format!("{column} read only where {other} is empty"));
        let each: Vec<String> = each.collect();
        let text = format!("{}: {}", file_name(path), each.join(", "));
        let next = "leave out the column that is less sure, if it is the other";
        let notice = Remark::new(UNHEEDED_COLUMN, each.len(), text, next);
        (!each.is_empty()).then(|| notice.at(Level::Informs))
    }

    /// Says how many runs rebounded faster than they fell.
    pub fn above_one(&self) -> Option<Remark> {
        let runs = self.above_one;
        let (they, are) = by_number(runs, ("it", "is"), ("they", "are"));
        let text = format!(
            "{} rebounded faster than {they} fell, by at most 10 %; {they} {are} kept",
            counted(runs, "run")
        );
        let next = "check the speed calibration of these runs";
        (runs > 0).then(|| Remark::new(RESTITUTION_ABOVE_ONE, runs, text, next))
    }
}

/// Says once which columns were not read: those of each table by name, tables with the same ones together.
pub(super) fn columns_not_read(tables: &[(String, Vec<String>)]) -> Option<Remark> {
    let mut alike: Vec<(Vec<&str>, &[String])> = vec![];
    for (table, columns) in tables.iter().filter(|(_, columns)| !columns.is_empty()) {
        match alike.iter_mut().find(|(_, others)| others == columns) {
            Some((names, _)) if names.contains(&table.as_str()) => {}
            Some((names, _)) => names.push(table),
            None => alike.push((vec![table.as_str()], columns.as_slice())),
        }
    }
    let count: usize = alike.iter().map(|(_, columns)| columns.len()).sum();
    let each: Vec<String> = alike
        .iter()
        .map(|(names, columns)| {
            let noun = if columns.len() == 1 { "column" } else { "columns" };
            format!("{}: {noun} {} not read", names.join(", "), columns.join(", "))
        })
        .collect();
    // others are those at which a liquid wets, and more corners
    const OTHERS: &str = "contact wetting kontakt rand benetz tangle triangle";
    let is_of_impact = |name: &String| {
        let name = name.to_lowercase();
        let is_other = OTHERS.split(' ').any(|part| name.contains(part));
        (name.contains("angle") || name.contains("winkel")) && !is_other
    };
    let (next, level) = match alike.iter().flat_map(|(_, columns)| *columns).any(is_of_impact) {
        true => (
            "see that speeds and restitutions are those normal to the plate: no angle is read",
            Level::Cautions,
        ),
        false => (
            "nothing, unless one of them holds what the analysis needs under another name",
            Level::Informs,
        ),
    };
    (count > 0).then(|| Remark::new(UNKNOWN_COLUMN, count, each.join("; "), next).at(level))
}

/// Some rows in a few words: `rows 4, 9 to 12`.
pub(super) fn rows_in_words(rows: &[u64]) -> String {
    const MOST: usize = 8;
    let ranges: Vec<String> = rows
        .chunk_by(|a, b| a + 1 == *b)
        .map(|range| match range {
            [one] => one.to_string(),
            [first, .., last] => format!("{first} to {last}"),
            [] => String::new(),
        })
        .collect();
    let noun = if rows.len() == 1 { "row" } else { "rows" };
    let more = if ranges.len() > MOST { " and more" } else { "" };
    format!("{noun} {}{more}", ranges[..ranges.len().min(MOST)].join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_several_tables_have_are_told_once_and_only_inform() {
        let table = |name: &str, columns: &[&str]| (name.to_owned(), columns.iter().map(|c| (*c).to_owned()).collect());
        let told =
            |tables: &[(String, Vec<String>)]| columns_not_read(tables).map(|one| (one.text.clone(), one.count()));
        let sheets = [
            table("b.xlsx", &["ok"]),
            table("b.xlsx", &["ok"]),
            table("c.csv", &["ok"]),
            table("d.csv", &["x", "y"]),
        ];
        let text = "b.xlsx, c.csv: column ok not read; d.csv: columns x, y not read";
        assert_eq!(told(&sheets), Some((text.to_owned(), 3)));
        assert!(columns_not_read(&sheets).is_some_and(|notice| !notice.cautions()));
        let cautions =
            |name: &str| columns_not_read(&[table("a.csv", &[name])]).is_some_and(|notice| notice.cautions());
        assert!(cautions("Aufprallwinkel (deg)") && !cautions("contact angle") && !cautions("Randwinkel"));
    }
}
