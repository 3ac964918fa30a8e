//! Reads a law from a line of `laws.csv`.

use physics::physics::{LawNumbers, Order, Plateau};

use super::wetcor_status::{self, *};
use super::{order, wetcor_law};

/// Cells of a line without its end. No cell is in quotes.
fn cells(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    let line = line.strip_suffix(b"\r").unwrap_or(line);
    line.split(|byte| *byte == b',').map(<[u8]>::trim_ascii)
}

/// A line beside the header that names its cells.
#[derive(Clone, Copy)]
struct Row<'a> {
    header: &'a [u8],
    line: &'a [u8],
}

impl<'a> Row<'a> {
    fn new(header: &'a [u8], line: &'a [u8]) -> Result<Row<'a>, wetcor_status> {
        // what some editors put at the beginning of a file
        let header = header.strip_prefix(b"\xef\xbb\xbf").unwrap_or(header);
        let is_quoted = [header, line].iter().any(|text| text.contains(&b'"'));
        if is_quoted || cells(header).count() != cells(line).count() {
            return Err(WETCOR_BAD_LINE);
        }
        Ok(Row { header, line })
    }

    /// The cell of a column, empty where the table says nothing.
    fn cell(self, column: &str) -> Result<&'a [u8], wetcor_status> {
        let mut columns = cells(self.header).zip(cells(self.line));
        let found = columns.find(|(name, _)| *name == column.as_bytes());
        found.map(|(_, cell)| cell).ok_or(WETCOR_MISSING_COLUMN)
    }

    /// Its number; `None` where it is empty.
    fn number(self, column: &str) -> Result<Option<f64>, wetcor_status> {
        let cell = self.cell(column)?;
        if cell.is_empty() {
            return Ok(None);
        }
        let number = std::str::from_utf8(cell).ok().and_then(|text| text.parse().ok());
        number.map(Some).ok_or(WETCOR_BAD_LINE)
    }

    /// A number that may not be missing.
    fn needed(self, column: &str) -> Result<f64, wetcor_status> {
        self.number(column)?.ok_or(WETCOR_BAD_LINE)
    }

    /// A term that is not there where its cell is empty.
    fn term(self, column: &str) -> Result<f64, wetcor_status> {
        Ok(self.number(column)?.unwrap_or(0.0))
    }

    fn order(self) -> Result<Order, wetcor_status> {
        match self.cell("dry_order")? {
            b"1" => order(1),
            b"2" => order(2),
            _ => Err(WETCOR_BAD_LINE),
        }
    }

    fn numbers(self) -> Result<LawNumbers, wetcor_status> {
        let plateau = match self.cell("law")? {
            b"dry" => return Ok(LawNumbers::dry(self.needed("dry_k")?, self.order()?)),
            b"reference" => Plateau::Constant(self.needed("alpha")?),
            b"impact" => Plateau::OfSpeed {
                dry_k: self.needed("dry_k")?,
                order: self.order()?,
                loss: self.term("inertial_loss")?,
            },
            _ => return Err(WETCOR_BAD_LINE),
        };
        Ok(LawNumbers {
            plateau,
            beta: self.term("beta_m_s")?,
            kappa: self.term("kappa_m2_s2")?,
        })
    }
}

/// The law of a line, with whether it may be quoted.
pub fn law(header: &[u8], line: &[u8]) -> Result<(wetcor_law, wetcor_status), wetcor_status> {
    let row = Row::new(header, line)?;
    let min_speed = row.number("min_speed_m_s")?.unwrap_or(0.0);
    let max_speed = row.number("max_speed_m_s")?.unwrap_or(f64::INFINITY);
    let law = wetcor_law::new(row.numbers()?)?.with_range(min_speed, max_speed)?;
    match row.cell("quotable")? {
        b"true" => Ok((law, WETCOR_OK)),
        b"false" => Ok((law, WETCOR_NOT_QUOTABLE)),
        _ => Err(WETCOR_BAD_LINE),
    }
}
