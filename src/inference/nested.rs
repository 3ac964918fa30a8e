//! Tests one law for all groups against one law a group, by F.

use crate::distributions::f_tail;

/// Residual sum of squares of a fit and what it was made of.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spread {
    /// residual sum of squares
    pub sum_of_squares: f64,
    /// runs
    pub runs: usize,
    /// fitted parameters
    pub parameters: usize,
}

/// Outcome of an F test.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct FTest {
    /// spread between the groups over spread within them
    pub f: f64,
    /// degrees of freedom between
    pub df_between: usize,
    /// degrees of freedom within
    pub df_within: usize,
    /// probability of a larger F if one law holds for all
    pub p: f64,
}

impl FTest {
    /// By the squares between the groups and within them, with the degrees of freedom of each; `None` where F is no number.
    pub fn of(between: f64, df_between: usize, within: f64, df_within: usize) -> Option<FTest> {
        let f = between / df_between as f64 / (within / df_within as f64);
        Some(FTest {
            f,
            df_between,
            df_within,
            p: f_tail(f, df_between as f64, df_within as f64)?,
        })
    }
}

/// F test of `one` fit to all runs against separate fits to `groups` of the same runs.
///
/// `None` with fewer than two groups, without degrees of freedom, where the groups leave no scatter, or where a fit could
/// not begin and its sum of squares is infinite.
pub fn one_law_for_all(one: Spread, groups: &[Spread]) -> Option<FTest> {
    let separate = Spread {
        sum_of_squares: groups.iter().map(|group| group.sum_of_squares).sum(),
        runs: groups.iter().map(|group| group.runs).sum(),
        parameters: groups.iter().map(|group| group.parameters).sum(),
    };
    (groups.len() > 1).then(|| nested(one, separate))?
}

/// F test of a fit against a wider one that holds it as a case, to the same runs.
///
/// `None` without degrees of freedom, where the wider fit leaves no scatter, or where a sum of squares is not finite.
pub fn nested(narrow: Spread, wide: Spread) -> Option<FTest> {
    let df_between = wide.parameters.checked_sub(narrow.parameters).filter(|df| *df > 0)?;
    let df_within = wide.runs.checked_sub(wide.parameters).filter(|df| *df > 0)?;
    let within = wide.sum_of_squares;
    if wide.runs != narrow.runs || within <= 0.0 || !within.is_finite() || !narrow.sum_of_squares.is_finite() {
        return None;
    }
    FTest::of((narrow.sum_of_squares - within).max(0.0), df_between, within, df_within)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(sum_of_squares: f64, runs: usize) -> Spread {
        Spread {
            sum_of_squares,
            runs,
            parameters: 1,
        }
    }

    #[test]
    fn a_one_way_analysis_of_variance_comes_back() {
        // groups {1, 2, 3} and {3, 4, 5}: within 2 + 2, total 10, F = 6 on 1 and 4
        let group = spread(2.0, 3);
        let test = one_law_for_all(spread(10.0, 6), &[group, group]).expect("two groups with scatter");
        assert!((test.f - 6.0).abs() < 1e-12);
        assert_eq!((test.df_between, test.df_within), (1, 4));
        // R: pf(6, 1, 4, lower.tail = FALSE)
        assert!((test.p - 0.070_484).abs() < 1e-6, "{}", test.p);
    }

    #[test]
    fn without_scatter_or_groups_there_is_no_test() {
        let flat = spread(0.0, 3);
        assert_eq!(one_law_for_all(spread(0.0, 6), &[flat, flat]), None);
        assert_eq!(one_law_for_all(flat, &[flat]), None);
        // a law that was undefined at its start is no evidence for either side
        let (unknown, some) = (spread(f64::INFINITY, 3), spread(1.0, 6));
        assert_eq!(one_law_for_all(some, &[flat, unknown]), None);
        assert_eq!(one_law_for_all(unknown, &[some]), None);
    }
}
