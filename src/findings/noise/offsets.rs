//! Says whether the runs of a series share an offset, and how far that carries the standard errors off.
//!
//! The test is that of nested fits: the joint fit against the same with a free offset for each series, so that what the
//! parameters can take up of the offsets is not counted. With v_s the sum of a series' slopes and A the information of
//! the fit, the variance of the offsets follows from what the offsets explain, whose mean is
//! df σ² + σ_s² (n − Σ v_sᵀA⁻¹v_s): unbiased for few series, too. The standard error that allows for them is that of
//! scores with the variance σ² JᵀJ + σ_s² Σ v_s v_sᵀ.

use nalgebra::DMatrix;
use serde::Serialize;

use super::normal_equations::{JointSolution, NormalEquations};
use super::rows::{Rows, RunKind};
use super::spread::GroupVariances;
use super::standard_errors::{standard_error_ratios, worst, StandardErrorRatio};
use crate::distributions::f_tail;
use crate::inference::information::{add_square, square, Sums};
use crate::inference::nested::FTest;

/// Fewer series than this have no sd of offsets.
const FEWEST_SERIES: usize = 3;

/// Share of the offsets' squares that must be left beside what the parameters take up of them.
const LEAST_SEEN: f64 = 0.25;

/// Offsets that the wet runs of a series share.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// what the standard errors lack by it
    pub standard_errors: Vec<StandardErrorRatio>,
}

impl Offsets {
    /// The parameter whose standard error lacks most.
    pub fn worst(&self) -> Option<&StandardErrorRatio> {
        worst(&self.standard_errors)
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
        let part = &rows.parts[part];
        let own = if weigh_groups {
            variances.groups[part.group]
        } else {
            1.0
        };
        1.0 / (variances.kinds[rows.kind(part) as usize] * own)
    };
    let is_wet = |part: &usize| rows.kind(&rows.parts[*part]) == RunKind::Wet;
    let wet = || (0..rows.parts.len()).filter(is_wet).filter(|part| sums[*part].runs > 0);
    let one = NormalEquations::new(rows, sums, weight).fit();
    let (own, demeaned) = NormalEquations::within(rows, sums, weight);
    let own = own.fit();
    let series = wet().count();
    let df_between = (series + own.inverse.rank)
        .checked_sub(one.inverse.rank)
        .filter(|df| *df > 0)?;
    // of wet runs alone: dry runs have another spread, and no part in the offsets
    let (mut within, mut freedom) = (0.0, 0.0);
    for part in wet() {
        let (squares, left) = own.leaves(std::iter::once((&rows.parts[part], &demeaned[part])), weight(part));
        within += weight(part) * squares;
        freedom += left - 1.0;
    }
    let df_within = freedom.round();
    if df_within < 1.0 || within <= 0.0 {
        return None;
    }
    let variance = within / df_within;
    let explained = (one.left - own.left).max(0.0);
    let f = explained / df_between as f64 / variance;
    let p = f_tail(f, df_between as f64, df_within)?;
    let spread = OffsetSpread::new(rows, sums, &one, weight);
    // what the parameters take up of the offsets is not seen: of a small rest, or of few series, no sd can be had
    if series < FEWEST_SERIES || spread.expected < LEAST_SEEN * spread.all {
        return None;
    }
    // in units of e², since the offsets' slopes are those of e
    let of_offsets = (explained - df_between as f64 * variance) / spread.expected;
    let of_offsets = if spread.expected > 0.0 {
        of_offsets.max(0.0)
    } else {
        0.0
    };
    let mut scores = NormalEquations::new(rows, sums, |part| {
        if is_wet(&part) {
            weight(part) * variance
        } else {
            weight(part)
        }
    });
    scores.information += &spread.scores * of_offsets;
    Some(Offsets {
        series,
        test: FTest {
            f,
            df_between,
            df_within: df_within as usize,
            p,
        },
        sd: of_offsets.sqrt(),
        share: of_offsets.sqrt() / sd,
        standard_errors: standard_error_ratios(rows, &one.widening(&scores.information)),
    })
}

/// What offsets of unit variance would do to the fit without them.
struct OffsetSpread {
    /// n − Σ v_sᵀA⁻¹v_s: what they would add to the squares that are explained
    expected: f64,
    /// n: what they would add if the parameters took up nothing
    all: f64,
    /// Σ v_s v_sᵀ: what they would add to the information of the scores
    scores: DMatrix<f64>,
}

impl OffsetSpread {
    fn new(rows: &Rows, sums: &[Sums], fit: &JointSolution, weight: impl Fn(usize) -> f64) -> OffsetSpread {
        let mut found = OffsetSpread {
            expected: 0.0,
            all: 0.0,
            scores: NormalEquations::new(rows, sums, |_| 0.0).information,
        };
        for (index, (part, sums)) in rows.parts.iter().zip(sums).enumerate() {
            if rows.kind(part) != RunKind::Wet || sums.runs == 0 {
                continue;
            }
            let offset = part.places.len();
            let own = NormalEquations::slopes(part, sums);
            let slopes: Vec<(usize, f64)> = own.iter().map(|(j, slope)| (*j, slope * weight(index))).collect();
            let own = weight(index) * sums.information[(offset, offset)];
            found.all += own;
            found.expected += own - square(&fit.inverse.matrix, &slopes);
            add_square(&mut found.scores, 1.0, &slopes);
        }
        found
    }
}
