//! Reads the units that headers state: in the name of a column, or in the row below or above the names.

use std::sync::LazyLock;

use super::super::words::{is_among, without_brackets, words_of};
use crate::units::Dimension;

/// A unit that a header states.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::runs) enum StatedUnit {
    /// what our names end with in it
    Ours(&'static str),
    /// one that no column of runs can have, as the header writes it
    Other(String),
}

/// Powers of metre and second, and of whatever else a unit is made of.
type Powers = [i32; 3];

const LENGTH: Powers = [1, 0, 0];
const TIME: Powers = [0, 1, 0];
const SPEED: Powers = [1, -1, 0];
const SHARE: Powers = [0, 0, 0];
const ANOTHER: Powers = [0, 0, 1];

/// What units are made of.
struct Atom {
    /// how it is written, in small letters
    names: &'static str,
    /// in SI
    size: f64,
    /// what it is of
    kind: &'static str,
    powers: Powers,
}

/// Every one, by `units.txt`.
static ATOMS: LazyLock<Vec<Atom>> = LazyLock::new(|| {
    let atom = |line: &'static str| {
        let (size, names) = line.split_once(": ")?;
        let (size, kind) = size.split_once(' ')?;
        let powers = match kind {
            "length" => LENGTH,
            "time" => TIME,
            "speed" => SPEED,
            "share" => SHARE,
            _ => ANOTHER,
        };
        let size = size.parse().ok()?;
        Some(Atom {
            names,
            size,
            kind,
            powers,
        })
    };
    include_str!("units.txt").lines().filter_map(atom).collect()
});

/// Atoms that are units only with others: `min` is a minimum, `PA` a polyamide, `n` the normal.
const ONLY_WITH_OTHERS: &str = "h hr hour hours ч час min minute minutes n mn pa mpa j w k c l frame kt";

/// What is a unit only where something sets it off, or nothing else is in the name of a length.
const UNCLEAR: &str = "in ins ms sec second seconds seg min grad deg rad foot pied piede fuß fuss";

/// A unit as it is read from a text.
struct Measure {
    size: f64,
    powers: Powers,
    /// what the last atom is of that is no length, time, speed or share
    other: &'static str,
    atoms: usize,
    /// letters of the first atom
    letters: usize,
}

impl Measure {
    /// What it is of, as `quantities.txt` calls it; `another` of what is not known there.
    fn kind(&self) -> &'static str {
        match (self.other, self.powers) {
            (_, LENGTH) => "length",
            (_, TIME) => "time",
            (_, SPEED) => "speed",
            (_, SHARE) => "share",
            (_, [2, 0, 0]) => "area",
            (_, [3, 0, 0]) => "volume",
            (_, [0, -1, 0]) => "frequency",
            (_, [1, -2, 0]) => "acceleration",
            ("mass", [-3, 0, 1]) => "density",
            ("pressure", [0, 1, 1]) => "viscosity",
            ("force", [-1, 0, 1]) => "tension",
            (other, [0, 0, 1]) => other,
            _ => "another",
        }
    }

    fn is_of(&self, dimension: Dimension) -> bool {
        let own = match dimension {
            Dimension::Speed => SPEED,
            Dimension::Share | Dimension::One => SHARE,
            _ => LENGTH,
        };
        self.powers == own
    }
}

/// The unit that is written so, perhaps with a power of ten before it; `None` where none is.
pub(in crate::runs) fn unit_of(text: &str) -> Option<StatedUnit> {
    let text = text.trim();
    let measure = measure(&text.to_lowercase())?;
    let dimension = match measure.powers {
        LENGTH => Some(Dimension::Length),
        SPEED => Some(Dimension::Speed),
        SHARE => Some(Dimension::Share),
        _ => None,
    };
    let units = dimension.map_or(&[][..], Dimension::units);
    let ours = units
        .iter()
        .find(|unit| (unit.to_si(1.0) / measure.size - 1.0).abs() < 1e-9);
    Some(ours.map_or_else(
        || StatedUnit::Other(text.to_owned()),
        |unit| StatedUnit::Ours(unit.suffix),
    ))
}

