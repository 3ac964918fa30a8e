//! Writes JSON one entry a line, without blanks inside: a table that can be read and a quarter of the size of full
//! indentation.
//!
//! A character that is never shown as it is (see [`is_unseen`]) is written as its number, of which a reader makes the same
//! text: JSON is printed, and files of it are shown on terminals and in editors.

use std::io;

use serde_json::ser::Formatter;

use crate::error::{is_unseen, Error};

/// Nesting down to which every entry has its own line: the object and the lists in it.
const OPEN_TO: usize = 2;

/// Numbers below this are written with a power of ten.
const SMALL: f64 = 1e-3;

#[derive(Default)]
struct Shallow {
    depth: usize,
}

impl Shallow {
    fn line(&self, writer: &mut (impl io::Write + ?Sized)) -> io::Result<()> {
        if self.depth > OPEN_TO {
            return Ok(());
        }
        writer.write_all(b"\n")?;
        writer.write_all(&b"  "[..self.depth])
    }

    fn open(&mut self, writer: &mut (impl io::Write + ?Sized), bracket: &[u8]) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(bracket)
    }

    fn close(&mut self, writer: &mut (impl io::Write + ?Sized), bracket: &[u8]) -> io::Result<()> {
        let was_open = self.depth <= OPEN_TO;
        self.depth -= 1;
        if was_open {
            self.line(writer)?;
        }
        writer.write_all(bracket)
    }

    fn next(&self, writer: &mut (impl io::Write + ?Sized), first: bool) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.line(writer)
    }
}

impl Formatter for Shallow {
    fn write_f64<W: ?Sized + io::Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        // both read back to the same number; zeros after the point say nothing that a power of ten does not
        let small = value != 0.0 && value.abs() < SMALL;
        let text = if small {
            format!("{value:e}")
        } else {
            format!("{value:?}")
        };
        writer.write_all(text.as_bytes())
    }
    fn write_string_fragment<W: ?Sized + io::Write>(&mut self, writer: &mut W, fragment: &str) -> io::Result<()> {
        // nearly all: what is below a blank has been escaped before
        if fragment.is_ascii() && memchr::memchr(0x7f, fragment.as_bytes()).is_none() {
            return writer.write_all(fragment.as_bytes());
        }
        let mut rest = fragment;
        while let Some((at, c)) = rest.char_indices().find(|(_, c)| is_unseen(*c)) {
            writer.write_all(&rest.as_bytes()[..at])?;
            for unit in c.encode_utf16(&mut [0; 2]) {
                write!(writer, "\\u{unit:04x}")?;
            }
            rest = &rest[at + c.len_utf8()..];
        }
        writer.write_all(rest.as_bytes())
    }
    fn begin_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, b"[")
    }
    fn end_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"]")
    }
    fn begin_array_value<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.next(writer, first)
    }
    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open(writer, b"{")
    }
    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"}")
    }
    fn begin_object_key<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.next(writer, first)
    }
    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(if self.depth > OPEN_TO { b":" } else { b": " })
    }
}

/// A value as the text of a JSON file; a number that is not finite becomes null.
pub fn text(value: &impl serde::Serialize) -> Result<String, Error> {
    const DOING: &str = "write JSON";
    let mut bytes = vec![];
    let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, Shallow::default());
    value.serialize(&mut serializer).map_err(Error::internal(DOING))?;
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(Error::internal(DOING))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d11_what_is_not_shown_is_written_as_a_number_and_read_back_as_it_was() {
        let title = "a\u{1b}[2J\n\u{202e}b\u{7f}\u{9b}\u{e0041} ü中";
        let json = text(&title).expect("a text");
        assert!(!json.trim_end().chars().any(is_unseen), "{json:?}");
        assert!(json.contains("\\u202eb\\u007f\\u009b\\udb40\\udc41 ü中"), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).ok().as_deref(), Some(title));
    }

    #[test]
    fn numbers_read_back_to_the_last_bit() {
        let numbers = [-0.0, 0.1, -2.206_147_085_928_589_2e-5, 5e-324, 4371.0, f64::MAX];
        let text = text(&numbers).expect("numbers");
        assert!(text.contains("-2.2061470859285892e-5"), "{text}");
        let read: Vec<f64> = serde_json::from_str(&text).expect("valid JSON");
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&numbers));
    }
}
