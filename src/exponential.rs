//! Computes exponentials and logarithms that a loop may take several at a time.
//!
//! The library's own are a call a number. These have no branch and no call, so that where they stand in a loop that is
//! compiled for wide registers, as [`pulp::Arch::dispatch`] does, these are filled.

/// exp(x) for x up to 700, to 1e-14 of it; below −700, that of −700.
///
/// `fused`, a constant where this stands, says whether the code is made for registers that multiply and add at once.
#[cfg(feature = "cli")]
#[inline(always)]
pub fn exponential(x: f64, fused: bool) -> f64 {
    exponential_and_less_one(x, fused)[0]
}

/// exp(x) and exp(x) − 1, the latter as exact for small x as for large.
#[inline(always)]
pub fn exponential_and_less_one(x: f64, fused: bool) -> [f64; 2] {
    /// adding it rounds to a whole number, which its last bits then hold
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN_2_HEAD: f64 = 6.931_471_803_691_238e-1;
    const LN_2_REST: f64 = 1.908_214_929_270_587_7e-10;
    let times_plus = |a: f64, b: f64, c: f64| if fused { a.mul_add(b, c) } else { a * b + c };
    // a NaN remains one
    let x = if x < -700.0 { -700.0 } else { x };
    let rounded = times_plus(x, std::f64::consts::LOG2_E, ROUND);
    let n = rounded - ROUND;
    let f = times_plus(n, -LN_2_REST, times_plus(n, -LN_2_HEAD, x));
    // 1 + f + f² q(f), q through exp at Chebyshev's nodes of |f| ≤ ½ ln 2: off by 1.2e-15 at most
    let mut series = 2.761_380_686_153_829e-7;
    for term in [
        2.762_511_557_828_763e-6,
        2.480_153_638_869_076_6e-5,
        1.984_120_873_253_638_4e-4,
        1.388_888_890_588_154_2e-3,
        8.333_333_353_729_397e-3,
        4.166_666_666_665_136e-2,
        1.666_666_666_666_482_9e-1,
        0.5,
    ] {
        series = times_plus(series, f, term);
    }
    let less_one = times_plus(series * f, f, f);
    let power = f64::from_bits((rounded.to_bits() << 52).wrapping_add(1023 << 52));
    [
        times_plus(power, less_one, power),
        times_plus(power, less_one, power - 1.0),
    ]
}

/// ln(x) of x from 1e-300 to 1e300, to 1e-15 of it.
#[cfg(feature = "cli")]
#[inline(always)]
pub fn logarithm(x: f64, fused: bool) -> f64 {
    const LN_2_HEAD: f64 = 6.931_471_803_691_238e-1;
    const LN_2_REST: f64 = 1.908_214_929_270_587_7e-10;
    /// the bits of about √½, where the mantissa begins
    const LOWEST: u64 = 0x3fe6_a09e << 32;
    const ONE: u64 = 1023 << 52;
    /// a number whose last bits hold a whole number
    const WHOLE: u64 = 0x433 << 52;
    let times_plus = |a: f64, b: f64, c: f64| if fused { a.mul_add(b, c) } else { a * b + c };
    let bits = x.to_bits().wrapping_add(ONE - LOWEST);
    let n = f64::from_bits((bits >> 52) | WHOLE) - (f64::from_bits(WHOLE) + 1023.0);
    let more = f64::from_bits((bits & ((1 << 52) - 1)).wrapping_add(LOWEST)) - 1.0;
    // ln(1 + f) = 2 artanh s with s = f/(2 + f), |s| ≤ 0.172
    let s = more / (2.0 + more);
    let square = s * s;
    let mut series = 2.0 / 21.0;
    for odd in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = times_plus(series, square, 2.0 / odd);
    }
    // 2 s = f − s f
    let rest = times_plus(s, times_plus(square, series, -more), n * LN_2_REST);
    times_plus(n, LN_2_HEAD, more + rest)
}

/// Whether code that is made for this register may multiply and add at once.
#[cfg(feature = "cli")]
pub const fn is_fused<S: pulp::Simd>() -> bool {
    // x86 has it where it has registers of four, ARM always
    S::F64_LANES >= 4 || cfg!(target_arch = "aarch64")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_the_librarys() {
        for step in 0..280_000 {
            let x = -700.0 + 0.005 * f64::from(step);
            for found in [exponential(x, false), exponential(x, true)] {
                let gap = found / x.exp() - 1.0;
                assert!(gap.abs() < 1e-14, "{x}: {gap:e}");
            }
        }
        for step in -100..100 {
            let x = 10f64
                .powf(0.3 * f64::from(step))
                .copysign(f64::from(step))
                .clamp(-700.0, 700.0);
            for fused in [false, true] {
                let gap = exponential_and_less_one(x, fused)[1] / x.exp_m1() - 1.0;
                assert!(gap.abs() < 2e-14, "{x}: {gap:e}");
            }
        }
        for step in 0..280_000 {
            let x = (-690.0 + 0.005 * f64::from(step)).min(690.0).exp();
            for x in [x, 1.0 - 0.5 / (1.0 + x), 1.0 + 1e-3 / (1.0 + x)] {
                for found in [logarithm(x, false), logarithm(x, true)] {
                    let gap = found - x.ln();
                    assert!(gap.abs() <= 1e-15 * x.ln().abs(), "{x}: {gap:e}");
                }
            }
        }
        assert_eq!(exponential(-1e300, false), exponential(-700.0, false));
        assert!([false, true]
            .map(|fused| exponential(f64::NAN, fused))
            .iter()
            .all(|x| x.is_nan()));
    }
}
