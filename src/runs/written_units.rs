//! Reads the units that headers state: in the name of a column, or in the row below or above the names.

use super::other_quantities::has_factor;
use super::words::is_among;
use crate::units::Dimension;

/// A unit that a header states.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StatedUnit {
    /// what our names end with in it
    Ours(&'static str),
    /// one that no column of runs can have, as the header writes it
    Other(String),
}

/// What our names end with in each unit, with the ways that it is written in, in small letters and without blanks.
const UNITS: [(&str, &str); 8] = [
    ("_mm", "mm millimeter millimetre millimeters millimetres"),
    (
        "_um",
        "µm μm um micron microns mikrometer micrometer micrometre micrometers micrometres",
    ),
    ("_cm", "cm centimeter centimetre zentimeter centimeters centimetres"),
    ("_m", "m meter metre meters metres"),
    ("_m_s", "m/s m/sec ms"),
    ("_cm_s", "cm/s cm/sec cms"),
    ("_mm_s", "mm/s mm/sec mms"),
    ("_percent", "% percent percents pct prozent"),
];

/// Units that no column of runs can have, written in the same way.
const OTHER_UNITS: &str =
    "in in. inch inches zoll pouce pouces \" ″ ” '' ft ft. foot feet ' ′ yd mil mils thou nm dm km mph km/h kmh \
     kph ft/s fps in/s ips m/min ° °c deg degree degrees grad rad px px/s px/frame pixels/frame pixel pixels ‰ \
     sec hz mv kg mg ml µl μl ul mm² mm³ cm² cm³ m² m³ m/s² m²/s²";

/// The unit that is written so, perhaps with a power of ten before it; `None` where none is.
pub(super) fn unit_of(text: &str) -> Option<StatedUnit> {
    plain_unit(text).or_else(|| scaled_unit(text))
}

fn plain_unit(text: &str) -> Option<StatedUnit> {
    let plain: String = text
        .replace(" per ", "/")
        .replace("^2", "²")
        .replace("^3", "³")
        .chars()
        .filter(|c| !c.is_whitespace() && !"_^-⁻¹1·⋅".contains(*c))
        .flat_map(char::to_lowercase)
        .collect();
    let mut ours = UNITS.iter().filter(|(_, written)| is_among(written, &plain));
    let other = || is_among(OTHER_UNITS, &plain).then(|| StatedUnit::Other(text.trim().to_owned()));
    ours.next().map(|(suffix, _)| StatedUnit::Ours(suffix)).or_else(other)
}

/// A unit with a power of ten before it, as `1e-5 m`, `10^-5 m` or `10⁻⁵ m`: ours where it is one, as 1e-6 m is µm.
fn scaled_unit(text: &str) -> Option<StatedUnit> {
    let text = text.trim();
    let plain = with_plain_exponents(text.trim_start_matches(['x', '×', '*', '·', ' ']));
    let after = ["1e", "1E", "10^", "10**"]
        .iter()
        .find_map(|start| plain.strip_prefix(start))?;
    let end = after.find(|c: char| !(c.is_ascii_digit() || "+-−".contains(c)))?;
    let power: i32 = after[..end].replace('−', "-").parse().ok()?;
    let unit = plain_unit(after[end..].trim_start_matches([' ', '·', '×', '*']))?;
    let StatedUnit::Ours(suffix) = unit else {
        return Some(StatedUnit::Other(text.to_owned()));
    };
    let own = [Dimension::Length, Dimension::Speed].into_iter();
    let own = own.filter_map(|dimension| dimension.power_of(suffix, power)).next();
    Some(own.map_or_else(
        || StatedUnit::Other(text.to_owned()),
        |unit| StatedUnit::Ours(unit.suffix),
    ))
}

/// A text with `^-5` in place of `⁻⁵`.
fn with_plain_exponents(text: &str) -> String {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    let mut plain = String::new();
    let mut was_raised = false;
    for c in text.chars() {
        let digit = RAISED.chars().position(|raised| raised == c);
        let lowered = match digit {
            Some(digit) => char::from_digit(digit as u32, 10),
            None if c == '⁻' => Some('-'),
            None => None,
        };
        if lowered.is_some() && !was_raised {
            plain.push('^');
        }
        was_raised = lowered.is_some();
        plain.push(lowered.unwrap_or(c));
    }
    plain
}

/// The same of a cell of a row of units, which may have brackets around it.
pub(super) fn unit_of_cell(cell: &str) -> Option<StatedUnit> {
    let inside = cell.trim().trim_start_matches(['(', '[']).trim_end_matches([')', ']']);
    unit_of(inside.trim_start().trim_start_matches("in "))
}

