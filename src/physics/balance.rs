//! Puts the terms together: the energy one impact keeps, and its slopes. Whatever is simulated, fitted, sampled or shown
//! is this sum.

use super::coefficient::{Coefficient, Coefficients, Parameters};
use super::dry::{speed_root, Order};
use super::form::{DrySpeed, Form};
use super::loss::{Film, Fixed, Setting, Share, Slope};
use super::viscous::slope_lubrication_log;

/// What of one impact the balance reads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Impact {
    /// v^(1/5) at the dry speed in use, (m/s)^(1/5)
    pub dry_root: f64,
    /// 4/St
    pub over_stokes: f64,
    /// share that no parameter moves, and v times its slope in v
    pub fixed: [f64; 2],
}

impl Fixed {
    /// The share at an impact speed, m/s, and v times its slope in v.
    pub fn at(&self, impact_speed: f64) -> [f64; 2] {
        let (first, second) = (
            self.over_speed / impact_speed,
            self.over_square / (impact_speed * impact_speed),
        );
        [first + second, -first - 2.0 * second]
    }
}

impl Impact {
    /// An impact at `impact_speed`, m/s, as a balance of this form reads it.
    pub fn new(setting: &Setting, form: Form, impact_speed: f64) -> Impact {
        Impact {
            dry_root: form.dry_root(speed_root(impact_speed)),
            over_stokes: slope_lubrication_log(setting.stokes(impact_speed)),
            fixed: form.fixed(setting).map_or([0.0; 2], |fixed| fixed.at(impact_speed)),
        }
    }

    /// The same impact at so many times its speed, and at a dry speed whose fifth root is so many times as large.
    #[inline(always)]
    pub fn at_speed_ratio(&self, ratio: f64, root: f64) -> Impact {
        let inverse = 1.0 / ratio;
        let [share, slope] = self.fixed;
        // of c₁/v + c₂/v² the slope is −c₁/v − 2 c₂/v²
        let (first, second) = ((2.0 * share + slope) * inverse, -(share + slope) * inverse * inverse);
        Impact {
            dry_root: self.dry_root * root,
            over_stokes: self.over_stokes * inverse,
            fixed: [first + second, -first - 2.0 * second],
        }
    }
}

/// What parameters move of the losses at one setting: constant + over_stokes · 4/St.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lost {
    /// share of the impact energy, whatever the speed
    pub constant: f64,
    /// share over 4/St
    pub over_stokes: f64,
}

impl Lost {
    fn of(share: Share, density_ratio: f64) -> Lost {
        Lost {
            constant: density_ratio * share.inertial,
            over_stokes: share.viscous,
        }
    }

    /// Slope of r at an impact, where this is the slope of the losses.
    #[inline(always)]
    pub fn slope_of_kept(&self, at: &Impact) -> f64 {
        -self.constant - self.over_stokes * at.over_stokes
    }
}

/// The energy balance of one particle, density ratio and film at fixed parameters: r = e_dry² − lost − fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// order of the dry law
    pub order: Order,
    /// k, (m/s)^(-1/5)
    pub dry_k: f64,
    /// whether e_dry is that of the run's own speed
    pub own_speed: bool,
    /// the losses that parameters move
    pub lost: Lost,
}

/// What losses take together at one film ratio, and the slopes of that in the shared parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BalanceAtFilm {
    /// their sum
    pub share: Share,
    /// in the order of [`Coefficient::ALL`], nothing in those that no loss of the form has: without gaps, since this is
    /// made for every film at every step of a sampler
    pub slopes: [Share; Coefficient::COUNT],
}

impl BalanceAtFilm {
    /// Those of a form.
    #[inline]
    pub fn new(form: Form, film_ratio: f64, values: &Coefficients) -> BalanceAtFilm {
        let mut all = BalanceAtFilm::default();
        for one in form.at(film_ratio, values) {
            all.share = all.share + one.share;
            for Slope { of, share } in one.slopes.into_iter().flatten() {
                all.slopes[of as usize] = share;
            }
        }
        all
    }

    /// The slopes of the losses at a density ratio, in the order of [`Form::coefficients`].
    pub fn lost_slopes<'f>(&'f self, form: &'f Form, density_ratio: f64) -> impl Iterator<Item = Lost> + 'f {
        form.coefficients()
            .map(move |of| Lost::of(self.slopes[of as usize], density_ratio))
    }
}

