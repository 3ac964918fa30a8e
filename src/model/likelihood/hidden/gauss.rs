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

/// Nodes of [`HERMITE`], both signs.
pub(super) const HERMITE_NODES: usize = 2 * HERMITE.len();

/// Positive nodes of the Gauss–Hermite rule of order 16 for the standard normal, in order, each with its weight over the standard
/// normal density there and with the orthonormal Hermite polynomial of degree 15.
pub(super) const HERMITE: [[f64; 3]; 8] = [
    [0.386_760_604_500_557_4, 0.774_105_438_671_272_6, -0.4670095561284675],
    [1.1638291005549648, 0.7812709085330003, 0.6282708642457472],
    [1.9519803457163336, 0.796_510_292_466_864_3, -1.1496865463116694],
    [2.760_245_047_630_702, 0.822_007_779_964_311_7, 2.9326774049780835],
    [3.6008736241715487, 0.862_298_275_845_749_4, -10.900674194737352],
    [4.492955302520012, 0.927_378_566_184_503_8, 63.91368189342793],
    [5.472_225_705_949_343, 1.044_036_971_387_66, -690.862625518613],
    [6.6308781983931295, 1.3249406140780624, 20427.299714857567],
];

/// Whether the rule is off by less than 1e-7, from the parts that each pair of nodes, the negative one first, adds to the
/// integral: its coefficients in the last two orthonormal Hermite polynomials that the rule tells apart are small beside it.
pub(super) fn has_converged(parts: &[[f64; 2]]) -> bool {
    is_small(last_sums(parts), parts.iter().flatten().sum())
}

/// The same from [`last_sums`] and the mass.
#[inline(always)]
pub(super) fn is_small(last_sums: [f64; 2], mass: f64) -> bool {
    const MOST_OF_LAST: f64 = 1e-5;
    last_coefficient(last_sums) < MOST_OF_LAST * mass
}

/// Σ h (a − b) and Σ h x (a + b) over pairs of parts b below and a above, with the polynomial h of degree 15 at their node x.
fn last_sums(parts: &[[f64; 2]]) -> [f64; 2] {
    let (mut odd, mut even) = (0.0, 0.0);
    for ([node, _, last], [below, above]) in HERMITE.iter().zip(parts) {
        odd += last * (above - below);
        even += last * node * (above + below);
    }
    [odd, even]
}

/// The larger of the last two coefficients: at a node the polynomial of degree 14 is the last one times x/√15.
fn last_coefficient([odd, even]: [f64; 2]) -> f64 {
    odd.abs().max(even.abs() / ((HERMITE_NODES - 1) as f64).sqrt())
}
