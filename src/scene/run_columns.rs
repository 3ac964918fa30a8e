//! Holds the columns that a table of runs can have.

use super::keys::{KeyGuide, Without};
use super::names::letters_apart;
use crate::units::{names_in_words, Dimension, Unit};

/// A column runs can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RunColumn {
    /// name of the particle
    Particle,
    /// name of the liquid
    Liquid,
    /// of the sphere
    Diameter,
    /// thickness of the film
    Film,
    /// as measured
    ImpactSpeed,
    /// as measured
    ReboundSpeed,
    /// rebound speed over impact speed
    Restitution,
    /// that the run belongs to
    FilmRatio,
    /// standard deviation of the measurement
    ImpactSpeedSd,
    /// standard deviation of the measurement
    ReboundSpeedSd,
    /// standard deviation of the measurement
    RestitutionSd,
    /// of the errors of both speeds
    SpeedCorrelation,
    /// height of the sphere's lowest point when it is let go
    DropHeight,
    /// the same where it turns after the rebound
    ReboundHeight,
    /// Stokes number of the impact
    Stokes,
    /// how many runs the row is the mean of
    Runs,
    /// standard deviation of those runs about their mean
    RestitutionSdOfRuns,
    /// standard error of their mean
    RestitutionSe,
    /// why the run is left out
    Exclude,
    /// free label
    Run,
}

/// What holds without a column of errors.
const NO_ERROR: Without = Without::Words("taken as exact, but for what scatters the runs");

impl RunColumn {
    /// Every column.
    pub const ALL: [RunColumn; 20] = [
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
        RunColumn::DropHeight,
        RunColumn::ReboundHeight,
        RunColumn::Stokes,
        RunColumn::Runs,
        RunColumn::RestitutionSdOfRuns,
        RunColumn::RestitutionSe,
        RunColumn::Exclude,
        RunColumn::Run,
    ];
    /// The columns that hold numbers.
    pub fn numbers() -> impl Iterator<Item = RunColumn> {
        RunColumn::ALL.into_iter().filter(|column| column.is_number())
    }

    /// The columns that hold words.
    pub fn words() -> impl Iterator<Item = RunColumn> {
        RunColumn::ALL.into_iter().filter(|column| !column.is_number())
    }

