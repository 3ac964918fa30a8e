//! Chooses an axis's limits, tick step and tick labels.

use super::text;

/// Limits and ticks of a linear axis; `lower < upper` and `step > 0` always.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) step: f64,
    decimals: usize,
    /// Power of ten shared by all labels of the axis; 0 writes plain numbers.
    exponent: i32,
    /// Whether it is given logarithms to base 10.
    decades: bool,
}

/// Whether a value can be placed on an axis; near the limits of f64 even a span overflows.
pub(super) fn drawable(value: f64) -> bool {
    value.abs() < 1e100
}

impl Scale {
    /// Fits the values, or takes the wanted limits where they span something.
    pub(super) fn new(values: &[f64], wanted: Option<(f64, f64)>) -> Self {
        Self::with_ticks(6.0, values, wanted)
    }

    /// The same with about so many ticks at most.
    pub(super) fn with_ticks(most: f64, values: &[f64], wanted: Option<(f64, f64)>) -> Self {
        let (lower, upper) = wanted
            .filter(|&(lo, hi)| spans(lo, hi))
            .unwrap_or_else(|| fitted(values));
        let rough = (upper - lower) / most;
        let decade = 10f64.powi(rough.log10().floor() as i32);
        let step = [1.0, 2.0, 5.0]
            .into_iter()
            .find(|m| m * decade >= rough * (1.0 - 1e-9))
            .unwrap_or(10.0)
            * decade;
        let largest = lower.abs().max(upper.abs());
        let exponent = if (1e-3..1e5).contains(&largest) {
            0
        } else {
            largest.log10().floor() as i32
        };
        // The small shift keeps 0.1, a little below 10⁻¹ in its logarithm, in its decade.
        let finest = (step.log10() + 1e-9).floor() as i32;
        Self {
            lower,
            upper,
            step,
            decimals: usize::try_from(exponent - finest).unwrap_or(0),
            exponent,
            decades: false,
        }
    }

    /// The same for logarithms to base 10: from one power of ten to another, with ticks at powers only.
    pub(super) fn of_decades(self) -> Self {
        let (lower, upper) = (self.lower.floor(), self.upper.ceil());
        let most = 8.0;
        Self {
            lower,
            upper,
            step: ((upper - lower) / most).ceil(),
            decades: true,
            ..self
        }
    }

    pub(super) fn contains(&self, value: f64) -> bool {
        (self.lower..=self.upper).contains(&value)
    }

    /// Where the ticks are.
    pub(super) fn ticks(&self) -> impl Iterator<Item = f64> {
        let (step, slack) = (self.step, 1e-9);
        let first = (self.lower / step - slack).ceil() as i64;
        let last = (self.upper / step + slack).floor() as i64;
        (first..=last).map(move |i| i as f64 * step)
    }

    /// A tick's label: the same number of decimals and power of ten all along the axis.
    pub(super) fn label(&self, tick: f64) -> String {
        if self.decades {
            return text::markup(&Self::power(tick));
        }
        // Rounding leaves the tick at the origin a little off it: "-0.0".
        let tick = if tick.abs() < 1e-6 * self.step { 0.0 } else { tick };
        let plain = match self.exponent {
            0 => format!("{tick:.*}", self.decimals),
            e => format!("{:.*}e{e}", self.decimals, tick / 10f64.powi(e)),
        };
        plain.replace('-', "−")
    }

    fn power(tick: f64) -> String {
        format!("10^{{{tick:.0}}}").replace('-', "−")
    }

    /// Room for the widest tick label, in pixels.
    pub(super) fn label_width(&self, size: u32) -> f64 {
        let label = |tick: f64| {
            if self.decades {
                Self::power(tick)
            } else {
                self.label(tick)
            }
        };
        let ends = [label(self.lower), label(self.upper)];
        ends.iter().map(|l| text::width(l, size)).fold(0.0, f64::max)
    }
}

fn spans(lower: f64, upper: f64) -> bool {
    let least = 1e-9 * lower.abs().max(upper.abs());
    drawable(lower) && drawable(upper) && upper - lower > least.max(1e-100)
}

fn fitted(values: &[f64]) -> (f64, f64) {
    let values = || values.iter().copied().filter(|v| drawable(*v));
    let lower = values().fold(f64::INFINITY, f64::min);
    let upper = values().fold(f64::NEG_INFINITY, f64::max);
    if lower > upper {
        return (0.0, 1.0);
    }
    if !spans(lower, upper) {
        let largest = lower.abs().max(upper.abs());
        let half = if largest < 1e-99 { 0.5 } else { 0.1 * largest };
        return (lower - half, upper + half);
    }
    let span = upper - lower;
    let margin = 0.05 * span;
    // Data that begin near the origin are easier to read with the origin shown.
    let lower = if (0.0..=0.2 * span).contains(&lower) {
        0.0
    } else {
        lower - margin
    };
    (lower, upper + margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_hold_the_data_and_leave_room() {
        let s = Scale::new(&[0.31, 0.55, 0.92], None);
        assert!(s.lower < 0.31 && s.upper > 0.92);
        assert_eq!(Scale::new(&[0.2, 4.9], None).lower, 0.0);
        assert!(Scale::new(&[-0.2, 4.9], None).lower < -0.2);
    }

    #[test]
    fn degenerate_values_still_give_an_axis() {
        let cases: [&[f64]; 8] = [
            &[],
            &[3.0],
            &[0.0, 0.0],
            &[1.0, 1.0 + f64::EPSILON],
            &[f64::NAN, f64::INFINITY],
            &[-f64::MAX, f64::MAX],
            &[1e-310, 5e-310],
            &[9e99, -9e99],
        ];
        for values in cases {
            let s = Scale::new(values, None);
            assert!(s.lower < s.upper && s.upper.is_finite(), "{values:?}: {s:?}");
            let ticks = (s.upper - s.lower) / s.step;
            assert!((2.0..=6.5).contains(&ticks), "{values:?}: {s:?}");
        }
    }

    #[test]
    fn limits_that_span_nothing_are_ignored() {
        let fitted = Scale::new(&[1.0, 2.0], None);
        for wanted in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            assert_eq!(Scale::new(&[1.0, 2.0], Some(wanted)), fitted);
        }
        let s = Scale::new(&[1.0, 2.0], Some((0.0, 5.0)));
        assert_eq!((s.lower, s.upper), (0.0, 5.0));
    }

    #[test]
    fn decades_end_at_powers_of_ten() {
        let s = Scale::new(&[-2.3, 1.2], None).of_decades();
        assert_eq!((s.lower, s.upper, s.step), (-3.0, 2.0, 1.0));
        assert_eq!(Scale::power(-3.0), "10^{−3}");
        let wide = Scale::new(&[-20.0, 12.0], None).of_decades();
        assert!((wide.upper - wide.lower) / wide.step <= 8.5);
    }

    #[test]
    fn labels_of_an_axis_look_alike() {
        let labels = |lo, hi| {
            let s = Scale::new(&[], Some((lo, hi)));
            s.ticks().map(|tick| s.label(tick)).collect::<Vec<_>>()
        };
        assert_eq!(labels(0.0, 0.6), ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
        assert_eq!(labels(-1.0, 1.0), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(0.0, 300.0), ["0", "50", "100", "150", "200", "250", "300"]);
        assert_eq!(
            labels(0.0, 3e-5),
            ["0.0e−5", "0.5e−5", "1.0e−5", "1.5e−5", "2.0e−5", "2.5e−5", "3.0e−5"]
        );
        assert_eq!(labels(0.0, 4e6), ["0e6", "1e6", "2e6", "3e6", "4e6"]);
    }
}
