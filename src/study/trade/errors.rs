//! Measures how far off a method is, and what the linear law gets wrong on the design.

use super::methods::TradedMethod;
use super::results::{LinearBias, MarginalError, Reference, Rung};
use super::timed::MethodAnswer;
use crate::findings::scaling;
use crate::scene::WetLaw;

pub(super) fn rung(path: TradedMethod, seconds: f64, answer: MethodAnswer, reference: &Reference) -> Rung {
    let errors: Vec<Option<MarginalError>> = answer
        .marginals
        .iter()
        .zip(&reference.parameters)
        .map(|(found, truth)| {
            let (found, truth) = ((*found)?, truth.marginal);
            Some(MarginalError {
                mean: (found.mean - truth.mean) / truth.sd,
                sd: found.sd / truth.sd - 1.0,
                q05: (found.q05 - truth.q05) / truth.sd,
                q95: (found.q95 - truth.q95) / truth.sd,
            })
        })
        .collect();
    let worst = |of: fn(&MarginalError) -> f64| errors.iter().flatten().map(|miss| of(miss).abs()).reduce(f64::max);
    Rung {
        name: path.name(),
        seconds,
        nodes: answer.nodes,
        worst_mean: worst(|miss| miss.mean),
        worst_sd: worst(|miss| miss.sd),
        vouched: answer.vouched,
        effective: answer.effective,
        effective_per_second: answer.effective.map(|effective| effective / seconds),
        dominated_by: None,
        failed: answer.failed,
        errors,
    }
}

pub(super) fn linear_bias(scaling: &scaling::Scaling) -> Option<LinearBias> {
    let bias = scaling.bias.filter(|_| scaling.law == WetLaw::Linear)?;
    Some(LinearBias {
        particle: scaling.particle.clone(),
        film_ratio: scaling.film_ratio,
        e_inf: bias.e_inf,
        e_inf_se: scaling.e_inf.scale().map(|se| bias.e_inf / se),
        st_c: bias.st_c,
        st_c_se: scaling.st_c.scale().map(|se| bias.st_c / se),
    })
}
