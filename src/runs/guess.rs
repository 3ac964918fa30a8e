//! Guesses which column of runs a column of somebody's table is, and in which unit.

use super::headers::called::{called, columns_called, is_short_for, letters, parted};
use super::headers::contradicts_its_symbol;
use super::headers::header::in_plain_signs;
use super::headers::remarks::{in_no_unit, unknown_word};
use super::headers::units::{may_name_a_tool, unit_in_name, unit_of_cell, StatedUnit, UNIT_OR_TOOL};
use super::survey::SurveyedColumn;
use super::words::is_among;
use crate::error::quoted;
use crate::scene::RunColumn;
use crate::units::{Dimension, Unit};

/// A column that somebody's may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Guess {
    pub column: RunColumn,
    pub unit: &'static Unit,
    /// whether the unit, too, is guessed, by the size of the numbers
    pub is_unit_guessed: bool,
}

/// What stands in names of columns that may say which runs to leave out.
const CALLED_LIKE_REASONS: &str =
    "exclu ausgeschl outlier ausrei bad valid gültig comment kommentar bemerkung note notiz remark flag";

/// What columns are called that mark bad runs and say nothing of good ones.
const CALLED_BAD: &str =
    "ungültig ungueltig invalid bad badrun exclude excluded discard discarded reject rejected outlier ausreißer \
     ausreisser verworfen ausgeschlossen";

/// What columns of speeds are called that do not say whether before or after the impact.
const PLAIN_SPEEDS: &str = "v speed velocity geschwindigkeit vitesse velocidad velocità";

/// Whether a column is called as speeds before and after the impact may be, so that one which says more goes first.
pub(super) fn is_plain_speed(name: &str) -> bool {
    is_among(PLAIN_SPEEDS, &parted(name).0)
}

/// A sign, arrow or other mark behind the symbol of a speed, as in `v+`, `v_0*` or `v^2`: it may say that the speed is the one
/// after the impact, or that it is no speed any more.
fn mark_of_speed(name: &str) -> Option<char> {
    const DASHES: [char; 5] = ['-', '−', '–', '⁻', '₋'];
    /// what only sets off a unit or a remark
    const BETWEEN: &str = "/,:;)]}|·±=<>@&%°#";
    let plain = in_plain_signs(name.trim_start());
    let behind = plain.trim_start_matches(|c: char| c.is_alphanumeric() || "_.".contains(c));
    let symbol = letters(&plain[..plain.len() - behind.len()]);
    let symbol = symbol.trim_end_matches(char::is_numeric);
    let mut after = behind.trim_start_matches([' ', '(', '[', '{']).chars();
    let mark = after.next().filter(|c| !c.is_alphanumeric() && !BETWEEN.contains(*c))?;
    let after = match DASHES.contains(&mark) {
        true => after
            .as_str()
            .trim_start_matches(|c: char| c == ' ' || DASHES.contains(&c)),
        false => after.as_str(),
    };
    let is_speed = symbol == "u" || is_among(PLAIN_SPEEDS, symbol);
    // what goes on behind it is a word, as in `v - m/s`
    (is_speed && !after.starts_with(char::is_alphabetic)).then_some(mark)
}

/// Marks in such a column.
const MARKS: &str = "x X xx × * ! ✗ ✘ ✓";

/// Whether a column marks bad runs: by its name, and by marks in it and nothing else.
pub(super) fn marks_bad_runs(column: &SurveyedColumn) -> bool {
    let marks = column.words.iter().all(|word| is_among(MARKS, word));
    is_among(CALLED_BAD, &letters(&column.name)) && marks && !column.words.is_empty()
}

/// Whether a column that is not read may say which runs to leave out.
pub(super) fn may_hold_reasons(name: &str) -> bool {
    let name = letters(name);
    CALLED_LIKE_REASONS.split(' ').any(|part| name.contains(part))
}

/// Whether a column that is not read holds a few words, as one of particles or liquids does.
pub(super) fn may_hold_names(column: &SurveyedColumn) -> bool {
    let holds_days = is_among(CALLED_DAYS, &letters(&column.name));
    let is_of_words = column.largest.is_none() && (1..=MOST_KINDS).contains(&column.words.len());
    is_of_words && !holds_days && !may_hold_reasons(&column.name)
}

/// What is in the names of columns that only runs with a liquid have.
const OF_LIQUIDS: &str = "film schicht layer liquid flüssig fluessig fluid oil öl visk visc wet nass delta δ";

