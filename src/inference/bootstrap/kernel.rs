//! Fits the laws to weighted runs in one stream over them, for replicates by the ten thousand.
//!
//! Sums of [`Law`]'s values and slopes are restated here so that they are quick; the tests hold them equal to it.
//!
//! With e ≥ 0 the square root's sum of squares is convex in (α, β): (√r − e)² has the second derivative
//! e/(2 r^(3/2)) ≥ 0 in r, and r is linear in both. Newton's method, held inside the domain, then finds the one minimum.

use serde::{Deserialize, Serialize};

use crate::inference::law::Law;
use crate::inference::sums::sums;
use crate::physics::dry::Order;
use crate::scene::WetLaw;

/// What a kernel found; NaN where there is no fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedFit {
    /// a, b of the law
    pub parameters: [f64; 2],
    /// entries aa, ab, bb of the covariance with the replicate's own residual variance
    pub covariance: [f64; 3],
}

impl WeightedFit {
    /// No fit.
    pub const NONE: WeightedFit = WeightedFit {
        parameters: [f64::NAN; 2],
        covariance: [f64::NAN; 3],
    };

    /// The fit, if every parameter has a number.
    pub(super) fn finite(self) -> Result<WeightedFit, Failure> {
        let all = self.parameters.iter().all(|p| p.is_finite());
        all.then_some(self).ok_or(Failure::Degenerate)
    }
}

/// Why weighted runs have no fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Failure {
    /// the runs with weight do not determine the parameters
    Degenerate,
    /// Newton's method does not settle
    NotConverged,
    /// one series, where series are resampled
    OneSeries,
}

impl Failure {
    /// In words.
    pub fn as_str(self) -> &'static str {
        match self {
            Failure::Degenerate => "degenerate resample",
            Failure::NotConverged => "no convergence",
            Failure::OneSeries => "one series: none to draw in its place",
        }
    }
}

/// What a law is fitted to: runs, or runs of one abscissa as one at their mean.
#[derive(Debug, Clone, Copy)]
pub struct Sample<'a> {
    /// abscissa
    pub x: &'a [f64],
    /// known offset; empty for none
    pub offset: &'a [f64],
    /// restitution
    pub restitution: &'a [f64],
    /// weight
    pub weights: &'a [f64],
    /// weighted squares about the means, which no parameter moves
    pub within: f64,
}

