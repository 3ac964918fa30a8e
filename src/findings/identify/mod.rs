//! Says which directions of the parameters the runs can identify.
//!
//! | file | job |
//! |---|---|
//! | `words.rs` | why a direction is not seen, and what would show it |
//!
//! A direction is unidentified where the runs say less of it than its prior: the slopes of every restitution, wet and dry,
//! over the runs' spread and for a step of one prior sd in the logarithm of each parameter, leave it a singular value
//! below 1, and the prior then more than 1/√2 of its sd. Stuck runs are left out, as by least squares. In the place of a
//! prior that least squares contradicts stands the default one.

mod words;

use schemars::JsonSchema;
use serde::Serialize;

use super::balance::with_inertia_of;
use super::least_squares::LeastSquares;
use super::remarks;
use crate::distributions::gamma_quantile;
use crate::inference::information::{DirectionalInformation, LogNormalPrior, RunsWithPriors, UnseenGroup};
use crate::inference::joint::Joint;
use crate::model::parameters::{prior_of, ParameterKind};
use crate::remark::Remark;
use crate::runs::Runs;
use crate::scene::{Prior, Scene};

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
pub fn identify_directions(scene: &Scene, runs: &Runs, least_squares: &LeastSquares) -> Option<Directions> {
    let identifiability = Identifiability::of(scene, runs, least_squares)?;
    let left = identifiability.information.left();
    let (least, spread_left) = left.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    let kind = |place: &usize| identifiability.kinds[*place];
    let name = |place: &usize| kind(place).name(scene, runs);
    let film_scale = identifiability.value(ParameterKind::FILM_SCALE);
    let unseen = identifiability.unseen().into_iter().map(|group| {
        let kinds: Vec<_> = group.members.iter().map(kind).collect();
        let (reason, add) = words::why(scene, runs, film_scale, &kinds, group.directions);
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

/// The parameters that runs could identify, and the information they give.
struct Identifiability {
    /// the parameters, those the scene holds left out
    kinds: Vec<ParameterKind>,
    /// where the slopes were taken
    values: Vec<f64>,
    /// information of the runs and of the priors there
    information: DirectionalInformation,
    /// the same beside the default priors, where the scene's are narrower
    beside_defaults: DirectionalInformation,
    /// whether that is where the energy balance was fitted, without priors
    fitted: bool,
}

impl Identifiability {
    /// `None` without parameters, or where a sum is not finite.
    fn of(scene: &Scene, runs: &Runs, least_squares: &LeastSquares) -> Option<Identifiability> {
        let form = with_inertia_of(least_squares.form, least_squares.energy_balance.as_ref());
        let spheres = || 0..runs.spheres.len();
        let wet: Vec<usize> = spheres().filter(|s| !runs.series_of(*s).is_empty()).collect();
        let dry: Vec<usize> = spheres().filter(|s| !runs.dry_of(*s).is_empty()).collect();
        let joint = Joint::new(scene, runs, form, &wet, &dry);
        let all: Vec<ParameterKind> = joint.kinds().collect();
        let priors: Vec<Prior> = all.iter().map(|kind| prior_of(scene, runs, *kind, form).0).collect();
        let is_free = |j: &usize| !matches!(priors[*j], Prior::Fixed(_));
        let free: Vec<usize> = (0..all.len()).filter(is_free).collect();
        if free.is_empty() {
            return None;
        }
        let believed = |j: &usize| {
            let own = belief(&priors[*j]);
            // beside a prior that the runs contradict it is asked what they see beside the default one
            match estimate(runs, least_squares, all[*j], false) {
                Some((value, se)) if own.is_contradicted_by(value, se) => belief(&all[*j].default_prior(form).0),
                _ => own,
            }
        };
        let beliefs: Vec<LogNormalPrior> = free.iter().map(believed).collect();
        let held: Vec<f64> = priors.iter().map(Prior::median).collect();
        let whole = |values: &[f64]| {
            let mut full = held.clone();
            free.iter().zip(values).for_each(|(j, value)| full[*j] = *value);
            full
        };
        let sums = |values: &[f64]| {
            let full = whole(values);
            let wet = joint.sums(joint.wet_parts(), &full).of(&free);
            vec![wet, joint.sums(joint.dry_parts(), &full).of(&free)]
        };
        let spreads = measured_spreads(least_squares).map(|(kind, measured)| {
            let median = prior_of(scene, runs, kind, form).0.median();
            // runs that nothing but their errors scatters
            let expected = if median > 0.0 { median } else { typical_error(runs) };
            // runs that scatter less than is usual tell more
            measured.map_or(expected, |measured| measured.clamp(LEAST_SPREAD * expected, expected))
        });
        let evidence = RunsWithPriors {
            beliefs: &beliefs,
            spreads: &spreads,
            sums: &sums,
        };
        let kinds: Vec<ParameterKind> = free.iter().map(|j| all[*j]).collect();
        let (values, fitted) = linearisation_point(runs, least_squares, &evidence, &kinds)?;
        let information = evidence.information(&values)?;
        let wider = kinds.iter().zip(&beliefs).map(|(kind, own)| {
            let default = belief(&kind.default_prior(form).0);
            if default.ln_sd > own.ln_sd {
                default
            } else {
                *own
            }
        });
        let beside_defaults = RunsWithPriors {
            beliefs: &wider.collect::<Vec<_>>(),
            ..evidence
        };
        let beside_defaults = beside_defaults.information(&values)?;
        Some(Identifiability {
            kinds,
            values,
            information,
            beside_defaults,
            fitted,
        })
    }

    /// The parameters that the runs cannot tell. One of which they say less than a narrow prior of the scene, but more than
    /// the default one, they can.
    fn unseen(&self) -> Vec<UnseenGroup> {
        let others = self.beside_defaults.unseen();
        let hidden = |place: &usize| others.iter().any(|other| other.members.contains(place));
        let mut groups = self.information.unseen();
        groups.retain(|group| group.members.iter().any(hidden));
        groups
    }

    /// Value of a parameter; `None` where the scene holds it.
    fn value(&self, kind: ParameterKind) -> Option<f64> {
        let place = self.kinds.iter().position(|own| *own == kind)?;
        Some(self.values[place])
    }
}

/// Prior sds beyond which a start is none.
const FAR: f64 = 10.0;

/// Where to take the slopes: at the least-squares estimates, where all are more certain than their priors, else where runs
/// and priors together have their least squares; with whether it is the first.
fn linearisation_point(
    runs: &Runs,
    least_squares: &LeastSquares,
    evidence: &RunsWithPriors,
    kinds: &[ParameterKind],
) -> Option<(Vec<f64>, bool)> {
    let with_beliefs = || kinds.iter().zip(evidence.beliefs);
    let alone = with_beliefs().map(|(kind, belief)| {
        let (value, se) = estimate(runs, least_squares, *kind, true)?;
        // an estimate less certain than the prior is no place to take slopes at
        (se < value * belief.ln_sd).then_some(value)
    });
    if let Some(values) = alone.collect() {
        return Some((values, true));
    }
    let near = |(kind, belief): (&ParameterKind, &LogNormalPrior)| {
        let found = estimate(runs, least_squares, *kind, false).map(|(value, _)| value);
        // a fit that ran away is no place to start from
        let here = |value: &f64| (value / belief.median).ln().abs() < FAR * belief.ln_sd;
        found.filter(here).unwrap_or(belief.median)
    };
    let start: Vec<f64> = with_beliefs().map(near).collect();
    // runs that determine nothing may lead a search on and on: the slopes where it got to tell so all the same
    Some((evidence.fit_with_priors(&start)?, false))
}

/// Where least squares found a parameter, with its standard error: in the energy balance, which alone knows of k of a
/// sphere with wet runs where `balance_alone`, or in the dry runs. `None` unless it is positive.
fn estimate(runs: &Runs, least_squares: &LeastSquares, kind: ParameterKind, balance_alone: bool) -> Option<(f64, f64)> {
    let in_balance = || least_squares.energy_balance.as_ref()?.estimate(kind)?.value_and_scale();
    let of_dry = || {
        // a sphere without wet runs has its k from the dry ones, and no other
        let by_dry = |sphere: &usize| !balance_alone || runs.series_of(*sphere).is_empty();
        let sphere = kind.sphere().filter(by_dry)?;
        let dry = least_squares.dry.iter().find(|dry| dry.sphere == sphere)?;
        dry.dry_k.pair().filter(|_| dry.verdict.passed)
    };
    in_balance().or_else(of_dry).filter(|(value, _)| *value > 0.0)
}

/// A prior as median and sd of the logarithm; one that is not lognormal by its sd over its median.
fn belief(prior: &Prior) -> LogNormalPrior {
    let (sd, median) = match *prior {
        Prior::LogNormal(median, ln_sd) => return LogNormalPrior { median, ln_sd },
        Prior::StudentT(_, location, scale) => (prior.sd().unwrap_or(scale), location),
        _ => (prior.sd().unwrap_or(1.0), prior.median()),
    };
    // parameters are positive: a prior about 0 or below believes in about its sd
    let median = if median > 0.0 { median } else { sd };
    LogNormalPrior {
        median,
        ln_sd: sd / median,
    }
}

/// Share of the usual spread below which a spread is no measurement, but rounding.
const LEAST_SPREAD: f64 = 1e-3;

/// What wet and dry runs scatter by about the laws at most, which of few runs is far more than what they show.
fn measured_spreads(least_squares: &LeastSquares) -> [(ParameterKind, Option<f64>); 2] {
    /// chance that runs scatter by more
    const BEYOND: f64 = 0.05;
    let at_most = |sd: f64, runs: usize, parameters: usize| {
        let freedom = runs.checked_sub(parameters).filter(|freedom| *freedom > 0)? as f64;
        let chi_squared = 2.0 * gamma_quantile(BEYOND, 0.5 * freedom)?;
        Some(sd * (freedom / chi_squared).sqrt())
    };
    let wet = least_squares
        .energy_balance
        .as_ref()
        .filter(|balance| balance.verdict.passed);
    let wet = wet.and_then(|balance| at_most(balance.residual_sd?, balance.runs, balance.parameters.len()));
    let dry = least_squares.dry.iter().filter(|dry| dry.verdict.passed);
    let dry = dry.filter_map(|dry| at_most(dry.residual_sd?, dry.runs, 1));
    [
        (ParameterKind::SigmaWet, wet),
        (ParameterKind::SigmaDry, dry.reduce(f64::max)),
    ]
}

/// Root mean square of what the restitutions err by.
fn typical_error(runs: &Runs) -> f64 {
    let stated = runs.errors.iter().map(|error| error.restitution_sd);
    let squares: f64 = stated.map(|sd| sd * sd).sum();
    (squares / runs.len().max(1) as f64).sqrt()
}