/// The same, if it is one of a dimension.
pub(super) fn unit_of_kind(text: &str, dimension: Dimension) -> Option<StatedUnit> {
    let is_of_it = measure(&text.to_lowercase()).is_some_and(|read| read.is_of(dimension));
    unit_of(text).filter(|_| is_of_it)
}

/// Reads a product of units, in small letters: `ft/s`, `ft s-1`, `mm per second`, `10^-3 m`, `g cm⁻³`.
fn measure(text: &str) -> Option<Measure> {
    const BETWEEN: [char; 6] = ['_', '·', '⋅', '*', '×', '.'];
    let text = with_plain_exponents(text).replace('−', "-").replace("**", "^");
    let text = text.replace("0.", "0,").replace(BETWEEN, " ").replace('/', " / ");
    let words = text.split_whitespace().map(|word| word.trim_start_matches('-'));
    let mut words = words.filter(|word| !word.is_empty()).peekable();
    let is_slash = |word: &&str| ["/", "per", "pro"].contains(word);
    // what the slash stands after is no part of the text
    if words.peek().is_some_and(is_slash) {
        return None;
    }
    let mut read = Measure {
        size: 1.0,
        powers: [0; 3],
        other: "another",
        atoms: 0,
        letters: 0,
    };
    let (mut is_below, mut needs_others) = (false, false);
    for word in words {
        if is_slash(&word) {
            is_below = true;
            continue;
        }
        if word == "1" && read.atoms > 0 {
            return None;
        }
        if word == "1" || word == "x" {
            continue;
        }
        if let Some(power) = power_of_ten(word, is_below).filter(|_| read.atoms == 0) {
            read.size *= 10f64.powi(power);
            is_below = false;
            continue;
        }
        let is_of_exponent = |c: char| c.is_ascii_digit() || "^-+".contains(c);
        let (name, exponent) = word.split_at(word.find(is_of_exponent).unwrap_or(word.len()));
        let exponent: i32 = match exponent.trim_start_matches('^') {
            "" => 1,
            exponent => exponent.parse().ok()?,
        };
        let atom = ATOMS.iter().find(|atom| is_among(atom.names, name))?;
        // what a length is divided by is a time
        let (size, powers) = match atom.names == "ms mps" && is_below && read.atoms > 0 {
            true => (1e-3, TIME),
            false => (atom.size, atom.powers),
        };
        // the `ms-1` of metres a second
        let exponent = if powers == SPEED && exponent == -1 { 1 } else { exponent };
        // the `h cm` of a height is no hour
        let is_turned = read.powers[1] != 0 && powers[0] != 0;
        let again = is_turned || (0..2).any(|at| read.powers[at] != 0 && powers[at] != 0);
        if again || !(1..=3).contains(&exponent.abs()) {
            return None;
        }
        let signed = if is_below { -exponent } else { exponent };
        read.size *= size.powi(signed);
        (0..2).for_each(|at| read.powers[at] += signed * powers[at]);
        // the pixels a frame are no plain number
        read.powers[2] += powers[2];
        if powers[2] > 0 {
            read.other = atom.kind;
        }
        read.atoms += 1;
        if read.atoms == 1 {
            read.letters = name.chars().count();
        }
        needs_others = read.atoms == 1 && exponent == 1 && is_among(ONLY_WITH_OTHERS, name);
        // the `m_s` of our own names; metre seconds are nobody's
        if read.powers == [1, 1, 0] && powers == TIME {
            read.powers = SPEED;
            read.size /= size.powi(2);
        }
    }
    (read.atoms > 0 && !needs_others).then_some(read)
}

/// The power of `10^-5`, `1e-5`, `10-5`, `0.01` or, below a slash, `100`.
fn power_of_ten(token: &str, is_below: bool) -> Option<i32> {
    let token = token.trim_start_matches(['x', '×']);
    let zeros = |digits: &str| digits.bytes().all(|b| b == b'0').then_some(digits.len() as i32);
    if let Some(digits) = token.strip_prefix("0.").or(token.strip_prefix("0,")) {
        return Some(-1 - zeros(digits.strip_suffix('1')?)?);
    }
    if let Some(zeros) = token.strip_prefix("10").filter(|_| is_below).and_then(zeros) {
        return Some(-1 - zeros);
    }
    let bare = || token.strip_prefix("10").filter(|power| power.starts_with('-'));
    let starts = ["1e", "10^"].iter().find_map(|start| token.strip_prefix(start));
    starts.or_else(bare)?.parse().ok()
}

