//! Computes the log density of a prior, its slope, its quantiles, its spread, and draws from it.
//!
//! A prior truncated by a parameter's bounds keeps the density of the whole: a constant factor that no posterior, and no
//! comparison under the same bounds, depends on.

use rand::Rng;
use rand_distr::{Distribution, Gamma, StandardNormal, StudentT};
use statrs::function::gamma::ln_gamma;

use crate::distributions::{gamma_quantile, normal_quantile, student_t_peak, student_t_quantile, LN_ROOT_TWO_PI};

/// A prior density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// median, sd of the log
    LogNormal(f64, f64),
    /// scale
    HalfNormal(f64),
    /// mean, sd
    Normal(f64, f64),
    /// shape, rate
    Gamma(f64, f64),
    /// lower, upper end
    Uniform(f64, f64),
    /// degrees of freedom, location, scale
    StudentT(f64, f64, f64),
    /// held at a value
    Fixed(f64),
}

impl Prior {
    /// Log density and its slope at x; `None` where the density is zero or not finite.
    ///
    /// A parameter held at a value has no density: `Fixed` is 0 with slope 0 everywhere.
    pub fn ln_density(&self, x: f64) -> Option<(f64, f64)> {
        let (value, slope) = match *self {
            Prior::LogNormal(median, sd) if x > 0.0 => {
                let z = (x / median).ln() / sd;
                (-0.5 * z * z - LN_ROOT_TWO_PI - sd.ln() - x.ln(), -(1.0 + z / sd) / x)
            }
            Prior::HalfNormal(scale) if x >= 0.0 => {
                let z = x / scale;
                let twice = std::f64::consts::LN_2;
                (twice - 0.5 * z * z - LN_ROOT_TWO_PI - scale.ln(), -z / scale)
            }
            Prior::Normal(mean, sd) => {
                let z = (x - mean) / sd;
                (-0.5 * z * z - LN_ROOT_TWO_PI - sd.ln(), -z / sd)
            }
            Prior::Gamma(shape, rate) if x > 0.0 => (
                shape * rate.ln() - ln_gamma(shape) + (shape - 1.0) * x.ln() - rate * x,
                (shape - 1.0) / x - rate,
            ),
            Prior::Uniform(lo, hi) if (lo..=hi).contains(&x) => (-(hi - lo).ln(), 0.0),
            Prior::StudentT(df, loc, scale) => {
                let z = (x - loc) / scale;
                (
                    student_t_peak(df) - scale.ln() - 0.5 * (df + 1.0) * (z * z / df).ln_1p(),
                    -(df + 1.0) * z / (df + z * z) / scale,
                )
            }
            Prior::Fixed(_) => (0.0, 0.0),
            Prior::LogNormal(..) | Prior::HalfNormal(_) | Prior::Gamma(..) | Prior::Uniform(..) => return None,
        };
        (value.is_finite() && slope.is_finite()).then_some((value, slope))
    }

    /// Standard deviation; `None` for a Student-t with two degrees of freedom or fewer, and beyond the largest number.
    pub fn sd(&self) -> Option<f64> {
        let sd = match *self {
            Prior::LogNormal(median, sd) => {
                let variance = sd * sd;
                Some(median * (0.5 * variance).exp() * variance.exp_m1().sqrt())
            }
            Prior::HalfNormal(scale) => Some(scale * (1.0 - 2.0 / std::f64::consts::PI).sqrt()),
            Prior::Normal(_, sd) => Some(sd),
            Prior::Gamma(shape, rate) => Some(shape.sqrt() / rate),
            Prior::Uniform(lo, hi) => Some((hi - lo) / 12f64.sqrt()),
            Prior::StudentT(df, _, scale) => (df > 2.0).then(|| scale * (df / (df - 2.0)).sqrt()),
            Prior::Fixed(_) => Some(0.0),
        };
        sd.filter(|sd| sd.is_finite())
    }

