//! Rounds numbers for print: by their standard error where there is one (PDG rule), by significant digits elsewhere.

/// More decimals than this are noise in f64.
const MOST_DECIMALS: i32 = 17;

/// From here on digits before the point are written as a power of ten.
pub const LARGE: f64 = 1e6;

/// What stands where there is no number.
pub const NONE: &str = "–";

/// Decimal place to which a standard error, and its value with it, is rounded: 2 means hundredths, −1 tens.
///
/// The PDG rule: of the error's three leading digits, 100–354 keeps two digits, 355–949 one, 950–999 becomes 1000 and
/// keeps two.
fn decimals(se: f64) -> i32 {
    let exponent = se.log10().floor() as i32;
    let leading = (se / 10f64.powi(exponent - 2)).round();
    // rounding may carry 999.6 to 1000
    let (leading, exponent) = if leading >= 1000.0 {
        (100.0, exponent + 1)
    } else {
        (leading, exponent)
    };
    if leading < 355.0 {
        1 - exponent
    } else {
        // 950–999 prints as 1000 at the same place, which is its two digits
        -exponent
    }
}

/// A number to a decimal place; what is none is never shown as one.
fn to_place(x: f64, place: i32) -> String {
    if !x.is_finite() {
        return NONE.to_owned();
    }
    if place >= 0 {
        return with_minus(format!("{x:.*}", place.min(MOST_DECIMALS) as usize));
    }
    let unit = 10f64.powi(-place);
    with_minus(format!("{:.0}", (x / unit).round() * unit))
}

/// A number with the minus sign of a text in place of a hyphen.
fn with_minus(number: String) -> String {
    match number.strip_prefix('-') {
        Some(digits) => format!("−{digits}"),
        None => number,
    }
}

/// Beyond this place a value and its standard error are rounded apart: an error so small is that of numbers without scatter.
const MOST_TOGETHER: i32 = 9;

/// A value and its standard error, rounded together.
pub fn rounded(value: f64, se: f64) -> (String, String) {
    if !(se > 0.0 && se.is_finite() && value.is_finite()) {
        return (significant(value, 4), NONE.to_owned());
    }
    let place = decimals(se);
    if place > MOST_TOGETHER {
        return (significant(value, 4), significant(se, 2));
    }
    (to_place(value, place), to_place(se, place))
}

/// `value ± se`, rounded together.
pub fn with_se(value: f64, se: f64) -> String {
    let (value, se) = rounded(value, se);
    format!("{value} ± {se}")
}

/// Two ends of an interval, rounded by a standard error, or by the width where that is less: a few draws far out make an sd
/// that says little of where the others lie. Nothing where there is no standard error.
pub fn between(lo: f64, hi: f64, se: f64) -> String {
    if !(se > 0.0 && se.is_finite() && lo.is_finite() && hi.is_finite()) {
        return NONE.to_owned();
    }
    /// a width that is less of the standard error is none
    const NO_WIDTH: f64 = 1e-3;
    let width = hi - lo;
    let place = decimals(if width > NO_WIDTH * se { se.min(width) } else { se });
    let [lo, hi] = [lo, hi].map(|end| match place > MOST_TOGETHER {
        true => significant(end, 4),
        false => to_place(end, place),
    });
    format!("{lo} to {hi}")
}

/// Decimal place of the last digit worth more than a Monte Carlo error; that of the leading digit of `least` where even
/// that one is not.
fn settled(mcse: f64, least: f64) -> i32 {
    let worth = (-mcse.log10()).ceil() as i32 - 1;
    let leading = -least.abs().log10().floor();
    if leading.is_finite() {
        worth.max(leading as i32)
    } else {
        worth
    }
}

pub fn positive(x: Option<f64>) -> Option<f64> {
    x.filter(|x| *x > 0.0 && x.is_finite())
}

/// A number of a posterior to the last digit that is worth more than its Monte Carlo error, one digit at least.
pub fn by_mcse(value: Option<f64>, mcse: Option<f64>) -> String {
    match (value, positive(mcse)) {
        (Some(value), Some(mcse)) if value.abs() < LARGE => to_place(value, settled(mcse, value)),
        (value, _) => optional(value, 3),
    }
}

