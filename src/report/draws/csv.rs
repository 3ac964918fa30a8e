//! Writes one line a draw, as R's posterior reads it.

use std::fmt::Write;

use crate::error::Error;

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
}
