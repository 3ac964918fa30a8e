//! Cuts a CSV into records and their cells with csv-core. The only file that names it.
//!
//! A record ends with LF, CRLF or CR. A quote opens a quoted cell where it is the first byte of it, and nowhere else; in
//! such a cell separators and line ends are text, and a doubled quote is one (RFC 4180). A quote that is never closed takes
//! the rest of the text.
//!
//! The reader of the crate csv is built on csv-core too, but counts LF alone as the end of a line, tells the line of a record
//! before it skips the blank ones above, and holds a record of any length. Here lines are counted as an editor counts them,
//! and a record ends where a row is too long.

use std::fmt::Display;
use std::io::{BufRead, BufReader, Read};

use csv_core::{ReadRecordResult, Reader};

use super::refusals::{bad_row, whole_file};
use crate::encoding::{LineCount, BYTE_ORDER_MARK};
use crate::error::Problem;
use crate::files::MOST_OF_LINE;

/// Bytes that are fetched at once.
const FETCHED: usize = 1 << 16;

/// A record that is not blank.
#[derive(Debug, Clone)]
pub(super) struct Record<'r> {
    /// the line it starts on, from 1
    pub line: u64,
    /// with the blanks around them
    pub cells: Vec<&'r str>,
    /// its cells one after the other
    pub text: &'r str,
}

impl Record<'_> {
    /// Whether nothing stands in its cells.
    pub fn is_empty(&self) -> bool {
        self.cells.iter().all(|cell| cell.trim_ascii().is_empty())
    }

    /// Its cells as texts of their own.
    pub fn texts(&self) -> Vec<String> {
        self.cells.iter().map(|cell| (*cell).to_owned()).collect()
    }
}

/// The records of a source, one after the other.
pub(super) struct Records<R> {
    source: BufReader<R>,
    /// what separates cells
    pub separator: u8,
    parser: Reader,
    lines: LineCount,
    /// the line the record at hand starts on
    line: u64,
    /// its cells one after the other, and where each of them ends, with room for longer records
    text: Vec<u8>,
    ends: Vec<usize>,
    /// bytes of its cells
    length: usize,
    /// how many cells it has
    width: usize,
    is_put_back: bool,
}

impl<R: Read> Records<R> {
    pub fn new(source: R, separator: u8) -> std::io::Result<Records<R>> {
        let mut source = BufReader::with_capacity(FETCHED, source);
        let mut mark = [0; 4];
        let mark = BYTE_ORDER_MARK.encode_utf8(&mut mark).as_bytes();
        if source.fill_buf()?.starts_with(mark) {
            source.consume(mark.len());
        }
        let mut lines = LineCount::default();
        let start = source.fill_buf()?;
        let named = separator_named(start).map_or(0, |(_, length)| length);
        lines.pass(&start[..named]);
        source.consume(named);
        Ok(Records {
            source,
            separator,
            parser: csv_core::ReaderBuilder::new().delimiter(separator).build(),
            lines,
            line: 1,
            text: vec![0; 1 << 10],
            ends: vec![0; 1 << 6],
            length: 0,
            width: 0,
            is_put_back: false,
        })
    }