    /// Its name without a unit.
    pub fn base(self) -> &'static str {
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
            RunColumn::DropHeight => "drop_height",
            RunColumn::ReboundHeight => "rebound_height",
            RunColumn::Stokes => "stokes",
            RunColumn::Runs => "runs",
            RunColumn::RestitutionSdOfRuns => "restitution_sd_of_runs",
            RunColumn::RestitutionSe => "restitution_se",
            RunColumn::Exclude => "exclude",
            RunColumn::Run => "run",
        }
    }

    /// What it holds.
    pub fn dimension(self) -> Dimension {
        match self {
            RunColumn::Diameter | RunColumn::DropHeight | RunColumn::ReboundHeight => Dimension::Length,
            RunColumn::Film => Dimension::Thickness,
            RunColumn::ImpactSpeed | RunColumn::ReboundSpeed | RunColumn::ImpactSpeedSd | RunColumn::ReboundSpeedSd => {
                Dimension::Speed
            }
            RunColumn::Restitution | RunColumn::FilmRatio | RunColumn::RestitutionSd => Dimension::Share,
            RunColumn::Particle
            | RunColumn::Liquid
            | RunColumn::SpeedCorrelation
            | RunColumn::Stokes
            | RunColumn::Runs
            | RunColumn::RestitutionSdOfRuns
            | RunColumn::RestitutionSe
            | RunColumn::Exclude
            | RunColumn::Run => Dimension::One,
        }
    }

    /// What is to be said of it.
    pub fn guide(self) -> KeyGuide {
        let (without, example, meaning) = match self {
            RunColumn::Particle => (
                Without::Refused,
                "PTFE",
                "name of the sphere's material, one in [particles]",
            ),
            RunColumn::Liquid => (
                Without::Words("every run is dry"),
                "AK10",
                "name of the liquid, one in [liquids]; empty or `dry` without liquid",
            ),
            RunColumn::Diameter => (Without::Refused, "4.762", "diameter of the sphere"),
            RunColumn::Film => (
                Without::Words("no run may be wet"),
                "287",
                "thickness of the film; not read of dry runs",
            ),
            RunColumn::ImpactSpeed => (
                Without::Words("drop_height or stokes gives it"),
                "1.41",
                "normal speed before the impact",
            ),
            RunColumn::ReboundSpeed => (
                Without::Words("restitution or rebound_height gives it"),
                "0.92",
                "normal speed after the impact; 0: the run stuck",
            ),
            RunColumn::Restitution => (
                Without::Words("rebound_speed or rebound_height gives it"),
                "0.652",
                "rebound over impact speed; 0: the run stuck",
            ),
            RunColumn::DropHeight => (
                Without::Words("impact_speed or stokes gives the speed"),
                "100",
                "where the sphere's lowest point falls from (its centre: heights_of), v = √(2 g h)",
            ),
            RunColumn::ReboundHeight => (
                Without::Words("rebound_speed or restitution gives the speed"),
                "43",
                "how high its lowest point rebounds; see heights_of, heights_to",
            ),
            RunColumn::Stokes => (
                Without::Words("impact_speed or drop_height gives the speed"),
                "52",
                "Stokes number St = ρp D v/(9 η) of a wet run",
            ),
            RunColumn::FilmRatio => (
                Without::Words("by film_ratios in [data], else groups are found"),
                "0.06",
                "nominal film ratio δ/D that the run belongs to",
            ),
            RunColumn::ImpactSpeedSd => (NO_ERROR, "0.004", "sd of the error of the impact speed"),
            RunColumn::ReboundSpeedSd => (NO_ERROR, "0.004", "sd of the error of the rebound speed"),
            RunColumn::RestitutionSd => (NO_ERROR, "0.01", "sd of the error of the restitution as a whole"),
            RunColumn::SpeedCorrelation => (
                Without::Words("0"),
                "0.5",
                "correlation of the errors of both speeds, from -1 to 1",
            ),
            RunColumn::Runs => (
                Without::Words("each row is one run"),
                "5",
                "how many runs at one setting the row is the mean of",
            ),
            RunColumn::RestitutionSdOfRuns => (
                Without::Words("restitution_se says how the runs of a mean scatter"),
                "0.012",
                "of a mean: sd of its single runs",
            ),
            RunColumn::RestitutionSe => (
                Without::Words("restitution_sd_of_runs says how the runs of a mean scatter"),
                "0.005",
                "of a mean: its standard error, sd/√runs",
            ),
            RunColumn::Exclude => (
                Without::Words("every run is used"),
                "touched the wall",
                "why the run is left out; counted under these words; a no among yes and no (0 and 1) keeps it",
            ),
            RunColumn::Run => (
                Without::Words("rows are counted"),
                "17",
                "a label, shown in messages about the row",
            ),
        };
        let takes = if self.is_number() { "a number" } else { "a word" };
        KeyGuide {
            base: self.base(),
            dimension: self.dimension(),
            takes: takes.to_owned(),
            without,
            meaning,
            example: example.to_owned(),
        }
    }

    /// Whether its cells are numbers.
    pub fn is_number(self) -> bool {
        use RunColumn::{Exclude, Liquid, Particle, Run};
        !matches!(self, Particle | Liquid | Exclude | Run)
    }

    /// Its name in the usual unit, to ask for it.
    pub fn usual_name(self) -> String {
        format!("{}{}", self.base(), self.dimension().units()[0].suffix)
    }

    /// Every name a column can have, with its unit.
    pub fn names() -> impl Iterator<Item = (String, RunColumn, &'static Unit)> {
        RunColumn::ALL.into_iter().flat_map(|column| {
            let units = column.dimension().units().iter();
            units.map(move |unit| (format!("{}{}", column.base(), unit.suffix), column, unit))
        })
    }

    /// The column of this name, with the unit in it.
    pub fn named(name: &str) -> Option<(RunColumn, &'static Unit)> {
        let mut names = RunColumn::names();
        names.find_map(|(candidate, column, unit)| (candidate == name).then_some((column, unit)))
    }

    /// The column that a name which is none's was to be, because it lacks its unit or is misspelt, with what was expected.
    pub fn nearly(name: &str) -> Option<(RunColumn, String)> {
        if let Some(column) = RunColumn::ALL.into_iter().find(|column| column.base() == name) {
            let names = names_in_words(name, column.dimension());
            return Some((column, format!("a unit is part of the name; expected {names}")));
        }
        let candidates = RunColumn::names();
        let near = candidates
            .filter_map(|(candidate, column, _)| Some((letters_apart(name, &candidate, 2)?, candidate, column)));
        let (_, near, column) = near.min()?;
        Some((column, format!("unknown column; did you mean `{near}`?")))
    }
}
