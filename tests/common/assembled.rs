//! Puts a posterior together from its parts, so that a test can leave one of them out.

use wetcor::model::likelihood::{Likelihood, OutsideDomain};
use wetcor::model::parameters::{ModelParameters, ParameterKind};
use wetcor::model::posterior::LogDensity;
use wetcor::model::transforms::Transform;
use wetcor::runs::Runs;
use wetcor::scene::Scene;

/// A posterior with one thing wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    Nothing,
    LogJacobianForgotten,
    BoundOnKForgotten,
    SigmaSquaredForSigma,
    PriorForgotten(ParameterKind),
    TwoLForFourL,
    StuckRunsDropped,
}

/// The posterior put together from its parts, so that one of them can be wrong.
pub struct Assembled {
    pub parameters: ModelParameters,
    transforms: Vec<Transform>,
    pub likelihood: Likelihood,
    fault: Fault,
}

impl Assembled {
    pub fn new(scene: &Scene, all: &Runs, fault: Fault) -> Assembled {
        let form = scene.model.form();
        let parameters = ModelParameters::of(scene, all, form).expect("priors with room");
        let mut kept = all.clone();
        if fault == Fault::StuckRunsDropped {
            let series = kept.series.iter_mut().map(|series| &mut series.stuck);
            let all = series.chain(kept.dry.iter_mut().map(|dry| &mut dry.stuck));
            all.for_each(|stuck| stuck.end = stuck.start);
        }
        let transforms = parameters.sampled.iter().map(|p| match p.kind {
            ParameterKind::DryK(_) if fault == Fault::BoundOnKForgotten => Transform::Above(0.0),
            _ => Transform::of(p.bounds),
        });
        Assembled {
            transforms: transforms.collect(),
            likelihood: Likelihood::new(scene, &kept, form),
            parameters,
            fault,
        }
    }

    pub fn draw_at(&self, point: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(point).map(|(t, u)| t.at(*u).value).collect()
    }

    pub fn start(&self) -> Vec<f64> {
        let medians = self.parameters.sampled.iter().map(|p| p.prior.median());
        self.transforms.iter().zip(medians).map(|(t, x)| t.inverse(x)).collect()
    }
}

impl LogDensity for Assembled {
    fn dimension(&self) -> usize {
        self.transforms.len()
    }
    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        let mut full = self.parameters.full(&self.draw_at(point));
        let (mut l_factor, mut sigma_factor) = (1.0, 1.0);
        if self.fault == Fault::TwoLForFourL {
            l_factor = 0.5;
            full[ParameterKind::LUBRICATION_LOG.slot()] *= l_factor;
        }
        if self.fault == Fault::SigmaSquaredForSigma {
            let sigma = &mut full[ParameterKind::SigmaWet.slot()];
            sigma_factor = 2.0 * *sigma;
            *sigma *= *sigma;
        }
        let mut full_slopes = vec![0.0; full.len()];
        let mut value = self.likelihood.ln_density(&full, &mut full_slopes)?;
        let sampled = self.parameters.sampled.iter().zip(&self.transforms);
        for (((parameter, transform), u), slope) in sampled.zip(point).zip(slopes.iter_mut()) {
            let mapped = transform.at(*u);
            let mut of_value = full_slopes[parameter.kind.slot()];
            match parameter.kind {
                ParameterKind::LUBRICATION_LOG => of_value *= l_factor,
                ParameterKind::SigmaWet => of_value *= sigma_factor,
                _ => {}
            }
            if self.fault != Fault::PriorForgotten(parameter.kind) {
                let (ln_prior, prior_slope) = parameter.prior.ln_density(mapped.value).ok_or(OutsideDomain)?;
                value += ln_prior;
                of_value += prior_slope;
            }
            *slope = of_value * mapped.slope;
            if self.fault != Fault::LogJacobianForgotten {
                value += mapped.ln_jacobian;
                *slope += mapped.ln_jacobian_slope;
            }
        }
        let is_finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        is_finite.then_some(value).ok_or(OutsideDomain)
    }
}