    /// Median.
    pub fn median(&self) -> f64 {
        match *self {
            Prior::LogNormal(median, _) => median,
            // quartile of the normal
            Prior::HalfNormal(scale) => scale * 0.674_489_750_196_081_7,
            Prior::Normal(mean, _) => mean,
            // fails only for a shape or rate that no scene can hold
            Prior::Gamma(shape, rate) => gamma_quantile(0.5, shape).map_or(shape / rate, |median| median / rate),
            Prior::Uniform(lo, hi) => 0.5 * (lo + hi),
            Prior::StudentT(_, loc, _) => loc,
            Prior::Fixed(value) => value,
        }
    }

    /// Where x lies on the prior's own scale, in its sds from its centre: the logarithm for a lognormal; for a half-normal in
    /// scales from 0; for a Student-t without an sd in half-widths of its middle 68 %. `None` for a value that is held.
    pub fn standard(&self, x: f64) -> Option<f64> {
        match *self {
            Prior::LogNormal(median, sd) => (x > 0.0).then(|| (x / median).ln() / sd),
            Prior::HalfNormal(scale) => Some(x / scale),
            Prior::Fixed(_) => None,
            _ => self.half_width().map(|width| (x - self.median()) / width),
        }
    }

    /// The value that lies so many sds from the centre, on the prior's own scale: the inverse of [`Prior::standard`].
    pub fn at_standard(&self, z: f64) -> Option<f64> {
        match *self {
            Prior::LogNormal(median, sd) => Some(median * (sd * z).exp()),
            Prior::HalfNormal(scale) => Some(scale * z),
            Prior::Fixed(_) => None,
            _ => self.half_width().map(|width| self.median() + width * z),
        }
    }

    /// The sd, or the half-width of the middle 68 % where there is none.
    fn half_width(&self) -> Option<f64> {
        const ONE_SD: f64 = 0.841_344_746_068_542_9;
        self.sd().or_else(|| Some(self.quantile(ONE_SD)? - self.median()))
    }

    /// Quantile at a probability inside (0, 1); `None` where no number is it.
    pub fn quantile(&self, probability: f64) -> Option<f64> {
        let z = normal_quantile(probability);
        let x = match *self {
            Prior::LogNormal(median, sd) => median * (sd * z).exp(),
            Prior::HalfNormal(scale) => scale * normal_quantile(0.5 + 0.5 * probability),
            Prior::Normal(mean, sd) => mean + sd * z,
            Prior::Gamma(shape, rate) => gamma_quantile(probability, shape)? / rate,
            Prior::Uniform(lo, hi) => lo + probability * (hi - lo),
            Prior::StudentT(df, loc, scale) => loc + scale * student_t_quantile(probability, df)?,
            Prior::Fixed(value) => value,
        };
        x.is_finite().then_some(x)
    }

