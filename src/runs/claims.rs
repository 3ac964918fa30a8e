//! Checks what the parts of a Parquet file claim to hold, before memory is asked for by those claims.
//!
//! A damaged page that claims more values than its column has makes polars ask for them all, and a refused allocation
//! ends the process: no error, and no panic that could be caught.

use std::io::Cursor;

use polars::prelude::{ParquetReader, PolarsError, PolarsResult, SerReader};
use polars_parquet_format::thrift::protocol::TCompactInputProtocol;
use polars_parquet_format::{PageHeader, PageType};

/// Checks that in some columns, all of single values, the pages hold what their row groups claim and these what the file
/// claims, and that so many values fit into memory.
pub(super) fn agree(bytes: &[u8], columns: &[String]) -> PolarsResult<()> {
    let mut reader = ParquetReader::new(Cursor::new(bytes));
    let file = reader.get_metadata()?;
    let rows = file
        .row_groups
        .iter()
        .try_fold(0_usize, |rows, group| rows.checked_add(group.num_rows()));
    if rows != Some(file.num_rows) {
        return refuse(format!(
            "its row groups do not hold the {} rows it claims",
            file.num_rows
        ));
    }
    let mut room: Vec<[f64; 2]> = vec![];
    if room.try_reserve_exact(file.num_rows).is_err() {
        return refuse(format!("{} rows, as it claims, do not fit into memory", file.num_rows));
    }
    for column in columns {
        for group in &file.row_groups {
            for chunk in group.columns_under_root_iter(column).into_iter().flatten() {
                let rows = group.num_rows() as u64;
                let claims = (
                    u64::try_from(chunk.num_values()),
                    values(bytes, chunk.byte_range(), rows),
                );
                if claims != (Ok(rows), Some(rows)) {
                    return refuse(format!("the pages of column {column} do not hold its {rows} values"));
                }
            }
        }
    }
    Ok(())
}

fn refuse(reason: String) -> PolarsResult<()> {
    Err(PolarsError::ComputeError(reason.into()))
}

/// How many values the pages of a column hold by their own headers; `None` where one cannot be, or a dictionary is longer
/// than its page.
fn values(bytes: &[u8], pages: std::ops::Range<u64>, expected: u64) -> Option<u64> {
    // a polars page header has a few dozen bytes; statistics may hold two texts more
    const LONGEST_HEADER: usize = 1 << 24;
    let mut at = Cursor::new(bytes.get(..usize::try_from(pages.end).ok()?)?);
    at.set_position(pages.start);
    let mut held = 0_u64;
    // as polars reads them: until there are enough values, whatever follows
    while held < expected {
        let header =
            PageHeader::read_from_in_protocol(&mut TCompactInputProtocol::new(&mut at, LONGEST_HEADER)).ok()?;
        let claimed = match header.type_ {
            PageType::DATA_PAGE => header.data_page_header?.num_values,
            PageType::DATA_PAGE_V2 => header.data_page_header_v2?.num_values,
            // a text takes four bytes for its length, a number four or eight
            PageType::DICTIONARY_PAGE
                if header.dictionary_page_header?.num_values > header.uncompressed_page_size / 4 =>
            {
                return None
            }
            _ => 0,
        };
        held = held.checked_add(u64::try_from(claimed).ok()?)?;
        at.set_position(
            at.position()
                .checked_add(u64::try_from(header.compressed_page_size).ok()?)?,
        );
    }
    Some(held)
}
