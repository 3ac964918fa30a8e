//! Computes the restitution of a dry impact and its slopes.
//!
//! Symbols: k `dry_k` in (m/s)^(-1/5), v impact speed in m/s, e_dry dimensionless.

/// First-order viscoelastic law, e_dry = 1 − k v^(1/5).
///
/// Valid where it is positive, v < k⁻⁵ ([`speed_limit`]); beyond, e_dry is negative and its square grows again.
/// Source: Müller & Huang 2016, text above eq. envi, after Brilliantov & Pöschel.
pub fn restitution(dry_k: f64, impact_speed: f64) -> f64 {
    1.0 - dry_k * impact_speed.powf(0.2)
}

/// Slope of [`restitution`] with respect to k: −v^(1/5).
pub fn slope_dry_k(impact_speed: f64) -> f64 {
    -impact_speed.powf(0.2)
}

/// Slope of [`restitution`] with respect to v, s/m.
pub fn slope_impact_speed(dry_k: f64, impact_speed: f64) -> f64 {
    // not v^(-0.8): the rounding of an exponent counts ln v times
    -0.2 * dry_k * impact_speed.powf(0.2) / impact_speed
}

/// Coefficient of the second-order term, in units of k²: C₂/C₁² = 0.79826/1.15344² = 3/5.
///
/// Source: Ramírez, Pöschel, Brilliantov & Schwager 1999, Phys. Rev. E 60, 4465.
pub const SECOND_ORDER: f64 = 3.0 / 5.0;

/// Second-order viscoelastic law, 1 − k v^(1/5) + (3/5) k² v^(2/5).
///
/// Valid for k v^(1/5) well below one: its minimum is at k v^(1/5) = 5/6.
pub fn restitution_second_order(dry_k: f64, impact_speed: f64) -> f64 {
    let first = dry_k * impact_speed.powf(0.2);
    1.0 - first + SECOND_ORDER * first * first
}

/// Slope of [`restitution_second_order`] with respect to k.
pub fn slope_dry_k_second_order(dry_k: f64, impact_speed: f64) -> f64 {
    let root = impact_speed.powf(0.2);
    -root + 2.0 * SECOND_ORDER * dry_k * root * root
}

/// Order to which the dry law is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// [`restitution`]
    First,
    /// [`restitution_second_order`]
    Second,
}

impl Order {
    /// e_dry.
    pub fn restitution(self, dry_k: f64, impact_speed: f64) -> f64 {
        match self {
            Order::First => restitution(dry_k, impact_speed),
            Order::Second => restitution_second_order(dry_k, impact_speed),
        }
    }

    /// Slope of e_dry with respect to k.
    pub fn slope_dry_k(self, dry_k: f64, impact_speed: f64) -> f64 {
        match self {
            Order::First => slope_dry_k(impact_speed),
            Order::Second => slope_dry_k_second_order(dry_k, impact_speed),
        }
    }

    /// Slope of e_dry with respect to v, s/m.
    pub fn slope_impact_speed(self, dry_k: f64, impact_speed: f64) -> f64 {
        let first = slope_impact_speed(dry_k, impact_speed);
        match self {
            Order::First => first,
            Order::Second => first * (1.0 - 2.0 * SECOND_ORDER * dry_k * impact_speed.powf(0.2)),
        }
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
        match self {
            Order::First => speed_limit(dry_k),
            Order::Second => speed_limit(dry_k / self.largest_loss()),
        }
    }
}

/// Speed at which the first-order law reaches zero, v = k⁻⁵, m/s. Infinite for k ≤ 0.
pub fn speed_limit(dry_k: f64) -> f64 {
    if dry_k > 0.0 {
        dry_k.powi(-5)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_agree_with_differences() {
        for (k, v) in [(0.183, 0.77), (0.123, 1.9), (0.31, 3.3)] {
            let h = 1e-6;
            let dk = (restitution(k + h, v) - restitution(k - h, v)) / (2.0 * h);
            assert!((dk / slope_dry_k(v) - 1.0).abs() < 1e-6);
            let dv = (restitution(k, v + h) - restitution(k, v - h)) / (2.0 * h);
            assert!((dv / slope_impact_speed(k, v) - 1.0).abs() < 1e-6);
            let d2 = (restitution_second_order(k + h, v) - restitution_second_order(k - h, v)) / (2.0 * h);
            assert!((d2 / slope_dry_k_second_order(k, v) - 1.0).abs() < 1e-6);
            for order in [Order::First, Order::Second] {
                let of_speed = (order.restitution(k, v + h) - order.restitution(k, v - h)) / (2.0 * h);
                assert!((of_speed / order.slope_impact_speed(k, v) - 1.0).abs() < 1e-6);
            }
        }
    }

    /// Slip 3 of the paper: beyond v = k⁻⁵ the law is negative and its square grows again.
    #[test]
    fn the_law_turns_negative_beyond_its_speed_limit() {
        let k: f64 = 0.8;
        let limit = speed_limit(k);
        assert!(restitution(k, limit).abs() < 1e-15);
        assert!(restitution(k, 0.99 * limit) > 0.0);
        assert!(restitution(k, 1.01 * limit) < 0.0);
        let squared = |v: f64| restitution(k, v).powi(2);
        assert!(squared(2.0 * limit) > squared(1.5 * limit));
        assert!(speed_limit(0.183) > 2.0 && speed_limit(0.0).is_infinite());
    }

    /// The second order never reaches zero: it turns at its limit, which comes before the first order's.
    #[test]
    fn the_second_order_turns_at_its_limit() {
        let k: f64 = 0.8;
        let limit = Order::Second.speed_limit(k);
        assert!((k * limit.powf(0.2) - 5.0 / 6.0).abs() < 1e-14 && limit < speed_limit(k));
        assert!(Order::Second.slope_impact_speed(k, limit).abs() < 1e-14);
        assert!(restitution_second_order(k, limit) < restitution_second_order(k, 1.01 * limit));
        assert!(restitution_second_order(k, limit) < restitution_second_order(k, 0.99 * limit));
    }

    /// Slip 5 of the paper: e_dry² at the run's own speed is not e_dry² at 2 m/s.
    #[test]
    fn the_dry_speed_moves_the_energy_kept_by_up_to_six_hundredths() {
        let k = 0.183;
        let own = restitution(k, super::super::numbers::free_fall_speed(0.03));
        let reference = restitution(k, 2.0);
        let moved = own * own - reference * reference;
        assert!((moved - 0.06).abs() < 0.002, "{moved}");
    }

    #[test]
    fn the_second_order_coefficient_is_the_published_one() {
        assert!((SECOND_ORDER - 0.79826 / (1.15344f64 * 1.15344)).abs() < 1e-5);
    }
}