/// Numbers that only runs with a liquid have.
const LIQUID_NUMBERS: &str = "ca we bo oh hd hr";

/// Whether a line about a table speaks of a liquid or a film.
pub(super) fn speaks_of_liquids(line: &str) -> bool {
    const PARTS: &str = "film schicht layer liquid flüssig fluessig fluid visk visc";
    const WORDS: &str = "oil oel öl oils öle wet nass";
    let lower = line.to_lowercase();
    let mut words = lower.split(|c: char| !c.is_alphanumeric());
    // silicone oil is one word in German
    words.any(|word| is_among(WORDS, word) || word.ends_with("öl") || PARTS.split(' ').any(|part| word.contains(part)))
}

/// Whether a column that is not read may hold films: numbers with a unit of length, or named for what only wet runs have.
pub(super) fn may_hold_films(column: &SurveyedColumn) -> bool {
    let stated = parted(&column.name).1.or_else(|| unit_of_cell(&column.unit));
    let units = Dimension::Length.units().iter().chain(Dimension::Thickness.units());
    let mut suffixes = units.map(|unit| unit.suffix);
    let is_length = suffixes.any(|suffix| stated == Some(StatedUnit::Ours(suffix)));
    let name = letters(&column.name);
    let is_of_liquids = OF_LIQUIDS.split(' ').any(|word| name.contains(word)) || is_among(LIQUID_NUMBERS, &name);
    column.largest.is_some() && (is_of_liquids || is_length)
}

/// Whether a column that is not read may tell liquids apart by numbers, as one of viscosities or of shares in a mixture does.
pub(super) fn may_tell_liquids(column: &SurveyedColumn) -> bool {
    const PARTS: &str =
        "liquid fluid flüssig fluessig visk visc glyc glyz wasser water mischung mixture konzentration concentration";
    const SYMBOLS: &str = "oil oel öl η eta mu µ μ ν nu cst mpas wt vol";
    let (name, _) = parted(&column.name);
    let is_called = is_among(SYMBOLS, &name) || PARTS.split(' ').any(|part| name.contains(part));
    is_called && (2..=MOST_KINDS).contains(&column.words.len())
}

/// What columns of days and times are called, which are words to a reader of cells.
const CALLED_DAYS: &str = "date day time datum tag zeit uhrzeit heure jour timestamp";

/// Kinds of particles, or liquids, that one table may well have.
const MOST_KINDS: usize = 20;

/// Units to guess, each with the least and the most that the largest number of a column then may be. They leave out what two
/// units could be: 150 is a height in mm as well as in cm, and a speed in cm/s as well as in mm/s; a sphere of 0.5 is one in
/// mm or in cm, and a film of 0.02, too.
fn sizes(column: RunColumn) -> &'static [(&'static str, f64, f64)] {
    match column {
        RunColumn::Diameter => &[("_mm", 3.0, 30.0), ("_um", 300.0, 3e4), ("_m", 3e-4, 0.0125)],
        RunColumn::Film => &[("_um", 10.0, 3e3), ("_mm", 0.5, 3.0), ("_m", 1e-5, 1e-3)],
        RunColumn::ImpactSpeed | RunColumn::ReboundSpeed => &[("_m_s", 0.05, 8.0), ("_mm_s", 1e3, 8e3)],
        RunColumn::DropHeight | RunColumn::ReboundHeight => &[("_m", 5e-3, 0.9)],
        RunColumn::Restitution => &[("", 0.0, 1.5), ("_percent", 5.0, 110.0)],
        _ => &[],
    }
}

/// What a column's name would end with in the unit that its largest number is of.
fn suffix_by_size(column: RunColumn, largest: f64) -> Option<&'static str> {
    let mut sizes = sizes(column).iter();
    let found = sizes.find(|(_, least, most)| (*least..=*most).contains(&largest));
    found.map(|(suffix, _, _)| *suffix)
}

/// A column whose name is known but not its unit, or whose unit is one that no column of runs has: what it may be, and why it
/// is not guessed, in words that follow.
pub(super) type NotGuessed = (RunColumn, String);

