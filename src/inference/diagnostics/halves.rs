//! Cuts every chain into two, so that a drift within a chain shows as a difference between chains.

/// The halves of all chains, one after another in one vector.
#[derive(Debug, Clone)]
pub(super) struct Halves {
    /// draws, half after half
    pub draws: Vec<f64>,
    /// draws in each half
    pub length: usize,
}

impl Halves {
    /// The halves of `change` of each draw, of chains of equal length; of an odd number of draws the middle one is left out.
    pub fn map(chains: &[&[f64]], change: impl Fn(f64) -> f64) -> Halves {
        let length = chains.first().map_or(0, |chain| chain.len() / 2);
        let mut draws = Vec::with_capacity(2 * length * chains.len());
        for chain in chains {
            for half in [&chain[..length], &chain[chain.len() - length..]] {
                draws.extend(half.iter().map(|&x| change(x)));
            }
        }
        Halves { draws, length }
    }

    /// Whether all draws are the same.
    pub fn stand_still(&self) -> bool {
        self.draws.iter().all(|x| *x == self.draws[0])
    }

    /// One half after another.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> + Clone {
        self.draws.chunks_exact(self.length)
    }
}
