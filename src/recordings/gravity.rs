//! Estimates the one gravity that all flights share.

use crate::distributions::median;

/// The acceleration of free fall where it is not measured, in m/s².
pub use crate::physics::numbers::GRAVITY;

/// A gravity with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// g, in the unit of the heights over s²
    pub value: f64,
    /// of g
    pub se: f64,
    /// flights that it is of
    pub flights: usize,
}

/// Share of g by which a flight's own must differ from it to be wrong, where it does so by [`FAR`] standard deviations, too.
pub const OFF: f64 = 0.03;

/// See [`OFF`].
pub const FAR: f64 = 3.0;

/// Whether an estimate is too far from what it should be.
pub fn is_off(value: f64, se: f64, expected: f64) -> bool {
    let off = (value - expected).abs();
    off > OFF * expected.abs() && off > FAR * se
}

/// The gravity of all flights by least squares, those left out whose own is off; `None` without flights. Of each flight its
/// own with the standard error, and its frames.
pub(super) fn shared(flights: &[([f64; 2], usize)]) -> Option<Gravity> {
    /// of the median, that a flight may be off by at first
    const NEAR: f64 = 0.1;
    const ROUNDS: usize = 5;
    let mut own: Vec<f64> = vec![];
    // long flights say most: each counts as often as it has frames
    for ([value, _], frames) in flights {
        own.extend(std::iter::repeat_n(*value, *frames));
    }
    let start = median(&mut own)?;
    let mean = |keeps: &dyn Fn(f64, f64) -> bool| {
        let mut sums = [0.0; 2];
        let mut count = 0;
        for &([value, se], _) in flights {
            if keeps(value, se) {
                let weight = 1.0 / (se * se);
                sums = [sums[0] + weight, sums[1] + weight * value];
                count += 1;
            }
        }
        (count > 0).then(|| Gravity {
            value: sums[1] / sums[0],
            se: 1.0 / sums[0].sqrt(),
            flights: count,
        })
    };
    let mut found = mean(&|value, se| (value - start).abs() < (NEAR * start.abs()).max(FAR * se))?;
    for _ in 0..ROUNDS {
        let at = found.value;
        found = mean(&|value, se| !is_off(value, se, at)).unwrap_or(found);
    }
    Some(found)
}
