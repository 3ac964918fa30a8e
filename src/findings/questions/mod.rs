//! Answers what the paper leaves open about the film: is L constant where films are thin, is C at every film ratio?
//!
//! | file | job |
//! |---|---|
//! | `question.rs` | a question, what answers it, and the answer in fields and words |
//! | `trend_model.rs` | samples the scene's model with a trend, and says how far that moves what is quoted |

mod question;
mod trend_model;

use crate::error::Error;
use crate::model::parameters::ParameterKind;
use crate::remark::Remark;
use trend_model::TrendModel;

pub use question::{Answer, Question, Trend, SMALL};
pub use trend_model::Context;

/// The paper takes L as constant for film ratios below this one (text of its summary).
pub const THIN: f64 = 0.10;

/// Both questions, in the order of the paper's text, and whether a trend that was seen forbids quoting.
///
/// Fails where a prior leaves a parameter no room.
pub fn answer_questions(context: Context) -> Result<(Vec<Question>, Vec<Remark>), Error> {
    let questions = vec![is_lubrication_constant(context, THIN)?, is_prefactor_constant(context)?];
    let checks = questions.iter().filter_map(question::check_trend).collect();
    Ok((questions, checks))
}

/// Whether one L holds for the runs with film ratios below a line, under the scene's own form.
pub fn is_lubrication_constant(context: Context, below: f64) -> Result<Question, Error> {
    let model = TrendModel {
        context,
        runs: &context.comparison.runs.with_films_below(below),
        trend: ParameterKind::LubricationTrend,
        of: ParameterKind::LUBRICATION_LOG,
    };
    model.answer("Is L the same at every film ratio below 0.10?", Some(below))
}

/// Whether one C holds for all runs, under the scene's own form.
pub fn is_prefactor_constant(context: Context) -> Result<Question, Error> {
    let model = TrendModel {
        context,
        runs: context.comparison.runs,
        trend: ParameterKind::InertialTrend,
        of: ParameterKind::INERTIAL_PREFACTOR,
    };
    model.answer("Is C the same at every film ratio?", None)
}
