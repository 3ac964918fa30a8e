//! Computes the log posterior density on the whole line, with its slopes, in one pass.

use super::likelihood::{Likelihood, OutsideDomain};
use super::parameters::{ModelParameters, ParameterKind};
use super::series_offsets::{coordinates_about, OffsetCoordinate};
use super::transforms::Transform;

/// A log density over the whole of a space, up to a constant.
pub trait LogDensity: Sync {
    /// Dimensions of the space.
    fn dimension(&self) -> usize;

    /// Log density at a point; its slopes, as many, are overwritten.
    ///
    /// Fails where there is none; the slopes then mean nothing.
    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain>;

    /// Whether a point lies on the side of a mode, where several points stand for the same parameters.
    fn is_beside(&self, _mode: &[f64], _point: &[f64]) -> bool {
        true
    }
}

/// The posterior of a scene: priors times likelihood, on unbounded parameters.
#[derive(Debug, Clone)]
pub struct PosteriorDensity {
    parameters: ModelParameters,
    transforms: Vec<Transform>,
    /// of the offsets of the series, which follow the sampled parameters
    offsets: Vec<OffsetCoordinate>,
    likelihood: Likelihood,
}

impl PosteriorDensity {
    /// The posterior of these parameters under a likelihood of the same scene.
    pub fn new(parameters: ModelParameters, likelihood: Likelihood) -> PosteriorDensity {
        let both = likelihood.has_noise_on_energy();
        let transform = |parameter| Transform::of_parameter(parameter, both);
        let transforms = parameters.sampled.iter().map(transform).collect();
        PosteriorDensity {
            offsets: vec![OffsetCoordinate::UNTOLD; parameters.series_offsets.len()],
            parameters,
            transforms,
            likelihood,
        }
    }

    /// The same with the offsets of series on coordinates that are round about a full vector of parameters.
    pub fn with_offsets_about(mut self, full: &[f64]) -> PosteriorDensity {
        if !self.offsets.is_empty() {
            self.offsets = coordinates_about(&self.parameters, &self.likelihood, full);
        }
        self
    }

    /// The parameters.
    pub fn parameters(&self) -> &ModelParameters {
        &self.parameters
    }

    /// The parameters, and the offsets after them, at a point of the unbounded space.
    pub fn draw_at(&self, point: &[f64]) -> Vec<f64> {
        let each = self.transforms.iter().zip(point);
        let mut draw: Vec<f64> = each.map(|(t, u)| t.at(*u).value).collect();
        let sigma = self.sigma_series(&draw);
        let rest = point.get(draw.len()..).unwrap_or_default();
        draw.extend(self.offsets.iter().zip(rest).map(|(own, u)| own.at(*u, sigma).value));
        draw
    }

    /// The point of the unbounded space where the parameters have these values, or are near them; offsets that the draw
    /// lacks are where the runs want them.
    pub fn point_at(&self, draw: &[f64]) -> Vec<f64> {
        let mut point: Vec<f64> = self.transforms.iter().zip(draw).map(|(t, x)| t.inverse(*x)).collect();
        let sigma = self.sigma_series(draw);
        let given = draw.get(point.len()..).unwrap_or_default().iter().copied().map(Some);
        let each = self.offsets.iter().zip(given.chain(std::iter::repeat(None)));
        point.extend(each.map(|(own, offset)| offset.map_or(0.0, |offset| own.inverse(offset, sigma))));
        point
    }

    /// σ_series of a draw.
    fn sigma_series(&self, draw: &[f64]) -> f64 {
        let kind = ParameterKind::SigmaSeries;
        let place = self.parameters.place(kind);
        place.map_or(self.parameters.template[kind.slot()], |place| draw[place])
    }

    /// Log prior density of the offsets at a point, with slopes; that in σ_series goes to those of the full vector.
    fn add_offsets(&self, point: &[f64], full: &[f64], full_slopes: &mut [f64], slopes: &mut [f64]) -> f64 {
        let of_sigma = ParameterKind::SigmaSeries.slot();
        let first = self.parameters.first_offset();
        let mut value = 0.0;
        for (place, own) in self.offsets.iter().enumerate() {
            let at = self.transforms.len() + place;
            let mapped = own.at(point[at], full[of_sigma]);
            let kept = full_slopes[first + place];
            value += mapped.ln_prior;
            slopes[at] = kept * mapped.slope + mapped.ln_prior_slope;
            full_slopes[of_sigma] += kept * mapped.slope_sigma + mapped.ln_prior_slope_sigma;
        }
        value
    }
}

impl LogDensity for PosteriorDensity {
    fn dimension(&self) -> usize {
        self.parameters.dimension()
    }

    fn is_beside(&self, mode: &[f64], point: &[f64]) -> bool {
        let mut each = self.transforms.iter().zip(mode.iter().zip(point));
        each.all(|(transform, (mode, u))| *transform != Transform::Either || (*mode < 0.0) == (*u < 0.0))
    }

    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        let full = self.parameters.full(&self.draw_at(point));
        let mut full_slopes = vec![0.0; full.len()];
        let mut value = self.likelihood.ln_density(&full, &mut full_slopes)?;
        value += self.add_offsets(point, &full, &mut full_slopes, slopes);
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
