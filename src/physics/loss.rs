//! Says what a loss of the energy balance has to state of itself.
//!
//! Every loss known so far is, at fixed parameters, a share of the impact energy that falls with the first powers of
//! 1/v: ρ̃ a + l · 4/St + c₁/v + c₂/v². A loss states what it adds to a and l, which parameters move, and to c₁ and c₂,
//! which none does.

use std::ops::Add;

use super::coefficient::{Coefficient, Coefficients};
use super::numbers;

/// A film and the densities beside it, as far as losses with parameters read them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// δ̃ = δ/D
    pub film_ratio: f64,
    /// ρ̃ = ρl/ρp
    pub density_ratio: f64,
}

/// A sphere, a liquid and a film: what is held fixed while the impact speed varies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// particle density ρp, kg/m³
    pub density: f64,
    /// particle diameter D, m
    pub diameter: f64,
    /// liquid density ρl, kg/m³
    pub liquid_density: f64,
    /// dynamic viscosity η of the liquid, Pa s
    pub viscosity: f64,
    /// roughness ε of the particle, m; read by a viscous loss over the whole film alone, which is NaN without it
    pub roughness: Option<f64>,
    /// film thickness δ, m
    pub film: f64,
    /// surface tension γ of the liquid, N/m; read by the bridge alone
    pub surface_tension: Option<f64>,
}

/// What a loss takes of every run at one film ratio: ρ̃ · inertial + viscous · 4/St.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share {
    /// share of the impact energy over the density ratio, whatever the speed
    pub inertial: f64,
    /// share over 4/St
    pub viscous: f64,
}

impl Add for Share {
    type Output = Share;

    #[inline]
    fn add(self, other: Share) -> Share {
        Share {
            inertial: self.inertial + other.inertial,
            viscous: self.viscous + other.viscous,
        }
    }
}

/// How a share moves with one of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// the parameter
    pub of: Coefficient,
    /// slope of the share in it
    pub share: Share,
}

/// Most parameters a loss has.
pub const MOST_PARAMETERS: usize = 2;

/// What a loss takes at one film ratio, with its slope in each of its parameters in their order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AtFilm {
    /// what it takes
    pub share: Share,
    /// its slopes; `None` beyond its last parameter
    pub slopes: [Option<Slope>; MOST_PARAMETERS],
}

/// What a loss takes that no parameter moves: over_speed/v + over_square/v².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fixed {
    /// m/s
    pub over_speed: f64,
    /// m²/s²
    pub over_square: f64,
}

/// A loss of the energy balance in one of its forms.
pub trait Loss {
    /// Its parameters, in the order of files; none where it is not held.
    fn coefficients(&self) -> &'static [Coefficient];

    /// What it takes at a film ratio.
    fn at(&self, film_ratio: f64, values: &Coefficients) -> AtFilm;

    /// What it takes of a setting that no parameter moves; `None` if nothing, whatever the setting.
    fn fixed(&self, setting: &Setting) -> Option<Fixed>;

    /// The loss as a formula to be subtracted, `film` being how the text calls the film ratio; `None` if it is not held.
    fn formula(&self, film: &str) -> Option<String>;

    /// What the symbols of its formula stand for, `film` as there; `None` if there is nothing to say.
    fn definition(&self, film: &str) -> Option<String>;
}

impl Setting {
    /// δ̃ = δ/D.
    pub fn film_ratio(&self) -> f64 {
        self.film / self.diameter
    }

    /// ρ̃ = ρl/ρp.
    pub fn density_ratio(&self) -> f64 {
        self.liquid_density / self.density
    }

    /// The film as a loss with parameters reads it.
    pub fn of_film(&self) -> Film {
        Film {
            film_ratio: self.film_ratio(),
            density_ratio: self.density_ratio(),
        }
    }

    /// St at an impact speed in m/s.
    pub fn stokes(&self, impact_speed: f64) -> f64 {
        numbers::stokes(self.density, self.diameter, impact_speed, self.viscosity)
    }

    /// Re at an impact speed in m/s.
    pub fn reynolds(&self, impact_speed: f64) -> f64 {
        numbers::reynolds(self.liquid_density, self.film, impact_speed, self.viscosity)
    }
}
