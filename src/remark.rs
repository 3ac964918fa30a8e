//! Says one thing that a reader of an answer should know: what was found, how much it matters, and what to do about it.

use Line::{AtLeast, AtMost};

/// How much a remark bears on the numbers that are quoted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "cli", serde(rename_all = "lowercase"))]
pub enum Level {
    /// the main numbers are not to be quoted
    Forbids,
    /// it may change a main number or its ±, or what may be concluded from it
    Cautions,
    /// it moves no main number by more than a quarter of its ±
    Informs,
}

/// On which side of its line a value must lie; the line itself counts as holding. In a file it is its number.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, schemars::JsonSchema))]
#[cfg_attr(feature = "cli", serde(untagged))]
pub enum Line {
    /// no larger than this
    AtMost(f64),
    /// no smaller than this
    AtLeast(f64),
}

impl Line {
    /// Its number.
    pub fn threshold(self) -> f64 {
        match self {
            AtMost(line) | AtLeast(line) => line,
        }
    }

    /// Whether a value lies on the right side; NaN does not.
    pub fn holds(self, value: f64) -> bool {
        match self {
            AtMost(line) => value <= line,
            AtLeast(line) => value >= line,
        }
    }

    /// Another line on the same side.
    #[must_use]
    pub fn at(self, line: f64) -> Line {
        match self {
            AtMost(_) => AtMost(line),
            AtLeast(_) => AtLeast(line),
        }
    }
}

/// What a remark concerns that every main number rests on.
pub const ALL: &str = "all";

/// One thing to look at, with what to do about it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Remark {
    /// a fixed word a script can test for
    pub code: &'static str,
    /// what was found, `None` where nothing could be; without a line how many runs, series or keys it concerns
    pub value: Option<f64>,
    /// what the value is held against; `None` of what is only told where it is found
    pub line: Option<Line>,
    /// whether the value lies on the right side of its line
    pub passed: bool,
    /// how much it bears on the main numbers, if it failed
    pub level: Level,
    /// where the line comes from
    pub source: &'static str,
    /// what happened
    pub text: String,
    /// what the reader can do
    pub next_step: String,
    /// names of the main numbers that rest on it, or `all`; empty where no main number does
    pub concerns: Vec<String>,
}

impl Remark {
    /// A caution without a line, of so many.
    pub fn new(code: &'static str, count: usize, text: impl Into<String>, next_step: impl Into<String>) -> Remark {
        Remark {
            code,
            value: Some(count as f64),
            line: None,
            passed: false,
            level: Level::Cautions,
            source: "",
            text: text.into(),
            next_step: next_step.into(),
            concerns: vec![ALL.to_owned()],
        }
    }

    /// The same, at another level.
    #[must_use]
    pub fn at(mut self, level: Level) -> Remark {
        self.level = level;
        if level == Level::Informs {
            self.concerns.clear();
        }
        self
    }

    /// A caution where a main number feels it; else it only informs.
    #[must_use]
    pub fn cautioning_if(self, felt: bool) -> Remark {
        self.at(if felt { Level::Cautions } else { Level::Informs })
    }

    /// The same with something more particular to do.
    #[must_use]
    pub fn then(mut self, next_step: impl Into<String>) -> Remark {
        self.next_step = next_step.into();
        self
    }

    /// The same, where a failure does not forbid quoting unless this is so.
    #[must_use]
    pub fn forbidding_if(self, forbids: bool) -> Remark {
        match (forbids, self.level) {
            (true, _) => self.at(Level::Forbids),
            (false, Level::Forbids) => self.at(Level::Cautions),
            _ => self,
        }
    }

    /// That only these main numbers rest on; where there are none, it only informs.
    #[must_use]
    pub fn concerning(self, names: impl IntoIterator<Item = String>) -> Remark {
        let concerns: Vec<String> = names.into_iter().collect();
        if concerns.is_empty() {
            return self.at(Level::Informs);
        }
        Remark { concerns, ..self }
    }

    /// With more words where it failed.
    #[must_use]
    pub fn if_failed(mut self, words: &str) -> Remark {
        if !self.passed {
            self.text = format!("{}; {words}", self.text);
        }
        self
    }

    /// How many runs, series or keys it concerns.
    pub fn count(&self) -> usize {
        self.value.map_or(0, |value| value as usize)
    }

    /// Whether a failure forbids quoting the main numbers.
    pub fn gates(&self) -> bool {
        self.level == Level::Forbids
    }

    /// Whether it forbids quoting the main numbers.
    pub fn forbids(&self) -> bool {
        !self.passed && self.gates()
    }

    /// Whether it bears on a main number, and forbids nothing.
    pub fn cautions(&self) -> bool {
        !self.passed && self.level == Level::Cautions
    }

    /// Whether it is told though no main number rests on it.
    pub fn informs(&self) -> bool {
        !self.passed && self.level == Level::Informs
    }
}
