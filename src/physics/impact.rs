//! Puts the terms together: the energy one impact keeps, and its slopes in every parameter.

use super::dry::Order;
use super::inertia::Inertia;
use super::{bridge, numbers, viscous};

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
    /// film thickness δ, m
    pub film: f64,
    /// surface tension γ of the liquid, N/m; read by the bridge alone
    pub surface_tension: Option<f64>,
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

    /// St at an impact speed in m/s.
    pub fn stokes(&self, impact_speed: f64) -> f64 {
        numbers::stokes(self.density, self.diameter, impact_speed, self.viscosity)
    }

    /// Re at an impact speed in m/s.
    pub fn reynolds(&self, impact_speed: f64) -> f64 {
        numbers::reynolds(self.liquid_density, self.film, impact_speed, self.viscosity)
    }

    /// κ of the bridge's loss κ/v², m²/s²; 0 without a surface tension.
    pub fn bridge_kappa(&self) -> f64 {
        let kappa = |gamma| bridge::kappa(gamma, self.density, self.diameter, self.film);
        self.surface_tension.map_or(0.0, kappa)
    }
}

/// Speed at which e_dry enters the energy balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrySpeed {
    /// one reference speed for every run, m/s (the paper: 2 m/s)
    Reference(f64),
    /// each run's own impact speed
    Impact,
}

impl DrySpeed {
    /// The speed to use for a run at `impact_speed`, m/s.
    pub fn of(self, impact_speed: f64) -> f64 {
        match self {
            DrySpeed::Reference(speed) => speed,
            DrySpeed::Impact => impact_speed,
        }
    }
}

/// The terms an energy balance holds, and their forms: r = e_dry² − C ρ̃ g(δ̃) − 4 L/St − κ/v², each as far as it is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// form of the inertial loss; [`Inertia::None`]: not held
    pub inertia: Inertia,
    /// the speed at which e_dry enters
    pub dry_speed: DrySpeed,
    /// whether the viscous loss is held
    pub viscous: bool,
    /// whether the rupture of the bridge is held, where the liquid has a surface tension
    pub bridge: bool,
    /// order of the dry law
    pub dry: Order,
}

impl Form {
    /// The paper's balance: the viscous loss, no bridge, the dry law to first order.
    pub fn new(inertia: Inertia, dry_speed: DrySpeed) -> Form {
        Form {
            inertia,
            dry_speed,
            viscous: true,
            bridge: false,
            dry: Order::First,
        }
    }
}

/// The parameters of the energy balance r = e_dry² − C ρ̃ g(δ̃) − 4 L/St.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// k of the dry law, (m/s)^(-1/5)
    pub dry_k: f64,
    /// L = ln(δc/ε)
    pub lubrication_log: f64,
    /// C, scale of the inertial loss
    pub inertial_prefactor: f64,
    /// δ̃0 of the saturating form; not read by the others
    pub film_scale: f64,
}

/// Slopes of the energy kept in each of [`Parameters`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slopes {
    /// dr/dk
    pub dry_k: f64,
    /// dr/dL
    pub lubrication_log: f64,
    /// dr/dC
    pub inertial_prefactor: f64,
    /// dr/dδ̃0
    pub film_scale: f64,
}

/// Share of the impact energy a wet impact keeps, r; negative where it cannot rebound.
///
/// `impact_speed` in m/s. Valid for normal impact, 0 < δ̃ ≤ 0.5 and e_dry > 0. Sources: eqs. enEdis2, visc, Eint1,
/// Eint2; the saturating form is empirical; the bridge is [`bridge`]'s.
pub fn kept_energy(setting: &Setting, form: Form, parameters: &Parameters, impact_speed: f64) -> f64 {
    let e_dry = form.dry.restitution(parameters.dry_k, form.dry_speed.of(impact_speed));
    let shape = form.inertia.shape(setting.film_ratio(), parameters.film_scale);
    let kept = e_dry * e_dry - parameters.inertial_prefactor * setting.density_ratio() * shape;
    let viscous = if form.viscous {
        viscous::loss(parameters.lubrication_log, setting.stokes(impact_speed))
    } else {
        0.0
    };
    let bridge = if form.bridge {
        bridge::loss(setting.bridge_kappa(), impact_speed)
    } else {
        0.0
    };
    kept - viscous - bridge
}