/// A text with `^-5` in place of `⁻⁵`.
fn with_plain_exponents(text: &str) -> String {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻";
    const PLAIN: &str = "0123456789-";
    let mut plain = String::new();
    let mut was_raised = false;
    for c in text.chars() {
        let mut signs = RAISED.chars().zip(PLAIN.chars());
        let lowered = signs.find(|(raised, _)| *raised == c);
        if lowered.is_some() && !was_raised {
            plain.push('^');
        }
        was_raised = lowered.is_some();
        plain.push(lowered.map_or(c, |(_, plain)| plain));
    }
    plain
}

/// The same of a cell of a row of units, which may have brackets around it; what stands in square brackets is one in any case.
pub(in crate::runs) fn unit_of_cell(cell: &str) -> Option<StatedUnit> {
    let cell = cell.trim();
    let inside = cell.trim_start_matches(['(', '[']).trim_end_matches([')', ']']).trim();
    let is_square = cell.starts_with('[') && cell.ends_with(']') && !is_among(NO_UNITS, &inside.to_lowercase());
    let is_other = || is_square || beside_number(inside).is_some_and(|unit| unit_of(unit).is_some());
    unit_of(inside.trim_start_matches("in ")).or_else(|| is_other().then(|| StatedUnit::Other(inside.to_owned())))
}

/// What is left of a text without the number before or after it by which its unit is multiplied or divided: the `in` of
/// `1/8 in`, the `µm` of `µm/10`; `None` without such a number.
fn beside_number(text: &str) -> Option<&str> {
    const OF_NUMBER: &str = "0123456789.,/⁄ *×·x¼½¾⅓⅔⅕⅒⅛⅜⅝⅞";
    let is_of_number = |c: char| OF_NUMBER.contains(c);
    let has_digit = |number: &str| number.contains(|c: char| c.is_numeric());
    let (after, before) = (
        text.trim_start_matches(is_of_number),
        text.trim_end_matches(is_of_number),
    );
    if has_digit(&text[..text.len() - after.len()]) {
        return Some(after);
    }
    let number = text[before.len()..].trim_start();
    (has_digit(number) && number.starts_with(['/', '*', '×', '·', 'x'])).then_some(before)
}

/// What stands in a row of units where there is none, or names the row; nothing where brackets are empty.
const NO_UNITS: &str = " - – — / 1 n/a none dimensionless dimensionslos ohne unit units einheit einheiten unité unités";

/// Whether a row below the names states units and nothing else; `-` and `1` are units of plain numbers.
pub(in crate::runs) fn is_row_of_units<'c>(cells: impl Iterator<Item = &'c str>) -> bool {
    let mut units = 0;
    for cell in cells
        .map(|cell| cell.trim().to_lowercase())
        .filter(|cell| !cell.is_empty())
    {
        if unit_of_cell(&cell).is_some() {
            units += 1;
        } else if !is_among(NO_UNITS, cell.trim_matches(['[', ']', '(', ')', ' '])) {
            return false;
        }
    }
    units > 0
}

/// The units in the row above the names, in which titles may stand, too; nothing in place of any other cell, and in place of
/// all where a number stands among them: then it is a line about the whole table, as `Diameter, 4.762, mm` is.
pub(in crate::runs) fn units_above<'c>(cells: impl IntoIterator<Item = &'c str>) -> Vec<String> {
    let cells: Vec<&str> = cells.into_iter().map(str::trim).collect();
    let is_number = |cell: &&str| cell.replace(',', ".").parse::<f64>().is_ok();
    if cells.iter().any(is_number) {
        return vec![];
    }
    // a `4.762 mm` or `[draft]` among titles is no unit
    let is_plain = |cell: &&str| unit_of(cell.trim_matches(['[', ']', '(', ')'])).is_some();
    let has_units = cells.iter().any(is_plain);
    let mut cells: Vec<String> = cells.into_iter().map(str::to_owned).collect();
    let others = cells
        .iter_mut()
        .filter(|cell| !has_units || unit_of_cell(cell).is_none());
    others.for_each(String::clear);
    cells
}

