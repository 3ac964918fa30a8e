//! Computes the share of the impact energy that ruptures the liquid bridge, and its slope.
//!
//! The paper leaves this term out as an order of magnitude smaller than the others (text above eq. enEdis2).

use std::f64::consts::PI;

use super::coefficient::{Coefficient, Coefficients};
use super::loss::{AtFilm, Fixed, Loss, Setting};

/// Whether the rupture of the bridge is held; it takes nothing where the liquid's surface tension is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bridge(pub bool);

impl Loss for Bridge {
    fn coefficients(&self) -> &'static [Coefficient] {
        &[]
    }

    #[inline]
    fn at(&self, _: f64, _: &Coefficients) -> AtFilm {
        AtFilm::default()
    }

    fn fixed(&self, setting: &Setting) -> Option<Fixed> {
        self.0.then(|| Fixed {
            over_speed: 0.0,
            over_square: setting.surface_tension.map_or(0.0, |gamma| {
                kappa(gamma, setting.density, setting.diameter, setting.film)
            }),
        })
    }

    fn formula(&self, _: &str) -> Option<String> {
        self.0.then(|| "κ/v²".to_owned())
    }

    fn definition(&self, _: &str) -> Option<String> {
        self.0.then(|| format!("κ = 12 γ √(2 V_b D)/(ρp D³) with {VOLUME}"))
    }
}

/// [`volume`] as a formula.
pub const VOLUME: &str = "V_b = π δ² (D/2 − δ/3)";

/// Volume of the bridge, taken as the immersed cap: π δ² (D/2 − δ/3), m³. Lengths in m, δ ≤ D.
pub fn volume(diameter: f64, film: f64) -> f64 {
    PI * film * film * (diameter / 2.0 - film / 3.0)
}

/// κ of the loss κ/v², m²/s²: 12 γ √(2 V_b D) / (ρp D³).
///
/// Units: N/m, kg/m³, m, m. Source: rupture energy π γ √(2 V_b D) over the impact energy.
pub fn kappa(surface_tension: f64, density: f64, diameter: f64, film: f64) -> f64 {
    12.0 * surface_tension * (2.0 * volume(diameter, film) * diameter).sqrt() / (density * diameter.powi(3))
}

/// Loss κ/v².
pub fn loss(kappa: f64, impact_speed: f64) -> f64 {
    kappa / (impact_speed * impact_speed)
}

/// Slope of [`loss`] with respect to v, s/m.
pub fn slope_impact_speed(kappa: f64, impact_speed: f64) -> f64 {
    -2.0 * kappa / impact_speed.powi(3)
}
