//! Holds a header as it is looked through, and what several files ask of one.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use super::super::words::{is_among, words_of};
use crate::scene::RunColumn;

/// Columns whose headers name what is measured.
pub(super) const MEASURED: [RunColumn; 9] = [
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
pub(super) const ROOTS: &str = "sqrt √ root wurzel racine ^0.5 **0.5 ^(0.5) ^(1/2) ^1/2 ^½ **(1/2)";

/// What a header holds in place of what its column takes, and the column that takes it.
pub(super) type Instead = (&'static str, Option<RunColumn>);

/// A header as it is looked through.
pub(super) struct Header<'n> {
    pub name: &'n str,
    /// the same in small letters
    pub lower: String,
    pub words: Vec<String>,
}

impl<'n> Header<'n> {
    pub fn new(name: &'n str) -> Header<'n> {
        let lower = name.to_lowercase();
        Header {
            name,
            words: words_of(&lower).map(str::to_owned).collect(),
            lower,
        }
    }

    /// Whether it has a word of a list.
    pub fn has(&self, list: &str) -> bool {
        self.words.iter().any(|word| is_among(list, word))
    }

    /// The same, or a longer word that ends with one.
    pub fn has_end(&self, list: &str) -> bool {
        self.words.iter().any(|word| ends_like(list, word))
    }

    /// Whether one of a list stands anywhere in it.
    pub fn contains(&self, list: &str) -> bool {
        list.split(' ').any(|part| self.lower.contains(part))
    }

    /// What it begins with up to a sign, its capitals kept.
    pub fn symbol(&self) -> &'n str {
        self.name
            .split(|c: char| !c.is_alphanumeric())
            .next()
            .unwrap_or_default()
    }

    pub fn has_square_sign(&self) -> bool {
        // the `²⁾` of a footnote squares nothing
        !self.contains("²⁾") && self.contains("² ^2 **2")
    }
}

/// Commands of TeX that are signs, with these; any other says how a text looks.
const SIGNS_OF_TEX: [(&str, &str); 13] = [
    ("dot", "d"),
    ("sqrt", "√"),
    ("mu", "µ"),
    ("delta", "δ"),
    ("Delta", "Δ"),
    ("varepsilon", "ε"),
    ("epsilon", "ε"),
    ("sigma", "σ"),
    ("times", "×"),
    ("cdot", "·"),
    ("pm", "±"),
    ("prime", "'"),
    ("circ", "°"),
];

/// A header without the marks of TeX and in signs of one width: `$v_{\mathrm{in}}$` is v_in, `\frac{h_r}{h_0}` h_r/h_0,
/// `v（m/s）` v(m/s).
pub(in crate::runs) fn in_plain_signs(name: &str) -> Cow<'_, str> {
    /// beside each of these ASCII has the same sign, at this distance
    const FULL_WIDTH: RangeInclusive<char> = '\u{ff01}'..='\u{ff5e}';
    const APART: u32 = 0xfee0;
    if name.contains(|c| FULL_WIDTH.contains(&c)) {
        let narrow = |c: char| char::from_u32(c as u32 - APART).unwrap_or(c);
        let narrow = |c: char| if FULL_WIDTH.contains(&c) { narrow(c) } else { c };
        return Cow::Owned(in_plain_signs(&name.chars().map(narrow).collect::<String>()).into_owned());
    }
    if !name.contains(['$', '\\', '{']) {
        return Cow::Borrowed(name);
    }
    let mut plain = String::new();
    let mut fractions = 0;
    let mut parts = name.split('\\');
    plain.push_str(parts.next().unwrap_or_default());
    for part in parts {
        let end = part.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(part.len());
        let (command, after) = part.split_at(end);
        fractions += usize::from(command == "frac");
        let sign = SIGNS_OF_TEX.iter().find(|(own, _)| *own == command);
        plain.push_str(sign.map_or("", |(_, sign)| sign));
        // a thin space
        let after = if command.is_empty() {
            after.trim_start_matches([',', ';', ':', '!'])
        } else {
            after
        };
        plain.push_str(if sign.is_some() { after.trim_start() } else { after });
    }
    plain = plain.replacen("}{", "/", fractions);
    plain.retain(|c| !"${}".contains(c));
    Cow::Owned(plain.trim().to_owned())
}

/// Whether a word is one of a list, or ends with one as `falltime` does.
pub(super) fn ends_like(list: &str, word: &str) -> bool {
    let is_end = |own: &str| own.chars().count() >= "time".len() && word.ends_with(own);
    list.split(' ').any(|own| own == word || is_end(own))
}

/// What a column holds.
pub(super) fn in_few_words(column: RunColumn) -> &'static str {
    let means = column.guide().meaning.trim_start_matches("of a mean: ");
    let ends = [",", ";", " ("].into_iter().filter_map(|end| means.find(end));
    &means[..ends.min().unwrap_or(means.len())]
}
