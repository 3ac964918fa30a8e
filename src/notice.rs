//! Says what a reader of an answer should look at: the command ran, but something wants a second look.

/// One thing to look at, counted, with what to do about it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize))]
pub struct Notice {
    /// a fixed word a script can test for
    pub code: &'static str,
    /// how many runs, series or keys it concerns
    pub count: usize,
    /// what happened
    pub text: String,
    /// what the reader can do
    pub next_step: String,
}

impl Notice {
    /// A notice from its parts.
    pub fn new(code: &'static str, count: usize, text: impl Into<String>, next_step: impl Into<String>) -> Notice {
        Notice {
            code,
            count,
            text: text.into(),
            next_step: next_step.into(),
        }
    }
}
