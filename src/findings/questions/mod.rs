//! Answers what the paper leaves open about the film: is L constant where films are thin, is C at every film ratio?
//!
//! | file | job |
//! |---|---|
//! | `ask.rs` | samples a model with and without a trend on the same runs, and leaves each run out of both |
//! | `answer.rs` | says what the two tell |

mod answer;
mod ask;

use serde::Serialize;

use super::compare::{affordable, Compared};
use super::posterior::Posterior;
use super::Findings;
use crate::error::Error;
use crate::inference::diagnostics::loo::Loo;
use crate::inference::nuts::Watcher;
use crate::model::parameters::Kind;
use crate::notice::Notice;
use crate::runs::Runs;
use crate::scene::Scene;
use ask::Models;

pub use answer::Answer;

/// The paper takes L as constant for film ratios below this one (text of its summary).
pub const THIN: f64 = 0.10;

/// A question with its answer. Field names are those of `findings.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Question {
    /// in words
    pub question: &'static str,
    /// the parameter it asks of: `lubrication_log`, `inertial_prefactor`
    pub parameter: &'static str,
    /// only runs with film ratios below this one are asked; `None`: all
    pub film_ratio_below: Option<f64>,
    /// wet runs that are asked
    pub runs: usize,
    /// film ratios that enough of them have; `None` where they were not counted
    pub film_ratios: Option<usize>,
    /// the model without the trend and the one with it; none where nothing was sampled
    pub models: Vec<Compared>,
    /// by how much the trend predicts runs better, in log density summed over them
    pub gain: Option<f64>,
    /// standard error of the gain, run by run
    pub gain_se: Option<f64>,
    /// the trend; `None` where nothing was sampled
    pub trend: Option<Trend>,
    /// what that tells
    pub answer: Answer,
    /// the same in words
    pub text: String,
}

/// How a parameter goes with the logarithm of the film ratio: dL/d ln δ̃ or d ln C/d ln δ̃.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trend {
    /// its letter
    pub symbol: &'static str,
    /// mean of the posterior
    pub mean: f64,
    /// its standard deviation
    pub sd: f64,
    /// its central 95 %
    pub interval: [f64; 2],
    /// what was believed before, as a scene writes it
    pub prior: String,
    /// why
    pub source: &'static str,
}

/// What the questions are asked of.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// what was held fixed
    pub scene: &'a Scene,
    /// every run
    pub runs: &'a Runs,
    /// where sampling starts
    pub least_squares: &'a Findings,
    /// the scene's own model, sampled on every run
    pub own: &'a Posterior,
    /// leave-one-out of it; `None` where it has yet to be computed
    pub own_loo: Option<&'a Loo>,
    /// hears of every draw
    pub watcher: Watcher<'a>,
}

/// Both questions, in the order of the paper's text, and what wants a second look.
///
/// Fails where a prior leaves a parameter no room.
pub fn find(context: Context) -> Result<(Vec<Question>, Vec<Notice>), Error> {
    let questions = vec![is_lubrication_constant(context, THIN)?, is_prefactor_constant(context)?];
    let notices = questions.iter().filter_map(answer::notice).collect();
    Ok((questions, notices))
}

/// Whether one L serves the runs with film ratios below a line, under the scene's own form.
pub fn is_lubrication_constant(context: Context, below: f64) -> Result<Question, Error> {
    let question = Question {
        film_ratio_below: Some(below),
        ..unanswered("Is L the same at every film ratio below 0.10?", Kind::LubricationLog)
    };
    if let Some(why) = too_many(context) {
        return Ok(question.open(&why));
    }
    let part = context.runs.with_films_below(below);
    let models = Models {
        // nothing was left out: the scene's own draws are of these runs
        plain: (part.len() == context.runs.len()).then_some(&context.own.sampled),
        context,
        runs: &part,
        trend: Kind::LubricationTrend,
        of: Kind::LubricationLog,
    };
    models.ask(question)
}

/// Whether one C serves all runs, under the scene's own form.
pub fn is_prefactor_constant(context: Context) -> Result<Question, Error> {
    let question = unanswered("Is C the same at every film ratio?", Kind::InertialPrefactor);
    if let Some(why) = too_many(context) {
        return Ok(question.open(&why));
    }
    let models = Models {
        plain: Some(&context.own.sampled),
        context,
        runs: context.runs,
        trend: Kind::InertialTrend,
        of: Kind::InertialPrefactor,
    };
    models.ask(question)
}

fn unanswered(question: &'static str, of: Kind) -> Question {
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
    }
}

/// Why the runs are not asked at all.
fn too_many(context: Context) -> Option<String> {
    let runs = context.runs;
    if runs.series.is_empty() {
        return Some("no wet runs in use".to_owned());
    }
    let draws = context.own.sampled.draws();
    let none = affordable(runs, draws).is_none();
    none.then(|| format!("{} runs are too many to leave each out", runs.len()))
}

impl Question {
    /// The same, left open for a reason.
    fn open(self, why: &str) -> Question {
        Question {
            answer: Answer::Open,
            text: format!("open: {why}"),
            ..self
        }
    }
}
