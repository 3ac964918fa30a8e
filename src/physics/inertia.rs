//! Computes the share of the impact energy that sets the liquid in motion, and its slopes.
//!
//! The loss is C ρ̃ g(δ̃): C `inertial_prefactor`, ρ̃ `density_ratio`, δ̃ `film_ratio`, g the shape given here.

use super::coefficient::{Coefficient, Coefficients, LogNormal, Parameter};
use super::loss::{AtFilm, Fixed, Loss, Setting, Share, Slope};
use crate::exponential::exponential_and_less_one;

/// C, scale of the loss.
pub const PREFACTOR: Parameter = Parameter {
    name: "inertial_prefactor",
    symbol: "C",
    words: "the inertial prefactor",
    meaning: "C, scale of the inertial loss C ρ̃ g(δ̃)",
    example: "1.0",
    unit: "1",
    grid: &[],
    must_be_positive: false,
    in_logarithm: false,
    may_be_zero: true,
    prior: LogNormal {
        median: 1.0,
        ln_sd: 0.5,
        reason: "default: the formula as derived has prefactor 1",
    },
};

/// What is believed of C in the saturating form, whose shape ends at 1.
const LEVEL: LogNormal = LogNormal {
    median: 0.3,
    ln_sd: 0.5,
    reason: "default: the published data level off near 0.25",
};

/// δ̃0, the film ratio over which the saturating form rises.
pub const FILM_SCALE: Parameter = Parameter {
    name: "film_scale",
    symbol: "δ̃0",
    words: "the film scale",
    meaning: "δ̃0, film ratio over which the saturating inertial loss rises",
    example: "0.07",
    unit: "1",
    grid: &[0.01, 0.025, 0.05, 0.1, 0.2, 0.5],
    must_be_positive: true,
    in_logarithm: false,
    may_be_zero: false,
    prior: LogNormal {
        median: 0.07,
        ln_sd: 0.5,
        reason: "default: the published data level off near a film ratio of 0.07",
    },
};

/// Shape g(δ̃) of the inertial loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "cli", serde(rename_all = "snake_case"))]
pub enum Inertia {
    /// δ̃ (3 − 6 δ̃ + 4 δ̃²): stepwise penetration, eq. Eint2. Valid to δ̃ = 0.5.
    Stepwise,
    /// 2 δ̃ (3 − 5 δ̃ + 2 δ̃²): cap displaced at once, eq. Eint1. Valid to δ̃ ≈ 0.39, where it starts to fall.
    Cap,
    /// 1 − exp(−δ̃/δ̃0): empirical, levels off as the paper's data do and neither of its formulas does.
    Saturating,
    /// no inertial loss
    None,
}

impl Inertia {
    /// The form that stands unless another is clearly better: the paper's own for its films.
    pub const DEFAULT: Inertia = Inertia::Stepwise;

    /// The forms a scene can name, in the order they are offered.
    pub const ALL: [Inertia; 4] = [Inertia::Stepwise, Inertia::Cap, Inertia::Saturating, Inertia::None];

    /// The word a scene file uses.
    pub fn name(self) -> &'static str {
        match self {
            Inertia::Stepwise => "stepwise",
            Inertia::Cap => "cap",
            Inertia::Saturating => "saturating",
            Inertia::None => "none",
        }
    }

    /// Largest film ratio at which the form means anything.
    pub fn valid_to(self) -> f64 {
        match self {
            Inertia::Stepwise | Inertia::Saturating | Inertia::None => 0.5,
            // root of d/dδ̃ = 6 − 20 δ̃ + 12 δ̃²
            Inertia::Cap => (10.0 - 28.0_f64.sqrt()) / 12.0,
        }
    }

    /// Whether the form has a film scale δ̃0.
    pub fn has_film_scale(self) -> bool {
        self == Inertia::Saturating
    }

    /// What is believed of C before any run.
    pub fn prefactor_prior(self) -> LogNormal {
        match self {
            Inertia::Saturating => LEVEL,
            Inertia::Stepwise | Inertia::Cap | Inertia::None => PREFACTOR.prior,
        }
    }

    /// g(δ̃); `film_scale` is read by the saturating form only.
    pub fn shape(self, film_ratio: f64, film_scale: f64) -> f64 {
        let x = film_ratio;
        match self {
            Inertia::Stepwise => x * (3.0 + x * (-6.0 + 4.0 * x)),
            Inertia::Cap => 2.0 * x * (3.0 + x * (-5.0 + 2.0 * x)),
            Inertia::Saturating => saturating(x / film_scale)[0],
            Inertia::None => 0.0,
        }
    }

    /// dg/dδ̃.
    pub fn slope_film_ratio(self, film_ratio: f64, film_scale: f64) -> f64 {
        let x = film_ratio;
        match self {
            // 3 − 12 δ̃ + 12 δ̃² as the square it is, which vanishes at δ̃ = 0.5 without cancelling
            Inertia::Stepwise => 3.0 * (1.0 - 2.0 * x) * (1.0 - 2.0 * x),
            Inertia::Cap => 6.0 + x * (-20.0 + 12.0 * x),
            Inertia::Saturating => saturating(x / film_scale)[1] / film_scale,
            Inertia::None => 0.0,
        }
    }

    /// dg/dδ̃0; zero for every form without a film scale.
    pub fn slope_film_scale(self, film_ratio: f64, film_scale: f64) -> f64 {
        self.shape_and_slope_film_scale(film_ratio, film_scale).1
    }

    /// g and dg/dδ̃0 of the saturating form, as a loop computes them several at a time; `fused` where the loop is made for
    /// registers that multiply and add at once.
    #[inline(always)]
    pub fn saturating_shape_and_slope(film_ratio: f64, film_scale: f64, fused: bool) -> (f64, f64) {
        let over = 1.0 / film_scale;
        let x = film_ratio * over;
        let [left, fallen] = exponential_and_less_one(-x, fused);
        (-fallen, -x * over * left)
    }

    /// g and dg/dδ̃0 together, with one exponential.
    pub fn shape_and_slope_film_scale(self, film_ratio: f64, film_scale: f64) -> (f64, f64) {
        match self {
            Inertia::Saturating => {
                let [shape, left] = saturating(film_ratio / film_scale);
                (shape, -film_ratio / (film_scale * film_scale) * left)
            }
            Inertia::Stepwise | Inertia::Cap | Inertia::None => (self.shape(film_ratio, film_scale), 0.0),
        }
    }
}

