//! Says of each key of a scene what it is called, what is taken under it, what holds without it and what it means.
//!
//! The reader reads by a [`Key`], and every text about scenes is made of the same ones.

use crate::units::Dimension;

/// A key of a table of a scene.
pub(super) struct Key<K, A> {
    /// its name, to which the dimension adds a unit
    pub base: &'static str,
    /// what is taken under it
    pub takes: K,
    /// what holds without it
    pub absent: A,
    /// what it means, in a few words
    pub meaning: &'static str,
    /// what a scene may give, in the usual unit
    pub example: &'static str,
}

/// What is taken under a key.
pub(super) trait Takes {
    /// What kind of quantity it is, and so which units its name may end with.
    fn dimension(&self) -> Dimension {
        Dimension::One
    }

    /// What a message names as expected.
    fn in_words(&self) -> String;
}

/// A value that can stand as what holds without a key.
pub(super) trait Writes: Takes {
    /// what is read
    type Value;

    /// A value as a scene gives it, in the usual unit.
    fn written(&self, value: &Self::Value) -> String;
}

/// What holds without a key.
pub(super) trait Absence<T> {
    /// what the reader gets
    type Read;
    /// whether the key must be there
    const IS_REQUIRED: bool = false;

    /// What the reader gets of what the file gives, if it gives something that can be read.
    fn settle(&self, given: Option<T>) -> Self::Read;
}

/// The key must be there.
pub(super) struct Required;

/// Without the key there is no such thing; in words what then.
pub(super) struct Optional(pub &'static str);

/// Without the key this holds.
pub(super) struct DefaultsTo<T>(pub T);

impl<T> Absence<T> for Required {
    type Read = Option<T>;
    const IS_REQUIRED: bool = true;

    fn settle(&self, given: Option<T>) -> Option<T> {
        given
    }
}

impl<T> Absence<T> for Optional {
    type Read = Option<T>;

    fn settle(&self, given: Option<T>) -> Option<T> {
        given
    }
}

impl<T: Clone> Absence<T> for DefaultsTo<T> {
    type Read = T;

    fn settle(&self, given: Option<T>) -> T {
        given.unwrap_or_else(|| self.0.clone())
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
    pub takes: String,
    /// what holds without it
    pub without: Without,
    /// what it means, in a few words
    pub meaning: &'static str,
    /// what a scene may give, in the usual unit
    pub example: String,
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

/// A key whose guide can be made, whatever it takes.
pub(super) trait Guided {
    /// What is to be said of it.
    fn guide(&self) -> KeyGuide;
}

fn guide_with<K: Takes, A>(key: &Key<K, A>, without: Without) -> KeyGuide {
    KeyGuide {
        base: key.base,
        dimension: key.takes.dimension(),
        takes: key.takes.in_words(),
        without,
        meaning: key.meaning,
        example: key.example.to_owned(),
    }
}

impl<K: Takes> Guided for Key<K, Required> {
    fn guide(&self) -> KeyGuide {
        guide_with(self, Without::Refused)
    }
}

impl<K: Takes> Guided for Key<K, Optional> {
    fn guide(&self) -> KeyGuide {
        guide_with(self, Without::Words(self.absent.0))
    }
}

impl<K: Writes> Guided for Key<K, DefaultsTo<K::Value>> {
    fn guide(&self) -> KeyGuide {
        guide_with(self, Without::Value(self.takes.written(&self.absent.0)))
    }
}

/// What is to be said of some keys.
pub(super) fn guides(keys: &[&dyn Guided]) -> Vec<KeyGuide> {
    keys.iter().map(|key| key.guide()).collect()
}
