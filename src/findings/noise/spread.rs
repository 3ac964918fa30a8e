//! Says how far unequal spreads of the groups carry the standard errors off.

use serde::Serialize;

use super::normal_equations::{JointSolution, NormalEquations};
use super::rows::{Rows, RunKind};
use super::standard_errors::{standard_error_ratios, worst, StandardErrorRatio, LEVEL};
use crate::inference::information::square;
use crate::inference::information::Sums;
use crate::inference::nested::FTest;
use crate::inference::spreads::{median, LEAST_RESIDUALS, SD_OF_MEDIAN_DISTANCE};

/// Spreads of the groups against one spread for all dry and one for all wet runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpreadTest {
    /// Brown and Forsythe's test of equal spreads
    #[serde(flatten)]
    pub test: FTest,
    /// the group with the largest spread, of the kind (dry or wet) whose spreads differ most
    pub widest: GroupSpread,
    /// the one of that kind with the smallest
    pub narrowest: GroupSpread,
    /// what the standard errors lack by it
    pub standard_errors: Vec<StandardErrorRatio>,
}

impl SpreadTest {
    /// The parameter whose standard error lacks most.
    pub fn worst(&self) -> Option<&StandardErrorRatio> {
        worst(&self.standard_errors)
    }
}

/// The spread of one group's runs about the fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupSpread {
    /// name of the particle
    pub particle: String,
    /// D, m, where each diameter has a k of its own
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// name of the liquid; `None` for dry runs
    pub liquid: Option<String>,
    /// film ratio; `None` for dry runs
    pub film_ratio: Option<f64>,
    /// runs
    pub runs: usize,
    /// sd of their restitutions about the fit, their mean taken out
    pub sd: f64,
}

/// Groups whose spreads differ.
pub(super) struct UnequalSpreads {
    /// spread of each group over that of its kind, by medians
    factors: Vec<f64>,
}

impl UnequalSpreads {
    /// `None` where the test sees no difference.
    pub(super) fn of(test: Option<&FTest>, residuals: &mut [Vec<f64>]) -> Option<UnequalSpreads> {
        test.filter(|test| test.p < LEVEL)?;
        let factor = |group: &mut Vec<f64>| {
            let mut distances: Vec<f64> = group.iter().map(|x| x.abs()).collect();
            let middle = median(&mut distances).filter(|_| group.len() >= 2 * LEAST_RESIDUALS);
            middle
                .map(|middle| SD_OF_MEDIAN_DISTANCE * middle)
                .filter(|factor| *factor > 1e-6)
                .unwrap_or(1.0)
        };
        Some(UnequalSpreads {
            factors: residuals.iter_mut().map(factor).collect(),
        })
    }

    pub(super) fn factor(&self, group: usize) -> f64 {
        self.factors[group]
    }
}

/// Variances of the runs about the fit, in units of those in which the sums are counted.
pub(super) struct GroupVariances {
    /// of each kind
    pub(super) kinds: [f64; 2],
    /// of each group about its own mean, over that of all groups of its kind: a law that does not fit a group, or an
    /// offset of it, is no wider spread. 1 for groups of few runs
    pub(super) groups: Vec<f64>,
    /// of all groups of each kind about their means
    inside: [f64; 2],
    runs: Vec<usize>,
}

