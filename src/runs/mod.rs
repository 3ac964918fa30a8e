//! Holds what was measured: runs as plain columns, checked cell by cell, screened with reasons, ordered by series.
//!
//! | file | job |
//! |---|---|
//! | `errors.rs` | holds the measurement errors of runs |
//! | `read_run.rs` | holds one run as it was read, before runs are put in order |
//! | `raw_row.rs` | holds one run as a file has it, and how its heights and Stokes number become speeds |
//! | `averaged.rs` | reads a row that is the mean of several runs as those runs |
//! | `words.rs` | tells the words of a list, and knows those of a column of reasons that keep a run |
//! | `labels.rs` | knows the words that mark a row as the mean, total or spread of others |
//! | `places.rs` | says where a row stands as a person sees it |
//! | `told_twice.rs` | compares columns that tell the same thing of a run |
//! | `headers/` | says what headers tell of the numbers below them |
//! | `columns.rs` | matches a table's header with the columns runs can have |
//! | `row.rs` | checks one run and says which cell is wrong |
//! | `screen.rs` | says why a checked run is left out |
//! | `damaged.rs` | catches a library's panic over a damaged file, and passes our own on |
//! | `refusals.rs` | says where a bad cell stands, and what is wrong with a row or a file |
//! | `decimals.rs` | finds what separates columns and decimals |
//! | `survey.rs` | says what each column of an unknown table is called and holds |
//! | `guess.rs` | guesses which column of runs it is, by the names in `headers/called.txt` |
//! | `nominal.rs` | looks whether a column of film ratios holds nominal ones |
//! | `collect.rs` | gathers checked runs into columns and counts what was left out |
//! | `liquid_cells.rs` | watches whether liquids are written in every row or once a block |
//! | `checked_rows.rs` | checks rows of cells, and gathers their runs or what is wrong |
//! | `records.rs` | cuts a CSV into records and their cells with csv-core; the only file that names it |
//! | `csv.rs` | reads CSV in the order of the file, its runs or what is wrong with them |
//! | `parquet_footer.rs` | checks the counts a Parquet file states before memory is allocated by them |
//! | `new_run.rs` | holds one run to be written |
//! | `parquet.rs` | reads and writes Parquet with polars; with `parquet_footer.rs` the only file that names it |
//! | `hidden_rows.rs` | finds the rows and columns of a sheet that its workbook hides |
//! | `workbook.rs` | reads a sheet of a spreadsheet with calamine; the only file that names it |
//! | `source.rs` | opens a table, and reads no more of it than a format may have |
//! | `fields.rs` | reads a table whose columns are not those of runs, by those that it may have |
//! | `settings.rs` | reads the settings that predictions are asked for |
//! | `draft.rs` | drafts a scene from a table |
//! | `classes.rs` | puts numbers in classes, a part of them after the other |
//! | `film_groups.rs` | puts runs in groups of one film ratio, and measures how wide each is |
//! | `spheres.rs` | holds the spheres that have a k of their own |
//! | `series.rs` | orders runs by series |
//! | `impacts.rs` | computes of each run, once, what the laws and the energy balance read |
//! | `true_speeds.rs` | says how true speeds are distributed where measured ones err |
//! | `stated_errors.rs` | refuses runs without errors where errors are to be all that scatters them |
//! | `part.rs` | takes a part of the runs |
//! | `slabs.rs` | divides the runs of a series in slabs, in each of which laws are nearly polynomials |
//! | `condense.rs` | takes few of very many runs that stand for all |
//! | `table.rs` | reads the tables of a scene, every run of them |
//! | `many.rs` | reads more runs than are kept, as few that stand for all and a sample |
//! | `write.rs` | writes runs, simulated ones a row at a time |

mod averaged;
mod checked_rows;
mod classes;
mod collect;
mod columns;
mod condense;
mod csv;
mod damaged;
mod decimals;
mod draft;
mod errors;
mod fields;
mod film_groups;
mod guess;
mod headers;
mod hidden_rows;
mod impacts;
mod labels;
mod liquid_cells;
mod many;
mod new_run;
mod nominal;
mod parquet;
mod parquet_footer;
mod part;
mod places;
mod raw_row;
mod read_run;
mod records;
mod refusals;
mod row;
mod screen;
mod series;
mod settings;
mod slabs;
mod source;
mod spheres;
mod stated_errors;
mod survey;
mod table;
mod told_twice;
mod true_speeds;
mod words;
mod workbook;
mod write;

