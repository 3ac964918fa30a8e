//! Tells the words of a list and those outside brackets, and knows those of a column that says yes or no of each run.

/// What says no, in small letters.
const NO: &str = "0 0.0 0,0 no n false f nein falsch non faux";

/// What says yes, in small letters.
const YES: &str = "1 1.0 1,0 yes y true t ja j wahr oui vrai si sí x ✓";

/// Whether a word is one of a list, in which a blank stands between each two.
pub(super) fn is_among(list: &str, word: &str) -> bool {
    list.split(' ').any(|own| own == word)
}

/// A name without what stands in brackets.
pub(super) fn without_brackets(name: &str) -> String {
    let mut depth = 0;
    let mut is_outside = |c: char| {
        depth += i32::from("([".contains(c));
        let is_outside = depth == 0;
        depth -= i32::from(")]".contains(c));
        is_outside
    };
    name.chars().filter(|c| is_outside(*c)).collect()
}

/// The words that say no among all that a column holds; none where one of them says neither yes nor no.
pub(crate) fn words_for_no<'w>(words: impl Iterator<Item = &'w str> + Clone) -> Vec<String> {
    let says = |list: &str, word: &str| is_among(list, &word.to_lowercase());
    let all_are_known = words.clone().all(|word| says(NO, word) || says(YES, word));
    if !all_are_known {
        return vec![];
    }
    words.filter(|word| says(NO, word)).map(str::to_owned).collect()
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
