//! Reads the tables of a scene, every run of them.

use std::path::Path;
use std::sync::Arc;

use super::averaged::MOST_AVERAGED;
use super::checked_rows::TakeRuns;
use super::collect::{columns_not_read, too_many_rows, Collected, Screened, SheetRead, SHEETS_NOT_READ};
use super::nominal::drop_own_film_ratios;
use super::parquet::read_parquet;
use super::places::RowPlaces;
use super::refusals::whole_file;
use super::series::{arrange, Runs};
use super::source::TableSource;
use super::spheres::check_spheres;
use super::stated_errors::check_stated_errors;
use super::told_twice::ComparedColumns;
use super::workbook::{read_sheet, Workbook};
use crate::error::{file_name, quoted, Error, Problem};
use crate::files::MOST_OF_PARQUET;
use crate::remark::Remark;
use crate::scene::{RunColumn, Scene, TableFile, MISSING};
use crate::seed::sha256;

/// Runs as read, with what a reader should know of them.
#[derive(Debug, Default)]
pub struct Table {
    /// the runs in use, ordered by series: all, or few that stand for all
    pub runs: Runs,
    /// rows of the file; a row that is a mean counts as the runs that it stands for
    pub rows: usize,
    /// the sheets of workbooks that were read, as `book.xlsx#May`
    pub sheets: Vec<String>,
    /// rows left out, by reason
    pub screened: Vec<Screened>,
    /// columns that tell the same thing
    pub compared: Vec<ComparedColumns>,
    /// what wants a second look
    pub notices: Vec<Remark>,
    /// SHA-256 of the file
    pub sha256: String,
}

/// Reads, checks and screens the runs of a scene.
///
/// Fails with every bad cell named by line, column and value, where runs without measurement errors have no other spread,
/// where there are more than are kept, and where more spheres have a k of their own than are fitted together; then nothing of the table is used.
pub fn read(scene: &Scene) -> Result<Table, Error> {
    let mut joined = Joined::default();
    let mut rows = 0;
    for file in &scene.data.runs {
        let (table, sha256) = read_table(file, scene)?;
        rows += table.rows;
        if let Some(problem) = too_many_rows(rows, scene) {
            return Err(Error::input(&file.path, vec![problem]));
        }
        joined.add((table, sha256), file)?;
    }
    let (mut collected, mut table) = joined.finish(scene)?;
    let name = &collected.remarks.films[0];
    let own = drop_own_film_ratios(&mut collected.in_use, name, scene.data.film_ratio_gap);
    table.notices.extend(own);
    let places = std::mem::take(&mut table.runs.places);
    table.runs = arrange(collected.in_use, scene);
    table.runs.places = places;
    check_spheres(scene, &table.runs.spheres)?;
    check_stated_errors(scene, &table.runs)?;
    Ok(table)
}

impl Table {
    /// Runs that no file has.
    pub fn of(runs: Runs) -> Table {
        Table {
            rows: runs.len(),
            runs,
            ..Table::default()
        }
    }
}

/// Reads and checks one table; gives the SHA-256 of the file, too.
fn read_table(file: &TableFile, scene: &Scene) -> Result<(Collected, String), Error> {
    let path = file.path.as_path();
    let mut source = TableSource::open(path)?;
    let collected = read_by_exclude(&mut source, file, scene)?;
    if collected.rows == 0 {
        let problem = if file.ends_with(".parquet") || file.ends_with(TableFile::WORKBOOK) {
            whole_file("the table has no rows", "one row a run")
        } else {
            whole_file("no runs below the header", "one line a run")
        };
        return Err(Error::input(path, vec![problem]));
    }
    Ok((collected, source.sha256(path)?))
}