    /// One draw.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
        match *self {
            Prior::LogNormal(median, sd) => median * (sd * normal()).exp(),
            Prior::HalfNormal(scale) => scale * normal().abs(),
            Prior::Normal(mean, sd) => mean + sd * normal(),
            // the scene's reader lets no shape, rate or df at or below zero through
            Prior::Gamma(shape, rate) => Gamma::new(shape, 1.0 / rate).map_or(f64::NAN, |gamma| gamma.sample(rng)),
            Prior::Uniform(lo, hi) => {
                use rand::RngExt;
                lo + (hi - lo) * rng.random::<f64>()
            }
            Prior::StudentT(df, loc, scale) => {
                StudentT::new(df).map_or(f64::NAN, |student| loc + scale * student.sample(rng))
            }
            Prior::Fixed(value) => value,
        }
    }

    /// Its family and its numbers.
    pub fn text(&self) -> String {
        let (family, numbers) = self.words();
        format!("{family} {numbers}")
    }

    /// As a scene gives it.
    pub fn written(&self) -> String {
        let (family, numbers) = self.words();
        format!("{{ {family} = {numbers} }}")
    }

    fn words(&self) -> (&'static str, String) {
        match *self {
            Prior::LogNormal(median, sd) => ("lognormal", format!("[{median}, {sd}]")),
            Prior::HalfNormal(scale) => ("half_normal", scale.to_string()),
            Prior::Normal(mean, sd) => ("normal", format!("[{mean}, {sd}]")),
            Prior::Gamma(shape, rate) => ("gamma", format!("[{shape}, {rate}]")),
            Prior::Uniform(lo, hi) => ("uniform", format!("[{lo}, {hi}]")),
            Prior::StudentT(df, loc, scale) => ("student_t", format!("[{df}, {loc}, {scale}]")),
            Prior::Fixed(value) => ("fixed", value.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAMILIES: [(Prior, f64); 6] = [
        (Prior::LogNormal(0.15, 0.5), 0.213),
        (Prior::HalfNormal(0.1), 0.137),
        (Prior::Normal(-1.3, 0.7), 0.41),
        (Prior::Gamma(2.3, 0.4), 3.7),
        (Prior::Uniform(-0.2, 1.9), 0.77),
        (Prior::StudentT(3.7, 0.6, 2.1), -1.9),
    ];

    #[test]
    fn sds_from_the_centre_are_counted_on_the_scale_of_the_prior() {
        let of = |prior: Prior, x: f64| prior.standard(x).expect("a prior with an sd");
        assert!((of(Prior::LogNormal(1.0, 0.5), 6.0) - 6f64.ln() / 0.5).abs() < 1e-12);
        assert!((of(Prior::HalfNormal(0.1), 0.015) - 0.15).abs() < 1e-12);
        assert!((of(Prior::Normal(1.95, 0.02), 1.89) + 3.0).abs() < 1e-9);
        assert_eq!(Prior::Fixed(2.0).standard(2.0), None);
        // a Cauchy prior has half of its mass within one scale, and 68 % within 1.837
        assert!((of(Prior::StudentT(1.0, 3.0, 0.1), 3.0 + 0.1837) - 1.0).abs() < 1e-3);
        for (prior, x) in FAMILIES {
            let back = prior.at_standard(of(prior, x)).expect("the same prior");
            assert!((back - x).abs() < 1e-12 * x.abs().max(1.0), "{prior:?}");
        }
    }

    #[test]
    fn outside_the_support_there_is_no_density() {
        for (prior, x) in [
            (Prior::LogNormal(0.15, 0.5), -0.1),
            (Prior::HalfNormal(0.1), -0.1),
            (Prior::Gamma(2.3, 0.4), 0.0),
            (Prior::Uniform(0.0, 1.0), 1.5),
            (Prior::Normal(0.0, 1.0), f64::NAN),
        ] {
            assert_eq!(prior.ln_density(x), None, "{prior:?}");
        }
    }

    /// Draws have the median and the sd each prior says it has; a family with its two numbers swapped would not.
    #[test]
    fn draws_have_the_medians_and_spreads_of_their_families() {
        const DRAWS: usize = 40_000;
        let mut rng = crate::seed::stream(1, "draws_have_the_medians_and_spreads_of_their_families", 0);
        let below = |prior: Prior, median: f64, rng: &mut rand::rngs::ChaCha8Rng| {
            (0..DRAWS).filter(|_| prior.draw(rng) < median).count() as f64
        };
        let z = |count: f64| (count - 0.5 * DRAWS as f64) / (0.25 * DRAWS as f64).sqrt();
        for (prior, _) in FAMILIES {
            let count = below(prior, prior.median(), &mut rng);
            assert!(z(count).abs() < 4.0, "{prior:?} {count}");
            let draws: Vec<f64> = (0..DRAWS).map(|_| prior.draw(&mut rng)).collect();
            let mean = draws.iter().sum::<f64>() / DRAWS as f64;
            let sd = (draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / DRAWS as f64).sqrt();
            let expected = prior.sd().expect("finite");
            assert!((sd / expected - 1.0).abs() < 0.15, "{prior:?} {sd} {expected}");
        }
        let swapped = below(Prior::Gamma(0.4, 2.3), FAMILIES[3].0.median(), &mut rng);
        assert!(z(swapped).abs() > 50.0);
    }
}
