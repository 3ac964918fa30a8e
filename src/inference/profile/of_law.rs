//! Profiles a law of two parameters over one number of theirs, with the other solved out.

use super::{search, Limits, ProfilePoint, AGREES};
use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::least_squares::Fit;
use crate::inference::regression::Regression;

/// The number that is held along a profile: every quantity of a law is a function of one of these.
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
    pub fn of(self, [a, b]: [f64; 2]) -> f64 {
        match self {
            Held::First => a,
            Held::Second => b,
            Held::Ratio => b / a,
            Held::Product => a * b,
        }
    }

    /// Its slopes in the parameters.
    fn slopes(self, [a, b]: [f64; 2]) -> [f64; 2] {
        match self {
            Held::First => [1.0, 0.0],
            Held::Second => [0.0, 1.0],
            Held::Ratio => [-b / (a * a), 1.0 / a],
            Held::Product => [b, a],
        }
    }

    /// The place of the parameter that is left free: what is solved out.
    pub fn free(self) -> usize {
        usize::from(self == Held::First)
    }

    /// The parameters at which it has a value while the free one has another.
    pub fn at(self, value: f64, free: f64) -> [f64; 2] {
        match self {
            Held::First => [value, free],
            Held::Second => [free, value],
            Held::Ratio => [free, value * free],
            Held::Product => [free, value / free],
        }
    }

    /// The slopes of these parameters in the value.
    pub fn direction(self, [a, _]: [f64; 2]) -> [f64; 2] {
        match self {
            Held::First => [1.0, 0.0],
            Held::Second => [0.0, 1.0],
            Held::Ratio => [0.0, a],
            Held::Product => [0.0, 1.0 / a],
        }
    }

    /// Whether the free parameter keeps its sign: 0 would be no law, or another sheet of it.
    fn keeps_sign(self) -> bool {
        matches!(self, Held::Ratio | Held::Product)
    }
}

/// A fitted law of two parameters about its minimum. Outside the domain of the law, which a fit never leaves, the squares
/// go on with the law's mirror image ([`crate::inference::law::Law::continued`]).
pub struct LawProfile<'a> {
    regression: &'a Regression<'a>,
    /// weight of each run; empty where all weigh the same
    weights: Vec<f64>,
    /// what was taken off the minimum's parameters
    bias: [f64; 2],
    parameters: [f64; 2],
    fit: Uncertain,
    /// s², the variance of a residual of weight 1
    variance: f64,
    squares: f64,
}