pub use collect::Screened;
pub(crate) use collect::{OF_READING, OTHER_LABEL};
pub use draft::Draft;
pub use errors::{RunError, RunsWithErrors};
pub(crate) use fields::{column, rows_by_fields, text_rows, Column, Fields, Row, TextRow};
pub use film_groups::{rounded_film_ratio, FilmGroup, NEAR_NOMINAL, WIDEST};
pub use impacts::{by_film, Conditions};
pub use many::{read_any_number, MOST_KEPT};
pub use new_run::NewRun;
pub use part::is_in_even_share;
pub use places::RowPlaces;
pub(crate) use raw_row::LARGEST_RESTITUTION;
pub(crate) use refusals::whole_file;
pub(crate) use screen::NOTHING_USES;
pub use series::{DryGroup, Impacts, Runs, Series};
pub use settings::{read_settings, AskedSetting};
pub use spheres::{diameter_in_mm, sphere_label, sphere_words, Sphere, MOST_SPHERES};
pub use table::{read, Table};
pub use told_twice::{ComparedBlock, ComparedColumns};
pub use true_speeds::{SharedSpeed, TrueSpeed, TrueSpeeds, GAP};
pub(crate) use words::words_for_no;
pub use write::{free_place, RunWriter, TableFormat};

use std::path::Path;

use read_run::{ReadRun, RowSetting};
use source::TableSource;
use survey::Survey;
use workbook::Workbook;

use crate::error::{quoted, Error, Problem};
use crate::files::MOST_OF_PARQUET;
use crate::scene::{HiddenRows, Naming, Scene, TableFile};

/// Puts simulated runs in order, as [`read`] does those of a file.
pub fn arrange(scene: &Scene, new: &[NewRun]) -> Runs {
    let index = |position: Option<usize>| position.and_then(|i| u32::try_from(i).ok());
    let read = new.iter().zip(1..).map(|(run, row)| {
        let particle = index(scene.particles.iter().position(|p| p.name == run.particle));
        let liquid = run.liquid.map(|name| scene.liquids.iter().position(|l| l.name == name));
        ReadRun {
            setting: RowSetting {
                particle: particle.unwrap_or_default(),
                liquid: liquid.and_then(index),
                diameter: run.diameter,
                film: run.film.map_or(0.0, |(film, _)| film),
            },
            impact_speed: run.impact_speed,
            restitution: run.restitution,
            film_ratio: run.film.map(|(_, ratio)| ratio),
            row,
            ..ReadRun::default()
        }
    });
    series::arrange(read.collect(), scene)
}

/// Drafts a scene from a table that it is to name `runs`.
///
/// Fails where the table cannot be read, or has no rows.
pub fn draft_scene(file: &TableFile, runs: &str) -> Result<Draft, Error> {
    let path = file.path.as_path();
    let refused = |problems: Vec<Problem>| Error::input(&file.shown(), problems);
    let mut source = TableSource::open(path)?;
    let mut survey = if file.ends_with(".parquet") {
        parquet::survey_parquet(source.parquet(path, MOST_OF_PARQUET)?).map_err(refused)?
    } else if file.ends_with(TableFile::WORKBOOK) {
        survey_workbook(&source.workbook(path)?, file.sheet.as_deref()).map_err(refused)?
    } else {
        survey_text(&mut source, path)?
    };
    survey.settle_labels();
    if survey.rows == 0 {
        return Err(refused(vec![whole_file("no runs below the header", "one row a run")]));
    }
    if !survey.is_table() {
        let expected = match file.ends_with(TableFile::WORKBOOK) {
            true => "a row with a name in each column, and numbers below it",
            false => {
                "a line with the names of columns, a comma, a semicolon or a tab between each two, and numbers below it"
            }
        };
        return Err(refused(vec![whole_file("no row names the columns", expected)]));
    }
    Ok(draft::draft(&survey, runs))
}

