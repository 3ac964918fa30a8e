//! Tries a prior where sampling will go: what would hang, overflow or drown in rounding is refused before it starts.

use super::prior::Prior;
use crate::distributions::FEW;

/// Probability outside each of the two points between which a prior is tried.
const OUTSIDE: f64 = 0.001;

/// Magnitudes between which the larger of these points lies. No parameter has another than 1 or (m/s)^(-1/5) for its unit,
/// and squares, products and fourth powers of these are far from the ends of the numbers.
const MAGNITUDES: (f64, f64) = (1e-15, 1e15);

/// Least distance of the points, as a share of the magnitude: the log density of a narrower one is lost in rounding.
const NARROWEST: f64 = 1e-5;

/// Most by which the log density may fall from the median to where the bounds let the parameter be: 37 sd of a normal.
const FALL: f64 = 700.0;

/// How far inside its bounds a parameter is tried, as a share of them or of the distance of the points.
const INSIDE: f64 = 1e-3;

impl Prior {
    /// What is to be expected of a prior inside these bounds in place of this one; `None` where it stands the trial.
    ///
    /// A prior held at a value is tried by its magnitude and the bounds; 0 is no magnitude, and left to who knows whether it
    /// may be held.
    pub(crate) fn fails(&self, bounds: (f64, f64)) -> Option<String> {
        let (least, most) = MAGNITUDES;
        if let Prior::Fixed(value) = *self {
            let usable = value == 0.0 || (least..=most).contains(&value.abs());
            return (!usable).then(|| format!("a value of a magnitude from {least:e} to {most:e}"));
        }
        if matches!(self, Prior::StudentT(df, ..) if *df < FEW) {
            return Some(format!("[df, loc, scale] with df of {FEW} or more"));
        }
        let points = [OUTSIDE, 0.5, 1.0 - OUTSIDE].map(|probability| self.quantile(probability));
        let [Some(low), Some(middle), Some(high)] = points else {
            return Some(
                "a prior whose 0.1 %, 50 % and 99.9 % points are numbers that can be computed with".to_owned(),
            );
        };
        let size = low.abs().max(high.abs());
        if !(least..=most).contains(&size) {
            return Some(format!(
                "a prior of which the larger of the 0.1 % and 99.9 % points has a magnitude from {least:e} to {most:e}, \
                 they are {low:.3e} and {high:.3e}"
            ));
        }
        if high - low < NARROWEST * size {
            return Some(format!(
                "a prior whose 0.1 % and 99.9 % points lie apart by {NARROWEST:e} of their magnitude or more, they are \
                 {low:.9e} and {high:.9e}; or {{ fixed = {middle} }}"
            ));
        }
        let inside = match *self {
            // its own ends are bounds, too
            Prior::Uniform(lo, hi) => (bounds.0.max(lo), bounds.1.min(hi)),
            _ => bounds,
        };
        if inside.0 >= inside.1 {
            return Some(within("a value", bounds));
        }
        let little = INSIDE * (high - low).min(inside.1 - inside.0);
        let tried = |x: f64| self.ln_density(x.max(inside.0 + little).min(inside.1 - little));
        let has_room = match (self.ln_density(middle), tried(middle)) {
            (Some((there, _)), Some((here, _))) => there - here < FALL,
            _ => false,
        };
        if !has_room || tried(low).is_none() || tried(high).is_none() {
            return Some(within("a prior with a density", bounds));
        }
        None
    }
}

/// A phrase that says where a parameter has to lie.
pub(crate) fn within(what: &str, (lower, upper): (f64, f64)) -> String {
    if upper.is_finite() {
        format!("{what} between {lower} and {upper:.6}")
    } else {
        format!("{what} above {lower}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ABOVE_ZERO: (f64, f64) = (0.0, f64::INFINITY);

    #[test]
    fn usual_and_wide_priors_stand_the_trial() {
        for prior in [
            Prior::LogNormal(3.0, 5.0),
            Prior::HalfNormal(1e-6),
            Prior::Normal(0.0, 1e-6),
            Prior::Normal(-5.0, 1.0),
            Prior::Gamma(0.01, 1.0),
            Prior::Gamma(1e6, 1e6),
            Prior::Gamma(1e6, 1.0),
            Prior::Uniform(-100.0, 1.0),
            Prior::Uniform(0.0, 1e9),
            Prior::StudentT(0.5, 0.0, 1.0),
            Prior::StudentT(1e300, 0.12, 0.02),
        ] {
            assert_eq!(prior.fails(ABOVE_ZERO), None, "{prior:?}");
        }
        assert_eq!(Prior::LogNormal(10.0, 0.5).fails((2.0, f64::INFINITY)), None);
        assert_eq!(Prior::LogNormal(0.4, 0.3).fails((0.0, 0.87)), None);
    }

    #[test]
    fn what_cannot_be_computed_with_fails_the_trial_and_says_why() {
        let above_two = (2.0, f64::INFINITY);
        let below_one = (0.0, 0.87);
        for (prior, bounds, why) in [
            (Prior::Gamma(2.0, 1e308), ABOVE_ZERO, "a magnitude from 1e-15 to 1e15"),
            (Prior::Gamma(1e-5, 1.0), ABOVE_ZERO, "can be computed with"),
            (Prior::Gamma(1e14, 1e14), ABOVE_ZERO, "or { fixed = 0.99999"),
            (Prior::LogNormal(1e-5, 0.2), above_two, "a density above 2"),
            (Prior::LogNormal(0.2, 1e-9), ABOVE_ZERO, "or { fixed = 0.2 }"),
            (Prior::HalfNormal(1e-300), ABOVE_ZERO, "a magnitude from 1e-15 to 1e15"),
            (Prior::Normal(-50.0, 1.0), ABOVE_ZERO, "a prior with a density above 0"),
            (Prior::Normal(900.0, 1.0), below_one, "a density between 0 and 0.87"),
            (Prior::Uniform(-1.7e308, 1.7e308), ABOVE_ZERO, "can be computed with"),
            (Prior::Uniform(2.0, 3.0), below_one, "a value between 0 and 0.87"),
            (Prior::StudentT(0.1, 0.0, 1.0), ABOVE_ZERO, "df of 0.5 or more"),
            (Prior::StudentT(4.0, 1.0, 1e-300), ABOVE_ZERO, "or { fixed = 1 }"),
            (Prior::Fixed(1e300), ABOVE_ZERO, "a magnitude from 1e-15 to 1e15"),
        ] {
            let refusal = prior.fails(bounds).unwrap_or_default();
            assert!(refusal.contains(why), "{prior:?}: {refusal}");
        }
    }
}
