//! Says what a reader of an answer should look at: the command ran, but something wants a second look.

/// Whether a notice bears on the numbers that are quoted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize))]
#[cfg_attr(feature = "cli", serde(rename_all = "lowercase"))]
pub enum Level {
    /// it may change a main number or its ±, or what may be concluded from it
    Cautions,
    /// it moves no main number by more than a quarter of its ±
    Informs,
}

/// One thing to look at, counted, with what to do about it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize))]
pub struct Notice {
    /// a fixed word a script can test for
    pub code: &'static str,
    /// whether it bears on the numbers that are quoted
    pub level: Level,
    /// how many runs, series or keys it concerns
    pub count: usize,
    /// what happened
    pub text: String,
    /// what the reader can do
    pub next_step: String,
}

impl Notice {
    /// A caution from its parts.
    pub fn new(code: &'static str, count: usize, text: impl Into<String>, next_step: impl Into<String>) -> Notice {
        Notice {
            code,
            level: Level::Cautions,
            count,
            text: text.into(),
            next_step: next_step.into(),
        }
    }

    /// The same, at another level.
    #[must_use]
    pub fn at(self, level: Level) -> Notice {
        Notice { level, ..self }
    }

    /// Whether it bears on the numbers that are quoted.
    pub fn cautions(&self) -> bool {
        self.level == Level::Cautions
    }
}
