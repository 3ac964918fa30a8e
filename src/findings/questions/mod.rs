//! Answers what the paper leaves open about the film: is L constant where films are thin, is C at every film ratio?
//!
//! | file | job |
//! |---|---|
//! | `question.rs` | a question with its answer, in fields |
//! | `effect.rs` | how far a trend moves what is quoted, and which runs would tell more of it |
//! | `conclusion.rs` | concludes from a model with and one without a trend |
//! | `trend_comparison.rs` | samples the two on the same runs, and leaves each run out of both |

mod conclusion;
mod effect;
mod question;
mod trend_comparison;

use super::checks::Check;
use crate::error::Error;
use crate::model::parameters::ParameterKind;
use trend_comparison::TrendComparison;

pub use conclusion::SMALL;
pub use question::{Answer, Question, Trend};
pub use trend_comparison::Context;

/// The paper takes L as constant for film ratios below this one (text of its summary).
pub const THIN: f64 = 0.10;

/// Both questions, in the order of the paper's text, and whether a trend that was seen forbids quoting.
///
/// Fails where a prior leaves a parameter no room.
pub fn answer_questions(context: Context) -> Result<(Vec<Question>, Vec<Check>), Error> {
    let questions = vec![is_lubrication_constant(context, THIN)?, is_prefactor_constant(context)?];
    let checks = questions.iter().filter_map(conclusion::check_trend).collect();
    Ok((questions, checks))
}

/// Whether one L holds for the runs with film ratios below a line, under the scene's own form.
pub fn is_lubrication_constant(context: Context, below: f64) -> Result<Question, Error> {
    let question = Question {
        film_ratio_below: Some(below),
        ..unanswered(
            "Is L the same at every film ratio below 0.10?",
            ParameterKind::LUBRICATION_LOG,
        )
    };
    if let Some(why) = context.why_none() {
        return Ok(question.open(&why));
    }
    let part = context.runs.with_films_below(below);
    let models = TrendComparison {
        // nothing was left out: the scene's own draws are of these runs
        plain: (part.len() == context.runs.len()).then_some(&context.own.sampled),
        context,
        runs: &part,
        trend: ParameterKind::LubricationTrend,
        of: ParameterKind::LUBRICATION_LOG,
    };
    models.answer(question)
}

/// Whether one C holds for all runs, under the scene's own form.
pub fn is_prefactor_constant(context: Context) -> Result<Question, Error> {
    let question = unanswered("Is C the same at every film ratio?", ParameterKind::INERTIAL_PREFACTOR);
    if let Some(why) = context.why_none() {
        return Ok(question.open(&why));
    }
    let models = TrendComparison {
        plain: Some(&context.own.sampled),
        context,
        runs: context.runs,
        trend: ParameterKind::InertialTrend,
        of: ParameterKind::INERTIAL_PREFACTOR,
    };
    models.answer(question)
}

fn unanswered(question: &'static str, of: ParameterKind) -> Question {
    Question {
        question,
        parameter: of.key(),
        film_ratio_below: None,
        runs: 0,
        film_ratios: None,
        models: vec![],
        gain: None,
        gain_se: None,
        trend: None,
        answer: Answer::Open,
        text: String::new(),
        why_open: None,
    }
}
