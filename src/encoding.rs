//! Decodes input files as UTF-8 text, or says why they are none.

use crate::error::Problem;

const EXPECTED: &str = "expected a text file saved as UTF-8";

/// The text of a file without its byte-order mark.
pub(crate) fn decode(bytes: &[u8]) -> Result<&str, Problem> {
    let whole_file = |place: &str| Problem {
        line: None,
        place: place.to_owned(),
        found: None,
        expected: EXPECTED.to_owned(),
    };
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        return Err(whole_file("the file is UTF-16"));
    }
    if memchr::memchr(0, bytes).is_some() {
        return Err(whole_file("the file is binary"));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        Problem {
            line: Some(line_of(bytes, at)),
            place: "not valid UTF-8".to_owned(),
            found: bytes.get(at).map(|byte| format!("byte 0x{byte:02X}")),
            expected: EXPECTED.to_owned(),
        }
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
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

    #[test]
    fn what_is_no_utf8_is_named() {
        let problem = |bytes: &[u8]| decode(bytes).expect_err("no UTF-8").to_string();
        assert_eq!(
            problem(b"a\nM\xfcller"),
            "line 2, not valid UTF-8: found byte 0xFC, expected a text file saved as UTF-8"
        );
        assert!(problem(b"\xff\xfea\0").starts_with("the file is UTF-16"));
        assert!(problem(b"PK\x03\x04\0").starts_with("the file is binary"));
        assert_eq!(decode("\u{feff}δ".as_bytes()), Ok("δ"));
    }
}