/// Reads and checks the rows of a table.
pub(super) fn read_rows(
    source: &mut TableSource,
    file: &TableFile,
    scene: &Scene,
    take: TakeRuns,
) -> Result<Collected, Error> {
    let path = file.path.as_path();
    if file.ends_with(".parquet") {
        let most = if take.is_none() { MOST_OF_PARQUET } else { u64::MAX };
        let read = read_parquet(&source.parquet(path, most)?, scene, take);
        return read.map_err(|problems| Error::input(path, problems));
    }
    if file.ends_with(TableFile::WORKBOOK) {
        let bytes = source.workbook(path)?;
        let refused = |problems: Vec<Problem>| Error::input(&file.shown(), problems);
        let mut book = Workbook::open(&bytes).map_err(refused)?;
        let sheet = book.sheet(file.sheet.as_deref()).map_err(refused)?;
        let shown = file.of_sheet(sheet.name()).shown();
        return read_sheet(sheet, scene).map_err(|problems| Error::input(&shown, problems));
    }
    let table = source.csv(path, &scene.data.naming)?;
    let read = table.runs(scene, take);
    read.map_err(|problems| Error::input(path, problems))
}

/// All tables as one, whose rows count on from table to table.
#[derive(Default)]
pub(super) struct Joined<'p> {
    all: Collected,
    first: Option<&'p Path>,
    places: RowPlaces,
    /// what was read of each workbook, and whether the scene names its sheet
    sheets: Vec<(&'p TableFile, SheetRead)>,
    notices: Vec<Remark>,
    /// whether any says of its runs which liquid they have
    tells_liquid: bool,
    /// the columns of each table that were not read
    unknown: Vec<(String, Vec<String>)>,
    /// columns that tell the same thing, of each table
    compared: Vec<ComparedColumns>,
    /// SHA-256 of each file
    hashes: Vec<String>,
}

impl<'p> Joined<'p> {
    /// Adds a table; only one is held beside those before it. Fails where means stand for more runs than are kept.
    pub fn add(&mut self, (mut table, sha256): (Collected, String), file: &'p TableFile) -> Result<(), Error> {
        let path = file.path.as_path();
        let notices = [
            table.hidden_rows(path),
            table.hidden_columns(path),
            table.heights_assumed(),
            table.unheeded_columns(path),
            table.excluded_by_yes(path),
            table.excluded_most(path),
        ];
        self.unknown.push((file_name(path), table.remarks.unknown.clone()));
        self.tells_liquid |= table.remarks.tells_liquid;
        self.compared.extend(table.compared_columns(self.all.rows));
        for notice in notices.into_iter().flatten() {
            // what is so of several sheets or files is said once
            let mut before = self.notices.iter_mut();
            match before.find(|own| own.code == notice.code && own.text == notice.text) {
                Some(own) => own.value = Some((own.count() + notice.count()) as f64),
                None => self.notices.push(notice),
            }
        }
        self.hashes.push(sha256);
        let sheet = table.sheet.take();
        let sheet_name = sheet.as_ref().map(|sheet| sheet.name.as_str());
        let is_text = sheet.is_none() && !file.ends_with(".parquet");
        let lines = std::mem::take(&mut table.lines);
        self.places
            .add(self.all.rows, (file_name(path).as_str(), sheet_name), is_text, lines);
        self.sheets.extend(sheet.map(|sheet| (file, sheet)));
        let first = *self.first.get_or_insert(path);
        let has_film_ratio = table.remarks.has_film_ratio;
        if self.all.rows > 0 && self.all.remarks.has_film_ratio != has_film_ratio {
            let [with, without] = if has_film_ratio { [path, first] } else { [first, path] };
            let expected = format!(
                "expected a column `film_ratio`, as {} has: runs of one scene all belong to nominal film ratios, or none does",
                file_name(with)
            );
            return Err(Error::input(without, vec![Problem::new("header", expected)]));
        }
        self.all.append(table);
        if self.all.averaged[1] > MOST_AVERAGED {
            let expected = format!("at most {MOST_AVERAGED} together");
            let problem = whole_file("the rows are means of too many runs", &expected);
            return Err(Error::input(path, vec![problem]));
        }
        Ok(())
    }

