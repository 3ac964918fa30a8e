//! Computes the viscous loss of a wet impact and the critical Stokes numbers that follow from it.
//!
//! Symbols: L = ln(δc/ε) `lubrication_log`. The paper calls 2 L "k" in eq. wetcor; here k is the dry law's only.

use super::coefficient::{Coefficient, Coefficients, LogNormal, Parameter};
use super::jet::Number;
use super::loss::{AtFilm, Fixed, Loss, Setting, Share, Slope};

/// L = ln(δc/ε).
pub const LUBRICATION_LOG: Parameter = Parameter {
    name: "lubrication_log",
    symbol: "L",
    words: "the viscous loss",
    unit: "1",
    grid: &[],
    must_be_positive: false,
    may_be_zero: false,
    prior: LogNormal {
        median: 3.0,
        ln_sd: 0.5,
        reason: "default: film of some 10 to 1000 roughnesses where the sphere turns round",
    },
};

/// Form of the viscous loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Viscous {
    /// 4 L/St with one L (eqs. visc and beta)
    Constant,
    /// no viscous loss
    None,
}

impl Loss for Viscous {
    fn coefficients(&self) -> &'static [Coefficient] {
        match self {
            Viscous::Constant => &[Coefficient::LubricationLog],
            Viscous::None => &[],
        }
    }

    fn at(&self, _: f64, values: &Coefficients) -> AtFilm {
        match self {
            Viscous::Constant => AtFilm {
                share: over_stokes(values[Coefficient::LubricationLog]),
                slopes: [
                    Some(Slope {
                        of: Coefficient::LubricationLog,
                        share: over_stokes(1.0),
                    }),
                    None,
                ],
            },
            Viscous::None => AtFilm::default(),
        }
    }

    fn fixed(&self, _: &Setting) -> Option<Fixed> {
        None
    }

    fn formula(&self, _: &str) -> Option<String> {
        match self {
            Viscous::Constant => Some("4 L/St".to_owned()),
            Viscous::None => None,
        }
    }
}

fn over_stokes(viscous: f64) -> Share {
    Share { inertial: 0.0, viscous }
}

/// Share of the impact energy lost to viscosity, 4 L / St (eqs. visc and beta).
pub fn loss(lubrication_log: f64, stokes: f64) -> f64 {
    4.0 * lubrication_log / stokes
}

/// Slope of [`loss`] with respect to L: 4 / St.
pub fn slope_lubrication_log(stokes: f64) -> f64 {
    4.0 / stokes
}

/// β = −36 η L/(ρp D) of e = √(α + β/v), m/s (eq. beta). Units: Pa s, kg/m³, m.
pub fn beta(lubrication_log: f64, viscosity: f64, density: f64, diameter: f64) -> f64 {
    -36.0 * viscosity * lubrication_log / (density * diameter)
}

/// Critical Stokes number of the linear law, St_c = 2 L / e_inf² (eq. stc): where e_inf (1 − St_c/St) is zero.
pub fn st_c<T: Number>(lubrication_log: T, e_inf: T) -> T {
    lubrication_log * 2.0 / (e_inf * e_inf)
}

/// Stokes number at which the square root reaches zero, 4 L / e_inf² = 2 St_c.
pub fn st_no_rebound<T: Number>(lubrication_log: T, e_inf: T) -> T {
    st_c(lubrication_log, e_inf) * 2.0
}

/// L from e_inf and St_c, the inverse of [`st_c`].
pub fn lubrication_log<T: Number>(e_inf: T, st_c: T) -> T {
    st_c * 0.5 * e_inf * e_inf
}

/// Critical separation δc = ε exp(L), m, for a roughness ε in m.
pub fn critical_separation<T: Number>(roughness: f64, lubrication_log: T) -> T {
    lubrication_log.exp() * roughness
}

#[cfg(test)]
mod tests {
    use super::super::numbers;
    use super::*;

    #[test]
    fn beta_over_speed_is_minus_the_loss() {
        let (density, diameter, speed, viscosity, l) = (2150.0, 4.762e-3, 1.3, 48.3e-3, 1.92);
        let st = numbers::stokes(density, diameter, speed, viscosity);
        let from_beta = -beta(l, viscosity, density, diameter) / speed;
        assert!((from_beta / loss(l, st) - 1.0).abs() < 1e-14);
        assert!((slope_lubrication_log(st) * l / loss(l, st) - 1.0).abs() < 1e-15);
    }

    /// Slip 2 of the paper: the linear law is zero at St_c, the square root only at 2 St_c.
    #[test]
    fn the_square_root_is_zero_at_twice_the_linear_laws_critical_stokes_number() {
        let (l, e_inf) = (1.92, 0.72);
        let kept = |st: f64| e_inf * e_inf - loss(l, st);
        assert!(kept(st_no_rebound(l, e_inf)).abs() < 1e-15);
        assert!(kept(st_c(l, e_inf)) < -0.1);
        let linear = e_inf * (1.0 - st_c(l, e_inf) / st_no_rebound(l, e_inf));
        assert!((linear - 0.5 * e_inf).abs() < 1e-15);
        assert!((lubrication_log(e_inf, st_c(l, e_inf)) - l).abs() < 1e-15);
    }

    /// Slip 4 of the paper: St_c e_inf² = 5.5 is δc = 78 µm for ε = 5 µm, not about 100 µm.
    #[test]
    fn the_papers_critical_separation_is_78_micrometres() {
        let delta_c = critical_separation(5e-6, 5.5 / 2.0);
        assert!((delta_c - 78e-6).abs() < 0.3e-6, "{delta_c}");
        assert!(delta_c < 80e-6);
    }
}
