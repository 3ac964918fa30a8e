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

/// Every column, in order, with its name without a unit and what it holds.
const COLUMNS: [(RunColumn, &str, Dimension); 20] = [
    (RunColumn::Particle, "particle", Dimension::One),
    (RunColumn::Liquid, "liquid", Dimension::One),
    (RunColumn::Diameter, "diameter", Dimension::Length),
    (RunColumn::Film, "film", Dimension::Thickness),
    (RunColumn::ImpactSpeed, "impact_speed", Dimension::Speed),
    (RunColumn::ReboundSpeed, "rebound_speed", Dimension::Speed),
    (RunColumn::Restitution, "restitution", Dimension::Share),
    (RunColumn::FilmRatio, "film_ratio", Dimension::Share),
    (RunColumn::ImpactSpeedSd, "impact_speed_sd", Dimension::Speed),
    (RunColumn::ReboundSpeedSd, "rebound_speed_sd", Dimension::Speed),
    (RunColumn::RestitutionSd, "restitution_sd", Dimension::Share),
    (RunColumn::SpeedCorrelation, "speed_correlation", Dimension::One),
    (RunColumn::DropHeight, "drop_height", Dimension::Length),
    (RunColumn::ReboundHeight, "rebound_height", Dimension::Length),
    (RunColumn::Stokes, "stokes", Dimension::One),
    (RunColumn::Runs, "runs", Dimension::One),
    (RunColumn::RestitutionSdOfRuns, "restitution_sd_of_runs", Dimension::One),
    (RunColumn::RestitutionSe, "restitution_se", Dimension::One),
    (RunColumn::Exclude, "exclude", Dimension::One),
    (RunColumn::Run, "run", Dimension::One),
];

/// The head of what is said of the columns.
pub(super) const HEAD: &str = "Columns of a table of runs";

impl RunColumn {
    /// Every column.
    pub const ALL: [RunColumn; COLUMNS.len()] = {
        let mut all = [RunColumn::Particle; COLUMNS.len()];
        let mut at = 0;
        while at < all.len() {
            all[at] = COLUMNS[at].0;
            at += 1;
        }
        all
    };

    /// What is to be said of it.
    pub fn guide(self) -> KeyGuide {
        let takes = if self.is_number() { "a number" } else { "a word" };
        let without = match self {
            RunColumn::Particle | RunColumn::Diameter => Without::Refused,
            _ => Without::Words(""),
        };
        KeyGuide::new(self.base(), self.dimension(), takes, without).in_table(HEAD)
    }

    /// Its name without a unit.
    pub fn base(self) -> &'static str {
        COLUMNS[self as usize].1
    }

    /// What it holds.
    pub fn dimension(self) -> Dimension {
        COLUMNS[self as usize].2
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
        format!("{}{}", self.base(), self.dimension().units()[0].suffix)
    }

    /// Every name a column can have, with its unit.
    pub fn names() -> impl Iterator<Item = (String, RunColumn, &'static Unit)> {
        RunColumn::ALL.into_iter().flat_map(|column| {
            let names = column.dimension().names(column.base());
            names.map(move |(name, unit)| (name, column, unit))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_listed_in_their_order() {
        assert!(RunColumn::ALL.is_sorted_by(|one, next| *one as usize + 1 == *next as usize));
    }
}
