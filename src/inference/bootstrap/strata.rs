//! Divides the runs of a series into strata by impact speed.
//!
//! Speeds are set by the experiment, not drawn. Where a law is only near the truth, as the linear one is, resampling
//! speeds over a whole series would turn its misfit into variance that the design does not have: on the paper's design
//! 95 % intervals of the linear St_c then cover 99.4 %. Inside one speed only the noise varies.

use std::ops::Range;

/// Fewer runs give too few different resamples: two of them only two.
pub const LEAST_RUNS: usize = 3;

/// Speeds that differ by less than this share are one speed, apart by rounding.
const SAME_SPEED: f64 = 1e-9;

/// Strata of runs in order of speed: runs of one speed, joined with the next higher speeds up to [`LEAST_RUNS`].
///
/// What is left at the fast end joins the stratum below it, so that only a series of fewer runs has a smaller stratum.
/// Runs whose speeds are all different are thus taken three neighbours at a time.
pub fn by_speed(sorted: &[f64]) -> Vec<Range<usize>> {
    let mut strata: Vec<Range<usize>> = vec![];
    let mut start = 0;
    for end in 1..=sorted.len() {
        let next = sorted.get(end);
        let ends = next.is_none_or(|next| *next > sorted[end - 1] * (1.0 + SAME_SPEED));
        if ends && end - start >= LEAST_RUNS {
            strata.push(start..end);
            start = end;
        }
    }
    if start < sorted.len() {
        match strata.last_mut() {
            Some(last) => last.end = sorted.len(),
            None => strata.push(start..sorted.len()),
        }
    }
    strata
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_speeds_are_strata_and_others_join_their_neighbours() {
        let one = |stratum: Range<usize>| Vec::from_iter([stratum]);
        assert!(by_speed(&[]).is_empty());
        assert_eq!(by_speed(&[1.0]), one(0..1));
        assert_eq!(by_speed(&[1.0, 2.0]), one(0..2));
        assert_eq!(by_speed(&[1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]), vec![0..4, 4..7]);
        assert_eq!(by_speed(&[1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0]), vec![0..4, 4..8]);
        assert_eq!(by_speed(&[1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7]), vec![0..3, 3..8]);
        // 0.1 + 0.2 is no other speed than 0.3
        assert_eq!(by_speed(&[0.3, 0.3, 0.1 + 0.2, 0.5, 0.5, 0.5]), vec![0..3, 3..6]);
    }
}
