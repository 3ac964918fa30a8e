//! Matches the header of a table with the columns runs can have.

use crate::error::{quoted, Problem};
use crate::scene::{closest, letters_apart};
use crate::units::{names_in_words, Dimension, Unit};

/// A column runs can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Column {
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
    Run,
}

impl Column {
    pub const ALL: [Column; 12] = [
        Column::Particle,
        Column::Liquid,
        Column::Diameter,
        Column::Film,
        Column::ImpactSpeed,
        Column::ReboundSpeed,
        Column::Restitution,
        Column::FilmRatio,
        Column::ImpactSpeedSd,
        Column::ReboundSpeedSd,
        Column::RestitutionSd,
        Column::Run,
    ];
    /// The columns that hold numbers.
    pub const NUMBERS: [Column; 9] = [
        Column::Diameter,
        Column::Film,
        Column::ImpactSpeed,
        Column::ReboundSpeed,
        Column::Restitution,
        Column::FilmRatio,
        Column::ImpactSpeedSd,
        Column::ReboundSpeedSd,
        Column::RestitutionSd,
    ];

    fn base(self) -> &'static str {
        match self {
            Column::Particle => "particle",
            Column::Liquid => "liquid",
            Column::Diameter => "diameter",
            Column::Film => "film",
            Column::ImpactSpeed => "impact_speed",
            Column::ReboundSpeed => "rebound_speed",
            Column::Restitution => "restitution",
            Column::FilmRatio => "film_ratio",
            Column::ImpactSpeedSd => "impact_speed_sd",
            Column::ReboundSpeedSd => "rebound_speed_sd",
            Column::RestitutionSd => "restitution_sd",
            Column::Run => "run",
        }
    }

    fn dimension(self) -> Dimension {
        match self {
            Column::Diameter => Dimension::Length,
            Column::Film => Dimension::Thickness,
            Column::ImpactSpeed | Column::ReboundSpeed | Column::ImpactSpeedSd | Column::ReboundSpeedSd => {
                Dimension::Speed
            }
            Column::Particle
            | Column::Liquid
            | Column::Restitution
            | Column::FilmRatio
            | Column::RestitutionSd
            | Column::Run => Dimension::One,
        }
    }

    /// The column's name in the usual unit, to ask for it.
    fn usual_name(self) -> String {
        format!("{}{}", self.base(), self.dimension().units()[0].suffix)
    }
}

fn known_names() -> impl Iterator<Item = (String, Column, &'static Unit)> {
    Column::ALL.into_iter().flat_map(|column| {
        let units = column.dimension().units().iter();
        units.map(move |unit| (format!("{}{}", column.base(), unit.suffix), column, unit))
    })
}

/// Where each column stands in the table, and in which unit.
#[derive(Debug)]
pub(super) struct Plan {
    places: [Option<Place>; Column::ALL.len()],
    /// columns that are not used, as a message shows them
    pub unknown: Vec<String>,
    /// what to say of a missing column of films, which only wet runs need
    missing_film: Problem,
    /// how many columns the table has
    pub width: usize,
}

/// A column's place in the table.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub index: usize,
    pub name: String,
    unit: &'static Unit,
}

impl Place {
    pub fn to_si(&self, value: f64) -> f64 {
        self.unit.to_si(value)
    }
}

