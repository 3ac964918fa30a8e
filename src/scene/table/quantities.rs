//! Reads quantities whose unit stands in the key, and takes them to SI.

use std::cell::Cell;

use super::values::as_number;
use super::{DeValue, SceneTable, Spanned};
use crate::scene::expect::Expect;
use crate::units::{Dimension, MAGNITUDES, MAGNITUDE_EXPECTED};

/// What stands where a quantity or one word is expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuantityOrWord {
    /// the quantity, in SI
    Quantity(f64),
    /// the word
    Word,
}

impl<'a, 'i> SceneTable<'a, 'i> {
    /// The key a quantity is given under, with its value converted by `read`; two units for one quantity are refused.
    fn with_unit<T>(
        &self,
        base: &str,
        dimension: Dimension,
        read: impl Fn(&Self, &str, &'a Spanned<DeValue<'i>>, &dyn Fn(f64) -> f64) -> Option<T>,
    ) -> Option<T> {
        self.read_keys.borrow_mut().quantity(base, dimension);
        let mut given: Vec<(String, &'a Spanned<DeValue<'i>>, &'static crate::units::Unit)> = vec![];
        for unit in dimension.units() {
            let key = format!("{base}{}", unit.suffix);
            if let Some(value) = self.entry(&key) {
                given.push((key, value, unit));
            }
        }
        given.sort_by_key(|(_, value, _)| value.span().start);
        if let [(first, _, _), (second, value, _), ..] = given.as_slice() {
            self.refuse(
                second,
                value.span().start,
                None,
                format!("`{base}` is already given as `{first}`; expected one unit for one quantity"),
            );
            return None;
        }
        let (key, value, unit) = given.first()?;
        let out_of_range = Cell::new(false);
        let read = read(self, key, value, &|x| {
            let si = unit.to_si(x);
            // zero is the business of what the number is expected to be
            let lost = dimension != Dimension::One && x != 0.0 && !MAGNITUDES.contains(&si);
            out_of_range.set(out_of_range.get() || lost);
            si
        });
        if out_of_range.get() {
            self.refuse_value(key, value, MAGNITUDE_EXPECTED);
            return None;
        }
        read
    }

    /// A number with its unit in the key, in SI.
    pub fn quantity(&self, base: &str, dimension: Dimension, expect: Expect) -> Option<f64> {
        self.with_unit(base, dimension, |table, key, value, to_si| {
            table.checked_number(key, value, expect).map(to_si)
        })
    }

    /// A required quantity: its absence is a problem.
    pub fn required(&self, base: &str, dimension: Dimension, expect: Expect) -> Option<f64> {
        self.require_key(base, dimension);
        self.quantity(base, dimension, expect)
    }

    /// Says so when a required key is missing under each of its units.
    pub fn require_key(&self, base: &str, dimension: Dimension) -> bool {
        let keys: Vec<_> = dimension
            .units()
            .iter()
            .map(|unit| format!("{base}{}", unit.suffix))
            .collect();
        let present = keys.iter().any(|key| self.has(key));
        if !present {
            self.read_keys.borrow_mut().missing(keys);
        }
        present
    }

    /// A quantity, or one word in its place.
    pub fn quantity_or_word(
        &self,
        base: &str,
        dimension: Dimension,
        expect: Expect,
        word: &str,
    ) -> Option<QuantityOrWord> {
        self.with_unit(base, dimension, |table, key, value, to_si| {
            if value.get_ref().as_str() == Some(word) {
                return Some(QuantityOrWord::Word);
            }
            match as_number(value.get_ref()).filter(|x| (expect.holds)(*x)) {
                Some(x) => Some(QuantityOrWord::Quantity(to_si(x))),
                None => {
                    table.refuse_value(key, value, &format!("{} or \"{word}\"", expect.words));
                    None
                }
            }
        })
    }

    /// A list of quantities with the unit in the key, in SI.
    pub fn quantities(&self, base: &str, dimension: Dimension, expect: Expect) -> Option<Vec<f64>> {
        self.with_unit(base, dimension, |table, key, value, to_si| {
            table.list(key, value, expect, to_si)
        })
    }

    /// For each particle a list of quantities: one list for all, or a table of lists by particle.
    pub fn quantities_by_name(
        &self,
        base: &str,
        dimension: Dimension,
        expect: Expect,
        names: &[&str],
    ) -> Option<Vec<Vec<f64>>> {
        self.with_unit(base, dimension, |table, key, value, to_si| {
            if value.get_ref().is_array() {
                let list = table.list(key, value, expect, to_si)?;
                return Some(vec![list; names.len()]);
            }
            if !value.get_ref().is_table() {
                table.refuse_value(
                    key,
                    value,
                    "a list of numbers, or a table with a list for each particle",
                );
                return None;
            }
            let inner = table.inner(key, value)?;
            let lists = names
                .iter()
                .map(|name| match inner.entry(name) {
                    Some(list) => inner.list(name, list, expect, to_si),
                    None => Some(vec![]),
                })
                .collect();
            inner.finish();
            lists
        })
    }

    fn list(
        &self,
        key: &str,
        value: &Spanned<DeValue<'i>>,
        expect: Expect,
        to_si: &dyn Fn(f64) -> f64,
    ) -> Option<Vec<f64>> {
        let Some(items) = value.get_ref().as_array().filter(|items| !items.is_empty()) else {
            self.refuse_value(key, value, "a list of numbers");
            return None;
        };
        items
            .iter()
            .map(|item| self.checked_number(key, item, expect).map(to_si))
            .collect()
    }
}
