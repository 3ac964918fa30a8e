//! Reads words, texts and plain numbers, one or a list.

use super::{DeValue, SceneTable, Spanned};
use crate::error::quoted;
use crate::scene::expect::Expect;
use crate::units::Dimension;

/// Takes a number of a file to SI.
pub(in crate::scene) type ToSi<'f> = &'f dyn Fn(f64) -> f64;

/// What is taken under a key.
pub(in crate::scene) trait Takes {
    /// what is read
    type Value;

    /// What a message names as expected.
    fn in_words(&self) -> String;

    /// The value, if it is what is taken; `to_si` is what its unit does. Nothing of what is read in another way.
    fn taken(&self, _: &Spanned<DeValue>, _: ToSi) -> Option<Self::Value> {
        None
    }

    /// The same; what is not taken is refused. `key` is the name the file gives.
    fn read(&self, table: &SceneTable, key: &str, value: &Spanned<DeValue>, to_si: ToSi) -> Option<Self::Value> {
        let taken = self.taken(value, to_si);
        if taken.is_none() {
            table.refuse_value(key, value, &self.in_words());
        }
        taken
    }

    /// A value as a scene gives it in the usual unit; nothing of what never stands as a default.
    fn written(&self, _: &Self::Value, _: Dimension) -> String {
        String::new()
    }
}

/// A text.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Text;
/// Texts with their places in the file, at least one, a single one without brackets, too.
#[derive(Clone, Copy)]
pub(in crate::scene) struct TextOrTexts;
/// A list of texts with their places.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Texts;
/// Yes or no.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Switch;
/// A whole number from the first to the second.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Count(pub u64, pub u64);
/// One of some words, each with what it stands for.
#[derive(Clone, Copy)]
pub(in crate::scene) struct OneOf<T> {
    words: fn() -> Vec<(&'static str, T)>,
    /// words of earlier versions, each refused with the one that replaces it
    replaced: &'static [(&'static str, &'static str)],
}
/// Some of some words, or one word that stands for no list.
#[derive(Clone, Copy)]
pub(in crate::scene) struct SomeOf<T> {
    pub words: fn() -> Vec<(&'static str, T)>,
    pub instead: &'static str,
}

/// Largest count: one above it could not be worked through, nor is it exact as f64.
pub(in crate::scene) const MOST_COUNTED: u64 = 1 << 53;

impl Takes for Text {
    type Value = String;

    fn in_words(&self) -> String {
        "a text in quotes".to_owned()
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<String> {
        value.get_ref().as_str().map(str::to_owned)
    }
}

fn located(item: &Spanned<DeValue>) -> Option<(String, usize)> {
    Some((item.get_ref().as_str()?.to_owned(), item.span().start))
}

impl Takes for TextOrTexts {
    type Value = Vec<(String, usize)>;

    fn in_words(&self) -> String {
        "a text in quotes, or a list of such".to_owned()
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<Self::Value> {
        match value.get_ref().as_array() {
            Some(items) if items.is_empty() => None,
            Some(items) => items.iter().map(located).collect(),
            None => located(value).map(|text| vec![text]),
        }
    }
}

impl Takes for Texts {
    type Value = Vec<(String, usize)>;

    fn in_words(&self) -> String {
        "a list of texts in quotes".to_owned()
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<Self::Value> {
        value.get_ref().as_array()?.iter().map(located).collect()
    }
}

impl Takes for Switch {
    type Value = bool;

    fn in_words(&self) -> String {
        "true or false".to_owned()
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<bool> {
        value.get_ref().as_bool()
    }

    fn written(&self, value: &bool, _: Dimension) -> String {
        value.to_string()
    }
}

impl Takes for Count {
    type Value = u64;

