//! Holds one run to be written, and gives its numbers in the units of a table.

use crate::rounding::to_digits;
use crate::units;

/// One run to be written; lengths in m, speeds in m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewRun<'a> {
    /// name of the particle
    pub particle: &'a str,
    /// name of the liquid; `None` for a dry run
    pub liquid: Option<&'a str>,
    /// D
    pub diameter: f64,
    /// δ and its nominal ratio to D; `None` for a dry run
    pub film: Option<(f64, f64)>,
    /// v
    pub impact_speed: f64,
    /// e; 0 where the run stuck
    pub restitution: f64,
}

impl NewRun<'_> {
    /// Names of the columns that hold numbers, in order.
    pub(super) const NUMBERS: [&'static str; 5] = [
        "diameter_mm",
        "film_um",
        "film_ratio",
        "impact_speed_m_s",
        "restitution",
    ];

    /// The numbers of a run in the units of [`NewRun::NUMBERS`].
    pub(super) fn numbers(&self) -> [Option<f64>; 5] {
        [
            Some(to_digits(units::millimetres(self.diameter), DIGITS)),
            self.film.map(|(film, _)| to_digits(units::micrometres(film), DIGITS)),
            self.film.map(|(_, ratio)| ratio),
            Some(self.impact_speed),
            Some(self.restitution),
        ]
    }
}

/// Significant digits that undo the last-digit noise of a change of unit.
const DIGITS: usize = 12;
