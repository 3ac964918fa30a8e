//! Fits the laws to weighted runs in one stream over them, for replicates by the ten thousand.
//!
//! With e ≥ 0 the square root's sum of squares is convex in (α, β): (√r − e)² has the second derivative
//! e/(2 r^(3/2)) ≥ 0 in r, and r is linear in both. Newton's method kept inside the domain then finds the one minimum.

/// What a kernel found: parameters, and the covariance over the squared residual sd, as (aa, ab, bb).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighted {
    /// a, b of the law
    pub parameters: [f64; 2],
    /// entries aa, ab, bb of the covariance with the replicate's own residual variance
    pub covariance: [f64; 3],
}

/// Below this share of the product of the diagonals a 2 × 2 determinant is rounding.
const SINGULAR: f64 = 1e-12;

/// k of e = 1 − k s, s = v^(1/5); `None` if every weight is on runs without speed.
pub fn dry(s: &[f64], e: &[f64], w: &[f64]) -> Option<Weighted> {
    let (mut ss, mut sy, mut yy, mut n) = (0.0, 0.0, 0.0, 0.0);
    for ((s, e), w) in s.iter().zip(e).zip(w) {
        let y = 1.0 - e;
        ss += w * s * s;
        sy += w * s * y;
        yy += w * y * y;
        n += w;
    }
    if ss <= 0.0 {
        return None;
    }
    let k = sy / ss;
    let variance = (yy - k * sy).max(0.0) / (n - 1.0) / ss;
    Some(Weighted {
        parameters: [k, 0.0],
        covariance: [variance, 0.0, 0.0],
    })
}

/// a, b of e = a − b x; `None` if the weighted x do not vary.
pub fn linear(x: &[f64], e: &[f64], w: &[f64]) -> Option<Weighted> {
    // about a run inside the data, so that nothing cancels
    let (x0, e0) = (*x.get(x.len() / 2)?, *e.get(e.len() / 2)?);
    let (mut n, mut sx, mut se, mut xx, mut xe, mut ee) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for ((x, e), w) in x.iter().zip(e).zip(w) {
        let (x, e) = (x - x0, e - e0);
        n += w;
        sx += w * x;
        se += w * e;
        xx += w * x * x;
        xe += w * x * e;
        ee += w * e * e;
    }
    let (mx, me) = (sx / n, se / n);
    let vxx = xx - sx * mx;
    // a NaN determines nothing, either
    let determined = vxx > SINGULAR * xx.max(f64::MIN_POSITIVE) && n >= 2.0;
    if !determined {
        return None;
    }
    let vxe = xe - sx * me;
    let slope = vxe / vxx;
    let intercept = e0 + me - slope * (x0 + mx);
    let variance = (ee - se * me - slope * vxe).max(0.0) / (n - 2.0);
    let centre = x0 + mx;
    let bb = variance / vxx;
    Some(Weighted {
        parameters: [intercept, -slope],
        covariance: [variance / n + centre * centre * bb, centre * bb, bb],
    })
}

/// Kept energy below which a run without weight is held, so that its zero weight stays a zero.
const FLOOR: f64 = 1e-30;

/// Newton steps before a replicate counts as not converged.
const MOST_STEPS: usize = 60;
/// Relative change of both parameters' contributions at which Newton's next step would be rounding.
const SETTLED: f64 = 1e-13;

/// α, β of e = √(α + β x + o) from a start inside the domain, at which it need not be near the minimum.
///
/// `offset` is empty or one number a run. `None` if the runs with weight do not determine both, or Newton's method does
/// not settle.
pub fn square_root(x: &[f64], offset: &[f64], e: &[f64], w: &[f64], start: [f64; 2]) -> Option<Weighted> {
    let [mut alpha, mut beta] = start;
    let offset_of = |run: usize| if offset.is_empty() { 0.0 } else { offset[run] };
    for _ in 0..MOST_STEPS {
        // gradient g and Hessian h of ½ Σ w (√r − e)²
        let (mut g0, mut g1, mut h0, mut h1, mut h2) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for run in 0..x.len() {
            let r = (alpha + beta * x[run] + offset_of(run)).max(FLOOR);
            let root = r.sqrt();
            let slope = 0.5 * w[run] * (1.0 - e[run] / root);
            let bend = 0.25 * w[run] * e[run] / (r * root);
            g0 += slope;
            g1 += slope * x[run];
            h0 += bend;
            h1 += bend * x[run];
            h2 += bend * x[run] * x[run];
        }
        let determinant = h0 * h2 - h1 * h1;
        let determined = determinant > SINGULAR * h0 * h2;
        if !determined {
            return None;
        }
        let mut step = [(h1 * g1 - h2 * g0) / determinant, (h1 * g0 - h0 * g1) / determinant];
        // inside the domain: never more than most of the way to its edge
        let mut share: f64 = 1.0;
        for run in 0..x.len() {
            let r = alpha + beta * x[run] + offset_of(run);
            let change = step[0] + step[1] * x[run];
            if w[run] > 0.0 && change < 0.0 && -change > 0.9 * r {
                share = share.min(0.9 * r / -change);
            }
        }
        step = step.map(|s| s * share);
        alpha += step[0];
        beta += step[1];
        let moved = step[0].abs() + (step[1] * x[x.len() / 2]).abs();
        if share == 1.0 && moved <= SETTLED * alpha.abs() {
            return covariance(x, offset, e, w, [alpha, beta]);
        }
    }
    None
}

/// The delta method's covariance at the minimum: residual variance times (JᵀWJ)⁻¹.
fn covariance(x: &[f64], offset: &[f64], e: &[f64], w: &[f64], parameters: [f64; 2]) -> Option<Weighted> {
    let [alpha, beta] = parameters;
    let (mut n, mut squares, mut j0, mut j1, mut j2) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for run in 0..x.len() {
        let r = (alpha + beta * x[run] + if offset.is_empty() { 0.0 } else { offset[run] }).max(FLOOR);
        let residual = r.sqrt() - e[run];
        let weight = 0.25 * w[run] / r;
        n += w[run];
        squares += w[run] * residual * residual;
        j0 += weight;
        j1 += weight * x[run];
        j2 += weight * x[run] * x[run];
    }
    let scale = squares / (n - 2.0) / (j0 * j2 - j1 * j1);
    Some(Weighted {
        parameters,
        covariance: [scale * j2, -scale * j1, scale * j0],
    })
}
