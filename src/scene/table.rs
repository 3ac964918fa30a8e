//! Reads TOML tables whose keys carry units, and names what cannot be used by line, key and value.
//!
//! The only file that names the TOML crate.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use toml::de::{DeTable, DeValue};
use toml::Spanned;

use crate::encoding::line_of;
use crate::error::{quoted, Problem};
use crate::units::{Dimension, MAGNITUDES, MAGNITUDE_EXPECTED};

use super::asked::Asked;
use super::document::Document;
use super::expect::Expect;

/// Reads a whole document; the problem is the parser's own when it is no TOML.
pub(super) fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, Problem> {
    DeTable::parse(text).map_err(|error| {
        let span = error.span();
        let found = span.clone().and_then(|span| text.get(span)).map(str::trim);
        let found = found.filter(|found| !found.is_empty());
        Problem {
            // some of the parser's own limits have no place
            line: span.map(|span| line_of(text.as_bytes(), span.start)),
            place: "not valid TOML".to_owned(),
            found: found.map(quoted),
            expected: error.message().to_owned(),
        }
    })
}

/// One table of the document; remembers which keys were asked for.
pub(super) struct Table<'a, 'i> {
    document: Rc<Document<'i>>,
    name: String,
    at: usize,
    entries: &'a DeTable<'i>,
    asked: RefCell<Asked>,
}

/// A value with its place, for checks that need more than the value itself.
pub(super) struct Found<T> {
    pub value: T,
    pub at: usize,
}

impl<'a, 'i> Table<'a, 'i> {
    pub fn root(document: Rc<Document<'i>>, entries: &'a DeTable<'i>) -> Self {
        Table {
            document,
            name: String::new(),
            at: 0,
            entries,
            asked: RefCell::default(),
        }
    }

    fn place(&self, key: &str) -> String {
        match (self.name.is_empty(), key.is_empty()) {
            (true, _) => key.to_owned(),
            (false, true) => format!("[{}]", self.name),
            (false, false) => format!("[{}] {key}", self.name),
        }
    }

    /// Says that the value of `key` is not what was expected.
    pub fn refuse(&self, key: &str, at: usize, found: Option<String>, expected: impl Into<String>) {
        let line = Some(self.document.line(at));
        let place = self.place(key);
        let expected = expected.into();
        self.document.report(
            at,
            Problem {
                line,
                place,
                found,
                expected,
            },
        );
    }

    /// Says what the file as a whole lacks.
    pub fn refuse_whole(&self, expected: &str) {
        self.document.report(
            0,
            Problem {
                line: None,
                place: String::new(),
                found: None,
                expected: expected.to_owned(),
            },
        );
    }

    fn refuse_value(&self, key: &str, value: &Spanned<DeValue<'i>>, expected: &str) {
        let found = self.document.snippet(value.span());
        self.refuse(key, value.span().start, Some(found), format!("expected {expected}"));
    }

    fn entry(&self, key: &str) -> Option<&'a Spanned<DeValue<'i>>> {
        let value = self.entries.get(key);
        self.asked.borrow_mut().key(key, value.is_some());
        value
    }

    /// Where the value of a key starts, or the table where there is none.
    pub fn at(&self, key: &str) -> usize {
        self.entries.get(key).map_or(self.at, |v| v.span().start)
    }

    /// Whether the file sets a key.
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// The keys the file sets, in its order.
    pub fn keys(&self) -> Vec<String> {
        let mut keys: Vec<_> = self.entries.iter().map(|(k, _)| k).collect();
        keys.sort_by_key(|k| k.span().start);
        keys.into_iter().map(|k| k.get_ref().to_string()).collect()
    }

    pub fn text(&self, key: &str) -> Option<String> {
        let value = self.entry(key)?;
        match value.get_ref().as_str() {
            Some(text) => Some(text.to_owned()),
            None => {
                self.refuse_value(key, value, "a text in quotes");
                None
            }
        }
    }

    pub fn number(&self, key: &str, expect: Expect) -> Option<f64> {
        let value = self.entry(key)?;
        self.checked_number(key, value, expect)
    }

    fn checked_number(&self, key: &str, value: &Spanned<DeValue<'i>>, expect: Expect) -> Option<f64> {
        match as_number(value.get_ref()).filter(|x| (expect.holds)(*x)) {
            Some(x) => Some(x),
            None => {
                self.refuse_value(key, value, expect.words);
                None
            }
        }
    }

    /// A whole number of at least `least`.
    pub fn count(&self, key: &str, least: u64) -> Option<u64> {
        // a count above this could not be worked through, nor is it exact as f64
        self.whole(key, least, 1 << 53, &format!("a whole number of {least} or more"))
    }

    /// A whole number from `least` to `most`.
    pub fn count_to(&self, key: &str, least: u64, most: u64) -> Option<u64> {
        self.whole(key, least, most, &format!("a whole number from {least} to {most}"))
    }

    fn whole(&self, key: &str, least: u64, most: u64, expected: &str) -> Option<u64> {
        let value = self.entry(key)?;
        let parsed = value
            .get_ref()
            .as_integer()
            .and_then(|i| u64::from_str_radix(i.as_str(), i.radix()).ok())
            .filter(|n| (least..=most).contains(n));
        if parsed.is_none() {
            self.refuse_value(key, value, expected);
        }
        parsed
    }

