//! Reads what a table of runs calls its columns and its words, and what it leaves unsaid.

use super::expect::{ABOVE_ZERO, FINITE};
use super::names::{already_given, closest, name_expected, DRY, FILL_IN, MISSING};
use super::run_columns::RunColumn;
use super::table::values::{count, one_of};
use super::table::SceneTable;
use super::table_file::TableFile;

/// What a table of runs calls its columns and its words, and what it leaves unsaid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Naming {
    /// our name of a column, unit included, and theirs
    pub columns: Vec<(String, String)>,
    /// a column with words of its cells, each theirs and ours
    pub words: Vec<(RunColumn, Vec<[String; 2]>)>,
    /// columns that are the same in every row
    pub constants: Vec<Constant>,
    /// columns that are the same in every row of a sheet, with the name of that sheet
    pub sheets: Vec<(String, Vec<Constant>)>,
    /// row or line that names the columns, from 1; absent: the first that is not blank
    pub header_row: Option<u64>,
    /// what is done with the rows that a workbook hides; absent: they are refused
    pub hidden_rows: Option<HiddenRows>,
    /// where drop and rebound heights are counted from
    pub heights_to: HeightsTo,
    /// the point of the sphere that they are heights of
    pub heights_of: HeightsOf,
    /// whether the scene says so
    pub heights_of_is_told: bool,
}

impl Naming {
    /// The columns that are the same in every row of a table, which may be a sheet of a workbook.
    pub fn constants_of(&self, sheet: Option<&str>) -> Vec<&Constant> {
        let of_sheet = self.sheets.iter().filter(|(name, _)| Some(name.as_str()) == sheet);
        let of_sheet = of_sheet.flat_map(|(_, constants)| constants);
        self.constants.iter().chain(of_sheet).collect()
    }
}

/// A column that is the same in every row.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// which
    pub column: RunColumn,
    /// its name in the scene, unit included
    pub name: String,
    /// what every row has there
    pub value: ConstantValue,
}

/// What every row has in a column.
#[derive(Debug, Clone, PartialEq)]
pub enum ConstantValue {
    /// in SI
    Number(f64),
    /// a word
    Word(String),
}

/// Where drop and rebound heights are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HeightsTo {
    /// the plate: the sphere meets the film before it has fallen the whole height
    #[default]
    Plate,
    /// the surface of the film
    Film,
}

/// The point of a sphere that its heights are heights of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HeightsOf {
    /// the lowest point, which meets the film
    #[default]
    Lowest,
    /// the centre, half a diameter above it
    Centre,
}

/// What is done with the rows that a workbook hides, by a filter or by hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HiddenRows {
    /// read like all others
    Take,
    /// left out
    Leave,
}

/// The names that a scene gives its particles and liquids.
#[derive(Default)]
pub(super) struct SceneNames {
    pub particles: Vec<String>,
    pub liquids: Vec<String>,
}

/// Reads the naming from the table of the data.
pub(super) fn naming(data: &SceneTable, names: &SceneNames, runs: &[TableFile]) -> Naming {
    let columns = columns(data);
    let words = words(data, names);
    let everywhere = data.inner_table("constants", "a table of columns with a value each");
    let constants = everywhere.map_or_else(Vec::new, |table| constants(&table, names, &[]));
    let hidden_rows = one_of([("take", HiddenRows::Take), ("leave", HiddenRows::Leave)]);
    let heights_to = one_of([("plate", HeightsTo::Plate), ("film", HeightsTo::Film)]);
    let heights_of = one_of([("lowest", HeightsOf::Lowest), ("centre", HeightsOf::Centre)]);
    Naming {
        columns,
        words,
        sheets: sheets(data, names, &constants, runs),
        constants,
        header_row: data.read("header_row", count(1, 1 << 20)),
        hidden_rows: data.read("hidden_rows", hidden_rows),
        heights_to: data.read_or("heights_to", heights_to, HeightsTo::default()),
        heights_of: data.read_or("heights_of", heights_of, HeightsOf::default()),
        heights_of_is_told: data.has("heights_of"),
    }
}

