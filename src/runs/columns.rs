//! Matches the header of a table with the columns runs can have.

use super::headers::called::parted;
use super::headers::header::in_plain_signs;
use super::headers::heights::{other_height, other_height_by_line};
use super::headers::remarks::{in_no_unit, unit_in_line, unknown_word};
use super::headers::units::{
    unit_in_brackets, unit_in_name, unit_of_cell, unit_of_cell_above, units_above, StatedUnit,
};
use super::headers::{constant_named, other_quantity};
use super::raw_row::{RawRow, IMPACTS, REBOUNDS};
use super::told_twice::TOLD_TWICE;
use crate::error::{quoted, unless_wrong, Problem};
use crate::scene::{already_given, closest, Constant, ConstantValue, HeightsTo, Naming, RunColumn, MISSING};
use crate::units::{names_in_words, Dimension, Unit};

/// What a cell holds without the blanks around it; `None` where it is missing.
pub(super) fn present(cell: &str) -> Option<&str> {
    let text = cell.trim();
    (!text.is_empty() && text != MISSING).then_some(text)
}

/// The names in a table's header, with what stands around them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct TableHeader {
    pub names: Vec<String>,
    /// units in the row below the names; empty without such a row
    pub units: Vec<String>,
    /// units in the row above the names, nothing in place of other cells; empty without such a row
    pub units_above: Vec<String>,
    /// the titles right above the names, nothing where there is none; empty without such a row
    pub titles: Vec<String>,
    /// what stands above the names, but for titles right above several of them
    pub lines_above: Vec<String>,
    /// the line or row of the names, from 1
    pub line: Option<u64>,
    /// which sheet of a workbook it is
    pub sheet: Option<String>,
}

/// Rows above the names whose words are looked at, besides the last.
pub(super) const MOST_ABOVE: usize = 40;

impl TableHeader {
    /// A header of these rows, the last of which names the columns.
    pub fn of(above: &[Vec<String>], names: Vec<String>) -> TableHeader {
        let right_above = above.last().map_or(&[][..], Vec::as_slice);
        let filled = |row: &[String]| row.iter().filter(|cell| present(cell).is_some()).count();
        let lines = if filled(right_above) > 1 {
            &above[..above.len() - 1]
        } else {
            above
        };
        let lines = lines.iter().flatten().filter(|cell| present(cell).is_some());
        TableHeader {
            lines_above: lines.map(|cell| cell.trim().to_owned()).collect(),
            ..TableHeader::below(right_above, names)
        }
    }

    /// A header with a row of units or titles above it: a column without a name has the title right above it, and a name that
    /// occurs twice gets its group's title, as `Impact Speed`.
    pub fn below(above: &[String], mut names: Vec<String>) -> TableHeader {
        let mut units_above = units_above(above.iter().map(String::as_str));
        // a line about the whole table has no titles of columns
        let titles = if units_above.is_empty() { &[] } else { above };
        let title = |index: usize| {
            let cell = titles.get(index).map_or("", |cell| cell.trim());
            Some(cell).filter(|cell| !cell.is_empty() && unit_of_cell(cell).is_none())
        };
        let unnamed = |names: &[String], index: usize| names.get(index).is_none_or(String::is_empty);
        // names over two rows: those that have no groups are merged with the row below
        let merged: Vec<usize> = (0..titles.len())
            .filter(|index| title(*index).is_some() && unnamed(&names, *index))
            .collect();
        if let (Some(last), true) = (merged.last(), merged.len() > 1) {
            names.resize(names.len().max(last + 1), String::new());
        }
        // the cells of a group are merged, too, so that all but the first are empty
        let mut group = String::new();
        let mut in_groups = vec![];
        for (index, name) in names.iter_mut().enumerate() {
            if let Some(title) = title(index) {
                group = format!("{title} ");
            }
            if merged.contains(&index) {
                *name = std::mem::take(&mut group).trim_end().to_owned();
            }
            in_groups.push(format!("{group}{name}"));
        }
        let count = |all: &[String], name: &String| all.iter().filter(|other| *other == name).count();
        let alone = names.clone();
        for (name, in_group) in names.iter_mut().zip(&in_groups) {
            let is_told = merged.len() > 1 || count(&alone, name) > 1;
            if is_told && !name.is_empty() && count(&in_groups, in_group) == 1 {
                name.clone_from(in_group);
            }
        }
        // a single one above the first column is that of the table
        let of_table = titles.iter().skip(1).all(|cell| cell.trim().is_empty());
        let titles = (0..if of_table { 0 } else { names.len() }).map(|index| title(index).unwrap_or_default());
        let titles: Vec<String> = titles.map(str::to_owned).collect();
        // the unit of a group, above a name that has none
        for ((unit, title), name) in units_above.iter_mut().zip(&titles).zip(&names) {
            if unit.is_empty() && parted(name).1.is_none() {
                *unit = unit_in_brackets(title).map_or(String::new(), |(before, _)| title[before.len()..].to_owned());
            }
        }
        if units_above.iter().all(String::is_empty) {
            units_above.clear();
        }
        TableHeader {
            names,
            units_above,
            titles,
            ..TableHeader::default()
        }
    }