/// What a column may be, of those that are still free. Fails where nothing like it is known, or its unit leaves it open.
pub(super) fn guess(column: &SurveyedColumn, is_free: impl Fn(RunColumn) -> bool) -> Result<Guess, Option<NotGuessed>> {
    let plain = in_plain_signs(&column.name);
    let found = candidate(column, &is_free).filter(|_| !contradicts_its_symbol(&plain));
    let (candidate, stated) = found.ok_or_else(|| {
        let has_unit = parted(&plain).1.is_some();
        let word = unknown_word(&plain, Dimension::Length).filter(|_| !has_unit)?;
        let mut called = columns_called(&plain.replacen(&word, "", 1)).into_iter();
        let meant = called.find(|own| is_free(*own) && unknown_word(&plain, own.dimension()).is_some())?;
        let why = "convert its numbers, or leave the word out where it is no unit";
        Some((meant, format!("but {}: {why}", in_no_unit(&word))))
    })?;
    let not_guessed = |why: String| Some((candidate, why));
    if candidate == RunColumn::Restitution && column.name.trim_start().starts_with('E') && parted(&column.name).0 == "e"
    {
        return Err(not_guessed("but a capital E may be an energy".to_owned()));
    }
    let is_speed = matches!(candidate, RunColumn::ImpactSpeed | RunColumn::ReboundSpeed);
    if let Some(mark) = mark_of_speed(&column.name).filter(|_| is_speed) {
        let mark = quoted(&mark.to_string());
        return Err(not_guessed(format!(
            "but its {mark} may say that it is the speed after the impact, or make another quantity of it"
        )));
    }
    if candidate == RunColumn::Runs && column.is_running_number() {
        return Err(not_guessed(
            "but rises from row to row, as a running number does and no number of repeats".to_owned(),
        ));
    }
    let units = candidate.dimension().units();
    let (suffix, is_unit_guessed) = match stated {
        _ if candidate.dimension() == Dimension::One => ("", false),
        Some(StatedUnit::Ours("_percent"))
            if candidate == RunColumn::Restitution && column.largest.is_some_and(|largest| largest <= 1.5) =>
        {
            let why =
                "but is called per cent and holds no number above 1.5: if these are shares of 1, as a spreadsheet \
                       that shows 85 % holds 0.85, say so in its header";
            return Err(not_guessed(why.to_owned()));
        }
        Some(StatedUnit::Ours(suffix @ "_um"))
            if candidate == RunColumn::Diameter
                && may_name_a_tool(&column.name)
                && column.largest.and_then(|largest| suffix_by_size(candidate, largest)) != Some(suffix) =>
        {
            return Err(not_guessed(format!("but {UNIT_OR_TOOL}")));
        }
        Some(StatedUnit::Ours(suffix)) => (suffix, false),
        Some(StatedUnit::Other(written)) => {
            let why = format!("but is in {}: convert its numbers", quoted(&written));
            return Err(not_guessed(why));
        }
        None => {
            let suffix = column.largest.and_then(|largest| suffix_by_size(candidate, largest));
            let of_most = column.middle().and_then(|middle| suffix_by_size(candidate, middle));
            if let (Some(largest), true) = (column.largest, of_most.is_some() && suffix != of_most) {
                return Err(not_guessed(format!(
                    "but {largest} in row {} is no number in the unit of the others: mend that cell, or state the unit in the header",
                    column.largest_at
                )));
            }
            let suffix = suffix.or((column.largest.is_some() && units[0].suffix.is_empty()).then_some(""));
            let suffix = suffix.ok_or_else(|| not_guessed("but its unit is not known".to_owned()))?;
            (suffix, !suffix.is_empty())
        }
    };
    let unit = candidate.dimension().unit(suffix).ok_or(None)?;
    Ok(Guess {
        column: candidate,
        unit,
        is_unit_guessed,
    })
}

/// Which column of runs a column is called like, and the unit that its header states.
fn candidate(column: &SurveyedColumn, is_free: impl Fn(RunColumn) -> bool) -> Option<(RunColumn, Option<StatedUnit>)> {
    let (name, stated) = parted(&column.name);
    let stated = stated.or_else(|| unit_of_cell(&column.unit));
    // the `in` of `v_in` is a part of the name
    let readings = [
        (name.clone(), stated.clone()),
        (letters(&column.name), unit_of_cell(&column.unit)),
    ];
    let by_name = |(candidate, names): (RunColumn, &str)| {
        let fits = |(name, stated): &&(String, Option<StatedUnit>)| {
            let is_called =
                is_among(names, name) || letters(candidate.base()) == *name || is_short_for(names, &column.name);
            is_called && is_free(candidate) && column_may_be(column, candidate, stated.as_ref())
        };
        let (_, stated) = readings.iter().find(fits)?;
        Some((candidate, stated.clone()))
    };
    let by_part = |(candidate, parts): (RunColumn, &str)| {
        let fits = parts.split(' ').any(|part| name.contains(part)) && may_hold_names(column);
        (fits && is_free(candidate) && stated.is_none()).then_some((candidate, None))
    };
    called("")
        .find_map(by_name)
        .or_else(|| called("like ").find_map(by_part))
}

