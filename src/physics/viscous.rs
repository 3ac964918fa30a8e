//! Computes the viscous loss of a wet impact and the critical Stokes numbers that follow from it.
//!
//! The loss is 4 L/St. Either L = ln(δc/ε) is one number, lubrication acting within a critical separation δc; or lubrication
//! acts all the way through the film and out to where the bridge ruptures, and L = ½ (ln(δ/ε) + ln(δr/ε)) belongs to a film
//! and a diameter. The paper calls 2 L "k" in eq. wetcor; here k is the dry law's only.

use super::bridge;
use super::coefficient::{Coefficient, Coefficients, LogNormal, Parameter};
use super::jet::Number;
use super::loss::{AtFilm, Fixed, Loss, Setting, Share, Slope};

/// L = ln(δc/ε).
pub const LUBRICATION_LOG: Parameter = Parameter {
    name: "lubrication_log",
    symbol: "L",
    words: "the viscous loss",
    meaning: "L = ln(δc/ε) of the viscous loss 4 L/St",
    example: "2.75",
    unit: "1",
    grid: &[],
    must_be_positive: false,
    in_logarithm: false,
    may_be_zero: false,
    prior: LogNormal {
        median: 3.0,
        ln_sd: 0.5,
        reason: "default: film of some 10 to 1000 roughnesses where the sphere turns round",
    },
};

/// λ = δr/V_b^(1/3), the rupture distance of the bridge over the cube root of its volume.
///
/// A static bridge ruptures at (1 + θ/2) V_b^(1/3), θ being the contact angle: Lian, Thornton & Adams 1993, J. Colloid
/// Interface Sci. 161, 138, for two spheres.
pub const RUPTURE_SCALE: Parameter = Parameter {
    name: "rupture_scale",
    symbol: "λ",
    words: "the rupture distance",
    meaning: "λ = δr/V_b^(1/3) of the viscous loss over the whole film, with `viscous = \"film\"`",
    example: "1.3",
    unit: "1",
    grid: &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0],
    must_be_positive: true,
    in_logarithm: true,
    may_be_zero: false,
    prior: LogNormal {
        median: 1.0,
        ln_sd: 1.0,
        reason: "default: a bridge ruptures at 1 to 1.8 V_b^(1/3), by its contact angle (Lian et al. 1993); the \
                 roughness, which enters squared, is hardly known better than to a half",
    },
};

/// Form of the viscous loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "cli", serde(rename_all = "snake_case"))]
pub enum Viscous {
    /// 4 L/St with one L (eqs. visc and beta)
    Constant,
    /// 4 L/St with L = ½ (ln(δ/ε) + ln(δr/ε)), δr = λ V_b^(1/3) (eq. visc0)
    Film,
    /// no viscous loss
    None,
}

impl Viscous {
    /// Every one.
    pub const ALL: [Viscous; 3] = [Viscous::Constant, Viscous::Film, Viscous::None];

    /// The forms a scene can name, the usual one first; its list of terms leaves the loss out.
    pub const NAMED: [Viscous; 2] = [Viscous::Constant, Viscous::Film];

    /// Its word in scenes and files.
    pub fn name(self) -> &'static str {
        match self {
            Viscous::Constant => "constant",
            Viscous::Film => "film",
            Viscous::None => "none",
        }
    }

    /// What it says, in words.
    pub fn words(self) -> &'static str {
        match self {
            Viscous::Constant => "one L for all films",
            Viscous::Film => "lubrication over the whole film",
            Viscous::None => "no viscous loss",
        }
    }

    /// Why L is not the logarithm of a δc/ε; `None` if it is.
    pub fn why_no_critical_separation(self) -> Option<&'static str> {
        match self {
            Viscous::Film => Some("lubrication acts over the whole film: there is no δc"),
            Viscous::Constant | Viscous::None => None,
        }
    }

    /// Whether it reads the roughness of the particles.
    pub fn reads_roughness(self) -> bool {
        self == Viscous::Film
    }

    /// Whether spheres of two diameters in films of one film ratio differ in L, and so in St_c.
    pub fn tells_diameters_apart(self) -> bool {
        self == Viscous::Film
    }

    /// What has to be said of its parameter wherever it is told; `None` if nothing.
    pub fn caution(self) -> Option<&'static str> {
        match self {
            Viscous::Film => Some(
                "without a measured contact angle the runs determine λ/ε² alone: λ is as sure as the square of the \
                 roughness. L = ½ (ln(δ/ε) + ln(δr/ε)) with δr = λ V_b^(1/3), and with it St_c, belongs to a film and \
                 a diameter; there is no δc",
            ),
            Viscous::Constant | Viscous::None => None,
        }
    }
}