/// Surveys a CSV, whose names may stand below titles.
fn survey_text(source: &mut TableSource, path: &Path) -> Result<Survey, Error> {
    let refused = |problems: Vec<Problem>| Error::input(path, problems);
    source.check_text(path)?;
    let usual = source.separator(path, &Naming::default())?;
    let mut first = vec![];
    for separator in [b',', b';', b'\t'] {
        let table = source.separated_by(separator, path)?;
        let rows = table.first_rows(survey::ROWS_OF_HEADER).map_err(refused)?;
        first.push((survey::row_of_names(&rows), separator, rows));
    }
    // the separator that parts the line of names most
    let width = |(row, separator, rows): &FirstRows| {
        let names = rows.iter().find(|(line, _)| Some(*line) == *row);
        (names.map_or(0, |(_, cells)| cells.len()), *separator == usual)
    };
    let best = first.into_iter().filter(|(row, ..)| row.is_some()).max_by_key(width);
    let (row, separator, rows) = best.unwrap_or((None, usual, vec![]));
    let table = source.separated_by(separator, path)?;
    let mut survey = table.survey(row).map_err(refused)?;
    survey.take_titles(rows);
    Ok(survey)
}

/// The line of names, if one was found, by a separator of columns, and the first rows that it parts.
type FirstRows = (Option<u64>, u8, Vec<(u64, Vec<String>)>);

/// Surveys the sheet of a workbook that is named, else those that are not hidden and have the columns of the first that looks
/// like a table.
fn survey_workbook(bytes: &[u8], named: Option<&str>) -> Result<Survey, Vec<Problem>> {
    let mut book = Workbook::open(bytes)?;
    let all = book.sheets();
    let visible = all
        .iter()
        .filter(|(_, is_hidden)| !is_hidden)
        .map(|(name, _)| name.as_str());
    let wanted: Vec<Option<&str>> = match named {
        None if all.iter().any(|(_, is_hidden)| !is_hidden) => visible.map(Some).collect(),
        _ => vec![named],
    };
    let only = wanted.len() == 1;
    let mut found: Option<(columns::TableHeader, Survey)> = None;
    let mut left = vec![];
    for name in wanted {
        let mut sheet = book.sheet(name)?;
        let first = sheet.peek(survey::ROWS_OF_HEADER)?;
        let naming = Naming {
            header_row: survey::row_of_names(&first),
            hidden_rows: Some(HiddenRows::Leave),
            ..Naming::default()
        };
        let header = match sheet.header(&naming) {
            Err(problems) if only => return Err(problems),
            // an empty sheet
            Err(_) => continue,
            Ok(header) => columns::TableHeader {
                sheet: None,
                titles: vec![],
                lines_above: vec![],
                ..header
            },
        };
        let width = header.names.len();
        let survey = match &mut found {
            Some((known, survey)) if *known == header => {
                survey.keep_titles(&first);
                survey
            }
            Some((_, survey)) if survey.is_table() && survey.rows + survey.labelled.len() > 0 => {
                left.push(sheet.name().to_owned());
                continue;
            }
            // what came before is a cover
            cover => {
                left.extend(cover.take().map(|(_, survey)| survey.sheets).unwrap_or_default());
                let mut survey = Survey::new(header.clone());
                survey.take_titles(first);
                &mut cover.insert((header, survey)).1
            }
        };
        survey.sheets.push(sheet.name().to_owned());
        while let Some(row) = sheet.next_row()? {
            survey.add(row.number, row.texts(width).iter().map(String::as_str));
        }
        survey.hidden_rows += sheet.read.hidden_rows.len();
        for (index, column) in survey.columns.iter().enumerate() {
            let name = quoted(&column.name);
            if !column.name.is_empty() && sheet.hides_column(index) && !survey.hidden_columns.contains(&name) {
                survey.hidden_columns.push(name);
            }
        }
    }
    let Some((_, mut survey)) = found else {
        return Err(vec![whole_file("every sheet is empty", "a sheet with one row a run")]);
    };
    if named.is_some() || all.len() == 1 {
        survey.sheets.clear();
    } else {
        let hidden = all.iter().filter(|(_, is_hidden)| *is_hidden);
        survey.sheets_left = left.iter().map(|name| quoted(name)).collect();
        survey
            .sheets_left
            .extend(hidden.map(|(name, _)| format!("{} (hidden)", quoted(name))));
    }
    Ok(survey)
}

#[cfg(test)]
mod tests;
