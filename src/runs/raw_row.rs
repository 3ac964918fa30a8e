//! Holds one run as a file has it, and how its heights and Stokes number become speeds.

use crate::physics::numbers::speed_at_stokes;
use crate::scene::{HeightsOf, HeightsTo, RunColumn, Scene, DRY};

/// Largest restitution that is kept, with a notice above one; larger ones cannot be a measurement of a rebound.
pub(crate) const LARGEST_RESTITUTION: f64 = 1.1;

/// One run as the file has it: numbers in SI, missing cells as `None`.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct RawRow<'a> {
    pub particle: Option<&'a str>,
    pub liquid: Option<&'a str>,
    pub diameter: Option<f64>,
    pub film: Option<f64>,
    pub impact_speed: Option<f64>,
    pub rebound_speed: Option<f64>,
    pub restitution: Option<f64>,
    pub film_ratio: Option<f64>,
    /// standard deviations of impact speed, rebound speed and restitution
    pub sds: [Option<f64>; 3],
    /// of the errors of both speeds
    pub speed_correlation: Option<f64>,
    pub drop_height: Option<f64>,
    pub rebound_height: Option<f64>,
    pub stokes: Option<f64>,
    /// how many runs it is the mean of, with their sd and the standard error of their mean
    pub runs: Option<f64>,
    pub sd_of_runs: Option<f64>,
    pub se: Option<f64>,
    /// why it is left out
    pub exclude: Option<&'a str>,
    /// its label
    pub run: Option<&'a str>,
}

impl<'a> RawRow<'a> {
    /// Takes the word of a column that holds no numbers.
    pub fn set_word(&mut self, column: RunColumn, word: Option<&'a str>) {
        match column {
            RunColumn::Particle => self.particle = word,
            RunColumn::Liquid => self.liquid = word,
            RunColumn::Exclude => self.exclude = word,
            RunColumn::Run => self.run = word,
            _ => {}
        }
    }

    /// Takes the number of a column that holds such.
    pub fn set(&mut self, column: RunColumn, value: Option<f64>) {
        match column {
            RunColumn::Diameter => self.diameter = value,
            RunColumn::Film => self.film = value,
            RunColumn::ImpactSpeed => self.impact_speed = value,
            RunColumn::ReboundSpeed => self.rebound_speed = value,
            RunColumn::Restitution => self.restitution = value,
            RunColumn::FilmRatio => self.film_ratio = value,
            RunColumn::ImpactSpeedSd => self.sds[0] = value,
            RunColumn::ReboundSpeedSd => self.sds[1] = value,
            RunColumn::RestitutionSd => self.sds[2] = value,
            RunColumn::SpeedCorrelation => self.speed_correlation = value,
            RunColumn::DropHeight => self.drop_height = value,
            RunColumn::ReboundHeight => self.rebound_height = value,
            RunColumn::Stokes => self.stokes = value,
            RunColumn::Runs => self.runs = value,
            RunColumn::RestitutionSdOfRuns => self.sd_of_runs = value,
            RunColumn::RestitutionSe => self.se = value,
            RunColumn::Particle | RunColumn::Liquid | RunColumn::Exclude | RunColumn::Run => {}
        }
    }

    /// Whether the run had no liquid.
    pub fn is_dry(&self) -> bool {
        matches!(self.liquid, None | Some(DRY))
    }
}

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

/// Speed over Stokes number of a run.
pub(super) enum StokesScale {
    Known(f64),
    /// without a liquid there is none
    Dry,
    /// a cell that it wants was refused
    Unknown,
}

impl StokesScale {
    pub fn of(scene: &Scene, particle: Option<usize>, liquid: Option<usize>, diameter: Option<f64>) -> StokesScale {
        let (Some(particle), Some(diameter)) = (particle, diameter) else {
            return StokesScale::Unknown;
        };
        let Some(liquid) = liquid else {
            return StokesScale::Dry;
        };
        let (density, viscosity) = (scene.particles[particle].density, scene.liquids[liquid].viscosity);
        StokesScale::Known(speed_at_stokes(density, diameter, viscosity, 1.0))
    }
}

/// Where a sphere meets the film, on the scale of the heights of a table.
pub(super) struct Surface {
    pub height: f64,
}

impl Surface {
    /// `None` where film or diameter were refused and the heights depend on it.
    pub fn of(scene: &Scene, film: Option<f64>, diameter: Option<f64>) -> Option<Surface> {
        let of_film = match scene.data.naming.heights_to {
            HeightsTo::Plate => film?,
            HeightsTo::Film => 0.0,
        };
        let of_sphere = match scene.data.naming.heights_of {
            HeightsOf::Lowest => 0.0,
            HeightsOf::Centre => 0.5 * diameter?,
        };
        Some(Surface {
            height: of_film + of_sphere,
        })
    }

    /// How far a sphere falls from a height to the surface; `None` where it lies within.
    pub fn fall(&self, height: f64) -> Option<f64> {
        let fall = height - self.height;
        (fall > 0.0).then_some(fall)
    }
}