/// Slopes of [`kept_energy`] in the parameters.
pub fn kept_energy_slopes(setting: &Setting, form: Form, parameters: &Parameters, impact_speed: f64) -> Slopes {
    let v = form.dry_speed.of(impact_speed);
    let (film_ratio, density_ratio) = (setting.film_ratio(), setting.density_ratio());
    let (k, scale) = (parameters.dry_k, parameters.film_scale);
    Slopes {
        dry_k: 2.0 * form.dry.restitution(k, v) * form.dry.slope_dry_k(k, v),
        lubrication_log: if form.viscous {
            -viscous::slope_lubrication_log(setting.stokes(impact_speed))
        } else {
            0.0
        },
        inertial_prefactor: -density_ratio * form.inertia.shape(film_ratio, scale),
        film_scale: -parameters.inertial_prefactor * density_ratio * form.inertia.slope_film_scale(film_ratio, scale),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTING: Setting = Setting {
        density: 2150.0,
        diameter: 4.762e-3,
        liquid_density: 930.0,
        viscosity: 9.3e-3,
        film: 286e-6,
        surface_tension: Some(20.1e-3),
    };
    const PARAMETERS: Parameters = Parameters {
        dry_k: 0.183,
        lubrication_log: 1.92,
        inertial_prefactor: 0.41,
        film_scale: 0.068,
    };

    #[test]
    fn slopes_agree_with_differences() {
        let moved = |parameter: usize, step: f64| {
            let mut p = PARAMETERS;
            *[
                &mut p.dry_k,
                &mut p.lubrication_log,
                &mut p.inertial_prefactor,
                &mut p.film_scale,
            ][parameter] += step;
            p
        };
        let h = 1e-6;
        for inertia in Inertia::ALL {
            let plain = [DrySpeed::Impact, DrySpeed::Reference(2.0)].map(|speed| Form::new(inertia, speed));
            let every = Form {
                bridge: true,
                dry: Order::Second,
                ..plain[0]
            };
            let no_viscous = Form {
                viscous: false,
                ..plain[1]
            };
            for form in [plain[0], plain[1], every, no_viscous] {
                let slopes = kept_energy_slopes(&SETTING, form, &PARAMETERS, 1.37);
                let slopes = [
                    slopes.dry_k,
                    slopes.lubrication_log,
                    slopes.inertial_prefactor,
                    slopes.film_scale,
                ];
                for (parameter, slope) in slopes.into_iter().enumerate() {
                    let at = |step| kept_energy(&SETTING, form, &moved(parameter, step), 1.37);
                    let difference = (at(h) - at(-h)) / (2.0 * h);
                    let gap = (difference - slope).abs();
                    assert!(gap < 1e-6 * (1.0 + difference.abs()), "{inertia:?} {gap}");
                }
            }
        }
    }

    /// Metre, kilogram and second rescaled by odd factors, k and the dry speed with them: no pure number moves.
    #[test]
    fn the_energy_kept_does_not_depend_on_the_units() {
        let (metre, kilogram, second) = (3.7, 0.21, 12.9);
        let speed_unit: f64 = metre / second;
        let density_unit = kilogram / (metre * metre * metre);
        let scaled = Setting {
            density: SETTING.density * density_unit,
            diameter: SETTING.diameter * metre,
            liquid_density: SETTING.liquid_density * density_unit,
            viscosity: SETTING.viscosity * kilogram / (metre * second),
            film: SETTING.film * metre,
            surface_tension: SETTING
                .surface_tension
                .map(|gamma| gamma * kilogram / (second * second)),
        };
        let scaled_parameters = Parameters {
            dry_k: PARAMETERS.dry_k * speed_unit.powf(-0.2),
            ..PARAMETERS
        };
        for inertia in Inertia::ALL {
            let form = |speed| Form {
                bridge: true,
                ..Form::new(inertia, DrySpeed::Reference(speed))
            };
            let here = kept_energy(&SETTING, form(2.0), &PARAMETERS, 1.37);
            let there = kept_energy(&scaled, form(2.0 * speed_unit), &scaled_parameters, 1.37 * speed_unit);
            assert!((here / there - 1.0).abs() < 1e-12, "{inertia:?} {here} {there}");
        }
    }

    #[test]
    fn the_dry_speed_matters_only_for_impact_speeds_other_than_the_reference() {
        let at = |dry_speed, v| kept_energy(&SETTING, Form::new(Inertia::Cap, dry_speed), &PARAMETERS, v);
        assert_eq!(at(DrySpeed::Impact, 2.0), at(DrySpeed::Reference(2.0), 2.0));
        assert!(at(DrySpeed::Impact, 0.8) > at(DrySpeed::Reference(2.0), 0.8) + 0.05);
    }

    /// The bridge takes κ/v² and no more, and only where the liquid's surface tension is known.
    #[test]
    fn the_bridge_takes_its_share() {
        let plain = Form::new(Inertia::Stepwise, DrySpeed::Reference(2.0));
        let form = Form { bridge: true, ..plain };
        let taken = |setting: &Setting, v| {
            kept_energy(setting, plain, &PARAMETERS, v) - kept_energy(setting, form, &PARAMETERS, v)
        };
        let share = bridge::loss(SETTING.bridge_kappa(), 0.4);
        assert!(share > 1e-4 && (taken(&SETTING, 0.4) - share).abs() < 1e-15);
        let unknown = Setting {
            surface_tension: None,
            ..SETTING
        };
        assert_eq!(taken(&unknown, 0.4), 0.0);
    }
}
