//! Sums the weighted squares of a law over its runs, anywhere about its minimum, by a number that quantities are functions of.

use nalgebra::DMatrix;

use super::effective_variance::ErrorWeights;
use super::profile::{ProblemProfile, Region};
use super::regression::Regression;
use super::sums::{add_square, Sums};
use crate::physics::jet::{Jet, Number};

/// A number of a law's two parameters: every quantity of a law is a function of one of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Held {
    /// the first parameter
    First,
    /// the second
    Second,
    /// the second over the first
    Ratio,
    /// their product
    Product,
}

impl Held {
    /// Every one.
    pub const ALL: [Held; 4] = [Held::First, Held::Second, Held::Ratio, Held::Product];

    /// Its value.
    pub fn of<T: Number>(self, [a, b]: [T; 2]) -> T {
        match self {
            Held::First => a,
            Held::Second => b,
            Held::Ratio => b / a,
            Held::Product => a * b,
        }
    }

    /// The place of the parameter that is left free.
    pub fn free(self) -> usize {
        usize::from(self == Held::First)
    }

    /// The parameters by its value and the free one.
    pub fn at<T: Number>(self, [value, free]: [T; 2]) -> [T; 2] {
        match self {
            Held::First => [value, free],
            Held::Second => [free, value],
            Held::Ratio => [free, value * free],
            Held::Product => [free, value / free],
        }
    }
}

