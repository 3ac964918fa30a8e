//! Says whether the momenta of Hamiltonian chains reach all energies of the posterior: E-BFMI.

use super::FEWEST_DRAWS;

/// E-BFMI of one chain from its energies, draw by draw: mean squared step over variance.
///
/// About 1 for a sampler that draws the energy afresh each time; below 0.3 the tails are reached too slowly. `None` for
/// fewer than four draws, a value that is not finite, or energies that are all the same. Source: Betancourt 2016
/// (arXiv:1604.00695).
pub fn e_bfmi(energies: &[f64]) -> Option<f64> {
    if energies.len() < FEWEST_DRAWS {
        return None;
    }
    let steps: f64 = energies.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    let squares = super::variance(energies) * (energies.len() as f64 - 1.0);
    // both sums run over n − 1
    let fraction = steps / squares;
    (fraction.is_finite() && squares > 0.0).then_some(fraction)
}