impl<'a> Sample<'a> {
    /// Single runs without offset.
    pub fn new(x: &'a [f64], restitution: &'a [f64], weights: &'a [f64]) -> Sample<'a> {
        Sample {
            x,
            offset: &[],
            restitution,
            weights,
            within: 0.0,
        }
    }
}

/// Below this share of the product of the diagonals a 2 × 2 determinant is rounding.
const SINGULAR: f64 = 1e-12;

/// Fits a law to weighted runs, where it needs a start from parameters near those of all runs.
pub fn fit(law: Law, sample: &Sample, start: [f64; 2]) -> Result<WeightedFit, Failure> {
    let fitted = match law {
        Law::Dry(Order::First) => dry(sample),
        Law::Dry(Order::Second) => dry_second_order(sample, start[0]),
        Law::Wet(WetLaw::Linear) => linear(sample),
        Law::Wet(WetLaw::Sqrt) => square_root(sample, start),
    };
    fitted.and_then(WeightedFit::finite)
}

/// k of e = 1 − k s, s = v^(1/5); fails if every weight is on runs without speed.
pub fn dry(sample: &Sample) -> Result<WeightedFit, Failure> {
    let (mut ss, mut sy, mut yy, mut n) = (0.0, 0.0, sample.within, 0.0);
    for ((s, e), w) in sample.x.iter().zip(sample.restitution).zip(sample.weights) {
        let y = 1.0 - e;
        ss += w * s * s;
        sy += w * s * y;
        yy += w * y * y;
        n += w;
    }
    if ss <= 0.0 {
        return Err(Failure::Degenerate);
    }
    let k = sy / ss;
    let variance = (yy - k * sy).max(0.0) / (n - 1.0) / ss;
    Ok(WeightedFit {
        parameters: [k, 0.0],
        covariance: [variance, 0.0, 0.0],
    })
}

/// k of e = 1 − k s + (3/5) k² s² from a start near it; fails if every weight is on runs without speed, or Newton's method
/// does not settle.
pub fn dry_second_order(sample: &Sample, start: f64) -> Result<WeightedFit, Failure> {
    // F = 1 − η + a η²
    let a = 0.5 * Law::Dry(Order::Second).response(0.0).bend;
    // of runs with y = 1 − e: the squares are a polynomial in k
    let [n, yy, y1, y2, s2, s3, s4] = sums([sample.x, sample.restitution, sample.weights], |[s, e, w]| {
        let (y, square) = (1.0 - e, s * s);
        let ws2 = w * square;
        [w, w * y * y, w * s * y, ws2 * y, ws2, ws2 * s, ws2 * square]
    });
    if s2 <= 0.0 {
        return Err(Failure::Degenerate);
    }
    let mut k = start;
    for _ in 0..MOST_STEPS {
        // half the slope of the squares in k, and half its slope
        let slope = -y1 + k * (s2 + 2.0 * a * y2) - 3.0 * a * k * k * s3 + 2.0 * a * a * k * k * k * s4;
        let bend = s2 + 2.0 * a * y2 - 6.0 * a * k * s3 + 6.0 * a * a * k * k * s4;
        if bend <= 0.0 {
            return Err(Failure::NotConverged);
        }
        let step = slope / bend;
        k -= step;
        if step.abs() <= SETTLED * k.abs() {
            let left = sample.within + yy - 2.0 * k * y1 + k * k * (s2 + 2.0 * a * y2) - 2.0 * a * k * k * k * s3
                + a * a * k * k * k * k * s4;
            let squares = s2 - 4.0 * a * k * s3 + 4.0 * a * a * k * k * s4;
            return Ok(WeightedFit {
                parameters: [k, 0.0],
                covariance: [left.max(0.0) / (n - 1.0) / squares, 0.0, 0.0],
            });
        }
    }
    Err(Failure::NotConverged)
}

/// a, b of e = a − b x; fails if the weighted x do not vary.
pub fn linear(sample: &Sample) -> Result<WeightedFit, Failure> {
    let (x, e, w) = (sample.x, sample.restitution, sample.weights);
    // about a run inside the data, so that nothing cancels
    let (Some(&x0), Some(&e0)) = (x.get(x.len() / 2), e.get(e.len() / 2)) else {
        return Err(Failure::Degenerate);
    };
    let [n, sx, se, xx, xe, ee] = sums([x, e, w], |[x, e, w]| {
        let (x, e) = (x - x0, e - e0);
        let (wx, we) = (w * x, w * e);
        [w, wx, we, wx * x, wx * e, we * e]
    });
    let design = LineDesign::new(n, x0, sx, xx)?;
    let me = se * design.share;
    Ok(design.through(e0 + me, xe - sx * me, sample.within + ee - se * me))
}

/// The part of a linear fit that depends on weights and abscissae alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineDesign {
    /// 1 over the sum of the weights: a fit must not wait for divisions
    pub(super) share: f64,
    /// 1 over the degrees of freedom
    freedom: f64,
    /// mean abscissa
    pub(super) centre: f64,
    /// 1 over the squares about it
    spread: f64,
}

impl LineDesign {
    /// From the sum of the weights, and sum and squares of x − x0.
    pub(super) fn new(runs: f64, x0: f64, sx: f64, xx: f64) -> Result<LineDesign, Failure> {
        let share = 1.0 / runs;
        let mean = sx * share;
        let squares = xx - sx * mean;
        // a NaN determines nothing, either
        let determined = squares > SINGULAR * xx.max(f64::MIN_POSITIVE) && runs >= 2.0;
        let design = LineDesign {
            share,
            freedom: 1.0 / (runs - 2.0),
            centre: x0 + mean,
            spread: 1.0 / squares,
        };
        determined.then_some(design).ok_or(Failure::Degenerate)
    }

