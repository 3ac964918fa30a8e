//! Sums the integrands of two normal noises over nodes, several at a time.
//!
//! Symbols as in `convolution.rs`. Lanes are added in one order on every machine.

use pulp::{Arch, Simd, WithSimd};

use crate::exponential::{exponential, is_fused};
use crate::physics::rebound::kept_and_slope;

/// Nodes of one call.
const BATCH: usize = 64;

/// Nodes that are computed side by side.
const LANES: usize = 8;

/// What two normal noises must be for a restitution.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoNoises {
    /// e, or the limit
    pub restitution: f64,
    pub r: f64,
    /// 1/σ
    pub own: f64,
    /// 1/σ_r
    pub of_energy: f64,
}

impl TwoNoises {
    #[inline(always)]
    pub fn at(&self, x: f64) -> NodeAt {
        let (y, stretch) = kept_and_slope(x);
        let a = (y - self.r) * self.of_energy;
        let b = (self.restitution - x) * self.own;
        NodeAt {
            a,
            b,
            stretch,
            square: a * a + b * b,
        }
    }
}

/// What is integrated along the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Integrand {
    /// the density of a rebound: y′ f, and that times a, a² and b²
    Density,
    /// the share of a side by the angle, S dθ with (1 − S) in the place of S, which has no pole at the centre; and f, f a and
    /// f b y′
    AngleWithin,
    /// the same with S
    AngleBeyond,
}

/// A Gauss–Hermite rule for the standard normal: its positive nodes, each with its weight over the density there.
type Hermite<const PAIRS: usize> = [[f64; 2]; PAIRS];

const OF_EIGHT: Hermite<4> = [
    [0.539_079_811_351_375_2, 1.081228675771996],
    [1.6365190424351082, 1.121_315_859_898_708],
    [2.802_485_861_287_542, 1.2257732914241648],
    [4.1445471861258945, 1.5159381479120442],
];

const OF_SIXTEEN: Hermite<8> = [
    [0.386_760_604_500_557_4, 0.774_105_438_671_272_6],
    [1.1638291005549648, 0.7812709085330003],
    [1.9519803457163336, 0.796_510_292_466_864_3],
    [2.760_245_047_630_702, 0.822_007_779_964_311_7],
    [3.6008736241715487, 0.862_298_275_845_749_4],
    [4.492955302520012, 0.927_378_566_184_503_8],
    [5.472_225_705_949_343, 1.044_036_971_387_66],
    [6.6308781983931295, 1.3249406140780624],
];

/// The orthonormal Hermite polynomial of a degree one below the number of nodes, at the positive nodes.
type LastPolynomial<const PAIRS: usize> = [f64; PAIRS];

const LAST_OF_EIGHT: LastPolynomial<4> = [
    -0.5788865440839135,
    1.03256469711088,
    -3.60183808695513,
    33.31637763122326,
];

const LAST_OF_SIXTEEN: LastPolynomial<8> = [
    -0.4670095561284675,
    0.6282708642457472,
    -1.1496865463116694,
    2.9326774049780835,
    -10.900674194737352,
    63.91368189342793,
    -690.862625518613,
    20427.299714857567,
];

/// Nodes of a Gauss–Hermite rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Order {
    Eight,
    Sixteen,
}

impl Order {
    /// Positive nodes, in order, each with its weight over the standard normal density there.
    pub fn pairs(self) -> &'static [[f64; 2]] {
        match self {
            Order::Eight => &OF_EIGHT,
            Order::Sixteen => &OF_SIXTEEN,
        }
    }

    /// The orthonormal Hermite polynomial of a degree one below the number of nodes, at the positive nodes.
    pub fn last_polynomial(self) -> &'static [f64] {
        match self {
            Order::Eight => &LAST_OF_EIGHT,
            Order::Sixteen => &LAST_OF_SIXTEEN,
        }
    }

    /// The larger coefficient of an integrand over the normal density in the last two orthonormal Hermite polynomials that
    /// the rule tells apart, from the parts that each pair of nodes, the negative one first, adds to the integral.
    pub fn last_coefficient(self, parts: &[[f64; 2]]) -> f64 {
        let last = self.last_polynomial();
        let degree = (2 * last.len() - 1) as f64;
        let (mut odd, mut even) = (0.0, 0.0);
        for (([node, _], last), [below, above]) in self.pairs().iter().zip(last).zip(parts) {
            odd += last * (above - below);
            // at a node the polynomial of the degree before is this one times x/√degree
            even += last * node * (above + below);
        }
        odd.abs().max(even.abs() / degree.sqrt())
    }
}

/// The sums of [`Integrand::Density`] by the Gauss–Hermite rule about a place, with a width.
pub(super) fn hermite_sums(noises: TwoNoises, reference: f64, (x, width): (f64, f64), order: Order) -> [f64; 4] {
    let (mut places, mut weights) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
    let pairs = order.pairs();
    for (pair, [node, weight]) in pairs.iter().enumerate() {
        (places[2 * pair], places[2 * pair + 1]) = (x - width * node, x + width * node);
        (weights[2 * pair], weights[2 * pair + 1]) = (width * weight, width * weight);
    }
    let count = 2 * pairs.len();
    #[cfg(test)]
    super::tests::nodes::count(count);
    Arch::new().dispatch(Densities(Batch {
        noises,
        reference,
        x: &places[..count],
        weight: &weights[..count],
    }))
}

/// Nodes of a rule with their weights, gathered until there are enough of them.
pub(super) struct NormalNodes {
    noises: TwoNoises,
    integrand: Integrand,
    /// the logarithm that all exponentials are divided by
    reference: f64,
    x: [f64; BATCH],
    weight: [f64; BATCH],
    count: usize,
    sums: [f64; 4],
}