    /// What a line `D = …` or `D: …` above the names says of a column in words: with the name, less its unit, before it, and alone.
    fn legend(&self, name: &str) -> Option<[String; 2]> {
        let symbol = name.split(['(', '[', '/', ',']).next()?.trim();
        let says = |line: &String| {
            let (before, after) = line.split_once(['=', ':'])?;
            let meaning = after.split(';').next()?.trim();
            let is_in_words = meaning.contains(char::is_alphabetic) && !meaning.contains(|c: char| c.is_ascii_digit());
            let is_of_name = before.split_whitespace().next_back() == Some(symbol);
            (is_of_name && is_in_words).then(|| [format!("{symbol} ({meaning})"), meaning.to_owned()])
        };
        self.lines_above.iter().find_map(says)
    }

    /// The title above a name, or of heights the one that reaches over it from the left.
    fn title(&self, index: usize, column: RunColumn) -> &str {
        let mut up_to = self.titles.iter().take(index + 1).rev();
        let own = up_to.next().filter(|title| !title.is_empty());
        let is_of_heights = |title: &str| {
            let title = title.to_lowercase();
            ["height", "höhe"].iter().any(|word| title.contains(word))
        };
        let of_group = || {
            let title = up_to.find(|title| !title.is_empty())?;
            let is_height = matches!(column, RunColumn::DropHeight | RunColumn::ReboundHeight);
            Some(title).filter(|title| is_height && is_of_heights(title))
        };
        own.or_else(of_group).map_or("", String::as_str)
    }
}

/// Where each column stands in the table, and in which unit.
#[derive(Debug)]
pub(super) struct TableLayout<'s> {
    places: [Option<ColumnPlace>; RunColumn::ALL.len()],
    /// what a reader of the table should know of its header
    pub remarks: HeaderRemarks,
    /// names that are no column's
    unread: Vec<String>,
    /// those of them that tell a constant of the scene, by their place and what it is
    pub told_constants: Vec<(ColumnPlace, Dimension)>,
    /// the line of the header
    line: Option<u64>,
    /// how many columns the table has
    pub width: usize,
    naming: &'s Naming,
    /// columns that are the same in every row
    constants: Vec<&'s Constant>,
}

/// What a reader of a table should know of its header.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct HeaderRemarks {
    /// columns that are not used, as a message shows them
    pub unknown: Vec<String>,
    /// columns that are read only where another has nothing, each with that one
    pub unheeded: Vec<[String; 2]>,
    /// what the columns that tell the same thing are called
    pub told_twice: [[String; 2]; TOLD_TWICE.len()],
    /// what the columns of film ratios and films are called
    pub films: [String; 2],
    /// what heights are above, where speeds follow from those of a point of the sphere that the scene does not tell
    pub lowest_point_above: Option<String>,
    /// whether it or the scene says of each run which liquid it has
    pub tells_liquid: bool,
    /// whether there are nominal film ratios, which then every wet run needs
    pub has_film_ratio: bool,
}

