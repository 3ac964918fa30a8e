//! Integrates over noise on the energy that a run keeps, by the trapezoidal rule.
//!
//! Symbols: a run that keeps r + σ_r a would be measured at x = m(r + σ_r a), and was at e = x + s b, s being the spread of all
//! noise on the restitution. Along x its density is ∫ φ(a) f(b)/s da; the probability that it came out on a side of e is
//! ∫ φ(a) F(±b) da, or by parts ∫ F(±a) f(b) db, whichever is the narrower.
//!
//! Of what falls to nothing at both ends the rule of step h is off by exp(−2π d/h), d being how far from the line its nearest
//! pole lies, and of a bell of width w by exp(−2π² w²/h²). m⁻¹ has its poles at τ (±1 ± i).

use pulp::{Arch, Simd, WithSimd};

use super::normal::{ln_normal_cdf_and_slope, CERTAIN};
use super::run_density::{RunDensity, Seen, Side};
use super::run_noise::{MeasuredRun, RunNoise};
use super::tails::Tails;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::exponential::{exponential, is_fused};
use crate::lanes;
use crate::physics::rebound::{kept_and_slope, kept_of_mean_restitution, mean_restitution, TURN};

/// The logarithm falls by this much from its largest value to where the rest is nothing.
const FALL: f64 = 24.0;

/// Nodes taken at once, and what their number is a multiple of, so that registers are filled.
const AT_ONCE: usize = 32;
const LANES: usize = 8;

/// Nodes beyond which parameters are taken to have no density.
const MOST_NODES: f64 = 1e5;

/// A number at each of these nodes.
type Column = [f64; AT_ONCE];

/// The log density or probability of a run that keeps this on average, with its slopes but for those that follow from that in
/// what is kept; no number where parameters have none.
pub(super) fn over_energy(noise: RunNoise, kept: f64, run: &MeasuredRun) -> RunDensity {
    let (e, side) = match run.seen {
        Seen::Rebound(e) => (e, None),
        Seen::On(side, e) | Seen::Measured(side, e) => (e, Some(side)),
    };
    let spread = match run.seen {
        // what sticks is not measured
        Seen::On(..) => noise.sigma,
        Seen::Rebound(_) | Seen::Measured(..) => run.errors.variance(noise.sigma).sqrt(),
    };
    let mut integral = Integral {
        noise,
        kept,
        e,
        spread,
        side,
        by_parts: false,
        ends: [f64::NAN; 2],
        nodes: 0,
    };
    if noise.tails == Tails::Normal && integral.is_certain() {
        return RunDensity::default();
    }
    integral.bound();
    match integral.count_nodes() {
        Some(nodes) => Arch::new().dispatch(Integral { nodes, ..integral }),
        None => RunDensity {
            value: f64::NAN,
            ..RunDensity::default()
        },
    }
}

/// An integral along x.
struct Integral {
    noise: RunNoise,
    /// r
    kept: f64,
    e: f64,
    /// s
    spread: f64,
    /// `None` of a rebound
    side: Option<Side>,
    by_parts: bool,
    ends: [f64; 2],
    nodes: usize,
}

impl Integral {
    /// a at e, and b where a is 0.
    fn apart(&self) -> [f64; 2] {
        let a = (kept_of_mean_restitution(self.e) - self.kept) / self.noise.energy;
        [a, (self.e - mean_restitution(self.kept)) / self.spread]
    }

    /// Whether a run came out on its side whatever the noise.
    fn is_certain(&self) -> bool {
        let is_far = |apart: f64, side: Side| side.sign() * apart > 2.0 * CERTAIN;
        self.side
            .is_some_and(|side| self.apart().iter().all(|apart| is_far(*apart, side)))
    }

