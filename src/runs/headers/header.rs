//! Reads a header once: its words, its symbol, what it is called, and the quantities that these name.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use super::super::words::{ends_like, is_among, without_brackets, words_of};
use super::called::called_as;
use super::quantities::{quantities_in, quantities_of_symbol, quantity_of_kind, Quantities, Quantity};
use super::units::kind_beside;
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

/// Words before what a quantity was made from.
pub(super) const SOURCES: &str = "from by via aus durch par using";

/// Words for a quotient.
const RATIOS: &str = "ratio ratios quotient verhältnis verhaeltnis rapport rapporto razón relación отношение";

/// A header as it was read.
pub(super) struct Header<'n> {
    pub name: &'n str,
    /// the same in small letters
    pub lower: String,
    /// of these what stands outside brackets
    pub outside: String,
    pub words: Vec<String>,
    /// what it begins with up to a sign, its capitals kept
    pub symbol: &'n str,
    /// its letters and digits without a unit
    pub letters: String,
    /// the columns that are called so
    pub called: Vec<RunColumn>,
    /// the quantities of its words
    pub named: Quantities,
    /// those of its symbol, as far as these may be in the unit that stands beside it
    pub of_symbol: Quantities,
    /// what that unit is of, where its symbol stands for nothing in such a unit
    pub of_unit: Option<&'static Quantity>,
}

impl<'n> Header<'n> {
    pub fn new(name: &'n str) -> Header<'n> {
        let lower = name.to_lowercase();
        let symbol = name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        let (letters, mut called) = called_as(name);
        let all_of_symbol = quantities_of_symbol(symbol);
        let mut of_symbol = all_of_symbol.clone();
        let mut of_unit = None;
        if let Some((kind, written)) = kind_beside(symbol, name) {
            of_symbol.retain(|quantity| quantity.may_be_in(kind, &written));
            if of_symbol.len() < all_of_symbol.len() {
                called.retain(|column| of_symbol.iter().any(|quantity| quantity.shares_units_with(*column)));
                // of anything but a speed these are milliseconds
                let kind = if written == "ms" { "time" } else { kind };
                of_unit = quantity_of_kind(kind).filter(|_| of_symbol.is_empty());
            }
        }
        Header {
            name,
            outside: without_brackets(&lower),
            words: words_of(&lower).map(str::to_owned).collect(),
            symbol,
            letters,
            called,
            named: quantities_in(&lower),
            of_symbol,
            of_unit,
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

    /// Whether its words name a quantity of a column.
    pub fn names(&self, column: RunColumn) -> bool {
        self.named.iter().any(|quantity| quantity.is_of(column))
    }

    /// Whether a word of it says that it is a quotient.
    pub fn is_called_ratio(&self) -> bool {
        self.has_end(RATIOS)
    }

    pub fn is_quotient(&self) -> bool {
        self.is_called_ratio() || self.contains("/ :") || self.has("over")
    }

    /// What stands behind its first slash, in small letters.
    pub fn divisor(&self) -> Option<&str> {
        self.lower.split_once('/').map(|(_, after)| after.trim())
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

/// What a column holds.
pub(super) fn in_few_words(column: RunColumn) -> &'static str {
    let means = column.guide().meaning.trim_start_matches("of a mean: ");
    let ends = [",", ";", " ("].into_iter().filter_map(|end| means.find(end));
    &means[..ends.min().unwrap_or(means.len())]
}
