//! Computes the log posterior density on the whole line, with its slopes, in one pass.

use super::likelihood::{Likelihood, OutsideDomain};
use super::parameters::ModelParameters;
use super::transforms::Transform;

/// A log density over the whole of a space, up to a constant.
pub trait LogDensity: Sync {
    /// Dimensions of the space.
    fn dimension(&self) -> usize;

    /// Log density at a point; its slopes, as many, are overwritten.
    ///
    /// Fails where there is none; the slopes then mean nothing.
    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain>;
}

/// The posterior of a scene: priors times likelihood, on unbounded parameters.
#[derive(Debug, Clone)]
pub struct PosteriorDensity {
    parameters: ModelParameters,
    transforms: Vec<Transform>,
    likelihood: Likelihood,
}

impl PosteriorDensity {
    /// The posterior of these parameters under a likelihood of the same scene.
    pub fn new(parameters: ModelParameters, likelihood: Likelihood) -> PosteriorDensity {
        let transforms = parameters.sampled.iter().map(|p| Transform::of(p.bounds)).collect();
        PosteriorDensity {
            parameters,
            transforms,
            likelihood,
        }
    }

    /// The parameters.
    pub fn parameters(&self) -> &ModelParameters {
        &self.parameters
    }

    /// The likelihood.
    pub fn likelihood(&self) -> &Likelihood {
        &self.likelihood
    }

    /// The parameters at a point of the unbounded space.
    pub fn draw_at(&self, point: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(point).map(|(t, u)| t.at(*u).value).collect()
    }

    /// The point of the unbounded space where the parameters have these values, or are near them.
    pub fn point_at(&self, draw: &[f64]) -> Vec<f64> {
        self.transforms.iter().zip(draw).map(|(t, x)| t.inverse(*x)).collect()
    }
}

impl LogDensity for PosteriorDensity {
    fn dimension(&self) -> usize {
        self.transforms.len()
    }

    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        /// more parameters than any scene has without a heap of particles
        const STACK: usize = 32;
        let length = self.parameters.template.len();
        let mut stack = [[0.0; STACK]; 2];
        let mut heap: [Vec<f64>; 2];
        let [full, full_slopes] = if length <= STACK {
            stack.each_mut().map(|part| &mut part[..length])
        } else {
            heap = [vec![0.0; length], vec![0.0; length]];
            heap.each_mut().map(Vec::as_mut_slice)
        };
        full.copy_from_slice(&self.parameters.template);
        for ((parameter, transform), u) in self.parameters.sampled.iter().zip(&self.transforms).zip(point) {
            full[parameter.kind.slot()] = transform.at(*u).value;
        }
        let mut value = self.likelihood.ln_density(full, full_slopes)?;
        let each = self.parameters.sampled.iter().zip(&self.transforms);
        for ((parameter, transform), (u, slope)) in each.zip(point.iter().zip(slopes.iter_mut())) {
            let mapped = transform.at(*u);
            let (ln_prior, prior_slope) = parameter.prior.ln_density(mapped.value).ok_or(OutsideDomain)?;
            value += ln_prior + mapped.ln_jacobian;
            let of_value = full_slopes[parameter.kind.slot()] + prior_slope;
            *slope = of_value * mapped.slope + mapped.ln_jacobian_slope;
        }
        let finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        if finite {
            Ok(value)
        } else {
            Err(OutsideDomain)
        }
    }
}

#[cfg(test)]
mod tests;
