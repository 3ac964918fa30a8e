//! Computes the energy kept, the dry law and the mean restitution at a setting, with their slopes.

use super::errors::Errors;
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::physics::rebound::TURN;

/// What of a node the energy kept depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Abscissa {
    /// x
    pub(super) viscous: f64,
    /// p
    pub(super) dry_power: f64,
    /// b; `None` where the form holds no bridge
    pub(super) bridge: Option<f64>,
}

/// What of the parameters the energy kept in a block depends on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Law {
    pub(super) order: Order,
    /// whether e_dry is that of the run's own speed
    pub(super) own_speed: bool,
    pub(super) k: f64,
    /// C ρ̃ g(δ̃)
    pub(super) inertial: f64,
    pub(super) l: f64,
}

impl Law {
    /// That of a dry run, but for its k.
    pub(super) const DRY: Law = Law {
        order: Order::First,
        own_speed: true,
        k: f64::NAN,
        inertial: 0.0,
        l: 0.0,
    };

    /// r, and its slope in k over −2: e_dry times that of −e_dry.
    #[inline]
    pub(super) fn kept(&self, at: &Abscissa) -> (f64, f64) {
        let (e_dry, fall) = e_dry(self.order, self.k, at.dry_power);
        let lost = self.inertial + self.l * at.viscous + at.bridge.unwrap_or(0.0);
        (e_dry * e_dry - lost, e_dry * fall)
    }

    /// e_dry, its slope in −k, and that slope's slope in k.
    #[inline]
    pub(super) fn dry(&self, p: f64) -> (f64, f64, f64) {
        let (e_dry, fall) = e_dry(self.order, self.k, p);
        let bend = match self.order {
            Order::First => 0.0,
            Order::Second => -2.0 * SECOND_ORDER * p * p,
        };
        (e_dry, fall, bend)
    }

    /// dr/dv at a slowness 1/v, and its slope in k; with p ∝ v^(1/5), x ∝ 1/v and b ∝ 1/v².
    #[inline]
    pub(super) fn by_speed(&self, at: &Abscissa, slowness: f64) -> (f64, f64) {
        let viscous = self.l * at.viscous + 2.0 * at.bridge.unwrap_or(0.0);
        if !self.own_speed {
            return (viscous * slowness, 0.0);
        }
        let (e_dry, fall, bend) = self.dry(at.dry_power);
        let dry = -0.4 * e_dry * fall * self.k;
        let of_k = -0.4 * (e_dry * fall + self.k * (e_dry * bend - fall * fall));
        ((viscous + dry) * slowness, of_k * slowness)
    }

    /// r and dr/dv; the second 0 for a run whose speed does not err.
    #[inline]
    pub(super) fn kept_and_by_speed(&self, at: &Abscissa, errors: Errors) -> (f64, f64) {
        let by_speed = if errors.speed > 0.0 {
            self.by_speed(at, errors.slowness).0
        } else {
            0.0
        };
        (self.kept(at).0, by_speed)
    }
}

/// e_dry and its slope in −k.
#[inline(always)]
pub(super) fn e_dry(order: Order, k: f64, p: f64) -> (f64, f64) {
    match order {
        Order::First => (1.0 - k * p, p),
        Order::Second => {
            let bent = SECOND_ORDER * k * p;
            (1.0 - k * p * (1.0 - bent), p * (1.0 - 2.0 * bent))
        }
    }
}

/// m(r) and m′(r) with two roots and one division.
#[inline(always)]
pub(super) fn mean_and_slope(kept: f64) -> (f64, f64) {
    const TURN4: f64 = TURN * TURN * TURN * TURN;
    let square = kept * kept + TURN4;
    let inverse = 1.0 / (square * square.sqrt().sqrt());
    (kept * square * inverse, (0.5 * kept * kept + TURN4) * inverse)
}
