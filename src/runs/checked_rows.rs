//! Checks rows of cells one after the other, and gathers their runs or what is wrong with them.

use std::borrow::Cow;

use super::collect::Collected;
use super::columns::{ColumnPlace, TableLayout};
use super::decimals::{parse_number, rounding_of, Decimals};
use super::labels::{is_count, may_mark, Label, NamesForAll};
use super::liquid_cells::LiquidCells;
use super::raw_row::{BadCell, RawRow};
use super::read_run::ReadRun;
use super::refusals::CellPlace;
use super::row::{check_row, RowChecker};
use crate::error::{quoted, Problem, Problems, PROBLEMS_SHOWN};
use crate::rounding::short;
use crate::scene::{RunColumn, Scene};
use crate::units::Dimension;

/// A cell that is not empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell<T> {
    /// a text, which may be a number
    Text(T),
    /// a number
    Number(f64),
    /// a number whose format shows it in per cent: 0.85 as 85 %
    Percent(f64),
    /// what is neither, as a message shows it, and what is amiss with it
    Other(T, &'static str),
}

impl Cell<String> {
    pub fn borrowed(&self) -> Cell<&str> {
        match self {
            Cell::Text(text) => Cell::Text(text),
            Cell::Number(number) => Cell::Number(*number),
            Cell::Percent(number) => Cell::Percent(*number),
            Cell::Other(text, why) => Cell::Other(text, why),
        }
    }
}

impl<'c> Cell<&'c str> {
    /// As a message shows it.
    pub fn text(self) -> Cow<'c, str> {
        match self {
            Cell::Text(text) | Cell::Other(text, _) => text.into(),
            Cell::Number(number) | Cell::Percent(number) => number.to_string().into(),
        }
    }
}

/// Takes the runs of a table a block after the other; where there is none, all are held.
pub(super) type TakeRuns<'t> = Option<&'t mut dyn FnMut(Vec<ReadRun>)>;

/// A column of numbers.
struct NumberColumn<'s> {
    column: RunColumn,
    place: &'s ColumnPlace,
    /// the cell that was read last and its number in SI: those below it mostly are the same
    last: (String, Option<f64>),
}

/// The runs of a table as far as it was read, and what is wrong with them.
pub(super) struct CheckedRows<'s, 't> {
    layout: &'s TableLayout<'s>,
    /// the columns that the table has: those of words, and those of numbers
    words: Vec<(RunColumn, &'s ColumnPlace)>,
    numbers: Vec<NumberColumn<'s>>,
    checker: RowChecker<'s>,
    take: TakeRuns<'t>,
    pub collected: Collected,
    decimals: Decimals<RunColumn>,
    liquids: LiquidCells,
    names_for_all: NamesForAll,
    /// of those that nobody prints only the number is kept, since there may be one a cell
    pub problems: Problems,
    /// whether a wet run lacks a column of films
    wants_film: bool,
}

impl<'s, 't> CheckedRows<'s, 't> {
    pub fn new(layout: &'s TableLayout<'s>, scene: &'s Scene, take: TakeRuns<'t>) -> CheckedRows<'s, 't> {
        let (numbers, words): (Vec<_>, Vec<_>) = layout.columns_read().partition(|(column, _)| column.is_number());
        let numbers = numbers.into_iter().map(|(column, place)| NumberColumn {
            column,
            place,
            last: (String::new(), None),
        });
        CheckedRows {
            layout,
            words,
            numbers: numbers.collect(),
            checker: RowChecker::new(scene, &layout.remarks),
            take,
            collected: Collected::new(&layout.remarks),
            decimals: Decimals::new(),
            liquids: LiquidCells::default(),
            names_for_all: NamesForAll::default(),
            problems: Problems::default(),
            wants_film: false,
        }
    }

