//! Writes one line a draw, as R's posterior reads it.

use csv::Writer;

use crate::error::Error;
use crate::inference::importance::DrawCounts;

/// Draws of some quantities: `.chain`, `.iteration`, `.draw` (each from 1), then a named column each.
///
/// A column holds a number for each draw, chain after chain. Numbers have the digits that bring the same f64 back; a name with
/// a comma is quoted.
pub fn table(size: DrawCounts, columns: &[(&str, Vec<f64>)]) -> Result<Vec<u8>, Error> {
    const DOING: &str = "write draws.csv";
    let names = columns.iter().map(|(name, _)| *name);
    let mut writer = Writer::from_writer(vec![]);
    let written = writer.write_record([".chain", ".iteration", ".draw"].into_iter().chain(names));
    written.map_err(Error::internal(DOING))?;
    for draw in 0..size.chains * size.draws {
        let place = [draw / size.draws + 1, draw % size.draws + 1, draw + 1].map(|number| number.to_string());
        let numbers = columns.iter().map(|(_, values)| format!("{:?}", values[draw]));
        let written = writer.write_record(place.into_iter().chain(numbers));
        written.map_err(Error::internal(DOING))?;
    }
    writer.into_inner().map_err(Error::internal(DOING))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_count_from_one_and_stand_to_the_last_bit() {
        let k = ("dry_k[PTFE]", vec![0.1 + 0.2, 1e-300, -0.0, f64::MAX]);
        let e = ("e_inf[PTFE,AK10,0.06]", vec![1.0, f64::NAN, f64::INFINITY, 0.5]);
        let size = DrawCounts { chains: 2, draws: 2 };
        let bytes = table(size, &[k, e]).expect("a table");
        let expected = [
            ".chain,.iteration,.draw,dry_k[PTFE],\"e_inf[PTFE,AK10,0.06]\"",
            "1,1,1,0.30000000000000004,1.0",
            "1,2,2,1e-300,NaN",
            "2,1,3,-0.0,inf",
            "2,2,4,1.7976931348623157e308,0.5",
        ];
        let lines: Vec<&str> = std::str::from_utf8(&bytes).expect("text").lines().collect();
        assert_eq!(lines, expected);
    }
}
