//! Remembers which keys of a table are read, and finds those that nothing reads.

use std::collections::BTreeMap;

use super::keys::KeyGuide;
use super::names::{closest, nearest};
use crate::error::PROBLEMS_SHOWN;
use crate::units::{names_in_words, Dimension};

/// The keys a table may have.
#[derive(Default)]
pub(super) struct ReadKeys {
    /// every key; true once it was found
    pub keys: BTreeMap<String, bool>,
    /// what is to be said of those that were asked for, in that order
    pub guides: Vec<KeyGuide>,
    /// required keys that are not there, each with all its units
    pub missing: Vec<Vec<String>>,
}

impl ReadKeys {
    /// A message for each key that nothing reads.
    pub fn unknown(&mut self, names: &[String]) -> Vec<(String, String)> {
        let mut unknown: Vec<(String, String)> = vec![];
        for name in names.iter().filter(|name| !self.keys.contains_key(*name)) {
            // beyond what is printed no key is compared with every one that is read
            if unknown.len() >= PROBLEMS_SHOWN {
                unknown.push((name.clone(), "unknown key".to_owned()));
                continue;
            }
            let free = || self.keys.iter().filter(|(_, found)| !**found).map(|(k, _)| k.as_str());
            let all = || self.keys.keys().map(String::as_str);
            let unit = |base: &str, dimension: Dimension| {
                let names = names_in_words(base, dimension);
                let usual = format!("{base}{}", dimension.units()[0].suffix);
                (Some(usual), format!("a unit is part of the key; expected {names}"))
            };
            let (meant, hint) = if let Some(key) = self.guides.iter().find(|key| key.base == name) {
                unit(name, key.dimension)
            } else if let Some(near) = closest(name, free()).or_else(|| closest(name, all())) {
                (Some(near.to_owned()), format!("unknown key; did you mean `{near}`?"))
            } else if let Some((base, dimension)) = self.in_an_unknown_unit(name) {
                unit(base, dimension)
            } else if let Some(near) = nearest(name, free()).or_else(|| nearest(name, all())) {
                (None, format!("unknown key; the nearest known one is `{near}`"))
            } else {
                (None, "unknown key".to_owned())
            };
            // a key under another name is reported once
            self.missing
                .retain(|keys| !meant.as_ref().is_some_and(|meant| keys.contains(meant)));
            unknown.push((name.clone(), hint));
        }
        unknown
    }

    /// The quantity a key means that names a unit nobody knows.
    fn in_an_unknown_unit(&self, name: &str) -> Option<(&str, Dimension)> {
        let names_it = |base: &str| name.strip_prefix(base).is_some_and(|unit| unit.starts_with('_'));
        let with_units = self.guides.iter().filter(|key| key.dimension != Dimension::One);
        let longest = with_units
            .filter(|key| names_it(key.base))
            .max_by_key(|key| key.base.len())?;
        Some((longest.base, longest.dimension))
    }
}
