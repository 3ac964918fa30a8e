//! Computes exponentials that a loop may take several at a time.
//!
//! The library's own is a call a number. This one has no branch and no call, so that where it stands in a loop that is
//! compiled for wide registers, as [`pulp::Arch::dispatch`] does, these are filled.

/// exp(x) for x up to 700, to 1e-13 of it; below −700, and of NaN, that of −700.
#[inline(always)]
pub fn exponential(x: f64) -> f64 {
    /// adding it rounds to a whole number, which its last bits then hold
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN_2_HEAD: f64 = 6.931_471_803_691_238e-1;
    const LN_2_REST: f64 = 1.908_214_929_270_587_7e-10;
    let x = x.max(-700.0);
    let rounded = x * std::f64::consts::LOG2_E + ROUND;
    let n = rounded - ROUND;
    let f = x - n * LN_2_HEAD - n * LN_2_REST;
    // Taylor's series to the eleventh power: |f| is at most half of ln 2
    let mut series = 1.0 / 39_916_800.0;
    for term in [
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ] {
        series = series * f + term;
    }
    let power = (rounded.to_bits() << 52).wrapping_add(1023 << 52);
    series * f64::from_bits(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_librarys() {
        for step in 0..280_000 {
            let x = -700.0 + 0.005 * f64::from(step);
            let gap = exponential(x) / x.exp() - 1.0;
            assert!(gap.abs() < 1e-13, "{x}: {gap:e}");
        }
        assert_eq!(exponential(-1e300), exponential(-700.0));
        assert_eq!(exponential(f64::NAN), exponential(-700.0));
    }
}
