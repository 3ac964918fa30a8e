//! Reads fields of JSON files by their paths, and compares them.
//!
//! A path is keys with points between. Of a list every entry is meant, or those that brackets choose: by their fields, as
//! `remarks[code=noise,passed=false]`, or one by its place, as `[0]`.

use std::path::Path;

use serde_json::Value;

/// Says how deep in brackets a text is, character by character.
fn depth() -> impl FnMut(char) -> i32 {
    let mut depth = 0;
    move |c| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        depth
    }
}

/// The parts of a text between separators that stand in no bracket.
fn parts(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut depth = depth();
    text.split(move |c| depth(c) == 0 && c == separator)
}

/// What stands in the bracket that a text begins with, and the text after it.
fn bracket(text: &str) -> (&str, &str) {
    let mut depth = depth();
    let end = text.find(|c| depth(c) == 0).expect("a bracket that is closed");
    (&text[1..end], &text[end + 1..])
}

fn entries(value: &Value) -> Vec<&Value> {
    value.as_array().map_or(vec![value], |list| list.iter().collect())
}

/// A text as it is, anything else as JSON.
fn shown(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Whether an entry has a field of this value, as `code=noise`, or of another, as `film_ratio!=null`.
fn is_chosen(entry: &Value, condition: &str) -> bool {
    let (key, word) = condition.split_once('=').expect("a field and its value");
    let has = |key: &str| shown(&entry[key]) == word;
    key.strip_suffix('!').map_or_else(|| has(key), |key| !has(key))
}

fn chosen<'v>(listed: impl Iterator<Item = &'v Value>, choice: &str) -> Vec<&'v Value> {
    match choice.parse() {
        Ok(place) => listed.skip(place).take(1).collect(),
        Err(_) => listed
            .filter(|entry| parts(choice, ',').all(|condition| is_chosen(entry, condition)))
            .collect(),
    }
}

/// The values at a path.
fn at<'v>(whole: &'v Value, path: &str) -> Vec<&'v Value> {
    let mut found = vec![whole];
    for step in parts(path, '.') {
        let (key, mut choices) = step.split_at(step.find('[').unwrap_or(step.len()));
        let below = found.into_iter().flat_map(entries);
        found = below.filter_map(|value| value.get(key)).collect();
        while !choices.is_empty() {
            let (choice, rest) = bracket(choices);
            found = chosen(found.into_iter().flat_map(entries), choice);
            choices = rest;
        }
    }
    found
}

/// Whether a value is as a comparison with a word says.
fn holds(value: &Value, comparison: &str, word: &str) -> bool {
    let number = |text: &str| -> f64 { text.trim().parse().unwrap_or_else(|_| panic!("{text}: no number")) };
    let own = value.as_f64();
    match comparison {
        "=" => shown(value) == word || own.is_some_and(|own| word.parse() == Ok(own)),
        "!=" => !holds(value, "=", word),
        "has" => shown(value).contains(word),
        "lacks" => !holds(value, "has", word),
        "<" => own.is_some_and(|own| own < number(word)),
        ">" => own.is_some_and(|own| own > number(word)),
        "~" => {
            let (middle, within) = word.split_once('±').expect("a number ± another");
            own.is_some_and(|own| (own - number(middle)).abs() < number(within))
        }
        other => panic!("{other} compares nothing"),
    }
}

/// Holds a line to files in a folder, where a report stands for its findings: `field FILE PATH COMPARISON WORD`, where every
/// value at the path, and at least one, must be so (`.PATH` in place of a word is the value there); `count FILE PATH COMPARISON
/// NUMBER`, of how many values there are; `same FILE FILE PATH`.
#[track_caller]
pub fn assert_line(folder: &Path, line: &str) {
    let read = |name: &str| -> Value {
        let path = folder.join(name);
        let path = if path.is_dir() {
            path.join("findings.json")
        } else {
            path
        };
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{name}: {error}"));
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let words: Vec<&str> = line.splitn(5, [' ', '\n']).collect();
    match words[..] {
        ["field", file, path, comparison, word] => {
            let whole = read(file);
            let found = at(&whole, path);
            // a word may be the value at another path
            let other = word.strip_prefix('.').map(|path| shown(at(&whole, path)[0]));
            let word = other.as_deref().unwrap_or(word);
            let are_so = found.iter().all(|value| holds(value, comparison, word));
            assert!(are_so && !found.is_empty(), "{line}: found {found:?}");
        }
        ["count", file, path, comparison, number] => {
            let whole = read(file);
            let found: Vec<&Value> = at(&whole, path).into_iter().flat_map(entries).collect();
            assert!(
                holds(&found.len().into(), comparison, number),
                "{line}: found {found:?}"
            );
        }
        ["same", file, other, path] => {
            let [own, other] = [file, other].map(read);
            let [own, other] = [&own, &other].map(|whole| at(whole, path));
            assert!(own == other && !own.is_empty(), "{line}: found {own:?}, {other:?}");
        }
        _ => panic!("{line}: no such line"),
    }
}
