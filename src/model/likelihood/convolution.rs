//! Integrates over what a run keeps, where noise acts on the energy kept beside noise on e: e* = m(r + σ_r z′) + σ z.
//!
//! Symbols: x = m(y), the restitution of an energy kept y; a = (y − r)/σ_r and b = (e − x)/σ, what the two noises must be
//! for e; ρ² = a² + b²; f the density of (z′, z), which depends on ρ alone, S the probability of lying beyond ρ.
//!
//! A rebound has the density ∫ f(a, b) y′(x) dx/(σ σ_r). A run sticks where (z′, z) lies on one side of the curve
//! x ↦ (a, b) at e = the limit; by Green's theorem the probability of that is (1/2π) ∫ S dθ along the curve, θ being the
//! angle about the centre, and one more where the centre lies on that side. Near the centre ½ − (1/2π) ∫ (1 − S) dθ, which
//! is the same, has no pole. Slopes in r, σ and σ_r are integrals of f along the same curve.
//!
//! In x the integrand is smooth but for the turn of m, which is τ wide: Gauss's rule on panels that are short beside the
//! integrand's width and split at the turn, so that a slope of the sum is the sum of slopes to the rule's own error, and
//! the nodes may move with the parameters. Far from the turn the trapezoidal rule, which is exact to the same digits
//! where an integrand has vanished at both ends.

mod side_by_side;

pub(super) use side_by_side::{ln_densities, MOST_REBOUNDS};

use super::normal_nodes::{hermite_sums, Integrand, NormalNodes, Order, TwoNoises};
use super::run_density::{Side, Spreads};
use super::tails::{Radial, Tails};
use crate::physics::rebound::{kept_and_slope, mean_restitution, TURN};

/// The log density of a rebound, or the log probability of a side of the limit, with its slopes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Convolved {
    pub value: f64,
    /// in r
    pub kept: f64,
    /// in σ
    pub sigma: f64,
    /// in σ_r
    pub energy: f64,
    /// in ν
    pub nu: f64,
}

/// Positive nodes of Gauss's rule of order 12 on (−1, 1), each with its weight.
pub(super) const GAUSS: [[f64; 2]; 6] = [
    [0.125_233_408_511_468_9, 0.249_147_045_813_402_8],
    [0.367_831_498_998_180_2, 0.233_492_536_538_354_8],
    [0.587_317_954_286_617_5, 0.203_167_426_723_065_9],
    [0.769_902_674_194_304_7, 0.160_078_328_543_346_2],
    [0.904_117_256_370_474_9, 0.106_939_325_995_318_4],
    [0.981_560_634_246_719_2, 0.047_175_336_386_511_8],
];

/// Panels beyond which parameters are taken to have no density.
pub(super) const MOST_PANELS: usize = 20_000;

/// A run of one setting as seen from a restitution.
#[derive(Debug, Clone, Copy)]
struct Curve {
    /// e, or the limit
    restitution: f64,
    r: f64,
    /// 1/σ
    own: f64,
    /// 1/σ_r
    of_energy: f64,
    radial: Radial,
}

/// A point of the curve.
#[derive(Debug, Clone, Copy)]
struct CurvePoint {
    a: f64,
    b: f64,
    /// y′
    stretch: f64,
    /// ρ²
    square: f64,
}

/// Where the curve comes nearest to the centre, about.
#[derive(Debug, Clone, Copy)]
struct Nearest {
    x: f64,
    /// ρ²
    square: f64,
}

/// A density that is all but normal in x.
#[derive(Debug, Clone, Copy)]
struct Bell {
    x: f64,
    /// standard deviation
    width: f64,
    /// its logarithm at x, but for constants
    reference: f64,
    /// of the rule that it takes
    order: Order,
}

/// Steps of Gauss–Newton's from e, by which a bell is found or there is none.
const BELL_STEPS: usize = 4;

/// Of a width, that the place of a bell may be off.
const OFF_THE_PLACE: f64 = 0.1;

/// A step of Gauss–Newton's.
#[derive(Debug, Clone, Copy)]
struct TowardsBell {
    step: f64,
    /// of x, before the step
    variance: f64,
    /// the logarithm before the step, but for constants
    reference: f64,
}

impl TowardsBell {
    #[inline(always)]
    fn is_near(&self) -> bool {
        self.step * self.step < OFF_THE_PLACE * OFF_THE_PLACE * self.variance
    }
}

