//! Chooses an axis's limits, tick step and tick labels.

use super::data::Axis;
use super::text;

/// Limits and ticks of a linear axis; `lower < upper` and `step > 0` always.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisScale {
    lower: f64,
    upper: f64,
    step: f64,
    decimals: usize,
    /// Power of ten shared by all labels of the axis; 0 writes plain numbers.
    exponent: i32,
    /// Whether it is given logarithms to base 10.
    decades: bool,
}

/// Ticks of any axis at most.
const MOST_TICKS: f64 = 8.0;

/// Whether a value can be placed on an axis; near the limits of f64 even a span overflows.
pub(super) fn drawable(value: f64) -> bool {
    value.abs() < 1e100
}

impl AxisScale {
    /// The scale of an axis with values along it: with the fewest ticks, of these numbers at most, that still has two.
    pub(super) fn of_axis(axis: &Axis, values: &[f64], ticks: &[f64]) -> Self {
        let scales = ticks.iter().map(|most| Self::with_ticks(*most, values, axis.range));
        let enough = scales.reduce(|scale, finer| if scale.ticks().nth(1).is_some() { scale } else { finer });
        let scale = enough.unwrap_or_else(|| Self::with_ticks(MOST_TICKS, values, axis.range));
        if axis.decades {
            scale.of_decades()
        } else {
            scale
        }
    }

    /// Fits the values, or takes the wanted limits where they span something; with about so many ticks at most.
    fn with_ticks(most: f64, values: &[f64], wanted: Option<(f64, f64)>) -> Self {
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
    fn of_decades(self) -> Self {
        let (lower, upper) = (self.lower.floor(), self.upper.ceil());
        Self {
            lower,
            upper,
            step: ((upper - lower) / MOST_TICKS).ceil(),
            decades: true,
            ..self
        }
    }

    /// Where a value lies between the limits: 0 at the lower one, 1 at the upper one.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.lower) / (self.upper - self.lower)
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

    /// Which ticks are labelled, of an axis of this length whose labels need so much room: all, every second, …
    pub(super) fn labelled_every(&self, needed: f64, length: f64) -> usize {
        let room = length * self.step / (self.upper - self.lower);
        (needed / room).ceil().max(1.0) as usize
    }

    /// A tick's label: the same number of decimals and power of ten all along the axis.
    pub(super) fn label(&self, tick: f64) -> String {
        // Rounding leaves the tick at the origin a little off it: "-0.0".
        let tick = if tick.abs() < 1e-6 * self.step { 0.0 } else { tick };
        let plain = match self.exponent {
            _ if self.decades => format!("10^{{{tick:.0}}}"),
            0 => format!("{tick:.*}", self.decimals),
            e => format!("{:.*}e{e}", self.decimals, tick / 10f64.powi(e)),
        };
        plain.replace('-', "−")
    }

    /// Room for the widest tick label, in pixels.
    pub(super) fn label_width(&self, size: f64) -> f64 {
        let ends = [self.label(self.lower), self.label(self.upper)];
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

    fn scale(values: &[f64], wanted: Option<(f64, f64)>) -> AxisScale {
        AxisScale::with_ticks(6.0, values, wanted)
    }

    #[test]
    fn decades_end_at_powers_of_ten() {
        let s = scale(&[-2.3, 1.2], None).of_decades();
        assert_eq!((s.lower, s.upper, s.step), (-3.0, 2.0, 1.0));
        assert_eq!(s.label(-3.0), "10^{−3}");
        let wide = scale(&[-20.0, 12.0], None).of_decades();
        assert!((wide.upper - wide.lower) / wide.step <= 8.5);
    }

    #[test]
    fn an_axis_has_two_ticks_and_no_more_labels_than_there_is_room_for() {
        let axis = Axis::new("x").between(0.43, 1.17);
        let few = AxisScale::of_axis(&axis, &[], &[3.0, 4.0, 5.0, 8.0]);
        assert_eq!(few.ticks().collect::<Vec<_>>(), [0.5, 1.0]);
        let every = |needed| few.labelled_every(needed, 74.0);
        assert_eq!([49.0, 51.0, 101.0].map(every), [1, 2, 3]);
    }

    #[test]
    fn labels_of_an_axis_look_alike() {
        let labels = |lo, hi| {
            let s = scale(&[], Some((lo, hi)));
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
