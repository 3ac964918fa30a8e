//! Reads how much sampling a scene asks for.

use crate::scene::table::Table;

/// How a posterior is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampler {
    /// chains
    pub chains: u64,
    /// draws a chain spends adapting
    pub warmup: u64,
    /// draws a chain keeps
    pub draws: u64,
}

/// More chains, or more draws a chain, than any memory holds beside the runs.
const MOST_CHAINS: u64 = 1000;
const MOST_DRAWS: u64 = 1_000_000;

pub(in crate::scene) fn sampler(root: &Table) -> Sampler {
    let mut sampler = Sampler {
        chains: 4,
        warmup: 1000,
        draws: 1000,
    };
    if let Some(table) = root.table("sampler") {
        let count = |key: &str, most: u64| table.count_to(key, 1, most);
        sampler.chains = count("chains", MOST_CHAINS).unwrap_or(sampler.chains);
        sampler.warmup = count("warmup", MOST_DRAWS).unwrap_or(sampler.warmup);
        sampler.draws = count("draws", MOST_DRAWS).unwrap_or(sampler.draws);
        table.finish();
    }
    sampler
}
