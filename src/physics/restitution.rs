//! Gives the restitution of one sphere, liquid and film at any speed: the parameters fixed, what they fix computed once.

use super::balance::{Balance, Impact};
use super::coefficient::Parameters;
use super::dry::{speed_root, Order};
use super::form::{DrySpeed, Form};
use super::loss::Setting;

/// e(v) = √r of the energy balance r = e_dry² − C ρ̃ g(δ̃) − 4 L/St at fixed parameters; 0 where r is not positive.
///
/// Unlike [`mean_restitution`](super::rebound::mean_restitution), whose smooth continuation below zero is the
/// likelihood's, this is what a simulation code needs: no rebound is 0. Beyond the speed at which e_dry reaches zero it
/// counts as zero, so that its square does not grow again. Copied freely, evaluated without allocation. Valid for normal
/// impact and 0 < δ̃ ≤ 0.5. Source: Müller & Huang 2016, eqs. enEdis2, visc, Eint1, Eint2; the saturating form is
/// empirical.
///
/// ```
/// # use wetcor::physics::{Coefficient, DrySpeed, Form, Inertia, Parameters, Restitution, Setting};
/// # let sphere = Setting {
/// #     density: 2150.0, diameter: 4.762e-3, liquid_density: 930.0, viscosity: 9.3e-3, film: 286e-6,
/// #     surface_tension: None, roughness: None,
/// # };
/// # let parameters = Parameters::new(0.183)
/// #     .with(Coefficient::LubricationLog, 1.85)
/// #     .with(Coefficient::InertialPrefactor, 0.47)
/// #     .with(Coefficient::FilmScale, 0.069);
/// // a sphere and parameters as on the crate's page
/// let form = Form::new(Inertia::Saturating, DrySpeed::Reference(2.0));
/// let e_n = Restitution::new(&sphere, form, &parameters);
/// let slope = e_n.log_slope(1.2).expect("it rebounds");
/// let change = e_n.at(1.2 * 1.001) / e_n.at(1.2);
/// assert!((change - 1.001f64.powf(slope)).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restitution(LawNumbers);

/// The numbers of a law e(v): e² = a(v) + β/v − κ/v², 0 where that is not positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawNumbers {
    /// a(v), what is kept beside the losses that fall with the speed
    pub plateau: Plateau,
    /// β, m/s; −4 L/St is β/v
    pub beta: f64,
    /// κ of the rupture of the bridge, m²/s²; 0 where it is not held
    pub kappa: f64,
}

/// What is kept of the impact energy beside the losses that fall with the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plateau {
    /// α, whatever the speed: with it and κ = 0 the law is e = √(α + β/v) (eq. envi)
    Constant(f64),
    /// e_dry(v)² − loss, e_dry being taken at the impact speed; with nothing else the law is the dry one
    OfSpeed {
        /// k, (m/s)^(-1/5)
        dry_k: f64,
        /// order of the dry law
        order: Order,
        /// what the liquid's inertia takes
        loss: f64,
    },
}

impl LawNumbers {
    /// e_dry = 1 − k v^(1/5), to this order.
    pub fn dry(dry_k: f64, order: Order) -> LawNumbers {
        let loss = 0.0;
        LawNumbers {
            plateau: Plateau::OfSpeed { dry_k, order, loss },
            beta: 0.0,
            kappa: 0.0,
        }
    }

    /// a(v) at a speed, m/s: α where the law has one.
    pub fn plateau_at(&self, speed: f64) -> f64 {
        match self.plateau {
            Plateau::Constant(alpha) => alpha,
            Plateau::OfSpeed { dry_k, order, loss } => e_dry_squared(order, dry_k, speed) - loss,
        }
    }

    /// Speed below which nothing rebounds, m/s: 0 where everything does, infinite where nothing does.
    pub fn threshold_speed(&self) -> f64 {
        let of_constant = |alpha: f64| {
            if alpha > 0.0 {
                let root = (self.beta * self.beta + 4.0 * alpha * self.kappa).sqrt();
                (0.5 * (root - self.beta) / alpha).max(0.0)
            } else {
                f64::INFINITY
            }
        };
        /// far more than it takes where the law rebounds at all but a sliver of speeds
        const MOST_STEPS: usize = 1000;
        // a(v) never rises, so that the threshold of a(v) never falls with v: from 0 its steps rise to the first root
        let step = |v: &f64| Some(of_constant(self.plateau_at(*v))).filter(|next| next > v);
        let steps = std::iter::successors(Some(0.0), step).take(MOST_STEPS);
        steps.last().unwrap_or(f64::INFINITY)
    }
}

/// k v^(1/5), held beyond the speed the law is valid to: e_dry is then zero to first order, its minimum to second.
#[inline]
fn dry_loss(order: Order, dry_k: f64, speed: f64) -> f64 {
    (dry_k * speed_root(speed)).min(order.largest_loss())
}

#[inline]
fn e_dry_squared(order: Order, dry_k: f64, speed: f64) -> f64 {
    order.of_loss(dry_loss(order, dry_k, speed))[0].powi(2)
}

impl From<LawNumbers> for Restitution {
    #[inline]
    fn from(numbers: LawNumbers) -> Restitution {
        Restitution(numbers)
    }
}

impl Restitution {
    /// The law of this sphere, liquid and film with these parameters.
    pub fn new(setting: &Setting, form: Form, parameters: &Parameters) -> Restitution {
        let Balance { lost, dry_k, order, .. } = Balance::new(form, setting.of_film(), parameters);
        let fixed = form.fixed(setting).unwrap_or_default();
        // what falls with 1/v has its coefficient as its value at 1 m/s
        let over_speed = lost.over_stokes * Impact::new(setting, form, 1.0).over_stokes;
        let loss = lost.constant;
        Restitution(LawNumbers {
            plateau: match form.dry_speed {
                DrySpeed::Reference(speed) => Plateau::Constant(e_dry_squared(order, dry_k, speed) - loss),
                DrySpeed::Impact => Plateau::OfSpeed { dry_k, order, loss },
            },
            beta: -(fixed.over_speed + over_speed),
            kappa: fixed.over_square,
        })
    }

