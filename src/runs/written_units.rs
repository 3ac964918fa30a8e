//! Reads the units that names of columns have.

/// How units are written.
const UNITS: [(&str, &str); 14] = [
    ("mm", "_mm"),
    ("µm", "_um"),
    ("μm", "_um"),
    ("um", "_um"),
    ("micron", "_um"),
    ("microns", "_um"),
    ("cm", "_cm"),
    ("m", "_m"),
    ("m/s", "_m_s"),
    ("ms", "_m_s"),
    ("cm/s", "_cm_s"),
    ("cms", "_cm_s"),
    ("mm/s", "_mm_s"),
    ("mms", "_mm_s"),
];

/// What our names end with in a unit that is written so; `None` where none of ours is.
pub(super) fn unit_of(text: &str) -> Option<&'static str> {
    let text: String = text
        .chars()
        .filter(|c| !c.is_whitespace() && !"_^-¹1".contains(*c))
        .collect();
    let unit = UNITS.iter().find(|(written, _)| *written == text);
    unit.map(|(_, suffix)| *suffix)
}

/// What stands before a unit in brackets, and what our names end with in that unit.
pub(super) fn unit_in_brackets(name: &str) -> Option<(&str, &'static str)> {
    let at = name.find(['(', '['])?;
    let inside = name[at + 1..].trim_end().trim_end_matches([')', ']']);
    Some((&name[..at], unit_of(inside)?))
}
