//! Reads words, texts and plain numbers, one or a list.

use super::{DeValue, Located, SceneTable, Spanned};
use crate::scene::expect::Expect;

impl<'i> SceneTable<'_, 'i> {
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

    pub fn boolean(&self, key: &str) -> Option<bool> {
        let value = self.entry(key)?;
        let found = value.get_ref().as_bool();
        if found.is_none() {
            self.refuse_value(key, value, "true or false");
        }
        found
    }

    pub fn number(&self, key: &str, expect: Expect) -> Option<f64> {
        let value = self.entry(key)?;
        self.checked_number(key, value, expect)
    }

    pub(super) fn checked_number(&self, key: &str, value: &Spanned<DeValue<'i>>, expect: Expect) -> Option<f64> {
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
    pub fn words_or<T: Copy>(&self, key: &str, single_word: &str, choices: &[(&str, T)]) -> Option<Option<Vec<T>>> {
        let value = self.entry(key)?;
        if value.get_ref().as_str() == Some(single_word) {
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
            let expected = format!("\"{single_word}\" or a list out of {}", names.join(", "));
            self.refuse_value(key, value, &expected);
        }
        words.map(Some)
    }

    /// A text or a list of some, with their places.
    pub fn text_or_texts(&self, key: &str) -> Option<Vec<Located<String>>> {
        let value = self.entry(key)?;
        let text = |item: &Spanned<DeValue<'_>>| {
            let value = item.get_ref().as_str()?.to_owned();
            let at = item.span().start;
            Some(Located { value, at })
        };
        let texts = match value.get_ref().as_array() {
            Some(items) if items.is_empty() => None,
            Some(items) => items.iter().map(text).collect(),
            None => text(value).map(|text| vec![text]),
        };
        if texts.is_none() {
            self.refuse_value(key, value, "a text in quotes, or a list of such");
        }
        texts
    }

    /// A list of texts with their places.
    pub fn texts(&self, key: &str) -> Option<Vec<Located<String>>> {
        let value = self.entry(key)?;
        let texts: Option<Vec<_>> = value.get_ref().as_array().and_then(|items| {
            let text = |item: &Spanned<DeValue<'_>>| {
                let value = item.get_ref().as_str()?.to_owned();
                let at = item.span().start;
                Some(Located { value, at })
            };
            items.iter().map(text).collect()
        });
        if texts.is_none() {
            self.refuse_value(key, value, "a list of texts in quotes");
        }
        texts
    }
}

pub(super) fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}