/// A column's place in a table.
#[derive(Debug, Clone)]
pub(crate) struct ColumnPlace {
    pub index: usize,
    pub name: String,
    pub unit: &'static Unit,
}

impl<'s> TableLayout<'s> {
    /// Matches a header.
    pub fn new(header: &TableHeader, naming: &'s Naming) -> Result<TableLayout<'s>, Vec<Problem>> {
        let layout = TableLayout {
            places: Default::default(),
            remarks: HeaderRemarks::default(),
            unread: vec![],
            told_constants: vec![],
            line: header.line,
            width: header.names.len(),
            naming,
            constants: naming.constants_of(header.sheet.as_deref()),
        };
        let mut matching = Matching {
            layout,
            misnamed: vec![],
            problems: vec![],
        };
        matching.match_names(header);
        if matching.misnamed.is_empty() && matching.layout.places.iter().all(Option::is_none) {
            let expected =
                "expected the names of columns, among them particle, diameter_mm, impact_speed_m_s and restitution";
            let hint = match naming.header_row {
                None => "; where titles stand above the names, `header_row` in [data] says in which row these are",
                Some(_) => "",
            };
            let problem = Problem::new("header", format!("{expected}{hint}")).on(header.line);
            return Err(vec![problem.found(quoted(&header.names.join(",")))]);
        }
        matching.require_columns();
        matching.layout.remark();
        unless_wrong(matching.problems, matching.layout)
    }

    /// Notes which columns are read only where others have nothing, and what columns that tell the same are called.
    fn remark(&mut self) {
        let told = |column: RunColumn| Some(quoted(&self.place(column)?.name));
        let unheeded = TOLD_TWICE
            .into_iter()
            .filter_map(|[column, other]| Some([told(column)?, told(other)?]));
        let unheeded = unheeded.collect();
        let gives_only = |height: RunColumn, one_of: [RunColumn; 3]| {
            let mut others = one_of.into_iter().filter(|column| *column != height);
            self.gives(height) && !others.any(|column| self.gives(column))
        };
        let reads_heights =
            gives_only(RunColumn::DropHeight, IMPACTS) || gives_only(RunColumn::ReboundHeight, REBOUNDS);
        self.remarks = HeaderRemarks {
            unheeded,
            told_twice: TOLD_TWICE.map(|both| both.map(|column| self.name(column))),
            films: [RunColumn::FilmRatio, RunColumn::Film].map(|column| self.name(column)),
            lowest_point_above: (reads_heights && !self.naming.heights_of_is_told).then(|| {
                match self.naming.heights_to {
                    HeightsTo::Plate => "the plate, less the film".to_owned(),
                    HeightsTo::Film => "the film".to_owned(),
                }
            }),
            tells_liquid: self.gives(RunColumn::Liquid),
            has_film_ratio: self.gives(RunColumn::FilmRatio),
            unknown: std::mem::take(&mut self.remarks.unknown),
        };
    }

    pub fn place(&self, column: RunColumn) -> Option<&ColumnPlace> {
        self.places[column as usize].as_ref()
    }

    /// The columns that are read, with their places.
    pub fn columns_read(&self) -> impl Iterator<Item = (RunColumn, &ColumnPlace)> {
        let placed = |column: RunColumn| Some((column, self.place(column)?));
        RunColumn::ALL.into_iter().filter_map(placed)
    }

    /// What is expected of a column whose numbers a workbook shows with other units than it is read in; with the column's name.
    pub fn other_unit_shown(&self, index: usize, shown: &str) -> Option<(&str, String)> {
        let (column, place) = self.columns_read().find(|(_, place)| place.index == index)?;
        let unknown = || unknown_word(&format!("({shown})"), column.dimension()).map(StatedUnit::Other);
        let stated = unit_of_cell(shown).or_else(unknown)?;
        let expected = another_unit((column, place.unit), stated, "the number format of its cells")?;
        Some((&place.name, expected))
    }

    /// Whether the table has a column or the scene says what it holds in every row.
    pub fn gives(&self, column: RunColumn) -> bool {
        self.place(column).is_some() || self.constants.iter().any(|constant| constant.column == column)
    }

    /// A row whose cells are not read yet.
    pub fn row_before_its_cells(&self) -> RawRow<'s> {
        let mut row = RawRow::default();
        for Constant { column, value, .. } in self.constants.iter().copied() {
            match value {
                ConstantValue::Number(value) => row.set(*column, Some(*value)),
                ConstantValue::Word(word) => row.set_word(*column, present(word)),
            }
        }
        row
    }

