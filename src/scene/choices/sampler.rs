//! Reads how much sampling a scene asks for.

use crate::scene::table::values::count;
use crate::scene::table::SceneTable;

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

/// Most chains, and most draws a chain adapts by or keeps: more than any answer needs.
const MOST_CHAINS: u64 = 1000;
const MOST_DRAWS: u64 = 1_000_000;

/// Most draws that all chains keep together; what they take also depends on the parameters, and is checked when these
/// are listed.
pub const MOST_KEPT: u64 = 10_000_000;

pub fn sampler(table: &SceneTable) -> Sampler {
    let sampler = Sampler {
        chains: table.read_or("chains", count(1, MOST_CHAINS), 4),
        warmup: table.read_or("warmup", count(1, MOST_DRAWS), 400),
        draws: table.read_or("draws", count(1, MOST_DRAWS), 1000),
    };
    if sampler.chains * sampler.draws > MOST_KEPT {
        let key = if table.has("draws") { "draws" } else { "chains" };
        let found = format!("{} draws of {} chains", sampler.draws, sampler.chains);
        let expected = format!("expected at most {MOST_KEPT} draws of all chains together");
        table.refuse(key, table.at(key), Some(found), expected);
    }
    table.finish();
    sampler
}