/// Whether a row below the names states units and nothing else; `-` and `1` are units of plain numbers.
pub(super) fn is_row_of_units<'c>(cells: impl Iterator<Item = &'c str>) -> bool {
    let mut units = 0;
    for cell in cells.map(str::trim).filter(|cell| !cell.is_empty()) {
        if unit_of_cell(cell).is_some() {
            units += 1;
        } else if !["-", "–", "1", "[-]", "[–]", "[1]", "(-)", "(1)"].contains(&cell) {
            return false;
        }
    }
    units > 0
}

/// The units in the row above the names, in which titles may stand, too; nothing in place of any other cell, and in place of
/// all where a number stands among them: then it is a line about the whole table, as `Diameter, 4.762, mm` is.
pub(super) fn units_above<'c>(cells: impl IntoIterator<Item = &'c str>) -> Vec<String> {
    let cells: Vec<&str> = cells.into_iter().map(str::trim).collect();
    let is_number = |cell: &&str| cell.replace(',', ".").parse::<f64>().is_ok();
    if cells.iter().any(is_number) {
        return vec![];
    }
    let mut cells: Vec<String> = cells.into_iter().map(str::to_owned).collect();
    let others = cells.iter_mut().filter(|cell| unit_of_cell(cell).is_none());
    others.for_each(String::clear);
    cells
}

/// The unit that a cell above a column of some kind states. The `in` above a speed says which speed it is.
pub(super) fn unit_of_cell_above(cell: &str, dimension: Dimension) -> Option<StatedUnit> {
    unit_of_cell(cell).filter(|unit| is_meant(unit, dimension))
}

/// Whether a unit that is written at a quantity is meant as one: at a speed `in` says which speed it is.
fn is_meant(unit: &StatedUnit, dimension: Dimension) -> bool {
    is_length(dimension)
        || !matches!(unit, StatedUnit::Other(text) if text.trim_end_matches('.').eq_ignore_ascii_case("in"))
}

fn is_length(dimension: Dimension) -> bool {
    matches!(dimension, Dimension::Length | Dimension::Thickness)
}

/// What stands before a unit in brackets, and that unit.
pub(super) fn unit_in_brackets(name: &str) -> Option<(&str, StatedUnit)> {
    let groups = name.match_indices(['(', '[']);
    let mut units = groups.filter_map(|(at, _)| {
        let inside = &name[at + 1..];
        let end = inside.find([')', ']']).unwrap_or(inside.len());
        Some((&name[..at], unit_of(&inside[..end])?))
    });
    units.next()
}

/// The unit that the name of a column of some kind states beyond doubt: in brackets, after a slash, a comma or the word
/// `in`, or at its end where it can be nothing else. The `in` of `v_in`, say, is no inch.
pub(super) fn unit_in_name(name: &str, dimension: Dimension) -> Option<StatedUnit> {
    let is_length = is_length(dimension);
    let is_meant = |unit: &StatedUnit| is_meant(unit, dimension);
    if dimension == Dimension::Share && has_factor(&name.to_lowercase()) {
        let is_percent = name.contains("100") && !name.contains("1000");
        let written = StatedUnit::Other(name.trim().to_owned());
        return Some(if is_percent {
            StatedUnit::Ours("_percent")
        } else {
            written
        });
    }
    if let Some((_, unit)) = unit_in_brackets(name).filter(|(_, unit)| is_meant(unit)) {
        return Some(unit);
    }
    let after = |mark: &str| name.split_once(mark).and_then(|(_, after)| unit_of(after));
    let in_words = name.rsplit_once(" in ").and_then(|(_, after)| unit_of(after));
    if let Some(unit) = after("/").or_else(|| after(",")).or(in_words).filter(&is_meant) {
        return Some(unit);
    }
    let trimmed = name.trim_end();
    if let Some(mark) = trimmed.chars().next_back().filter(|c| "%‰°\"″”".contains(*c)) {
        return unit_of(mark.encode_utf8(&mut [0; 4]));
    }
    // the `1e-5 m` of `film 1e-5 m`
    let mut tails = trimmed.match_indices(char::is_whitespace);
    if let Some(unit) = tails.find_map(|(at, _)| scaled_unit(&trimmed[at..])) {
        return Some(unit);
    }
    let last = trimmed
        .rsplit(char::is_whitespace)
        .next()
        .filter(|last| last.len() < trimmed.len());
    // apart from the rest, `m` is the metre of a length, and `mil` the mil of one
    let is_mil = |end: &str| is_length && end.eq_ignore_ascii_case("mil");
    let is_of_length = |end: &str| is_length && (end.eq_ignore_ascii_case("in") || end == "m");
    let last = last.filter(|last| is_clear(last) || is_mil(last) || is_of_length(last));
    let joined = trimmed
        .match_indices('_')
        .map(|(at, _)| trimmed[at + 1..].replace('_', "/"));
    let joined = joined
        .filter(|tail| is_clear(tail) || is_mil(tail))
        .find_map(|tail| unit_of(&tail));
    last.and_then(unit_of).or(joined)
}