    /// What a cell holds, in our words; `None` where it is missing.
    pub fn read<'c>(&self, column: RunColumn, cell: &'c str) -> Option<&'c str>
    where
        's: 'c,
    {
        let cell = present(cell)?;
        let of_column = self.naming.words.iter().filter(|(of, _)| *of == column);
        match of_column
            .flat_map(|(_, words)| words)
            .find(|[theirs, _]| theirs == cell)
        {
            Some([_, ours]) => present(ours),
            None => Some(cell),
        }
    }

    /// What a number stands for, in our words; `None` where it marks a missing cell.
    pub fn read_number(&self, column: RunColumn, number: f64) -> Option<f64> {
        let mut of_column = self.naming.words.iter().filter(|(of, _)| *of == column);
        let words = of_column.find_map(|(_, words)| words.iter().find(|[theirs, _]| theirs.parse() == Ok(number)));
        match words {
            Some([_, ours]) => present(ours)?.parse().ok(),
            None => Some(number),
        }
    }

    /// The column to name where a value is missing that one of several columns could give.
    pub fn blamed(&self, column: RunColumn) -> RunColumn {
        let one_of: &[RunColumn] = match column {
            RunColumn::Restitution => &REBOUNDS,
            RunColumn::ImpactSpeed => &IMPACTS,
            RunColumn::RestitutionSdOfRuns => &[RunColumn::RestitutionSdOfRuns, RunColumn::RestitutionSe],
            _ => return column,
        };
        let mut given = one_of.iter().filter(|column| self.place(**column).is_some());
        given.next().copied().unwrap_or(column)
    }

    /// The name a column has in this table.
    pub fn name(&self, column: RunColumn) -> String {
        self.place(column)
            .map_or_else(|| column.usual_name(), |place| place.name.clone())
    }

    /// Says that a column is missing, and which name in the header is nearest.
    pub fn missing_column(&self, column: RunColumn, also: &str) -> Problem {
        let name = column.usual_name();
        let hint = match closest(&name, self.unread.iter().map(String::as_str)) {
            Some(near) => format!("; the nearest is {}", quoted(near)),
            None if self.unread.is_empty() => String::new(),
            None => {
                let unread: Vec<String> = self.unread.iter().map(|name| quoted(name)).collect();
                format!("; columns not known: {}", unread.join(", "))
            }
        };
        Problem::new(format!("column {name}"), format!("missing column{also}{hint}")).on(self.line)
    }
}

/// A header that is being matched, and what is wrong with it.
struct Matching<'s> {
    layout: TableLayout<'s>,
    /// columns whose name is misspelt or lacks its unit
    misnamed: Vec<RunColumn>,
    problems: Vec<Problem>,
}

