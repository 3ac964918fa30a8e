//! Says by how much standard errors are too small: where groups have unequal spreads, and where series share offsets.
//!
//! The test of offsets is that of nested fits: the joint fit against the same with a free offset for each series, so that what the
//! parameters can take up of the offsets is not counted. With v_s the sum of a series' slopes and A the information of
//! the fit, the variance of the offsets follows from what the offsets explain, whose mean is
//! df σ² + σ_s² (n − Σ v_sᵀA⁻¹v_s): unbiased for few series, too. The standard error that allows for them is that of
//! scores with the variance σ² JᵀJ + σ_s² Σ v_s v_sᵀ.

use schemars::JsonSchema;
use serde::Serialize;

use super::rows::{Rows, RunKind, SharedOffset};
use crate::inference::linearised_joint::{LinearisedJoint, RowsLeft};
use crate::inference::nested::FTest;
use crate::inference::spreads::{median, LEAST_RESIDUALS, SD_OF_MEDIAN_DISTANCE};
use crate::inference::sums::Sums;

/// Standard errors too small by more than this factor matter: a 95 % interval then covers less than 94 %.
///
/// An interval of ± 1.960 standard errors that are too small by c reaches ± 1.960/c of the right ones, and covers 94 %
/// where that is 1.881: c = 1.042. It is the line of 0.25 for a bias, for a width.
pub const LINE: f64 = 1.042;

/// Probability below which groups or series are taken to differ.
pub const LEVEL: f64 = 0.01;

/// By how much the standard error of a parameter is too small.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StandardErrorRatio {
    /// its name
    pub parameter: String,
    /// the standard error that allows for what was found over the one that does not; below 1 it is too large
    pub ratio: f64,
}

/// The parameters the runs see, with what their standard errors lack.
fn standard_error_ratios(rows: &Rows, widening: &[Option<f64>]) -> Vec<StandardErrorRatio> {
    let named = |(name, ratio): (&String, &Option<f64>)| {
        Some(StandardErrorRatio {
            parameter: name.clone(),
            ratio: (*ratio)?,
        })
    };
    rows.names.iter().zip(widening).filter_map(named).collect()
}

/// The one that lacks most, where a test sees a difference and a 95 % interval therefore covers less than 94 %.
fn affected<'a>(test: &FTest, all: &'a [StandardErrorRatio]) -> Option<&'a StandardErrorRatio> {
    let worst = all.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
    worst.filter(|worst| test.p < LEVEL && worst.ratio > LINE)
}

/// Spreads of the groups against one spread for all dry and one for all wet runs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
    /// The standard error that lacks most, where spreads differ and a 95 % interval therefore covers less than 94 %.
    pub fn affected_standard_error(&self) -> Option<&StandardErrorRatio> {
        affected(&self.test, &self.standard_errors)
    }
}

/// The spread of one group's runs about the fit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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

