//! Writes one line a draw, as R's posterior reads it, and reads such a table back.

use std::fmt::Write;

use crate::error::{quoted, Error, Problem};

/// Draws of some quantities: `.chain`, `.iteration`, `.draw` (each from 1), then a column each.
///
/// A column has its values chain after chain, `chains` times `iterations` of them, else the table cannot be written.
/// Numbers have the digits that bring the same f64 back; a name with a comma is quoted.
pub fn table(chains: usize, iterations: usize, columns: &[(&str, &[f64])]) -> Result<String, Error> {
    for (name, values) in columns {
        if values.len() != chains * iterations {
            return Err(Error::Internal {
                doing: "write draws.csv",
                reason: format!("{name}: {} values for {chains} x {iterations} draws", values.len()),
            });
        }
    }
    let mut text = String::from(".chain,.iteration,.draw");
    for (name, _) in columns {
        text.push(',');
        push_name(&mut text, name);
    }
    text.push('\n');
    for draw in 0..chains * iterations {
        let (chain, iteration) = (draw / iterations + 1, draw % iterations + 1);
        // a String takes whatever is written to it
        let _ = write!(text, "{chain},{iteration},{}", draw + 1);
        for (_, values) in columns {
            let _ = write!(text, ",{:?}", values[draw]);
        }
        text.push('\n');
    }
    Ok(text)
}

fn push_name(text: &mut String, name: &str) {
    if name.contains([',', '"', '\n', '\r']) {
        text.push('"');
        text.push_str(&name.replace('"', "\"\""));
        text.push('"');
    } else {
        text.push_str(name);
    }
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
    let mut lines = text.lines();
    let header = names(lines.next().unwrap_or_default());
    let mut places = vec![];
    for column in columns {
        let place = header.iter().position(|name| name == column);
        let missing = || {
            problem(
                Some(1),
                "no such column".to_owned(),
                format!("expected {}", quoted(column)),
            )
        };
        places.push(place.ok_or_else(missing)?);
    }
    let mut values = vec![Vec::with_capacity(draws); columns.len()];
    let mut found = 0;
    for (line, number) in lines.zip(2u64..) {
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != header.len() {
            let expected = format!("expected {}", header.len());
            return Err(problem(Some(number), format!("{} cells", cells.len()), expected));
        }
        for (column, place) in values.iter_mut().zip(&places) {
            let value = cells[*place].parse();
            column
                .push(value.map_err(|_| problem(Some(number), quoted(cells[*place]), "expected a number".to_owned()))?);
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

/// The names of a header line; a quoted one may hold commas.
fn names(line: &str) -> Vec<String> {
    let mut names = vec![String::new()];
    let mut inside = false;
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        let last = names.len() - 1;
        match letter {
            '"' if inside && letters.peek() == Some(&'"') => {
                letters.next();
                names[last].push('"');
            }
            '"' => inside = !inside,
            ',' if !inside => names.push(String::new()),
            other => names[last].push(other),
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_count_from_one_and_come_back_to_the_last_bit() {
        let k = [0.1 + 0.2, 1e-300, -0.0, f64::MAX];
        let e = [1.0, f64::NAN, f64::INFINITY, 0.5];
        let text = table(2, 2, &[("dry_k[PTFE]", &k), ("e_inf[PTFE,AK10,0.06]", &e)]).expect("as many values");
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
        assert!(matches!(table(2, 2, &[("x", &[1.0; 3])]), Err(Error::Internal { .. })));
    }

    #[test]
    fn a_table_comes_back_and_a_part_of_it_does_not() {
        let (k, e) = ([0.1 + 0.2, 1e-300, 0.25, 1.5], [1.0, 0.5, 0.25, 12.25]);
        let text = table(2, 2, &[("e[\"a\",b]", &e), ("k", &k)]).expect("as many values");
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