fn sheets(
    data: &SceneTable,
    names: &SceneNames,
    everywhere: &[Constant],
    runs: &[TableFile],
) -> Vec<(String, Vec<Constant>)> {
    // the name of a sheet that is not named is not known yet
    let all_are_named = runs.iter().all(|file| file.sheet.is_some());
    let named = || runs.iter().filter_map(|file| file.sheet.as_deref());
    let takes = "for each sheet a table of columns with a value each";
    data.inner_each("sheets", takes, |table, sheet, _| {
        if all_are_named && !named().any(|name| name == sheet) {
            table.refuse_key(&sheet, name_expected("a sheet that `runs` names", &sheet, named()));
        }
        let own = constants(&table.table(&sheet)?, names, everywhere);
        Some((sheet, own))
    })
}

fn columns(data: &SceneTable) -> Vec<(String, String)> {
    let takes = "a table of our names and theirs";
    data.inner_each("columns", takes, |table, ours, before: &[(String, String)]| {
        if RunColumn::named(&ours).is_none() {
            refuse_column(table, &ours);
            return None;
        }
        // blanks around it are no part of a name in a table either
        let theirs = table.text(&ours)?.trim().to_owned();
        if theirs == FILL_IN {
            let expected =
                "the name that the table gives this column (one that is the same in every row goes into `constants`)";
            table.refuse_given(&ours, expected);
        } else if before.iter().any(|(_, other)| *other == theirs) {
            table.refuse_given(&ours, "a column that stands for no other");
        }
        Some((ours, theirs))
    })
}

fn words(data: &SceneTable, names: &SceneNames) -> Vec<(RunColumn, Vec<[String; 2]>)> {
    let takes = "for each column a table of their words and ours";
    data.inner_each("values", takes, |table, name, _| {
        let named = RunColumn::named(&name).map(|(column, _)| column);
        let Some(column) = named.or_else(|| RunColumn::of_base(&name)) else {
            refuse_column(table, &name);
            return None;
        };
        let of_column = table.table(&name)?;
        let pairs = of_column.each(|theirs, _| {
            let ours = of_column.text(&theirs)?;
            check_word(&of_column, &theirs, column, &ours, names);
            Some([theirs, ours])
        });
        Some((column, pairs))
    })
}

/// The columns in a table that are the same in every row, none of them among those that are so in every sheet.
fn constants(table: &SceneTable, names: &SceneNames, everywhere: &[Constant]) -> Vec<Constant> {
    table.each(|name, before: &[Constant]| {
        let Some((column, unit)) = RunColumn::named(&name) else {
            refuse_column(table, &name);
            return None;
        };
        let value = if column.is_number() {
            let expect = match column {
                RunColumn::Diameter
                | RunColumn::Film
                | RunColumn::ImpactSpeed
                | RunColumn::DropHeight
                | RunColumn::Stokes => ABOVE_ZERO,
                _ => FINITE,
            };
            let value = table.number(&name, expect);
            value.map(|value| ConstantValue::Number(unit.to_si(value)))
        } else {
            let word = table.text(&name);
            if let Some(word) = &word {
                check_word(table, &name, column, word, names);
            }
            word.map(ConstantValue::Word)
        };
        if let Some(other) = before.iter().chain(everywhere).find(|other| other.column == column) {
            table.refuse_key(&name, already_given(column.base(), &other.name));
        }
        let value = value?;
        Some(Constant { column, name, value })
    })
}

/// Refuses a name that is no column's.
fn refuse_column(table: &SceneTable, name: &str) {
    let expected = match RunColumn::nearly(name) {
        Some((_, expected)) => expected,
        None => "expected the name of a column that runs can have, as diameter_mm".to_owned(),
    };
    table.refuse_key(name, expected);
}

/// Refuses a word that no cell of a column may hold.
fn check_word(table: &SceneTable, key: &str, column: RunColumn, word: &str, names: &SceneNames) {
    if word == MISSING {
        return;
    }
    let (what, of_scene, besides) = match column {
        RunColumn::Particle => ("a name in [particles]", &names.particles, None),
        RunColumn::Liquid => ("a name in [liquids] or \"dry\"", &names.liquids, Some(DRY)),
        _ if column.is_number() && word.parse::<f64>().is_err() => {
            return table.refuse_given(key, "a number in quotes, with a decimal point, or \"NA\"");
        }
        _ => return,
    };
    let known = || of_scene.iter().map(String::as_str).chain(besides);
    if !known().any(|name| name == word) {
        let near = closest(word, known()).map(|near| format!("{what}; did you mean `{near}`?"));
        table.refuse_given(key, near.as_deref().unwrap_or(what));
    }
}
