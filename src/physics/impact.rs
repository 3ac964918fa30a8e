//! Puts the terms together: the energy one impact keeps, and its slopes in every parameter.

use super::inertia::Inertia;
use super::{dry, numbers, viscous};

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
/// Eint2; the saturating form is empirical.
pub fn kept_energy(
    setting: &Setting,
    inertia: Inertia,
    dry_speed: DrySpeed,
    parameters: &Parameters,
    impact_speed: f64,
) -> f64 {
    let e_dry = dry::restitution(parameters.dry_k, dry_speed.of(impact_speed));
    let shape = inertia.shape(setting.film_ratio(), parameters.film_scale);
    e_dry * e_dry
        - parameters.inertial_prefactor * setting.density_ratio() * shape
        - viscous::loss(parameters.lubrication_log, setting.stokes(impact_speed))
}

/// Slopes of [`kept_energy`] in the parameters.
pub fn kept_energy_slopes(
    setting: &Setting,
    inertia: Inertia,
    dry_speed: DrySpeed,
    parameters: &Parameters,
    impact_speed: f64,
) -> Slopes {
    let v = dry_speed.of(impact_speed);
    let (film_ratio, density_ratio) = (setting.film_ratio(), setting.density_ratio());
    let scale = parameters.film_scale;
    Slopes {
        dry_k: 2.0 * dry::restitution(parameters.dry_k, v) * dry::slope_dry_k(v),
        lubrication_log: -viscous::slope_lubrication_log(setting.stokes(impact_speed)),
        inertial_prefactor: -density_ratio * inertia.shape(film_ratio, scale),
        film_scale: -parameters.inertial_prefactor * density_ratio * inertia.slope_film_scale(film_ratio, scale),
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
            for dry_speed in [DrySpeed::Impact, DrySpeed::Reference(2.0)] {
                let slopes = kept_energy_slopes(&SETTING, inertia, dry_speed, &PARAMETERS, 1.37);
                let slopes = [
                    slopes.dry_k,
                    slopes.lubrication_log,
                    slopes.inertial_prefactor,
                    slopes.film_scale,
                ];
                for (parameter, slope) in slopes.into_iter().enumerate() {
                    let at = |step| kept_energy(&SETTING, inertia, dry_speed, &moved(parameter, step), 1.37);
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
        };
        let scaled_parameters = Parameters {
            dry_k: PARAMETERS.dry_k * speed_unit.powf(-0.2),
            ..PARAMETERS
        };
        for inertia in Inertia::ALL {
            let here = kept_energy(&SETTING, inertia, DrySpeed::Reference(2.0), &PARAMETERS, 1.37);
            let there = kept_energy(
                &scaled,
                inertia,
                DrySpeed::Reference(2.0 * speed_unit),
                &scaled_parameters,
                1.37 * speed_unit,
            );
            assert!((here / there - 1.0).abs() < 1e-12, "{inertia:?} {here} {there}");
        }
    }

    #[test]
    fn the_dry_speed_matters_only_for_impact_speeds_other_than_the_reference() {
        let at = |dry_speed, v| kept_energy(&SETTING, Inertia::Cap, dry_speed, &PARAMETERS, v);
        assert_eq!(at(DrySpeed::Impact, 2.0), at(DrySpeed::Reference(2.0), 2.0));
        assert!(at(DrySpeed::Impact, 0.8) > at(DrySpeed::Reference(2.0), 0.8) + 0.05);
    }
}
