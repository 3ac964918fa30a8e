//! Says what a header tells of the numbers below it, and refuses one that tells another thing than the key it stands under.
//!
//! | file | job |
//! |---|---|
//! | `units.rs` | reads the units that headers state, by `units.txt` |
//! | `called.rs` | knows what laboratories call the columns of runs, by `called.txt` |
//! | `quantities.rs` | holds the quantities that a header may name, by `quantities.txt` |
//! | `header.rs` | reads a header once: its words, its symbol, what it is called, and the quantities that these name |
//! | `conversions.rs` | knows what a factor, a power or a difference turns into the quantity of a column |
//! | `heights.rs` | tells which point of the sphere a height refers to, and what it is measured from |
//! | `spreads.rs` | tells a standard deviation from a standard error, and both from other spreads |
//! | `named.rs` | tells which quantity a header names in place of the one that its column takes |
//! | `remarks.rs` | asks about a word in the place of a unit that is no unit and no remark of `remarks.txt` |
//! | `examples.txt` | headers and cells that laboratories write, with what must be made of them |

pub(super) mod called;
mod conversions;
pub(super) mod header;
pub(super) mod heights;
mod named;
mod quantities;
pub(super) mod remarks;
mod spreads;
pub(super) mod units;

use super::words::is_among;
use crate::scene::RunColumn;
use conversions::known_conversion;
use header::{in_few_words, Header, MEASURED};
pub(super) use named::constant_named;
use named::named_quantity;
use spreads::other_spread;
use units::{may_name_a_tool, UNIT_OR_TOOL};

/// Words of a column that marks the runs to keep.
const KEPT: &str =
    "in valid valide gültig gueltig ok good gut use used usable keep kept include included brauchbar bon accept \
                    accepted pass passed is to fit verwendet verwendbar ordnung i o io válido valido";

/// Whether the unit beside the symbol of a header is none that it may have, as in `d (s)`.
pub(super) fn contradicts_its_symbol(name: &str) -> bool {
    Header::new(name).of_unit.is_some()
}

/// What a header names in place of the quantity of a column that is read under a key, and what to do about it; `None` where it
/// names none.
pub(super) fn other_quantity(name: &str, column: RunColumn, key: &str) -> Option<String> {
    let header = Header::new(name);
    if let Some(expected) = known_conversion(&header, column) {
        return Some(expected);
    }
    if column == RunColumn::Exclude && header.words.iter().all(|word| is_among(KEPT, word)) {
        return Some(format!(
            "by its name it marks the runs to keep; `{key}` takes why a run is left out: add a column that marks the others, \
             and name that one"
        ));
    }
    if column == RunColumn::Diameter && !key.ends_with("_um") && may_name_a_tool(name) {
        return Some(format!("by its name it may be in µm, but {UNIT_OR_TOOL}"));
    }
    let is_number = |word: &String| is_among("number nr no nummer index id", word);
    let counts_no_runs = header.words.last().is_some_and(is_number) || header.has("stuck failed dof");
    if column == RunColumn::Runs && counts_no_runs {
        return Some(format!(
            "by its name it does not count the runs of a row, as `{key}` does: name the right column"
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