impl Plan {
    /// Matches a header; `line` is where it stands in the file.
    pub fn new(header: &[String], line: Option<u64>) -> Result<Plan, Vec<Problem>> {
        let mut places: [Option<Place>; Column::ALL.len()] = Default::default();
        let mut unread: Vec<&str> = vec![];
        let mut unknown: Vec<String> = vec![];
        // columns that stand there under a name nobody can read
        let mut meant: Vec<Column> = vec![];
        let mut problems = vec![];
        let mut refuse = |place: String, expected: String| {
            problems.push(Problem {
                line,
                place,
                found: None,
                expected,
            });
        };
        for (index, name) in header.iter().enumerate() {
            let Some((_, column, unit)) = known_names().find(|(known, _, _)| known == name) else {
                if let Some(column) = Column::ALL.into_iter().find(|column| column.base() == name) {
                    let names = names_in_words(name, column.dimension());
                    refuse(
                        format!("column {name}"),
                        format!("a unit is part of the name; expected {names}"),
                    );
                    meant.push(column);
                } else if let Some((near, column)) = close_enough(name) {
                    refuse(
                        format!("column {name}"),
                        format!("unknown column; did you mean `{near}`?"),
                    );
                    meant.push(column);
                } else if name.is_empty() {
                    unknown.push(format!("no. {} (without a name)", index + 1));
                } else {
                    unread.push(name);
                    unknown.push(quoted(name));
                }
                continue;
            };
            match &places[column as usize] {
                Some(first) if first.name == *name => {
                    refuse(format!("column {name}"), "the column is there twice".to_owned());
                }
                Some(first) => refuse(
                    format!("column {name}"),
                    format!(
                        "`{}` is already given as `{}`; expected one unit for one quantity",
                        column.base(),
                        first.name
                    ),
                ),
                None => {
                    places[column as usize] = Some(Place {
                        index,
                        name: name.clone(),
                        unit,
                    });
                }
            }
        }
        if meant.is_empty() && places.iter().all(Option::is_none) {
            return Err(vec![Problem {
                line,
                place: "header".to_owned(),
                found: Some(quoted(&header.join(","))),
                expected:
                    "expected the names of columns, among them particle, diameter_mm, impact_speed_m_s and restitution"
                        .to_owned(),
            }]);
        }
        let missing = |column: Column| places[column as usize].is_none() && !meant.contains(&column);
        let unread_in_words: Vec<String> = unread.iter().map(|name| quoted(name)).collect();
        let lacks = |column: Column, also: &str| {
            let name = column.usual_name();
            let hint = match closest(&name, unread.iter().copied()) {
                Some(near) => format!("; the nearest is {}", quoted(near)),
                None if unread.is_empty() => String::new(),
                None => format!("; columns not known: {}", unread_in_words.join(", ")),
            };
            (format!("column {name}"), format!("missing column{also}{hint}"))
        };
        let mut want = |column: Column, also: &str| {
            let (place, expected) = lacks(column, also);
            refuse(place, expected);
        };
        for column in [Column::Particle, Column::Diameter, Column::ImpactSpeed] {
            if missing(column) {
                want(column, "");
            }
        }
        if missing(Column::ReboundSpeed) && missing(Column::Restitution) {
            want(Column::Restitution, " (or `rebound_speed_m_s`)");
        }
        if missing(Column::Liquid) && !missing(Column::Film) {
            want(Column::Liquid, " (runs with a film need it)");
        }
        if problems.is_empty() {
            let (place, expected) = lacks(Column::Film, " (wet runs need it)");
            Ok(Plan {
                places,
                unknown,
                missing_film: Problem {
                    line,
                    place,
                    found: None,
                    expected,
                },
                width: header.len(),
            })
        } else {
            Err(problems)
        }
    }

    pub fn place(&self, column: Column) -> Option<&Place> {
        self.places[column as usize].as_ref()
    }

    /// The column to name where a value is missing that either of two columns could give.
    pub fn blamed(&self, column: Column) -> Column {
        match column {
            Column::Restitution if self.place(column).is_none() => Column::ReboundSpeed,
            _ => column,
        }
    }

    /// What to say to a wet run in a table without films.
    pub fn missing_film(&self) -> Problem {
        self.missing_film.clone()
    }

    /// The name a column has in this table.
    pub fn name(&self, column: Column) -> String {
        self.place(column)
            .map_or_else(|| column.usual_name(), |place| place.name.clone())
    }
}

/// A known column within two letters of a name.
fn close_enough(name: &str) -> Option<(String, Column)> {
    known_names()
        .filter_map(|(known, column, _)| Some((letters_apart(name, &known, 2)?, known, column)))
        .min()
        .map(|(_, known, column)| (known, column))
}
