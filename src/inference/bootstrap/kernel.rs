//! Fits the laws to weighted runs in one stream over them, for replicates by the ten thousand.
//!
//! With e ≥ 0 the square root's sum of squares is convex in (α, β): (√r − e)² has the second derivative
//! e/(2 r^(3/2)) ≥ 0 in r, and r is linear in both. Newton's method kept inside the domain then finds the one minimum.

use crate::physics::dry::SECOND_ORDER;

/// What a kernel found; NaN where there is no fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighted {
    /// a, b of the law
    pub parameters: [f64; 2],
    /// entries aa, ab, bb of the covariance with the replicate's own residual variance
    pub covariance: [f64; 3],
}

impl Weighted {
    /// No fit.
    pub const NONE: Weighted = Weighted {
        parameters: [f64::NAN; 2],
        covariance: [f64::NAN; 3],
    };
}

/// Why weighted runs have no fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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

/// k of e = 1 − k s, s = v^(1/5); fails if every weight is on runs without speed.
pub fn dry(sample: &Sample) -> Result<Weighted, Failure> {
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
    Ok(Weighted {
        parameters: [k, 0.0],
        covariance: [variance, 0.0, 0.0],
    })
}

/// k of e = 1 − k s + (3/5) k² s² from a start near it; fails if every weight is on runs without speed, or Newton's method
/// does not settle.
pub fn dry_second_order(sample: &Sample, start: f64) -> Result<Weighted, Failure> {
    const A: f64 = SECOND_ORDER;
    // of runs with y = 1 − e: the squares are a polynomial in k
    let [n, yy, y1, y2, s2, s3, s4] = sums(
        [sample.x, sample.x, sample.restitution, sample.weights],
        |s, _, e, w| {
            let (y, square) = (1.0 - e, s * s);
            let ws2 = w * square;
            [w, w * y * y, w * s * y, ws2 * y, ws2, ws2 * s, ws2 * square]
        },
    );
    if s2 <= 0.0 {
        return Err(Failure::Degenerate);
    }
    let mut k = start;
    for _ in 0..MOST_STEPS {
        // half the slope of the squares in k, and half its slope
        let slope = -y1 + k * (s2 + 2.0 * A * y2) - 3.0 * A * k * k * s3 + 2.0 * A * A * k * k * k * s4;
        let bend = s2 + 2.0 * A * y2 - 6.0 * A * k * s3 + 6.0 * A * A * k * k * s4;
        if bend <= 0.0 {
            return Err(Failure::NotConverged);
        }
        let step = slope / bend;
        k -= step;
        if step.abs() <= SETTLED * k.abs() {
            let left = sample.within + yy - 2.0 * k * y1 + k * k * (s2 + 2.0 * A * y2) - 2.0 * A * k * k * k * s3
                + A * A * k * k * k * k * s4;
            let squares = s2 - 4.0 * A * k * s3 + 4.0 * A * A * k * k * s4;
            return Ok(Weighted {
                parameters: [k, 0.0],
                covariance: [left.max(0.0) / (n - 1.0) / squares, 0.0, 0.0],
            });
        }
    }
    Err(Failure::NotConverged)
}

/// Runs taken at once, so that sums of them need not wait for one another.
const LANES: usize = 4;

/// a, b of e = a − b x; fails if the weighted x do not vary.
pub fn linear(sample: &Sample) -> Result<Weighted, Failure> {
    let (x, e, w) = (sample.x, sample.restitution, sample.weights);
    // about a run inside the data, so that nothing cancels
    let (Some(&x0), Some(&e0)) = (x.get(x.len() / 2), e.get(e.len() / 2)) else {
        return Err(Failure::Degenerate);
    };
    let [n, sx, se, xx, xe, ee] = sums([x, x, e, w], |x, _, e, w| {
        let (x, e) = (x - x0, e - e0);
        let (wx, we) = (w * x, w * e);
        [w, wx, we, wx * x, wx * e, we * e]
    });
    let level = Level::new(n, x0, sx, xx)?;
    let me = se * level.share;
    Ok(level.through(e0 + me, xe - sx * me, sample.within + ee - se * me))
}

/// What weights and abscissae alone say of a linear fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    /// 1 over the sum of the weights: a fit must not wait for divisions
    pub(super) share: f64,
    /// 1 over the degrees of freedom
    freedom: f64,
    /// mean abscissa
    pub(super) centre: f64,
    /// 1 over the squares about it
    spread: f64,
}

impl Level {
    /// From the sum of the weights, and sum and squares of x − x0.
    pub(super) fn new(runs: f64, x0: f64, sx: f64, xx: f64) -> Result<Level, Failure> {
        let share = 1.0 / runs;
        let mean = sx * share;
        let squares = xx - sx * mean;
        // a NaN determines nothing, either
        let determined = squares > SINGULAR * xx.max(f64::MIN_POSITIVE) && runs >= 2.0;
        let level = Level {
            share,
            freedom: 1.0 / (runs - 2.0),
            centre: x0 + mean,
            spread: 1.0 / squares,
        };
        determined.then_some(level).ok_or(Failure::Degenerate)
    }