/// Spread of each group over that of its kind, by medians; `None` where the test sees no difference.
pub(super) fn unequal_spreads(test: Option<&FTest>, residuals: &[Vec<f64>]) -> Option<Vec<f64>> {
    test.filter(|test| test.p < LEVEL)?;
    let factor = |group: &Vec<f64>| {
        let mut distances: Vec<f64> = group.iter().map(|x| x.abs()).collect();
        let middle = median(&mut distances).filter(|_| group.len() >= 2 * LEAST_RESIDUALS);
        let factor = middle.map(|middle| SD_OF_MEDIAN_DISTANCE * middle);
        factor.filter(|factor| *factor > 1e-6).unwrap_or(1.0)
    };
    Some(residuals.iter().map(factor).collect())
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
        let fitted = rows.fit(sums);
        let mut groups = vec![rows.blank(); rows.groups.len()];
        for (group, sums) in rows.group_of.iter().zip(sums) {
            groups[*group].add_weighted(sums, 1.0);
        }
        let (mut kinds, mut inside) = ([RowsLeft::default(); 2], [RowsLeft::default(); 2]);
        let mut own = vec![];
        for (group, sums) in rows.groups.iter().zip(&groups) {
            let mut left = fitted.leaves(sums, 1.0);
            kinds[group.kind as usize].add(left);
            let offset = SharedOffset::of(sums);
            if offset.weight > 0.0 {
                let mean = offset.gradient + offset.slopes.dot(&fitted.step);
                // of the mean's one degree of freedom the parameters have taken up a part already
                let taken = offset.taken(&fitted.inverse.matrix) / offset.weight;
                left.add(RowsLeft {
                    squares: -mean * mean / offset.weight,
                    freedom: taken - 1.0,
                });
            }
            inside[group.kind as usize].add(left);
            own.push(left);
        }
        let of_group = |index: usize| {
            let all = variance(inside[rows.groups[index].kind as usize]);
            let enough = groups[index].runs >= LEAST_RESIDUALS;
            let own = variance(own[index]).filter(|_| enough);
            own.zip(all).map_or(1.0, |(own, all)| own / all)
        };
        GroupVariances {
            kinds: kinds.map(|kind| variance(kind).unwrap_or(1.0)),
            groups: (0..rows.groups.len()).map(of_group).collect(),
            inside: inside.map(|kind| variance(kind).unwrap_or(1.0)),
            runs: groups.iter().map(|sums| sums.runs).collect(),
        }
    }
}

fn variance(left: RowsLeft) -> Option<f64> {
    (left.freedom > 0.5 && left.squares > 0.0).then(|| left.squares / left.freedom)
}

/// The spreads with what they do to the standard errors; `sds` are those of the kinds in which the sums are counted.
pub(super) fn test_spreads(
    rows: &Rows,
    sums: &[Sums],
    variances: &GroupVariances,
    test: Option<FTest>,
    sds: [f64; 2],
) -> Option<SpreadTest> {
    let weight = |part: usize| 1.0 / variances.kinds[rows.kind(part) as usize];
    let fitted = LinearisedJoint::new(&rows.together(sums, weight));
    let scores = rows.together(sums, |part| weight(part) * variances.groups[rows.group_of[part]]);
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
        let group = &rows.groups[index];
        let kind = group.kind as usize;
        GroupSpread {
            particle: rows.particle(group).to_owned(),
            diameter_m: rows.runs.spheres[group.sphere].diameter,
            liquid: rows.liquid(group).map(str::to_owned),
            film_ratio: group.film_ratio,
            runs: variances.runs[index],
            sd: (variances.groups[index] * variances.inside[kind]).sqrt() * sds[kind],
        }
    };
    Some(SpreadTest {
        test: test?,
        widest: spread_of(widest),
        narrowest: spread_of(narrowest),
        standard_errors: standard_error_ratios(rows, &fitted.widening(&scores.information)),
    })
}

/// Fewer series than this have no sd of offsets.
const FEWEST_SERIES: usize = 3;

/// Share of the offsets' squares that must be left beside what the parameters take up of them.
const LEAST_SEEN: f64 = 0.25;

/// Offsets that the wet runs of a series share.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Offsets {
    /// series with runs in the fit
    pub series: usize,
    /// F test of an offset for each series
    #[serde(flatten)]
    pub test: FTest,
    /// sd of the offsets, in units of e; 0 where the series differ less than their runs would make them
    pub sd: f64,
    /// the same over the sd of wet runs about the fit
    pub share: f64,
    /// particle, liquid, diameter and film ratio of the series farthest from the others, in its standard errors
    pub farthest: String,
    /// what the standard errors lack by it
    pub standard_errors: Vec<StandardErrorRatio>,
}

impl Offsets {
    /// The standard error that lacks most, where there are offsets and a 95 % interval therefore covers less than 94 %.
    pub fn affected_standard_error(&self) -> Option<&StandardErrorRatio> {
        affected(&self.test, &self.standard_errors)
    }
}

