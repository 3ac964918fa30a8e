//! Sums terms over columns of numbers in several lanes at once.

/// Rows taken at once, so that sums of them need not wait for one another.
const LANES: usize = 4;

/// Sums over the rows of terms in M columns of numbers; of columns of different lengths the shortest counts.
#[inline(always)] // in the registers of the caller
pub fn sums<const M: usize, const N: usize>(columns: [&[f64]; M], terms: impl Fn([f64; M]) -> [f64; N]) -> [f64; N] {
    let runs = columns.iter().map(|column| column.len()).min().unwrap_or(0);
    let mut lanes = [[0.0; LANES]; N];
    let mut row = [0.0; M];
    // loops throughout: a map over an array may be a call
    for first in (0..runs - runs % LANES).step_by(LANES) {
        let mut several = [[0.0; LANES]; M];
        for (to, column) in several.iter_mut().zip(&columns) {
            to.copy_from_slice(&column[first..first + LANES]);
        }
        for lane in 0..LANES {
            for (to, several) in row.iter_mut().zip(&several) {
                *to = several[lane];
            }
            for (sum, term) in lanes.iter_mut().zip(terms(row)) {
                sum[lane] += term;
            }
        }
    }
    for run in runs - runs % LANES..runs {
        for (to, column) in row.iter_mut().zip(&columns) {
            *to = column[run];
        }
        for (sum, term) in lanes.iter_mut().zip(terms(row)) {
            sum[0] += term;
        }
    }
    lanes.map(|sum| sum.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_counts_once() {
        for runs in 0..14 {
            let column: Vec<f64> = (1..=runs).map(f64::from).collect();
            let n = f64::from(runs);
            let found = sums([&column, &column], |[x, y]| [1.0, x, x * y]);
            let expected = [n, n * (n + 1.0) / 2.0, n * (n + 1.0) * (2.0 * n + 1.0) / 6.0];
            assert_eq!(found, expected, "{runs}");
        }
        assert_eq!(sums([&[1.0, 2.0, 4.0], &[1.0, 1.0]], |[x, y]| [x * y]), [3.0]);
    }
}