impl Balance {
    /// The balance of a particle with this k where losses take so much.
    #[inline]
    pub fn at(form: Form, dry_k: f64, share: Share, density_ratio: f64) -> Balance {
        Balance {
            order: form.dry,
            dry_k,
            own_speed: form.dry_speed == DrySpeed::Impact,
            lost: Lost::of(share, density_ratio),
        }
    }

    /// The balance at a film.
    #[inline]
    pub fn new(form: Form, film: Film, parameters: &Parameters) -> Balance {
        let at_film = BalanceAtFilm::new(form, film.film_ratio, &parameters.shared);
        Balance::at(form, parameters.dry_k, at_film.share, film.density_ratio)
    }

    /// The same with so much more of the energy kept, whatever the speed.
    #[inline]
    pub fn with_offset(mut self, offset: f64) -> Balance {
        self.lost.constant -= offset;
        self
    }

    /// The same with the dry law of this order.
    #[inline(always)]
    pub fn of_order(&self, order: Order) -> Balance {
        Balance { order, ..*self }
    }

    /// That of a dry impact: no loss beside e_dry², at the run's own speed.
    pub fn dry(order: Order, dry_k: f64) -> Balance {
        Balance {
            order,
            dry_k,
            own_speed: true,
            lost: Lost::default(),
        }
    }

    /// e_dry and its first and second slope in k.
    #[inline(always)]
    pub fn e_dry(&self, dry_root: f64) -> [f64; 3] {
        let [e_dry, slope, bend] = self.order.of_loss(self.dry_k * dry_root);
        [e_dry, slope * dry_root, bend * dry_root * dry_root]
    }

    /// r, the share of the energy kept, and its slope in k; r is negative where the impact cannot rebound.
    #[inline(always)]
    pub fn kept(&self, at: &Impact) -> (f64, f64) {
        let [e_dry, slope, _] = self.e_dry(at.dry_root);
        let lost = self.lost.constant + self.lost.over_stokes * at.over_stokes + at.fixed[0];
        (e_dry * e_dry - lost, 2.0 * e_dry * slope)
    }

    /// The same impact at so many times its speed.
    #[inline]
    pub fn at_speed_ratio(&self, at: &Impact, ratio: f64) -> Impact {
        let mut there = at.at_speed_ratio(ratio, 1.0);
        if self.own_speed {
            there.dry_root *= speed_root(ratio);
        }
        there
    }

    /// v dr/dv and v² d²r/dv².
    pub fn in_log_speed(&self, at: &Impact) -> [f64; 2] {
        let viscous = self.lost.over_stokes * at.over_stokes;
        let [share, slope] = at.fixed;
        // of c₁/v + c₂/v² the second is 2 c₁/v + 6 c₂/v²
        let losses = [viscous - slope, 4.0 * slope + 2.0 * share - 2.0 * viscous];
        if !self.own_speed {
            return losses;
        }
        let [first, second] = self.order.square_in_log_speed(self.dry_k * at.dry_root);
        [losses[0] + first, losses[1] + second]
    }

    /// Slope of v dr/dv in k.
    pub fn in_log_speed_slope_k(&self, at: &Impact) -> f64 {
        if !self.own_speed {
            return 0.0;
        }
        let [e_dry, slope, bend] = self.e_dry(at.dry_root);
        // v d/dv is a fifth of k d/dk
        0.4 * (e_dry * slope + self.dry_k * (slope * slope + e_dry * bend))
    }

    /// e_inf², what an impact of infinite St keeps, with e_dry at `dry_speed`, m/s; and its slope in k. Not positive where
    /// there is no e_inf.
    pub fn e_inf_squared(&self, dry_speed: f64) -> (f64, f64) {
        self.kept(&Impact {
            dry_root: speed_root(dry_speed),
            over_stokes: 0.0,
            fixed: [0.0; 2],
        })
    }

    /// e_inf; NaN where there is none.
    pub fn e_inf(&self, dry_speed: f64) -> f64 {
        let (square, _) = self.e_inf_squared(dry_speed);
        if square > 0.0 {
            square.sqrt()
        } else {
            f64::NAN
        }
    }
}

/// Slopes of the energy kept in k and in each shared parameter, zero in those that the form lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gradient {
    /// dr/dk
    pub dry_k: f64,
    /// in the order of [`Coefficient::ALL`]
    pub shared: [f64; Coefficient::COUNT],
}

