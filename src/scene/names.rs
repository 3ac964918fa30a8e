//! Says which names are allowed, and which known name a misspelt one is nearest to.

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
    let near_enough = |candidate: &&str| strsim::damerau_levenshtein(name, candidate) <= 2.max(candidate.len() / 3);
    nearest(name, candidates.into_iter().filter(near_enough))
}

/// The candidate with the fewest letters to change.
pub(super) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .min_by_key(|candidate| (strsim::damerau_levenshtein(name, candidate), *candidate))
}

/// Says that a name is not `what` it should be, and which of the names may have been meant.
pub fn name_expected<'a>(what: &str, name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let near = closest(name, names);
    let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    format!("expected {what}{hint}")
}