impl Matching<'_> {
    fn match_names(&mut self, header: &TableHeader) {
        let naming = self.layout.naming;
        for (index, name) in header.names.iter().enumerate() {
            let told = naming.columns.iter().find(|(_, theirs)| theirs == name);
            match RunColumn::named(told.map_or(name, |(ours, _)| ours)) {
                Some(read_as) => {
                    self.compare_with_header(header, index, read_as, told.map(|(ours, _)| ours.as_str()));
                    let (column, unit) = read_as;
                    let name = name.clone();
                    self.add_column(column, ColumnPlace { index, name, unit });
                }
                None => self.add_other_name(header, index, name),
            }
        }
        for (ours, theirs) in &naming.columns {
            if !header.names.contains(theirs) {
                self.refuse_absent(ours, theirs);
            }
        }
        for Constant { column, name, .. } in self.layout.constants.clone() {
            if let Some(place) = self.layout.place(*column) {
                let own = place.name.clone();
                let expected = format!("expected no such column: by the scene `{name}` is the same in every row");
                self.refuse(&own, expected);
            }
        }
    }

    /// Refuses a column where its header says another unit, quantity or height than it is read as; by its name only where that
    /// is not ours but `told` in the scene.
    fn compare_with_header(
        &mut self,
        header: &TableHeader,
        index: usize,
        read_as: (RunColumn, &'static Unit),
        told: Option<&str>,
    ) {
        let naming = self.layout.naming;
        let (column, name) = (read_as.0, &header.names[index]);
        let dimension = column.dimension();
        let plain = in_plain_signs(name);
        let legend = told.and_then(|_| header.legend(name));
        let by_legend = |ours| {
            let mut each = legend.iter().flatten();
            let told = each.find_map(|legend| other_quantity(legend, column, ours))?;
            Some(told.replacen("by its name", "by a line above the names", 1))
        };
        let other = told.and_then(|ours| other_quantity(&plain, column, ours).or_else(|| by_legend(ours)));
        // the unit of another quantity says no more
        let is_own = other.is_none();
        let by_name = told.filter(|_| is_own).and_then(|_| stated_by_name(&plain, column));
        let below = header.units.get(index).and_then(|cell| unit_of_cell(cell));
        let above = header.units_above.get(index);
        let above = above.and_then(|cell| unit_of_cell_above(cell, dimension));
        // of a unit that the name or the row above or below it states, what is said of others says no more
        let has_none = [&parted(&plain).1, &by_name, &below, &above]
            .into_iter()
            .all(Option::is_none);
        let title = in_plain_signs(header.title(index, column));
        let of_group = parted(&title).1.filter(|stated| has_none && is_unit_of(stated, column));
        let of_legend = legend.as_ref().filter(|_| has_none && is_own);
        let of_legend = of_legend.and_then(|[with_name, _]| unit_in_name(with_name, dimension));
        let of_line = || unit_in_line(&header.lines_above.join(";"), column);
        let of_legend = of_legend.or_else(|| of_line().filter(|_| has_none && is_own));
        let has_no_unit = has_none && of_group.is_none() && of_legend.is_none();
        for (stated, by) in [
            (by_name, "its name"),
            (below, "the row below its name"),
            (above, "the row above its name"),
            (of_group, "the title above its name"),
            (of_legend, "a line above the names"),
        ] {
            let expected = stated.and_then(|stated| another_unit(read_as, stated, by));
            expected.into_iter().for_each(|expected| self.refuse(name, expected));
        }
        let by_name = told.and_then(|_| other_height(&plain, "its name", column, naming));
        let by_title = || other_height(&title, "the title above its name", column, naming);
        let mut lines = header.lines_above.iter();
        let by_line = || lines.find_map(|line| other_height_by_line(line, column, naming));
        let height = by_name.or_else(by_title).or_else(by_line);
        let is_doubtful = told.is_some() && is_own && has_no_unit && height.is_none();
        let by_name = unknown_word(&plain, dimension).map(|word| ("its name", word));
        // a word among units
        let has_units_above = !header.units_above.is_empty();
        let of_title = || unknown_word(&format!("({})", title.trim_matches(['(', ')'])), dimension);
        let by_title = || Some(("the title above its name", of_title().filter(|_| has_units_above)?));
        let unknown = by_name.or_else(by_title).filter(|_| is_doubtful);
        let unknown = unknown.map(|(by, word)| {
            format!(
                "by {by} it {}; expected {}: convert its numbers, or leave the word out where it is no unit",
                in_no_unit(&word),
                names_in_words(column.base(), dimension)
            )
        });
        for expected in other.into_iter().chain(height).chain(unknown) {
            self.refuse(name, expected);
        }
    }

    fn refuse(&mut self, name: &str, expected: String) {
        let problem = Problem::new(format!("column {name}"), expected);
        self.problems.push(problem.on(self.layout.line));
    }

    /// Puts a column in its place, once and in one unit.
    fn add_column(&mut self, column: RunColumn, place: ColumnPlace) {
        let name = &place.name;
        let expected = match &self.layout.places[column as usize] {
            Some(first) if first.name == *name => "the column is there twice".to_owned(),
            Some(first) => already_given(column.base(), &first.name),
            None => {
                self.layout.places[column as usize] = Some(place);
                return;
            }
        };
        self.refuse(name, expected);
    }

    /// Refuses a name that is nearly that of a column which nothing gives, unless it is too short to tell, or says the opposite;
    /// any other column is not used.
    fn add_other_name(&mut self, header: &TableHeader, index: usize, name: &str) {
        /// letters of names that are near too many words
        const SHORT: usize = 4;
        let naming = self.layout.naming;
        let is_given = |column: RunColumn| {
            let told = |name: &String| naming.columns.iter().find(|(_, theirs)| theirs == name);
            let mut names = header
                .names
                .iter()
                .map(|name| told(name).map_or(name, |(ours, _)| ours));
            let is_of = |(own, _): (RunColumn, _)| own == column;
            names.any(|name| RunColumn::named(name).is_some_and(is_of)) || self.layout.gives(column)
        };
        let may_be_meant = |column: RunColumn| {
            let is_long = name.chars().count() > SHORT || RunColumn::of_base(&name.to_lowercase()).is_some();
            let is_opposite = column == RunColumn::Exclude && other_quantity(name, column, column.base()).is_some();
            is_long && !is_given(column) && !is_opposite
        };
        let near = RunColumn::nearly(name).filter(|(column, _)| may_be_meant(*column));
        if let Some((column, expected)) = near {
            self.refuse(name, expected);
            self.misnamed.push(column);
        } else if name.is_empty() {
            self.layout.remarks.unknown.push(unnamed_column(index));
        } else {
            let place = |dimension: Dimension| ColumnPlace {
                index,
                name: name.to_owned(),
                unit: &dimension.units()[0],
            };
            let told = constant_named(&in_plain_signs(name)).map(|dimension| (place(dimension), dimension));
            self.layout.told_constants.extend(told);
            self.layout.unread.push(name.to_owned());
            self.layout.remarks.unknown.push(quoted(name));
        }
    }

    /// Refuses a header without a column that the scene names.
    fn refuse_absent(&mut self, ours: &str, theirs: &str) {
        let near = closest(theirs, self.layout.unread.iter().map(String::as_str));
        let hint = near.map_or(String::new(), |near| format!("; the nearest is {}", quoted(near)));
        let expected = format!("missing column, which by the scene is `{ours}`{hint}");
        self.refuse(theirs, expected);
        self.misnamed.extend(RunColumn::named(ours).map(|(column, _)| column));
    }

    fn lacks(&self, column: RunColumn) -> bool {
        !self.layout.gives(column) && !self.misnamed.contains(&column)
    }

    fn lacks_all(&self, columns: &[RunColumn]) -> bool {
        columns.iter().all(|column| self.lacks(*column))
    }

    /// Refuses a header without the columns that every table needs.
    fn require_columns(&mut self) {
        use RunColumn::{Diameter, Film, FilmRatio, Liquid, Particle, RestitutionSdOfRuns, RestitutionSe, Runs};
        let has_films = !self.lacks(Film) || !self.lacks(FilmRatio);
        let has_means = !self.lacks_all(&[RestitutionSdOfRuns, RestitutionSe]);
        let speeds = " (or `drop_height_mm`, or `stokes`)";
        let rebounds = " (or `rebound_speed_m_s`, or `rebound_height_mm`)";
        // columns of which one must be there, the usual one first
        for (one_of, also, is_needed) in [
            (&[Particle][..], "", true),
            (&[Diameter], "", true),
            (&IMPACTS, speeds, true),
            (&REBOUNDS, rebounds, true),
            (&[Liquid], " (runs with a film need it)", has_films),
            (&[Runs], " (how many runs each row is the mean of)", has_means),
        ] {
            if is_needed && self.lacks_all(one_of) {
                let problem = self.layout.missing_column(one_of[0], also);
                self.problems.push(problem);
            }
        }
    }
}

