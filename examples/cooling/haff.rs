//! Gives what kinetic theory says of a dilute gas of smooth hard spheres whose restitution is constant.

use std::f64::consts::PI;

/// A gas in its state of homogeneous cooling, to first order in a₂, which does for e of 0.8 and above; at e = 0 it cools
/// about a percent more slowly.
pub struct Haff {
    /// restitution
    pub e: f64,
    /// variance of a component of velocity at the start, m²/s²
    pub temperature: f64,
    /// π D² n, the spheres met on a metre of relative path, 1/m
    pub met_per_metre: f64,
}

impl Haff {
    /// a₂, how far the velocities are from normal, to first order: van Noije & Ernst 1998, Granular Matter 1, 57.
    pub fn sonine(&self) -> f64 {
        let (e, square) = (self.e, self.e * self.e);
        16.0 * (1.0 - e) * (1.0 - 2.0 * square) / (81.0 - 17.0 * e + 30.0 * square * (1.0 - e))
    }

    /// Impacts of a sphere of normal velocities in a second at the start: π D² n times the mean relative speed.
    fn frequency_of_normal(&self) -> f64 {
        self.met_per_metre * 4.0 * (self.temperature / PI).sqrt()
    }

    /// Impacts of a sphere in a second at the start.
    pub fn frequency(&self) -> f64 {
        self.frequency_of_normal() * (1.0 - self.sonine() / 16.0)
    }

    /// 1/τ at the start, half the rate at which the energy falls, 1/s: an impact between normal velocities takes the mean
    /// share (1 − e²)/3 of the energy of a sphere.
    pub fn cooling_rate(&self) -> f64 {
        (1.0 - self.e * self.e) / 6.0 * self.frequency_of_normal() * (1.0 + 3.0 * self.sonine() / 16.0)
    }

    /// T(t) = T₀/(1 + t/τ)², m²/s²: Haff 1983, J. Fluid Mech. 134, 401.
    pub fn temperature_at(&self, time: f64) -> f64 {
        self.temperature / (1.0 + time * self.cooling_rate()).powi(2)
    }
}