impl GroupVariances {
    pub(super) fn new(rows: &Rows, sums: &[Sums]) -> GroupVariances {
        let fitted = NormalEquations::new(rows, sums, |_| 1.0).fit();
        let mut kinds = [ResidualSum::default(); 2];
        let mut runs = vec![0; rows.groups.len()];
        let mut own: Vec<ResidualSum> = vec![ResidualSum::default(); rows.groups.len()];
        let mut means = vec![(0.0, 0.0); rows.groups.len()];
        // the parts of a group have slopes in the same parameters
        let mut slopes: Vec<Vec<(usize, f64)>> = vec![vec![]; rows.groups.len()];
        for (part, sums) in rows.parts.iter().zip(sums) {
            let (squares, freedom) = fitted.leaves(std::iter::once((part, sums)), 1.0);
            kinds[rows.kind(part) as usize].add(squares, freedom);
            own[part.group].add(squares, freedom);
            runs[part.group] += sums.runs;
            let (sum, weight) = fitted.sum(part, sums);
            means[part.group].0 += sum;
            means[part.group].1 += weight;
            let more = NormalEquations::slopes(part, sums);
            let so_far = &mut slopes[part.group];
            match so_far.is_empty() {
                true => *so_far = more,
                false => so_far.iter_mut().zip(more).for_each(|(sum, (_, slope))| sum.1 += slope),
            }
        }
        let mut inside = [ResidualSum::default(); 2];
        for (index, group) in rows.groups.iter().enumerate() {
            let (sum, weight) = means[index];
            if weight > 0.0 {
                // of the mean's one degree of freedom the parameters have taken up a part already
                let taken = square(&fitted.inverse.matrix, &slopes[index]) / weight;
                own[index].add(-sum * sum / weight, taken - 1.0);
            }
            inside[group.kind as usize].add(own[index].squares, own[index].freedom);
        }
        let of_group = |index: usize| {
            let all = inside[rows.groups[index].kind as usize].variance();
            let enough = runs[index] >= LEAST_RESIDUALS;
            let own = own[index].variance().filter(|_| enough);
            own.zip(all).map_or(1.0, |(own, all)| own / all)
        };
        GroupVariances {
            kinds: kinds.map(|kind| kind.variance().unwrap_or(1.0)),
            groups: (0..rows.groups.len()).map(of_group).collect(),
            inside: inside.map(|kind| kind.variance().unwrap_or(1.0)),
            runs,
        }
    }
}

/// What a fit leaves of some runs.
#[derive(Clone, Copy, Default)]
struct ResidualSum {
    squares: f64,
    freedom: f64,
}

impl ResidualSum {
    fn add(&mut self, squares: f64, freedom: f64) {
        self.squares += squares;
        self.freedom += freedom;
    }

    fn variance(self) -> Option<f64> {
        (self.freedom > 0.5 && self.squares > 0.0).then(|| self.squares / self.freedom)
    }
}

/// The spreads with what they do to the standard errors; `sds` are those of the kinds in which the sums are counted.
pub(super) fn test_spreads(
    rows: &Rows,
    sums: &[Sums],
    variances: &GroupVariances,
    test: Option<FTest>,
    sds: [f64; 2],
) -> Option<SpreadTest> {
    let weight = |part: usize| 1.0 / variances.kinds[rows.kind(&rows.parts[part]) as usize];
    let fitted: JointSolution = NormalEquations::new(rows, sums, weight).fit();
    let scores = NormalEquations::new(rows, sums, |part| {
        weight(part) * variances.groups[rows.parts[part].group]
    })
    .information;
    let ends = RunKind::ALL.iter().filter_map(|kind| {
        let of_kind = |group: &usize| rows.groups[*group].kind == *kind && variances.runs[*group] >= LEAST_RESIDUALS;
        let order = |a: &usize, b: &usize| variances.groups[*a].total_cmp(&variances.groups[*b]);
        let widest = (0..rows.groups.len()).filter(of_kind).max_by(order)?;
        let narrowest = (0..rows.groups.len()).filter(of_kind).min_by(order)?;
        (widest != narrowest).then_some((widest, narrowest))
    });
    let by = |pair: &(usize, usize)| variances.groups[pair.0] / variances.groups[pair.1];
    let (widest, narrowest) = ends.max_by(|a, b| by(a).total_cmp(&by(b)))?;
    let spread_of = |index: usize| {
        let group = rows.groups[index];
        let kind = group.kind as usize;
        let sphere = rows.runs.spheres[group.sphere];
        GroupSpread {
            particle: rows.scene.particles[sphere.particle].name.clone(),
            diameter_m: sphere.diameter,
            liquid: group.liquid.map(|liquid| rows.scene.liquids[liquid].name.clone()),
            film_ratio: group.film_ratio,
            runs: variances.runs[index],
            sd: (variances.groups[index] * variances.inside[kind]).sqrt() * sds[kind],
        }
    };
    Some(SpreadTest {
        test: test?,
        widest: spread_of(widest),
        narrowest: spread_of(narrowest),
        standard_errors: standard_error_ratios(rows, &fitted.widening(&scores)),
    })
}