    /// The line through the mean restitution, from products and squares about the means.
    #[inline(always)] // in the registers of the caller
    pub(super) fn through(&self, mean: f64, products: f64, squares: f64) -> WeightedFit {
        let slope = products * self.spread;
        let variance = (squares - slope * products).max(0.0) * self.freedom;
        let bb = variance * self.spread;
        WeightedFit {
            parameters: [mean - slope * self.centre, -slope],
            covariance: [
                variance * self.share + self.centre * self.centre * bb,
                self.centre * bb,
                bb,
            ],
        }
    }
}

/// Linear predictor below which a run without weight is held, so that its zero weight stays a zero.
const FLOOR: f64 = 1e-30;

/// Newton steps before a replicate counts as not converged.
const MOST_STEPS: usize = 60;
/// Share of the way to the domain's edge a step may take.
const MOST_OF_THE_WAY: f64 = 0.9;
/// Relative change of both parameters' contributions after which Newton's next one, about its square, is rounding.
const SETTLED: f64 = 1e-10;

/// α, β of e = √(α + β x + o) from a start inside the domain, at which it need not be near the minimum.
///
/// Fails if the runs with weight do not determine both, or Newton's method does not settle.
pub fn square_root(sample: &Sample, start: [f64; 2]) -> Result<WeightedFit, Failure> {
    if sample.offset.is_empty() {
        newton::<false>(sample, sample.restitution, start)
    } else {
        newton::<true>(sample, sample.offset, start)
    }
}

/// Linear predictor of the square root, the offset left out where there is none.
#[inline(always)]
fn predictor<const OFFSET: bool>([alpha, beta]: [f64; 2], x: f64, o: f64) -> f64 {
    alpha + beta * x + if OFFSET { o } else { 0.0 }
}

/// Gradient g and Hessian h of ½ Σ w (√r − e)² in the columns x, o, e and w: g0, g1, h00, h01, h11.
#[inline(always)]
fn gradient_and_hessian<const OFFSET: bool>(columns: [&[f64]; 4], parameters: [f64; 2]) -> [f64; 5] {
    sums(columns, |[x, o, e, w]| {
        let r = predictor::<OFFSET>(parameters, x, o).max(FLOOR);
        // one division for both e/√r and e/(r √r)
        let bend = w * e / (r * r.sqrt());
        let slope = 0.5 * (w - bend * r);
        let bend = 0.25 * bend;
        [slope, slope * x, bend, bend * x, bend * x * x]
    })
}

/// The largest share of a step that leads no run more than most of the way to the edge of the domain.
#[inline(always)]
fn share_inside<const OFFSET: bool>(columns: [&[f64]; 4], parameters: [f64; 2], step: [f64; 2]) -> f64 {
    let change = |x: f64| step[0] + step[1] * x;
    let room = |x: f64, o: f64| MOST_OF_THE_WAY * predictor::<OFFSET>(parameters, x, o);
    let [leaving] = sums(columns, |[x, o, _, w]| [(w * (-change(x) - room(x, o))).max(0.0)]);
    let mut share: f64 = 1.0;
    if leaving > 0.0 {
        let [x, o, _, w] = columns;
        for run in (0..x.len()).filter(|run| w[*run] > 0.0 && -change(x[*run]) - room(x[*run], o[*run]) > 0.0) {
            share = share.min(room(x[run], o[run]) / -change(x[run]));
        }
    }
    share
}

