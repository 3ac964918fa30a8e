//! Says when draws are enough: the largest R-hat, the fewest effective draws, and whether draws of parameters hold both.

use rayon::prelude::*;

use super::diagnostics::summary::{summarise, Summary};

/// Largest R-hat of chains that have mixed (Vehtari et al. 2021).
pub const LARGEST_RHAT: f64 = 1.01;

/// Fewest effective draws of each chain, for the centre and for the 5 % and 95 % points (Vehtari et al. 2021).
pub const FEWEST_EFFECTIVE: f64 = 100.0;

/// The draws of each parameter in each chain: `draws[parameter][chain][draw]`.
pub type ParameterDraws = [Vec<Vec<f64>>];

/// What is asked of the draws of every parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MixingLines {
    /// largest R-hat; `None` of draws that are not from chains
    pub rhat: Option<f64>,
    /// fewest effective draws of all chains together
    pub effective: f64,
}

impl MixingLines {
    /// What is asked of so many chains.
    pub fn of_chains(chains: usize) -> MixingLines {
        MixingLines {
            rhat: Some(LARGEST_RHAT),
            effective: FEWEST_EFFECTIVE * chains as f64,
        }
    }

    /// Whether every parameter's draws hold to them; effective draws count 1/`factor`², see
    /// [`Sampled::mcse_factor`](super::sampling::Sampled).
    pub fn hold(self, draws: &ParameterDraws, factor: f64) -> bool {
        let enough = |effective: Option<f64>| effective.is_some_and(|n| n / (factor * factor) >= self.effective);
        draws.par_iter().all(|chains| {
            let found = summary_of(chains);
            let agree = self.rhat.is_none_or(|line| found.rhat.is_some_and(|rhat| rhat <= line));
            agree && enough(found.ess_bulk) && enough(found.ess_tail)
        })
    }
}

/// How many draws each chain is to add: as many as it has, or what is left to the most, until every parameter's draws hold
/// to the lines; none then, and where no more may be made.
pub fn draws_to_add(lines: MixingLines, draws: &ParameterDraws, most: usize) -> usize {
    let made = draws_a_chain(draws);
    let left = most.saturating_sub(made);
    if left == 0 || lines.hold(draws, 1.0) {
        0
    } else {
        made.min(left)
    }
}

/// Draws that each chain made.
pub fn draws_a_chain(draws: &ParameterDraws) -> usize {
    draws.first().and_then(|chains| chains.first()).map_or(0, Vec::len)
}

/// The summary of one parameter's draws, chain by chain.
pub fn summary_of(chains: &[Vec<f64>]) -> Summary {
    let chains: Vec<&[f64]> = chains.iter().map(Vec::as_slice).collect();
    summarise(&chains)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::stream;
    use rand_distr::{Distribution, StandardNormal};

    /// Independent draws of two parameters in four chains, the second parameter's last chain off by so many sds.
    fn drawn(each: usize, off: f64) -> Vec<Vec<Vec<f64>>> {
        let mut rng = stream(1, "mixing", 0);
        let mut chain = |off: f64| -> Vec<f64> {
            let draws = (0..each).map(|_| StandardNormal.sample(&mut rng));
            draws.map(|z: f64| z + off).collect()
        };
        let offsets = [[0.0; 4], [0.0, 0.0, 0.0, off]];
        offsets.map(|chains| chains.map(&mut chain).to_vec()).to_vec()
    }

    #[test]
    fn independent_draws_hold_and_a_chain_apart_or_too_few_do_not() {
        let lines = MixingLines::of_chains(4);
        assert!(lines.hold(&drawn(1000, 0.0), 1.0));
        assert!(!lines.hold(&drawn(1000, 1.0), 1.0));
        assert!(!lines.hold(&drawn(90, 0.0), 1.0));
        // each draw stands for a quarter of one
        assert!(lines.hold(&drawn(300, 0.0), 1.0) && !lines.hold(&drawn(300, 0.0), 2.0));
        let apart = MixingLines { rhat: None, ..lines };
        assert!(apart.hold(&drawn(10_000, 0.05), 1.0));
    }
}
