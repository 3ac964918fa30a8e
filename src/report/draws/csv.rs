//! Writes one line a draw, as R's posterior reads it, and reads such a table back.

use std::fmt::Write;

use csv::{ReaderBuilder, StringRecord, Writer};

use super::arrays::DrawSize;
use crate::error::{quoted, Error, Problem};

/// Draws of some quantities: `.chain`, `.iteration`, `.draw` (each from 1), then a named column each.
///
/// A column holds a number for each draw, chain after chain, else the table cannot be written. Numbers have the digits that
/// bring the same f64 back; a name with a comma is quoted.
pub fn table(size: DrawSize, columns: &[(&str, Vec<f64>)]) -> Result<String, Error> {
    let fail = |reason: String| Error::Internal {
        doing: "write draws.csv",
        reason,
    };
    if let Some((name, values)) = columns.iter().find(|(_, values)| values.len() != size.total()) {
        let DrawSize { chains, draws } = size;
        let found = format!("{name}: {} values", values.len());
        return Err(fail(format!("{found} for {chains} x {draws} draws")));
    }
    let names = columns.iter().map(|(name, _)| *name);
    let mut header = Writer::from_writer(vec![]);
    let written = header.write_record([".chain", ".iteration", ".draw"].into_iter().chain(names));
    written.map_err(|error| fail(error.to_string()))?;
    let header = header.into_inner().map_err(|error| fail(error.to_string()))?;
    let mut text = String::from_utf8(header).map_err(|error| fail(error.to_string()))?;
    for draw in 0..size.total() {
        let (chain, iteration) = (draw / size.draws + 1, draw % size.draws + 1);
        // a String takes whatever is written to it
        let _ = write!(text, "{chain},{iteration},{}", draw + 1);
        for (_, values) in columns {
            let _ = write!(text, ",{:?}", values[draw]);
        }
        text.push('\n');
    }
    Ok(text)
}

/// The values of some columns of a table of ours with so many draws.
///
/// Fails where the table was cut short or is not ours: a column missing, a line too short, a cell that is no number.
pub fn read(text: &str, columns: &[&str], draws: usize) -> Result<Vec<Vec<f64>>, Problem> {
    let problem = |line: Option<u64>, found: String, expected: String| Problem {
        line,
        place: String::new(),
        found: Some(found),
        expected,
    };
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut record = StringRecord::new();
    let mut next = |record: &mut StringRecord| {
        let there = reader.read_record(record);
        there.map_err(|error| problem(None, error.to_string(), "expected a table of draws".to_owned()))
    };
    next(&mut record)?;
    let header = record.len();
    let mut places = vec![];
    for column in columns {
        let place = record.iter().position(|name| name == *column);
        let expected = || format!("expected {}", quoted(column));
        places.push(place.ok_or_else(|| problem(Some(1), "no such column".to_owned(), expected()))?);
    }
    let mut values = vec![vec![]; columns.len()];
    let mut found = 0;
    while next(&mut record)? {
        let line = record.position().map(csv::Position::line);
        if record.len() != header {
            let expected = format!("expected {header}");
            return Err(problem(line, format!("{} cells", record.len()), expected));
        }
        for (column, place) in values.iter_mut().zip(&places) {
            let cell = &record[*place];
            let value = cell.parse();
            column.push(value.map_err(|_| problem(line, quoted(cell), "expected a number".to_owned()))?);
        }
        found += 1;
    }
    // the end of the last line tells a number from the beginning of one
    if found != draws || !text.ends_with('\n') {
        let cut = if text.ends_with('\n') { "" } else { ", the last one cut" };
        return Err(problem(
            None,
            format!("{found} draws{cut}"),
            format!("expected {draws}"),
        ));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: DrawSize = DrawSize { chains: 2, draws: 2 };

    fn column<'n>(name: &'n str, values: &[f64]) -> (&'n str, Vec<f64>) {
        (name, values.to_vec())
    }

    #[test]
    fn draws_count_from_one_and_come_back_to_the_last_bit() {
        let k = [0.1 + 0.2, 1e-300, -0.0, f64::MAX];
        let e = [1.0, f64::NAN, f64::INFINITY, 0.5];
        let text =
            table(SIZE, &[column("dry_k[PTFE]", &k), column("e_inf[PTFE,AK10,0.06]", &e)]).expect("as many values");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[0],
            ".chain,.iteration,.draw,dry_k[PTFE],\"e_inf[PTFE,AK10,0.06]\""
        );
        assert_eq!(lines[1], "1,1,1,0.30000000000000004,1.0");
        assert_eq!(lines[2], "1,2,2,1e-300,NaN");
        assert_eq!(lines[3], "2,1,3,-0.0,inf");
        for (line, (k, e)) in lines[1..].iter().zip(k.iter().zip(e)) {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            assert_eq!(cells[3].to_bits(), k.to_bits());
            assert!(cells[4] == e || e.is_nan());
        }
    }

    #[test]
    fn a_column_of_another_length_is_refused() {
        assert!(matches!(
            table(SIZE, &[column("x", &[1.0; 3])]),
            Err(Error::Internal { .. })
        ));
    }

    #[test]
    fn a_table_comes_back_and_a_part_of_it_does_not() {
        let (k, e) = ([0.1 + 0.2, 1e-300, 0.25, 1.5], [1.0, 0.5, 0.25, 12.25]);
        let text = table(SIZE, &[column("e[\"a\",b]", &e), column("k", &k)]).expect("as many values");
        assert_eq!(
            read(&text, &["k", "e[\"a\",b]"], 4).ok(),
            Some(vec![k.to_vec(), e.to_vec()])
        );
        let why = |text: &str, column: &str| {
            let problem = read(text, &[column], 4).err();
            problem.map(|problem| problem.to_string()).unwrap_or_default()
        };
        assert_eq!(why(&text, "l"), "line 1: found no such column, expected `l`");
        for cut in 1..text.len() {
            assert_ne!(why(&text[..cut], "k"), "", "{cut}");
        }
        let (all, _) = text.trim_end().rsplit_once('\n').expect("lines");
        assert_eq!(why(&format!("{all}\n"), "k"), "found 3 draws, expected 4");
        assert_eq!(
            why(&text.replace("0.25", "O.25"), "k"),
            "line 4: found `O.25`, expected a number"
        );
    }
}
