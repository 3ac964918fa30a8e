//! Fits a law to weighted runs in one stream over them: replicates by the ten thousand, and starts of other fits.
//!
//! Sums of [`Law`]'s values and slopes are restated here so that they are quick; the tests hold them equal to it.
//!
//! With e ≥ 0 the square root's sum of squares is convex in (α, β): (√r − e)² has the second derivative
//! e/(2 r^(3/2)) ≥ 0 in r, and r is linear in both. Newton's method, held inside the domain, then finds the one minimum.

use crate::inference::law::Law;
use crate::lanes::sums;
use crate::physics::dry::Order;
use crate::scene::WetLaw;

/// The parameters a, b of a law, or why weighted runs have no fit.
pub type WeightedFit = Result<[f64; 2], Failure>;

/// Why weighted runs have no fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Failure {
    /// the runs with weight do not determine the parameters
    Degenerate,
    /// Newton's method, or the weights by measurement errors, do not settle
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
}

impl<'a> Sample<'a> {
    /// Runs without offset.
    pub fn new(x: &'a [f64], restitution: &'a [f64], weights: &'a [f64]) -> Sample<'a> {
        Sample {
            x,
            offset: &[],
            restitution,
            weights,
        }
    }
}

/// Below this share of the product of the diagonals a 2 × 2 determinant is rounding.
const SINGULAR: f64 = 1e-12;

/// Fits a law to weighted runs, where it needs a start from parameters near those of all runs.
pub fn fit(law: Law, sample: &Sample, start: [f64; 2]) -> WeightedFit {
    let fitted = match law {
        Law::Dry(order) => dry(order, sample, start[0]),
        Law::Wet(WetLaw::Linear) => linear(sample),
        Law::Wet(WetLaw::Sqrt) => square_root(sample, start),
    }?;
    let finite = fitted.iter().all(|parameter| parameter.is_finite());
    finite.then_some(fitted).ok_or(Failure::Degenerate)
}

/// k of e = 1 − k s, to second order 1 − k s + (3/5) k² s², with s = v^(1/5); to second order by Newton's method from a start
/// near it.
///
/// Fails if every weight is on runs without speed, or Newton's method does not settle.
pub fn dry(order: Order, sample: &Sample, start: f64) -> WeightedFit {
    // F = 1 − η + a η²
    let a = 0.5 * Law::Dry(order).response(0.0).bend;
    // of runs with y = 1 − e: the squares are a polynomial in k
    let [y1, y2, s2, s3, s4] = sums([sample.x, sample.restitution, sample.weights], |[s, e, w]| {
        let (y, ws) = (1.0 - e, w * s);
        let ws2 = ws * s;
        [ws * y, ws2 * y, ws2, ws2 * s, ws2 * s * s]
    });
    if s2 <= 0.0 {
        return Err(Failure::Degenerate);
    }
    if order == Order::First {
        return Ok([y1 / s2, 0.0]);
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
            return Ok([k, 0.0]);
        }
    }
    Err(Failure::NotConverged)
}