fn newton<const OFFSET: bool>(sample: &Sample, o: &[f64], start: [f64; 2]) -> Result<WeightedFit, Failure> {
    let mut parameters = start;
    let middle = *sample.x.get(sample.x.len() / 2).ok_or(Failure::Degenerate)?;
    let columns = [sample.x, o, sample.restitution, sample.weights];
    for _ in 0..MOST_STEPS {
        let [g0, g1, h0, h1, h2] = gradient_and_hessian::<OFFSET>(columns, parameters);
        let determinant = h0 * h2 - h1 * h1;
        let determined = determinant > SINGULAR * h0 * h2;
        if !determined {
            return Err(Failure::Degenerate);
        }
        let step = [(h1 * g1 - h2 * g0) / determinant, (h1 * g0 - h0 * g1) / determinant];
        let share = share_inside::<OFFSET>(columns, parameters, step);
        let step = step.map(|s| s * share);
        parameters = [parameters[0] + step[0], parameters[1] + step[1]];
        let change = step[0].abs() + (step[1] * middle).abs();
        if share == 1.0 && change <= SETTLED * parameters[0].abs() {
            return Ok(covariance::<OFFSET>(columns, sample.within, parameters));
        }
    }
    Err(Failure::NotConverged)
}

/// The delta method's covariance at the minimum: residual variance times (JᵀWJ)⁻¹.
fn covariance<const OFFSET: bool>(columns: [&[f64]; 4], within: f64, parameters: [f64; 2]) -> WeightedFit {
    let [n, squares, j0, j1, j2] = sums(columns, |[x, o, e, w]| {
        let r = predictor::<OFFSET>(parameters, x, o).max(FLOOR);
        let residual = r.sqrt() - e;
        let weight = 0.25 * w / r;
        [w, w * residual * residual, weight, weight * x, weight * x * x]
    });
    let scale = (within + squares) / (n - 2.0) / (j0 * j2 - j1 * j1);
    WeightedFit {
        parameters,
        covariance: [scale * j2, -scale * j1, scale * j0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::stream;
    use rand::rngs::ChaCha8Rng;
    use rand::RngExt;

    /// WeightedFit runs that scatter about a law.
    struct Case {
        law: Law,
        x: Vec<f64>,
        offset: Vec<f64>,
        restitution: Vec<f64>,
        weights: Vec<f64>,
        parameters: [f64; 2],
        within: f64,
    }

    impl Case {
        fn draw(law: Law, with_offset: bool, rng: &mut ChaCha8Rng) -> Case {
            let mut uniform = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
            let parameters = match law {
                Law::Dry(_) => [uniform(0.1, 0.3), 0.0],
                Law::Wet(WetLaw::Linear) => [uniform(0.7, 0.9), uniform(0.05, 0.15)],
                Law::Wet(WetLaw::Sqrt) => [uniform(0.5, 0.8), -uniform(0.05, 0.15)],
            };
            let (mut x, mut offset, mut restitution, mut weights) = (vec![], vec![], vec![], vec![]);
            for run in 0..41 {
                x.push(law.abscissa(uniform(0.4, 4.0)));
                offset.push(if with_offset { uniform(-0.05, 0.05) } else { 0.0 });
                restitution.push(law.restitution(parameters, x[run], offset[run]) + uniform(-0.03, 0.03));
                weights.push(uniform(-1.0, 4.0).max(0.0).floor());
            }
            offset.truncate(if with_offset { 41 } else { 0 });
            Case {
                law,
                x,
                offset,
                restitution,
                weights,
                parameters,
                within: uniform(0.0, 0.01),
            }
        }

        fn sample(&self) -> Sample<'_> {
            Sample {
                offset: &self.offset,
                within: self.within,
                ..Sample::new(&self.x, &self.restitution, &self.weights)
            }
        }

        /// Gradient and Hessian of ½ Σ w (F − e)², JᵀWJ, and Σ w (F − e)², by the law's own statement.
        fn stated(&self, law: Law, parameters: [f64; 2]) -> ([f64; 2], [f64; 3], [f64; 3], f64) {
            let (mut gradient, mut hessian, mut information, mut squares) = ([0.0; 2], [0.0; 3], [0.0; 3], 0.0);
            for (run, (x, weight)) in self.x.iter().zip(&self.weights).enumerate() {
                let offset = self.offset.get(run).copied().unwrap_or(0.0);
                let at = law.response(law.predictor(parameters, *x, offset));
                let residual = at.value - self.restitution[run];
                squares += weight * residual * residual;
                for (sum, c) in gradient.iter_mut().zip(law.design(*x)) {
                    *sum += weight * residual * at.slope * c;
                }
                for (j, product) in law.design_products(*x).into_iter().enumerate() {
                    hessian[j] += weight * (at.slope * at.slope + residual * at.bend) * product;
                    information[j] += weight * at.slope * at.slope * product;
                }
            }
            (gradient, hessian, information, squares)
        }

        /// Newton's step at the fit, as a share of the parameters, by the statement of a law.
        fn step_left(&self, law: Law, fit: &WeightedFit) -> f64 {
            let (gradient, hessian, _, _) = self.stated(law, fit.parameters);
            let steps = law.solve(hessian, gradient).into_iter().zip(fit.parameters);
            let shares = steps.take(law.parameters()).map(|(step, b)| (step / b).abs());
            shares.fold(0.0, f64::max)
        }
    }

    fn cases(test: &str) -> impl Iterator<Item = Case> + use<'_> {
        let kinds = [
            (Law::Dry(Order::First), false),
            (Law::Dry(Order::Second), false),
            (Law::LINEAR, false),
            (Law::SQUARE_ROOT, false),
            (Law::SQUARE_ROOT, true),
        ];
        let mut rng = stream(1, test, 0);
        (0..200).map(move |number| {
            let (law, with_offset) = kinds[number % kinds.len()];
            Case::draw(law, with_offset, &mut rng)
        })
    }

    const ROUNDING: f64 = 1e-12;

    #[test]
    fn every_fit_is_the_minimum_of_the_law_as_it_is_stated() {
        for case in cases("every_fit_is_the_minimum_of_the_law_as_it_is_stated") {
            let law = case.law;
            let start = case.parameters.map(|b| 1.05 * b);
            let found = fit(law, &case.sample(), start).expect("determined");
            assert!(case.step_left(law, &found) < ROUNDING, "{law:?}: {found:?}");
            let (_, _, information, squares) = case.stated(law, found.parameters);
            let freedom = case.weights.iter().sum::<f64>() - law.parameters() as f64;
            let variance = (case.within + squares) / freedom;
            let [aa, ab] = law.solve(information, [variance, 0.0]);
            let [_, bb] = law.solve(information, [0.0, variance]);
            for (found, stated) in found.covariance.into_iter().zip([aa, ab, bb]) {
                assert!(
                    (found - stated).abs() <= ROUNDING * stated.abs(),
                    "{law:?}: {found} {stated}"
                );
            }
            // the planted fault: the dry law to the other order
            if law == Law::Dry(Order::Second) {
                assert!(case.step_left(Law::Dry(Order::First), &found) > 1e-3);
            }
        }
    }

    #[test]
    fn sums_of_the_square_root_away_from_its_minimum_are_those_of_the_law_as_it_is_stated() {
        for case in cases("sums_of_the_square_root_away_from_its_minimum") {
            if case.law != Law::SQUARE_ROOT {
                continue;
            }
            let parameters = [1.1 * case.parameters[0], 0.7 * case.parameters[1]];
            let ([g0, g1], [h0, h1, h2], _, _) = case.stated(case.law, parameters);
            let o = if case.offset.is_empty() { &case.x } else { &case.offset };
            let columns = [&case.x[..], o, &case.restitution, &case.weights];
            let found = if case.offset.is_empty() {
                gradient_and_hessian::<false>(columns, parameters)
            } else {
                gradient_and_hessian::<true>(columns, parameters)
            };
            for (found, stated) in found.into_iter().zip([g0, g1, h0, h1, h2]) {
                assert!((found - stated).abs() <= ROUNDING * stated.abs(), "{found} {stated}");
            }
        }
    }
}