    /// The line through the mean restitution, from products and squares about the means.
    pub(super) fn through(&self, mean: f64, products: f64, squares: f64) -> Weighted {
        let slope = products * self.spread;
        let variance = (squares - slope * products).max(0.0) * self.freedom;
        let bb = variance * self.spread;
        Weighted {
            parameters: [mean - slope * self.centre, -slope],
            covariance: [
                variance * self.share + self.centre * self.centre * bb,
                self.centre * bb,
                bb,
            ],
        }
    }
}

/// Kept energy below which a run without weight is held, so that its zero weight stays a zero.
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
pub fn square_root(sample: &Sample, start: [f64; 2]) -> Result<Weighted, Failure> {
    if sample.offset.is_empty() {
        newton::<false>(sample, sample.restitution, start)
    } else {
        newton::<true>(sample, sample.offset, start)
    }
}

/// Sums of four columns' terms over the runs.
pub(super) fn sums<const N: usize>(
    [x, o, e, w]: [&[f64]; 4],
    terms: impl Fn(f64, f64, f64, f64) -> [f64; N],
) -> [f64; N] {
    let mut lanes = [[0.0; LANES]; N];
    let chunked = [x, o, e, w].map(|column| column.as_chunks::<LANES>());
    let [xs, os, es, ws] = chunked.map(|(chunks, _)| chunks);
    for (((x, o), e), w) in xs.iter().zip(os).zip(es).zip(ws) {
        for lane in 0..LANES {
            for (sum, term) in lanes.iter_mut().zip(terms(x[lane], o[lane], e[lane], w[lane])) {
                sum[lane] += term;
            }
        }
    }
    let [xs, os, es, ws] = chunked.map(|(_, rest)| rest);
    for (((x, o), e), w) in xs.iter().zip(os).zip(es).zip(ws) {
        for (sum, term) in lanes.iter_mut().zip(terms(*x, *o, *e, *w)) {
            sum[0] += term;
        }
    }
    lanes.map(|sum| sum.iter().sum())
}

fn newton<const OFFSET: bool>(sample: &Sample, o: &[f64], start: [f64; 2]) -> Result<Weighted, Failure> {
    let (x, w) = (sample.x, sample.weights);
    let [mut alpha, mut beta] = start;
    let middle = *x.get(x.len() / 2).ok_or(Failure::Degenerate)?;
    let columns = [x, o, sample.restitution, w];
    let kept = |[alpha, beta]: [f64; 2], x: f64, o: f64| alpha + beta * x + if OFFSET { o } else { 0.0 };
    for _ in 0..MOST_STEPS {
        // gradient g and Hessian h of ½ Σ w (√r − e)²
        let [g0, g1, h0, h1, h2] = sums(columns, |x, o, e, w| {
            let r = kept([alpha, beta], x, o).max(FLOOR);
            // one division for both e/√r and e/(r √r)
            let bend = w * e / (r * r.sqrt());
            let slope = 0.5 * (w - bend * r);
            let bend = 0.25 * bend;
            [slope, slope * x, bend, bend * x, bend * x * x]
        });
        let determinant = h0 * h2 - h1 * h1;
        let determined = determinant > SINGULAR * h0 * h2;
        if !determined {
            return Err(Failure::Degenerate);
        }
        let mut step = [(h1 * g1 - h2 * g0) / determinant, (h1 * g0 - h0 * g1) / determinant];
        // inside the domain: never more than most of the way to its edge
        let beyond = |x: f64, o: f64| -(step[0] + step[1] * x) - MOST_OF_THE_WAY * kept([alpha, beta], x, o);
        let [leaving] = sums(columns, |x, o, _, w| [(w * beyond(x, o)).max(0.0)]);
        let mut share: f64 = 1.0;
        if leaving > 0.0 {
            for run in (0..x.len()).filter(|run| w[*run] > 0.0 && beyond(x[*run], o[*run]) > 0.0) {
                let change = step[0] + step[1] * x[run];
                share = share.min(MOST_OF_THE_WAY * kept([alpha, beta], x[run], o[run]) / -change);
            }
        }
        step = step.map(|s| s * share);
        alpha += step[0];
        beta += step[1];
        let moved = step[0].abs() + (step[1] * middle).abs();
        if share == 1.0 && moved <= SETTLED * alpha.abs() {
            let kept = |x, o| kept([alpha, beta], x, o);
            return Ok(covariance(columns, sample.within, [alpha, beta], kept));
        }
    }
    Err(Failure::NotConverged)
}

/// The delta method's covariance at the minimum: residual variance times (JᵀWJ)⁻¹.
fn covariance(columns: [&[f64]; 4], within: f64, parameters: [f64; 2], kept: impl Fn(f64, f64) -> f64) -> Weighted {
    let [n, squares, j0, j1, j2] = sums(columns, |x, o, e, w| {
        let r = kept(x, o).max(FLOOR);
        let residual = r.sqrt() - e;
        let weight = 0.25 * w / r;
        [w, w * residual * residual, weight, weight * x, weight * x * x]
    });
    let scale = (within + squares) / (n - 2.0) / (j0 * j2 - j1 * j1);
    Weighted {
        parameters,
        covariance: [scale * j2, -scale * j1, scale * j0],
    }
}
