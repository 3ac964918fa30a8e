//! Lists what may be taken under a key: words, texts and numbers, one or a list; reads those that no key's guide tells of.

use super::{DeValue, SceneTable, Spanned};
use crate::error::quoted;
use crate::scene::expect::Expect;
use crate::units::Dimension;

/// Takes a number of a file to SI.
pub(super) type ToSi<'f> = &'f dyn Fn(f64) -> f64;

/// The value, if it is what is taken, by what its unit does.
type Take<T> = dyn Fn(&Spanned<DeValue>, ToSi) -> Option<T>;

/// A value as a scene gives it in the usual unit.
type Write<T> = dyn Fn(&T, Dimension) -> String;

/// What is taken under a key.
pub(in crate::scene) struct Takes<T> {
    /// what a message names as expected
    pub words: String,
    pub dimension: Dimension,
    take: Box<Take<T>>,
    /// nothing is written of what never stands as a default
    pub written: Box<Write<T>>,
    /// words of earlier versions, each refused with the one that replaces it
    replaced: &'static [(&'static str, &'static str)],
}

impl<T> Takes<T> {
    fn new(
        words: impl Into<String>,
        take: impl Fn(&Spanned<DeValue>, ToSi) -> Option<T> + 'static,
        written: impl Fn(&T, Dimension) -> String + 'static,
    ) -> Takes<T> {
        Takes {
            words: words.into(),
            dimension: Dimension::One,
            take: Box::new(take),
            written: Box::new(written),
            replaced: &[],
        }
    }

    /// The same of a quantity whose unit stands in the key.
    pub fn of(self, dimension: Dimension) -> Takes<T> {
        Takes { dimension, ..self }
    }

    /// The same, where earlier versions had other words.
    pub fn replacing(self, replaced: &'static [(&'static str, &'static str)]) -> Takes<T> {
        Takes { replaced, ..self }
    }
}

/// A text with its place in the file.
type Located = (String, usize);

fn located(item: &Spanned<DeValue>) -> Option<Located> {
    Some((item.get_ref().as_str()?.to_owned(), item.span().start))
}

fn no_default<T>(_: &T, _: Dimension) -> String {
    String::new()
}

/// A text.
pub(in crate::scene) fn text() -> Takes<String> {
    let take = |value: &Spanned<DeValue>, _: ToSi| value.get_ref().as_str().map(str::to_owned);
    Takes::new("a text in quotes", take, no_default)
}

/// Texts with their places in the file, at least one, a single one without brackets, too.
pub(in crate::scene) fn text_or_texts() -> Takes<Vec<Located>> {
    let take = |value: &Spanned<DeValue>, _: ToSi| match value.get_ref().as_array() {
        Some(items) if items.is_empty() => None,
        Some(items) => items.iter().map(located).collect(),
        None => located(value).map(|text| vec![text]),
    };
    Takes::new("a text in quotes, or a list of such", take, no_default)
}

/// A list of texts with their places.
pub(in crate::scene) fn texts() -> Takes<Vec<Located>> {
    let take = |value: &Spanned<DeValue>, _: ToSi| value.get_ref().as_array()?.iter().map(located).collect();
    Takes::new("a list of texts in quotes", take, no_default)
}

/// Yes or no.
pub(in crate::scene) fn switch() -> Takes<bool> {
    let take = |value: &Spanned<DeValue>, _: ToSi| value.get_ref().as_bool();
    Takes::new("true or false", take, |value, _| value.to_string())
}

/// Largest count: one above it could not be worked through, nor is it exact as f64.
pub(in crate::scene) const MOST_COUNTED: u64 = 1 << 53;

/// A whole number between two, both included.
pub(in crate::scene) fn count(least: u64, most: u64) -> Takes<u64> {
    let words = match most {
        MOST_COUNTED => format!("a whole number of {least} or more"),
        _ => format!("a whole number from {least} to {most}"),
    };
    let take = move |value: &Spanned<DeValue>, _: ToSi| {
        let integer = value.get_ref().as_integer()?;
        let count = u64::from_str_radix(integer.as_str(), integer.radix()).ok()?;
        (least..=most).contains(&count).then_some(count)
    };
    Takes::new(words, take, |value, _| value.to_string())
}

