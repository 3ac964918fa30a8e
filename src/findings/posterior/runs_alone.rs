//! Finds what the runs alone say of each parameter, where a scene sets priors of its own: the normal about the mode of the
//! posterior under the default priors, with those taken out again.
//!
//! The scene's own posterior cannot tell: a prior far from the runs pulls the other parameters with it, and one with bounds
//! hides what lies beyond them.

use schemars::JsonSchema;
use serde::Serialize;

use super::sampling::SamplingSetup;
use crate::distributions::{f_tail, normal_quantile};
use crate::findings::remarks;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::importance::{propose, DrawCounts, ProposalTails};
use crate::inference::prepared_posterior::{PreparedPosterior, Start};
use crate::model::likelihood::Likelihood;
use crate::model::parameters::{ModelParameter, ModelParameters, ParameterKind};
use crate::runs::Runs;
use crate::scene::{Prior, Scene, SIGMA_ENERGY};
use crate::seed::StreamName;

/// What the runs alone say of a parameter, on the scale of its prior.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct RunsAlone {
    /// its value
    pub value: f64,
    /// its standard error
    pub se: f64,
    /// its distance from the centre of the prior, in sds of the two together, a spread's on the logarithm; from the nearer
    /// bound of a uniform one, in standard errors, and 0 inside. Of few runs it is that of a normal as improbable as theirs.
    pub from_prior: f64,
    /// its distance from the mean of the posterior, in sds of the posterior; from a value that is held, in standard errors
    pub from_posterior: f64,
}

/// A posterior that keeps more of its prior's sd says nothing of what the runs alone say.
const NARROWER: f64 = 0.95;

/// Value and standard error that runs give beside a prior, from the mean and the sd of the posterior in sds of the prior
/// from its centre: both taken as normals on the prior's scale. `None` where the posterior is no narrower than the prior.
fn without(prior: &Prior, mean: f64, sd: f64) -> Option<[f64; 2]> {
    if !(sd > 0.0 && sd < NARROWER) {
        return None;
    }
    let left = 1.0 - sd * sd;
    let [from, to] = [-1.0, 1.0].map(|side| prior.at_standard((mean + side * sd * left.sqrt()) / left));
    let found = [prior.at_standard(mean / left)?, 0.5 * (to? - from?)];
    found.iter().all(|x| x.is_finite()).then_some(found)
}

impl RunsAlone {
    /// Whether the runs contradict the prior.
    pub fn contradicts_prior(&self) -> bool {
        !remarks::PRIOR_CONFLICT.holds(self.from_prior.abs())
    }

    /// From the mean and the sd of the posterior in sds of its prior from the prior's centre.
    pub(super) fn of(prior: &Prior, mean: f64, sd: f64) -> Option<RunsAlone> {
        let [value, se] = without(prior, mean, sd)?;
        let left = 1.0 - sd * sd;
        Some(RunsAlone {
            value,
            se,
            from_prior: mean / left.sqrt(),
            from_posterior: mean * sd / left,
        })
    }
}

/// The sds of a normal beyond which as much lies as beyond so many of Student's t.
fn as_normal(t: f64, freedom: f64) -> f64 {
    /// beyond, a probability is no number
    const FAR: f64 = 37.0;
    let beyond = f_tail(t * t, 1.0, freedom).filter(|p| *p > 0.0);
    let z = beyond.map_or(FAR, |p| -normal_quantile(0.5 * p));
    z.min(t.abs()).copysign(t)
}

/// What the runs say of one parameter.
#[derive(Debug, Clone, Copy)]
struct Alone {
    kind: ParameterKind,
    /// value and standard error
    number: [f64; 2],
    /// degrees of freedom of that
    freedom: f64,
}

/// What the runs say of every parameter under the default priors.
#[derive(Debug, Clone)]
pub(super) struct UnderDefaults {
    of_each: Vec<Alone>,
}

impl UnderDefaults {
    /// `None` where the scene sets no prior, or where the posterior under the default ones has no peak.
    pub(super) fn of(
        scene: &Scene,
        runs: &Runs,
        setup: SamplingSetup,
        (likelihood, start): (&Likelihood, &Start),
        seed: u64,
    ) -> Option<UnderDefaults> {
        const DRAWS: usize = 2000;
        let mut plain = scene.clone();
        // one of no file is how far slow rebounds are trusted, which is not asked of the runs
        plain
            .priors
            .retain(|prior| prior.parameter == SIGMA_ENERGY.name && prior.line.is_none());
        if plain.priors.len() == scene.priors.len() {
            return None;
        }
        let parameters = ModelParameters::of(&plain, runs, setup.form).ok()?;
        let prepared = PreparedPosterior::new(parameters, likelihood, start).ok()?;
        let about = Some(&prepared.about).filter(|about| about.is_at_peak())?;
        let size = DrawCounts {
            chains: 1,
            draws: DRAWS,
        };
        let stream = StreamName::new(seed, "default priors");
        let proposed = propose(&prepared.posterior, (about, ProposalTails::Normal), size, stream);
        let points = proposed
            .iter()
            .flat_map(|one| one.points.chunks_exact(about.mode.len().max(1)));
        let draws: Vec<Vec<f64>> = points.map(|point| prepared.posterior.draw_at(point)).collect();
        let sampled = &prepared.posterior.parameters().sampled;
        let of_one = |(place, parameter): (usize, &ModelParameter)| {
            let on_scale = draws.iter().map(|draw| parameter.prior.standard(draw[place]));
            let on_scale: Vec<f64> = on_scale.collect::<Option<_>>()?;
            let found = summarise(&[on_scale.as_slice()]);
            Some(Alone {
                kind: parameter.kind,
                number: without(&parameter.prior, found.mean?, found.sd?)?,
                freedom: freedom(runs, sampled, parameter.kind),
            })
        };
        Some(UnderDefaults {
            of_each: sampled.iter().enumerate().filter_map(of_one).collect(),
        })
    }