/// A range of x.
#[derive(Debug, Clone, Copy)]
struct Range {
    lo: f64,
    hi: f64,
}

/// Log density of a rebound that keeps r on average.
pub(super) fn ln_density(tails: Tails, restitution: f64, r: f64, spreads: Spreads) -> Convolved {
    let curve = Curve::new(tails, restitution, r, spreads);
    if let Some(bell) = curve.bell() {
        let sums = hermite_sums(curve.noises(), bell.reference, (bell.x, bell.width), bell.order);
        return curve.density(sums, bell.reference, 0.0);
    }
    let nearest = curve.nearest();
    let reference = curve.radial.ln_beyond(nearest.square);
    let mut of_nu = 0.0;
    let sums = match curve.radial {
        Radial::Normal => curve.over_normal(Integrand::Density, reference, (curve.range(nearest), nearest)),
        Radial::Student { .. } => {
            let range = curve.range(nearest);
            let mut sums = [0.0; 5];
            let mut add = |x: f64, weight: f64| {
                let at = curve.at(x);
                let beyond = (curve.radial.ln_beyond(at.square) - reference).exp();
                let over = curve.radial.density_over_beyond(at.square);
                let part = weight * at.stretch * beyond * over;
                // d ln f/d(ρ²/2)
                let falls = curve.falls(at.square);
                sums[0] += part;
                sums[1] += part * falls * at.a;
                sums[2] += part * falls * at.a * at.a;
                sums[3] += part * falls * at.b * at.b;
                sums[4] +=
                    part * (curve.radial.ln_beyond_nu(at.square) + curve.radial.ln_density_over_beyond_nu(at.square));
            };
            curve.over_panels(range, nearest, STUDENT_WIDTHS, &mut add);
            of_nu = sums[4];
            [sums[0], sums[1], sums[2], sums[3]]
        }
    };
    curve.density(sums, reference, of_nu)
}

/// Log probability that a run which keeps r on average comes out on a side of the limit.
pub(super) fn ln_probability(tails: Tails, side: Side, limit: f64, r: f64, spreads: Spreads) -> Convolved {
    /// nearer to the centre than this the form without a pole is as accurate as the other
    const NEAR: f64 = 4.0;
    let curve = Curve::new(tails, limit, r, spreads);
    let nearest = curve.nearest();
    // the centre lies on the side of what sticks
    let sticks = mean_restitution(r) <= limit;
    let inside = sticks == (side == Side::Below);
    if inside && curve.radial.ln_beyond(nearest.square) < -50.0 {
        return Convolved::default();
    }
    let near = nearest.square < NEAR;
    let range = curve.range(nearest);
    let reference = if near {
        0.0
    } else {
        curve.radial.ln_beyond(nearest.square)
    };
    let angle = if near {
        Integrand::AngleWithin
    } else {
        Integrand::AngleBeyond
    };
    let (sums, of_nu) = match curve.radial {
        Radial::Normal => (curve.over_normal(angle, reference, (range, nearest)), 0.0),
        Radial::Student { .. } => curve.over_student_angles(range, nearest, (near, reference)),
    };
    let [mass, of_r, of_energy, of_own] = sums;
    let turn = std::f64::consts::TAU;
    // of what sticks, times e^−reference
    let below = if near {
        0.5 - (curve.angles_outside(range) + mass) / turn
    } else {
        mass / turn
    };
    let sign = side.sign();
    let (value, share) = if near {
        let own = if sign > 0.0 { below } else { 1.0 - below };
        (own.ln(), sign / own)
    } else if inside {
        let other = sign * below * reference.exp();
        (other.ln_1p(), sign * reference.exp() / (1.0 + other))
    } else {
        let own = sign * below;
        (own.ln() + reference, 1.0 / below)
    };
    let slope = share / turn;
    Convolved {
        value,
        kept: -slope * of_r * curve.own * curve.of_energy,
        sigma: -slope * of_own * curve.own * curve.of_energy,
        energy: -slope * of_energy * curve.own * curve.of_energy,
        nu: slope * of_nu,
    }
}

/// Widths of the integrand that a panel may have where a pole lies two widths from the curve, as of S/ρ².
const WIDTHS_TO_A_POLE: f64 = 3.2;

/// Gauss's rule of order 12 has 1e-9 of a normal density over so many standard deviations.
const WIDTHS: f64 = 5.0;

