//! Holds the nodes of Gauss's rules.

/// Positive nodes of Gauss's rule of order 12 on (−1, 1), each with its weight.
pub(super) const GAUSS: [[f64; 2]; 6] = [
    [0.125_233_408_511_468_9, 0.249_147_045_813_402_8],
    [0.367_831_498_998_180_2, 0.233_492_536_538_354_8],
    [0.587_317_954_286_617_5, 0.203_167_426_723_065_9],
    [0.769_902_674_194_304_7, 0.160_078_328_543_346_2],
    [0.904_117_256_370_474_9, 0.106_939_325_995_318_4],
    [0.981_560_634_246_719_2, 0.047_175_336_386_511_8],
];

/// A Gauss–Hermite rule for the standard normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hermite {
    /// its positive nodes, in order, each with its weight over the standard normal density there and with the orthonormal
    /// Hermite polynomial of a degree one below the number of nodes
    pub pairs: &'static [[f64; 3]],
    /// the largest last coefficient, of the mass: the integral is then off by less than 1e-7
    pub most_of_last: f64,
}

impl Hermite {
    /// The rule of eight nodes.
    pub const EIGHT: Hermite = Hermite {
        pairs: &[
            [0.539_079_811_351_375_2, 1.081228675771996, -0.5788865440839135],
            [1.6365190424351082, 1.121_315_859_898_708, 1.03256469711088],
            [2.802_485_861_287_542, 1.2257732914241648, -3.60183808695513],
            [4.1445471861258945, 1.5159381479120442, 33.31637763122326],
        ],
        most_of_last: 1e-4,
    };

    /// The rule of sixteen nodes.
    pub const SIXTEEN: Hermite = Hermite {
        pairs: &[
            [0.386_760_604_500_557_4, 0.774_105_438_671_272_6, -0.4670095561284675],
            [1.1638291005549648, 0.7812709085330003, 0.6282708642457472],
            [1.9519803457163336, 0.796_510_292_466_864_3, -1.1496865463116694],
            [2.760_245_047_630_702, 0.822_007_779_964_311_7, 2.9326774049780835],
            [3.6008736241715487, 0.862_298_275_845_749_4, -10.900674194737352],
            [4.492955302520012, 0.927_378_566_184_503_8, 63.91368189342793],
            [5.472_225_705_949_343, 1.044_036_971_387_66, -690.862625518613],
            [6.6308781983931295, 1.3249406140780624, 20427.299714857567],
        ],
        most_of_last: 1e-5,
    };

    /// The larger coefficient of an integrand over the normal density in the last two orthonormal Hermite polynomials that
    /// the rule tells apart, from the parts that each pair of nodes, the negative one first, adds to the integral.
    pub fn last_coefficient(self, parts: &[[f64; 2]]) -> f64 {
        let degree = (2 * self.pairs.len() - 1) as f64;
        let (mut odd, mut even) = (0.0, 0.0);
        for ([node, _, last], [below, above]) in self.pairs.iter().zip(parts) {
            odd += last * (above - below);
            // at a node the polynomial of the degree before is this one times x/√degree
            even += last * node * (above + below);
        }
        odd.abs().max(even.abs() / degree.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distributions::LN_ROOT_TWO_PI;

    /// What each pair of nodes adds to the integral of a function times the standard normal density.
    fn parts(rule: Hermite, of: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let pair = |[node, weight, _]: &[f64; 3]| {
            let weight = weight * (-0.5 * node * node - LN_ROOT_TWO_PI).exp();
            [weight * of(-node), weight * of(*node)]
        };
        rule.pairs.iter().map(pair).collect()
    }

    #[test]
    fn the_last_coefficient_is_that_of_the_last_two_polynomials() {
        for rule in [Hermite::EIGHT, Hermite::SIXTEEN] {
            let degree = 2 * rule.pairs.len() as i32 - 1;
            // x to a power has the root of its factorial of the polynomial of that degree, and none of those above
            let root = |power: i32| (1..=power).map(f64::from).product::<f64>().sqrt();
            for power in [degree, degree - 1] {
                let found = rule.last_coefficient(&parts(rule, |x| x.powi(power) / root(power)));
                assert!((found - 1.0).abs() < 1e-12, "{rule:?} {power}: {found}");
            }
            for power in 0..degree - 1 {
                let found = rule.last_coefficient(&parts(rule, |x| x.powi(power) / root(power)));
                assert!(found < 1e-12, "{rule:?} {power}: {found:e}");
            }
        }
    }
}