/// Whether a column may be one of runs by what stands in it, and by the unit that its header states.
fn column_may_be(column: &SurveyedColumn, candidate: RunColumn, stated: Option<&StatedUnit>) -> bool {
    let has_unit = |stated: &StatedUnit| match stated {
        StatedUnit::Ours(suffix) => candidate.dimension().unit(suffix).is_some(),
        // told as such
        StatedUnit::Other(_) => unit_in_name(&column.name, candidate.dimension()).as_ref() == Some(stated),
    };
    if candidate.is_number() {
        // a word among numbers is for the reader to refuse
        let is_known = candidate != RunColumn::Restitution || stated.is_some();
        let has_size = |largest: f64| is_known || suffix_by_size(candidate, largest).is_some();
        let fits = column.largest.is_some_and(has_size);
        fits && stated.is_none_or(has_unit)
    } else {
        let is_of_names = matches!(candidate, RunColumn::Particle | RunColumn::Liquid);
        stated.is_none() && !(is_of_names && column.has_more)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::columns::TableHeader;
    use crate::runs::survey::Survey;
    use crate::runs::tests::examples;

    fn guessed(name: &str, cells: &[&str]) -> Option<(String, bool)> {
        let mut survey = Survey::new(TableHeader {
            names: vec![name.to_owned()],
            ..TableHeader::default()
        });
        for cell in cells {
            survey.add(2, [*cell]);
        }
        let guess = guess(&survey.columns[0], |_| true).ok()?;
        Some((
            format!("{}{}", guess.column.base(), guess.unit.suffix),
            guess.is_unit_guessed,
        ))
    }

    /// Nothing is guessed of what is unknown, of words for numbers, of a unit that cannot be or of two that could, or of
    /// reasons.
    #[test]
    fn columns_are_known_by_the_names_laboratories_give_them() {
        for (answer, columns) in examples("guess") {
            let (ours, is_unit_guessed) = match answer.strip_suffix(" by size") {
                Some(ours) => (ours, true),
                None => (answer, false),
            };
            let expected = (ours != "nothing").then(|| (ours.to_owned(), is_unit_guessed));
            for column in columns {
                let (name, cell) = column.split_once(" = ").expect("a name and a cell");
                assert_eq!(guessed(name, &[cell]), expected, "{name}");
            }
        }
        assert_eq!(guessed("", &["1"]), None);
        for name in examples("mark").into_iter().flat_map(|(_, names)| names) {
            assert_eq!(mark_of_speed(name), None, "{name}");
        }
    }

    #[test]
    fn one_number_of_another_size_tells_no_unit() {
        for (name, cells) in [
            ("e", ["0.81", "0.77", "7.9", "0.74"]),
            ("v", ["0.9", "1100", "1.4", "1.6"]),
            ("D", ["4", "4000", "4", "6"]),
        ] {
            assert_eq!(guessed(name, &cells), None, "{name}");
        }
        // runs that stuck among per cent, and slow ones among fast
        assert!(guessed("e", &["0", "81", "77", "1.2", "74"]).is_some_and(|(ours, _)| ours == "restitution_percent"));
        assert!(guessed("v", &["0.04", "0.06", "3"]).is_some_and(|(ours, _)| ours == "impact_speed_m_s"));
    }

    #[test]
    fn a_running_number_counts_no_repeats() {
        for cells in [
            ["11", "12", "13", "14", "15", "16"],
            ["1", "2", "3", "1", "2", "3"],
            ["9", "4", "7", "5", "6", "8"],
        ] {
            assert_eq!(guessed("n", &cells), None, "{cells:?}");
        }
        for cells in [["5", "5", "6", "5", "4", "5"], ["3", "5", "3", "5", "3", "5"]] {
            assert!(guessed("n", &cells).is_some(), "{cells:?}");
        }
    }
}