    fn in_words(&self) -> String {
        let Count(least, most) = self;
        match *most {
            MOST_COUNTED => format!("a whole number of {least} or more"),
            _ => format!("a whole number from {least} to {most}"),
        }
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<u64> {
        let integer = value.get_ref().as_integer()?;
        let count = u64::from_str_radix(integer.as_str(), integer.radix()).ok()?;
        (self.0..=self.1).contains(&count).then_some(count)
    }

    fn written(&self, value: &u64, _: Dimension) -> String {
        value.to_string()
    }
}

fn quoted_words<T>(words: &[(&'static str, T)]) -> Vec<String> {
    words.iter().map(|(name, _)| format!("\"{name}\"")).collect()
}

impl<T> OneOf<T> {
    /// One of the words that a function lists.
    pub const fn of(words: fn() -> Vec<(&'static str, T)>) -> OneOf<T> {
        OneOf { words, replaced: &[] }
    }

    /// The same, where earlier versions had other words.
    pub const fn replacing(self, replaced: &'static [(&'static str, &'static str)]) -> OneOf<T> {
        OneOf { replaced, ..self }
    }
}

impl<T: PartialEq> Takes for OneOf<T> {
    type Value = T;

    fn in_words(&self) -> String {
        quoted_words(&(self.words)()).join(" or ")
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<T> {
        let word = value.get_ref().as_str()?;
        let mut words = (self.words)().into_iter();
        words.find(|(name, _)| *name == word).map(|(_, choice)| choice)
    }

    fn read(&self, table: &SceneTable, key: &str, value: &Spanned<DeValue>, to_si: ToSi) -> Option<T> {
        let word = value.get_ref().as_str();
        let taken = self.taken(value, to_si);
        match self.replaced.iter().find(|(old, _)| Some(*old) == word) {
            Some((old, new)) => {
                let expected = format!("expected \"{new}\", which replaces it");
                table.refuse(key, value.span().start, Some(quoted(old)), expected);
            }
            None if taken.is_none() => table.refuse_value(key, value, &self.in_words()),
            None => {}
        }
        taken
    }

    fn written(&self, value: &T, _: Dimension) -> String {
        let words = (self.words)();
        let word = words.iter().find(|(_, stands_for)| stands_for == value);
        word.map_or_else(String::new, |(name, _)| format!("\"{name}\""))
    }
}

impl<T: Copy> Takes for SomeOf<T> {
    type Value = Option<Vec<T>>;

    fn in_words(&self) -> String {
        let words = quoted_words(&(self.words)()).join(", ");
        format!("\"{}\" or a list out of {words}", self.instead)
    }

    fn taken(&self, value: &Spanned<DeValue>, _: ToSi) -> Option<Option<Vec<T>>> {
        if value.get_ref().as_str() == Some(self.instead) {
            return Some(None);
        }
        let known = (self.words)();
        let choice = |item: &Spanned<DeValue>| {
            let text = item.get_ref().as_str()?;
            let word = known.iter().find(|(name, _)| *name == text);
            word.map(|(_, choice)| *choice)
        };
        let items = value.get_ref().as_array()?;
        items.iter().map(choice).collect::<Option<Vec<T>>>().map(Some)
    }

    /// Only no list stands as what holds without a key.
    fn written(&self, _: &Option<Vec<T>>, _: Dimension) -> String {
        format!("\"{}\"", self.instead)
    }
}

impl SceneTable<'_, '_> {
    /// The text under a name that the scene gives.
    pub fn text(&self, key: &str) -> Option<String> {
        let value = self.entry(key)?;
        Text.read(self, key, value, &|x| x)
    }

    /// The number under a name that the scene gives.
    pub fn number(&self, key: &str, expect: Expect) -> Option<f64> {
        let value = self.entry(key)?;
        self.checked_number(key, value, expect)
    }

    pub(super) fn checked_number(&self, key: &str, value: &Spanned<DeValue>, expect: Expect) -> Option<f64> {
        let number = as_number(value.get_ref()).filter(|x| (expect.holds)(*x));
        if number.is_none() {
            self.refuse_value(key, value, expect.words);
        }
        number
    }

    /// A fixed number of finite numbers, or nothing if the value is no such list.
    pub fn numbers(&self, key: &str, how_many: usize) -> Option<Vec<f64>> {
        let value = self.entry(key)?;
        let items = value.get_ref().as_array().filter(|items| items.len() == how_many);
        let finite = |item: &Spanned<DeValue>| as_number(item.get_ref()).filter(|x| x.is_finite());
        let numbers: Option<Vec<f64>> = items.and_then(|items| items.iter().map(finite).collect());
        if numbers.is_none() {
            self.refuse_value(key, value, &format!("a list of {how_many} numbers"));
        }
        numbers
    }
}

pub(super) fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}
