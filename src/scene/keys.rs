//! Says of each key of a scene what it is called, what is taken under it, what holds without it and what it means.
//!
//! The reader tells what it reads by; what else is to be said stands in `keys.txt`. Every text about scenes is made of both.

use super::names::NAME_RULE;
use crate::units::Dimension;

/// A block a table, a line a key; the first line says what the table holds.
pub(super) const KEYS: &str = include_str!("keys.txt");

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
    /// What the reader tells of a key.
    pub(super) fn new(
        base: &'static str,
        dimension: Dimension,
        takes: impl Into<String>,
        without: Without,
    ) -> KeyGuide {
        KeyGuide {
            base,
            dimension,
            takes: takes.into(),
            without,
            meaning: "",
            example: String::new(),
        }
    }

    /// The same with what `keys.txt` says of it in the table of this head.
    pub(super) fn in_table(self, head: &str) -> KeyGuide {
        let (_, lines) = told_of(head);
        let mut rows = lines.lines().map(|line| line.split(" | "));
        let Some(mut cells) = rows.find_map(|mut cells| (cells.next() == Some(self.base)).then_some(cells)) else {
            return self;
        };
        let mut cell = || cells.next().unwrap_or_default();
        KeyGuide {
            example: cell().to_owned(),
            meaning: cell(),
            without: match self.without {
                Without::Words(_) => Without::Words(cell()),
                without => without,
            },
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

/// What a table of this head holds, in a sentence without its full stop, and the lines of its keys.
fn told_of(head: &str) -> (&'static str, &'static str) {
    let mut tables = KEYS.split("\n\n").filter_map(|table| table.split_once('\n'));
    let told = |(first, lines): (&'static str, &'static str)| {
        let about = first.strip_prefix(title(head))?.strip_prefix(": ")?;
        Some((about, lines))
    };
    tables.find_map(told).unwrap_or_default()
}

/// What a table of this head is called.
pub(super) fn title(head: &str) -> &str {
    match head {
        "" => "Above all tables",
        head => head,
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
    /// A table with what is to be said of it and of its keys.
    pub(super) fn new(head: &'static str, keys: Vec<KeyGuide>) -> Section {
        Section {
            head,
            about: told_of(head).0.replace("NAME_RULE", NAME_RULE),
            may_be_empty: ["", "[model]", "[priors]", "[sampler]", "[bootstrap]"].contains(&head),
            keys: keys.into_iter().map(|key| key.in_table(head)).collect(),
        }
    }
}
