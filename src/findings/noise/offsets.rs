//! Says whether the runs of a series share an offset, and how far that carries the standard errors off.
//!
//! The test is that of nested fits: the joint fit against the same with a free offset for each series, so that what the
//! parameters can take up of the offsets is not counted. With v_s the sum of a series' slopes and A the information of
//! the fit, the variance of the offsets follows from what the offsets explain, whose mean is
//! df σ² + σ_s² (n − Σ v_sᵀA⁻¹v_s): unbiased for few series, too. The standard error that allows for them is that of
//! scores with the variance σ² JᵀJ + σ_s² Σ v_s v_sᵀ.

use schemars::JsonSchema;
use serde::Serialize;

use super::rows::{Rows, RunKind, SharedOffset};
use super::spread::{affected, standard_error_ratios, GroupVariances, StandardErrorRatio};
use crate::inference::linearised_joint::LinearisedJoint;
use crate::inference::nested::FTest;
use crate::inference::sums::Sums;

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