impl NormalNodes {
    pub fn new(noises: TwoNoises, integrand: Integrand, reference: f64) -> NormalNodes {
        NormalNodes {
            noises,
            integrand,
            reference,
            x: [0.0; BATCH],
            weight: [0.0; BATCH],
            count: 0,
            sums: [0.0; 4],
        }
    }

    #[inline(always)]
    pub fn add(&mut self, x: f64, weight: f64) {
        (self.x[self.count], self.weight[self.count]) = (x, weight);
        self.count += 1;
        if self.count == BATCH {
            self.flush();
        }
    }

    /// The sums over all nodes.
    pub fn finish(mut self) -> [f64; 4] {
        self.flush();
        self.sums
    }

    fn flush(&mut self) {
        if self.count == 0 {
            return;
        }
        #[cfg(test)]
        super::tests::nodes::count(self.count);
        let filled = self.count.next_multiple_of(LANES);
        let last = self.x[self.count - 1];
        for place in self.count..filled {
            (self.x[place], self.weight[place]) = (last, 0.0);
        }
        let batch = Batch {
            noises: self.noises,
            reference: self.reference,
            x: &self.x[..filled],
            weight: &self.weight[..filled],
        };
        let arch = Arch::new();
        let sums = match self.integrand {
            Integrand::Density => arch.dispatch(Densities(batch)),
            Integrand::AngleWithin => arch.dispatch(Angles::<true>(batch)),
            Integrand::AngleBeyond => arch.dispatch(Angles::<false>(batch)),
        };
        for (all, sum) in self.sums.iter_mut().zip(sums) {
            *all += sum;
        }
        self.count = 0;
    }
}

struct Batch<'n> {
    noises: TwoNoises,
    reference: f64,
    x: &'n [f64],
    weight: &'n [f64],
}

impl Batch<'_> {
    /// Sums four terms of every node; `terms` are those at (a, b, y′, ρ²) with a weight.
    #[inline(always)]
    fn sum(&self, terms: impl Fn(NodeAt, f64) -> [f64; 4]) -> [f64; 4] {
        let noises = self.noises;
        let mut lanes = [[0.0; LANES]; 4];
        for (x, weight) in self.x.chunks_exact(LANES).zip(self.weight.chunks_exact(LANES)) {
            for lane in 0..LANES {
                let found = terms(noises.at(x[lane]), weight[lane]);
                for (sums, term) in lanes.iter_mut().zip(found) {
                    sums[lane] += term;
                }
            }
        }
        lanes.map(|sums| sums.iter().sum())
    }
}

/// What a node has, y′ and ρ² besides.
#[derive(Clone, Copy)]
pub(super) struct NodeAt {
    a: f64,
    b: f64,
    stretch: f64,
    square: f64,
}

impl NodeAt {
    /// The terms of [`Integrand::Density`].
    #[inline(always)]
    pub fn density(&self, weight: f64, reference: f64, fused: bool) -> [f64; 4] {
        let part = weight * self.stretch * exponential(-0.5 * self.square - reference, fused);
        [part, part * self.a, part * self.a * self.a, part * self.b * self.b]
    }
}

struct Densities<'n>(Batch<'n>);

impl WithSimd for Densities<'_> {
    type Output = [f64; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 4] {
        let reference = self.0.reference;
        self.0.sum(|at, weight| at.density(weight, reference, is_fused::<S>()))
    }
}

struct Angles<'n, const WITHIN: bool>(Batch<'n>);

impl<const WITHIN: bool> WithSimd for Angles<'_, WITHIN> {
    type Output = [f64; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 4] {
        /// ρ² below which 1 − S is taken from its series
        const CENTRE: f64 = 1e-3;
        let noises = self.0.noises;
        let reference = self.0.reference;
        self.0.sum(|at, weight| {
            let beyond = exponential(-0.5 * at.square - reference, is_fused::<S>());
            let turned = weight * (-at.a * noises.own - at.b * at.stretch * noises.of_energy);
            let share = if WITHIN {
                let half = 0.5 * at.square;
                let series = 0.5 * (1.0 - half * (0.5 - half * (1.0 / 6.0 - half / 24.0)));
                let far = (1.0 - beyond) / at.square;
                if at.square < CENTRE {
                    series
                } else {
                    far
                }
            } else {
                beyond / at.square
            };
            let density = weight * beyond;
            [share * turned, density, density * at.a, density * at.b * at.stretch]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distributions::LN_ROOT_TWO_PI;

    /// What each pair of nodes adds to the integral of a function times the standard normal density.
    fn parts(order: Order, of: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let pair = |[node, weight]: &[f64; 2]| {
            let weight = weight * (-0.5 * node * node - LN_ROOT_TWO_PI).exp();
            [weight * of(-node), weight * of(*node)]
        };
        order.pairs().iter().map(pair).collect()
    }

    #[test]
    fn the_last_coefficient_is_that_of_the_last_two_polynomials() {
        for order in [Order::Eight, Order::Sixteen] {
            let degree = 2 * order.pairs().len() as i32 - 1;
            // x to a power has the root of its factorial of the polynomial of that degree, and none of those above
            let root = |power: i32| (1..=power).map(f64::from).product::<f64>().sqrt();
            for power in [degree, degree - 1] {
                let found = order.last_coefficient(&parts(order, |x| x.powi(power) / root(power)));
                assert!((found - 1.0).abs() < 1e-12, "{order:?} {power}: {found}");
            }
            for power in 0..degree - 1 {
                let found = order.last_coefficient(&parts(order, |x| x.powi(power) / root(power)));
                assert!(found < 1e-12, "{order:?} {power}: {found:e}");
            }
        }
    }
}