/// A number, in SI.
pub(in crate::scene) fn number(expect: Expect) -> Takes<f64> {
    let take = move |value: &Spanned<DeValue>, to_si: ToSi| {
        let number = as_number(value.get_ref())?;
        (expect.holds)(number).then(|| to_si(number))
    };
    // a number with a point stays one
    let written = |value: &f64, dimension: Dimension| format!("{:?}", dimension.units()[0].from_si(*value));
    Takes::new(expect.words, take, written)
}

/// A number, in SI, or one word in its place, which is read as none.
pub(in crate::scene) fn number_or(expect: Expect, word: &'static str) -> Takes<Option<f64>> {
    let take = move |value: &Spanned<DeValue>, to_si: ToSi| match value.get_ref().as_str() {
        Some(text) => (text == word).then_some(None),
        None => (number(expect).take)(value, to_si).map(Some),
    };
    let written = move |value: &Option<f64>, dimension: Dimension| match value {
        Some(value) => (number(expect).written)(value, dimension),
        None => format!("\"{word}\""),
    };
    Takes::new(format!("{} or \"{word}\"", expect.words), take, written)
}

fn quoted_words<T>(words: &[(&'static str, T)], between: &str) -> String {
    let quoted: Vec<String> = words.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    quoted.join(between)
}

/// One of some words, each with what it stands for.
pub(in crate::scene) fn one_of<T: Clone + PartialEq + 'static>(words: impl Into<Vec<(&'static str, T)>>) -> Takes<T> {
    let known = words.into();
    let words = known.clone();
    let take = move |value: &Spanned<DeValue>, _: ToSi| {
        let word = value.get_ref().as_str()?;
        let found = known.iter().find(|(name, _)| *name == word);
        found.map(|(_, choice)| choice.clone())
    };
    let expected = quoted_words(&words, " or ");
    let written = move |value: &T, _: Dimension| {
        let word = words.iter().find(|(_, choice)| choice == value);
        word.map_or_else(String::new, |(name, _)| format!("\"{name}\""))
    };
    Takes::new(expected, take, written)
}

/// Some of some words, or one word that stands for no list.
pub(in crate::scene) fn some_of<T: Clone + PartialEq + 'static>(
    words: impl Into<Vec<(&'static str, T)>>,
    instead: &'static str,
) -> Takes<Option<Vec<T>>> {
    let words = words.into();
    let expected = format!("\"{instead}\" or a list out of {}", quoted_words(&words, ", "));
    let one = one_of(words);
    let take = move |value: &Spanned<DeValue>, to_si: ToSi| match value.get_ref().as_str() {
        Some(text) => (text == instead).then_some(None),
        None => {
            let items = value.get_ref().as_array()?.iter();
            items
                .map(|item| (one.take)(item, to_si))
                .collect::<Option<Vec<T>>>()
                .map(Some)
        }
    };
    // only no list stands as what holds without a key
    Takes::new(expected, take, move |_, _| format!("\"{instead}\""))
}

impl<'i> SceneTable<'_, 'i> {
    /// A value, if it is what is taken; what is not is refused. `key` is the name the file gives.
    pub(super) fn taken<T>(&self, key: &str, value: &Spanned<DeValue<'i>>, takes: &Takes<T>, to_si: ToSi) -> Option<T> {
        let taken = (takes.take)(value, to_si);
        if taken.is_none() {
            let word = value.get_ref().as_str();
            match takes.replaced.iter().find(|(old, _)| Some(*old) == word) {
                Some((old, new)) => {
                    let expected = format!("expected \"{new}\", which replaces it");
                    self.refuse(key, value.span().start, Some(quoted(old)), expected);
                }
                None => self.refuse_value(key, value, &takes.words),
            }
        }
        taken
    }

    /// The text under a name that the scene gives.
    pub fn text(&self, key: &str) -> Option<String> {
        self.taken(key, self.entry(key)?, &text(), &|x| x)
    }

    /// The number under a name that the scene gives.
    pub fn number(&self, key: &str, expect: Expect) -> Option<f64> {
        self.taken(key, self.entry(key)?, &number(expect), &|x| x)
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

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}
