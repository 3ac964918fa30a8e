//! Lists the quantities that are quoted of a fit, each with its name, symbol, unit and definition.
//!
//! Whatever fits, resamples, samples or moves constants gives numbers for what a [`Wetted`] holds; a quantity is computed
//! from these, and from nothing else, by [`Quantity::value`].

use super::coefficient::Coefficient;
use super::dry::DRY_K;
use super::jet::Number;
use super::{rebound, viscous};

/// A quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// k of the dry law
    DryK,
    /// a parameter that particles share, L among them
    Shared(Coefficient),
    /// √α, the wet restitution as St → ∞ at the reference dry speed
    EInf,
    /// 2 L/e_inf² (eq. stc)
    StC,
    /// 4 L/e_inf² = 2 St_c, where the square root reaches zero
    StNoRebound,
    /// St_c e_inf² = 2 L
    StCEInf2,
    /// δc = ε exp(L)
    DeltaC,
    /// δc/ε = exp(L)
    DeltaCOverRoughness,
    /// (e_dry² − e_inf²)/ρ̃, what the liquid's inertia takes
    InertialLoss,
    /// α of e = √(α + β/v)
    Alpha,
    /// β
    Beta,
    /// −β/α, the speed below which nothing rebounds
    ThresholdSpeed,
}

/// What a quantity is called.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Described {
    /// its word in files
    pub name: &'static str,
    /// its letter in formulas and tables
    pub symbol: &'static str,
    /// its unit
    pub unit: &'static str,
    /// whether its interval is made on its logarithm
    pub log: bool,
}

/// Where a quantity is quoted: what it reads beside a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// ε of the particle, m; absent: there is no δc
    pub roughness: Option<f64>,
    /// ρ̃
    pub density_ratio: f64,
}

impl Place {
    /// No place: for quantities that read nothing beside the fit.
    pub const NONE: Place = Place {
        roughness: None,
        density_ratio: f64::NAN,
    };
}

/// What a fit of wet runs says of one particle at one film ratio; NaN where it does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wetted<T> {
    /// e_dry at the reference dry speed
    pub e_dry: T,
    /// e_inf
    pub e_inf: T,
    /// L, where e falls with 1/St
    pub lubrication_log: T,
    /// α and β of the law in 1/v
    pub law: [T; 2],
}

impl<T: Number> Wetted<T> {
    /// By e = √(a + b/St).
    pub fn of_square_root(a: T, b: T) -> Wetted<T> {
        let rises = a.value() > 0.0;
        Wetted {
            e_inf: a.sqrt().only_if(rises),
            lubrication_log: (-b * 0.25).only_if(rises && b.value() < 0.0),
            ..Wetted::unknown(a)
        }
    }

    /// By e = a − b/St.
    pub fn of_line(a: T, b: T) -> Wetted<T> {
        let rises = a.value() > 0.0;
        let falls = rises && b.value() > 0.0;
        Wetted {
            e_inf: a.only_if(rises),
            lubrication_log: viscous::lubrication_log(a, b / a).only_if(falls),
            ..Wetted::unknown(a)
        }
    }

    /// By e = √(α + β/v).
    pub fn of_speed(alpha: T, beta: T) -> Wetted<T> {
        Wetted {
            e_inf: alpha.sqrt().only_if(alpha.value() > 0.0),
            law: [alpha, beta],
            ..Wetted::unknown(alpha)
        }
    }

    /// By an energy balance.
    pub fn of_balance(e_inf: T, lubrication_log: T) -> Wetted<T> {
        Wetted {
            e_inf,
            lubrication_log,
            ..Wetted::unknown(e_inf)
        }
    }

    /// Nothing known.
    fn unknown(any: T) -> Wetted<T> {
        let none = any.only_if(false);
        Wetted {
            e_dry: none,
            e_inf: none,
            lubrication_log: none,
            law: [none; 2],
        }
    }

