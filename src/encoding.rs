//! Decodes input files as UTF-8 text, or says why they are none.

use std::io::Read;

use crate::error::Problem;

const EXPECTED: &str = "expected a text file saved as UTF-8";

fn whole_file(place: &str) -> Problem {
    Problem::new(place, EXPECTED)
}

fn not_utf8(line: u64, byte: Option<&u8>) -> Problem {
    let found = byte.map(|byte| format!("byte 0x{byte:02X}"));
    Problem::new("not valid UTF-8", EXPECTED).on(line).found(found)
}

/// What a file is that starts so or holds such a byte, if it is no UTF-8 for that; the bytes begin on a line.
fn no_text(bytes: &[u8], at_start: bool, first_line: u64) -> Option<Problem> {
    if at_start && (bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF])) {
        Some(whole_file("the file is UTF-16"))
    } else {
        let zero = memchr::memchr(0, bytes)?;
        let line = first_line + line_of(bytes, zero) - 1;
        Some(whole_file("the file is binary").on(line).found("byte 0x00".to_owned()))
    }
}

/// The text of a file without its byte-order mark.
pub(crate) fn decode(bytes: &[u8]) -> Result<&str, Problem> {
    if let Some(problem) = no_text(bytes, true, 1) {
        return Err(problem);
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        not_utf8(line_of(bytes, at), bytes.get(at))
    })?;
    Ok(text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text))
}

/// What some programs write before a text.
pub(crate) const BYTE_ORDER_MARK: char = '\u{feff}';

/// Checks that a source is text, as [`decode`] does, with no line longer than so many bytes, and gives how many bytes it
/// has; a piece at a time, of which the first that is no text decides.
pub(crate) fn check(mut source: impl Read, longest_line: usize) -> std::io::Result<Result<usize, Problem>> {
    const PIECE: usize = 1 << 20;
    let mut piece: Vec<u8> = Vec::with_capacity(PIECE + 4);
    let (mut lines, mut of_line, mut at_start) = (LineCount::default(), 0, true);
    let mut bytes = 0;
    loop {
        // what is left of the piece before is the start of a character, checked but for that
        let fetched = source.by_ref().take(PIECE as u64).read_to_end(&mut piece)?;
        let is_last = fetched < PIECE;
        bytes += fetched;
        if let Some(problem) = no_text(&piece, at_start, lines.line()) {
            return Ok(Err(problem));
        }
        let (valid, broken) = match std::str::from_utf8(&piece) {
            Ok(_) => (piece.len(), false),
            Err(error) => (error.valid_up_to(), error.error_len().is_some() || is_last),
        };
        let mut start = 0;
        for end in memchr::memchr2_iter(b'\n', b'\r', &piece[..valid]) {
            if end - start + of_line > longest_line {
                break;
            }
            (start, of_line) = (end + 1, 0);
        }
        lines.pass(&piece[..start]);
        of_line += valid - start;
        if of_line > longest_line {
            let expected = format!("expected lines of at most {longest_line} bytes");
            let problem = Problem::new("", expected).on(lines.line());
            return Ok(Err(problem.found("a longer line".to_owned())));
        }
        if broken {
            return Ok(Err(not_utf8(lines.line(), piece.get(valid))));
        }
        if is_last {
            return Ok(Ok(bytes));
        }
        lines.pass(&piece[start..valid]);
        at_start = false;
        piece.drain(..valid);
    }
}

/// Counts the lines of a text that comes in pieces. A line ends with LF, CRLF or CR.
#[derive(Debug, Default)]
pub(crate) struct LineCount {
    ended: u64,
    /// whether CR was the last byte: LF then ends the same line
    after_cr: bool,
}

impl LineCount {
    /// The line, from 1, that the next byte stands on.
    pub fn line(&self) -> u64 {
        self.ended + 1
    }

    /// Takes the next bytes of the text.
    pub fn pass(&mut self, bytes: &[u8]) {
        for end in memchr::memchr2_iter(b'\n', b'\r', bytes) {
            let after_cr = end
                .checked_sub(1)
                .map_or(self.after_cr, |before| bytes[before] == b'\r');
            self.ended += u64::from(!(after_cr && bytes[end] == b'\n'));
        }
        self.after_cr = bytes.last().map_or(self.after_cr, |last| *last == b'\r');
    }
}

/// The line, from 1, that a byte stands on. A line ends with LF, CRLF or CR.
pub(crate) fn line_of(bytes: &[u8], at: usize) -> u64 {
    1 + line_ends(bytes).take_while(|end| *end < at).count() as u64
}

/// Where lines end: the last byte of each line end.
pub(crate) fn line_ends(bytes: &[u8]) -> impl Iterator<Item = usize> + '_ {
    memchr::memchr2_iter(b'\n', b'\r', bytes)
        .filter(|i| bytes.get(*i) == Some(&b'\n') || bytes.get(i + 1) != Some(&b'\n'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_with_any_of_the_three_line_ends() {
        for text in ["a\nb\nc", "a\r\nb\r\nc", "a\rb\rc"] {
            let at = text.find('c').expect("it is there");
            assert_eq!(line_of(text.as_bytes(), at), 3, "{text:?}");
        }
    }

    /// A source that hands out its bytes in twos: a piece then ends anywhere.
    struct InTwos<'b>(&'b [u8]);

    impl Read for InTwos<'_> {
        fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
            let most = into.len().min(2);
            self.0.read(&mut into[..most])
        }
    }

    #[test]
    fn a_text_is_checked_piece_by_piece_as_it_is_whole() {
        let long = "δ\r\n".repeat(400_000);
        let mut bad = long.clone().into_bytes();
        let middle = bad.len() - 7;
        bad[middle] = 0xFF;
        for bytes in [
            b"a\nM\xfcller" as &[u8],
            b"\xff\xfea\0",
            b"PK\x03\x04\0",
            "\u{feff}δ".as_bytes(),
            b"",
            &bad,
        ]
        .into_iter()
        .chain([long.as_bytes(), &long.as_bytes()[..long.len() - 3]])
        {
            let found = check(InTwos(bytes), 1 << 20).expect("it is read");
            assert_eq!(found, decode(bytes).map(|_| bytes.len()));
        }
        assert_eq!(decode("\u{feff}δ".as_bytes()), Ok("δ"));
        let lines = "four\nfive5\nsix".as_bytes();
        assert_eq!(check(lines, 5).expect("it is read"), Ok(lines.len()));
        let problem = check(lines, 4).expect("it is read").expect_err("a long line");
        assert_eq!(
            problem.to_string(),
            "line 2: found a longer line, expected lines of at most 4 bytes"
        );
        let endless = check(std::io::repeat(b'x'), 1 << 20).expect("it is read");
        assert_eq!(endless.map_err(|problem| problem.line), Err(Some(1)));
    }
}
