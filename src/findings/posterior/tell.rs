//! Tells each parameter, and what follows from it, in numbers, with how the draws were made.

use rayon::prelude::*;

use super::derived::Derived;
use super::predictive::Predictive;
use super::sampling::Asked;
use super::written::{Accuracy, Compression, LeftOut, PosteriorFindings, PriorTold, Quantity, Tried};
use crate::findings::predict::Basis;
use crate::inference::diagnostics::energy::e_bfmi;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::nuts::{divergences, Effort, LARGEST_DEPTH};
use crate::inference::sampling::Sampled;
use crate::model::parameters::Parameter;
use crate::physics::form::Term;
use crate::physics::DrySpeed;

/// What the draws say, and how they were made.
pub(super) fn tell(
    asked: Asked,
    effort: Effort,
    rows: usize,
    sampled: &Sampled,
    derived: &[Derived],
    (predictive, basis): (Predictive, Basis),
) -> PosteriorFindings {
    let parameters = &sampled.parameters;
    let told = parameters.sampled.par_iter().zip(&sampled.values);
    let kept = sampled.chains.iter();
    PosteriorFindings {
        parameters: told
            .map(|(parameter, values)| of_parameter(parameter, values, sampled.mcse_factor))
            .collect(),
        derived: derived
            .par_iter()
            .map(|derived| Quantity {
                mcse_q05: None,
                mcse_q95: None,
                ..quantity(&derived.name, &derived.values, sampled.mcse_factor)
            })
            .collect(),
        left_out: parameters
            .left_out
            .iter()
            .map(|left| LeftOut {
                name: left.name.clone(),
                value: left.value,
                reason: left.reason.clone(),
            })
            .collect(),
        correlation: correlation(&sampled.values),
        chains: sampled.chains.len(),
        warmup: if sampled.method.is_nuts() { effort.warmup } else { 0 },
        draws: sampled.chains.first().map_or(0, |chain| chain.ln_density.len()),
        target_accept: sampled.target_accept,
        divergences: divergences(&sampled.chains),
        trajectories_cut: kept
            .clone()
            .flat_map(|chain| &chain.tree_depth)
            .filter(|depth| **depth >= LARGEST_DEPTH)
            .count(),
        e_bfmi: kept
            .filter(|chain| !chain.energy.is_empty())
            .map(|chain| e_bfmi(&chain.energy))
            .collect(),
        method: sampled.method,
        khat: sampled.khat.filter(|khat| khat.is_finite()),
        accuracy: sampled.accuracy.as_ref().map(|accuracy| Accuracy {
            asked: accuracy.requested,
            vouched: Some(accuracy.vouched).filter(|error| error.is_finite()),
            tried: accuracy
                .tried
                .iter()
                .map(|(method, why)| Tried {
                    method: *method,
                    why: why.clone(),
                })
                .collect(),
        }),
        terms: asked.form.terms().into_iter().map(Term::name).collect(),
        inertia: asked.form.inertia.name(),
        viscous: asked.form.viscous.name(),
        dry_speed_m_s: match asked.form.dry_speed {
            DrySpeed::Reference(v) => Some(v),
            DrySpeed::Impact => None,
        },
        compression: sampled
            .compression
            .zip(sampled.checked_error)
            .map(|(made, checked)| Compression {
                nodes: made.nodes,
                rows,
                rows_exact: made.rows_exact,
                bound: sampled.bound.unwrap_or(f64::INFINITY),
                max_log_density_error: checked,
            }),
        predictive,
        basis,
    }
}

fn of_parameter(parameter: &Parameter, values: &[Vec<f64>], mcse_factor: f64) -> Quantity {
    let told = quantity(&parameter.name, values, mcse_factor);
    let sd = parameter.prior.sd();
    let prior = PriorTold {
        symbol: parameter.kind.symbol(),
        unit: parameter.kind.unit(),
        lower: parameter.bounds.0,
        upper: Some(parameter.bounds.1).filter(|upper| upper.is_finite()),
        density: parameter.prior.text(),
        median: parameter.prior.median(),
        sd,
        source: parameter.source,
        sd_ratio: told.sd.zip(sd).map(|(posterior, prior)| posterior / prior),
    };
    Quantity {
        prior: Some(prior),
        ..told
    }
}

/// `mcse_factor` is that of [`Sampled`].
fn quantity(name: &str, values: &[Vec<f64>], mcse_factor: f64) -> Quantity {
    let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let missing = values.iter().flatten().filter(|value| !value.is_finite()).count();
    let all: usize = values.iter().map(Vec::len).sum();
    let found = summarise(&chains);
    let why_none = match found.why_none {
        Some(_) if missing > 0 => Some(format!("{missing} of {all} draws leave no energy at infinite speed")),
        why => why.map(|why| why.to_string()),
    };
    let larger = |mcse: f64| mcse_factor * mcse;
    let fewer = |effective: f64| effective / (mcse_factor * mcse_factor);
    Quantity {
        name: name.to_owned(),
        mean: found.mean,
        sd: found.sd,
        median: found.median,
        q05: found.q05,
        q95: found.q95,
        rhat: found.rhat,
        ess_bulk: found.ess_bulk.map(fewer),
        ess_tail: found.ess_tail.map(fewer),
        mcse_mean: found.mcse_mean.map(larger),
        mcse_sd: found.mcse_sd.map(larger),
        mcse_q05: found.mcse_q05.map(larger),
        mcse_q95: found.mcse_q95.map(larger),
        prior: None,
        why_none,
    }
}

fn correlation(values: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let centred: Vec<Vec<f64>> = values
        .iter()
        .map(|chains| {
            let all: Vec<f64> = chains.concat();
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let norm = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>().sqrt();
            all.iter().map(|x| (x - mean) / norm).collect()
        })
        .collect();
    let pair = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum();
    centred
        .iter()
        .map(|a| centred.iter().map(|b| pair(a, b)).collect())
        .collect()
}
