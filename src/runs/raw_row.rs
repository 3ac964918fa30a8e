//! Holds one run as a file has it, and how its heights and Stokes number become speeds.

use std::ops::Index;

use crate::physics::numbers::speed_at_stokes;
use crate::scene::{HeightsOf, HeightsTo, RunColumn, Scene, DRY};

/// Largest restitution that is kept, with a notice above one; larger ones cannot be a measurement of a rebound.
pub(crate) const LARGEST_RESTITUTION: f64 = 1.1;

/// One run as the file has it: what stands in each column.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct RawRow<'a> {
    words: [Option<&'a str>; RunColumn::ALL.len()],
    /// in SI
    numbers: [Option<f64>; RunColumn::ALL.len()],
}

impl<'a> RawRow<'a> {
    /// Takes the word of a column that holds no numbers.
    pub fn set_word(&mut self, column: RunColumn, word: Option<&'a str>) {
        self.words[column as usize] = word;
    }

    /// Takes the number of a column that holds such, in SI.
    pub fn set(&mut self, column: RunColumn, value: Option<f64>) {
        self.numbers[column as usize] = value;
    }

    /// The word in a column; `None` of a missing cell.
    pub fn word(&self, column: RunColumn) -> Option<&'a str> {
        self.words[column as usize]
    }

    /// Whether the run had no liquid.
    pub fn is_dry(&self) -> bool {
        self.word(RunColumn::Liquid)
            .is_none_or(|liquid| liquid.eq_ignore_ascii_case(DRY))
    }
}

/// The number in a column, in SI; `None` of a missing cell.
impl Index<RunColumn> for RawRow<'_> {
    type Output = Option<f64>;

    fn index(&self, column: RunColumn) -> &Option<f64> {
        &self.numbers[column as usize]
    }
}

/// The columns of which runs have at least one for the impact, and one for the rebound; the usual one first.
pub(super) const IMPACTS: [RunColumn; 3] = [RunColumn::ImpactSpeed, RunColumn::DropHeight, RunColumn::Stokes];
pub(super) const REBOUNDS: [RunColumn; 3] = [
    RunColumn::Restitution,
    RunColumn::ReboundSpeed,
    RunColumn::ReboundHeight,
];

/// The columns of the standard deviations of measurement: of impact speed, rebound speed and restitution.
pub(super) const MEASUREMENT_SDS: [RunColumn; 3] = [
    RunColumn::ImpactSpeedSd,
    RunColumn::ReboundSpeedSd,
    RunColumn::RestitutionSd,
];

/// A wrong cell.
#[derive(Debug, PartialEq)]
pub(super) struct BadCell {
    pub column: RunColumn,
    pub expected: String,
}

pub(super) fn bad_cell(column: RunColumn, expected: impl Into<String>) -> BadCell {
    BadCell {
        column,
        expected: expected.into(),
    }
}

/// Adds a wrong cell; gives nothing in its place.
pub(super) fn refuse<T>(problems: &mut Vec<BadCell>, column: RunColumn, expected: impl Into<String>) -> Option<T> {
    problems.push(bad_cell(column, expected));
    None
}

/// Speed over Stokes number of a run; `None` without a liquid, and where a cell that it wants was refused.
pub(super) fn stokes_scale(
    scene: &Scene,
    particle: Option<u32>,
    liquid: Option<u32>,
    diameter: Option<f64>,
) -> Option<f64> {
    let density = scene.particles[particle? as usize].density;
    let viscosity = scene.liquids[liquid? as usize].viscosity;
    Some(speed_at_stokes(density, diameter?, viscosity, 1.0))
}

/// Where a sphere meets the film, on the scale of the heights of a table; `None` where film or diameter were refused and the
/// heights depend on it.
pub(super) fn surface(scene: &Scene, film: Option<f64>, diameter: Option<f64>) -> Option<f64> {
    let of_film = match scene.data.naming.heights_to {
        HeightsTo::Plate => film?,
        HeightsTo::Film => 0.0,
    };
    let of_sphere = match scene.data.naming.heights_of {
        HeightsOf::Lowest => 0.0,
        HeightsOf::Centre => 0.5 * diameter?,
    };
    Some(of_film + of_sphere)
}

/// How far a sphere falls from a height to the surface; `None` where it lies within.
pub(super) fn fall(height: f64, surface: f64) -> Option<f64> {
    let fall = height - surface;
    (fall > 0.0).then_some(fall)
}
