//! Knows the words of a column that says yes or no of each run.

/// What says no, in small letters.
const NO: [&str; 11] = [
    "0", "0.0", "0,0", "no", "n", "false", "f", "nein", "falsch", "non", "faux",
];

/// What says yes, in small letters.
const YES: [&str; 16] = [
    "1", "1.0", "1,0", "yes", "y", "true", "t", "ja", "j", "wahr", "oui", "vrai", "si", "sí", "x", "✓",
];

fn is_one_of(words: &[&str], cell: &str) -> bool {
    words.contains(&cell.to_lowercase().as_str())
}

/// The words that say no among all that a column holds; none where one of them says neither yes nor no.
pub(crate) fn words_for_no<'w>(words: impl Iterator<Item = &'w str> + Clone) -> Vec<String> {
    let all_are_known = words.clone().all(|word| is_one_of(&NO, word) || is_one_of(&YES, word));
    if !all_are_known {
        return vec![];
    }
    words.filter(|word| is_one_of(&NO, word)).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_is_said_only_where_every_word_says_yes_or_no() {
        let of = |words: &[&'static str]| words_for_no(words.iter().copied());
        assert_eq!(of(&["0", "1"]), ["0"]);
        assert_eq!(of(&["FALSE"]), ["FALSE"]);
        assert_eq!(of(&["Nein", "n", "ja"]), ["Nein", "n"]);
        for words in [
            &["x"][..],
            &["1"],
            &[],
            &["no", "touched the wall"],
            &["no film"],
            &["00"],
        ] {
            assert_eq!(of(words), [""; 0], "{words:?}");
        }
    }
}