/// What is expected of a column for which another unit is stated than the one that the scene reads it in.
fn another_unit((column, unit): (RunColumn, &Unit), stated: StatedUnit, by: &str) -> Option<String> {
    let is_own = matches!(&stated, StatedUnit::Ours(suffix) if *suffix == unit.suffix);
    if is_own || !column.is_number() {
        return None;
    }
    let base = column.base();
    Some(match stated {
        StatedUnit::Ours(suffix) if column.dimension().unit(suffix).is_some() => format!(
            "by {by} it has another unit than `{base}{}`; expected it as `{base}{suffix}` in the scene's columns",
            unit.suffix
        ),
        StatedUnit::Ours(suffix) => {
            let written = suffix.trim_start_matches('_').replace("m_s", "m/s").replace("um", "µm");
            format!("by {by} it is in {written}, which `{base}` cannot be")
        }
        StatedUnit::Other(written) => format!(
            "by {by} it is in {}; expected {}: convert its numbers",
            quoted(&written),
            names_in_words(base, column.dimension())
        ),
    })
}

/// The unit that the table's name of a column states; one of our own names states it by its end.
fn stated_by_name(name: &str, column: RunColumn) -> Option<StatedUnit> {
    let ours = RunColumn::named(name).filter(|(own, unit)| *own == column && !unit.suffix.is_empty());
    match ours {
        Some((_, unit)) => Some(StatedUnit::Ours(unit.suffix)),
        None => unit_in_name(name, column.dimension()),
    }
}

