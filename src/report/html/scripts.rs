//! Sets the symbols of a text as print does: what stands behind an underscore below the line, powers above it.

use crate::report::markup::escaped;

/// Symbols with an index behind an underscore. Names of keys and columns begin with none of them alone.
const WITH_INDEX: [&str; 6] = ["e", "St", "σ", "v", "δ̃", "ν"];

/// Symbols whose index is written beside them.
const WITH_LETTER: [(&str, &str); 4] = [
    ("δc", "δ<sub>c</sub>"),
    ("δ̃0", "δ̃<sub>0</sub>"),
    ("ρp", "ρ<sub>p</sub>"),
    ("ρl", "ρ<sub>l</sub>"),
];

/// The pieces of a text: what stands as it is written, each with the HTML of the symbol behind it.
pub(super) fn pieces(text: &str) -> Vec<(&str, String)> {
    let mut pieces = vec![];
    let (mut plain, mut before) = (0, None);
    let mut at = 0;
    while let Some(letter) = text[at..].chars().next() {
        match symbol(&text[at..], before) {
            Some((set, length)) => {
                pieces.push((&text[plain..at], set));
                at += length;
                plain = at;
                before = Some('i');
            }
            None => {
                at += letter.len_utf8();
                before = Some(letter);
            }
        }
    }
    pieces.push((&text[plain..], String::new()));
    pieces
}

/// The symbol or power that a text begins with, as HTML, and how many bytes it takes; `before`: the letter before it.
fn symbol(text: &str, before: Option<char>) -> Option<(String, usize)> {
    if let Some((power, _)) = text.strip_prefix("^(").and_then(|rest| rest.split_once(')')) {
        return Some((format!("<sup>{}</sup>", escaped(power)), power.len() + 3));
    }
    // not ², which is a power
    let goes_on = |letter: char| letter.is_alphabetic() || letter.is_ascii_digit() || letter == '_';
    if before.is_some_and(goes_on) {
        return None;
    }
    let ends = |rest: &str| !rest.starts_with(|letter| goes_on(letter) || letter == '[');
    for (written, set) in WITH_LETTER {
        if text.strip_prefix(written).is_some_and(ends) {
            return Some((set.to_owned(), written.len()));
        }
    }
    WITH_INDEX.iter().find_map(|base| {
        let rest = text.strip_prefix(base)?.strip_prefix('_')?;
        let length = rest
            .find(|letter: char| !letter.is_ascii_lowercase())
            .unwrap_or(rest.len());
        let (index, rest) = rest.split_at(length);
        (length > 0 && ends(rest)).then(|| (format!("{base}<sub>{index}</sub>"), base.len() + 1 + length))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(text: &str) -> String {
        let pieces = pieces(text).into_iter();
        pieces.flat_map(|(plain, set)| [plain.to_owned(), set]).collect()
    }

    #[test]
    fn indices_and_powers_are_set_and_names_are_not() {
        for (text, expected) in [
            ("e_dry = 1 − k v^(1/5)", "e<sub>dry</sub> = 1 − k v<sup>1/5</sup>"),
            ("St_c = 2 L/e_inf²", "St<sub>c</sub> = 2 L/e<sub>inf</sub>²"),
            ("L = ln(δc/ε), ρp D", "L = ln(δ<sub>c</sub>/ε), ρ<sub>p</sub> D"),
            ("r (r² + τ⁴)^(−1/4)", "r (r² + τ⁴)<sup>−1/4</sup>"),
            ("δ̃_m and δ̃0", "δ̃<sub>m</sub> and δ̃<sub>0</sub>"),
            (
                "impact_speed_m_s, e_inf[PTFE], dry_e_inf, e_inf_x",
                "impact_speed_m_s, e_inf[PTFE], dry_e_inf, e_inf_x",
            ),
            ("^(open", "^(open"),
            ("^(<b>)", "<sup>&lt;b&gt;</sup>"),
        ] {
            assert_eq!(set(text), expected);
        }
    }
}
