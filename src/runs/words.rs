//! Tells the words of a list and those outside brackets, and knows those of a column of reasons that keep a run.

/// What says no, in small letters.
const NO: &str = "0 0.0 0,0 no n false f nein falsch non faux";

/// What keeps a run in a column of reasons to leave runs out, whatever else stands there.
const KEEPS: &str =
    "no nein non nej não nao nie нет false falsch faux none keine aucun null nil nan n/a #n/a ok o.k okay i.o fine pass passed \
     accept accepted keep kept good gut bon bueno buono хорошо valid gültig gueltig valide use used include included";

/// Whether a word is one of [`KEEPS`], or dashes or points.
fn keeps(word: &str) -> bool {
    let lower = word.to_lowercase();
    is_among(KEEPS, lower.trim_end_matches(['.', '!'])) || word.chars().all(|c| "-–—−.".contains(c))
}

/// What says yes, in small letters.
const YES: &str = "1 1.0 1,0 yes y true t ja j wahr oui vrai si sí x ✓";

/// Whether a word is one of a list, in which a blank stands between each two.
pub(super) fn is_among(list: &str, word: &str) -> bool {
    list.split(' ').any(|own| own == word)
}

/// Whether a word is one of a list, or ends with one as `falltime` does.
pub(super) fn ends_like(list: &str, word: &str) -> bool {
    let is_end = |own: &str| own.chars().count() >= "time".len() && word.ends_with(own);
    list.split(' ').any(|own| own == word || is_end(own))
}

/// The words of a name.
pub(super) fn words_of(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
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

/// The words among all that a column of reasons to leave runs out holds that keep a run: those that are no reason anywhere and,
/// where every word says yes or no, those that say no.
pub(crate) fn words_for_no<'w>(words: impl Iterator<Item = &'w str> + Clone) -> Vec<String> {
    let says = |list: &str, word: &str| is_among(list, &word.to_lowercase());
    let all_are_known = words.clone().all(|word| says(NO, word) || says(YES, word));
    let is_no = |word: &&str| if all_are_known { says(NO, word) } else { keeps(word) };
    words.filter(is_no).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_keep_a_run_are_no_reasons() {
        let of = |words: &[&'static str]| words_for_no(words.iter().copied());
        assert_eq!(of(&["--", "hit the edge", "O.K.", "."]), ["--", "O.K.", "."]);
        for word in ["Good", "NaN", "null", "fine", "i.O.", "pass", "нет", "nej", "OK!"] {
            assert_eq!(of(&[word, "splash"]), [word]);
        }
        // a tick may mark either, and single letters and numbers may be short for reasons
        for words in [
            &["x"][..],
            &["1"],
            &[],
            &["✓", "✗"],
            &["n", "w"],
            &["0", "2"],
            &["no film"],
            &["not good"],
            &["00"],
            &["?"],
        ] {
            assert_eq!(of(words), [""; 0], "{words:?}");
        }
    }
}
