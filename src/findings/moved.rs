//! Holds a number in two fits, of which the second leaves runs out or allows for more.

use super::remarks::in_symbols;
use crate::rounding::with_se;

/// A number by its name, with its value and ±.
pub(super) type Told = (String, [f64; 2]);

/// A number by its name, with its value and ± in both fits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moved {
    pub name: String,
    pub before: [f64; 2],
    pub after: [f64; 2],
}

impl Moved {
    /// Every number that both fits tell.
    pub fn between<'t>(before: &'t [Told], after: &'t [Told]) -> impl Iterator<Item = Moved> + 't {
        before.iter().filter_map(move |(name, before)| {
            let (_, after) = after.iter().find(|(other, _)| other == name)?;
            let (name, before, after) = (name.clone(), *before, *after);
            Some(Moved { name, before, after })
        })
    }

    /// How far its values lie apart, in the ± of the first fit.
    pub fn shift(&self) -> f64 {
        self.apart() / self.before[1]
    }

    /// The same in the smaller ± of both.
    pub fn shift_in_smaller(&self) -> f64 {
        self.apart() / self.before[1].min(self.after[1])
    }

    /// The same in the larger.
    pub fn shift_in_larger(&self) -> f64 {
        self.apart() / self.before[1].max(self.after[1])
    }

    fn apart(&self) -> f64 {
        (self.after[0] - self.before[0]).abs()
    }

    /// Its symbol, and what it is in each fit.
    pub fn words(&self) -> [String; 3] {
        let [before, after] = [self.before, self.after].map(|[value, se]| with_se(value, se));
        [in_symbols(&self.name), before, after]
    }

    /// What it is with and without the runs that the second fit leaves out: `it` or `them`.
    pub fn with_and_without(&self, runs: &str) -> String {
        let [symbol, with, without] = self.words();
        format!("{symbol} is {with} with {runs} and {without} without {runs}")
    }
}