    /// Adds the row at a place of the file, and says whether it is a run; `texts` are all its cells that may say that it is
    /// none, `cell` gives what it has in a column of the table.
    pub fn add<'c>(
        &mut self,
        at: CellPlace,
        texts: impl Iterator<Item = &'c str> + Clone,
        cell: impl Fn(&ColumnPlace) -> Option<Cell<&'c str>>,
    ) -> bool {
        self.names_for_all.see(texts.clone());
        let layout = self.layout;
        let text = |(column, place): &(RunColumn, &ColumnPlace)| (*column, cell(place).map(Cell::text));
        let words: Vec<(RunColumn, Option<Cow<str>>)> = self.words.iter().map(text).collect();
        let mut row: RawRow<'_> = layout.row_before_its_cells();
        for (column, word) in &words {
            row.set_word(*column, word.as_deref().and_then(|text| layout.read(*column, text)));
        }
        let liquid = row.word(RunColumn::Liquid);
        self.collected.count(at.number(), row.word(RunColumn::Run));
        // of a run that is left out nothing else is read but what its liquid says of those below
        if let Some(reason) = row.word(RunColumn::Exclude) {
            self.collected.exclude(reason, 1);
            self.liquids.pass(at, liquid);
            return false;
        }
        let runs = layout.place(RunColumn::Runs).and_then(&cell);
        let is_mean_of_runs = runs.is_some_and(|cell| parse_number(&cell.text()).is_ok_and(|runs| runs.value > 1.0));
        let names_spheres = |index| layout.place(RunColumn::Particle).is_some_and(|at| at.index == index);
        let marks_no_run = |(index, text): &(usize, &str)| {
            if !may_mark(text) || self.knows(*index, text, &row) {
                return false;
            }
            match self.names_for_all.label(*index, text) {
                // that it is a mean it says itself
                Some(Label::Mean) => !is_mean_of_runs,
                Some(Label::Other | Label::All) => true,
                // a count of rows stands below names, where in any other column it may be one of averaged runs
                None => names_spheres(*index) && is_count(text),
            }
        };
        if let Some((_, text)) = texts.enumerate().find(marks_no_run) {
            self.collected.add_labelled(text.trim());
            self.liquids.pass(at, liquid);
            return false;
        }
        let mut bad = vec![];
        let mut is_beside_film = false;
        for index in 0..self.numbers.len() {
            let NumberColumn { column, place, .. } = self.numbers[index];
            let cell = cell(place);
            // the film of a run that is called dry is not read at all; beside an empty cell only a number says that there was one
            let is_of_dry = matches!(column, RunColumn::Film | RunColumn::FilmRatio) && row.is_dry();
            if is_of_dry && row.word(RunColumn::Liquid).is_some() {
                let film = cell.and_then(|cell| parse_number(&cell.text()).ok());
                is_beside_film |= film.is_some_and(|film| film.value > 0.0);
                continue;
            }
            match self.number(index, cell, at) {
                Ok(value) => row.set(column, value),
                Err(_) if is_of_dry => {}
                Err(expected) => bad.push(BadCell { column, expected }),
            }
        }
        let holds = |column: RunColumn| row[column].is_some_and(|number| !number.is_nan());
        self.liquids
            .add(at, liquid, holds(RunColumn::Film) || holds(RunColumn::FilmRatio));
        let rounding = |column| {
            let cell = layout.place(column).and_then(&cell);
            cell.map_or(0.0, |cell| rounding_of(&cell.text()))
        };
        if let Some(row) = check_row(&row, &mut self.checker, rounding, &mut bad) {
            for (place, dimension) in &layout.told_constants {
                let cell = cell(place).map(Cell::text);
                let off =
                    cell.and_then(|cell| Some((contradicts(&cell, *dimension, &row.run, self.checker.scene)?, cell)));
                if let Some((expected, cell)) = off {
                    self.refuse_named(at, &place.name, expected, quoted(cell.trim()));
                }
            }
            self.liquids.measured(&row.run);
            if is_beside_film {
                self.collected.add_dry_beside_film();
            }
            self.collected.push(&row, self.checker.scene);
        }
        for bad in bad {
            self.refuse(at, bad, |column| {
                let text = cell(layout.place(column)?)?.text();
                (!text.trim().is_empty()).then(|| quoted(text.trim()))
            });
        }
        true
    }

    /// Gives the runs away that were gathered, where they are a block.
    pub fn give_block(&mut self) {
        /// runs of a block, at least
        const BLOCK: usize = 1 << 19;
        if let Some(take) = self.take.as_mut().filter(|_| self.collected.in_use.len() >= BLOCK) {
            take(std::mem::take(&mut self.collected.in_use));
        }
    }

    /// Whether a cell is in a column whose words have a meaning of their own, as the name of a particle has.
    fn knows(&self, index: usize, text: &str, row: &RawRow) -> bool {
        let column = self.words.iter().find(|(_, place)| place.index == index);
        match column.map(|(column, _)| *column) {
            Some(column @ RunColumn::Particle) => self.checker.knows(column, row.word(column)),
            Some(column @ RunColumn::Liquid) => row.is_dry() || self.checker.knows(column, row.word(column)),
            Some(column) => {
                let word = self.layout.read(column, text);
                word.is_some_and(|word| self.names_for_all.label(index, word).is_none())
            }
            None => false,
        }
    }

