//! Holds a number in two fits, of which the second leaves runs out or allows for more.

use super::remarks::in_symbols;
use crate::rounding::with_se;

/// A number by its name, with its value and ± in both fits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moved {
    pub name: String,
    pub before: [f64; 2],
    pub after: [f64; 2],
}

impl Moved {
    /// How far its values lie apart.
    pub fn apart(&self) -> f64 {
        (self.after[0] - self.before[0]).abs()
    }

    /// Its symbol, and what it is in each fit.
    pub fn words(&self) -> [String; 3] {
        let [before, after] = [self.before, self.after].map(|[value, se]| with_se(value, se));
        [in_symbols(&self.name), before, after]
    }
}
