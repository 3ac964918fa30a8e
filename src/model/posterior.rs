//! Computes the log posterior density on the whole line, with its slopes, in one pass.

use super::likelihood::{Likelihood, OutsideDomain};
use super::parameters::{ModelParameters, ParameterKind};
use super::series_offsets::{coordinates_about, OffsetCoordinate};
use super::transforms::{slopes_in_total_and_angle, spreads_at, total_and_angle, Mapped, Transform};
use crate::scene::Prior;

/// The spreads of wet runs, where noise acts on the energy kept, too.
const SPREADS: [ParameterKind; 2] = [ParameterKind::SigmaWet, ParameterKind::SigmaEnergy];

/// Replaces two numbers by what a function makes of them.
fn replace(numbers: &mut [f64], places: [usize; 2], by: impl Fn([f64; 2]) -> [f64; 2]) {
    let made = by(places.map(|place| numbers[place]));
    (numbers[places[0]], numbers[places[1]]) = (made[0], made[1]);
}

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
    /// places among the sampled parameters of σ and σ_r of wet runs, where the total spread and the angle stand for them
    spreads: Option<[usize; 2]>,
    /// of the offsets of the series, which follow the sampled parameters
    offsets: Vec<OffsetCoordinate>,
    likelihood: Likelihood,
}

impl PosteriorDensity {
    /// The posterior of these parameters under a likelihood of the same scene.
    pub fn new(parameters: ModelParameters, likelihood: Likelihood) -> PosteriorDensity {
        let mut transforms: Vec<Transform> = parameters.sampled.iter().map(|p| Transform::of(p.bounds)).collect();
        let place = |kind| {
            parameters
                .place(kind)
                .filter(|at| transforms[*at] == Transform::Above(0.0))
        };
        let spreads = SPREADS.map(place);
        let spreads = spreads[0].zip(spreads[1]).map(<[usize; 2]>::from);
        if let Some([_, angle]) = spreads {
            transforms[angle] = Transform::RightAngle;
        }
        // the runs of few series do not tell their spread from none
        if let Some(at) = parameters.place(ParameterKind::SigmaSeries) {
            if let Prior::HalfNormal(scale) = parameters.sampled[at].prior {
                transforms[at] = Transform::FromNought(scale);
            }
        }
        PosteriorDensity {
            spreads,
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
        self.draw_of(&self.mapped(point), point)
    }

    /// The parameters at a point before spreads stand for their total and angle.
    fn mapped(&self, point: &[f64]) -> Vec<Mapped> {
        self.transforms.iter().zip(point).map(|(t, u)| t.at(*u)).collect()
    }

    /// [`PosteriorDensity::draw_at`] a point that was mapped.
    fn draw_of(&self, mapped: &[Mapped], point: &[f64]) -> Vec<f64> {
        let mut draw: Vec<f64> = mapped.iter().map(|own| own.value).collect();
        if let Some(places) = self.spreads {
            replace(&mut draw, places, spreads_at);
        }
        let sigma = self.sigma_series(&draw);
        let rest = point.get(draw.len()..).unwrap_or_default();
        draw.extend(self.offsets.iter().zip(rest).map(|(own, u)| own.at(*u, sigma).value));
        draw
    }

    /// The point of the unbounded space where the parameters have these values, or are near them; offsets that the draw
    /// lacks are where the runs want them.
    pub fn point_at(&self, draw: &[f64]) -> Vec<f64> {
        let mut bounded = draw.to_vec();
        if let Some(places) = self.spreads {
            replace(&mut bounded, places, total_and_angle);
        }
        let each = self.transforms.iter().zip(&bounded);
        let mut point: Vec<f64> = each.map(|(t, x)| t.inverse(*x)).collect();
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

    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        let mapped = self.mapped(point);
        let full = self.parameters.full(&self.draw_of(&mapped, point));
        let mut full_slopes = vec![0.0; full.len()];
        let slots = self.spreads.map(|_| SPREADS.map(ParameterKind::slot));
        let mut value = self.likelihood.ln_density(&full, &mut full_slopes)?;
        value += self.add_offsets(point, &full, &mut full_slopes, slopes);
        for (parameter, mapped) in self.parameters.sampled.iter().zip(&mapped) {
            let slot = parameter.kind.slot();
            let (ln_prior, prior_slope) = parameter.prior.ln_density(full[slot]).ok_or(OutsideDomain)?;
            value += ln_prior + mapped.ln_jacobian;
            full_slopes[slot] += prior_slope;
        }
        if let Some(slots) = slots {
            let spreads = slots.map(|slot| full[slot]);
            let [total, _] = total_and_angle(spreads);
            value += total.ln();
            replace(&mut full_slopes, slots, |slopes| {
                let [of_total, of_angle] = slopes_in_total_and_angle(spreads, slopes);
                [of_total + 1.0 / total, of_angle]
            });
        }
        let each = self.parameters.sampled.iter().zip(&mapped);
        for ((parameter, mapped), slope) in each.zip(slopes.iter_mut()) {
            *slope = full_slopes[parameter.kind.slot()] * mapped.slope + mapped.ln_jacobian_slope;
        }
        let finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        finite.then_some(value).ok_or(OutsideDomain)
    }
}

#[cfg(test)]
mod tests;
