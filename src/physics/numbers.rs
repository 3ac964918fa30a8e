//! Computes the dimensionless numbers of an impact, its speed after a fall, and which diameters are one.

/// Acceleration of free fall used to turn a drop height into an impact speed, m/s².
pub const GRAVITY: f64 = 9.81;

/// Stokes number St = ρp D v / (9 η), with the 9 of Müller & Huang 2016.
///
/// Other codes drop the 9 or use reduced mass and radius; numbers are comparable only within one convention.
/// Units: kg/m³, m, m/s, Pa s.
pub fn stokes(density: f64, diameter: f64, impact_speed: f64, viscosity: f64) -> f64 {
    density * diameter * impact_speed / (9.0 * viscosity)
}

/// Impact speed at a Stokes number, v = 9 η St/(ρp D), by the convention of [`stokes`].
///
/// Units: kg/m³, m, Pa s; m/s.
pub fn speed_at_stokes(density: f64, diameter: f64, viscosity: f64, stokes: f64) -> f64 {
    9.0 * viscosity * stokes / (density * diameter)
}

/// Reynolds number of the film, Re = ρl δ v / η; Re/St = 9 ρ̃ δ̃.
///
/// Units: kg/m³, m, m/s, Pa s.
pub fn reynolds(liquid_density: f64, film: f64, impact_speed: f64, viscosity: f64) -> f64 {
    liquid_density * film * impact_speed / viscosity
}

/// Impact speed of a fall from rest through `height` (m), v = √(2 g h), without air drag.
pub fn free_fall_speed(height: f64) -> f64 {
    (2.0 * GRAVITY * height).sqrt()
}

/// Diameters that differ by at most this share of the smaller are one diameter.
const SAME_DIAMETER: f64 = 1e-3;

/// Whether two diameters, in the same unit, count as one.
pub fn same_diameter(one: f64, other: f64) -> bool {
    one.max(other) <= one.min(other) * (1.0 + SAME_DIAMETER)
}
