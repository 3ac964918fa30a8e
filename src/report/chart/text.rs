//! Sets subscripts and superscripts in labels, and estimates how wide a label gets.

use super::super::markup::escaped;
use crate::error::is_unseen;

/// Where a part of a label stands.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Script {
    /// distance below the line, in the line's em
    drop: f64,
    /// relative to the line
    size: f64,
}

const LINE: Script = Script { drop: 0.0, size: 1.0 };
const LOWERED: Script = Script { drop: 0.22, size: 0.75 };
const RAISED: Script = Script {
    drop: -0.36,
    size: 0.75,
};

/// The content of an element that holds the label, set at so many pixels. Sizes and shifts are in pixels: not every viewer
/// reads a share of the size around it.
pub(super) fn markup(label: &str, size: f64) -> String {
    let mut content = String::new();
    let mut at = 0.0;
    for (script, part) in parts(label) {
        let shift = script.drop - at;
        at = script.drop;
        let part = escaped(&part);
        if shift == 0.0 {
            content.push_str(&part);
        } else {
            content.push_str(&format!(
                "<tspan dy=\"{}\" font-size=\"{}\">{part}</tspan>",
                decimal(shift * size),
                decimal(script.size * size)
            ));
        }
    }
    content
}

/// Estimates a label's width in pixels, generously: what viewers substitute for the fonts
/// asked for is unknown, and among the usual ones only bold or monospaced faces are wider.
pub(super) fn width(label: &str, size: f64) -> f64 {
    let part_width = |(script, part): &(Script, String)| script.size * part.chars().map(advance).sum::<f64>();
    size * parts(label).iter().map(part_width).sum::<f64>()
}

/// Width of a letter in em: at least what DejaVu Sans and Verdana have for most of its kind.
fn advance(c: char) -> f64 {
    match c {
        '\u{300}'..='\u{36F}' => 0.0,
        ' ' | '.' | ',' | ':' | ';' | '\'' | '(' | ')' | '/' | '|' | 'I' | 'f' | 'i' | 'j' | 'l' | 'r' | 't' => 0.46,
        'm' | 'w' | 'M' | 'W' | '%' | '@' | '—' | '…' => 1.0,
        // East Asian letters and pictures fill a square
        '\u{1100}'..='\u{115F}'
        | '\u{2E80}'..='\u{A4CF}'
        | '\u{AC00}'..='\u{D7A3}'
        | '\u{F900}'..='\u{FAFF}'
        | '\u{FE30}'..='\u{FE6F}'
        | '\u{FF00}'..='\u{FF60}'
        | '\u{1F300}'..='\u{3FFFD}' => 1.1,
        '+' | '−' | '=' | '<' | '>' | '±' | '~' => 0.84,
        _ if c.is_uppercase() => 0.76,
        _ => 0.64,
    }
}

/// Splits a label at `_{…}` and `^{…}`; what no XML document may hold, and what would turn the rest of the label, become
/// blanks.
fn parts(label: &str) -> Vec<(Script, String)> {
    let forbidden = |c: char| is_unseen(c) || matches!(c, '\u{FFFE}' | '\u{FFFF}');
    let clean: String = label.chars().map(|c| if forbidden(c) { ' ' } else { c }).collect();
    let mut parts = Vec::new();
    let mut line = String::new();
    let mut rest = clean.as_str();
    while let Some(c) = rest.chars().next() {
        let script = match c {
            '_' => Some(LOWERED),
            '^' => Some(RAISED),
            _ => None,
        };
        let after = &rest[c.len_utf8()..];
        let braces = after.strip_prefix('{').and_then(|s| s.split_once('}'));
        if let Some((script, (inner, tail))) = script.zip(braces) {
            if !line.is_empty() {
                parts.push((LINE, std::mem::take(&mut line)));
            }
            parts.push((script, inner.to_owned()));
            rest = tail;
        } else {
            line.push(c);
            rest = after;
        }
    }
    if !line.is_empty() {
        parts.push((LINE, line));
    }
    parts
}

/// A number to a hundredth, as short as it goes.
pub(super) fn decimal(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    match short {
        "-0" | "" => "0".to_owned(),
        _ => short.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_braces_make_scripts() {
        let line = |s: &str| (LINE, s.to_string());
        assert_eq!(parts("AK_10^x"), [line("AK_10^x")]);
        assert_eq!(parts("a_{b"), [line("a_{b")]);
        assert_eq!(
            parts("e_{inf}^{2}/ρ"),
            [(line("e")), (LOWERED, "inf".into()), (RAISED, "2".into()), line("/ρ")]
        );
        assert_eq!(parts("a\u{0}b\u{FFFF}"), [line("a b ")]);
        assert_eq!(parts("a\u{202e}b\u{3164}"), [line("a b ")]);
    }

    #[test]
    fn text_after_scripts_returns_to_the_line() {
        let tags = markup("e_{n}^{2} x", 20.0);
        let shifts = tags.split("<tspan dy=\"").skip(1);
        let shifts: f64 = shifts
            .map(|t| t.split('"').next().unwrap().parse::<f64>().unwrap())
            .sum();
        assert!(
            tags.contains("font-size=\"15\"") && !tags.contains('%') && !tags.contains("em"),
            "{tags}"
        );
        assert!(shifts.abs() < 0.02, "{tags}");
    }

    #[test]
    fn marks_over_a_letter_take_no_room() {
        assert_eq!(width("ρ\u{303}", 10.0), width("ρ", 10.0));
        assert!(width("e_{n}", 10.0) < width("en", 10.0));
        assert!(width("粒子", 10.0) > width("mm", 10.0));
    }

    #[test]
    fn numbers_are_short_and_to_a_hundredth() {
        let values = [-0.001, 100.0, 1.5, -2.999, 0.126];
        assert_eq!(values.map(decimal), ["0", "100", "1.5", "-3", "0.13"]);
    }
}