/// A mean with the sd of its posterior and its own Monte Carlo error.
pub fn with_sd(mean: f64, sd: f64, mcse: f64) -> String {
    if sd >= LARGE || positive(Some(sd)).is_none() {
        return format!("{} ± {}", significant(mean, 2), significant(sd, 2));
    }
    let place = decimals(sd).min(settled(mcse, sd));
    format!("{} ± {}", to_place(mean, place), to_place(sd, place))
}

/// A value with its error: of a posterior to no digit that its Monte Carlo error leaves open. Without an error that is said.
pub fn with_error(value: Option<f64>, error: Option<f64>, mcse: Option<f64>) -> String {
    match (value, positive(error), positive(mcse)) {
        (Some(mean), Some(sd), Some(mcse)) => with_sd(mean, sd, mcse),
        (Some(value), Some(se), None) => with_se(value, se),
        (Some(value), None, _) => format!("{} (no ±)", significant(value, 4)),
        (None, ..) => NONE.to_owned(),
    }
}

/// The word that agrees with a number of things.
pub fn by_number<W>(count: usize, one: W, more: W) -> W {
    if count == 1 {
        one
    } else {
        more
    }
}

/// A number with the word it counts, as `1 run` and `2 runs` are.
pub fn counted(count: usize, one: &str) -> String {
    format!("{count} {one}{}", by_number(count, "", "s"))
}

/// The number of so many significant digits that is nearest.
pub fn to_digits(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.max(1) - 1).parse().unwrap_or(x)
}

/// A number to some significant digits, without exponent between 1e-4 and 1e6.
pub fn significant(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return NONE.to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    // rounding may carry 0.0999 to 0.100
    let exponent = to_digits(x, digits).abs().log10().floor() as i32;
    if !(-5..6).contains(&exponent) {
        return with_minus(format!("{x:.*e}", digits.max(1) - 1));
    }
    to_place(x, digits.max(1) as i32 - 1 - exponent)
}

/// A number that may be missing, to some significant digits.
pub fn optional(x: Option<f64>, digits: usize) -> String {
    x.map_or_else(|| NONE.to_owned(), |x| significant(x, digits))
}

/// A probability.
pub fn probability(p: f64) -> String {
    if !p.is_finite() {
        NONE.to_owned()
    } else if p < 0.001 {
        "below 0.001".to_owned()
    } else {
        format!("{p:.3}")
    }
}

/// A number with its sign and two decimals.
pub fn signed(x: f64) -> String {
    signed_to(x, 2)
}

/// A shift with its sign, to the place its estimate is rounded to.
pub fn shift(x: f64, se: Option<f64>) -> String {
    signed_to(x, se.filter(|se| *se > 0.0 && se.is_finite()).map_or(4, decimals))
}

/// The same to a decimal place.
pub fn signed_to(x: f64, place: i32) -> String {
    if !x.is_finite() {
        return NONE.to_owned();
    }
    let text = to_place(x.abs(), place);
    let is_zero = text.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    match (is_zero, x < 0.0) {
        (true, _) => text,
        (false, true) => format!("−{text}"),
        (false, false) => format!("+{text}"),
    }
}

/// Smallest and largest, to three significant digits.
pub fn range([lo, hi]: [f64; 2]) -> String {
    let (lo, hi) = (significant(lo, 3), significant(hi, 3));
    if lo == hi {
        lo
    } else {
        format!("{lo} to {hi}")
    }
}

