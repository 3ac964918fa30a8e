//! Holds the quantities that a header may name, by `quantities.txt`.

use std::sync::LazyLock;

use super::super::words::{ends_like, is_among, words_of};
use crate::scene::RunColumn;
use crate::units::Dimension;

/// What a header may name.
pub(super) struct Quantity {
    pub name: &'static str,
    /// what its units are of
    kind: &'static str,
    pub words: &'static str,
    /// what the columns that take it are called, the one of the impact first
    columns: &'static str,
    symbols: &'static str,
}

/// Quantities of the table.
pub(super) type Quantities = Vec<&'static Quantity>;

/// Every quantity that a header may name.
pub(super) static QUANTITIES: LazyLock<Vec<Quantity>> = LazyLock::new(|| {
    let quantity = |line: &'static str| {
        let mut parts = line.split(':').map(str::trim);
        let mut next = || parts.next().filter(|_| !line.starts_with('#'));
        Some(Quantity {
            name: next()?,
            kind: next()?,
            words: next()?,
            columns: next()?,
            symbols: next().unwrap_or_default(),
        })
    };
    include_str!("quantities.txt").lines().filter_map(quantity).collect()
});

impl Quantity {
    pub fn is_of(&self, column: RunColumn) -> bool {
        is_among(self.columns, column.base())
    }

    pub fn columns(&self) -> impl Iterator<Item = RunColumn> {
        self.columns.split(' ').filter_map(RunColumn::of_base)
    }

    /// Whether a column takes numbers in its units.
    pub fn shares_units_with(&self, column: RunColumn) -> bool {
        self.kind
            == match column.dimension() {
                Dimension::Length | Dimension::Thickness => "length",
                Dimension::Speed => "speed",
                _ => "share",
            }
    }

    /// Whether it may be given in a unit of a kind, which is written so.
    pub fn may_be_in(&self, kind: &str, written: &str) -> bool {
        let is_letter = written.chars().count() == 1 && written.chars().all(char::is_alphabetic);
        match kind {
            _ if kind == self.kind => true,
            "share" | "another" => true,
            // beside a speed `in` says which it is, and a letter beside a plain number is a symbol
            "length" if written.trim_end_matches('.') == "in" => true,
            _ if is_letter && self.kind == "share" => true,
            // metres a second, or milliseconds
            "speed" if written == "ms" => self.kind == "time",
            _ => false,
        }
    }
}

/// Those that the words of a name, in small letters, name.
pub(super) fn quantities_in(lower: &str) -> Quantities {
    let is_named = |quantity: &&Quantity| words_of(lower).any(|word| ends_like(quantity.words, word));
    QUANTITIES.iter().filter(is_named).collect()
}

/// Those that a symbol stands for, perhaps with a number behind it.
pub(super) fn quantities_of_symbol(symbol: &str) -> Quantities {
    let symbol = symbol.trim_end_matches(char::is_numeric);
    let is_meant = |quantity: &&Quantity| !symbol.is_empty() && is_among(quantity.symbols, symbol);
    QUANTITIES.iter().filter(is_meant).collect()
}

/// The quantity that is called like what a unit is of.
pub(super) fn quantity_of_kind(kind: &str) -> Option<&'static Quantity> {
    QUANTITIES
        .iter()
        .find(|quantity| quantity.name.split(' ').next_back() == Some(kind))
}
