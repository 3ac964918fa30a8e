//! Says which directions of the parameters the runs can identify.
//!
//! | file | job |
//! |---|---|
//! | `identifiability.rs` | the information of the runs at the fit, beside that of the priors |
//! | `words.rs` | why a direction is not seen, and what would show it |
//!
//! A direction is unidentified where the runs say less of it than its prior: the slopes of every restitution, wet and dry,
//! over the runs' spread and for a step of one prior sd in the logarithm of each parameter, leave it a singular value
//! below 1, and the prior then more than 1/√2 of its sd. Stuck runs are left out, as by least squares. In the place of a
//! prior that least squares contradicts stands the default one.

mod identifiability;
mod words;

use schemars::JsonSchema;
use serde::Serialize;

use super::least_squares::LeastSquares;
use super::remarks;
use crate::remark::Remark;
use crate::runs::Runs;
use crate::scene::Scene;
use identifiability::Identifiability;

/// Identifiability of the parameters together.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Directions {
    /// where the slopes were taken: `least_squares`, or `least_squares_with_priors` where the energy balance alone has
    /// no answer
    pub at: &'static str,
    /// the parameter that keeps most of its prior
    pub least_known: String,
    /// the same in words
    #[serde(skip)]
    pub least_known_words: String,
    /// the share of its prior sd it keeps
    pub spread_left: f64,
    /// what the runs cannot see
    pub unseen: Vec<Unidentified>,
}

/// Parameters that the runs do not tell apart.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Unidentified {
    /// their names
    pub parameters: Vec<String>,
    /// in how many directions they do
    pub directions: usize,
    /// largest share of a prior sd that one of them keeps
    pub spread_left: f64,
    /// why, and which cannot be told apart
    pub reason: String,
    /// the runs that would show it
    pub add: String,
}

/// Identifiability of the parameters at the fit; `None` without parameters, or where a sum is not finite.
pub fn identify_directions(scene: &Scene, runs: &Runs, least_squares: LeastSquares) -> Option<Directions> {
    let identifiability = Identifiability::of(scene, runs, least_squares)?;
    let left = identifiability.information.left();
    let (least, spread_left) = left.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    let kind = |place: &usize| identifiability.kinds[*place];
    let name = |place: &usize| kind(place).name(scene, runs);
    let unseen = identifiability.unseen().into_iter().map(|group| {
        let kinds: Vec<_> = group.members.iter().map(kind).collect();
        let (reason, add) = words::why(scene, runs, &identifiability, &kinds, group.directions);
        Unidentified {
            parameters: group.members.iter().map(name).collect(),
            directions: group.directions,
            spread_left: group.members.iter().map(|place| left[*place]).fold(0.0, f64::max),
            reason,
            add,
        }
    });
    Some(Directions {
        at: match identifiability.fitted {
            true => "least_squares",
            false => "least_squares_with_priors",
        },
        least_known: name(&least),
        least_known_words: words::word(scene, runs, identifiability.kinds[least]),
        spread_left: *spread_left,
        unseen: unseen.collect(),
    })
}

/// A notice of what the runs do not identify; `None` where they identify everything.
pub fn unidentified_notice(directions: Option<&Directions>) -> Option<Remark> {
    let unseen = &directions?.unseen;
    let reasons: Vec<&str> = unseen.iter().map(|one| one.reason.as_str()).collect();
    let next: Vec<&str> = unseen.iter().map(|one| one.add.as_str()).collect();
    let count = unseen.iter().map(|one| one.directions).sum();
    (count > 0).then(|| remarks::UNSEEN.notice(count, reasons.join("; ")).then(next.join("; ")))
}
