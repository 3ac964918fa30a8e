//! Looks for noise that grows with the impact speed, 1/St or the restitution, by score tests on squared residuals.
//!
//! The test is Breusch and Pagan's as Koenker studentised it, which does not take the residuals' kurtosis as normal. With
//! u² = (residual/sd)²/(1 − leverage) of each run and x = ln v, ln(1/St) or the fitted e, z = Σ (x − x̄)(u² − ū²) over
//! √(Σ (x − x̄)² · mean (u² − ū²)²) is standard normal where the spread does not go with x; growth is on one side. The
//! factor is that of an sd ∝ exp(b x), a power of v or of 1/St, with b of most likelihood under normal noise. Groups whose
//! spreads differ show here, too, as far as they differ in x: a liquid that scatters more may be one whose 1/St is larger.

use schemars::JsonSchema;
use serde::Serialize;

use super::outliers::OutlierSearch;
use super::rows::{Rows, RunAtFit, RunKind};
use super::scatter::RobustFit;
use super::standard_errors::LEVEL;
use crate::findings::range::range;
use crate::model::likelihood::normal::normal_cdf;

/// Growth that makes the sd at an end of the runs larger than the one sd by more than this matters: a 90 % band of single
/// runs then holds less than 88 % of them there.
///
/// A band of ± 1.645 sds that are too small by c reaches ± 1.645/c of the right ones, and holds 88 % where that is 1.555.
pub const LINE_OF_BANDS: f64 = 1.058;

/// Normal quantile at the edge of a 90 % band.
const EDGE: f64 = 1.644_853_626_951_472_7;

/// Fewer runs than this are not tested.
const LEAST_RUNS: usize = 20;

/// What the spread of runs may grow with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GrowthWith {
    /// v
    ImpactSpeed,
    /// 1/St; not asked of dry runs
    InverseStokes,
    /// e of the fit
    Restitution,
}

impl GrowthWith {
    const ALL: [GrowthWith; 3] = [
        GrowthWith::ImpactSpeed,
        GrowthWith::InverseStokes,
        GrowthWith::Restitution,
    ];

    /// Its name in a sentence.
    pub fn words(self) -> &'static str {
        match self {
            GrowthWith::ImpactSpeed => "the impact speed",
            GrowthWith::InverseStokes => "1/St",
            GrowthWith::Restitution => "the restitution",
        }
    }

    /// What an sd ∝ exp(b x) has for x.
    fn regressor(self, value: f64) -> f64 {
        match self {
            GrowthWith::ImpactSpeed | GrowthWith::InverseStokes => value.ln(),
            GrowthWith::Restitution => value,
        }
    }
}

/// Whether the spread of the runs grows.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct NoiseGrowth {
    /// probability that even noise is said to grow with anything, dry and wet runs together; at most, as the tests share
    /// it evenly
    pub level: f64,
    /// one test of each kind of run against each quantity that varies
    pub tests: Vec<GrowthTest>,
}

impl NoiseGrowth {
    /// The test that chance would hardly pass for the others.
    pub fn strongest(&self) -> Option<&GrowthTest> {
        self.tests.iter().max_by(|a, b| a.z.total_cmp(&b.z))
    }

    /// The strongest growth of each kind of run that is more than chance and matters to bands of single runs.
    pub fn found(&self) -> impl Iterator<Item = &GrowthTest> {
        RunKind::ALL.into_iter().filter_map(|kind| self.found_of(kind))
    }

    /// That of wet runs.
    pub fn of_wet_runs(&self) -> Option<&GrowthTest> {
        self.found_of(RunKind::Wet)
    }

    fn found_of(&self, kind: RunKind) -> Option<&GrowthTest> {
        let of_kind = self.tests.iter().filter(|test| test.of == kind.word());
        let strongest = of_kind.max_by(|a, b| a.z.total_cmp(&b.z))?;
        (strongest.p < self.level && strongest.largest_over_one > LINE_OF_BANDS).then_some(strongest)
    }
}

/// One kind of run against one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct GrowthTest {
    /// `dry` or `wet` runs
    pub of: &'static str,
    /// the quantity
    pub with: GrowthWith,
    /// runs tested
    pub runs: usize,
    /// its smallest and largest value over them; v in m/s
    pub between: [f64; 2],
    /// the score, standard normal where the spread is even
    pub z: f64,
    /// probability of a score so large by chance, times the number of tests
    pub p: f64,
    /// sd at the largest value over that at the smallest
    pub factor: f64,
    /// the larger sd of both ends over the one sd that the intervals take
    pub largest_over_one: f64,
    /// share of the runs that a 90 % band of single runs, made with the one sd, would hold at each end
    pub band_holds: [f64; 2],
}

/// Squared residual of a run, over its expectation, and what it may go with.
struct SquaredResidual {
    kind: RunKind,
    square: f64,
    /// in the order of [`GrowthWith::ALL`]; NaN where there is none
    values: [f64; 3],
}

/// The tests; `None` with too few runs.
pub(super) fn test_growth(rows: &Rows, robust: &RobustFit, sorted: &OutlierSearch) -> Option<NoiseGrowth> {
    let all = squared_residuals(rows, robust, sorted);
    let mut tests = vec![];
    for kind in RunKind::ALL {
        let of_kind: Vec<&SquaredResidual> = all.iter().filter(|one| one.kind == kind).collect();
        if of_kind.len() < LEAST_RUNS {
            continue;
        }
        for (place, with) in GrowthWith::ALL.into_iter().enumerate() {
            let runs = of_kind.iter().map(|one| (one.values[place], one.square)).collect();
            tests.extend(test(kind, with, runs));
        }
    }
    let looks = tests.len() as f64;
    tests.iter_mut().for_each(|test| test.p = (test.p * looks).min(1.0));
    (!tests.is_empty()).then_some(NoiseGrowth { level: LEVEL, tests })
}

