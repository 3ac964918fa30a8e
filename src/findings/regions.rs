//! Finds where e_inf and St_c lie together: curves around the densest shares of replicates and draws, and their intervals.

use super::balance::{DerivedEstimate, EnergyBalance};
use super::bootstrap::JointReplicates;
use super::posterior::Posterior;
use crate::inference::density::CloudDensity;
use crate::physics::loss::Film;
use crate::scene::{Scene, WetLaw};

/// Shares of a cloud that its contours hold.
pub const SHARES: [f64; 2] = [0.5, 0.95];

/// A closed curve around the densest share of a cloud of pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// the share it holds, together with the others of this share: one of [`SHARES`]
    pub share: f64,
    /// (e_inf, St_c) along it
    pub curve: Vec<(f64, f64)>,
}

/// The contours of (e_inf, St_c), one a hill and share; none where the finite pairs are few or lie on a line.
pub fn contours(pairs: &[[f64; 2]]) -> Vec<Contour> {
    let Some(density) = CloudDensity::new(pairs) else {
        return vec![];
    };
    let of_share = |share: f64| {
        let curves = density.around(share).into_iter();
        curves.map(move |curve| Contour { share, curve })
    };
    SHARES.into_iter().flat_map(of_share).collect()
}

/// e_inf and St_c of the posterior's draws at a film ratio, with the density ratio of the runs the law was fitted to.
///
/// `None` beside the linear law, whose St_c is another quantity; over all film ratios, where there is no one e_inf; and
/// over several diameters where these differ in St_c.
pub fn of_posterior(
    scene: &Scene,
    balance: &EnergyBalance,
    posterior: &Posterior,
    joint: &JointReplicates,
) -> Option<Vec<[f64; 2]>> {
    let film_ratio = joint.film_ratio.filter(|_| joint.law == WetLaw::Sqrt)?;
    let of_film = |row: &&DerivedEstimate| row.sphere == joint.sphere && row.film_ratio == film_ratio;
    let mut derived = balance.derived.iter().filter(of_film);
    let (Some(row), None) = (derived.next(), derived.next()) else {
        return None;
    };
    let film = Film {
        film_ratio,
        density_ratio: row.density_ratio,
    };
    posterior.e_inf_and_st_c(
        joint.sphere,
        film,
        row.fixed_over_stokes,
        scene.model.dry_speed.reference(),
    )
}

/// The central interval of e_inf, and that of St_c.
pub fn central(pairs: &[[f64; 2]], level: f64) -> [Option<[f64; 2]>; 2] {
    [0, 1].map(|axis| {
        let mut sorted: Vec<f64> = pairs.iter().map(|pair| pair[axis]).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |probability: f64| {
            let place = (probability * (sorted.len() as f64 - 1.0)).round() as usize;
            sorted.get(place).copied()
        };
        at(0.5 - 0.5 * level)
            .zip(at(0.5 + 0.5 * level))
            .map(|(lo, hi)| [lo, hi])
    })
}
