//! Reads TOML tables whose keys carry units, and names what cannot be used by line, key and value.
//!
//! | file | job |
//! |---|---|
//! | `values.rs` | what may be taken under a key: words, texts and numbers, one or a list |
//! | `quantities.rs` | what stands under a key with its unit, and what is told of the key |
//!
//! The only file that names the TOML crate; the others take its types from here.

mod quantities;
pub(super) mod values;

use std::cell::RefCell;
use std::sync::LazyLock;

use toml::de::{DeTable, DeValue};
use toml::Spanned;

use crate::encoding::line_of;
use crate::error::{quoted, Problem};

use super::document::Document;
use super::keys::{KeyGuide, Section};
use super::names::name_expected;
use super::unknown_keys::ReadKeys;

const NOT_TOML: &str = "not valid TOML";

/// Reads a whole document; the problem is the parser's own when it is no TOML.
pub(super) fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, Problem> {
    DeTable::parse(text).map_err(|error| {
        let span = error.span();
        if let Some(problem) = span.clone().and_then(|span| decimal_comma(text, span.start)) {
            return problem;
        }
        let found = span.clone().and_then(|span| text.get(span)).map(str::trim);
        let found = found.filter(|found| !found.is_empty());
        // some of the parser's own limits have no place
        let line = span.map(|span| line_of(text.as_bytes(), span.start));
        let problem = Problem::new(NOT_TOML, error.message()).on(line);
        problem.found(found.map(quoted))
    })
}

/// Says that the line of a mistake has a number with a decimal comma, if it has one.
fn decimal_comma(text: &str, at: usize) -> Option<Problem> {
    let before = text.get(..at)?;
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let line = text.get(start..)?.lines().next()?;
    let number_after = |(equals, _): (usize, &str)| {
        let value = line[equals + 1..].trim_start();
        let end = value.find(|c: char| !(c.is_ascii_digit() || "+-,".contains(c)));
        let number = &value[..end.unwrap_or(value.len())];
        let (whole, decimals) = number.split_once(',')?;
        let is_number = !whole.is_empty() && decimals.chars().all(|c| c.is_ascii_digit()) && !decimals.is_empty();
        is_number.then_some(number)
    };
    let number = line.match_indices('=').find_map(number_after)?;
    let expected = format!("expected a decimal point: `{}`", number.replace(',', "."));
    let problem = Problem::new(NOT_TOML, expected).on(line_of(text.as_bytes(), start));
    Some(problem.found(quoted(number)))
}

/// One table of the document; remembers which keys were read.
pub(super) struct SceneTable<'a, 'i> {
    document: &'a Document<'i>,
    name: String,
    at: usize,
    entries: &'a DeTable<'i>,
    read_keys: RefCell<ReadKeys>,
}

/// A table without any key.
static EMPTY: LazyLock<DeTable<'static>> = LazyLock::new(DeTable::default);

/// What is read of a table of which nothing is given, and what is to be said of the keys that it was asked for.
pub(super) fn read_nothing<T>(read: impl FnOnce(&SceneTable) -> T) -> (T, Vec<KeyGuide>) {
    let document = Document::new("");
    let table = SceneTable::root(&document, &EMPTY);
    (read(&table), table.read_keys.take().guides)
}

/// What is to be said of a table by what is read of it.
pub(super) fn section<T>(head: &'static str, read: impl FnOnce(&SceneTable) -> T) -> Section {
    Section::new(head, read_nothing(read).1)
}

impl<'a, 'i> SceneTable<'a, 'i> {
    /// The table at the top of a document.
    pub fn root(document: &'a Document<'i>, entries: &'a DeTable<'i>) -> Self {
        SceneTable {
            document,
            name: String::new(),
            at: 0,
            entries,
            read_keys: RefCell::default(),
        }
    }

