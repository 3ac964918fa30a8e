//! Computes the fifth root of a speed, faster than a power does.
//!
//! Only [`Restitution`](super::Restitution), which a simulation calls at every collision, takes its root here: most of its
//! time would go into `powf`. What is fitted goes through [`speed_root`](super::dry::speed_root), so that no fitted
//! number depends on the last bit of this one.

/// Parts of 1 ≤ m < 2 that have a row of the table: with so many |s| < 1/256.
const PARTS: usize = 128;

/// For each part r, near the root of its middle, and c = r⁻⁵.
static OF_MANTISSA: [[f64; 2]; PARTS] = {
    let mut table = [[0.0; 2]; PARTS];
    let mut part = 0;
    while part < PARTS {
        // of few digits, so that c is as good as exact
        let r = by_newton(1.0 + (part as f64 + 0.5) / PARTS as f64) as f32 as f64;
        let fourth = (r * r) * (r * r);
        table[part] = [r, 1.0 / (fourth * r)];
        part += 1;
    }
    table
};

/// The fifth root of a number from 1 to 2, in more steps than it takes.
const fn by_newton(x: f64) -> f64 {
    let mut root = 1.0;
    let mut step = 0;
    while step < 8 {
        let fourth = (root * root) * (root * root);
        root += (x - fourth * root) / (5.0 * fourth);
        step += 1;
    }
    root
}

/// 2^(n/5) for each exponent n, which a number holds 1023 too high.
static OF_EXPONENT: [f64; 2048] = {
    const OF_REST: [f64; 5] = [
        1.0,
        1.148_698_354_997_035,
        1.319_507_910_772_894_2,
        1.515_716_566_510_398_2,
        1.741_101_126_592_248_2,
    ];
    let mut table = [0.0; 2048];
    let mut held = 0;
    while held < 2048 {
        // 1023 and 2 are 5 · 205
        let whole = (held as u64 + 2) / 5;
        table[held] = OF_REST[(held + 2) % 5] * f64::from_bits((1023 - 205 + whole) << 52);
        held += 1;
    }
    table
};

/// v^(1/5) of a finite number above zero, to 2 units in the last place; below the smallest normal number, and of 0, only
/// to 1e-61; of anything else any number.
///
/// With v = 2^n m, 1 ≤ m < 2, r about m^(1/5) and c = r⁻⁵, v^(1/5) = 2^(n/5) r (1 + s)^(1/5) with s = c m − 1. The
/// first two stand in tables, of which the speeds of a simulation read a few lines, and the last is a short series, into
/// which an error of s enters by a fifth.
///
/// ```
/// # use wetcor::physics::fifth_root::fifth_root;
/// assert!((fifth_root(243.0) - 3.0).abs() < 1e-15);
/// ```
#[inline(always)]
pub fn fifth_root(v: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    const ONE: u64 = 1023 << 52;
    let bits = v.to_bits();
    let m = f64::from_bits(bits & MANTISSA | ONE);
    let [r, c] = OF_MANTISSA[(bits >> 45) as usize % PARTS];
    let root = r * OF_EXPONENT[(bits >> 52) as usize % 2048];
    let s = c * m - 1.0;
    let s2 = s * s;
    // the binomial series of (1 + s)^(1/5), less 1 and over s; s⁶ is below 1e-16 of it
    let series = (0.2 - 0.08 * s) + s2 * ((0.048 - 0.033_6 * s) + 0.025_536 * s2);
    root + root * s * series
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::dry::speed_root;

    /// Units in the last place between this root and the power.
    fn apart(v: f64) -> u64 {
        let power = speed_root(v);
        // 1/5 as a double is 2^-54/5 too large, which moves the power by up to 1e-14 of it
        let too_large = 0.2 * 2f64.powi(-54);
        let exact = power - power * (too_large * v.ln());
        fifth_root(v).to_bits().abs_diff(exact.to_bits())
    }

    #[test]
    fn it_is_the_power_to_two_units_in_the_last_place() {
        // every exponent, with mantissas that no two share
        const EACH: u32 = 200;
        let golden = 0.618_033_988_749_894_9;
        let mut most = 0;
        for exponent in 0..2046 {
            for step in 0..EACH {
                let mantissa = 1.0 + (golden * f64::from(exponent * EACH + step)).fract();
                most = most.max(apart(mantissa * 2f64.powi(exponent as i32 - 1022)));
            }
        }
        assert!((1..=2).contains(&most), "{most}");
        for v in [f64::MAX, f64::MIN_POSITIVE, 1.0, 1.0f64.next_down(), 32f64.next_down()] {
            assert!(apart(v) <= 2, "{v}");
        }
        for v in [0.0, f64::from_bits(1), 1e-310, f64::MIN_POSITIVE.next_down()] {
            assert!((fifth_root(v) - speed_root(v)).abs() < 1e-61, "{v}");
        }
    }

    #[test]
    fn the_roots_of_fifth_powers_are_whole() {
        for root in 1..1500u64 {
            let v = (root * root * root * root * root) as f64;
            assert!((fifth_root(v) / root as f64 - 1.0).abs() < 4.5e-16, "{root}");
        }
    }
}