    /// The same with e_dry of the particle.
    pub fn with_e_dry(self, e_dry: T) -> Wetted<T> {
        Wetted { e_dry, ..self }
    }
}

impl Quantity {
    /// What it is called.
    pub fn describe(self) -> Described {
        let of = |name, symbol, unit, log| Described {
            name,
            symbol,
            unit,
            log,
        };
        match self {
            Quantity::DryK => of(DRY_K.name, DRY_K.symbol, DRY_K.unit, false),
            Quantity::Shared(coefficient) => {
                let own = coefficient.describe();
                of(own.name, own.symbol, own.unit, own.in_logarithm)
            }
            Quantity::EInf => of("e_inf", "e_inf", "1", false),
            Quantity::StC => of("st_c", "St_c", "1", false),
            Quantity::StNoRebound => of("st_no_rebound", "2 St_c", "1", false),
            Quantity::StCEInf2 => of("st_c_e_inf2", "St_c e_inf²", "1", false),
            Quantity::DeltaC => of("delta_c_m", "δc", "m", true),
            Quantity::DeltaCOverRoughness => of("delta_c_over_roughness", "δc/ε", "1", true),
            Quantity::InertialLoss => of("loss_over_density_ratio", "(e_dry² − e_inf²)/ρ̃", "1", false),
            Quantity::Alpha => of("alpha", "α", "1", false),
            Quantity::Beta => of("beta", "β", "m/s", false),
            Quantity::ThresholdSpeed => of("threshold_speed_m_s", "v at e = 0", "m/s", false),
        }
    }

    /// Its value; NaN where it is not defined, and of parameters that follow from nothing else.
    #[inline]
    pub fn value<T: Number>(self, at: &Place, of: &Wetted<T>) -> T {
        let l = of.lubrication_log;
        match self {
            Quantity::Shared(Coefficient::LubricationLog) => l,
            Quantity::DryK | Quantity::Shared(_) => l.only_if(false),
            Quantity::EInf => of.e_inf,
            Quantity::StC => viscous::st_c(l, of.e_inf),
            Quantity::StNoRebound => viscous::st_no_rebound(l, of.e_inf),
            Quantity::StCEInf2 => l * 2.0,
            Quantity::DeltaC => match at.roughness {
                Some(roughness) => viscous::critical_separation(roughness, l),
                None => l.only_if(false),
            },
            Quantity::DeltaCOverRoughness => l.exp(),
            Quantity::InertialLoss => (of.e_dry * of.e_dry - of.e_inf * of.e_inf) * (1.0 / at.density_ratio),
            Quantity::Alpha => of.law[0],
            Quantity::Beta => of.law[1],
            Quantity::ThresholdSpeed => rebound::threshold_speed(of.law[0], of.law[1]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: Place = Place {
        roughness: Some(5e-6),
        density_ratio: 0.43,
    };

    #[test]
    fn both_laws_give_the_same_quantities_of_the_same_restitution() {
        let (e_inf, st_c) = (0.72, 10.4);
        let root = Wetted::of_square_root(e_inf * e_inf, -2.0 * st_c * e_inf * e_inf);
        let line = Wetted::of_line(e_inf, e_inf * st_c);
        for quantity in [Quantity::EInf, Quantity::StC, Quantity::StNoRebound, Quantity::DeltaC] {
            let (of_root, of_line) = (quantity.value(&AT, &root), quantity.value(&AT, &line));
            assert!(
                (of_root / of_line - 1.0).abs() < 1e-13,
                "{quantity:?} {of_root} {of_line}"
            );
        }
        assert!(Quantity::StC.value(&AT, &Wetted::of_square_root(0.5, 0.1)).is_nan());
        assert!(Quantity::StC.value(&AT, &Wetted::of_line(0.5, -0.1)).is_nan());
        assert!(Quantity::EInf.value(&AT, &Wetted::of_square_root(-0.5, -0.1)).is_nan());
        assert!(Quantity::DeltaC.value(&Place::NONE, &root).is_nan());
    }
}
