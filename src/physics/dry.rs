//! Computes the restitution of a dry impact and its slopes.
//!
//! Symbols: k `dry_k` in (m/s)^(-1/5), v impact speed in m/s, e_dry dimensionless.

use super::coefficient::{LogNormal, Parameter};

/// k, one for each particle.
pub const DRY_K: Parameter = Parameter {
    name: "dry_k",
    symbol: "k",
    words: "k",
    meaning: "k of the dry law e_dry = 1 − k v^(1/5), in (m/s)^(-1/5)",
    example: "0.15",
    unit: "(m/s)^(-1/5)",
    grid: &[],
    must_be_positive: true,
    in_logarithm: false,
    may_be_zero: false,
    prior: LogNormal {
        median: 0.15,
        ln_sd: 0.5,
        reason: "default: 0.123 and 0.183 were measured for two plastics, a factor 2.7 either way holds 95 %",
    },
};

/// Speed at which e_inf and St_c are quoted unless a scene names another, m/s (upper end of the paper's dry runs).
pub const REFERENCE_SPEED: f64 = 2.0;

/// Power of the speed in the loss of a dry impact.
pub const POWER: f64 = 0.2;

/// Coefficient of the second-order term, in units of k²: C₂/C₁² = 0.79826/1.15344² = 3/5.
///
/// Source: Ramírez, Pöschel, Brilliantov & Schwager 1999, Phys. Rev. E 60, 4465.
pub const SECOND_ORDER: f64 = 3.0 / 5.0;

/// v^(1/5) of an impact speed, (m/s)^(1/5): what the dry law reads of it.
pub fn speed_root(impact_speed: f64) -> f64 {
    impact_speed.powf(POWER)
}

/// Order to which the dry law is taken: e_dry = 1 − k v^(1/5), with + (3/5) k² v^(2/5) to second order.
///
/// Source: Müller & Huang 2016, text above eq. envi, after Brilliantov & Pöschel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// valid where it is positive, v < k⁻⁵; beyond, e_dry is negative and its square grows again
    First,
    /// valid for k v^(1/5) well below one: its minimum is at k v^(1/5) = 5/6
    Second,
}

impl Order {
    /// e_dry at z = k v^(1/5) with its first and second derivative in z.
    #[inline(always)]
    pub fn of_loss(self, z: f64) -> [f64; 3] {
        match self {
            Order::First => [1.0 - z, -1.0, 0.0],
            Order::Second => {
                let bent = SECOND_ORDER * z;
                [(1.0 - z) + bent * z, 2.0 * bent - 1.0, 2.0 * SECOND_ORDER]
            }
        }
    }

    /// e_dry.
    pub fn restitution(self, dry_k: f64, impact_speed: f64) -> f64 {
        self.of_loss(dry_k * speed_root(impact_speed))[0]
    }

    /// Slope of e_dry with respect to k.
    pub fn slope_dry_k(self, dry_k: f64, impact_speed: f64) -> f64 {
        let root = speed_root(impact_speed);
        root * self.of_loss(dry_k * root)[1]
    }

    /// Slope of e_dry with respect to v, s/m.
    pub fn slope_impact_speed(self, dry_k: f64, impact_speed: f64) -> f64 {
        self.in_log_speed(dry_k * speed_root(impact_speed))[0] / impact_speed
    }

    /// The next power of the speed, which the law does not have: (v^(1/5))² or its cube.
    pub fn next_power(self, impact_speed: f64) -> f64 {
        let root = speed_root(impact_speed);
        match self {
            Order::First => root * root,
            Order::Second => root * root * root,
        }
    }

    /// v de/dv and v² d²e/dv² of e_dry at z = k v^(1/5).
    pub fn in_log_speed(self, z: f64) -> [f64; 2] {
        // with v dz/dv = z/5 and v² d²z/dv² = −4 z/25
        let [_, first, second] = self.of_loss(z);
        let slope = POWER * z;
        [first * slope, second * slope * slope + first * (POWER - 1.0) * slope]
    }

    /// The same of e_dry².
    #[inline]
    pub fn square_in_log_speed(self, z: f64) -> [f64; 2] {
        let e_dry = self.of_loss(z)[0];
        let [first, second] = self.in_log_speed(z);
        [2.0 * e_dry * first, 2.0 * (first * first + e_dry * second)]
    }

    /// k v^(1/5) up to which e_dry is positive and falls: 1, and 5/6, where the second order has its minimum.
    pub fn largest_loss(self) -> f64 {
        match self {
            Order::First => 1.0,
            Order::Second => 0.5 / SECOND_ORDER,
        }
    }

    /// Speed at which [`Order::largest_loss`] is reached, m/s. Infinite for k ≤ 0.
    pub fn speed_limit(self, dry_k: f64) -> f64 {
        let k = dry_k / self.largest_loss();
        if k > 0.0 {
            k.powi(-5)
        } else {
            f64::INFINITY
        }
    }

    /// Its number: the power of k it goes to.
    pub fn number(self) -> u8 {
        match self {
            Order::First => 1,
            Order::Second => 2,
        }
    }

    /// The law as a formula of a speed called `v`.
    pub fn formula(self, v: &str) -> String {
        match self {
            Order::First => format!("1 − k {v}^(1/5)"),
            Order::Second => format!("1 − k {v}^(1/5) + (3/5) k² {v}^(2/5)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second order never reaches zero: it turns at its limit, which comes before the first order's.
    #[test]
    fn the_second_order_turns_at_its_limit() {
        let k: f64 = 0.8;
        let law = Order::Second;
        let limit = law.speed_limit(k);
        assert!((k * limit.powf(0.2) - 5.0 / 6.0).abs() < 1e-14 && limit < Order::First.speed_limit(k));
        assert!(law.slope_impact_speed(k, limit).abs() < 1e-14);
        assert!(law.restitution(k, limit) < law.restitution(k, 1.01 * limit));
        assert!(law.restitution(k, limit) < law.restitution(k, 0.99 * limit));
    }

    #[test]
    fn the_second_order_coefficient_is_the_published_one() {
        assert!((SECOND_ORDER - 0.79826 / (1.15344f64 * 1.15344)).abs() < 1e-5);
    }
}