/// Those of the runs clear of sticking, without outliers.
fn squared_residuals(rows: &Rows, robust: &RobustFit, sorted: &OutlierSearch) -> Vec<SquaredResidual> {
    /// a run that the fit follows nearly by itself has no residual to speak of
    const LEAST_FREE: f64 = 0.1;
    let fitted = rows.fit(&sorted.sums);
    let of_run = |own: &RunAtFit| {
        let slopes = rows.slopes(own);
        let shift = fitted.shift(&slopes);
        let expected = (1.0 - fitted.leverage(&slopes)).max(LEAST_FREE);
        let run = own.row.run;
        let inverse_stokes = match own.kind {
            RunKind::Dry => f64::NAN,
            RunKind::Wet => rows.runs.inverse_stokes(run),
        };
        SquaredResidual {
            kind: own.kind,
            square: (own.row.residual / own.sd + shift).powi(2) / expected,
            values: [
                rows.runs.impact_speed[run],
                inverse_stokes,
                own.row.model + own.sd * shift,
            ],
        }
    };
    let is_fair = |own: &&RunAtFit| own.clear && !sorted.is_outlying(own.row.run);
    robust.runs.iter().filter(is_fair).map(of_run).collect()
}

/// One test, p not yet shared; `None` where the quantity does not vary, is not positive, or nothing scatters.
fn test(kind: RunKind, with: GrowthWith, runs: Vec<(f64, f64)>) -> Option<GrowthTest> {
    /// a quantity that varies by less tells nothing
    const LEAST_RANGE: f64 = 1e-3;
    let n = runs.len() as f64;
    let [lo, hi] = range(runs.iter().map(|(value, _)| *value))?;
    let range = with.regressor(hi) - with.regressor(lo);
    if range.is_nan() || range < LEAST_RANGE {
        return None;
    }
    let x: Vec<f64> = runs.iter().map(|(value, _)| with.regressor(*value) / range).collect();
    let middle = x.iter().sum::<f64>() / n;
    let one = runs.iter().map(|(_, square)| square).sum::<f64>() / n;
    let centred: Vec<(f64, f64)> = x.iter().zip(&runs).map(|(x, run)| (x - middle, run.1)).collect();
    let score: f64 = centred.iter().map(|(x, square)| x * (square - one)).sum();
    let of_x: f64 = centred.iter().map(|(x, _)| x * x).sum();
    let of_squares = centred.iter().map(|(_, square)| (square - one).powi(2)).sum::<f64>() / n;
    let z = score / (of_x * of_squares).sqrt();
    let [at_middle, slope] = fit_growth(&centred);
    let (from, to) = (with.regressor(lo) / range - middle, with.regressor(hi) / range - middle);
    let over_one = [from, to].map(|x| (at_middle + slope * x).exp() / one.sqrt());
    let holds = over_one.map(|over_one| 1.0 - 2.0 * normal_cdf(-EDGE / over_one));
    let found = GrowthTest {
        of: kind.word(),
        with,
        runs: runs.len(),
        between: [lo, hi],
        z,
        p: normal_cdf(-z),
        factor: slope.exp(),
        largest_over_one: over_one[0].max(over_one[1]),
        band_holds: holds,
    };
    (z.is_finite() && found.largest_over_one.is_finite()).then_some(found)
}

/// a and b of the growth sd = exp(a + b x) of most likelihood under normal noise, of x and squares: Newton's steps on
/// ½ ln mean (u² exp(−2bx)), which is convex in b where x has mean 0.
fn fit_growth(runs: &[(f64, f64)]) -> [f64; 2] {
    const STEPS: usize = 50;
    const LONGEST: f64 = 1.0;
    let mut slope = 0.0;
    let sums = |slope: f64| {
        let of = |sums: [f64; 3], (x, square): &(f64, f64)| {
            let weight = square * (-2.0 * slope * x).exp();
            [sums[0] + weight, sums[1] + weight * x, sums[2] + weight * x * x]
        };
        runs.iter().fold([0.0; 3], of)
    };
    for _ in 0..STEPS {
        let [weight, first, second] = sums(slope);
        let (mean, square) = (first / weight, second / weight);
        let step = (mean / (2.0 * (square - mean * mean))).clamp(-LONGEST, LONGEST);
        if !step.is_finite() {
            break;
        }
        slope += step;
        if step.abs() < 1e-9 {
            break;
        }
    }
    [0.5 * (sums(slope)[0] / runs.len() as f64).ln(), slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_bands_is_where_they_hold_88_percent() {
        let holds = 1.0 - 2.0 * normal_cdf(-EDGE / LINE_OF_BANDS);
        assert!((holds - 0.88).abs() < 5e-4, "{holds}");
    }

    #[test]
    fn the_score_is_that_of_its_formula() {
        // x − x̄ = ∓½, n = 20: z = √n (u²₂ − u²₁)/2 over the sd of u², which is half their distance
        let runs: Vec<(f64, f64)> = (0..20)
            .map(|i| (1.0 + f64::from(i % 2), 1.0 + f64::from(i % 2)))
            .collect();
        let found = test(RunKind::Wet, GrowthWith::Restitution, runs).expect("it varies");
        assert!((found.z - f64::sqrt(20.0)).abs() < 1e-12, "{}", found.z);
        assert!((found.factor - f64::sqrt(2.0)).abs() < 1e-9, "{}", found.factor);
        let constant = vec![(1.0, 1.0); 30];
        assert!(test(RunKind::Dry, GrowthWith::ImpactSpeed, constant).is_none());
    }
}