/// The unit that a cell above a column of some kind states. The `in` above a speed says which speed it is.
pub(in crate::runs) fn unit_of_cell_above(cell: &str, dimension: Dimension) -> Option<StatedUnit> {
    unit_of_cell(cell).filter(|unit| is_meant(unit, dimension))
}

/// Whether a unit that is written at a quantity is meant as one: at a speed `in` says which speed it is, and a letter beside a
/// plain number is a symbol.
fn is_meant(unit: &StatedUnit, dimension: Dimension) -> bool {
    let StatedUnit::Other(text) = unit else {
        return true;
    };
    let text = text.trim_end_matches('.');
    let is_plain = matches!(dimension, Dimension::Share | Dimension::One);
    let is_symbol = text.chars().all(char::is_alphabetic) && text.chars().count() == 1;
    is_length(dimension) || !(text.eq_ignore_ascii_case("in") || is_plain && is_symbol)
}

fn is_length(dimension: Dimension) -> bool {
    matches!(dimension, Dimension::Length | Dimension::Thickness)
}

/// What stands before a unit in brackets, and that unit.
pub(in crate::runs) fn unit_in_brackets(name: &str) -> Option<(&str, StatedUnit)> {
    let mut units = in_brackets(name).filter_map(|own| Some((own.before, unit_of(own.inside)?)));
    units.next()
}

/// What a unit in brackets is of, or one behind the slash or comma that follows a symbol; and how it is written, in small
/// letters.
pub(super) fn kind_beside(symbol: &str, name: &str) -> Option<(&'static str, String)> {
    let behind = name
        .split_once(['/', ','])
        .filter(|(before, _)| before.trim() == symbol);
    let inside = in_brackets(name).map(|own| own.inside);
    let texts = inside.chain(behind.map(|(_, after)| after));
    let mut texts = texts.map(|text| text.trim().to_lowercase());
    texts.find_map(|text| Some((measure(&text)?.kind(), text)))
}

/// A part of a name in brackets.
pub(super) struct Bracketed<'n> {
    pub before: &'n str,
    pub inside: &'n str,
    is_square: bool,
}

pub(super) fn in_brackets(name: &str) -> impl Iterator<Item = Bracketed<'_>> {
    name.match_indices(['(', '[']).map(|(at, bracket)| {
        let is_square = bracket == "[";
        let inside = &name[at + 1..];
        let end = inside.find(if is_square { ']' } else { ')' });
        let end = end.or(inside.find([')', ']'])).unwrap_or(inside.len());
        Bracketed {
            before: &name[..at],
            inside: &inside[..end],
            is_square,
        }
    })
}

impl Bracketed<'_> {
    /// The unit that stands among other words, as in `(cm/s, mean)`, or is not known, as in `[10 µm]`: of other words in round
    /// brackets nobody can tell, but in square ones a unit is expected.
    fn unit_among_words(&self, dimension: Dimension) -> Option<StatedUnit> {
        let Bracketed { before, inside, .. } = *self;
        let text = inside.split('±').next().unwrap_or_default().trim();
        let is_own = |unit: &str| measure(&unit.to_lowercase()).is_some_and(|read| read.is_of(dimension));
        let is_plain = matches!(dimension, Dimension::Share | Dimension::One);
        let other = StatedUnit::Other(text.to_owned());
        let number = beside_number(text);
        if !is_plain && (number.is_some_and(is_own) || is_made_of_units(text)) {
            return Some(other);
        }
        let pieces = pieces(text);
        // a micrometer is what it was measured with
        let among = pieces
            .iter()
            .filter(|piece| piece.is_unit(dimension) && is_own(piece.text));
        let mut among = among.filter(|piece| !["m", "micrometer"].contains(&piece.text.to_lowercase().as_str()));
        if let Some(piece) = among.next() {
            return unit_of(piece.text);
        }
        let is_exponent = before.ends_with(['^', '*']);
        // the index of a `v[0]`
        let is_index = text.len() == 1 && text.starts_with(char::is_numeric) && before.ends_with(char::is_alphanumeric);
        let is_unknown = match number {
            _ if text.is_empty() || is_exponent || is_index => false,
            Some("") => {
                let is_factor = ["/", "x", "×", "*", "1/", "0.", "0,"]
                    .iter()
                    .any(|start| text.starts_with(start));
                is_factor || self.is_square && !(is_plain && text == "1")
            }
            Some("ths" | "nds") => true,
            Some(unit) if self.is_square => !is_plain || unit_of(unit).is_some(),
            Some(_) => false,
            None if is_among(ARBITRARY, &text.to_lowercase()) => true,
            None if is_plain => false,
            None => self.is_square && !text.eq_ignore_ascii_case("si"),
        };
        is_unknown.then_some(other)
    }
}

