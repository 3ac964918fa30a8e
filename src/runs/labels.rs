//! Knows the words by which a table marks a row as the mean, the total or the spread of others.

use super::words::{is_among, words_of};

/// What a label says that a row is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Label {
    Mean,
    /// a total or a spread
    Other,
    /// of all runs together
    All,
}

const MEANS: &str =
    "mean average avg ave aver mw ø moy medel 平均 среднее средн mittelwert mittel durchschnitt moyenne media schnitt \
     promedio gemiddelde média";

const OTHERS: &str =
    "total totals sum subtotal std stdev stddev sd rms σ cv var variance varianz min max stdabw summe gesamt \
     standardabweichung stabw écart ecart somme suma totale desviación deviation sem standardfehler iqr spannweite median \
     médiane mediane mediana medián mediaan mdn medianwert zentralwert медиана 中央値 中位数";

/// Words for all runs together.
const ALL: &str = "all alle alles tous tout todos todas tutti tutte";

/// What may follow such a word, besides numbers and single letters, without making a remark of it.
const AFTER: &str =
    "of the all runs series block value values dev deviation error von der des aus reihe serie de du type di \
     del standard mean wert sd std";

/// What may stand before such a word, besides numbers.
const BEFORE: &str =
    "set series block group overall grand arithmetic geometric weighted standard run runs nr lauf versuch trial drops n to \
     bis";

/// Words that are a unit or a threshold behind a number.
const OF_NUMBERS: &str = "min max mw σ";

/// Letters of the longest cell that is looked at.
const LONGEST: usize = 60;

/// What a cell says that its row is; `None` of any other word, and of a remark that only begins with such a word.
pub(super) fn label(cell: &str) -> Option<Label> {
    // most cells are numbers
    if cell.len() > LONGEST || !cell.contains(|c: char| c.is_alphabetic() || "∅∑".contains(c)) {
        return None;
    }
    let lower = cell.to_lowercase();
    match lower.trim() {
        "x\u{304}" | "∅" | "overall" => return Some(Label::Mean),
        "∑" => return Some(Label::Other),
        _ => {}
    }
    let is_digit = |c: char| c.is_ascii_digit();
    let mut words = words_of(&lower);
    let is_before = |word: &str| word.chars().all(is_digit) || is_among(BEFORE, word);
    let first = words.by_ref().find(|word| !is_before(word))?.trim_matches(is_digit);
    let known = [(MEANS, Label::Mean), (OTHERS, Label::Other), (ALL, Label::All)];
    let (_, label) = known.into_iter().find(|(words, _)| is_among(words, first))?;
    let has_number = lower
        .split(first)
        .next()
        .is_some_and(|before| before.contains(is_digit));
    let is_of_number = has_number && (label == Label::All || is_among(OF_NUMBERS, first));
    let is_remark = words.any(|word| {
        let is_counted = word.chars().all(is_digit) || word.chars().count() == 1;
        !is_counted && !is_among(AFTER, word)
    });
    (!is_remark && !is_of_number).then_some(label)
}

/// The columns in which a word for all runs is a name: their first run has one there.
#[derive(Debug, Clone, Default)]
pub(super) struct NamesForAll(Option<Vec<usize>>);

impl NamesForAll {
    /// Looks at the cells of a row, of which the first alone tells.
    pub fn see<'c>(&mut self, cells: impl Iterator<Item = &'c str>) {
        self.0.get_or_insert_with(|| {
            let for_all = cells.enumerate().filter(|(_, cell)| label(cell) == Some(Label::All));
            for_all.map(|(index, _)| index).collect()
        });
    }

    /// What a cell of a column says that its row is.
    pub fn label(&self, index: usize, cell: &str) -> Option<Label> {
        let is_name = || self.0.iter().flatten().any(|column| *column == index);
        label(cell).filter(|label| *label != Label::All || !is_name())
    }
}

/// Whether a cell may be a label or a count: nearly every cell is a number or empty.
pub(super) fn may_mark(cell: &str) -> bool {
    cell.bytes().any(|byte| !byte.is_ascii_digit() && byte != b'.')
}

/// Whether a cell counts rows, as the `n = 12` below a column of names does.
pub(super) fn is_count(cell: &str) -> bool {
    let cell = cell.trim().strip_prefix(['n', 'N', '#']).map(str::trim_start);
    let number = cell.and_then(|cell| cell.strip_prefix(['=', ':'])).map(str::trim);
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::tests::examples;

    #[test]
    fn labels_are_known_and_remarks_are_none() {
        for (expected, cells) in examples("label") {
            for cell in cells {
                let found = label(cell).map_or("none".to_owned(), |label| format!("{label:?}"));
                assert_eq!(found, expected, "{cell}");
            }
        }
        assert_eq!(label(""), None);
    }
}