    /// The runs as they were read; and what is to be said of them, with the places of their rows.
    ///
    /// Fails where the scene names liquids and no table says which runs have one, which would all be read as dry.
    pub fn finish(mut self, scene: &Scene) -> Result<(Collected, Table), Error> {
        if let Some((liquid, path)) = scene.liquids.first().zip(self.first).filter(|_| !self.tells_liquid) {
            let expected = format!(
                "`columns = {{ liquid = \"…\" }}` in [data] with the table's own name for the column of liquids, or \
                 `constants = {{ liquid = \"{}\" }}` where every run has this one, or no [liquids] where every run is dry",
                liquid.name
            );
            let problem = whole_file("no column `liquid`, though the scene has [liquids]", &expected);
            return Err(Error::input(path, vec![problem]));
        }
        let mut notices: Vec<Remark> = self.sheets_not_read().collect();
        notices.extend(self.all.liquids_without_runs(scene));
        notices.append(&mut self.notices);
        notices.extend(self.all.labelled_rows(&self.places));
        notices.extend(self.all.averaged_rows());
        notices.extend(self.all.dry_beside_film(&self.places));
        notices.extend(self.all.above_one());
        notices.extend(columns_not_read(&self.unknown));
        let sha256 = match self.hashes.as_slice() {
            [only] => only.clone(),
            several => {
                let lines: String = several.iter().map(|hash| format!("{hash}\n")).collect();
                sha256(lines.as_bytes())
            }
        };
        let shown = |(file, sheet): &(&TableFile, SheetRead)| format!("{}#{}", file_name(&file.path), sheet.name);
        let table = Table {
            runs: Runs {
                places: Arc::new(self.places),
                ..Runs::default()
            },
            rows: self.all.runs(),
            sheets: self.sheets.iter().map(shown).collect(),
            screened: self.all.screened(),
            compared: self.compared,
            notices,
            sha256,
        };
        Ok((self.all, table))
    }

    /// Says of a workbook whose sheet the scene does not name which one was read and which were not, and of a hidden sheet
    /// that it was read.
    fn sheets_not_read(&self) -> impl Iterator<Item = Remark> + '_ {
        self.sheets.iter().filter_map(|(file, sheet)| {
            let book = file_name(&file.path);
            let read = quoted(&sheet.name);
            if sheet.is_hidden {
                let text = format!("{book}: sheet {read} is hidden; it is read since the scene names it");
                let next = "nothing, if its runs are meant";
                return Some(Remark::new(SHEETS_NOT_READ, 1, text, next));
            }
            let is_read = |name: &str| {
                let mut read = self.sheets.iter();
                read.any(|(other, own)| other.path == file.path && own.name == name)
            };
            let not_read = |hidden: bool| -> Vec<String> {
                let others = sheet.others.iter();
                let others = others.filter(|(name, is_hidden)| *is_hidden == hidden && !is_read(name));
                others.map(|(name, _)| quoted(name)).collect()
            };
            let (visible, hidden) = (not_read(false), not_read(true));
            if file.sheet.is_some() || visible.is_empty() && hidden.is_empty() {
                return None;
            }
            let mut text = format!("{book}: sheet {read} is read");
            if !visible.is_empty() {
                text.push_str(&format!(", not {}", visible.join(", ")));
            }
            if !hidden.is_empty() {
                let not = if visible.is_empty() { "not" } else { "nor" };
                text.push_str(&format!(", {not} the hidden {}", hidden.join(", ")));
            }
            let count = visible.len() + hidden.len();
            let name = &sheet.name;
            let next = format!("name the sheets that hold runs, as `runs = [\"{book}#{name}\", …]`");
            Some(Remark::new(SHEETS_NOT_READ, count, text, next))
        })
    }
}

/// Reads a table; where its column `exclude` turns out to say yes or no of each run, once more with those kept that have a
/// no there.
fn read_by_exclude(source: &mut TableSource, file: &TableFile, scene: &Scene) -> Result<Collected, Error> {
    let first = read_rows(source, file, scene, None)?;
    let words = first.words_for_no();
    if words.is_empty() {
        return Ok(first);
    }
    let missing = |word: &String| [word.clone(), MISSING.to_owned()];
    let of_column = (RunColumn::Exclude, words.iter().map(missing).collect());
    let mut scene = scene.clone();
    scene.data.naming.words.push(of_column);
    let mut collected = read_rows(source, file, &scene, None)?;
    collected.kept_by_no = words;
    Ok(collected)
}