    /// Chooses what is integrated, and between which ends.
    fn bound(&mut self) {
        let [a, b] = self.apart();
        // the largest value of what is likely is near 0; of anything else it is as large as with all of it in a or in b at least
        let is_likely = self.side.is_some_and(|side| side.sign() * b > 0.0);
        let fall = if is_likely { 0.0 } else { 0.5 * (a * a).min(b * b) };
        let far = (2.0 * (FALL + fall)).sqrt();
        let by_energy = [-far, far].map(|a| mean_restitution(self.kept + self.noise.energy * a));
        let by_noise = match self.noise.tails {
            Tails::Normal => [-far, far].map(|b| self.e + self.spread * b),
            // which fall too slowly to bound anything
            Tails::Student(_) | Tails::AsymmetricLaplace(_) => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let length = |[lo, hi]: [f64; 2]| hi - lo;
        self.by_parts = self.side.is_some() && length(by_noise) < length(by_energy);
        let by_both = [by_energy[0].max(by_noise[0]), by_energy[1].min(by_noise[1])];
        let [lo, hi] = if self.by_parts { by_noise } else { by_energy };
        // a probability bounds what lies away from its side
        self.ends = match self.side {
            None => by_both,
            Some(side) if (side == Side::Below) == self.by_parts => [by_both[0], hi],
            Some(_) => [lo, by_both[1]],
        };
    }

    /// How many nodes do; `None` where these would be too many.
    fn count_nodes(&self) -> Option<usize> {
        /// of a step, over the distance of the poles of m⁻¹ or of Student's from the line: exp(−2π/0.34) is 1e-8. Of a bell a
        /// step is the width: 2 exp(−2π²) is 5e-9
        const OF_POLES: f64 = 0.34;
        let [lo, hi] = self.ends;
        let (_, steepest) = kept_and_slope(lo.abs().max(hi.abs()));
        let squares = (1.0 / self.spread).powi(2) + (steepest / self.noise.energy).powi(2);
        let mut step = 1.0 / squares.sqrt();
        if lo < TURN && hi > -TURN {
            step = step.min(OF_POLES * TURN);
        }
        if self.noise.tails != Tails::Normal {
            step = step.min(OF_POLES * self.spread);
        }
        let nodes = ((hi - lo) / step).ceil().max(1.0);
        // nor where it is no number
        (nodes <= MOST_NODES).then(|| (nodes as usize).next_multiple_of(LANES))
    }
}

/// Columns of what the nodes of one call have.
#[derive(Default)]
struct AtNodes {
    a: Column,
    b: Column,
    /// da/dx times σ_r
    stretch: Column,
    ln: Column,
    /// slopes of the logarithm in a, b and the shape of the noise
    of_a: Column,
    of_b: Column,
    of_shape: Column,
}

impl WithSimd for Integral {
    type Output = RunDensity;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> RunDensity {
        let fused = is_fused::<S>();
        let step = (self.ends[1] - self.ends[0]) / self.nodes as f64;
        let mut at = AtNodes::default();
        let mut reference = f64::NEG_INFINITY;
        let mut sums = [0.0; 5];
        for first in (0..self.nodes).step_by(AT_ONCE) {
            let count = (self.nodes - first).min(AT_ONCE);
            let from = self.ends[0] + (first as f64 + 0.5) * step;
            self.at_nodes(&mut at, count, [from, step], fused);
            let highest = at.ln[..count].iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if highest > reference {
                let factor = (reference - highest).exp();
                sums.iter_mut().for_each(|sum| *sum *= factor);
                reference = highest;
            }
            let [parts, of_a, of_b] = [&mut at.ln, &mut at.of_a, &mut at.of_b].map(|column| &mut column[..count]);
            let columns = parts.iter_mut().zip(of_a).zip(of_b).zip(&at.stretch[..count]);
            for (((part, of_a), of_b), stretch) in columns {
                *part = stretch * exponential(*part - reference, fused);
                *of_a *= *part;
                *of_b *= *part;
            }
            // of few columns each, so that lanes need not be shuffled
            let product =
                |[one, other]: [&Column; 2]| lanes::sums([&one[..count], &other[..count]], |[x, y]| [x * y])[0];
            let [mass, of_a] = lanes::sums([&at.ln[..count], &at.of_a[..count]], |parts| parts);
            let of_shape = match self.noise.tails {
                Tails::Normal => 0.0,
                Tails::Student(_) | Tails::AsymmetricLaplace(_) => product([&at.ln, &at.of_shape]),
            };
            let more = [
                mass,
                of_a,
                product([&at.of_a, &at.a]),
                product([&at.of_b, &at.b]),
                of_shape,
            ];
            for (sum, more) in sums.iter_mut().zip(more) {
                *sum += more;
            }
        }
        let mass = sums[0];
        let [of_a, of_a_a, of_b_b, shape] = [sums[1], sums[2], sums[3], sums[4]].map(|sum| sum / mass);
        // densities are per unit of r and of e
        let of_energy = f64::from(u8::from(!self.by_parts));
        let of_noise = f64::from(u8::from(self.by_parts || self.side.is_none()));
        let (sigma, energy) = (self.noise.sigma, self.noise.energy);
        let per_energy = if self.by_parts { 1.0 } else { energy };
        let per_noise = if of_noise > 0.0 { self.spread } else { 1.0 };
        RunDensity {
            value: reference + (mass * (step / per_noise / per_energy)).ln() - LN_ROOT_TWO_PI,
            kept: -of_a / energy,
            energy: -(of_a_a + of_energy) / energy,
            sigma: -(of_b_b + of_noise) * sigma / (self.spread * self.spread),
            shape,
            ..RunDensity::default()
        }
    }
}

impl Integral {
    /// Writes what these nodes have, each a step from the last.
    #[inline(always)]
    fn at_nodes(&self, at: &mut AtNodes, count: usize, [from, step]: [f64; 2], fused: bool) {
        let (kept, e, per_energy, per_spread) = (self.kept, self.e, 1.0 / self.noise.energy, 1.0 / self.spread);
        let [a, b, stretch] = [&mut at.a, &mut at.b, &mut at.stretch].map(|column| &mut column[..count]);
        let columns = a.iter_mut().zip(&mut *b).zip(&mut *stretch);
        for (node, ((a, b), stretch)) in columns.enumerate() {
            let x = from + node as f64 * step;
            let (y, slope) = kept_and_slope(x);
            (*a, *b, *stretch) = ((y - kept) * per_energy, (e - x) * per_spread, slope);
        }
        let (a, b) = (&at.a[..count], &at.b[..count]);
        let [ln, of_a, of_b] = [&mut at.ln, &mut at.of_a, &mut at.of_b].map(|column| &mut column[..count]);
        let slopes = ln.iter_mut().zip(of_a).zip(of_b);
        let of_shape = &mut at.of_shape[..count];
        let columns = slopes.zip(a.iter().zip(b));
        match self.side.map(Side::sign) {
            _ if self.noise.tails != Tails::Normal => {
                for ((((ln, of_a), of_b), (a, b)), of_shape) in columns.zip(of_shape) {
                    let noise = match self.side {
                        None => self.noise.tails.ln_density(*b),
                        Some(side) => self.noise.tails.ln_probability_of(side, side.sign() * b),
                    };
                    let sign = self.side.map_or(1.0, Side::sign);
                    (*ln, *of_a, *of_b, *of_shape) = (noise.value - 0.5 * a * a, -a, sign * noise.z, noise.shape);
                }
            }
            None => {
                for (((ln, of_a), of_b), (a, b)) in columns {
                    (*ln, *of_a, *of_b) = (-0.5 * (a * a + b * b) - LN_ROOT_TWO_PI, -a, -b);
                }
            }
            Some(sign) if self.by_parts => {
                at.stretch[..count].fill(1.0);
                for (((ln, of_a), of_b), (a, b)) in columns {
                    let [value, slope] = ln_normal_cdf_and_slope(sign * a, fused);
                    (*ln, *of_a, *of_b) = (value - 0.5 * b * b, sign * slope, -b);
                }
            }
            Some(sign) => {
                for (((ln, of_a), of_b), (a, b)) in columns {
                    let [value, slope] = ln_normal_cdf_and_slope(sign * b, fused);
                    (*ln, *of_a, *of_b) = (value - 0.5 * a * a, -a, sign * slope);
                }
            }
        }
    }
}