    /// One of some words.
    pub fn choice<T: Copy>(&self, key: &str, choices: &[(&str, T)]) -> Option<T> {
        let value = self.entry(key)?;
        let word = value.get_ref().as_str();
        let choice = word.and_then(|word| choices.iter().find(|(name, _)| *name == word));
        if choice.is_none() {
            let names: Vec<_> = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect();
            self.refuse_value(key, value, &names.join(" or "));
        }
        choice.map(|(_, choice)| *choice)
    }

    /// The key a quantity is given under, with its value converted by `read`; two units for one quantity are refused.
    fn with_unit<T>(
        &self,
        base: &str,
        dimension: Dimension,
        read: impl Fn(&Self, &str, &'a Spanned<DeValue<'i>>, &dyn Fn(f64) -> f64) -> Option<T>,
    ) -> Option<T> {
        self.asked.borrow_mut().quantity(base, dimension);
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
            self.asked.borrow_mut().missing(keys);
        }
        present
    }

    /// A quantity that may also be one word instead.
    pub fn quantity_or_word<T: Copy>(
        &self,
        base: &str,
        dimension: Dimension,
        expect: Expect,
        word: (&str, T),
        wrap: impl Fn(f64) -> T,
    ) -> Option<T> {
        self.with_unit(base, dimension, |table, key, value, to_si| {
            if value.get_ref().as_str() == Some(word.0) {
                return Some(word.1);
            }
            match as_number(value.get_ref()).filter(|x| (expect.holds)(*x)) {
                Some(x) => Some(wrap(to_si(x))),
                None => {
                    table.refuse_value(key, value, &format!("{} or \"{}\"", expect.words, word.0));
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

    /// A fixed number of finite numbers, or nothing if the value is no such list.
    pub fn numbers(&self, key: &str, how_many: usize) -> Option<Vec<f64>> {
        let value = self.entry(key)?;
        let items = value.get_ref().as_array().filter(|items| items.len() == how_many);
        let numbers: Option<Vec<f64>> = items.and_then(|items| {
            items
                .iter()
                .map(|item| as_number(item.get_ref()).filter(|x| x.is_finite()))
                .collect()
        });
        if numbers.is_none() {
            self.refuse_value(key, value, &format!("a list of {how_many} numbers"));
        }
        numbers
    }

    /// A list of words out of a fixed set, or one word that stands for no list.
    pub fn words_or<T: Copy>(&self, key: &str, instead: &str, choices: &[(&str, T)]) -> Option<Option<Vec<T>>> {
        let value = self.entry(key)?;
        if value.get_ref().as_str() == Some(instead) {
            return Some(None);
        }
        let words: Option<Vec<T>> = value.get_ref().as_array().and_then(|items| {
            let word = |item: &Spanned<DeValue<'_>>| {
                let text = item.get_ref().as_str()?;
                choices
                    .iter()
                    .find(|(name, _)| *name == text)
                    .map(|(_, choice)| *choice)
            };
            items.iter().map(word).collect()
        });
        if words.is_none() {
            let names: Vec<_> = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect();
            let expected = format!("\"{instead}\" or a list out of {}", names.join(", "));
            self.refuse_value(key, value, &expected);
        }
        words.map(Some)
    }

    /// A list of texts with their places.
    pub fn texts(&self, key: &str) -> Option<Vec<Found<String>>> {
        let value = self.entry(key)?;
        let texts: Option<Vec<_>> = value.get_ref().as_array().and_then(|items| {
            let text = |item: &Spanned<DeValue<'_>>| {
                let value = item.get_ref().as_str()?.to_owned();
                let at = item.span().start;
                Some(Found { value, at })
            };
            items.iter().map(text).collect()
        });
        if texts.is_none() {
            self.refuse_value(key, value, "a list of texts in quotes");
        }
        texts
    }

    fn inner(&self, key: &str, value: &'a Spanned<DeValue<'i>>) -> Option<Table<'a, 'i>> {
        match value.get_ref().as_table() {
            Some(entries) => Some(Table {
                document: Rc::clone(&self.document),
                name: if self.name.is_empty() {
                    key.to_owned()
                } else {
                    format!("{}.{key}", self.name)
                },
                at: value.span().start,
                entries,
                asked: RefCell::default(),
            }),
            None => {
                self.refuse_value(key, value, "a table");
                None
            }
        }
    }

    pub fn table(&self, key: &str) -> Option<Table<'a, 'i>> {
        let value = self.entry(key)?;
        self.inner(key, value)
    }

    /// The tables of an array of tables, `[[key]]`.
    pub fn tables(&self, key: &str) -> Vec<Table<'a, 'i>> {
        let Some(value) = self.entry(key) else {
            return vec![];
        };
        match value.get_ref().as_array() {
            Some(items) => items.iter().filter_map(|item| self.inner(key, item)).collect(),
            None => {
                self.refuse_value(key, value, &format!("tables that begin with `[[{key}]]`"));
                vec![]
            }
        }
    }

    /// Names every key that nothing asked for, with the nearest one that exists, and every required key that is missing.
    pub fn finish(&self) {
        let mut asked = self.asked.borrow_mut();
        for (name, hint) in asked.unknown(&self.keys()) {
            let key = self
                .entries
                .get_key_value(name.as_str())
                .map(|(key, _)| key.span().start);
            self.refuse(&name, key.unwrap_or(self.at), None, hint);
        }
        for key in asked.still_missing() {
            self.refuse("", self.at, None, format!("missing key `{key}`"));
        }
    }
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}
