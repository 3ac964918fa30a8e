//! Says which names are allowed, and which allowed name a misspelt one is nearest to.

/// How a table of runs marks a run without liquid.
pub const DRY: &str = "dry";

/// How a table of runs marks a missing cell, besides leaving it empty.
pub const MISSING: &str = "NA";

/// What a drafted scene has in the place of a value that only its author knows.
pub const FILL_IN: &str = "fill in";

/// What a name of a particle or a liquid may hold.
pub const NAME_RULE: &str = "a name of letters, digits, `_`, `-` and `.`";

/// Whether a particle or a liquid may be called so.
pub fn name_is_allowed(name: &str) -> bool {
    !name.is_empty()
        && name
            .chars()
            .all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'))
}

/// The candidate nearest to a misspelt name, if any is near enough to have been meant.
pub fn closest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let near_enough = |candidate: &&str| letters_apart(name, candidate, 2.max(candidate.len() / 3)).is_some();
    nearest(name, candidates.into_iter().filter(near_enough))
}

/// How many letters two names differ by, if by no more than `most`.
///
/// Long names, or two of very different lengths, are not compared letter by letter: the cost is the product of their
/// lengths, and a file that is no table may hold a name of a megabyte.
pub fn letters_apart(name: &str, candidate: &str, most: usize) -> Option<usize> {
    let (letters, wanted) = (name.chars().count(), candidate.chars().count());
    let may_be_near = letters.abs_diff(wanted) <= most && letters.max(wanted) <= LONGEST_COMPARED;
    let apart = may_be_near.then(|| strsim::damerau_levenshtein(name, candidate))?;
    (apart <= most).then_some(apart)
}

/// Letters of the longest name that may be another one misspelt.
const LONGEST_COMPARED: usize = 200;

/// Letters of a name that count when no candidate is near.
const LETTERS_COMPARED: usize = 60;

/// The candidate with the fewest letters to change.
pub(super) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let end = name
        .char_indices()
        .nth(LETTERS_COMPARED)
        .map_or(name.len(), |(at, _)| at);
    let name = &name[..end];
    candidates
        .into_iter()
        .min_by_key(|candidate| (strsim::damerau_levenshtein(name, candidate), *candidate))
}

/// Says that a quantity is given in a second unit, or a second time.
pub(crate) fn already_given(base: &str, first: &str) -> String {
    format!("`{base}` is already given as `{first}`; expected one unit for one quantity")
}

/// Says that a name is not `what` it should be, and which of the names may have been meant.
pub fn name_expected<'a>(what: &str, name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let near = closest(name, names);
    let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    format!("expected {what}{hint}")
}
