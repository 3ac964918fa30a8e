//! Says what a header tells of the numbers below it, and refuses one that tells another thing than the key it stands under.
//!
//! | file | job |
//! |---|---|
//! | `called.rs` | knows what laboratories call the columns of runs, by `called.txt` |
//! | `units.rs` | reads the units that headers state |
//! | `conversions.rs` | knows what a factor, a power or a difference turns into the quantity of a column |
//! | `spreads.rs` | tells a standard deviation from a standard error, and both from other spreads |
//! | `quantities.rs` | tells by words and symbols which quantity a header names, by `quantities.txt` |
//! | `examples.txt` | headers that must be read, and those that must be refused |

pub(super) mod called;
mod conversions;
mod quantities;
mod spreads;
pub(super) mod units;

use super::words::is_among;
use crate::scene::RunColumn;
use conversions::known_conversion;
use quantities::named_quantity;
use spreads::other_spread;

/// Words of a column that marks the runs to keep.
const KEPT: &str = "in valid valide gültig gueltig ok good gut use used keep kept include included brauchbar bon";

/// Columns whose headers name what is measured.
const MEASURED: [RunColumn; 9] = [
    RunColumn::Diameter,
    RunColumn::Film,
    RunColumn::ImpactSpeed,
    RunColumn::ReboundSpeed,
    RunColumn::Restitution,
    RunColumn::DropHeight,
    RunColumn::ReboundHeight,
    RunColumn::Stokes,
    RunColumn::FilmRatio,
];

/// Words and signs of a square root.
const ROOTS: &str = "sqrt √ root wurzel racine ^0.5 **0.5 ^(0.5) ^(1/2) ^1/2 ^½ **(1/2)";

/// What a header holds in place of what its column takes, and the column that takes it.
type Instead = (&'static str, Option<RunColumn>);

/// A header as it is looked through.
struct Header<'n> {
    name: &'n str,
    /// the same in small letters
    lower: String,
    words: Vec<String>,
}

impl<'n> Header<'n> {
    fn new(name: &'n str) -> Header<'n> {
        let lower = name.to_lowercase();
        Header {
            name,
            words: words_of(&lower).map(str::to_owned).collect(),
            lower,
        }
    }

    /// Whether it has a word of a list.
    fn has(&self, list: &str) -> bool {
        self.words.iter().any(|word| is_among(list, word))
    }

    /// The same, or a longer word that ends with one.
    fn has_end(&self, list: &str) -> bool {
        self.words.iter().any(|word| ends_like(list, word))
    }

    /// Whether one of a list stands anywhere in it.
    fn contains(&self, list: &str) -> bool {
        list.split(' ').any(|part| self.lower.contains(part))
    }

    /// What it begins with up to a sign, its capitals kept.
    fn symbol(&self) -> &'n str {
        self.name
            .split(|c: char| !c.is_alphanumeric())
            .next()
            .unwrap_or_default()
    }

    fn has_square_sign(&self) -> bool {
        // the `²⁾` of a footnote squares nothing
        !self.contains("²) ²⁾") && self.contains("² ^2 **2")
    }
}

fn words_of(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
}

/// Whether a word is one of a list, or ends with one as `falltime` does.
fn ends_like(list: &str, word: &str) -> bool {
    let is_end = |own: &str| own.chars().count() >= "time".len() && word.ends_with(own);
    list.split(' ').any(|own| own == word || is_end(own))
}

/// What a header names in place of the quantity of a column that is read under a key, and what to do about it; `None` where it
/// names none.
pub(super) fn other_quantity(name: &str, column: RunColumn, key: &str) -> Option<String> {
    let header = Header::new(name);
    if let Some(expected) = known_conversion(&header, column) {
        return Some(expected.to_owned());
    }
    if column == RunColumn::Exclude && header.words.iter().all(|word| is_among(KEPT, word)) {
        return Some(format!(
            "by its name it marks the runs to keep; `{key}` takes why a run is left out: add a column that marks the others, \
             and name that one"
        ));
    }
    let measured = || named_quantity(&header, column).filter(|_| MEASURED.contains(&column));
    let (found, right) = other_spread(&header, column).or_else(measured)?;
    let step = match right {
        Some(right) => format!("name it as `{}` in the scene's columns", right.usual_name()),
        None => "name the right column, or add one to the table".to_owned(),
    };
    Some(format!(
        "by its name it holds {found}; `{key}` takes {}: {step}",
        in_few_words(column)
    ))
}

/// What a column holds.
fn in_few_words(column: RunColumn) -> &'static str {
    let means = column.guide().meaning.trim_start_matches("of a mean: ");
    let ends = [",", ";", " ("].into_iter().filter_map(|end| means.find(end));
    &means[..ends.min().unwrap_or(means.len())]
}
