//! Checks the counts a Parquet file states against what it holds, before memory is allocated by them.
//!
//! A damaged page that states more values than its column has makes polars ask for them all, and a refused allocation
//! ends the process: no error, and no panic that could be caught.

use std::fs::File;
use std::io::{Cursor, Read, Seek, SeekFrom};

use polars::prelude::{ParquetReader, PolarsError, PolarsResult, SerReader};
use polars_parquet_format::thrift::protocol::TCompactInputProtocol;
use polars_parquet_format::{PageHeader, PageType};

/// What every Parquet file ends with.
pub(super) const MARK: &[u8] = b"PAR1";

/// Bytes of a file's end after the footer: its length, and the mark of the format.
const END: usize = 8;

/// The last bytes of a file of some length, as many as say what it is.
pub(super) fn last_bytes(file: &mut File, length: u64) -> std::io::Result<Vec<u8>> {
    let mut end = vec![];
    file.seek(SeekFrom::Start(length.saturating_sub(END as u64)))?;
    file.by_ref().take(END as u64).read_to_end(&mut end)?;
    Ok(end)
}

/// The footer of a file of some length with what ends it, as far as there is one.
pub(super) fn footer(file: &mut File, length: u64) -> std::io::Result<Vec<u8>> {
    let end = last_bytes(file, length)?;
    let own = end.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes)).into();
    let mut footer = vec![];
    file.seek(SeekFrom::Start(length.saturating_sub(END as u64).saturating_sub(own)))?;
    file.by_ref().take(END as u64 + own).read_to_end(&mut footer)?;
    Ok(footer)
}

/// Checks that the end of a file is one of Parquet; nothing at all is for the reader to name.
pub(super) fn check_mark(end: &[u8]) -> PolarsResult<()> {
    if end.is_empty() || end.ends_with(MARK) {
        Ok(())
    } else {
        refuse("parquet: File out of specification: The file must end with PAR1".to_owned())
    }
}

/// Checks that a file's footer is a structure whose lists have no more elements than it has bytes left. A file without a
/// footer is for the reader to name.
pub(super) fn check_footer(bytes: &[u8]) -> PolarsResult<()> {
    let Some(end) = bytes.len().checked_sub(END) else {
        return Ok(());
    };
    let [a, b, c, d, mark @ ..] = &bytes[end..] else {
        return Ok(());
    };
    if mark != MARK {
        return Ok(());
    }
    let length = usize::try_from(u32::from_le_bytes([*a, *b, *c, *d])).unwrap_or(usize::MAX);
    let Some(footer) = end.checked_sub(length).and_then(|start| bytes.get(start..end)) else {
        return Ok(());
    };
    match (ThriftReader { left: footer }).structure(0) {
        Ok(()) => Ok(()),
        Err(ThriftError::TooLong) => refuse("its footer claims more parts than it holds".to_owned()),
        Err(ThriftError::Broken) => refuse("its footer is broken".to_owned()),
    }
}

/// Reads through a structure in Thrift's compact encoding, whatever its fields mean.
///
/// Source: the encoding as Apache Thrift specifies it (thrift-compact-protocol.md).
struct ThriftReader<'b> {
    left: &'b [u8],
}

/// Why reading ends early.
#[derive(Debug, PartialEq)]
enum ThriftError {
    /// a list of more elements than there are bytes
    TooLong,
    /// anything else
    Broken,
}

impl ThriftReader<'_> {
    /// Structures inside structures beyond which no footer goes.
    const DEEPEST: usize = 64;

    fn byte(&mut self) -> Result<u8, ThriftError> {
        let (first, rest) = self.left.split_first().ok_or(ThriftError::Broken)?;
        self.left = rest;
        Ok(*first)
    }

    fn skip(&mut self, count: u64) -> Result<(), ThriftError> {
        let count = usize::try_from(count).map_err(|_| ThriftError::Broken)?;
        self.left = self.left.get(count..).ok_or(ThriftError::Broken)?;
        Ok(())
    }

    /// A number in groups of seven bits, the lowest first.
    fn number(&mut self) -> Result<u64, ThriftError> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(ThriftError::Broken)
    }

    fn fits(&self, elements: u64) -> Result<(), ThriftError> {
        if elements > self.left.len() as u64 {
            Err(ThriftError::TooLong)
        } else {
            Ok(())
        }
    }

    fn structure(&mut self, depth: usize) -> Result<(), ThriftError> {
        /// fields of the footer that the reader takes for lists, whatever their type says
        const LISTS: [i64; 4] = [2, 4, 5, 7];
        const LIST: u8 = 9;
        let mut field = 0_i64;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(());
            }
            // the field's number stands apart where it does not follow closely
            if head >> 4 == 0 {
                let number = self.number()?;
                // zigzag: the sign is the lowest bit
                field = (number >> 1) as i64 ^ -((number & 1) as i64);
            } else {
                field = field.saturating_add(i64::from(head >> 4));
            }
            if depth == 0 && LISTS.contains(&field) && head & 0x0f != LIST {
                return Err(ThriftError::Broken);
            }
            // a field of truth is its own type
            if !matches!(head & 0x0f, 1 | 2) {
                self.value(head & 0x0f, depth)?;
            }
        }
    }

    fn value(&mut self, kind: u8, depth: usize) -> Result<(), ThriftError> {
        match kind {
            // truth inside a list, a byte
            1..=3 => self.skip(1),
            // whole numbers
            4..=6 => self.number().map(|_| ()),
            7 => self.skip(8),
            // a text
            8 => {
                let length = self.number()?;
                self.skip(length)
            }
            // a list or a set
            9 | 10 => {
                let head = self.byte()?;
                let elements = match head >> 4 {
                    15 => self.number()?,
                    few => u64::from(few),
                };
                self.fits(elements)?;
                (0..elements).try_for_each(|_| self.value(head & 0x0f, depth))
            }
            11 => {
                let pairs = self.number()?;
                self.fits(pairs)?;
                if pairs == 0 {
                    return Ok(());
                }
                let kinds = self.byte()?;
                (0..pairs).try_for_each(|_| {
                    self.value(kinds >> 4, depth)?;
                    self.value(kinds & 0x0f, depth)
                })
            }
            13 => self.skip(16),
            12 if depth < Self::DEEPEST => self.structure(depth + 1),
            _ => Err(ThriftError::Broken),
        }
    }
}

/// Checks that in some columns, all of single values, the pages hold what their row groups state and these what the file
/// states, and that so many values fit into memory.
pub(super) fn check_counts(bytes: &[u8], columns: &[String]) -> PolarsResult<()> {
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
                let counts = (
                    u64::try_from(chunk.num_values()),
                    values(bytes, chunk.byte_range(), rows),
                );
                if counts != (Ok(rows), Some(rows)) {
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
        let stated = match header.type_ {
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
        held = held.checked_add(u64::try_from(stated).ok()?)?;
        at.set_position(
            at.position()
                .checked_add(u64::try_from(header.compressed_page_size).ok()?)?,
        );
    }
    Some(held)
}