/// The profile of a number about a fit of a law, of which `region` is that of the parameters; the number is its first
/// parameter, the free one its second. `None` of a law of one parameter.
///
/// The weighted squares go on beyond the domain of the law ([`crate::inference::law::Law::continued`]): a fit never leaves
/// that, a profile may. To the information is added what the law's bend has of the squares' curvature where it adds to it,
/// as for a joint fit.
pub fn profile<'a>(
    regression: &'a Regression<'a>,
    errors: Option<&ErrorWeights>,
    region: &Region,
    held: Held,
) -> Option<ProblemProfile<'a>> {
    let fitted = <[f64; 2]>::try_from(region.minimum.as_slice()).ok()?;
    let variables = |point: [f64; 2]| [0, 1].map(|place| Jet::<2>::variable(point[place], place));
    let number = held.of(variables(fitted));
    let free = variables(fitted)[held.free()];
    let slopes = DMatrix::from_fn(2, 2, |row, column| [number, free][row].slopes[column]);
    let region = Region {
        minimum: vec![number.value, free.value],
        covariance: &slopes * &region.covariance * slopes.transpose(),
        ..*region
    };
    let weights: Vec<f64> = match errors {
        Some(errors) => errors.variance.iter().map(|variance| 1.0 / variance).collect(),
        None => regression.counts.to_vec(),
    };
    let bias = errors.map_or_else(Vec::new, |errors| errors.bias.clone());
    let squares = move |point: &[f64]| {
        let [mut a, mut b] = held.at(variables([point[0], point[1]]));
        // another sheet of a ratio or product
        if matches!(held, Held::Ratio | Held::Product) && a.value * fitted[0] <= 0.0 {
            return None;
        }
        for (own, bias) in [&mut a, &mut b].into_iter().zip(&bias) {
            own.value += bias;
        }
        let mut sums = Sums::new(2);
        for (run, x) in regression.x.iter().enumerate() {
            let at = regression.continued([a.value, b.value], run);
            let root = weights.get(run).map_or(1.0, |weight| weight.sqrt());
            let residual = at.value - regression.restitution[run];
            let [of_a, of_b] = regression.law.design(*x);
            let of_predictor = (a * of_a + b * of_b).slopes;
            let slopes = [0, 1].map(|place| (place, root * at.slope * of_predictor[place]));
            sums.add(root * residual, &slopes);
            let bent = residual * at.bend / (at.slope * at.slope);
            if bent > 0.0 {
                add_square(&mut sums.information, bent, &slopes);
            }
        }
        sums.squares.is_finite().then_some(sums)
    };
    ProblemProfile::new(squares, region)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::law::Law;
    use crate::inference::least_squares::Fit;
    use crate::inference::profile::{first_parameter, Limits};
    use crate::seed::stream;
    use rand::RngExt;

    /// 1/St of three heights and rebounds near the threshold of e² = 0.5324 − 11/St; `pinned` is one that barely does.
    fn draw(seed: u64, spread: f64, pinned: Option<f64>) -> [Vec<f64>; 2] {
        let mut rng = stream(seed, "profile of a law", 0);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let mut runs: Vec<(f64, f64)> = vec![];
        for stokes in [20.7476, 28.57, 40.4] {
            let kept: f64 = 0.5324 - 11.0 / stokes;
            runs.extend((0..3).map(|_| (1.0 / stokes, kept.sqrt() + spread * normal())));
        }
        runs.retain(|run| run.1 > 0.0);
        if let Some(e) = pinned {
            runs[0].1 = e;
        }
        let (x, e) = runs.into_iter().unzip();
        [x, e]
    }

    const T: f64 = 2.4;

    fn limits(regression: &Regression, fit: &Fit, held: Held) -> Limits {
        let region = Region::of(fit, None, 0.95).unwrap();
        let profile = profile(regression, None, &Region { t: T, ..region }, held).unwrap();
        profile.limits(first_parameter).unwrap()
    }

    /// The least squares of the square root with its mirror image over a grid of the other parameter.
    fn on_a_grid(held: Held, value: f64, fitted: f64, [x, e]: [&[f64]; 2]) -> f64 {
        const STEPS: i32 = 20_000;
        let squares = |i: i32| {
            let [a, b] = held.at([value, fitted * (1.0 + 0.9 * f64::from(i) / f64::from(STEPS))]);
            let root = |kept: f64| kept.abs().sqrt() * kept.signum();
            x.iter().zip(e).map(|(x, e)| (root(a + b * x) - e).powi(2)).sum()
        };
        (-STEPS..=STEPS).map(squares).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn limits_are_those_of_a_grid_within_a_thirtieth_of_the_half_width() {
        let mut checked = 0;
        for (seed, pinned) in (0..12).map(|seed| (seed, (seed % 3 == 0).then_some(0.0003))) {
            let [x, e] = draw(seed, 0.03, pinned);
            let regression = Regression::new(Law::SQUARE_ROOT, &x, &e);
            let fit = regression.fit();
            if fit.covariance.is_err() {
                continue;
            }
            let wanted = T * T * fit.residual_sd.unwrap().powi(2);
            for held in [Held::First, Held::Second, Held::Ratio] {
                let fitted = held.of([fit.parameters[0], fit.parameters[1]]);
                let free = fit.parameters[held.free()];
                let limits = limits(&regression, &fit, held);
                for limit in [limits.lo, limits.hi].into_iter().flatten() {
                    let rises =
                        |value: f64| on_a_grid(held, value, free, [&x, &e]) - fit.residual_sum_of_squares > wanted;
                    let half = limits.both().map_or((limit - fitted).abs(), |[lo, hi]| 0.5 * (hi - lo));
                    let beyond = limit + 0.03 * half.copysign(limit - fitted);
                    assert!(rises(beyond), "{seed} {held:?} {fitted} {limits:?}");
                    for part in 1..20 {
                        let within = fitted + 0.05 * f64::from(part) * (limit - fitted);
                        assert!(!rises(within), "{seed} {held:?} {fitted} {limits:?} {part}");
                    }
                    checked += 1;
                }
            }
        }
        assert!(checked > 50, "{checked}");
    }

    /// The limits of a ratio of two parameters of a straight line are Fieller's, and where a line through the origin is
    /// within reach, there is none on one side or on both.
    #[test]
    fn of_a_ratio_the_limits_are_fiellers() {
        let mut without = 0;
        for (seed, spread) in (0..20).map(|seed| (seed, if seed < 10 { 0.03 } else { 0.3 })) {
            let [x, e] = draw(seed, spread, None);
            let regression = Regression::new(Law::LINEAR, &x, &e);
            let fit = regression.fit();
            let [a, b] = [fit.parameters[0], fit.parameters[1]];
            let Some(covariance) = fit.covariance.as_ref().ok().filter(|_| a > 0.0) else {
                continue;
            };
            // (b − q a)² = t² (V_bb − 2 q V_ab + q² V_aa)
            let square = a * a - T * T * covariance[(0, 0)];
            let middle = (a * b - T * T * covariance[(0, 1)]) / square;
            let half = (middle * middle - (b * b - T * T * covariance[(1, 1)]) / square).sqrt();
            let found = limits(&regression, &fit, Held::Ratio);
            if square > 0.0 {
                let [lo, hi] = found.both().unwrap();
                assert!(
                    (lo - middle + half).abs() < 5e-3 * half,
                    "{seed}: {lo} {}",
                    middle - half
                );
                assert!(
                    (hi - middle - half).abs() < 5e-3 * half,
                    "{seed}: {hi} {}",
                    middle + half
                );
            } else {
                assert!(found.both().is_none(), "{seed}: {found:?}");
                without += 1;
            }
        }
        assert!(without > 2, "{without}");
    }
}