/// What is written for a unit of nobody.
const ARBITRARY: &str = "a.u. au arb arb. arb.u. div div. divs divisions ticks counts awg swg";

/// Whether a text is a quotient of units, although none that is known, as `px/fr`.
fn is_made_of_units(text: &str) -> bool {
    let is_atom = |name: &str| ATOMS.iter().any(|atom| is_among(atom.names, name));
    text.contains('/') && text.to_lowercase().split(['/', ' ']).all(is_atom)
}

/// The unit that the name of a column of some kind states beyond doubt: in brackets, after a slash, a comma or the word
/// `in`, or among its words where it can be nothing else. The `in` of `v_in`, say, is no inch.
pub(in crate::runs) fn unit_in_name(name: &str, dimension: Dimension) -> Option<StatedUnit> {
    let stated = undivided_unit(name, dimension)?;
    // the `film [µm] / 10` of another unit
    let outside = without_brackets(name.trim_end());
    let is_divided = beside_number(&outside).is_some_and(|rest| outside.starts_with(rest));
    let is_plain = matches!(dimension, Dimension::Share | Dimension::One);
    Some(match is_divided && !is_plain {
        true => StatedUnit::Other(name.trim().to_owned()),
        false => stated,
    })
}

/// The same, whatever number stands at the end of the name.
fn undivided_unit(name: &str, dimension: Dimension) -> Option<StatedUnit> {
    let is_meant = |unit: &StatedUnit| is_meant(unit, dimension);
    if dimension == Dimension::Share && has_factor(&name.to_lowercase()) {
        let is_percent = name.contains("100") && !name.contains("1000");
        let (percent, written) = (StatedUnit::Ours("_percent"), StatedUnit::Other(name.trim().to_owned()));
        return Some(if is_percent { percent } else { written });
    }
    // a micrometer in brackets may be what it was measured with
    let is_tool = |unit: &StatedUnit| *unit == StatedUnit::Ours("_um") && name.to_lowercase().contains("(micrometer)");
    let in_brackets = unit_in_brackets(name).map(|(_, unit)| unit).filter(is_meant);
    if let Some(unit) = in_brackets.clone().filter(|unit| !is_tool(unit)) {
        return Some(unit);
    }
    let trimmed = name.trim_end();
    // at the end, or set off as in `film (% of D)`; the `± 3 %` of another is an error
    let is_set_off =
        |at: usize| trimmed[..at].trim_end().is_empty() || trimmed[..at].trim_end().ends_with(['(', '[', ',', '/']);
    let ends = trimmed.chars().next_back().filter(|c| "%‰°\"″”".contains(*c));
    let set_off = trimmed
        .char_indices()
        .find(|(at, c)| "%‰".contains(*c) && is_set_off(*at));
    if let Some(mark) = ends.or(set_off.map(|(_, mark)| mark)) {
        return unit_of(mark.encode_utf8(&mut [0; 4]));
    }
    let name = without_brackets(trimmed);
    let pieces = pieces(name.trim_end());
    let mut stated = pieces.iter().filter(|piece| piece.is_unit(dimension));
    let stated = stated.find_map(|piece| unit_of(piece.text).filter(&is_meant));
    stated.or(in_brackets).or_else(|| {
        let behind_slash = trimmed.rsplit_once('/').map(|(before, inside)| Bracketed {
            before,
            inside,
            is_square: false,
        });
        let mut parts = self::in_brackets(trimmed).chain(behind_slash);
        parts.find_map(|part| part.unit_among_words(dimension).filter(&is_meant))
    })
}

