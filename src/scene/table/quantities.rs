//! Reads by keys, with the unit that stands in a key, and tells what it reads by.

use std::cell::Cell;

use super::values::{number, Takes, ToSi};
use super::{DeValue, SceneTable, Spanned};
use crate::scene::expect::Expect;
use crate::scene::keys::{KeyGuide, Without};
use crate::scene::names::already_given;
use crate::units::{Dimension, MAGNITUDES, MAGNITUDE_EXPECTED};

/// What is expected where a list of numbers is.
const LIST: &str = "a list of numbers";

/// What is told of a key that may be absent; `keys.txt` says what holds then.
const OPTIONAL: Without = Without::Words("");

impl<'a, 'i> SceneTable<'a, 'i> {
    /// What the file gives under a key that must be there; what is not taken there is refused.
    pub fn required<T>(&self, base: &'static str, takes: Takes<T>) -> Option<T> {
        if !self.gives(base, takes.dimension) {
            let names = takes.dimension.names(base).map(|(name, _)| name);
            self.read_keys.borrow_mut().missing.push(names.collect());
        }
        self.read_key(base, &takes, Without::Refused)
    }

    /// The same of a key that may be absent.
    pub fn read<T>(&self, base: &'static str, takes: Takes<T>) -> Option<T> {
        self.read_key(base, &takes, OPTIONAL)
    }

    /// The same, or what holds without the key.
    pub fn read_or<T>(&self, base: &'static str, takes: Takes<T>, default: T) -> T {
        let without = Without::Value((takes.written)(&default, takes.dimension));
        self.read_key(base, &takes, without).unwrap_or(default)
    }

    fn read_key<T>(&self, base: &'static str, takes: &Takes<T>, without: Without) -> Option<T> {
        self.tell(base, takes.dimension, takes.words.clone(), without);
        self.with_unit(base, takes.dimension, |name, value, to_si| {
            self.taken(name, value, takes, to_si)
        })
    }

    /// The list of numbers, in SI, under a key that may be absent.
    pub fn list(&self, base: &'static str, dimension: Dimension, expect: Expect) -> Option<Vec<f64>> {
        self.tell(base, dimension, format!("{LIST}, each {}", expect.words), OPTIONAL);
        self.with_unit(base, dimension, |name, value, to_si| {
            self.items(name, value, expect, to_si)
        })
    }

    /// The table under a key that may be absent; `takes` says what its keys are.
    pub fn inner_table(&self, base: &'static str, takes: &str) -> Option<SceneTable<'a, 'i>> {
        self.tell(base, Dimension::One, takes, OPTIONAL);
        self.table(base)
    }

    /// The same, as what each of its keys gives; nothing where there is no such table.
    pub fn inner_each<T>(
        &self,
        base: &'static str,
        takes: &str,
        read: impl Fn(&SceneTable<'a, 'i>, String, &[T]) -> Option<T>,
    ) -> Vec<T> {
        let inner = self.inner_table(base, takes);
        inner.map_or_else(Vec::new, |table| table.each(|key, before| read(&table, key, before)))
    }

    /// For each of the particles a list of numbers, in SI: one list for all, or a table of lists by particle; nothing of a key
    /// that is not there, or refused.
    pub fn by_particle(
        &self,
        base: &'static str,
        dimension: Dimension,
        expect: Expect,
        particles: &[String],
    ) -> Vec<Vec<f64>> {
        let takes = format!("{LIST}, or a table with a list for each particle");
        self.tell(base, dimension, takes.clone(), OPTIONAL);
        let lists = self.with_unit(base, dimension, |name, value, to_si| {
            if value.get_ref().is_array() {
                let list = self.items(name, value, expect, to_si)?;
                return Some(vec![list; particles.len()]);
            }
            if !value.get_ref().is_table() {
                self.refuse_value(name, value, &takes);
                return None;
            }
            let inner = self.inner(name, value)?;
            let lists = particles
                .iter()
                .map(|particle| match inner.entry(particle) {
                    Some(list) => inner.items(particle, list, expect, to_si),
                    None => Some(vec![]),
                })
                .collect();
            inner.finish();
            lists
        });
        lists.unwrap_or_else(|| vec![vec![]; particles.len()])
    }

    /// Whether the file gives a key, in whichever unit.
    pub fn gives(&self, base: &str, dimension: Dimension) -> bool {
        dimension.names(base).any(|(name, _)| self.has(&name))
    }

    /// Tells of a key what it is read by.
    fn tell(&self, base: &'static str, dimension: Dimension, takes: impl Into<String>, without: Without) {
        let guide = KeyGuide::new(base, dimension, takes, without);
        self.read_keys.borrow_mut().guides.push(guide);
    }

    /// The value the file gives a key in one of its units, converted by `read`; two units for one quantity are refused.
    fn with_unit<T>(
        &self,
        base: &str,
        dimension: Dimension,
        read: impl Fn(&str, &'a Spanned<DeValue<'i>>, ToSi) -> Option<T>,
    ) -> Option<T> {
        let names = dimension.names(base);
        let given = names.filter_map(|(name, unit)| Some((self.entry(&name)?, name, unit)));
        let mut given: Vec<_> = given.collect();
        given.sort_by_key(|(value, ..)| value.span().start);
        if let [(_, first, _), (value, second, _), ..] = given.as_slice() {
            self.refuse(second, value.span().start, None, already_given(base, first));
            return None;
        }
        let (value, name, unit) = given.first()?;
        let out_of_range = Cell::new(false);
        let read = read(name, value, &|x| {
            let si = unit.to_si(x);
            // zero is the business of what the number is expected to be
            let lost = dimension != Dimension::One && x != 0.0 && !MAGNITUDES.contains(&si);
            out_of_range.set(out_of_range.get() || lost);
            si
        });
        if out_of_range.get() {
            self.refuse_value(name, value, MAGNITUDE_EXPECTED);
            return None;
        }
        read
    }

    fn items(&self, key: &str, value: &Spanned<DeValue<'i>>, expect: Expect, to_si: ToSi) -> Option<Vec<f64>> {
        let Some(items) = value.get_ref().as_array().filter(|items| !items.is_empty()) else {
            self.refuse_value(key, value, LIST);
            return None;
        };
        let number = number(expect);
        let items = items.iter().map(|item| self.taken(key, item, &number, to_si));
        items.collect()
    }
}
