//! Finds where a function of one number is zero, between two ends.

/// Where a function is zero between two ends, in either order, to about two roundings of the larger end.
///
/// The function must have different signs at the ends, or be zero at one: else there is `None`, as where it is no number at
/// a point that is looked at. It may jump: then the jump counts as its zero. Of several zeros one is found. Steps by inverse
/// quadratic interpolation where the three latest points allow it, by halves else: about ten evaluations of a smooth
/// function. Source: Chandrupatla 1997 (Advances in Engineering Software 28, 145).
pub fn root_between(ends: [f64; 2], mut f: impl FnMut(f64) -> f64) -> Option<f64> {
    root_from(ends.map(|x| (x, f(x))), f)
}

/// The same of a function that is known at the ends: each a place with the value there.
pub fn root_from(ends: [(f64, f64); 2], mut f: impl FnMut(f64) -> f64) -> Option<f64> {
    /// halves alone would end sooner
    const STEPS: usize = 200;
    let [mut latest, mut other] = ends;
    let is_one_side = |a: f64, b: f64| (a < 0.0 && b < 0.0) || (a > 0.0 && b > 0.0);
    let is_unknown = [latest.0, latest.1, other.0, other.1].iter().any(|x| x.is_nan());
    if is_unknown || is_one_side(latest.1, other.1) {
        return None;
    }
    let rounding = 2.0 * f64::EPSILON * latest.0.abs().max(other.0.abs());
    let mut part: f64 = 0.5;
    for _ in 0..STEPS {
        let width = (other.0 - latest.0).abs();
        let nearest = if latest.1.abs() < other.1.abs() { latest } else { other };
        if nearest.1 == 0.0 || width <= rounding {
            return Some(nearest.0);
        }
        let least = 0.5 * rounding / width;
        let x = latest.0 + part.clamp(least, 1.0 - least) * (other.0 - latest.0);
        let at = f(x);
        if at.is_nan() {
            return None;
        }
        // the point that leaves the bracket still bends the curve through the next one
        let mut left = latest;
        if !is_one_side(at, latest.1) {
            (left, other) = (other, latest);
        }
        latest = (x, at);
        part = interpolated(latest, other, left).unwrap_or(0.5);
    }
    Some(latest.0)
}

/// The part of the way from a to b at which the inverse quadratic through three points is zero; `None` where it is not
/// monotonic between them.
fn interpolated(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let place = (a.0 - b.0) / (c.0 - b.0);
    let height = (a.1 - b.1) / (c.1 - b.1);
    let is_monotonic = height * height < place && (1.0 - height) * (1.0 - height) < 1.0 - place;
    let by_chord = a.1 / (b.1 - a.1) * c.1 / (b.1 - c.1);
    let by_bend = (c.0 - a.0) / (b.0 - a.0) * a.1 / (c.1 - a.1) * b.1 / (c.1 - b.1);
    is_monotonic.then_some(by_chord + by_bend)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_found_from_either_side_in_few_steps() {
        let mut asked = 0;
        for ends in [[0.0, 3.0], [3.0, 0.0], [-5.0, 400.0]] {
            let found = root_between(ends, |x| {
                asked += 1;
                x.exp() - 2.0
            });
            assert!((found.unwrap() - 2f64.ln()).abs() < 1e-12, "{found:?}");
        }
        assert!(asked < 60, "{asked}");
        // flat about its zero
        let flat = root_between([-1.0, 4.0], |x| (x - 0.3).powi(9)).unwrap();
        assert!((flat - 0.3).abs() < 1e-12, "{flat}");
    }

    #[test]
    fn a_jump_and_an_end_count_as_zeros() {
        let jump = root_between([0.0, 1.0], |x| if x < 0.7 { -1.0 } else { f64::INFINITY });
        assert!((jump.unwrap() - 0.7).abs() < 1e-15);
        assert_eq!(root_between([2.0, 5.0], |x| x - 5.0), Some(5.0));
        assert_eq!(root_between([0.0, 0.0], |x| x), Some(0.0));
    }

    #[test]
    fn there_is_none_without_a_change_of_sign_or_of_no_number() {
        assert_eq!(root_between([1.0, 2.0], |x| x), None);
        assert_eq!(root_between([1.0, f64::NAN], |x| x), None);
        let hidden = |x: f64| if x.abs() < 0.9 { f64::NAN } else { x };
        assert_eq!(root_between([-1.0, 2.0], hidden), None);
    }
}