impl<'a> LawProfile<'a> {
    /// `None` where the fit has no covariance, or one parameter.
    pub fn new(regression: &'a Regression, fit: &Fit, errors: Option<&ErrorWeights>) -> Option<LawProfile<'a>> {
        let [a, b] = *fit.parameters.as_slice() else {
            return None;
        };
        let mut profile = LawProfile {
            regression,
            weights: match errors {
                Some(errors) => errors.variance.iter().map(|v| 1.0 / v).collect(),
                None => regression.counts.to_vec(),
            },
            bias: [0.0; 2],
            parameters: [a, b],
            fit: Uncertain {
                covariance: Ok(fit.covariance.clone()?),
                degrees_of_freedom: fit.degrees_of_freedom,
            },
            variance: fit.residual_sd? * fit.residual_sd?,
            squares: f64::NAN,
        };
        if let Some(errors) = errors {
            profile.variance = 1.0;
            profile.bias = [0, 1].map(|j| errors.bias.get(j).copied().unwrap_or(0.0));
        }
        profile.squares = profile.squares_at(profile.parameters);
        Some(profile)
    }

    /// The fitted parameters.
    pub fn parameters(&self) -> [f64; 2] {
        self.parameters
    }

    /// Covariance of the parameters by the fit alone.
    pub fn uncertain(&self) -> &Uncertain {
        &self.fit
    }

    fn squares_at(&self, [a, b]: [f64; 2]) -> f64 {
        let at = [a + self.bias[0], b + self.bias[1]];
        let Regression {
            law,
            x,
            offset,
            restitution,
            counts: _,
        } = *self.regression;
        let square = |run: usize, offset: f64| {
            let left = law.continued(law.predictor(at, x[run], offset)) - restitution[run];
            left * left
        };
        let runs = 0..x.len();
        match (offset, self.weights.as_slice()) {
            ([], []) => runs.map(|run| square(run, 0.0)).sum(),
            (_, []) => runs.map(|run| square(run, offset[run])).sum(),
            ([], weights) => runs.map(|run| weights[run] * square(run, 0.0)).sum(),
            (_, weights) => runs.map(|run| weights[run] * square(run, offset[run])).sum(),
        }
    }

    fn point(&self, value: f64, squares: f64, t: f64) -> ProfilePoint {
        ProfilePoint::new(value, squares - self.squares, t * t * self.variance)
    }

    /// The points t standard errors along the slopes at the fit, with their squares.
    fn along_slopes(&self, held: Held, t: f64) -> Option<[ProfilePoint; 2]> {
        let slopes = held.slopes(self.parameters);
        let se = self.fit.se(&slopes).ok()?;
        let covariance = self.fit.covariance.as_ref().ok()?;
        let step = [0, 1].map(|j| (covariance[(j, 0)] * slopes[0] + covariance[(j, 1)] * slopes[1]) / se);
        Some([-t, t].map(|t| {
            let at = [0, 1].map(|j| self.parameters[j] + t * step[j]);
            self.point(held.of(at), self.squares_at(at), t)
        }))
    }

    /// Whether the squares rise along the slopes at the fit as if it had no curvature, and the number as well.
    pub fn is_straight(&self, held: Held, t: f64) -> bool {
        let value = held.of(self.parameters);
        let Ok(se) = self.fit.se(&held.slopes(self.parameters)) else {
            return true;
        };
        let straight = |(point, side): (ProfilePoint, f64)| {
            let off = (point.value - value) / (t * se) - side;
            (point.distance - 1.0).abs() <= AGREES && off.abs() <= AGREES
        };
        let both = self.along_slopes(held, t);
        both.is_some_and(|points| points.into_iter().zip([-1.0, 1.0]).all(straight))
    }

    /// The limits of a number at t.
    pub fn limits(&self, held: Held, t: f64) -> Limits {
        let value = held.of(self.parameters);
        let Ok(se) = self.fit.se(&held.slopes(self.parameters)) else {
            return Limits { lo: None, hi: None };
        };
        let mut near = self.parameters[held.free()];
        search(value, [value - t * se, value + t * se], |target| {
            let (free, squares) = self.least(held, target, near, t)?;
            near = free;
            Some(self.point(target, squares, t))
        })
    }

    /// The free parameter at which the squares are least while a number is held, and these: the best of values about a
    /// guess, then closed in on. Runs at the edge of their domain make the squares a sum of kinks, in which steps by
    /// slopes go astray.
    fn least(&self, held: Held, value: f64, near: f64, t: f64) -> Option<(f64, f64)> {
        /// reach of the values tried about the guess, in t standard errors: each four times the one before
        const REACH: [f64; 5] = [1.0 / 16.0, 0.25, 1.0, 4.0, 16.0];
        /// an error pinned by one run is no reach
        const LEAST: f64 = 1e-3;
        let place = held.free();
        let mut unit = [0.0; 2];
        unit[place] = 1.0;
        let reach = self.fit.se(&unit).map_or(0.0, |se| t * se).max(LEAST * near.abs());
        let fitted = self.parameters[place];
        let allowed = |free: f64| !held.keeps_sign() || free * fitted > 0.0;
        let squares = |free: f64| match allowed(free) {
            true => self.squares_at(held.at(value, free)),
            false => f64::INFINITY,
        };
        let below = REACH.iter().rev().map(|share| near - share * reach);
        let above = REACH.iter().map(|share| near + share * reach);
        let mut tried: Vec<f64> = below.chain([near]).chain(above).filter(|free| allowed(*free)).collect();
        if held.keeps_sign() {
            // towards 0 by shares
            tried.extend([0.5, 0.1, 0.01].map(|share| share * near));
            tried.sort_unstable_by(f64::total_cmp);
        }
        let all: Vec<f64> = tried.iter().map(|free| squares(*free)).collect();
        let best = (0..tried.len()).min_by(|a, b| all[*a].total_cmp(&all[*b]))?;
        let neighbours = [best.saturating_sub(1), best, (best + 1).min(tried.len() - 1)];
        let found = least_between(neighbours.map(|place| (tried[place], all[place])), squares);
        found.1.is_finite().then_some(found)
    }
}

/// Where a function is least between two points, from a third in their middle that is no higher, and its value there:
/// through the three lowest so far goes a parabola, and where its lowest point leads astray, the golden section is taken.
///
/// To 3e-6 of the distance of the two. Source: Brent 1973, Algorithms for Minimization without Derivatives, chapter 5.
fn least_between([low, middle, high]: [(f64, f64); 3], mut of: impl FnMut(f64) -> f64) -> (f64, f64) {
    /// share of the distance that is told apart
    const NEAR: f64 = 1e-6;
    /// the golden section alone takes about 30
    const STEPS: usize = 60;
    let golden = 0.5 * (3.0 - 5f64.sqrt());
    let (mut lo, mut hi) = (low.0, high.0);
    let near = NEAR * (hi - lo);
    let (mut best, mut second, mut third) = (middle, low, high);
    if third.1 < second.1 {
        (second, third) = (third, second);
    }
    let (mut step, mut last) = (hi - lo, hi - lo);
    for _ in 0..STEPS {
        let centre = 0.5 * (lo + hi);
        if (best.0 - centre).abs() <= 2.0 * near - 0.5 * (hi - lo) {
            break;
        }
        let (to_second, to_third) = (best.0 - second.0, best.0 - third.0);
        let (r, q) = (to_second * (best.1 - third.1), to_third * (best.1 - second.1));
        let parabola = (to_second * r - to_third * q) / (2.0 * (q - r));
        let before_last = std::mem::replace(&mut last, step);
        // false of what is no number, as beside an infinite value
        let is_good =
            parabola.abs() < 0.5 * before_last.abs() && best.0 + parabola > lo + near && best.0 + parabola < hi - near;
        step = if is_good {
            parabola
        } else {
            last = if best.0 < centre { hi - best.0 } else { lo - best.0 };
            golden * last
        };
        let at = best.0 + if step.abs() < near { near.copysign(step) } else { step };
        let new = (at, of(at));
        if new.1 <= best.1 {
            *(if at < best.0 { &mut hi } else { &mut lo }) = best.0;
            (third, second, best) = (second, best, new);
        } else {
            *(if at < best.0 { &mut lo } else { &mut hi }) = at;
            if new.1 <= second.1 {
                (third, second) = (second, new);
            } else if new.1 <= third.1 {
                third = new;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::law::Law;
    use crate::seed::stream;
    use rand::RngExt;

    /// 1/St of three heights and rebounds near the threshold of e² = 0.5324 − 11/St; `pinned` is one that barely does.
    fn draw(seed: u64, pinned: Option<f64>) -> (Vec<f64>, Vec<f64>) {
        let mut rng = stream(seed, "profile of a law", 0);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let mut runs: Vec<(f64, f64)> = vec![];
        for stokes in [20.7476, 28.57, 40.4] {
            let kept: f64 = 0.5324 - 11.0 / stokes;
            runs.extend((0..3).map(|_| (1.0 / stokes, kept.sqrt() + 0.03 * normal())));
        }
        runs.retain(|run| run.1 > 0.0);
        if let Some(e) = pinned {
            runs[0].1 = e;
        }
        runs.into_iter().unzip()
    }

    fn squares(held: Held, [value, free]: [f64; 2], x: &[f64], e: &[f64]) -> f64 {
        let [a, b] = match held {
            Held::First => [value, free],
            Held::Second => [free, value],
            Held::Ratio => [free, value * free],
            Held::Product => [free, value / free],
        };
        let root = |kept: f64| kept.abs().sqrt() * kept.signum();
        x.iter().zip(e).map(|(x, e)| (root(a + b * x) - e).powi(2)).sum()
    }

    /// The least squares over a grid of the free parameter.
    fn on_a_grid(held: Held, value: f64, fitted: f64, x: &[f64], e: &[f64]) -> f64 {
        const STEPS: i32 = 20_000;
        let free = |i: i32| fitted * (1.0 + 0.9 * f64::from(i) / f64::from(STEPS));
        let all = (-STEPS..=STEPS).map(|i| squares(held, [value, free(i)], x, e));
        all.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_least_of_a_function_is_found_between_two_points() {
        let smooth = |x: f64| (x - 0.3).powi(2) + 0.1 * (x - 0.3).powi(4);
        let kink = |x: f64| (x - 0.7).abs();
        let wall = |x: f64| if x < 0.2 { f64::INFINITY } else { x };
        let falling = |x: f64| -x;
        type Case<'c> = (&'c dyn Fn(f64) -> f64, f64, usize);
        let all: [Case; 4] = [
            (&smooth, 0.3, 12),
            (&kink, 0.7, 45),
            (&wall, 0.2, 45),
            (&falling, 1.0, 45),
        ];
        for (of, expected, most) in all {
            for middle in [0.4, 1.0] {
                let mut calls = 0;
                let given = [0.0, middle, 1.0].map(|x| (x, of(x)));
                if given[1].1 > given[0].1.min(given[2].1) {
                    continue;
                }
                let found = least_between(given, |x| {
                    calls += 1;
                    of(x)
                });
                assert!((found.0 - expected).abs() < 3e-6, "{expected} {found:?}");
                assert!(found.1 == of(found.0) && calls <= most, "{expected} {calls}");
            }
        }
    }

    #[test]
    fn limits_are_those_of_a_grid_and_squares_stay_below_within() {
        const T: f64 = 2.4;
        let mut checked = 0;
        for (seed, pinned) in (0..12).map(|seed| (seed, (seed % 3 == 0).then_some(0.0003))) {
            let (x, e) = draw(seed, pinned);
            let regression = Regression::new(Law::SQUARE_ROOT, &x, &e);
            let fit = regression.fit();
            let Some(profile) = LawProfile::new(&regression, &fit, None) else {
                continue;
            };
            let wanted = T * T * fit.residual_sd.unwrap().powi(2);
            for held in [Held::First, Held::Second, Held::Ratio] {
                let fitted = held.of(profile.parameters());
                let free = profile.parameters()[held.free()];
                let rise = |value: f64| (on_a_grid(held, value, free, &x, &e) - fit.residual_sum_of_squares) / wanted;
                let limits = profile.limits(held, T);
                for limit in [limits.lo, limits.hi].into_iter().flatten() {
                    let found = rise(limit);
                    assert!((found - 1.0).abs() < 0.03, "{seed} {held:?} {limit}: {found}");
                    for part in 1..20 {
                        let within = rise(fitted + 0.05 * f64::from(part) * (limit - fitted));
                        assert!(within < 1.0, "{seed} {held:?} {limit} {part}: {within}");
                    }
                    checked += 1;
                }
            }
        }
        assert!(checked > 50, "{checked}");
    }

    #[test]
    fn of_a_straight_line_the_limits_are_the_delta_methods() {
        let (x, e) = draw(3, None);
        let regression = Regression::new(Law::LINEAR, &x, &e);
        let fit = regression.fit();
        let profile = LawProfile::new(&regression, &fit, None).unwrap();
        for held in [Held::First, Held::Second] {
            assert!(profile.is_straight(held, 2.4));
            let place = usize::from(held == Held::Second);
            let [lo, hi] = profile.limits(held, 2.4).both().unwrap();
            let half = 2.4 * fit.se(place).unwrap();
            assert!((lo - fit.parameters[place] + half).abs() < 3e-3 * half, "{held:?}");
            assert!((hi - fit.parameters[place] - half).abs() < 3e-3 * half, "{held:?}");
        }
    }

    /// The limits of a ratio of two parameters of a straight line are Fieller's.
    #[test]
    fn of_a_ratio_the_limits_are_fiellers() {
        const T: f64 = 2.4;
        let (x, e) = draw(5, None);
        let regression = Regression::new(Law::LINEAR, &x, &e);
        let fit = regression.fit();
        let covariance = fit.covariance.as_ref().unwrap();
        let [a, b] = [fit.parameters[0], fit.parameters[1]];
        // (b − q a)² = t² (V_bb − 2 q V_ab + q² V_aa)
        let square = a * a - T * T * covariance[(0, 0)];
        let middle = (a * b - T * T * covariance[(0, 1)]) / square;
        let half = (middle * middle - (b * b - T * T * covariance[(1, 1)]) / square).sqrt();
        let profile = LawProfile::new(&regression, &fit, None).unwrap();
        let [lo, hi] = profile.limits(Held::Ratio, T).both().unwrap();
        assert!((lo - middle + half).abs() < 5e-3 * half, "{lo} {}", middle - half);
        assert!((hi - middle - half).abs() < 5e-3 * half, "{hi} {}", middle + half);
    }
}