/// a, b of e = a − b x; fails if the weighted x do not vary.
pub fn linear(sample: &Sample) -> WeightedFit {
    let (x, e, w) = (sample.x, sample.restitution, sample.weights);
    // about a run inside the data, so that nothing cancels
    let (Some(&x0), Some(&e0)) = (x.get(x.len() / 2), e.get(e.len() / 2)) else {
        return Err(Failure::Degenerate);
    };
    let [n, sx, se, xx, xe] = sums([x, e, w], |[x, e, w]| {
        let (x, e) = (x - x0, e - e0);
        let (wx, we) = (w * x, w * e);
        [w, wx, we, wx * x, wx * e]
    });
    let (mean_x, mean_e) = (sx / n, se / n);
    let squares = xx - sx * mean_x;
    // a NaN determines nothing, either
    let determined = squares > SINGULAR * xx.max(f64::MIN_POSITIVE) && n >= 2.0;
    if !determined {
        return Err(Failure::Degenerate);
    }
    let slope = (xe - sx * mean_e) / squares;
    Ok([e0 + mean_e - slope * (x0 + mean_x), -slope])
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
pub fn square_root(sample: &Sample, start: [f64; 2]) -> WeightedFit {
    let root = SquareRoot::new(sample);
    let mut parameters = start;
    let middle = *sample.x.get(sample.x.len() / 2).ok_or(Failure::Degenerate)?;
    for _ in 0..MOST_STEPS {
        let [g0, g1, h0, h1, h2] = root.gradient_and_hessian(parameters);
        let determinant = h0 * h2 - h1 * h1;
        let determined = determinant > SINGULAR * h0 * h2;
        if !determined {
            return Err(Failure::Degenerate);
        }
        let step = [(h1 * g1 - h2 * g0) / determinant, (h1 * g0 - h0 * g1) / determinant];
        let share = root.share_inside(parameters, step);
        let step = step.map(|s| s * share);
        parameters = [parameters[0] + step[0], parameters[1] + step[1]];
        let change = step[0].abs() + (step[1] * middle).abs();
        if share == 1.0 && change <= SETTLED * parameters[0].abs() {
            return Ok(parameters);
        }
    }
    Err(Failure::NotConverged)
}

/// The runs that a square root is fitted to.
struct SquareRoot<'a> {
    /// x, o, e and w; where no offset is known, x stands in its place
    columns: [&'a [f64]; 4],
    /// 1 where an offset is known and 0 where not, times which the column of offsets counts
    known: f64,
}

impl<'a> SquareRoot<'a> {
    fn new(sample: &Sample<'a>) -> SquareRoot<'a> {
        let (o, known) = if sample.offset.is_empty() {
            (sample.x, 0.0)
        } else {
            (sample.offset, 1.0)
        };
        SquareRoot {
            columns: [sample.x, o, sample.restitution, sample.weights],
            known,
        }
    }

    /// Gradient g and Hessian h of ½ Σ w (√r − e)²: g0, g1, h00, h01, h11.
    fn gradient_and_hessian(&self, [alpha, beta]: [f64; 2]) -> [f64; 5] {
        sums(self.columns, |[x, o, e, w]| {
            let r = (alpha + beta * x + self.known * o).max(FLOOR);
            // one division for both e/√r and e/(r √r)
            let bend = w * e / (r * r.sqrt());
            let slope = 0.5 * (w - bend * r);
            let bend = 0.25 * bend;
            [slope, slope * x, bend, bend * x, bend * x * x]
        })
    }

    /// The largest share of a step that leads no run more than most of the way to the edge of the domain.
    fn share_inside(&self, [alpha, beta]: [f64; 2], step: [f64; 2]) -> f64 {
        let mut share: f64 = 1.0;
        let [x, o, _, w] = self.columns;
        for run in 0..x.len() {
            let fall = -(step[0] + step[1] * x[run]);
            let room = MOST_OF_THE_WAY * (alpha + beta * x[run] + self.known * o[run]);
            if w[run] > 0.0 && fall > room {
                share = share.min(room / fall);
            }
        }
        share
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::stream;
    use rand::rngs::ChaCha8Rng;
    use rand::RngExt;

    /// Weighted runs that scatter about a law.
    struct Case {
        law: Law,
        x: Vec<f64>,
        offset: Vec<f64>,
        restitution: Vec<f64>,
        weights: Vec<f64>,
        parameters: [f64; 2],
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
            }
        }

        fn sample(&self) -> Sample<'_> {
            Sample {
                offset: &self.offset,
                ..Sample::new(&self.x, &self.restitution, &self.weights)
            }
        }

        /// Gradient and Hessian of ½ Σ w (F − e)², by the law's own statement.
        fn stated(&self, law: Law, parameters: [f64; 2]) -> ([f64; 2], [f64; 3]) {
            let (mut gradient, mut hessian) = ([0.0; 2], [0.0; 3]);
            for (run, (x, weight)) in self.x.iter().zip(&self.weights).enumerate() {
                let offset = self.offset.get(run).copied().unwrap_or(0.0);
                let at = law.response(law.predictor(parameters, *x, offset));
                let residual = at.value - self.restitution[run];
                for (sum, c) in gradient.iter_mut().zip(law.design(*x)) {
                    *sum += weight * residual * at.slope * c;
                }
                for (j, product) in law.design_products(*x).into_iter().enumerate() {
                    hessian[j] += weight * (at.slope * at.slope + residual * at.bend) * product;
                }
            }
            (gradient, hessian)
        }

        /// Newton's step at the fit, as a share of the parameters, by the statement of a law.
        fn step_left(&self, law: Law, fitted: [f64; 2]) -> f64 {
            let (gradient, hessian) = self.stated(law, fitted);
            let steps = law.solve(hessian, gradient).into_iter().zip(fitted);
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
            assert!(case.step_left(law, found) < ROUNDING, "{law:?}: {found:?}");
            // the planted fault: the dry law to the other order
            if law == Law::Dry(Order::Second) {
                assert!(case.step_left(Law::Dry(Order::First), found) > 1e-3);
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
            let ([g0, g1], [h0, h1, h2]) = case.stated(case.law, parameters);
            let found = SquareRoot::new(&case.sample()).gradient_and_hessian(parameters);
            for (found, stated) in found.into_iter().zip([g0, g1, h0, h1, h2]) {
                assert!((found - stated).abs() <= ROUNDING * stated.abs(), "{found} {stated}");
            }
        }
    }
}