/// Far enough from the turn that y is x |x| to rounding's eye.
const CLEAR: f64 = 6.0 * TURN;

/// Student's has a pole about one width from the curve.
const STUDENT_WIDTHS: f64 = 2.0;

impl Curve {
    fn new(tails: Tails, restitution: f64, r: f64, spreads: Spreads) -> Curve {
        Curve {
            restitution,
            r,
            own: 1.0 / spreads.sigma,
            of_energy: 1.0 / spreads.energy,
            radial: tails.radial(),
        }
    }

    #[inline(always)]
    fn at(&self, x: f64) -> CurvePoint {
        let (y, stretch) = kept_and_slope(x);
        let a = (y - self.r) * self.of_energy;
        let b = (self.restitution - x) * self.own;
        CurvePoint {
            a,
            b,
            stretch,
            square: a * a + b * b,
        }
    }

    fn noises(&self) -> TwoNoises {
        TwoNoises {
            restitution: self.restitution,
            r: self.r,
            own: self.own,
            of_energy: self.of_energy,
        }
    }

    /// −2 d ln f/dρ².
    #[inline(always)]
    fn falls(&self, square: f64) -> f64 {
        match self.radial {
            Radial::Normal => 1.0,
            Radial::Student { nu, steepness, .. } => (nu + 2.0) * steepness / (1.0 + steepness * square),
        }
    }

    /// Gauss–Newton's steps from the better of the two places where one noise is nought.
    fn nearest(&self) -> Nearest {
        /// a few do but for restitutions hundreds of spreads off
        const STEPS: usize = 100;
        let of = |x: f64| (x, self.at(x));
        let (one, other) = (of(self.restitution), of(mean_restitution(self.r)));
        let (mut x, mut at) = if one.1.square < other.1.square { one } else { other };
        let mut share = 1.0;
        for _ in 0..STEPS {
            let slope = at.stretch * self.of_energy;
            let step = (at.b * self.own - at.a * slope) / (self.own * self.own + slope * slope);
            let next = of(x + share * step);
            if next.1.square < at.square {
                let gained = at.square - next.1.square;
                (x, at) = next;
                share = (2.0f64 * share).min(1.0);
                if gained < 1e-2 {
                    break;
                }
            } else if step.abs() * self.own.hypot(slope) < 1e-2 {
                break;
            } else {
                share *= 0.5;
            }
        }
        Nearest { x, square: at.square }
    }

    /// The x beyond which nothing is left of the integrand.
    fn range(&self, nearest: Nearest) -> Range {
        let far = self.radial.farthest(nearest.square).sqrt();
        let (own, energy) = (far / self.own, far / self.of_energy);
        Range {
            lo: (self.restitution - own).max(mean_restitution(self.r - energy)),
            hi: (self.restitution + own).min(mean_restitution(self.r + energy)),
        }
    }

    /// The angle that the curve turns by before and after a range at whose ends it is far from the centre, which it passes
    /// near: it comes from π and goes to 0.
    fn angles_outside(&self, range: Range) -> f64 {
        let angle = |x: f64| {
            let at = self.at(x);
            at.b.atan2(at.a)
        };
        let (first, last) = (angle(range.lo), angle(range.hi));
        // past π, not short of −π
        let first = if first < -0.5 * std::f64::consts::FRAC_PI_2 {
            first + std::f64::consts::TAU
        } else {
            first
        };
        first - std::f64::consts::PI - last
    }

    /// The log density from its sums.
    fn density(&self, [mass, of_r, of_energy, of_own]: [f64; 4], reference: f64, of_nu: f64) -> Convolved {
        let means = [of_r / mass, of_energy / mass, of_own / mass];
        Convolved {
            nu: of_nu / mass,
            ..self.density_of_means(reference + mass.ln() + self.ln_scale(), means)
        }
    }

    /// The same from its logarithm and the means of a, a² and b² over the integrand.
    #[inline(always)]
    fn density_of_means(&self, value: f64, [of_r, of_energy, of_own]: [f64; 3]) -> Convolved {
        Convolved {
            value,
            kept: of_r * self.of_energy,
            sigma: (of_own - 1.0) * self.own,
            energy: (of_energy - 1.0) * self.of_energy,
            nu: 0.0,
        }
    }

    /// ln of what the integral over x of y′ exp(−ρ²/2) is to be multiplied by.
    fn ln_scale(&self) -> f64 {
        (self.own * self.of_energy / std::f64::consts::TAU).ln()
    }