    /// The number in a cell of a column of numbers, in SI, or what was expected of it.
    fn number(&mut self, index: usize, cell: Option<Cell<&str>>, at: CellPlace) -> Result<Option<f64>, String> {
        let NumberColumn { column, place, last } = &mut self.numbers[index];
        // the sign of a zero says nothing
        let to_si = |value: f64| place.unit.to_si(value) + 0.0;
        match cell {
            None => Ok(None),
            Some(Cell::Text(text)) => {
                if text != last.0 {
                    let number = self.layout.read(*column, text);
                    let number = number
                        .map(|number| self.decimals.read(number, *column, at))
                        .transpose()?;
                    text.clone_into(&mut last.0);
                    last.1 = number.map(to_si);
                }
                Ok(last.1)
            }
            Some(Cell::Number(value)) => Ok(self.layout.read_number(*column, value).map(to_si)),
            // a share, in a column in per cent, too
            Some(Cell::Percent(share)) if matches!(column.dimension(), Dimension::Share | Dimension::One) => {
                Ok(self.layout.read_number(*column, share).map(|share| share + 0.0))
            }
            Some(Cell::Percent(_)) => Err("expected a number that is not shown in per cent".to_owned()),
            Some(Cell::Other(_, why)) => Err(format!("expected a number{why}")),
        }
    }

    /// Refuses a cell; `found` shows what stands in a column, and `None` where nothing does.
    fn refuse(&mut self, at: CellPlace, bad: BadCell, found: impl FnOnce(RunColumn) -> Option<String>) {
        if bad.column == RunColumn::Film && !self.layout.gives(RunColumn::Film) {
            self.wants_film = true;
            return;
        }
        if self.problems.count >= PROBLEMS_SHOWN {
            self.problems.count += 1;
            return;
        }
        let column = self.layout.blamed(bad.column);
        let found = found(column).unwrap_or_else(|| "an empty cell".to_owned());
        self.refuse_named(at, &self.layout.name(column), bad.expected, found);
    }

    /// The same of any column by its name.
    fn refuse_named(&mut self, at: CellPlace, name: &str, expected: String, found: String) {
        let (line, place) = match at {
            CellPlace::Line(line) => (Some(line), format!("column {name}")),
            CellPlace::Row(row) => (None, format!("row {row}, column {name}")),
        };
        self.problems.push(Problem::new(place, expected).on(line).found(found));
    }

    /// Every run, unless something is wrong.
    pub fn finish(mut self) -> Result<Collected, Problems> {
        if let Some((at, column, text, expected)) = self.decimals.doubt() {
            // without this cell others may be good
            let others = std::mem::take(&mut self.problems);
            self.refuse(at, BadCell { column, expected }, |_| Some(quoted(&text)));
            self.problems.extend(others);
        }
        if let Some((at, bad)) = self.liquids.doubt() {
            self.refuse(at, bad, |_| None);
        }
        let mut all = Problems::default();
        if self.wants_film {
            all.push(self.layout.missing_column(RunColumn::Film, " (wet runs need it)"));
        }
        all.extend(self.problems);
        match all.count {
            0 => Ok(self.collected),
            _ => Err(all),
        }
    }
}

/// What was expected of a cell that tells the viscosity or the density of a wet run's materials otherwise than the scene, in any
/// unit; `None` where it agrees, or is no number.
fn contradicts(cell: &str, dimension: Dimension, row: &ReadRun, scene: &Scene) -> Option<String> {
    /// by what share a property may differ from run to run, as with the temperature
    const FROM_RUN_TO_RUN: f64 = 0.05;
    let value = parse_number(cell.trim()).ok()?.value;
    let particle = &scene.particles[row.setting.particle as usize];
    let liquid = &scene.liquids[row.setting.liquid? as usize];
    let constants = match dimension {
        Dimension::Viscosity => vec![(&liquid.name, liquid.viscosity, liquid.viscosity_rel_sd)],
        _ => vec![
            (&particle.name, particle.density, particle.density_rel_sd),
            (&liquid.name, liquid.density, liquid.density_rel_sd),
        ],
    };
    let agrees = |(_, constant, sd): &(&String, f64, Option<f64>)| {
        let most = FROM_RUN_TO_RUN.max(3.0 * sd.unwrap_or_default()) + rounding_of(cell);
        let mut units = dimension.units().iter();
        units.any(|unit| (unit.to_si(value) / constant).ln().abs() <= most)
    };
    if value.is_nan() || value <= 0.0 || constants.iter().any(agrees) {
        return None;
    }
    let usual = &dimension.units()[0];
    let each = constants
        .iter()
        .map(|(name, constant, _)| format!("{} {} of {name}", short(usual.from_si(*constant)), usual.symbol));
    Some(format!(
        "expected {}, as the scene has it: correct the one that is wrong, or take the column out of the table",
        each.collect::<Vec<_>>().join(" or ")
    ))
}