    /// The next record that is not blank. Fails where it is longer than any row, or the source cannot be read.
    pub fn next_record(&mut self) -> Result<Option<Record<'_>>, Vec<Problem>> {
        if !std::mem::take(&mut self.is_put_back) && !self.advance()? {
            return Ok(None);
        }
        let text = std::str::from_utf8(&self.text[..self.length]).map_err(|_| unreadable("no text"))?;
        let starts = std::iter::once(&0).chain(&self.ends);
        let cells = starts
            .zip(&self.ends[..self.width])
            .map(|(start, end)| &text[*start..*end]);
        Ok(Some(Record {
            line: self.line,
            cells: cells.collect(),
            text,
        }))
    }

    /// Lets the next record be the one at hand again.
    pub fn put_back(&mut self) {
        self.is_put_back = true;
    }

    /// Goes on to the next record that is not blank; whether there is one.
    fn advance(&mut self) -> Result<bool, Vec<Problem>> {
        loop {
            self.pass_line_ends()?;
            self.line = self.lines.line();
            if !self.cut_plain() && !self.cut()? {
                return Ok(false);
            }
            if self.width > 1 || !self.text[..self.length].trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// Passes the rest of a line end and blank lines.
    fn pass_line_ends(&mut self) -> Result<(), Vec<Problem>> {
        loop {
            let bytes = self.source.fill_buf().map_err(unreadable)?;
            let blank = bytes.iter().take_while(|byte| matches!(byte, b'\n' | b'\r')).count();
            if blank == 0 {
                return Ok(());
            }
            self.lines.pass(&bytes[..blank]);
            self.source.consume(blank);
        }
    }

    /// Cuts the next record where it was fetched whole and has no quote, as nearly all; whether it does.
    fn cut_plain(&mut self) -> bool {
        let bytes = self.source.buffer();
        let end = memchr::memchr3(b'\n', b'\r', b'"', bytes).filter(|end| bytes[*end] != b'"');
        // the first is left to csv-core, which passes a second byte-order mark
        let Some(end) = end.filter(|_| self.width > 0) else {
            return false;
        };
        (self.length, self.width) = (0, 0);
        self.text.resize(self.text.len().max(end), 0);
        for cell in bytes[..end].split(|byte| *byte == self.separator) {
            let start = self.length;
            self.length += cell.len();
            self.text[start..self.length].copy_from_slice(cell);
            if self.width == self.ends.len() {
                self.ends.resize(2 * self.width, 0);
            }
            self.ends[self.width] = self.length;
            self.width += 1;
        }
        self.lines.pass(&bytes[..end]);
        self.source.consume(end);
        true
    }

    /// Cuts the next record, which may be blank; whether there is one.
    fn cut(&mut self) -> Result<bool, Vec<Problem>> {
        (self.length, self.width) = (0, 0);
        let mut bytes_read = 0;
        loop {
            let bytes = self.source.fill_buf().map_err(unreadable)?;
            // the end of the file ends a row as the end of a line does, unless a quote is open
            let is_last = bytes.is_empty() && bytes_read > 0;
            let bytes = if is_last { b"\n" } else { bytes };
            let (text, ends) = (&mut self.text[self.length..], &mut self.ends[self.width..]);
            let (result, read, written, ended) = self.parser.read_record(bytes, text, ends);
            self.length += written;
            self.width += ended;
            if is_last && result == ReadRecordResult::InputEmpty {
                let expected = "a second quote where its cell ends";
                return Err(vec![bad_row(self.line, "a quote that is not closed", expected)]);
            }
            if !is_last {
                self.lines.pass(&bytes[..read]);
                self.source.consume(read);
                bytes_read += read;
            }
            let is_record = result == ReadRecordResult::Record;
            // a record ends with its line end, or with the file
            let of_row = bytes_read - usize::from(is_record && read > 0);
            if of_row > MOST_OF_LINE {
                let expected = format!(
                    "rows of at most {MOST_OF_LINE} bytes; a cell may go on over the end of the line: is a quote not closed?"
                );
                return Err(vec![bad_row(self.line, "a longer row", &expected)]);
            }
            match result {
                ReadRecordResult::Record => return Ok(true),
                ReadRecordResult::End => return Ok(false),
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::OutputFull => self.text.resize(2 * self.text.len(), 0),
                ReadRecordResult::OutputEndsFull => self.ends.resize(2 * self.ends.len(), 0),
            }
        }
    }
}

/// Says that a table was not to be read to its end.
fn unreadable(why: impl Display) -> Vec<Problem> {
    vec![whole_file("the table cannot be read", &why.to_string())]
}

/// What a first line `sep=;` names as separator, as Excel reads and writes it, and the length of that line.
pub(super) fn separator_named(start: &[u8]) -> Option<(u8, usize)> {
    let named = start.get(..4).filter(|key| key.eq_ignore_ascii_case(b"sep="));
    match (named, start.get(4..)?) {
        (Some(_), [separator, b'\r' | b'\n', ..]) => Some((*separator, 5)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    type Cut = Vec<(u64, Vec<String>)>;

    /// A source that hands out few bytes at a time: what is fetched at once then ends anywhere.
    struct InFives<'b>(&'b [u8]);

    impl Read for InFives<'_> {
        fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
            let most = into.len().min(5);
            self.0.read(&mut into[..most])
        }
    }

    /// `None` of a text with a quote that is not closed.
    fn cut(source: impl Read, separator: u8) -> Option<Cut> {
        let mut records = Records::new(source, separator).expect("it is read");
        let mut all = vec![];
        while let Some(record) = records.next_record().ok()? {
            let cells = record.cells.iter().map(|cell| cell.trim_ascii().to_owned());
            all.push((record.line, cells.collect()));
        }
        Some(all)
    }

    /// The same by the crate csv, the lines by the first byte of its records that belongs to one.
    fn cut_by_csv(text: &str, separator: u8) -> Cut {
        let mut reader = ::csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .trim(::csv::Trim::All)
            .from_reader(text.as_bytes());
        let records = reader
            .byte_records()
            .map(|record| record.expect("bytes that are there"));
        let filled = records.filter(|record| record.len() > 1 || !record[0].is_empty());
        let told = filled.map(|record| {
            let from = record.position().map_or(0, |position| position.byte() as usize);
            // blank lines are skipped after the position is told
            let skipped = text[from..].find(|letter| !matches!(letter, '\n' | '\r')).unwrap_or(0);
            let line = crate::encoding::line_of(text.as_bytes(), from + skipped);
            let cells = record.iter().map(|cell| String::from_utf8_lossy(cell).into_owned());
            (line, cells.collect())
        });
        told.collect()
    }

    #[test]
    fn records_start_on_the_lines_that_an_editor_counts() {
        let mut rng = crate::seed::stream(1, "cells are cut", 0);
        let parts = ",|,|;|\n|\r\n|\r| |\"|\"\"|\"|a|PTFE,|4,|0.5\n|δ|\"a,b\",|\"a\nb\",|\"\"\"|\t";
        let parts: Vec<&str> = parts.split('|').collect();
        let (mut several, mut quoted, mut open) = (0, 0, 0);
        for _ in 0..10_000 {
            let text: String = (0..rng.random_range(1..16))
                .map(|_| parts[rng.random_range(0..parts.len())])
                .collect();
            for separator in [b',', b';'] {
                let ours = cut(text.as_bytes(), separator);
                assert_eq!(ours, cut(InFives(text.as_bytes()), separator), "{text:?}");
                let Some(ours) = ours else {
                    open += 1;
                    continue;
                };
                assert_eq!(ours, cut_by_csv(&text, separator), "{text:?}");
                several += usize::from(ours.len() > 1);
                quoted += usize::from(ours.iter().flat_map(|(_, cells)| cells).any(|cell| cell.contains('\n')));
            }
        }
        assert!(
            several > 5_000 && quoted > 500 && (500..10_000).contains(&open),
            "{several} {quoted} {open}"
        );
    }

    #[test]
    fn a_first_line_may_name_the_separator() {
        let rows = cut("\u{feff}SEP=;\r\na;b\r\n1;2\r\n".as_bytes(), b';').expect("no quote");
        let row = |line: u64, cells: [&str; 2]| (line, cells.map(str::to_owned).to_vec());
        assert_eq!(rows, [row(2, ["a", "b"]), row(3, ["1", "2"])]);
        assert_eq!(separator_named(b"sep=\t\n"), Some((b'\t', 5)));
        assert_eq!(separator_named(b"sep=, a\n"), None);
    }
}
