//! Reads how much sampling a scene asks for.

use crate::scene::keys::{Key, Section};
use crate::scene::table::{read_nothing, Count, SceneTable};

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

const CHAINS: Key<Count, u64> = Key::new("chains", Count(1, MOST_CHAINS))
    .means("chains")
    .example("8")
    .defaults_to(4);

const WARMUP: Key<Count, u64> = Key::new("warmup", Count(1, MOST_DRAWS))
    .means("draws that a chain spends adapting")
    .example("2000")
    .defaults_to(1000);

const DRAWS: Key<Count, u64> = Key::new("draws", Count(1, MOST_DRAWS))
    .means("draws that a chain keeps")
    .example("5000")
    .defaults_to(1000);

/// What is to be said of the table of the sampler.
pub(in crate::scene) fn guide() -> Section {
    let (_, keys) = read_nothing(sampler);
    Section::new("[sampler]", "How the posterior is sampled", keys).that_may_be_empty()
}

pub fn sampler(table: &SceneTable) -> Sampler {
    let sampler = Sampler {
        chains: table.read_or(&CHAINS),
        warmup: table.read_or(&WARMUP),
        draws: table.read_or(&DRAWS),
    };
    if sampler.chains * sampler.draws > MOST_KEPT {
        let key = if table.has(DRAWS.base) { DRAWS.base } else { CHAINS.base };
        let found = format!("{} draws of {} chains", sampler.draws, sampler.chains);
        let expected = format!("expected at most {MOST_KEPT} draws of all chains together");
        table.refuse(key, table.at(key), Some(found), expected);
    }
    table.finish();
    sampler
}
