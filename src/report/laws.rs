//! Writes the laws of a scene's pairs as CSV, a line a pair, at full precision and in SI.

use minijinja::context;

use super::template::{self, serialized};
use crate::error::Error;
use crate::findings::laws::PairLaw;

/// The laws, a line a pair.
pub(super) const LAWS: &str = "laws.csv";
/// Those that are not √(α + β/v) at some speeds, a line a speed.
pub(super) const TABLE: &str = "laws_table.csv";

/// Both files by their names; names of particles and liquids have no comma.
pub(super) fn files(laws: &[PairLaw]) -> Result<[(String, String); 2], Error> {
    let values = context! { laws => serialized(laws) };
    let file = |name: &str| Ok((name.to_owned(), template::plain(name, &values)?));
    Ok([file(LAWS)?, file(TABLE)?])
}