/// Whether a unit is one that a column is written in.
fn is_unit_of(stated: &StatedUnit, column: RunColumn) -> bool {
    matches!(stated, StatedUnit::Ours(suffix) if !suffix.is_empty() && column.dimension().unit(suffix).is_some())
}

/// A column without a name, as a message shows it.
pub(super) fn unnamed_column(index: usize) -> String {
    format!("no. {} (without a name)", index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::tests::examples;

    /// Cells of a line, with `|` between.
    fn cells(line: &str) -> Vec<String> {
        line.split('|').map(str::to_owned).collect()
    }

    fn below(above: &str, names: &str) -> TableHeader {
        TableHeader::below(&cells(above), cells(names))
    }

    /// What is expected otherwise of columns of a header that a scene reads so: each the key of its numbers and its name.
    fn refused(header: &TableHeader, columns: &[[&str; 2]]) -> Vec<String> {
        let naming = Naming {
            columns: columns.iter().map(|own| own.map(str::to_owned).into()).collect(),
            ..Naming::default()
        };
        let problems = TableLayout::new(header, &naming).err().unwrap_or_default();
        let is_of = |problem: &Problem, name: &str| problem.place == format!("column {name}");
        let is_own = |problem: &Problem| columns.iter().any(|[_, name]| is_of(problem, name));
        let own = problems.into_iter().filter(is_own).map(|problem| problem.expected);
        own.filter(|expected| !expected.starts_with("missing")).collect()
    }

    #[test]
    fn names_that_stand_twice_are_told_apart_by_their_group() {
        for (above, names, told_apart) in [
            (
                "|Impact||Rebound|",
                "ball|Speed|angle|Speed|e",
                "ball|Impact Speed|angle|Rebound Speed|e",
            ),
            ("|Reference|", "e|e|v", "e|Reference e|v"),
            ("No.|ball|Speed||bad", "||in|out", "No.|ball|Speed in|Speed out|bad"),
            // nothing tells these apart
            ("Diameter|4.762|mm", "ball|v|v", "ball|v|v"),
            ("|[m/s]|[m/s]", "ball|v|v", "ball|v|v"),
            ("Drops||", "ball|v|v", "ball|v|v"),
        ] {
            assert_eq!(below(above, names).names, cells(told_apart), "{above}");
        }
    }

    #[test]
    fn what_stands_above_a_name_says_unit_and_point_of_its_column() {
        const DROPS: &str = "ball|drop|rebound";
        const CENTRE: &str = "by the title above its name its heights are of the sphere's centre";
        let holds = |header: TableHeader, columns: &[[&str; 2]], expected: &str| {
            let found = refused(&header, columns).join("; ");
            let is_right = match expected {
                "" => found.is_empty(),
                _ => found.contains(expected),
            };
            assert!(is_right, "{header:?}: {found}");
        };
        for (title, names, expected) in [
            ("|Height of centre (mm)|", DROPS, "heights_of"),
            // what reaches over the next column, and units without brackets
            ("|Heights of centre in cm|", "ball|rebound|drop", CENTRE),
            ("|Heights of centre in cm|", "ball|rebound|drop", "drop_height_cm"),
            ("|v (m/s)|", "ball|v|drop", ""),
            ("|RH (%)|", "ball|v|drop", ""),
            ("|D (cm)|", "ball|v|drop", ""),
            // the title of the table
            ("Drops (cm)|", "drop|rebound", ""),
        ] {
            holds(below(title, names), &[["drop_height_mm", "drop"]], expected);
        }
        let own = below("|Height [cm]|", "ball|drop (mm)|e");
        holds(own, &[["drop_height_mm", "drop (mm)"]], "");
        // a name that has its unit needs none of the table
        let film = |name: &str| TableHeader::of(&[cells("Units: mm")], cells(&format!("ball|{name}|e")));
        for name in ["film µm mean", "δ µm (dry)", "film_um [wet]"] {
            holds(film(name), &[["film_um", name]], "");
        }
        holds(film("film"), &[["film_um", "film"]], "by a line above the names");
        // lines about the whole table
        for (line, expected) in [
            ("drop: height in inches", "by a line above the names it is in"),
            ("drop = 10 to 40 cm", ""),
            ("drop: drop height (mm)", ""),
            ("drops: in inches", ""),
            ("All heights are of the sphere's centre", "heights_of"),
            ("Centre for Granular Physics", ""),
        ] {
            let above = [cells(&format!("{line}||")), cells("May||")];
            let header = TableHeader::of(&above, cells(DROPS));
            holds(header, &[["drop_height_mm", "drop"]], expected);
        }
        for (line, expected) in [
            (
                "only radii were measured; column D = radius",
                "by a line above the names it is a radius",
            ),
            ("v: speeds in ft/s", "by a line above the names it is in"),
            ("D = 4.762 mm", ""),
            ("v: impact speed (m/s)", ""),
            ("D = diameter of the sphere", ""),
            ("v0: in ft/s", ""),
        ] {
            let header = TableHeader::of(&[cells(line)], cells("D (mm)|v|particle|restitution"));
            holds(
                header,
                &[["diameter_mm", "D (mm)"], ["impact_speed_m_s", "v"]],
                expected,
            );
        }
    }

    #[test]
    fn headers_are_read_as_they_say_or_refused() {
        let mut wrong = vec![];
        for (question, expected) in [("read", 0), ("refused", 1)] {
            let mut count = 0;
            for (key, names) in examples(question) {
                count += names.len();
                for name in names {
                    let own = refused(&TableHeader::below(&[], cells(name)), &[[key, name]]);
                    if own.len() != expected {
                        wrong.push(format!("{question} {key} `{name}`: {own:?}"));
                    }
                }
            }
            assert!(count >= 60, "{count}");
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