/// Whether a name has a word that may be its unit or, of a sphere, the screw that it was measured with, and nothing that tells.
pub(in crate::runs) fn may_name_a_tool(name: &str) -> bool {
    const MICROMETER: &str = "micrometer micrometre mikrometer micromètre micrómetro micrometro";
    let lower = name.to_lowercase();
    let has = |list: &str| words_of(&lower).any(|word| is_among(list, word));
    has(MICROMETER) && !has("µm μm um mm cm screw gauge schraube")
}

/// What to do about such a name.
pub(in crate::runs) const UNIT_OR_TOOL: &str =
    "a micrometer may be what it was measured with: write `mm` or `µm` into its name";

/// A part of a name, between two places where words begin or end, with what stands around it.
struct Piece<'n> {
    before: &'n str,
    text: &'n str,
    after: &'n str,
}

/// Between words.
pub(super) const MARKS: [char; 9] = [' ', '_', '/', ',', ';', ':', '.', '-', '|'];

/// Every part of a name between two places where words begin or end: at a mark, or at the capital of `DropHeight`; the longest
/// first, as the `m/s` of `v_m/s` before its `s`.
fn pieces(name: &str) -> Vec<Piece<'_>> {
    let mut starts = vec![0];
    let mut ends = vec![name.len()];
    let mut before = ' ';
    for (at, c) in name.char_indices() {
        if c.is_whitespace() || MARKS.contains(&c) {
            starts.push(at + c.len_utf8());
            ends.push(at);
        } else if before.is_lowercase() && c.is_uppercase() {
            starts.push(at);
            ends.push(at);
        }
        before = c;
    }
    let all = starts.iter().flat_map(|start| ends.iter().map(|end| (*start, *end)));
    let piece = |(start, end): (usize, usize)| {
        let text = name.get(start..end)?;
        let is_whole = !text.starts_with(MARKS) && !text.trim_end_matches('.').ends_with(MARKS);
        (is_whole && !text.is_empty()).then(|| Piece {
            before: &name[..start],
            text,
            after: &name[end..],
        })
    };
    let mut all: Vec<Piece> = all.filter_map(piece).collect();
    all.sort_by_key(|piece| std::cmp::Reverse(piece.text.len()));
    all
}

impl Piece<'_> {
    /// Whether it is a unit where it stands, if it is written as one, and no index, direction or material.
    fn is_unit(&self, dimension: Dimension) -> bool {
        let before = self.before.trim_end();
        let word = before.rsplit([' ', '_', '.', ',', '=']).next().unwrap_or_default();
        // by a slash, a comma or the word `in`
        let is_set_off =
            before.ends_with(['/', ',', ';', ':', '|']) || ["in", "en", "em"].contains(&word) && word != before;
        let is_last = self.after.trim_start_matches(['.', ' ']).is_empty() || self.after.starts_with([',', ';']);
        let lower = self.text.trim().to_lowercase();
        // the `in` before a unit, and the index of a `v_c m/s`
        let index = lower.split_whitespace().next().filter(|first| *first != lower);
        if index.is_some_and(|first| first == "in" || is_among(ONLY_WITH_OTHERS, first) && !is_set_off) {
            return false;
        }
        let Some(measure) = measure(&lower) else {
            return false;
        };
        let is_whole = self.before.is_empty();
        let has_power = lower.starts_with(['0', '1', 'x', '×', '*']);
        // the unit of a number in the name, as in `4 mm spheres`, is not that of the column
        if has_power || word.parse::<f64>().is_ok() {
            return has_power && is_last && !is_whole;
        }
        if is_set_off && is_last {
            return true;
        }
        if is_whole {
            let is_long = lower.chars().count() > 2 || is_among("mm cm µm μm um", &lower);
            return is_long && !is_among(UNCLEAR, &lower);
        }
        let is_length = is_length(dimension);
        // what stands at a symbol, as in `D_m`, is an index
        let letters = before.trim_end_matches(MARKS).chars().rev();
        let is_behind_word = letters.take_while(|c| c.is_alphabetic()).count() > 2;
        let stands_apart = is_behind_word || self.before.ends_with(char::is_whitespace);
        // apart from the rest, `m` is the metre of a length, and `in` and `mil` the inch and the mil of one
        match lower.as_str() {
            "in" => is_length && is_last,
            "m" => is_length && is_last && stands_apart,
            "mil" => is_length,
            // the `m_s` of a speed is one, the `s_g` of a sphere in gas none
            _ => !is_among(UNCLEAR, &lower) && (measure.letters > 1 || measure.atoms > 1 && measure.powers[0] != 0),
        }
    }
}