    /// What the runs say of a parameter beside its own prior, and beside the mean and the sd of its posterior in sds of that prior
    /// from its centre.
    pub(super) fn beside(&self, parameter: &ModelParameter, [mean, sd]: [f64; 2]) -> Option<RunsAlone> {
        let Alone { number, freedom, .. } = *self.of_kind(parameter.kind)?;
        let [value, se] = number;
        let prior = &parameter.prior;
        let z = prior.standard(value)?;
        let z_se = 0.5 * (prior.standard(value + se)? - prior.standard(value - se)?);
        // of that of the two together, what the runs have
        let (apart, share) = match *prior {
            Prior::Uniform(lo, hi) => (((value - hi).max(0.0) - (lo - value).max(0.0)) / se, 1.0),
            // a spread is told by its logarithm
            _ if parameter.kind.is_spread() && prior.median() > 0.0 => {
                let se = se / value;
                let both = se.hypot(prior.sd()? / prior.median());
                ((value / prior.median()).ln() / both, se / both)
            }
            _ => (z / z_se.hypot(1.0), z_se / z_se.hypot(1.0)),
        };
        let found = RunsAlone {
            value,
            se,
            from_prior: as_normal(apart, freedom / share.powi(4)),
            from_posterior: (z - mean) / sd,
        };
        let distances = [found.from_prior, found.from_posterior];
        distances.iter().all(|x| x.is_finite()).then_some(found)
    }

    /// What the runs say of a parameter beside the value that a prior holds it at.
    pub(super) fn beside_held(&self, kind: ParameterKind, held: f64) -> Option<RunsAlone> {
        let Alone { number, freedom, .. } = self.of_kind(kind)?;
        let [value, se] = *number;
        let apart = match kind.is_spread() {
            // none at all is what stated errors are held against by a check of their own
            true if held == 0.0 => return None,
            true => (value / held).ln() * value / se,
            false => (value - held) / se,
        };
        let apart = as_normal(apart, *freedom);
        Some(RunsAlone {
            value,
            se,
            from_prior: apart,
            from_posterior: apart,
        })
    }

    /// `None` where the runs say nothing of a parameter.
    fn of_kind(&self, kind: ParameterKind) -> Option<&Alone> {
        self.of_each.iter().find(|own| own.kind == kind)
    }
}

/// The rebounds, dry or wet, that tell a parameter, less the parameters that these tell.
fn freedom(runs: &Runs, sampled: &[ModelParameter], kind: ParameterKind) -> f64 {
    let dry: usize = runs.dry.iter().map(|group| runs.measured(group.rebounds.clone())).sum();
    let wet: usize = runs.series.iter().map(|own| runs.measured(own.rebounds.clone())).sum();
    let is_of_dry = |kind: ParameterKind| kind.sphere().is_some();
    let told_by_dry = dry > 0 && (is_of_dry(kind) || kind == ParameterKind::SigmaDry);
    let rebounds = if told_by_dry { dry } else { wet };
    let told = |own: &&ModelParameter| !own.kind.is_spread() && is_of_dry(own.kind) == told_by_dry;
    rebounds.saturating_sub(sampled.iter().filter(told).count()).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of four degrees of freedom 2.8 standard errors are as improbable as 1.96 of a normal.
    #[test]
    fn few_runs_say_less() {
        assert!((as_normal(2.776_445, 4.0) - 1.959_964).abs() < 1e-5);
        assert!((as_normal(-3.0, 1e9) + 3.0).abs() < 1e-5);
        assert_eq!(as_normal(100.0, 1e9), 37.0);
    }

    /// The posterior of a normal prior and a normal likelihood, by their precisions; and the same on the logarithm.
    #[test]
    fn the_prior_is_taken_out_of_the_posterior() {
        const PRIOR: [f64; 2] = [2.0, 0.05];
        const RUNS: [f64; 2] = [1.8, 0.04];
        let precision = [PRIOR, RUNS].map(|[_, sd]| 1.0 / (sd * sd));
        let sd = (precision[0] + precision[1]).powf(-0.5);
        let mean = (PRIOR[0] * precision[0] + RUNS[0] * precision[1]) * sd * sd;
        let standard = [(mean - PRIOR[0]) / PRIOR[1], sd / PRIOR[1]];
        let alone = RunsAlone::of(&Prior::Normal(PRIOR[0], PRIOR[1]), standard[0], standard[1]).expect("narrower");
        assert!((alone.value - RUNS[0]).abs() < 1e-12 && (alone.se - RUNS[1]).abs() < 1e-12);
        assert!((alone.from_prior - (RUNS[0] - PRIOR[0]) / PRIOR[1].hypot(RUNS[1])).abs() < 1e-12);
        assert!((alone.from_posterior - (RUNS[0] - mean) / sd).abs() < 1e-12);
        let log = Prior::LogNormal(PRIOR[0].exp(), PRIOR[1]);
        let of_log = RunsAlone::of(&log, standard[0], standard[1]).expect("narrower");
        assert!((of_log.value.ln() - RUNS[0]).abs() < 1e-12);
        assert!((of_log.from_prior - alone.from_prior).abs() < 1e-12);
        assert_eq!(RunsAlone::of(&log, 0.0, 1.0), None);
    }
}