/// Whether what ends a name is a unit there, and no index or direction: `m`, `in` and `ms` may be either.
fn is_clear(end: &str) -> bool {
    end.chars().count() > 1
        && !["in", "ms", "mil", "min", "grad", "deg", "rad", "sec", "1", "11"].contains(&end.to_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_states_its_unit_in_any_of_the_usual_ways() {
        let inch = |text: &str| Some(StatedUnit::Other(text.to_owned()));
        let ours = |suffix| Some(StatedUnit::Ours(suffix));
        for (name, unit) in [
            ("Drop Height (in)", inch("in")),
            ("Drop Height [inches]", inch("inches")),
            ("Drop Height in", inch("in")),
            ("drop height, in.", inch("in.")),
            ("h / in", inch("in")),
            ("h\"", inch("\"")),
            ("height (ft)", inch("ft")),
            ("height_ft", inch("ft")),
            ("Fallhöhe in cm", ours("_cm")),
            ("h (above the plate) [mm]", ours("_mm")),
            ("height CM", ours("_cm")),
            ("h_mm", ours("_mm")),
            ("h (m)", ours("_m")),
            ("h", None),
            ("h_m", None),
            ("h (above)", None),
            ("height 1", None),
            ("film m", ours("_m")),
            ("film 1e-5 m", inch("1e-5 m")),
            ("film (10^-5 m)", inch("10^-5 m")),
            ("film / 10⁻⁶ m", ours("_um")),
            ("D [10⁻³ m]", ours("_mm")),
            ("film x 10^-3 mm", ours("_um")),
            ("film (µl)", inch("µl")),
            ("D (mm^2)", inch("mm^2")),
            ("film of run 10 mmm", None),
            ("D mil", inch("mil")),
            ("D_mil", inch("mil")),
        ] {
            assert_eq!(unit_in_name(name, Dimension::Length), unit, "{name}");
        }
        for (name, unit) in [
            ("v_in", None),
            ("v (in)", None),
            ("v in", None),
            ("v_i/v_r", None),
            ("v_mm_s", ours("_mm_s")),
            ("v / cm s^-1", ours("_cm_s")),
            ("v [mph]", inch("mph")),
            ("v (10^-2 m/s)", ours("_cm_s")),
            ("v m", None),
            ("v mil", None),
        ] {
            assert_eq!(unit_in_name(name, Dimension::Speed), unit, "{name}");
        }
        for name in [
            "e [%]",
            "e %",
            "e in %",
            "e%",
            "e (percent)",
            "e_pct",
            "COR x100",
            "100*e",
        ] {
            assert_eq!(unit_in_name(name, Dimension::Share), ours("_percent"), "{name}");
        }
    }

    #[test]
    fn a_row_above_the_names_may_hold_titles_and_units() {
        let of = |cells: &[&str]| units_above(cells.iter().copied());
        assert_eq!(of(&["Drops of May", "(in)", "", "mm"]), ["", "(in)", "", "mm"]);
        assert_eq!(of(&["Trial", "Film"]), ["", ""]);
        assert_eq!(of(&["Diameter", "4,762", "mm"]), [""; 0]);
        assert_eq!(unit_of_cell_above("in", Dimension::Speed), None);
        let inch = Some(StatedUnit::Other("in".to_owned()));
        assert_eq!(unit_of_cell_above("(in)", Dimension::Length), inch);
    }

    #[test]
    fn a_row_of_units_holds_nothing_else() {
        let is_one = |cells: &[&str]| is_row_of_units(cells.iter().copied());
        assert!(is_one(&["", "[µm]", "[cm]", "", "[%]", "-"]));
        assert!(is_one(&["mm", "m/s"]));
        assert!(!is_one(&["PTFE", "mm"]));
        assert!(!is_one(&["", "-", ""]));
        assert!(!is_one(&["mm", "4.5"]));
    }
}