/// Words for the part of a unit that is counted.
const FRACTIONS: &str = "tenths hundredths thousandths zehntel hundertstel tausendstel dixièmes centièmes millièmes mille permille promille";

/// Signs of a product.
const TIMES: [char; 5] = ['*', '×', '·', '⋅', 'x'];

/// Whether a name, in small letters, says that its numbers are multiplied, as `1000 × v` does; the `x 10^-3 mm` of another is
/// a unit.
pub(super) fn has_factor(name: &str) -> bool {
    let are_zeros = |rest: &str| !rest.is_empty() && rest.bytes().all(|b| b == b'0');
    let is_power = |digits: &str| digits.strip_prefix('1').is_some_and(are_zeros);
    let is_number = |c: char| c.is_ascii_digit() || "^.,".contains(c);
    if words_of(name).any(|word| is_among(FRACTIONS, word)) {
        return true;
    }
    // the `10 v` of nobody's unit
    let mut words = name.split_whitespace();
    let is_first = words.next().is_some_and(is_power);
    let is_name = |next: &str| next.starts_with(char::is_alphabetic) && unit_of(next).is_none();
    if is_first && words.next().is_some_and(is_name) {
        return true;
    }
    name.match_indices(TIMES).any(|(at, sign)| {
        let (before, after) = (name[..at].trim_end(), name[at + sign.len()..].trim_start());
        // an `x` inside a word is a letter
        let is_letter = sign == "x" && name[..at].ends_with(char::is_alphabetic);
        let [first, last] = [
            before.rsplit(|c| !is_number(c)).next(),
            after.split(|c| !is_number(c)).next(),
        ];
        !is_letter && [first, last].into_iter().flatten().any(is_power)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::tests::examples;

    #[test]
    fn a_name_states_its_unit_in_any_of_the_usual_ways() {
        for (question, dimension) in [
            ("unit of a length", Dimension::Length),
            ("unit of a speed", Dimension::Speed),
            ("unit of a share", Dimension::Share),
        ] {
            for (answer, names) in examples(question) {
                let unit = match answer {
                    "none" => None,
                    ours if ours.starts_with('_') => Some(StatedUnit::Ours(ours)),
                    other => Some(StatedUnit::Other(other.to_owned())),
                };
                for name in names {
                    assert_eq!(unit_in_name(name, dimension), unit, "{name}");
                }
            }
        }
    }

    #[test]
    fn every_line_of_units_is_read() {
        let lines = include_str!("units.txt").lines();
        assert_eq!(ATOMS.len(), lines.filter(|line| !line.starts_with('#')).count());
    }

    #[test]
    fn a_row_of_units_holds_nothing_else() {
        let is_one = |cells: &[&str]| is_row_of_units(cells.iter().copied());
        assert!(is_one(&["", "[µm]", "[cm]", "", "[%]", "-"]));
        assert!(is_one(&["mm", "m/s"]));
        assert!(is_one(&["Einheit", "mm", "[ ]", "—", "n/a"]));
        assert!(!is_one(&["PTFE", "mm"]));
        assert!(!is_one(&["", "-", ""]));
        assert!(!is_one(&["mm", "4.5"]));
    }
}
