//! Matches the header of a table with the columns runs can have.

use crate::error::{quoted, Problem};
use crate::scene::{closest, letters_apart};
use crate::units::{names_in_words, Dimension, Unit};

/// A column runs can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum RunColumn {
    Particle,
    Liquid,
    Diameter,
    Film,
    ImpactSpeed,
    ReboundSpeed,
    Restitution,
    FilmRatio,
    ImpactSpeedSd,
    ReboundSpeedSd,
    RestitutionSd,
    SpeedCorrelation,
    Run,
}

impl RunColumn {
    pub const ALL: [RunColumn; 13] = [
        RunColumn::Particle,
        RunColumn::Liquid,
        RunColumn::Diameter,
        RunColumn::Film,
        RunColumn::ImpactSpeed,
        RunColumn::ReboundSpeed,
        RunColumn::Restitution,
        RunColumn::FilmRatio,
        RunColumn::ImpactSpeedSd,
        RunColumn::ReboundSpeedSd,
        RunColumn::RestitutionSd,
        RunColumn::SpeedCorrelation,
        RunColumn::Run,
    ];
    /// The columns that hold numbers.
    pub const NUMBERS: [RunColumn; 10] = [
        RunColumn::Diameter,
        RunColumn::Film,
        RunColumn::ImpactSpeed,
        RunColumn::ReboundSpeed,
        RunColumn::Restitution,
        RunColumn::FilmRatio,
        RunColumn::ImpactSpeedSd,
        RunColumn::ReboundSpeedSd,
        RunColumn::RestitutionSd,
        RunColumn::SpeedCorrelation,
    ];

    fn base(self) -> &'static str {
        match self {
            RunColumn::Particle => "particle",
            RunColumn::Liquid => "liquid",
            RunColumn::Diameter => "diameter",
            RunColumn::Film => "film",
            RunColumn::ImpactSpeed => "impact_speed",
            RunColumn::ReboundSpeed => "rebound_speed",
            RunColumn::Restitution => "restitution",
            RunColumn::FilmRatio => "film_ratio",
            RunColumn::ImpactSpeedSd => "impact_speed_sd",
            RunColumn::ReboundSpeedSd => "rebound_speed_sd",
            RunColumn::RestitutionSd => "restitution_sd",
            RunColumn::SpeedCorrelation => "speed_correlation",
            RunColumn::Run => "run",
        }
    }

    fn dimension(self) -> Dimension {
        match self {
            RunColumn::Diameter => Dimension::Length,
            RunColumn::Film => Dimension::Thickness,
            RunColumn::ImpactSpeed | RunColumn::ReboundSpeed | RunColumn::ImpactSpeedSd | RunColumn::ReboundSpeedSd => {
                Dimension::Speed
            }
            RunColumn::Particle
            | RunColumn::Liquid
            | RunColumn::Restitution
            | RunColumn::FilmRatio
            | RunColumn::RestitutionSd
            | RunColumn::SpeedCorrelation
            | RunColumn::Run => Dimension::One,
        }
    }

    /// The column's name in the usual unit, to ask for it.
    fn usual_name(self) -> String {
        format!("{}{}", self.base(), self.dimension().units()[0].suffix)
    }
}

fn column_names() -> impl Iterator<Item = (String, RunColumn, &'static Unit)> {
    RunColumn::ALL.into_iter().flat_map(|column| {
        let units = column.dimension().units().iter();
        units.map(move |unit| (format!("{}{}", column.base(), unit.suffix), column, unit))
    })
}

/// Where each column stands in the table, and in which unit.
#[derive(Debug)]
pub(super) struct TableLayout {
    places: [Option<ColumnPlace>; RunColumn::ALL.len()],
    /// columns that are not used, as a message shows them
    pub unknown: Vec<String>,
    /// what to say of a missing column of films, which only wet runs need
    missing_film: Problem,
    /// how many columns the table has
    pub width: usize,
}

/// A column's place in the table.
#[derive(Debug, Clone)]
pub(super) struct ColumnPlace {
    pub index: usize,
    pub name: String,
    unit: &'static Unit,
}

impl ColumnPlace {
    pub fn to_si(&self, value: f64) -> f64 {
        self.unit.to_si(value)
    }
}

impl TableLayout {
    /// Matches a header; `line` is where it stands in the file.
    pub fn new(header: &[String], line: Option<u64>) -> Result<TableLayout, Vec<Problem>> {
        let mut matched = MatchedHeader::of(header, line);
        if matched.has_no_column() {
            return Err(vec![Problem {
                line,
                place: "header".to_owned(),
                found: Some(quoted(&header.join(","))),
                expected:
                    "expected the names of columns, among them particle, diameter_mm, impact_speed_m_s and restitution"
                        .to_owned(),
            }]);
        }
        matched.require_columns();
        if matched.problems.is_empty() {
            Ok(TableLayout {
                missing_film: matched.missing_column(RunColumn::Film, " (wet runs need it)"),
                places: matched.places,
                unknown: matched.unknown,
                width: header.len(),
            })
        } else {
            Err(matched.problems)
        }
    }

    pub fn place(&self, column: RunColumn) -> Option<&ColumnPlace> {
        self.places[column as usize].as_ref()
    }