/// Share of the impact energy a wet impact keeps, r; negative where it cannot rebound.
///
/// `impact_speed` in m/s. Valid for normal impact, 0 < δ̃ ≤ 0.5 and e_dry > 0. Sources: eqs. enEdis2, visc, Eint1,
/// Eint2; the saturating form is empirical; the bridge is [`bridge`](super::bridge)'s.
pub fn kept_energy(setting: &Setting, form: Form, parameters: &Parameters, impact_speed: f64) -> f64 {
    let balance = Balance::new(form, setting.of_film(), parameters);
    balance.kept(&Impact::new(setting, form, impact_speed)).0
}

/// Slopes of [`kept_energy`] in the parameters.
pub fn kept_energy_slopes(setting: &Setting, form: Form, parameters: &Parameters, impact_speed: f64) -> Gradient {
    let at_film = BalanceAtFilm::new(form, setting.film_ratio(), &parameters.shared);
    let balance = Balance::at(form, parameters.dry_k, at_film.share, setting.density_ratio());
    let at = Impact::new(setting, form, impact_speed);
    let mut shared = [0.0; Coefficient::COUNT];
    for (slope, share) in shared.iter_mut().zip(at_film.slopes) {
        *slope = Lost::of(share, setting.density_ratio()).slope_of_kept(&at);
    }
    Gradient {
        dry_k: balance.kept(&at).1,
        shared,
    }
}

#[cfg(test)]
mod tests {
    use super::super::bridge;
    use super::super::form::Term;
    use super::super::inertia::Inertia;
    use super::super::tests::{every_form, parameters, SETTING};
    use super::*;

    #[test]
    fn slopes_in_the_speed_agree_with_differences() {
        let h = 1e-6;
        let film = SETTING.of_film();
        for form in every_form() {
            let at = |k: f64, v: f64| {
                let balance = Balance::new(
                    form,
                    film,
                    &Parameters {
                        dry_k: k,
                        ..parameters()
                    },
                );
                let impact = Impact::new(&SETTING, form, v);
                let second = (balance.in_log_speed(&impact), balance.in_log_speed_slope_k(&impact));
                (balance.kept(&impact).0, second.0[0], second.0[1], second.1)
            };
            let v: f64 = 1.37;
            let (_, slope, bend, of_k) = at(0.183, v);
            let difference = (at(0.183, v * (1.0 + h)).0 - at(0.183, v * (1.0 - h)).0) / (2.0 * h);
            assert!((difference - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{form:?}");
            // v d/dv of v r′ is v r′ + v² r″
            let difference = (at(0.183, v * (1.0 + h)).1 - at(0.183, v * (1.0 - h)).1) / (2.0 * h);
            assert!(
                (difference - slope - bend).abs() < 1e-6 * (1.0 + bend.abs()),
                "{form:?}"
            );
            let difference = (at(0.183 + h, v).1 - at(0.183 - h, v).1) / (2.0 * h);
            assert!((difference - of_k).abs() < 1e-6 * (1.0 + of_k.abs()), "{form:?}");
        }
    }

    #[test]
    fn a_parameter_belongs_to_the_term_that_brings_it() {
        for form in every_form() {
            for coefficient in Coefficient::ALL {
                let mut owners = Term::ALL.into_iter().filter(|term| term.owns(coefficient, form));
                let owner = owners.next();
                assert_eq!(
                    owner.is_some_and(|term| term.is_held(form)),
                    form.has(coefficient),
                    "{form:?}"
                );
                assert_eq!(owners.next(), None, "{form:?} {coefficient:?}");
            }
            let usual = Form {
                viscous: form.viscous,
                ..Form::new(form.inertia, form.dry_speed)
            };
            assert_eq!(usual.with_terms(&form.terms()), form);
        }
    }

    /// The bridge takes κ/v² and no more, and only where the liquid's surface tension is known.
    #[test]
    fn the_bridge_takes_its_share() {
        let plain = Form::new(Inertia::Stepwise, DrySpeed::Reference(2.0));
        let form = Term::Bridge.toggled(plain);
        let taken = |setting: &Setting, v| {
            kept_energy(setting, plain, &parameters(), v) - kept_energy(setting, form, &parameters(), v)
        };
        let share = {
            let kappa = bridge::kappa(20.1e-3, SETTING.density, SETTING.diameter, SETTING.film);
            bridge::loss(kappa, 0.4)
        };
        assert!(share > 1e-4 && (taken(&SETTING, 0.4) - share).abs() < 1e-15);
        let unknown = Setting {
            surface_tension: None,
            ..SETTING
        };
        assert_eq!(taken(&unknown, 0.4), 0.0);
    }
}
