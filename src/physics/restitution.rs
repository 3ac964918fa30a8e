//! Gives the restitution of one sphere, liquid and film at any speed: the parameters fixed, what they fix computed once.

use super::dry::Order;
use super::impact::{DrySpeed, Form, Parameters, Setting};
use super::viscous;

/// e(v) = √r of the energy balance r = e_dry² − C ρ̃ g(δ̃) − 4 L/St at fixed parameters; 0 where r is not positive.
///
/// Unlike [`mean_restitution`](super::rebound::mean_restitution), whose smooth continuation below zero is the
/// likelihood's, this is what a simulation code needs: no rebound is 0. Beyond the speed at which e_dry reaches zero it
/// counts as zero, so that its square does not grow again. Copied freely, evaluated without allocation. Valid for normal
/// impact and 0 < δ̃ ≤ 0.5. Source: Müller & Huang 2016, eqs. enEdis2, visc, Eint1, Eint2; the saturating form is
/// empirical.
///
/// ```
/// # use wetcor::physics::impact::{DrySpeed, Form, Parameters, Setting};
/// # use wetcor::physics::{inertia::Inertia, restitution::Restitution};
/// # let sphere = Setting {
/// #     density: 2150.0, diameter: 4.762e-3, liquid_density: 930.0, viscosity: 9.3e-3, film: 286e-6,
/// #     surface_tension: None,
/// # };
/// # let parameters = Parameters {
/// #     dry_k: 0.183, lubrication_log: 1.85, inertial_prefactor: 0.47, film_scale: 0.069,
/// # };
/// // a sphere and parameters as on the crate's page
/// let form = Form::new(Inertia::Saturating, DrySpeed::Reference(2.0));
/// let e_n = Restitution::new(&sphere, form, &parameters);
/// let slope = e_n.log_slope(1.2).expect("it rebounds");
/// let change = e_n.at(1.2 * 1.001) / e_n.at(1.2);
/// assert!((change - 1.001f64.powf(slope)).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restitution {
    dry: Dry,
    /// C ρ̃ g(δ̃)
    inertial: f64,
    /// −β, the viscous loss times the impact speed, m/s
    viscous: f64,
    /// κ, the bridge's loss times the square of the impact speed, m²/s²
    bridge: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Dry {
    /// e_dry² at the reference speed
    Fixed(f64),
    /// k, e_dry being taken at the impact speed to this order
    Own(f64, Order),
}

impl Restitution {
    /// The law of this sphere, liquid and film with these parameters.
    pub fn new(setting: &Setting, form: Form, parameters: &Parameters) -> Restitution {
        let shape = form.inertia.shape(setting.film_ratio(), parameters.film_scale);
        let (l, k) = (parameters.lubrication_log, parameters.dry_k);
        let beta = viscous::beta(l, setting.viscosity, setting.density, setting.diameter);
        Restitution {
            dry: match form.dry_speed {
                DrySpeed::Reference(speed) => Dry::Fixed(e_dry(form.dry, k, speed).powi(2)),
                DrySpeed::Impact => Dry::Own(k, form.dry),
            },
            inertial: parameters.inertial_prefactor * setting.density_ratio() * shape,
            viscous: if form.viscous { -beta } else { 0.0 },
            bridge: if form.bridge { setting.bridge_kappa() } else { 0.0 },
        }
    }

    /// Share of the impact energy kept, r, at an impact speed above zero, m/s; negative where there is no rebound.
    pub fn kept_energy(&self, impact_speed: f64) -> f64 {
        let dry = match self.dry {
            Dry::Fixed(square) => square,
            Dry::Own(k, order) => e_dry(order, k, impact_speed).powi(2),
        };
        let inverse = 1.0 / impact_speed;
        dry - self.inertial - (self.viscous + self.bridge * inverse) * inverse
    }

    /// The restitution at an impact speed above zero, m/s.
    pub fn at(&self, impact_speed: f64) -> f64 {
        self.kept_energy(impact_speed).max(0.0).sqrt()
    }

    /// d ln e/d ln v at an impact speed above zero, m/s; `None` where there is no rebound.
    pub fn log_slope(&self, impact_speed: f64) -> Option<f64> {
        let kept = self.kept_energy(impact_speed);
        if kept <= 0.0 {
            return None;
        }
        let dry = match self.dry {
            Dry::Fixed(_) => 0.0,
            Dry::Own(k, order) => {
                2.0 * e_dry(order, k, impact_speed) * impact_speed * order.slope_impact_speed(k, impact_speed)
            }
        };
        Some((dry + (self.viscous + 2.0 * self.bridge / impact_speed) / impact_speed) / (2.0 * kept))
    }
}

/// The dry law, held beyond the speed it is valid to: at zero to first order, at its minimum to second.
fn e_dry(order: Order, dry_k: f64, speed: f64) -> f64 {
    match order {
        Order::First => order.restitution(dry_k, speed).max(0.0),
        Order::Second => order.restitution(dry_k, speed.min(order.speed_limit(dry_k))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::dry;
    use super::super::impact::kept_energy;
    use super::super::inertia::Inertia;
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

    fn forms(inertia: Inertia) -> [Form; 4] {
        let [own, fixed] = [DrySpeed::Impact, DrySpeed::Reference(1.9)].map(|speed| Form::new(inertia, speed));
        let every = Form {
            bridge: true,
            dry: Order::Second,
            ..own
        };
        [
            own,
            fixed,
            every,
            Form {
                viscous: false,
                ..fixed
            },
        ]
    }

    #[test]
    fn it_is_the_root_of_the_energy_kept_and_zero_below_the_threshold() {
        for inertia in Inertia::ALL {
            for form in forms(inertia) {
                let law = Restitution::new(&SETTING, form, &PARAMETERS);
                for v in [0.02, 0.11, 0.9, 1.37, 4.0] {
                    let kept = kept_energy(&SETTING, form, &PARAMETERS, v);
                    assert!((law.kept_energy(v) - kept).abs() < 1e-13 * (1.0 + kept.abs()), "{v}");
                    assert_eq!(law.at(v) == 0.0, kept <= 0.0);
                    assert!(kept <= 0.0 || (law.at(v) / kept.sqrt() - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn the_slope_agrees_with_differences_and_is_none_without_rebound() {
        for form in forms(Inertia::Saturating) {
            let law = Restitution::new(&SETTING, form, &PARAMETERS);
            for v in [0.31, 0.87, 2.3] {
                let h: f64 = 1e-5;
                let difference = (law.at(v * h.exp()) / law.at(v * (-h).exp())).ln() / (2.0 * h);
                let slope = law.log_slope(v).unwrap_or(f64::NAN);
                assert!(
                    (difference - slope).abs() < 1e-6 * (1.0 + slope.abs()),
                    "{difference} {slope}"
                );
            }
            assert!(!form.viscous || law.log_slope(0.02).is_none());
        }
    }

    /// Slip 3 of the paper: beyond v = k⁻⁵ the square of the dry law grows again.
    #[test]
    fn beyond_the_dry_laws_limit_there_is_no_rebound() {
        let parameters = Parameters {
            dry_k: 0.8,
            ..PARAMETERS
        };
        let form = Form::new(Inertia::None, DrySpeed::Impact);
        let law = Restitution::new(&SETTING, form, &parameters);
        let far = 50.0 * dry::speed_limit(0.8);
        assert!(kept_energy(&SETTING, form, &parameters, far) > 0.0);
        assert_eq!((law.at(far), law.log_slope(far)), (0.0, None));
    }
}