/// The offsets; `None` where the series leave none to be seen. `weigh_groups`: groups have spreads of their own.
pub(super) fn test_offsets(
    rows: &Rows,
    sums: &[Sums],
    variances: &GroupVariances,
    weigh_groups: bool,
    sd: f64,
) -> Option<Offsets> {
    let weight = |part: usize| {
        let own = match weigh_groups {
            true => variances.groups[rows.group_of[part]],
            false => 1.0,
        };
        1.0 / (variances.kinds[rows.kind(part) as usize] * own)
    };
    let is_wet = |part: &usize| rows.kind(*part) == RunKind::Wet;
    let wet = || (0..rows.parts.len()).filter(is_wet).filter(|part| sums[*part].runs > 0);
    let one = LinearisedJoint::new(&rows.together(sums, weight));
    let mut within_series = sums.to_vec();
    wet().for_each(|part| within_series[part] = without_offset(&sums[part]));
    let own = LinearisedJoint::new(&rows.together(&within_series, weight));
    let series = wet().count();
    let df_between = (series + own.inverse.rank).checked_sub(one.inverse.rank);
    let df_between = df_between.filter(|df| *df > 0)?;
    // of wet runs alone: dry runs have another spread, and no part in the offsets
    let (mut within, mut freedom) = (0.0, 0.0);
    for part in wet() {
        let left = own.leaves(&within_series[part], weight(part));
        within += weight(part) * left.squares;
        freedom += left.freedom - 1.0;
    }
    let df_within = freedom.round();
    if df_within < 1.0 || within <= 0.0 {
        return None;
    }
    let variance = within / df_within;
    let explained = (one.left - own.left).max(0.0);
    let test = FTest::of(explained, df_between, within, df_within as usize)?;
    let offset = |part: usize| (weight(part), SharedOffset::of(&sums[part]));
    let offsets: Vec<(f64, SharedOffset)> = wet().map(offset).collect();
    // n, what offsets of unit variance would add to the squares if the parameters took up nothing, and what they do add
    let all: f64 = offsets.iter().map(|(weight, offset)| weight * offset.weight).sum();
    let taken = |(weight, offset): &(f64, SharedOffset)| weight * weight * offset.taken(&one.inverse.matrix);
    let expected = all - offsets.iter().map(taken).sum::<f64>();
    // what the parameters take up of the offsets is not seen: of a small rest, or of few series, no sd can be had
    if series < FEWEST_SERIES || expected < LEAST_SEEN * all {
        return None;
    }
    // in units of e², since the offsets' slopes are those of e
    let of_offsets = ((explained - df_between as f64 * variance) / expected).max(0.0);
    let from_others = |part: &usize| {
        let offset = SharedOffset::of(&sums[*part]);
        offset.gradient.abs() / offset.weight.sqrt()
    };
    let farthest = wet().max_by(|a, b| from_others(a).total_cmp(&from_others(b)))?;
    let of_part = |part: usize| if is_wet(&part) { variance } else { 1.0 };
    let mut scores = rows.together(sums, |part| weight(part) * of_part(part));
    for (weight, offset) in &offsets {
        let slopes = &offset.slopes * *weight;
        scores.information += &slopes * slopes.transpose() * of_offsets;
    }
    Some(Offsets {
        series,
        test,
        sd: of_offsets.sqrt(),
        share: of_offsets.sqrt() / sd,
        farthest: rows.part_name(farthest),
        standard_errors: standard_error_ratios(rows, &one.widening(&scores.information)),
    })
}

/// Sums of a series without what an offset of its own takes up.
fn without_offset(sums: &Sums) -> Sums {
    let last = sums.gradient.len() - 1;
    let (weight, offset) = (sums.information[(last, last)], sums.information.column(last));
    if weight <= 0.0 {
        return sums.clone();
    }
    let mean = sums.gradient[last] / weight;
    let mut left = sums.clone();
    left.squares -= mean * mean * weight;
    left.gradient -= offset * mean;
    left.information -= offset * offset.transpose() / weight;
    for slope in 0..offset.len() {
        // one that is the same in all runs leaves only rounding
        if left.information[(slope, slope)] <= 1e-12 * sums.information[(slope, slope)] {
            left.information.row_mut(slope).fill(0.0);
            left.information.column_mut(slope).fill(0.0);
        }
    }
    left
}