/// 1 − exp(−x) and exp(−x): each is computed where it is the smaller one, so that neither cancels.
fn saturating(x: f64) -> [f64; 2] {
    if x < std::f64::consts::LN_2 {
        let risen = -(-x).exp_m1();
        [risen, 1.0 - risen]
    } else {
        let left = (-x).exp();
        [1.0 - left, left]
    }
}

impl Loss for Inertia {
    fn coefficients(&self) -> &'static [Coefficient] {
        match self {
            Inertia::None => &[],
            Inertia::Stepwise | Inertia::Cap => &[Coefficient::InertialPrefactor],
            Inertia::Saturating => &[Coefficient::InertialPrefactor, Coefficient::FilmScale],
        }
    }

    #[inline]
    fn at(&self, film_ratio: f64, values: &Coefficients) -> AtFilm {
        if *self == Inertia::None {
            return AtFilm::default();
        }
        let c = values[Coefficient::InertialPrefactor];
        let (shape, slope) = self.shape_and_slope_film_scale(film_ratio, values[Coefficient::FilmScale]);
        let share = |inertial: f64| Share { inertial, viscous: 0.0 };
        let slope_of = |of: Coefficient, slope: f64| Slope {
            of,
            share: share(slope),
        };
        let prefactor = slope_of(Coefficient::InertialPrefactor, shape);
        let scale = || slope_of(Coefficient::FilmScale, c * slope);
        AtFilm {
            share: share(c * shape),
            slopes: [Some(prefactor), self.has_film_scale().then(scale)],
        }
    }

    fn fixed(&self, _: &Setting) -> Option<Fixed> {
        None
    }

    fn formula(&self, film: &str) -> Option<String> {
        (*self != Inertia::None).then(|| format!("C ρ̃ g({film})"))
    }

    fn definition(&self, x: &str) -> Option<String> {
        match self {
            Inertia::Stepwise => Some(format!("g({x}) = {x} (3 − 6 {x} + 4 {x}²) (stepwise, eq. Eint2)")),
            Inertia::Cap => Some(format!("g({x}) = 2 {x} (3 − 5 {x} + 2 {x}²) (cap, eq. Eint1)")),
            Inertia::Saturating => Some(format!("g({x}) = 1 − exp(−{x}/δ̃0) (saturating, empirical)")),
            Inertia::None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stepwise_is_the_integral_of_the_papers_own_velocity() {
        // 2 ∫ ½ ρl v_l² dV over ½ ρp V v²: with eq. dl2 the integrand is 12 ρ̃ (0.5 − h̃)²
        let film_ratio = 0.27;
        let steps = 20_000;
        let width = film_ratio / f64::from(steps);
        let integral: f64 = (0..steps)
            .map(|i| {
                let h = (f64::from(i) + 0.5) * width;
                12.0 * (0.5 - h) * (0.5 - h) * width
            })
            .sum();
        assert!((Inertia::Stepwise.shape(film_ratio, 0.0) - integral).abs() < 1e-8);
    }

    #[test]
    fn each_form_ends_where_it_stops_growing() {
        let cap = Inertia::Cap;
        assert!(cap.slope_film_ratio(cap.valid_to(), 0.0).abs() < 1e-12);
        assert!((cap.valid_to() - 0.39).abs() < 0.005);
        assert!(Inertia::Stepwise.slope_film_ratio(0.5, 0.0).abs() < 1e-15);
    }
}