    /// A table that stands under a key of this one.
    fn below(&self, key: &str, at: usize, entries: &'a DeTable<'i>) -> Self {
        let path = if self.name.is_empty() { "" } else { "." };
        SceneTable {
            name: format!("{}{path}{key}", self.name),
            at,
            ..SceneTable::root(self.document, entries)
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
        let problem = Problem::new(self.place(key), expected).on(self.document.line(at));
        self.document.report(at, problem.found(found));
    }

    /// The place of a name among some. One that is none of them is refused, with that which may have been meant, unless very
    /// many problems were found before.
    pub fn place_of(&self, key: &str, (name, at): (&str, usize), what: &str, names: &[String]) -> Option<usize> {
        let place = names.iter().position(|known| *known == name);
        if place.is_none() {
            let near: &[String] = if self.document.is_full() { &[] } else { names };
            let expected = name_expected(what, name, near.iter().map(String::as_str));
            self.refuse(key, at, Some(quoted(name)), expected);
        }
        place
    }

    /// Says what the file as a whole lacks.
    pub fn refuse_whole(&self, expected: &str) {
        self.document.report(0, Problem::new("", expected));
    }

    fn refuse_value(&self, key: &str, value: &Spanned<DeValue<'i>>, expected: &str) {
        let found = self.document.text.get(value.span()).unwrap_or_default();
        let expected = format!("expected {expected}");
        self.refuse(key, value.span().start, Some(quoted(found.trim())), expected);
    }

    /// Says that the value the file gives for `key` is not what was expected, and repeats it.
    pub fn refuse_given(&self, key: &str, expected: &str) {
        if let Some(value) = self.entries.get(key) {
            self.refuse_value(key, value, expected);
        }
    }

    /// Says that a key cannot be as it is, or is none of this table, and what was expected.
    pub fn refuse_key(&self, key: &str, expected: impl Into<String>) {
        // read, or it would be unknown as well
        self.entry(key);
        self.refuse(key, self.at(key), None, expected);
    }

    /// The line, from 1, that the table starts on.
    pub fn line(&self) -> u64 {
        self.document.line(self.at)
    }

    fn entry(&self, key: &str) -> Option<&'a Spanned<DeValue<'i>>> {
        let value = self.entries.get(key);
        let mut read_keys = self.read_keys.borrow_mut();
        read_keys.keys.insert(key.to_owned(), value.is_some());
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

    /// Whether the value of a key is a table.
    pub fn holds_table(&self, key: &str) -> bool {
        let value = self.entries.get(key);
        value.is_some_and(|value| value.get_ref().as_table().is_some())
    }

    /// The keys the file sets, in its order.
    pub fn keys(&self) -> Vec<String> {
        keys_in_order(self.entries)
    }

    /// What each key that the file sets gives, in its order; `read` also sees what those before gave. No key is left unknown
    /// that `read` has not looked at.
    pub fn each<T>(&self, read: impl Fn(String, &[T]) -> Option<T>) -> Vec<T> {
        let mut all = vec![];
        for key in self.keys() {
            all.extend(read(key, &all));
        }
        self.finish();
        all
    }

    /// The keys of the table under a key, in their order; none where there is no table.
    pub fn keys_of(&self, key: &str) -> Vec<String> {
        let inner = self.entries.get(key).and_then(|value| value.get_ref().as_table());
        inner.map_or_else(Vec::new, keys_in_order)
    }

    fn inner(&self, key: &str, value: &'a Spanned<DeValue<'i>>) -> Option<SceneTable<'a, 'i>> {
        let entries = value.get_ref().as_table();
        if entries.is_none() {
            self.refuse_value(key, value, "a table");
        }
        entries.map(|entries| self.below(key, value.span().start, entries))
    }

    pub fn table(&self, key: &str) -> Option<SceneTable<'a, 'i>> {
        let value = self.entry(key)?;
        self.inner(key, value)
    }

    /// The table under a key, without any key where there is none.
    pub fn table_or_empty(&self, key: &str) -> SceneTable<'a, 'i> {
        self.table(key).unwrap_or_else(|| self.below(key, 0, &EMPTY))
    }

    /// The tables of an array of tables, `[[key]]`.
    pub fn tables(&self, key: &str) -> Vec<SceneTable<'a, 'i>> {
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

    /// Names every key that nothing reads, with the nearest one that exists, and every required key that is missing.
    pub fn finish(&self) {
        let mut read_keys = self.read_keys.borrow_mut();
        for (name, hint) in read_keys.unknown(&self.keys()) {
            let key = self
                .entries
                .get_key_value(name.as_str())
                .map(|(key, _)| key.span().start);
            self.refuse(&name, key.unwrap_or(self.at), None, hint);
        }
        // by their usual names
        for key in read_keys.missing.iter().filter_map(|keys| keys.first()) {
            self.refuse("", self.at, None, format!("missing key `{key}`"));
        }
    }
}

fn keys_in_order(entries: &DeTable) -> Vec<String> {
    let mut keys: Vec<_> = entries.iter().map(|(k, _)| k).collect();
    keys.sort_by_key(|k| k.span().start);
    keys.into_iter().map(|k| k.get_ref().to_string()).collect()
}
