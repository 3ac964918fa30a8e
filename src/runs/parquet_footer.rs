//! Checks the counts a Parquet file states against what it holds, before memory is allocated by them.
//!
//! A damaged page that states more values than its column has makes polars ask for them all, and a refused allocation
//! ends the process: no error, and no panic that could be caught.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;

use polars::io::mmap::MmapBytesReader;
use polars::prelude::{ParquetReader, PolarsError, PolarsResult, SerReader};
use polars_parquet_format::thrift;
use polars_parquet_format::thrift::protocol::{TCompactInputProtocol, TInputProtocol, TType};
use polars_parquet_format::{PageHeader, PageType};

/// What every Parquet file ends with.
const MARK: &[u8] = b"PAR1";

/// Bytes of a file's end after the footer: its length, and the mark of the format.
const END: u64 = 8;

/// Checks that a file ends with the mark of the format, and that its footer is a structure whose lists have no more elements
/// than it has bytes left.
pub(super) fn check_footer(mut file: impl Read + Seek) -> PolarsResult<()> {
    let length = file.seek(SeekFrom::End(0))?;
    let mut end = vec![];
    file.seek(SeekFrom::Start(length.saturating_sub(END)))?;
    file.read_to_end(&mut end)?;
    if !end.ends_with(MARK) {
        return refuse("parquet: File out of specification: The file must end with PAR1".to_owned());
    }
    // a file without room for a footer is for the reader to name
    let [a, b, c, d, ..] = end.as_slice() else {
        return Ok(());
    };
    let own = u64::from(u32::from_le_bytes([*a, *b, *c, *d]));
    let Some(start) = length.checked_sub(END + own) else {
        return Ok(());
    };
    let mut footer = vec![];
    file.seek(SeekFrom::Start(start))?;
    file.take(own).read_to_end(&mut footer)?;
    // what an element and a text count there, and more
    let mut protocol = TCompactInputProtocol::new(footer.as_slice(), 16 * footer.len());
    match pass_structure(&mut protocol, 0) {
        Ok(()) => Ok(()),
        Err(_) => refuse("its footer is broken".to_owned()),
    }
}

type Footer<'b> = TCompactInputProtocol<&'b [u8]>;

/// Reads through a structure, whatever its fields mean. Fails where a list has more elements than there are bytes: each takes
/// one at least.
fn pass_structure(footer: &mut Footer, depth: usize) -> thrift::Result<()> {
    /// fields of the footer that the reader takes for lists, whatever their type says
    const LISTS: [i16; 4] = [2, 4, 5, 7];
    footer.read_struct_begin()?;
    loop {
        let field = footer.read_field_begin()?;
        let is_list = depth == 0 && field.id.is_some_and(|id| LISTS.contains(&id));
        match field.field_type {
            TType::Stop => return footer.read_struct_end(),
            other if is_list && other != TType::List => return Err("no list".into()),
            other => pass_value(footer, other, depth)?,
        }
    }
}

fn pass_value(footer: &mut Footer, value: TType, depth: usize) -> thrift::Result<()> {
    /// structures and lists inside one another beyond which no footer goes
    const DEEPEST: usize = 64;
    match value {
        _ if depth > DEEPEST => Err("too deep".into()),
        TType::Struct => pass_structure(footer, depth + 1),
        TType::List => {
            let list = footer.read_list_begin()?;
            (0..list.size).try_for_each(|_| pass_value(footer, list.element_type, depth + 1))
        }
        // also of bytes that are no text, as statistics are
        TType::String => footer.read_bytes().map(|_| ()),
        other => footer.skip(other),
    }
}

/// Checks that some columns, all of single values, hold the rows of a file: that its row groups have as many rows as it states,
/// their pages as many values, and that as many rows as are held at once fit into memory.
pub(super) fn check_counts(mut file: impl MmapBytesReader, columns: &[String], at_once: usize) -> PolarsResult<()> {
    /// bytes that are fetched at once: a page header has a few dozen, and statistics may hold two texts more
    const FETCHED: usize = 1 << 9;
    let about = ParquetReader::new(&mut file).get_metadata()?.clone();
    let rows = about
        .row_groups
        .iter()
        .try_fold(0_usize, |rows, group| rows.checked_add(group.num_rows()));
    if rows != Some(about.num_rows) {
        return refuse(format!(
            "its row groups do not hold the {} rows it claims",
            about.num_rows
        ));
    }
    let mut room: Vec<[f64; 2]> = vec![];
    if room.try_reserve_exact(at_once).is_err() {
        return refuse(format!("{at_once} rows, as it claims, do not fit into memory"));
    }
    let length = file.seek(SeekFrom::End(0))?;
    let mut file = BufReader::with_capacity(FETCHED, file);
    let filled = about.row_groups.iter().filter(|group| group.num_rows() > 0);
    for column in columns {
        for group in filled.clone() {
            for chunk in group.columns_under_root_iter(column).into_iter().flatten() {
                let rows = group.num_rows() as u64;
                let pages = Some(chunk.byte_range()).filter(|pages| pages.end <= length);
                let held = pages.and_then(|pages| values(&mut file, pages, rows));
                if (u64::try_from(chunk.num_values()), held) != (Ok(rows), Some(rows)) {
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
fn values(file: &mut (impl Read + Seek), pages: Range<u64>, expected: u64) -> Option<u64> {
    const LONGEST_HEADER: usize = 1 << 24;
    let (mut at, mut held) = (pages.start, 0_u64);
    // as polars reads them: until there are enough values, whatever follows
    while held < expected {
        file.seek(SeekFrom::Start(at)).ok()?;
        let mut page = file.by_ref().take(pages.end.checked_sub(at)?);
        let mut protocol = TCompactInputProtocol::new(&mut page, LONGEST_HEADER);
        let header = PageHeader::read_from_in_protocol(&mut protocol).ok()?;
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
        let length = u64::try_from(header.compressed_page_size).ok()?;
        at = (pages.end - page.limit()).checked_add(length)?;
    }
    Some(held)
}