    /// Where a density that is all but normal in x is largest: the turn is far beside its width, and y hardly bends over that.
    ///
    /// A Gauss–Hermite rule of a few nodes then does. `None` where it is not so.
    #[inline(always)]
    fn bell(&self) -> Option<Bell> {
        if self.radial != Radial::Normal || self.restitution < CLEAR {
            return None;
        }
        let mut x = self.restitution;
        for _ in 0..BELL_STEPS {
            let towards = self.towards_bell(x);
            if towards.is_near() {
                return self.bell_at(x, towards);
            }
            x += towards.step;
        }
        None
    }

    /// A step towards where a density is largest that is all but normal.
    #[inline(always)]
    fn towards_bell(&self, x: f64) -> TowardsBell {
        // so far from the turn y is x² but for τ⁴/(2 x²)
        let a = (x * x - self.r) * self.of_energy;
        let b = (self.restitution - x) * self.own;
        let slope = 2.0 * x * self.of_energy;
        let variance = 1.0 / (self.own * self.own + slope * slope);
        TowardsBell {
            step: (b * self.own - a * slope) * variance,
            variance,
            reference: -0.5 * (a * a + b * b),
        }
    }

    /// The bell about an x from which the next step is short.
    #[inline(always)]
    fn bell_at(&self, x: f64, towards: TowardsBell) -> Option<Bell> {
        /// of the distance from the turn
        const SHARE: f64 = 0.12;
        /// what y bends by over a width, over σ_r, with nodes that have 2e-8 and 2e-7 of such a density
        const BEND: [(f64, Order); 2] = [(0.012, Order::Eight), (0.04, Order::Sixteen)];
        let TowardsBell {
            variance, reference, ..
        } = towards;
        let of_turn = 0.5 * TURN * TURN * TURN * TURN * self.of_energy;
        let clear = x > CLEAR && variance < SHARE * SHARE * x * x && of_turn < OFF_THE_PLACE * x * x;
        let bend = variance * self.of_energy;
        let order = BEND.into_iter().find(|(most, _)| clear && bend < *most);
        order.map(|(_, order)| Bell {
            order,
            x,
            width: variance.sqrt(),
            reference,
        })
    }

    /// Sums over nodes with normal noise.
    fn over_normal(&self, integrand: Integrand, reference: f64, (range, nearest): (Range, Nearest)) -> [f64; 4] {
        let mut nodes = NormalNodes::new(self.noises(), integrand, reference);
        let mut add = |x: f64, weight: f64| nodes.add(x, weight);
        let has_pole = integrand == Integrand::AngleBeyond;
        if self.is_plain(range) && integrand == Integrand::Density {
            self.over_steps(range, &mut add);
        } else {
            let widths = if has_pole { WIDTHS_TO_A_POLE } else { WIDTHS };
            self.over_panels(range, nearest, widths, &mut add);
        }
        nodes.finish()
    }

    /// The integrals of a probability with Student's tails.
    fn over_student_angles(&self, range: Range, nearest: Nearest, (near, reference): (bool, f64)) -> ([f64; 4], f64) {
        let mut sums = [0.0; 4];
        let mut of_nu = 0.0;
        let mut add = |x: f64, weight: f64| {
            let at = self.at(x);
            let ln_beyond = self.radial.ln_beyond(at.square) - reference;
            let beyond = ln_beyond.exp();
            let turned = weight * (-at.a * self.own - at.b * at.stretch * self.of_energy);
            let angle = turned / at.square;
            sums[0] += if near {
                // at the very centre its limit, half the density
                if at.square > 0.0 {
                    -ln_beyond.exp_m1() * angle
                } else {
                    0.5 * self.radial.density_over_beyond(0.0) * turned
                }
            } else {
                beyond * angle
            };
            let density = weight * beyond * self.radial.density_over_beyond(at.square);
            sums[1] += density;
            sums[2] += density * at.a;
            sums[3] += density * at.b * at.stretch;
            if at.square > 0.0 {
                of_nu += beyond * self.radial.ln_beyond_nu(at.square) * angle;
            }
        };
        self.over_panels(range, nearest, STUDENT_WIDTHS, &mut add);
        (sums, of_nu)
    }

