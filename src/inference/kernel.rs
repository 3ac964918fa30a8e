//! Fits a law to weighted runs in one stream over them: replicates by the ten thousand, and starts of other fits.
//!
//! With e ≥ 0 the square root's sum of squares is convex in (α, β): (√r − e)² has the second derivative
//! e/(2 r^(3/2)) ≥ 0 in r, and r is linear in both. Newton's method, held inside the domain, then finds the one minimum.

use crate::inference::law::{Law, Response};
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

    /// The offsets and 1; where none is known a column in their place and 0, times which it counts.
    fn offsets(&self) -> (&'a [f64], f64) {
        match self.offset {
            [] => (self.x, 0.0),
            known => (known, 1.0),
        }
    }
}

/// Below this share of the product of the diagonals a 2 × 2 determinant is rounding.
const SINGULAR: f64 = 1e-12;
/// Linear predictor below which a run without weight is held, so that its zero weight stays a zero.
const FLOOR: f64 = 1e-30;
/// Newton steps before a replicate counts as not converged.
const MOST_STEPS: usize = 60;
/// Share of the way to the domain's edge a step may take.
const MOST_OF_THE_WAY: f64 = 0.9;
/// Relative change of both parameters' contributions after which Newton's next one, about its square, is rounding.
const SETTLED: f64 = 1e-10;

/// Fits a law to weighted runs by Newton's method from a start inside its domain: of the dry law to second order from near the
/// fit, of the others from anywhere.
///
/// Fails if the runs with weight do not determine the parameters, or Newton's method does not settle.
pub fn fit(law: Law, sample: &Sample, start: [f64; 2]) -> WeightedFit {
    let middle = *sample.x.get(sample.x.len() / 2).ok_or(Failure::Degenerate)?;
    let mut parameters = start;
    for _ in 0..MOST_STEPS {
        let [g0, g1, h0, h1, h2] = gradient_and_hessian(law, sample, parameters);
        let determined = match law.parameters() {
            1 => h0 > 0.0,
            _ => h0 * h2 - h1 * h1 > SINGULAR * h0 * h2,
        };
        // a NaN determines nothing, either
        if !determined {
            return Err(Failure::Degenerate);
        }
        let step = law.solve([h0, h1, h2], [g0, g1]).map(|step| -step);
        let share = match law {
            Law::Wet(WetLaw::Sqrt) => share_inside(sample, parameters, step),
            Law::Dry(_) | Law::Wet(WetLaw::Linear) => 1.0,
        };
        let step = step.map(|step| step * share);
        parameters = [parameters[0] + step[0], parameters[1] + step[1]];
        let change = step[0].abs() + (step[1] * middle).abs();
        // of a straight line one step leaves nothing
        let is_line = matches!(law, Law::Dry(Order::First) | Law::Wet(WetLaw::Linear));
        let settled = is_line || share == 1.0 && change <= SETTLED * parameters[0].abs();
        if settled && change.is_finite() {
            return Ok(parameters);
        }
    }
    Err(Failure::NotConverged)
}

/// Gradient g and Hessian h of ½ Σ w (F − e)²: g0, g1, h00, h01, h11.
fn gradient_and_hessian(law: Law, sample: &Sample, parameters: [f64; 2]) -> [f64; 5] {
    // each law a loop of its own without a choice in it
    match law {
        Law::Dry(Order::First) => sums_of(Law::Dry(Order::First), sample, parameters),
        Law::Dry(Order::Second) => sums_of(Law::Dry(Order::Second), sample, parameters),
        Law::Wet(WetLaw::Linear) => sums_of(Law::LINEAR, sample, parameters),
        Law::Wet(WetLaw::Sqrt) => sums_of(Law::SQUARE_ROOT, sample, parameters),
    }
}

#[inline(always)]
fn sums_of(law: Law, sample: &Sample, parameters: [f64; 2]) -> [f64; 5] {
    let lowest = match law {
        Law::Wet(WetLaw::Sqrt) => FLOOR,
        Law::Dry(_) | Law::Wet(WetLaw::Linear) => f64::NEG_INFINITY,
    };
    let (offset, known) = sample.offsets();
    sums([sample.x, offset, sample.restitution, sample.weights], |[x, o, e, w]| {
        let Response { value, slope, bend } = law.response(law.predictor(parameters, x, known * o).max(lowest));
        let residual = value - e;
        let (gradient, hessian) = (w * residual * slope, w * (slope * slope + residual * bend));
        let [a, b] = law.design(x);
        [
            gradient * a,
            gradient * b,
            hessian * a * a,
            hessian * a * b,
            hessian * b * b,
        ]
    })
}

/// The largest share of a step that leads no run more than most of the way to the edge of the square root's domain.
fn share_inside(sample: &Sample, parameters: [f64; 2], step: [f64; 2]) -> f64 {
    let law = Law::SQUARE_ROOT;
    let (offset, known) = sample.offsets();
    let mut share: f64 = 1.0;
    for ((x, o), w) in sample.x.iter().zip(offset).zip(sample.weights) {
        let fall = -law.predictor(step, *x, 0.0);
        let room = MOST_OF_THE_WAY * law.predictor(parameters, *x, known * o);
        if *w > 0.0 && fall > room {
            share = share.min(room / fall);
        }
    }
    share
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
}
