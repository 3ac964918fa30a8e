//! Reads by keys and says what is to be said of them; reads quantities whose unit stands in the key, which it takes to SI.

use std::cell::Cell;

use super::values::{as_number, Takes, ToSi};
use super::{DeValue, SceneTable, Spanned};
use crate::scene::expect::Expect;
use crate::scene::keys::{Key, KeyGuide, Without};
use crate::scene::names::already_given;
use crate::units::{Dimension, Unit, MAGNITUDES, MAGNITUDE_EXPECTED};

/// A number, in SI.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Number(pub Expect);
/// A number, in SI, or one word in its place, which is read as none.
#[derive(Clone, Copy)]
pub(in crate::scene) struct NumberOr(pub Expect, pub &'static str);
/// A list of numbers, in SI.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Numbers(pub Expect);
/// For each particle a list of numbers, in SI: one list for all, or a table of lists by particle.
#[derive(Clone, Copy)]
pub(in crate::scene) struct NumbersByParticle(pub Expect);
/// A table, whose keys are described in these words.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Inner(pub &'static str);

impl Takes for Number {
    type Value = f64;

    fn in_words(&self) -> String {
        self.0.words.to_owned()
    }

    fn taken(&self, value: &Spanned<DeValue>, to_si: ToSi) -> Option<f64> {
        let number = as_number(value.get_ref())?;
        (self.0.holds)(number).then(|| to_si(number))
    }

    fn written(&self, value: &f64, dimension: Dimension) -> String {
        // a number with a point stays one
        format!("{:?}", dimension.units()[0].from_si(*value))
    }
}

impl Takes for NumberOr {
    type Value = Option<f64>;

    fn in_words(&self) -> String {
        format!("{} or \"{}\"", self.0.words, self.1)
    }

    fn taken(&self, value: &Spanned<DeValue>, to_si: ToSi) -> Option<Option<f64>> {
        if value.get_ref().as_str() == Some(self.1) {
            return Some(None);
        }
        Number(self.0).taken(value, to_si).map(Some)
    }

    fn written(&self, value: &Option<f64>, dimension: Dimension) -> String {
        match value {
            Some(value) => Number(self.0).written(value, dimension),
            None => format!("\"{}\"", self.1),
        }
    }
}

/// What is expected where a list of numbers is.
const LIST: &str = "a list of numbers";

impl Takes for Numbers {
    type Value = Vec<f64>;

    fn in_words(&self) -> String {
        format!("{LIST}, each {}", self.0.words)
    }

    fn read(&self, table: &SceneTable, key: &str, value: &Spanned<DeValue>, to_si: ToSi) -> Option<Vec<f64>> {
        table.list(key, value, self.0, to_si)
    }
}

impl Takes for NumbersByParticle {
    type Value = Vec<Vec<f64>>;

    fn in_words(&self) -> String {
        format!("{LIST}, or a table with a list for each particle")
    }
}

impl Takes for Inner {
    type Value = ();

    fn in_words(&self) -> String {
        self.0.to_owned()
    }
}

impl<'a, 'i> SceneTable<'a, 'i> {
    /// What the file gives under a key; what is not taken there is refused.
    pub fn read<K: Takes>(&self, key: &Key<K>) -> Option<K::Value> {
        if key.without.is_none() && !self.gives(key) {
            let units = key.dimension.units().iter();
            let names = units.map(|unit| format!("{}{}", key.base, unit.suffix)).collect();
            self.read_keys.borrow_mut().missing.push(names);
        }
        self.read_given(key, without(key))
    }

    /// The same, or what holds without the key.
    pub fn read_or<K: Takes>(&self, key: &Key<K, K::Value>) -> K::Value
    where
        K::Value: Clone,
    {
        let given = self.read_given(key, Without::Value(key.takes.written(&key.default, key.dimension)));
        given.unwrap_or_else(|| key.default.clone())
    }

    fn read_given<K: Takes, D>(&self, key: &Key<K, D>, without: Without) -> Option<K::Value> {
        self.with_unit(key, without, |name, value, to_si| {
            key.takes.read(self, name, value, to_si)
        })
    }

    /// The table under a key.
    pub fn inner_table(&self, key: &Key<Inner>) -> Option<SceneTable<'a, 'i>> {
        self.read_keys.borrow_mut().guides.push(guide(key, without(key)));
        self.table(key.base)
    }

    /// Whether the file gives a key, in whichever unit.
    pub fn gives<K: Takes, A>(&self, key: &Key<K, A>) -> bool {
        let mut units = key.dimension.units().iter();
        units.any(|unit| self.has(&format!("{}{}", key.base, unit.suffix)))
    }

    /// For each of the particles what a key gives it; nothing of a key that is not there, or refused.
    pub fn by_particle(&self, key: &Key<NumbersByParticle>, particles: &[&str]) -> Vec<Vec<f64>> {
        let expect = key.takes.0;
        let lists = self.with_unit(key, without(key), |name, value, to_si| {
            if value.get_ref().is_array() {
                let list = self.list(name, value, expect, to_si)?;
                return Some(vec![list; particles.len()]);
            }
            if !value.get_ref().is_table() {
                self.refuse_value(name, value, &key.takes.in_words());
                return None;
            }
            let inner = self.inner(name, value)?;
            let lists = particles
                .iter()
                .map(|particle| match inner.entry(particle) {
                    Some(list) => inner.list(particle, list, expect, to_si),
                    None => Some(vec![]),
                })
                .collect();
            inner.finish();
            lists
        });
        lists.unwrap_or_else(|| vec![vec![]; particles.len()])
    }

    /// The value the file gives a key in one of its units, converted by `read`; two units for one quantity are refused.
    fn with_unit<K: Takes, A, T>(
        &self,
        key: &Key<K, A>,
        without: Without,
        read: impl Fn(&str, &'a Spanned<DeValue<'i>>, ToSi) -> Option<T>,
    ) -> Option<T> {
        let (base, dimension) = (key.base, key.dimension);
        self.read_keys.borrow_mut().guides.push(guide(key, without));
        let mut given: Vec<(String, &'a Spanned<DeValue<'i>>, &'static Unit)> = vec![];
        for unit in dimension.units() {
            let name = format!("{base}{}", unit.suffix);
            if let Some(value) = self.entry(&name) {
                given.push((name, value, unit));
            }
        }
        given.sort_by_key(|(_, value, _)| value.span().start);
        if let [(first, _, _), (second, value, _), ..] = given.as_slice() {
            self.refuse(second, value.span().start, None, already_given(base, first));
            return None;
        }
        let (name, value, unit) = given.first()?;
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

    fn list(&self, key: &str, value: &Spanned<DeValue>, expect: Expect, to_si: ToSi) -> Option<Vec<f64>> {
        let Some(items) = value.get_ref().as_array().filter(|items| !items.is_empty()) else {
            self.refuse_value(key, value, LIST);
            return None;
        };
        items
            .iter()
            .map(|item| self.checked_number(key, item, expect).map(to_si))
            .collect()
    }
}

/// What holds without a key that has no default.
fn without<K: Takes>(key: &Key<K>) -> Without {
    key.without.map_or(Without::Refused, Without::Words)
}

/// What is to be said of a key.
fn guide<K: Takes, A>(key: &Key<K, A>, without: Without) -> KeyGuide {
    let guide = KeyGuide::new(key.base, key.dimension, key.takes.in_words(), key.example);
    KeyGuide {
        without,
        ..guide.means(key.meaning)
    }
}
