//! Holds the columns that a table of runs can have.

use super::keys::KeyGuide;
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
const NO_ERROR: &str = "taken as exact, but for what scatters the runs";

/// A column of words.
fn word(base: &'static str, example: &'static str) -> KeyGuide {
    KeyGuide::new(base, Dimension::One, "a word", example)
}

/// A column of numbers.
fn number(base: &'static str, dimension: Dimension, example: &'static str) -> KeyGuide {
    KeyGuide::new(base, dimension, "a number", example)
}

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

    /// What is to be said of it.
    pub fn guide(self) -> KeyGuide {
        match self {
            RunColumn::Particle => word("particle", "PTFE").means("name of the sphere's material, one in [particles]"),
            RunColumn::Liquid => word("liquid", "AK10")
                .means("name of the liquid in every row, one in [liquids]; empty or `dry` without liquid")
                .without("every run is dry, and the scene has no [liquids]"),
            RunColumn::Diameter => number("diameter", Dimension::Length, "4.762").means("diameter of the sphere"),
            RunColumn::Film => number("film", Dimension::Thickness, "287")
                .means("thickness of the film; not read of dry runs")
                .without("no run may be wet"),
            RunColumn::ImpactSpeed => number("impact_speed", Dimension::Speed, "1.41")
                .means("normal speed before the impact")
                .without("drop_height or stokes gives it"),
            RunColumn::ReboundSpeed => number("rebound_speed", Dimension::Speed, "0.92")
                .means("normal speed after the impact; 0: the run stuck")
                .without("restitution or rebound_height gives it"),
            RunColumn::Restitution => number("restitution", Dimension::Share, "0.652")
                .means("rebound over impact speed; 0: the run stuck")
                .without("rebound_speed or rebound_height gives it"),
            RunColumn::DropHeight => number("drop_height", Dimension::Length, "100")
                .means("where the sphere's lowest point falls from (its centre: heights_of), v = √(2 g h)")
                .without("impact_speed or stokes gives the speed"),
            RunColumn::ReboundHeight => number("rebound_height", Dimension::Length, "43")
                .means("how high its lowest point rebounds; see heights_of, heights_to")
                .without("rebound_speed or restitution gives the speed"),
            RunColumn::Stokes => number("stokes", Dimension::One, "52")
                .means("Stokes number St = ρp D v/(9 η) of a wet run")
                .without("impact_speed or drop_height gives the speed"),
            RunColumn::FilmRatio => number("film_ratio", Dimension::Share, "0.06")
                .means("nominal film ratio δ/D that the run belongs to")
                .without("by film_ratios in [data], else groups are found"),
            RunColumn::ImpactSpeedSd => number("impact_speed_sd", Dimension::Speed, "0.004")
                .means("sd of the error of the impact speed")
                .without(NO_ERROR),
            RunColumn::ReboundSpeedSd => number("rebound_speed_sd", Dimension::Speed, "0.004")
                .means("sd of the error of the rebound speed")
                .without(NO_ERROR),
            RunColumn::RestitutionSd => number("restitution_sd", Dimension::Share, "0.01")
                .means("sd of the error of the restitution as a whole")
                .without(NO_ERROR),
            RunColumn::SpeedCorrelation => number("speed_correlation", Dimension::One, "0.5")
                .means("correlation of the errors of both speeds, from -1 to 1")
                .without("0"),
            RunColumn::Runs => number("runs", Dimension::One, "5")
                .means("how many runs at one setting the row is the mean of")
                .without("each row is one run"),
            RunColumn::RestitutionSdOfRuns => number("restitution_sd_of_runs", Dimension::One, "0.012")
                .means("of a mean: sd of its single runs")
                .without("restitution_se says how the runs of a mean scatter"),
            RunColumn::RestitutionSe => number("restitution_se", Dimension::One, "0.005")
                .means("of a mean: its standard error, sd/√runs")
                .without("restitution_sd_of_runs says how the runs of a mean scatter"),
            RunColumn::Exclude => word("exclude", "touched the wall")
                .means(
                    "why the run is left out; counted under these words; a no, `ok` or dash keeps it, 0 among 0 and 1",
                )
                .without("every run is used"),
            RunColumn::Run => word("run", "17")
                .means("a label, shown in messages about the row")
                .without("rows are counted"),
        }
    }

    /// Its name without a unit.
    pub fn base(self) -> &'static str {
        self.guide().base
    }

    /// What it holds.
    pub fn dimension(self) -> Dimension {
        self.guide().dimension
    }

    /// Whether its cells are numbers.
    pub fn is_number(self) -> bool {
        use RunColumn::{Exclude, Liquid, Particle, Run};
        !matches!(self, Particle | Liquid | Exclude | Run)
    }

    /// The column of the rebound for one of the impact, and the other way round; `None` where there is none.
    pub fn other_side(self) -> Option<RunColumn> {
        use RunColumn::{DropHeight, ImpactSpeed, ReboundHeight, ReboundSpeed};
        match self {
            DropHeight => Some(ReboundHeight),
            ReboundHeight => Some(DropHeight),
            ImpactSpeed => Some(ReboundSpeed),
            ReboundSpeed => Some(ImpactSpeed),
            _ => None,
        }
    }

    /// Whether it tells of the rebound.
    pub fn is_of_rebound(self) -> bool {
        use RunColumn::{ReboundHeight, ReboundSpeed, Restitution};
        matches!(self, ReboundHeight | ReboundSpeed | Restitution)
    }

    /// Its name in the usual unit, to ask for it.
    pub fn usual_name(self) -> String {
        self.guide().usual_name()
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

    /// The column whose name without a unit this is.
    pub fn of_base(name: &str) -> Option<RunColumn> {
        RunColumn::ALL.into_iter().find(|column| column.base() == name)
    }

    /// The column that a name which is none's was to be, because it lacks its unit or is misspelt, with what was expected.
    pub fn nearly(name: &str) -> Option<(RunColumn, String)> {
        if let Some(column) = RunColumn::of_base(name) {
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
