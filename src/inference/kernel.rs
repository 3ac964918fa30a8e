//! Holds a law with its runs, and fits it to them in one stream: replicates by the ten thousand, and starts of other fits.
//!
//! With e ≥ 0 the square root's sum of squares is convex in (α, β): (√r − e)² has the second derivative
//! e/(2 r^(3/2)) ≥ 0 in r, and r is linear in both. Newton's method, held inside the domain, then finds the one minimum.

use super::law::{Law, Response};
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

/// A law and the runs it is fitted to, one number a run in every column.
#[derive(Debug, Clone, Copy)]
pub struct Regression<'a> {
    /// the law
    pub law: Law,
    /// abscissae
    pub x: &'a [f64],
    /// known offsets; empty for none
    pub offset: &'a [f64],
    /// restitutions
    pub restitution: &'a [f64],
    /// how many runs each stands for, or its weight; empty where that is itself
    pub counts: &'a [f64],
}

impl<'a> Regression<'a> {
    /// A law without offset.
    pub fn new(law: Law, x: &'a [f64], restitution: &'a [f64]) -> Regression<'a> {
        Regression {
            law,
            x,
            offset: &[],
            restitution,
            counts: &[],
        }
    }

    /// The same with these counts or weights.
    pub fn weighted(self, counts: &'a [f64]) -> Regression<'a> {
        Regression { counts, ..self }
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

/// Fits a law to runs, each weighed by its count, by Newton's method from a start inside its domain: of the dry law to second
/// order from near the fit, of the others from anywhere.
///
/// Fails if the runs with weight do not determine the parameters, or Newton's method does not settle.
pub fn fit(sample: &Regression, start: [f64; 2]) -> WeightedFit {
    let law = sample.law;
    let middle = *sample.x.get(sample.x.len() / 2).ok_or(Failure::Degenerate)?;
    let mut parameters = start;
    for _ in 0..MOST_STEPS {
        let [g0, g1, h0, h1, h2] = gradient_and_hessian(sample, parameters);
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
fn gradient_and_hessian(sample: &Regression, parameters: [f64; 2]) -> [f64; 5] {
    // each law a loop of its own without a choice in it
    match sample.law {
        Law::Dry(Order::First) => sums_of(Law::Dry(Order::First), sample, parameters),
        Law::Dry(Order::Second) => sums_of(Law::Dry(Order::Second), sample, parameters),
        Law::Wet(WetLaw::Linear) => sums_of(Law::LINEAR, sample, parameters),
        Law::Wet(WetLaw::Sqrt) => sums_of(Law::SQUARE_ROOT, sample, parameters),
    }
}

/// The known offsets and 1; where none is known a column in their place and 0, times which it counts.
fn offsets<'a>(sample: &Regression<'a>) -> (&'a [f64], f64) {
    match sample.offset {
        [] => (sample.x, 0.0),
        known => (known, 1.0),
    }
}

#[inline(always)]
fn sums_of(law: Law, sample: &Regression, parameters: [f64; 2]) -> [f64; 5] {
    let lowest = match law {
        Law::Wet(WetLaw::Sqrt) => FLOOR,
        Law::Dry(_) | Law::Wet(WetLaw::Linear) => f64::NEG_INFINITY,
    };
    let (offset, known) = offsets(sample);
    sums([sample.x, offset, sample.restitution, sample.counts], |[x, o, e, w]| {
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
fn share_inside(sample: &Regression, parameters: [f64; 2], step: [f64; 2]) -> f64 {
    let law = Law::SQUARE_ROOT;
    let (offset, known) = offsets(sample);
    let mut share: f64 = 1.0;
    for ((x, o), w) in sample.x.iter().zip(offset).zip(sample.counts) {
        let fall = -law.predictor(step, *x, 0.0);
        let room = MOST_OF_THE_WAY * law.predictor(parameters, *x, known * o);
        if *w > 0.0 && fall > room {
            share = share.min(room / fall);
        }
    }
    share
}
