//! Says of each key of a scene what it is called, what is taken under it, what holds without it and what it means.
//!
//! The reader reads by a [`Key`], and every text about scenes is made of the same ones.

use std::borrow::Cow;

use crate::units::Dimension;

/// A key of a table of a scene.
#[derive(Clone, Copy)]
pub(super) struct Key<K, D = ()> {
    /// its name, to which the dimension adds a unit
    pub base: &'static str,
    /// its units
    pub dimension: Dimension,
    /// what is taken under it
    pub takes: K,
    /// what holds without it, in words; `None` of one that must be there, or has a default
    pub without: Option<&'static str>,
    /// what holds without it, as a value; nothing of a key without a default
    pub default: D,
    /// what it means, in a few words
    pub meaning: &'static str,
    /// what a scene may give, in the usual unit
    pub example: &'static str,
}

impl<K: Copy> Key<K> {
    /// A key under which this is taken, and which must be there unless it is said what holds without it.
    pub const fn new(base: &'static str, takes: K) -> Key<K> {
        Key::of(base, Dimension::One, takes)
    }

    /// The same of a quantity whose unit stands in the key.
    pub const fn of(base: &'static str, dimension: Dimension, takes: K) -> Key<K> {
        Key {
            base,
            dimension,
            takes,
            without: None,
            default: (),
            meaning: "",
            example: "",
        }
    }

    pub const fn means(self, meaning: &'static str) -> Key<K> {
        Key { meaning, ..self }
    }

    pub const fn example(self, example: &'static str) -> Key<K> {
        Key { example, ..self }
    }

    /// The same that may be absent; in words what then.
    pub const fn optional(self, without: &'static str) -> Key<K> {
        Key {
            without: Some(without),
            ..self
        }
    }

    /// The same with what holds in its absence.
    pub const fn defaults_to<T>(self, value: T) -> Key<K, T> {
        Key {
            base: self.base,
            dimension: self.dimension,
            takes: self.takes,
            without: None,
            default: value,
            meaning: self.meaning,
            example: self.example,
        }
    }
}

/// What is to be said of a key.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyGuide {
    /// its name without a unit
    pub base: &'static str,
    /// its units
    pub dimension: Dimension,
    /// what is taken under it
    pub takes: Cow<'static, str>,
    /// what holds without it
    pub without: Without,
    /// what it means, in a few words
    pub meaning: &'static str,
    /// what a scene may give, in the usual unit
    pub example: Cow<'static, str>,
}

/// What holds without a key, to be said.
#[derive(Debug, Clone, PartialEq)]
pub enum Without {
    /// the scene is refused
    Refused,
    /// this value, as a scene would give it
    Value(String),
    /// what these words say
    Words(&'static str),
}

impl KeyGuide {
    /// What is to be said of a key that must be there.
    pub(super) fn new(
        base: &'static str,
        dimension: Dimension,
        takes: impl Into<Cow<'static, str>>,
        example: impl Into<Cow<'static, str>>,
    ) -> KeyGuide {
        KeyGuide {
            base,
            dimension,
            takes: takes.into(),
            without: Without::Refused,
            meaning: "",
            example: example.into(),
        }
    }

    pub(super) fn means(self, meaning: &'static str) -> KeyGuide {
        KeyGuide { meaning, ..self }
    }

    /// The same of one that may be absent; in words what then.
    pub(super) fn without(self, words: &'static str) -> KeyGuide {
        KeyGuide {
            without: Without::Words(words),
            ..self
        }
    }

    /// Its name in the usual unit.
    pub fn usual_name(&self) -> String {
        format!("{}{}", self.base, self.dimension.units()[0].suffix)
    }

    /// What stands after the equals sign: what holds without the key, else an example.
    pub fn usual_value(&self) -> &str {
        match &self.without {
            Without::Value(value) => value,
            _ => &self.example,
        }
    }
}

/// A table of a scene, with what is to be said of its keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// its head, as `[data]`; empty above all tables
    pub head: &'static str,
    /// what it holds, in a sentence without its full stop
    pub about: String,
    /// whether it says no more than no such table where it has no keys
    pub may_be_empty: bool,
    /// its keys, in the order they are told
    pub keys: Vec<KeyGuide>,
}

impl Section {
    /// A table that says something by being there.
    pub(super) fn new(head: &'static str, about: impl Into<String>, keys: Vec<KeyGuide>) -> Section {
        Section {
            head,
            about: about.into(),
            may_be_empty: false,
            keys,
        }
    }

    /// The same of one that says no more than no such table where it has no keys.
    pub(super) fn that_may_be_empty(self) -> Section {
        Section {
            may_be_empty: true,
            ..self
        }
    }
}