impl Loss for Viscous {
    fn coefficients(&self) -> &'static [Coefficient] {
        match self {
            Viscous::Constant => &[Coefficient::LubricationLog],
            Viscous::Film => &[Coefficient::RuptureScale],
            Viscous::None => &[],
        }
    }

    #[inline]
    fn at(&self, _: f64, values: &Coefficients) -> AtFilm {
        match self {
            Viscous::Constant => taken(Coefficient::LubricationLog, values[Coefficient::LubricationLog], 1.0),
            // the part of L that λ moves; the film's own no parameter does
            Viscous::Film => {
                let scale = values[Coefficient::RuptureScale];
                taken(Coefficient::RuptureScale, 0.5 * scale.ln(), 0.5 / scale)
            }
            Viscous::None => AtFilm::default(),
        }
    }

    fn fixed(&self, setting: &Setting) -> Option<Fixed> {
        match self {
            Viscous::Film => Some(Fixed {
                // a share that falls with 1/v has its coefficient as its value at 1 m/s
                over_speed: loss(of_unit_scale(setting), setting.stokes(1.0)),
                over_square: 0.0,
            }),
            Viscous::Constant | Viscous::None => None,
        }
    }

    fn formula(&self, _: &str) -> Option<String> {
        (*self != Viscous::None).then(|| "4 L/St".to_owned())
    }

    fn definition(&self, _: &str) -> Option<String> {
        match self {
            Viscous::Constant => Some("L = ln(δc/ε)".to_owned()),
            Viscous::Film => Some(format!("L = ½ (ln(δ/ε) + ln(λ V_b^(1/3)/ε)) with {}", bridge::VOLUME)),
            Viscous::None => None,
        }
    }
}

/// L that one parameter moves, and its slope in that.
fn taken(of: Coefficient, lubrication_log: f64, slope: f64) -> AtFilm {
    let over_stokes = |viscous: f64| Share { inertial: 0.0, viscous };
    let slope = Slope {
        of,
        share: over_stokes(slope),
    };
    AtFilm {
        share: over_stokes(lubrication_log),
        slopes: [Some(slope), None],
    }
}

/// ½ (ln(δ/ε) + ln(V_b^(1/3)/ε)): L of a film at λ = 1, from logarithms of ratios that are of order 1 to 10⁴; NaN without ε.
fn of_unit_scale(setting: &Setting) -> f64 {
    let roughness = setting.roughness.unwrap_or(f64::NAN);
    let length = bridge::volume(setting.diameter, setting.film).cbrt();
    0.5 * ((setting.film / roughness).ln() + (length / roughness).ln())
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
    use super::super::balance::kept_energy;
    use super::super::coefficient::Parameters;
    use super::super::form::{DrySpeed, Form};
    use super::super::inertia::Inertia;
    use super::super::tests::SETTING;
    use super::*;

    /// L = ½ (ln(δ/ε) + ln(δr/ε)) summed up plainly, over the films and diameters of the published experiments.
    #[test]
    fn lubrication_over_the_whole_film_takes_the_plain_sum() {
        let form = Form {
            viscous: Viscous::Film,
            ..Form::new(Inertia::None, DrySpeed::Reference(2.0))
        };
        for (diameter, film, scale) in [(4.762e-3, 286e-6, 1.0), (1e-2, 1e-3, 1.6), (2e-3, 20e-6, 4e-3)] {
            let setting = Setting {
                diameter,
                film,
                ..SETTING
            };
            let volume = std::f64::consts::PI * film * film * (diameter / 2.0 - film / 3.0);
            let rupture = scale * volume.powf(1.0 / 3.0);
            let l = 0.5 * ((film / 5e-6).ln() + (rupture / 5e-6).ln());
            let v = 1.3;
            // energy over that of the impact, eq. visc0: (3/2) π η D² v (…) over (π/12) ρp D³ v²
            let viscous = 1.5 * std::f64::consts::PI * 9.3e-3 * diameter * diameter * v * 2.0 * l;
            let impact = std::f64::consts::PI / 12.0 * 2150.0 * diameter.powi(3) * v * v;
            let parameters = Parameters::new(0.0).with(Coefficient::RuptureScale, scale);
            let taken = 1.0 - kept_energy(&setting, form, &parameters, v);
            assert!((taken / (viscous / impact) - 1.0).abs() < 1e-13, "{taken}");
            let share = form.viscous.at(setting.film_ratio(), &parameters.shared).share.viscous;
            let all = share + form.fixed_over_stokes(&setting);
            assert!((all / l - 1.0).abs() < 1e-14, "{all} {l}");
            let smooth = Setting {
                roughness: None,
                ..setting
            };
            assert!(kept_energy(&smooth, form, &parameters, v).is_nan());
        }
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
}
