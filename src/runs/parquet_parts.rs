//! Takes a part of a Parquet file, some of its row groups, as a file of its own: of the whole no more need be in memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;

use polars_parquet_format::thrift::protocol::{TCompactInputProtocol, TCompactOutputProtocol};
use polars_parquet_format::{ColumnMetaData, FileMetaData};

use super::parquet_footer::MARK;
use crate::files::MOST_OF_PARQUET;

/// A Parquet file that is read a part after the other.
pub(super) struct ParquetParts {
    footer: FileMetaData,
    /// columns whose values the parts have
    columns: Vec<String>,
    pub all: Vec<Part>,
}

/// Some row groups of a Parquet file.
pub(super) struct Part {
    groups: Range<usize>,
    /// in the file before it
    pub rows_before: usize,
    pub rows: usize,
}

impl ParquetParts {
    /// Equal parts of so many rows, or as few more as row groups allow, with some of the columns.
    ///
    /// `footer` is the end of a file of some length from its footer on, which has been checked. `None` where its groups do not
    /// have the rows or the places that it claims, lie in other files or are encrypted, or where a part is too long to be held.
    pub fn of(footer: &[u8], length: u64, rows: usize, columns: Vec<String>) -> Option<ParquetParts> {
        let mut protocol = TCompactInputProtocol::new(footer, MOST_OF_PARQUET as usize);
        let footer = FileMetaData::read_from_in_protocol(&mut protocol).ok()?;
        let mut chunks = footer.row_groups.iter().flat_map(|group| &group.columns);
        let are_inside = chunks.all(|chunk| {
            let pages = chunk.meta_data.as_ref().and_then(pages);
            chunk.file_path.is_none() && pages.is_some_and(|pages| pages.end <= length)
        });
        let mut parts = ParquetParts {
            columns,
            all: vec![],
            footer,
        };
        let claimed = usize::try_from(parts.footer.num_rows).ok()?;
        // of equal length, as whoever reads them may take turns
        let rows = claimed.div_ceil(claimed.div_ceil(rows).max(1));
        let mut all = 0_usize;
        for (group, about) in parts.footer.row_groups.iter().enumerate() {
            let own = usize::try_from(about.num_rows).ok()?;
            // one without rows is no part of its own
            match parts.all.last_mut().filter(|part| part.rows < rows || own == 0) {
                Some(part) => (part.groups.end, part.rows) = (group + 1, part.rows.checked_add(own)?),
                None => parts.all.push(Part {
                    groups: group..group + 1,
                    rows_before: all,
                    rows: own,
                }),
            }
            all = all.checked_add(own)?;
        }
        let is_plain = parts.footer.encryption_algorithm.is_none();
        let are_all = all == claimed;
        let are_short = parts.all.iter().all(|part| parts.length(part) <= MOST_OF_PARQUET);
        (is_plain && are_inside && are_all && are_short).then_some(parts)
    }

    /// Bytes of the values of a part.
    fn length(&self, part: &Part) -> u64 {
        let groups = self.footer.row_groups[part.groups.clone()].iter();
        let chunks = groups
            .flat_map(|group| &group.columns)
            .filter_map(|chunk| chunk.meta_data.as_ref());
        let pages = chunks.filter(|chunk| self.has(chunk)).filter_map(pages);
        pages.fold(0, |sum, pages| sum.saturating_add(pages.end - pages.start))
    }

    /// Whether a part has the values of a chunk.
    fn has(&self, chunk: &ColumnMetaData) -> bool {
        let name = chunk.path_in_schema.first();
        name.is_some_and(|name| self.columns.contains(name))
    }

    /// A part as a file of its own.
    pub fn read(&self, part: &Part, mut file: &File) -> std::io::Result<Vec<u8>> {
        let length = usize::try_from(self.length(part)).unwrap_or(usize::MAX);
        let mut bytes = vec![];
        let room = bytes.try_reserve(length);
        room.map_err(|_| Error::from(ErrorKind::OutOfMemory))?;
        bytes.extend(MARK);
        let mut row_groups = self.footer.row_groups[part.groups.clone()].to_vec();
        let chunks = row_groups.iter_mut().flat_map(|group| &mut group.columns);
        for chunk in chunks.filter_map(|chunk| chunk.meta_data.as_mut()) {
            let Some(pages) = pages(chunk).filter(|_| self.has(chunk)) else {
                continue;
            };
            let own = bytes.len() as i64;
            file.seek(SeekFrom::Start(pages.start))?;
            let wanted = pages.end - pages.start;
            if file.take(wanted).read_to_end(&mut bytes)? as u64 != wanted {
                return Err(ErrorKind::UnexpectedEof.into());
            }
            let by = own.wrapping_sub(pages.start as i64);
            let places = [Some(&mut chunk.data_page_offset), chunk.dictionary_page_offset.as_mut()];
            for place in places.into_iter().flatten() {
                *place = place.wrapping_add(by);
            }
        }
        let footer = FileMetaData {
            num_rows: row_groups.iter().map(|group| group.num_rows).sum(),
            row_groups,
            schema: self.footer.schema.clone(),
            key_value_metadata: self.footer.key_value_metadata.clone(),
            created_by: self.footer.created_by.clone(),
            column_orders: self.footer.column_orders.clone(),
            version: self.footer.version,
            encryption_algorithm: None,
            footer_signing_key_metadata: None,
        };
        let start = bytes.len();
        let written = footer.write_to_out_protocol(&mut TCompactOutputProtocol::new(&mut bytes));
        written.map_err(|error| Error::other(error.to_string()))?;
        let length = (bytes.len() - start) as u32;
        bytes.extend(length.to_le_bytes());
        bytes.extend(MARK);
        Ok(bytes)
    }
}

/// Where the pages of a chunk are.
fn pages(chunk: &ColumnMetaData) -> Option<Range<u64>> {
    let start = chunk.dictionary_page_offset.unwrap_or(chunk.data_page_offset);
    let start = u64::try_from(start).ok()?;
    let length = u64::try_from(chunk.total_compressed_size).ok()?;
    Some(start..start.checked_add(length)?)
}