    /// Its numbers.
    pub fn numbers(&self) -> LawNumbers {
        self.0
    }

    /// The same with so much more of the energy kept, whatever the speed.
    pub fn with_offset(mut self, offset: f64) -> Restitution {
        match &mut self.0.plateau {
            Plateau::Constant(alpha) => *alpha += offset,
            Plateau::OfSpeed { loss, .. } => *loss -= offset,
        }
        self
    }

    /// Share of the impact energy kept, r, at an impact speed above zero, m/s; negative where there is no rebound.
    // a call of its own would take as long as what it computes
    #[inline(always)]
    pub fn kept_energy(&self, impact_speed: f64) -> f64 {
        let LawNumbers { plateau, beta, kappa } = self.0;
        let inverse = 1.0 / impact_speed;
        let falling = (kappa * inverse - beta) * inverse;
        match plateau {
            Plateau::Constant(alpha) => alpha - falling,
            // what waits for the root of e_dry comes last
            Plateau::OfSpeed { dry_k, order, loss } => e_dry_squared(order, dry_k, impact_speed) - (loss + falling),
        }
    }

    /// The restitution at an impact speed above zero, m/s.
    #[inline]
    pub fn at(&self, impact_speed: f64) -> f64 {
        self.kept_energy(impact_speed).max(0.0).sqrt()
    }

    /// d ln e/d ln v at an impact speed above zero, m/s; `None` where there is no rebound.
    #[inline]
    pub fn log_slope(&self, impact_speed: f64) -> Option<f64> {
        let kept = self.kept_energy(impact_speed);
        if kept <= 0.0 {
            return None;
        }
        let LawNumbers { plateau, beta, kappa } = self.0;
        let of_plateau = match plateau {
            Plateau::Constant(_) => 0.0,
            Plateau::OfSpeed { dry_k, order, .. } => order.square_in_log_speed(dry_loss(order, dry_k, impact_speed))[0],
        };
        let falling = 2.0 * kappa / (impact_speed * impact_speed) - beta / impact_speed;
        Some((of_plateau + falling) / (2.0 * kept))
    }
}

#[cfg(test)]
mod tests {
    use super::super::balance::kept_energy;
    use super::super::inertia::Inertia;
    use super::super::tests::{every_form, parameters, SETTING};
    use super::super::viscous::Viscous;
    use super::*;

    #[test]
    fn it_is_the_root_of_the_energy_kept_and_zero_below_the_threshold() {
        for form in every_form() {
            let law = Restitution::new(&SETTING, form, &parameters());
            for v in [0.02, 0.11, 0.9, 1.37, 4.0] {
                let kept = kept_energy(&SETTING, form, &parameters(), v);
                assert!((law.kept_energy(v) - kept).abs() < 1e-13 * (1.0 + kept.abs()), "{v}");
                assert_eq!(law.at(v) == 0.0, kept <= 0.0);
                assert!(kept <= 0.0 || (law.at(v) / kept.sqrt() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_slope_agrees_with_differences_and_is_none_without_rebound() {
        let forms = every_form().into_iter();
        for form in forms.filter(|form| form.inertia == Inertia::Saturating) {
            let law = Restitution::new(&SETTING, form, &parameters());
            for v in [0.31, 0.87, 2.3] {
                let h: f64 = 1e-5;
                let difference = (law.at(v * h.exp()) / law.at(v * (-h).exp())).ln() / (2.0 * h);
                let slope = law.log_slope(v).unwrap_or(f64::NAN);
                assert!(
                    (difference - slope).abs() < 1e-6 * (1.0 + slope.abs()),
                    "{difference} {slope}"
                );
            }
            assert!(form.viscous == Viscous::None || law.log_slope(0.02).is_none());
        }
    }

    #[test]
    fn nothing_rebounds_just_below_the_threshold_and_everything_just_above() {
        for form in every_form() {
            let law = Restitution::new(&SETTING, form, &parameters());
            let threshold = law.numbers().threshold_speed();
            let rebounds = |v: f64| law.at(v) > 0.0;
            assert!(rebounds(1.0000001 * threshold + 1e-12), "{form:?}");
            assert!(threshold == 0.0 || !rebounds(0.9999999 * threshold), "{form:?}");
        }
        let dry = Restitution::from(LawNumbers::dry(0.183, Order::First));
        assert!((dry.at(1.3) - Order::First.restitution(0.183, 1.3)).abs() < 1e-15);
        assert_eq!(dry.numbers().threshold_speed(), 0.0);
        let never = LawNumbers {
            plateau: Plateau::Constant(-0.1),
            ..dry.numbers()
        };
        assert_eq!(never.threshold_speed(), f64::INFINITY);
    }

    /// Slip 3 of the paper: beyond v = k⁻⁵ the square of the dry law grows again.
    #[test]
    fn beyond_the_dry_laws_limit_there_is_no_rebound() {
        let parameters = Parameters {
            dry_k: 0.8,
            ..parameters()
        };
        let form = Form::new(Inertia::None, DrySpeed::Impact);
        let law = Restitution::new(&SETTING, form, &parameters);
        let far = 50.0 * Order::First.speed_limit(0.8);
        assert!(kept_energy(&SETTING, form, &parameters, far) > 0.0);
        assert_eq!((law.at(far), law.log_slope(far)), (0.0, None));
    }
}
