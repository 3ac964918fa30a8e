//! Sets subscripts and superscripts in labels, and estimates how wide a label gets.

use crate::error::is_unseen;

/// Stand-ins, from Unicode's private area, for the characters of a tag. kuva escapes every
/// `<` and has no way to raise or lower part of a line, so tags travel through it in disguise.
const DISGUISE: [(char, &str); 3] = [('\u{E000}', "<"), ('\u{E001}', ">"), ('\u{E002}', "\"")];

/// Size of a script relative to its line.
const SCRIPT: f64 = 0.75;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Level {
    Line,
    Lowered,
    Raised,
}

impl Level {
    /// Distance below the line, in the line's em.
    fn drop(self) -> f64 {
        match self {
            Level::Line => 0.0,
            Level::Lowered => 0.22,
            Level::Raised => -0.36,
        }
    }
}

/// Prepares a label for kuva; [`finish`] completes it.
pub(super) fn markup(label: &str) -> String {
    let mut out = String::new();
    let mut at = 0.0;
    for (level, run) in runs(label) {
        let size = if level == Level::Line { 1.0 } else { SCRIPT };
        let shift = level.drop() - at;
        at = level.drop();
        // A dollar sign would start a formula of kuva's own.
        let run = run.replace('$', "\\$");
        if shift == 0.0 {
            out.push_str(&run);
        } else {
            out.push_str(&format!(
                "\u{E000}tspan dy=\u{E002}{:.3}em\u{E002} font-size=\u{E002}{:.0}%\u{E002}\u{E001}{run}\u{E000}/tspan\u{E001}",
                shift / size,
                100.0 * size
            ));
        }
    }
    out
}

/// Takes the tags of [`markup`] out of their disguise in a finished document.
pub(super) fn finish(document: &str) -> String {
    DISGUISE
        .iter()
        .fold(document.to_string(), |d, &(c, tag)| d.replace(c, tag))
}

/// Estimates a label's width in pixels, generously: what viewers substitute for the fonts
/// asked for is unknown, and among the usual ones only bold or monospaced faces are wider.
pub(super) fn width(label: &str, size: u32) -> f64 {
    let em: f64 = runs(label)
        .iter()
        .map(|(level, run)| {
            let size = if *level == Level::Line { 1.0 } else { SCRIPT };
            let spacing = run.chars().filter(|c| !combining(*c)).count();
            size * spacing as f64
        })
        .sum();
    0.63 * em * f64::from(size)
}

fn combining(c: char) -> bool {
    ('\u{300}'..='\u{36F}').contains(&c)
}

/// Splits a label at `_{…}` and `^{…}`; what no XML document may hold, and what would turn the rest of the label, become
/// blanks.
fn runs(label: &str) -> Vec<(Level, String)> {
    let forbidden = |c: char| is_unseen(c) || matches!(c, '\u{E000}'..='\u{E002}' | '\u{FFFE}' | '\u{FFFF}');
    let clean: String = label.chars().map(|c| if forbidden(c) { ' ' } else { c }).collect();
    let mut runs = Vec::new();
    let mut line = String::new();
    let mut rest = clean.as_str();
    while let Some(c) = rest.chars().next() {
        let level = match c {
            '_' => Level::Lowered,
            '^' => Level::Raised,
            _ => Level::Line,
        };
        let after = &rest[c.len_utf8()..];
        let script = after.strip_prefix('{').and_then(|s| s.split_once('}'));
        match script {
            Some((inner, tail)) if level != Level::Line => {
                if !line.is_empty() {
                    runs.push((Level::Line, std::mem::take(&mut line)));
                }
                runs.push((level, inner.to_string()));
                rest = tail;
            }
            _ => {
                line.push(c);
                rest = after;
            }
        }
    }
    if !line.is_empty() {
        runs.push((Level::Line, line));
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_braces_make_scripts() {
        let line = |s: &str| (Level::Line, s.to_string());
        assert_eq!(runs("AK_10^x"), [line("AK_10^x")]);
        assert_eq!(runs("a_{b"), [line("a_{b")]);
        assert_eq!(
            runs("e_{inf}^{2}/ρ"),
            [
                (line("e")),
                (Level::Lowered, "inf".into()),
                (Level::Raised, "2".into()),
                line("/ρ")
            ]
        );
        assert_eq!(runs("a\u{0}b\u{E000}"), [line("a b ")]);
        assert_eq!(runs("a\u{202e}b\u{3164}"), [line("a b ")]);
    }

    #[test]
    fn text_after_scripts_returns_to_the_line() {
        let tags = finish(&markup("e_{n}^{2} x"));
        let shifts: f64 = tags
            .split("<tspan dy=\"")
            .skip(1)
            .map(|t| {
                let shift: f64 = t.split("em").next().unwrap().parse().unwrap();
                let size = if t.contains("75%") { SCRIPT } else { 1.0 };
                shift * size
            })
            .sum();
        assert!(shifts.abs() < 2e-3, "{tags}");
    }

    #[test]
    fn marks_over_a_letter_take_no_room() {
        assert_eq!(width("ρ\u{303}", 10), width("ρ", 10));
        assert!(width("e_{n}", 10) < width("en", 10));
    }
}
