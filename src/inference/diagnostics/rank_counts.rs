//! Counts how the chains share the ranks of all draws.

/// The ranks of all draws in equal bins, chain by chain.
#[derive(Debug, Clone, PartialEq)]
pub struct RankCounts {
    /// of each chain, draws in each bin
    pub counts: Vec<Vec<usize>>,
    /// draws that a bin holds of each chain where all agree
    pub expected: f64,
    /// standard deviation of a count over `expected`, were the draws independent
    pub sd: f64,
}

impl RankCounts {
    /// Those of chains of one length in so many bins; equal draws rank by chain and place.
    pub fn new(chains: &[Vec<f64>], bins: usize) -> RankCounts {
        let each = chains.first().map_or(0, Vec::len) as f64;
        // of one chain every bin has its even share; of several, what the others leave
        let others = 1.0 - 1.0 / chains.len().max(1) as f64;
        RankCounts {
            counts: counts(chains, bins),
            expected: each / bins as f64,
            sd: (others * (bins as f64 - 1.0) / each.max(1.0)).sqrt(),
        }
    }
}

fn counts(chains: &[Vec<f64>], bins: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<(f64, usize)> = chains
        .iter()
        .enumerate()
        .flat_map(|(chain, draws)| draws.iter().map(move |draw| (*draw, chain)))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut counts = vec![vec![0; bins]; chains.len()];
    let all = order.len();
    for (rank, (_, chain)) in order.into_iter().enumerate() {
        counts[chain][rank * bins / all] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed;
    use rand::RngExt;

    #[test]
    fn chains_that_agree_share_the_ranks_evenly_and_one_that_does_not_stands_out() {
        let even = |chain: usize| (0..100).map(|draw| (2 * draw + chain) as f64).collect();
        assert_eq!(RankCounts::new(&[even(0), even(1)], 4).counts, [[25; 4]; 2]);
        let apart = [even(0), (0..100).map(|draw| f64::from(draw) + 1e6).collect()];
        assert_eq!(RankCounts::new(&apart, 4).counts, [[50, 50, 0, 0], [0, 0, 50, 50]]);
    }

    #[test]
    fn counts_of_independent_draws_scatter_by_their_sd() {
        let mut rng = seed::stream(1, "counts_of_independent_draws_scatter_by_their_sd", 0);
        let mut shares = vec![];
        let mut sd = 0.0;
        for _ in 0..200 {
            let chains: Vec<Vec<f64>> = (0..4).map(|_| (0..400).map(|_| rng.random()).collect()).collect();
            let ranks = RankCounts::new(&chains, 20);
            sd = ranks.sd;
            let of_all = ranks.counts.iter().flatten();
            shares.extend(of_all.map(|count| *count as f64 / ranks.expected - 1.0));
        }
        let found = (shares.iter().map(|share| share * share).sum::<f64>() / shares.len() as f64).sqrt();
        // 16,000 counts, of which 12,000 or so are free: the sd of an sd is 0.6 %
        assert!((found / sd - 1.0).abs() < 0.03, "{found} {sd}");
    }
}