    /// The column to name where a value is missing that either of two columns could give.
    pub fn blamed(&self, column: RunColumn) -> RunColumn {
        match column {
            RunColumn::Restitution if self.place(column).is_none() => RunColumn::ReboundSpeed,
            _ => column,
        }
    }

    /// What to say to a wet run in a table without films.
    pub fn missing_film(&self) -> Problem {
        self.missing_film.clone()
    }

    /// The name a column has in this table.
    pub fn name(&self, column: RunColumn) -> String {
        self.place(column)
            .map_or_else(|| column.usual_name(), |place| place.name.clone())
    }
}

/// A column whose name is within two letters of a name.
fn close_enough(name: &str) -> Option<(String, RunColumn)> {
    column_names()
        .filter_map(|(candidate, column, _)| Some((letters_apart(name, &candidate, 2)?, candidate, column)))
        .min()
        .map(|(_, candidate, column)| (candidate, column))
}

/// The names of a header, each with the column it stands for, and what is wrong with the others.
struct MatchedHeader<'h> {
    /// where the header stands in the file
    line: Option<u64>,
    places: [Option<ColumnPlace>; RunColumn::ALL.len()],
    /// names that are no column's
    unread: Vec<&'h str>,
    /// columns that are not used, as a message shows them
    unknown: Vec<String>,
    /// columns whose name is misspelt or lacks its unit
    misnamed: Vec<RunColumn>,
    problems: Vec<Problem>,
}

impl<'h> MatchedHeader<'h> {
    fn of(header: &'h [String], line: Option<u64>) -> MatchedHeader<'h> {
        let mut matched = MatchedHeader {
            line,
            places: Default::default(),
            unread: vec![],
            unknown: vec![],
            misnamed: vec![],
            problems: vec![],
        };
        for (index, name) in header.iter().enumerate() {
            match column_names().find(|(candidate, _, _)| candidate == name) {
                Some((_, column, unit)) => {
                    let name = name.clone();
                    matched.add_column(column, ColumnPlace { index, name, unit });
                }
                None => matched.add_other_name(index, name),
            }
        }
        matched
    }

    fn has_no_column(&self) -> bool {
        self.misnamed.is_empty() && self.places.iter().all(Option::is_none)
    }

    fn refuse(&mut self, place: String, expected: String) {
        self.problems.push(Problem {
            line: self.line,
            place,
            found: None,
            expected,
        });
    }

    /// Puts a column in its place, once and in one unit.
    fn add_column(&mut self, column: RunColumn, place: ColumnPlace) {
        let name = &place.name;
        match &self.places[column as usize] {
            Some(first) if first.name == *name => {
                self.refuse(format!("column {name}"), "the column is there twice".to_owned());
            }
            Some(first) => {
                let expected = format!(
                    "`{}` is already given as `{}`; expected one unit for one quantity",
                    column.base(),
                    first.name
                );
                self.refuse(format!("column {name}"), expected);
            }
            None => self.places[column as usize] = Some(place),
        }
    }

    /// Refuses a name that is nearly a column's; any other column is not used.
    fn add_other_name(&mut self, index: usize, name: &'h str) {
        if let Some(column) = RunColumn::ALL.into_iter().find(|column| column.base() == name) {
            let names = names_in_words(name, column.dimension());
            self.refuse(
                format!("column {name}"),
                format!("a unit is part of the name; expected {names}"),
            );
            self.misnamed.push(column);
        } else if let Some((near, column)) = close_enough(name) {
            self.refuse(
                format!("column {name}"),
                format!("unknown column; did you mean `{near}`?"),
            );
            self.misnamed.push(column);
        } else if name.is_empty() {
            self.unknown.push(format!("no. {} (without a name)", index + 1));
        } else {
            self.unread.push(name);
            self.unknown.push(quoted(name));
        }
    }

    fn lacks(&self, column: RunColumn) -> bool {
        self.places[column as usize].is_none() && !self.misnamed.contains(&column)
    }

    /// Says that a column is missing, and which name in the header is nearest.
    fn missing_column(&self, column: RunColumn, also: &str) -> Problem {
        let name = column.usual_name();
        let hint = match closest(&name, self.unread.iter().copied()) {
            Some(near) => format!("; the nearest is {}", quoted(near)),
            None if self.unread.is_empty() => String::new(),
            None => {
                let unread: Vec<String> = self.unread.iter().map(|name| quoted(name)).collect();
                format!("; columns not known: {}", unread.join(", "))
            }
        };
        Problem {
            line: self.line,
            place: format!("column {name}"),
            found: None,
            expected: format!("missing column{also}{hint}"),
        }
    }

    /// Refuses a header without the columns that every table needs.
    fn require_columns(&mut self) {
        let mut required = vec![];
        for column in [RunColumn::Particle, RunColumn::Diameter, RunColumn::ImpactSpeed] {
            if self.lacks(column) {
                required.push((column, ""));
            }
        }
        if self.lacks(RunColumn::ReboundSpeed) && self.lacks(RunColumn::Restitution) {
            required.push((RunColumn::Restitution, " (or `rebound_speed_m_s`)"));
        }
        if self.lacks(RunColumn::Liquid) && !self.lacks(RunColumn::Film) {
            required.push((RunColumn::Liquid, " (runs with a film need it)"));
        }
        for (column, also) in required {
            let problem = self.missing_column(column, also);
            self.problems.push(problem);
        }
    }
}