    /// Whether the range keeps clear of the turn, or the integrand is narrow beside it, and is normal.
    fn is_plain(&self, range: Range) -> bool {
        /// the trapezoidal rule errs by exp(−2π d/h), d being the distance of the poles of m⁻¹, which is τ
        const NARROW: f64 = 0.3 * TURN;
        let is_narrow = || 1.0 / self.own < NARROW;
        self.radial == Radial::Normal && (range.lo > CLEAR || range.hi < -CLEAR || is_narrow())
    }

    fn panel(&self, widths: f64) -> Panel {
        Panel {
            own: self.own,
            of_energy: self.of_energy,
            widths,
        }
    }

    /// The trapezoidal rule with a step of the smallest width.
    #[inline(always)]
    fn over_steps(&self, range: Range, add: &mut impl FnMut(f64, f64)) {
        let length = range.hi - range.lo;
        let panel = self.panel(1.0);
        let width = panel.width(range.hi).min(panel.width(range.lo));
        let steps = (length / width).ceil().max(1.0);
        let step = length / steps;
        // a range of no length known has no steps
        let steps = if steps < MOST_PANELS as f64 { steps as usize } else { 0 };
        for index in 0..steps {
            add(range.lo + (index as f64 + 0.5) * step, step);
        }
    }

    /// Gauss's rule on panels from the turn outwards.
    fn over_panels(&self, range: Range, nearest: Nearest, widths: f64, add: &mut impl FnMut(f64, f64)) {
        // parameters beyond all numbers have no range, and so no density
        if range.lo.is_nan() || range.hi.is_nan() {
            return;
        }
        let inner = 0f64.clamp(range.lo, range.hi.max(range.lo));
        let panel = self.panel(widths);
        for (end, sign) in [(range.lo, -1.0), (range.hi, 1.0)] {
            let mut from = inner;
            // the width falls outwards; where it hardly does, its least is taken for all
            let least = panel.width(end);
            let even = (least * self.own > 0.8).then_some(widths * least);
            for _ in 0..MOST_PANELS {
                let rest = sign * (end - from);
                // also where it is no number
                if rest.is_nan() || rest <= 0.0 {
                    break;
                }
                let mut length = even.map_or_else(|| panel.length(from, sign), |even| even.min(to_the_poles(from)));
                if self.radial != Radial::Normal {
                    // Student's integrand widens with the distance from where it is largest
                    let turn = to_the_poles(from);
                    length = length.max(0.5 * (from - nearest.x).abs()).min(turn);
                }
                length = length.min(rest);
                let (half, middle) = (0.5 * length, from + 0.5 * sign * length);
                for [node, weight] in GAUSS {
                    add(middle - half * node, half * weight);
                    add(middle + half * node, half * weight);
                }
                let next = if length < rest { from + sign * length } else { end };
                if next == from {
                    break;
                }
                from = next;
            }
            // an integral that stops before its end is none
            if sign * (end - from) > 0.0 {
                add(f64::NAN, f64::NAN);
            }
        }
    }
}

/// The longest panel that may begin at x: m⁻¹ has its poles at τ (±1 ± i).
#[inline(always)]
fn to_the_poles(x: f64) -> f64 {
    2.5 * TURN + 2.0 * x.abs()
}

/// How long panels of x may be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Panel {
    /// how much of the integrand's first standard deviation x covers, 1/σ
    pub own: f64,
    /// how much of its second y covers, 1/σ_r
    pub of_energy: f64,
    /// widths of the integrand to a panel
    pub widths: f64,
}

impl Panel {
    /// The change of x that takes the integrand by one standard deviation.
    #[inline(always)]
    pub fn width(&self, x: f64) -> f64 {
        let slope = kept_and_slope(x).1 * self.of_energy;
        1.0 / (self.own * self.own + slope * slope).sqrt()
    }

    /// The length of a panel that begins at x and goes outwards.
    pub fn length(&self, x: f64, sign: f64) -> f64 {
        let turn = to_the_poles(x);
        let mut length = self.widths * self.least_width(x);
        // the width falls outwards: each time from the other side of the length that its far end allows
        for _ in 0..2 {
            length = self.widths * self.least_width(x + sign * length.min(turn));
        }
        length.min(turn)
    }

    /// The width or somewhat less near the turn, sooner: the square of the slope of y is at most τ² + 4 x².
    #[inline(always)]
    fn least_width(&self, x: f64) -> f64 {
        let square = self.of_energy * self.of_energy * (TURN * TURN + 4.0 * x * x);
        1.0 / (self.own * self.own + square).sqrt()
    }
}

#[cfg(test)]
mod tests;
