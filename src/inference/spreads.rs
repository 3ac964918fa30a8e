//! Tests whether groups of residuals have one spread, by their distances from each group's median.

use super::nested::FTest;
pub use crate::distributions::{median, SD_OF_MEDIAN_DISTANCE};

/// Fewer residuals than this say too little of a spread to be a group.
pub const LEAST_RESIDUALS: usize = 5;

/// Brown and Forsythe's test of equal spreads among the groups of each kind; kinds may differ.
///
/// It holds its level where noise is not normal, and errs to the cautious side for groups of few residuals. No distance
/// counts for more than `most`, so that a single run does not make a group wide. Groups of fewer than
/// [`LEAST_RESIDUALS`] are left out; `None` without two groups of a kind, or without any scatter of the distances.
/// Source: Brown & Forsythe (1974), J. Am. Stat. Assoc. 69, 364.
pub fn equal_spreads(kinds: &mut [Vec<Vec<f64>>], most: f64) -> Option<FTest> {
    let (mut between, mut within) = (0.0, 0.0);
    let (mut df_between, mut df_within) = (0, 0);
    for groups in kinds {
        let mut means: Vec<(f64, f64)> = vec![];
        for group in groups.iter_mut().filter(|group| group.len() >= LEAST_RESIDUALS) {
            let Some(middle) = median(group) else { continue };
            let distance = |x: &f64| (x - middle).abs().min(most);
            let n = group.len() as f64;
            let mean = group.iter().map(distance).sum::<f64>() / n;
            within += group.iter().map(|x| (distance(x) - mean).powi(2)).sum::<f64>();
            df_within += group.len() - 1;
            means.push((n, mean));
        }
        let all: f64 = means.iter().map(|(n, _)| n).sum();
        let mean = means.iter().map(|(n, mean)| n * mean).sum::<f64>() / all;
        between += means.iter().map(|(n, own)| n * (own - mean).powi(2)).sum::<f64>();
        df_between += means.len().saturating_sub(1);
    }
    if df_between == 0 || within <= 0.0 {
        return None;
    }
    FTest::of(between, df_between, within, df_within)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy.stats.levene(…, center="median") of the same groups (SciPy 1.18.1)
    #[test]
    fn the_test_agrees_with_scipy() {
        let groups = vec![
            vec![0.3, -1.2, 0.8, 0.1, -0.4, 1.7],
            vec![2.9, -3.1, 0.2, 4.4, -1.8],
            vec![0.05, -0.15, 0.2, 0.4, -0.35, 0.1, -0.02],
        ];
        let test = equal_spreads(&mut [groups], f64::INFINITY).expect("three groups");
        assert_eq!((test.df_between, test.df_within), (2, 15));
        assert!((test.f / 9.712_564_685_926_287 - 1.0).abs() < 1e-9, "{}", test.f);
        assert!((test.p / 0.001_968_419_166_586_786 - 1.0).abs() < 1e-9, "{}", test.p);
    }
}
