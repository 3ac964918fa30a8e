//! Matches the header of a table with the columns runs can have.

use crate::error::Problem;
use crate::scene::closest;
use crate::units::{Dimension, Unit};

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
            Column::Diameter | Column::Film => Dimension::Length,
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
        // film thickness is usually given in µm, unlike every other length
        match self {
            Column::Film => "film_um".to_owned(),
            _ => format!("{}{}", self.base(), self.dimension().units()[0].suffix),
        }
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
    /// columns that are not used, by name
    pub unknown: Vec<String>,
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
        let mut unknown: Vec<String> = vec![];
        let mut problems = vec![];
        let mut refuse = |place: String, expected: String| {
            problems.push(Problem {
                line,
                place,
                found: None,
                expected,
            });
        };
        let names: Vec<String> = known_names().map(|(name, _, _)| name).collect();
        for (index, name) in header.iter().enumerate() {
            let Some((_, column, unit)) = known_names().find(|(known, _, _)| known == name) else {
                match close_enough(name, &names) {
                    Some(near) => refuse(
                        format!("column {name}"),
                        format!("unknown column; did you mean `{near}`?"),
                    ),
                    None => unknown.push(name.clone()),
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
        let missing = |column: Column| places[column as usize].is_none();
        let mut want = |column: Column, also: &str| {
            let name = column.usual_name();
            let near = closest(&name, unknown.iter().map(String::as_str));
            let hint = near.map_or(String::new(), |near| format!("; the nearest is `{near}`"));
            refuse(format!("column {name}"), format!("missing column{also}{hint}"));
        };
        for column in [Column::Particle, Column::Diameter, Column::ImpactSpeed] {
            if missing(column) {
                want(column, "");
            }
        }
        if missing(Column::ReboundSpeed) && missing(Column::Restitution) {
            want(Column::Restitution, " (or `rebound_speed_m_s`)");
        }
        if !missing(Column::Liquid) && missing(Column::Film) {
            want(Column::Film, " (wet runs need it)");
        }
        if missing(Column::Liquid) && !missing(Column::Film) {
            want(Column::Liquid, " (runs with a film need it)");
        }
        if problems.is_empty() {
            let width = header.len();
            Ok(Plan { places, unknown, width })
        } else {
            Err(problems)
        }
    }

    pub fn place(&self, column: Column) -> Option<&Place> {
        self.places[column as usize].as_ref()
    }

    /// The name a column has in this table.
    pub fn name(&self, column: Column) -> String {
        self.place(column)
            .map_or_else(|| column.usual_name(), |place| place.name.clone())
    }
}

/// A known column within two letters of a name.
fn close_enough<'a>(name: &str, known: &'a [String]) -> Option<&'a str> {
    let distance = |known: &str| strsim::damerau_levenshtein(name, known);
    let near = known.iter().map(|known| (distance(known), known.as_str())).min()?;
    (near.0 <= 2).then_some(near.1)
}
