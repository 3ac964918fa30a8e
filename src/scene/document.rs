//! Keeps a scene file's text and gathers the problems found in it.

use std::cell::{OnceCell, RefCell};

use crate::encoding::line_ends;
use crate::error::{Problem, PROBLEMS_SHOWN};

/// The text of a file and the problems found in it so far.
pub(super) struct Document<'i> {
    pub text: &'i str,
    problems: RefCell<Vec<(usize, Problem)>>,
    /// where lines end, once a problem needs its line: each problem of many would count them anew
    ends: OnceCell<Vec<usize>>,
}

impl<'i> Document<'i> {
    pub fn new(text: &'i str) -> Self {
        Document {
            text,
            problems: RefCell::default(),
            ends: OnceCell::new(),
        }
    }

    /// Problems in the order of the file.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = self.problems.take();
        problems.sort_by_key(|(at, _)| *at);
        problems.into_iter().map(|(_, problem)| problem).collect()
    }

    /// Remembers a problem and where in the text it stands.
    pub fn report(&self, at: usize, problem: Problem) {
        self.problems.borrow_mut().push((at, problem));
    }

    /// Whether more problems were found than are printed.
    pub fn is_full(&self) -> bool {
        self.problems.borrow().len() >= PROBLEMS_SHOWN
    }

    /// The line, from 1, that a byte stands on.
    pub fn line(&self, at: usize) -> u64 {
        let ends = self.ends.get_or_init(|| line_ends(self.text.as_bytes()).collect());
        1 + ends.partition_point(|end| *end < at) as u64
    }
}
