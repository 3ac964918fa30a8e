//! Escapes for Markdown what a user wrote, so that a reader of the page sees the same text.
//!
//! Free text (a title, a source) goes through [`literal`] where it enters a page, what stands in a code span through
//! [`code`]. The names of particles and liquids hold letters, digits, `_`, `-` and `.` only; what these could do, and what
//! is never shown as it is, a page takes care of by [`guarded`] line by line. An address in a text stays one: what is read is
//! where it leads.

use crate::error::is_unseen;

/// A text as it is, on one line, whatever it holds: no emphasis, link, picture, code, formula or HTML comes of it.
pub(crate) fn literal(text: &str) -> String {
    let line = one_line(text);
    let letters: Vec<char> = line.chars().collect();
    let mut escaped = String::with_capacity(line.len());
    let block = begins_block(&letters);
    for (at, &c) in letters.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| letters[before]);
        let rest = &letters[at + 1..];
        let marks = match c {
            '\\' | '`' | '*' | '[' | ']' | '<' | '>' | '~' | '$' => true,
            '_' => !inside_word(before, rest.first().copied()),
            // a heading opens and closes with it beside a blank
            '#' => before.is_none_or(|before| before == ' '),
            '&' => is_entity(rest),
            _ => block == Some(at),
        };
        if marks {
            escaped.push('\\');
        }
        push_seen(&mut escaped, c);
    }
    escaped
}

/// A text in a code span, on one line; the marks about it are as long as it takes.
pub(in crate::report) fn code(text: &str) -> String {
    let mut line = String::new();
    one_line(text).chars().for_each(|c| push_seen(&mut line, c));
    let longest = line.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let marks = "`".repeat(longest + 1);
    // a backtick at an end would lengthen the marks
    let room = if line.is_empty() || line.starts_with('`') || line.ends_with('`') {
        " "
    } else {
        ""
    };
    format!("{marks}{room}{line}{room}{marks}")
}

/// A piece of a page that may hold names: a `_` at the edge of one opens no emphasis, and nothing unseen is left.
pub(in crate::report) fn guarded(text: &str) -> String {
    // most are numbers and words
    if !text.contains(['_', '`']) && text.chars().all(|c| c == '\n' || !is_unseen(c)) {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    let mut escaped = String::with_capacity(text.len());
    let mut at = 0;
    while at < letters.len() {
        let c = letters[at];
        let before = at.checked_sub(1).map(|before| letters[before]);
        if c == '`' && before != Some('\\') {
            let end = end_of_code(&letters, at);
            letters[at..end].iter().for_each(|&c| push_seen(&mut escaped, c));
            at = end;
            continue;
        }
        let safe = before == Some('\\') || inside_word(before, letters.get(at + 1).copied());
        if c == '_' && !safe {
            escaped.push('\\');
        }
        push_seen(&mut escaped, c);
        at += 1;
    }
    escaped
}

/// The name of a file as a link leads to it.
pub(in crate::report) fn destination(file: &str) -> String {
    let mut address = String::with_capacity(file.len());
    for byte in file.bytes() {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_' | b'~') {
            address.push(char::from(byte));
        } else {
            address.push_str(&format!("%{byte:02X}"));
        }
    }
    address
}

/// A text with one blank wherever it has any, line ends with them.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn push_seen(escaped: &mut String, c: char) {
    if c == '\n' || !is_unseen(c) {
        escaped.push(c);
    } else {
        escaped.extend(c.escape_default());
    }
}

/// Whether a `_` between these is part of a word, where Markdown leaves it alone.
fn inside_word(before: Option<char>, after: Option<char>) -> bool {
    // a mark over a letter belongs to it
    let of_word = |c: char| c.is_alphanumeric() || matches!(c, '\u{300}'..='\u{36f}');
    before.is_some_and(of_word) && after.is_some_and(of_word)
}

/// Whether what follows a `&` makes it the name or the number of a character.
fn is_entity(rest: &[char]) -> bool {
    let end = rest.iter().position(|c| !(c.is_ascii_alphanumeric() || *c == '#'));
    end.is_some_and(|end| end > 0 && rest[end] == ';')
}

/// Where the mark stands by which a line would begin a list or underline a heading; `None` where it would not.
fn begins_block(letters: &[char]) -> Option<usize> {
    let digits = letters.iter().take_while(|c| c.is_ascii_digit()).count();
    let of_list = |at: usize| letters.get(at + 1).is_none_or(|after| *after == ' ');
    match letters.get(digits)? {
        '.' | ')' if digits > 0 => of_list(digits).then_some(digits),
        '+' if digits == 0 => of_list(0).then_some(0),
        '-' | '=' if digits == 0 => Some(0),
        _ => None,
    }
}

/// Where the code span that begins here ends, or its marks where it is none.
fn end_of_code(letters: &[char], start: usize) -> usize {
    let marks = |at: usize| letters[at..].iter().take_while(|c| **c == '`').count();
    let length = marks(start);
    let mut at = start + length;
    while at < letters.len() {
        match marks(at) {
            0 => at += 1,
            same if same == length => return at + same,
            other => at += other,
        }
    }
    start + length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d11_what_would_be_markup_is_the_text_it_is() {
        for (text, expected) in [
            (
                "**b** _i_ ~s~ `c` $m$ a\\",
                "\\*\\*b\\*\\* \\_i\\_ \\~s\\~ \\`c\\` \\$m\\$ a\\\\",
            ),
            ("a\n\n# b\r\n## c ##", "a \\# b \\## c \\##"),
            ("&lt; &#60; AT&T", "\\&lt; \\&#60; AT&T"),
            ("- a", "\\- a"),
            ("1. a", "1\\. a"),
            ("1.5 a", "1.5 a"),
            ("===", "\\==="),
            ("a\u{1b}[2J\u{202e}b\u{200b}", "a\\u{1b}\\[2J\\u{202e}b\\u{200b}"),
        ] {
            assert_eq!(literal(text), expected);
        }
        for (text, expected) in [("a", "`a`"), ("`a", "`` `a ``"), ("a``b", "```a``b```"), ("", "`  `")] {
            assert_eq!(code(text), expected);
        }
        assert_eq!(guarded("_a_: `_b_` __c__ \\_d"), "\\_a\\_: `_b_` \\_\\_c\\_\\_ \\_d");
        assert_eq!(guarded("`a` `` `_ `` _"), "`a` `` `_ `` \\_");
        assert_eq!(destination("a-µ (1).svg"), "a-%C2%B5%20%281%29.svg");
    }
}