/// A ratio or a length as a file would have it: up to four decimals, no trailing zeros; three digits where four
/// decimals would leave nothing of it, or where it is very large.
pub fn short(x: f64) -> String {
    if x != 0.0 && !(5e-5..1e6).contains(&x.abs()) {
        return significant(x, 3);
    }
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_posteriors_digits_are_those_its_monte_carlo_error_leaves() {
        for (mcse, expected) in [(8.25e-6, "0.18352"), (1e-5, "0.1835"), (1.2e-4, "0.184"), (0.3, "0.2")] {
            assert_eq!(by_mcse(Some(0.183_524_7), Some(mcse)), expected);
        }
        assert_eq!(by_mcse(Some(1234.0), Some(20.0)), "1200");
        assert_eq!(by_mcse(Some(0.0), Some(0.01)), "0.0");
        assert_eq!(by_mcse(Some(0.183_524_7), None), "0.184");
        assert_eq!(by_mcse(None, Some(0.1)), NONE);
        assert_eq!(with_sd(0.183_524_7, 0.001_23, 9e-6), "0.1835 ± 0.0012");
        // a short run settles fewer digits than the sd would show
        assert_eq!(with_sd(0.183_524_7, 0.001_23, 4e-4), "0.184 ± 0.001");
        assert_eq!(with_sd(0.183_524_7, 3.4e9, 1e8), "0.18 ± 3.4e9");
    }

    #[test]
    fn the_ends_of_an_interval_have_the_digits_of_its_sd() {
        assert_eq!(between(6.384, 6.507, 0.032), "6.384 to 6.507");
        // a long tail, whose sd says little of where the draws lie
        assert_eq!(between(120.0, 12_345.0, 300_000.0), "0 to 12000");
        assert_eq!(between(6.4, 6.4 + 1e-12, 0.032), "6.400 to 6.400");
        assert_eq!(between(0.18, 0.18, 1e-16), "0.1800 to 0.1800");
        assert_eq!(between(6.4, 6.4, 0.0), NONE);
    }

    /// The examples of the Particle Data Group's rounding rule, and the edges of its three ranges.
    #[test]
    fn errors_are_rounded_by_the_pdg_rule() {
        for (value, se, expected) in [
            (0.827, 0.119, "0.83 ± 0.12"),
            (0.827, 0.367, "0.8 ± 0.4"),
            (0.827, 0.0354, "0.827 ± 0.035"),
            (0.827, 0.0355, "0.83 ± 0.04"),
            (0.827, 0.0949, "0.83 ± 0.09"),
            (0.827, 0.0951, "0.83 ± 0.10"),
            (11.283, 0.2699, "11.28 ± 0.27"),
            (12_345.0, 123.0, "12350 ± 120"),
            (0.183_04, 0.000_999_6, "0.1830 ± 0.0010"),
            (0.18, 2.22e-16, "0.1800 ± 2.2e-16"),
            (-0.000_123_4, 0.000_001_99, "−0.0001234 ± 0.0000020"),
        ] {
            assert_eq!(with_se(value, se), expected);
        }
    }

    #[test]
    fn what_is_no_number_is_shown_as_none() {
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, 1.0, 1e300, 5e-324];
        for (a, b) in odd.iter().flat_map(|a| odd.map(|b| (*a, b))) {
            for text in [
                with_se(a, b),
                between(a, 1.0, b),
                between(1.0, 2.0, a),
                by_mcse(Some(a), Some(b)),
                with_sd(a, b, 0.1),
                with_sd(1.0, a, b),
                significant(a, 3),
                probability(a),
                signed(a),
                shift(a, Some(b)),
                range([a, b]),
                short(a),
            ] {
                assert!(!text.contains("NaN") && !text.contains("inf"), "{a} {b}: {text}");
            }
        }
        assert_eq!(
            [signed(f64::NAN), signed_to(f64::INFINITY, 1), probability(f64::NAN)],
            [NONE; 3]
        );
        let odd = [[0.1, 0.2, f64::NAN], [f64::NEG_INFINITY, 1.0, 0.1]];
        assert_eq!(odd.map(|[lo, hi, sd]| between(lo, hi, sd)), [NONE; 2]);
        assert_eq!(with_se(0.5, 0.0), "0.5000 ± –");
        assert_eq!(with_se(f64::NAN, 0.1), "– ± –");
    }

    #[test]
    fn significant_digits_and_ranges() {
        assert_eq!(significant(0.012_345, 3), "0.0123");
        assert_eq!(significant(0.099_96, 3), "0.100");
        assert_eq!(range([0.099_96, 0.100_04]), "0.100");
        assert_eq!(to_digits(0.006_103_296, 2), 0.0061);
        assert_eq!(significant(123_456.0, 3), "123000");
        assert_eq!(significant(1.234e-9, 3), "1.23e-9");
        assert_eq!(significant(f64::INFINITY, 3), NONE);
        assert_eq!(range([0.767, 1.715]), "0.767 to 1.72");
        assert_eq!(range([2.0, 2.0]), "2.00");
        assert_eq!(probability(0.000_2), "below 0.001");
        assert_eq!(signed(-1.234), "−1.23");
        assert_eq!(signed(-0.001), "0.00");
        assert_eq!(shift(0.046, Some(0.0108)), "+0.046");
        assert_eq!(short(0.06), "0.06");
        assert_eq!(short(4.762), "4.762");
        assert_eq!(short(2e-5), "0.0000200");
        assert_eq!(short(1e-9), "1.00e-9");
        assert_eq!(short(3e50), "3.00e50");
    }
}
