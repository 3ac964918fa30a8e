//! Holds the gas of `examples/cooling` against Haff's law and kinetic theory.

#[path = "../examples/cooling/gas.rs"]
mod gas;
#[path = "../examples/cooling/haff.rs"]
mod haff;
#[path = "../examples/cooling/pair.rs"]
mod pair;

use crate::common::{mean, seed_of};
use gas::{collide, Gas};
use haff::Haff;
use pair::{Pair, LUBRICATION_LOG, SPHERE};
use rand::{rngs::ChaCha8Rng, SeedableRng};
use std::f64::consts::PI;

/// Spheres of a gas, and how many gases are simulated for a mean and its standard error.
const SPHERES: usize = 4000;
const GASES: u64 = 20;

fn haff(e: f64) -> Haff {
    Haff {
        e,
        temperature: 1.0,
        met_per_metre: 12.0,
    }
}

/// How many standard errors the mean of some ratios is from what they should be.
fn z(ratios: &[f64], expected: f64) -> f64 {
    let (mean, se) = mean(ratios);
    // chance is small enough to see an error of two percent
    assert!(se < 4e-3, "{se}");
    (mean - expected) / se
}

/// At a time given in units of τ, over what theory says: how far √(T₀/T) has risen, which is t/τ by Haff's law; and how many
/// impacts that took. One of each gas.
fn ratios(test: &str, e: f64, gone: f64) -> [Vec<f64>; 2] {
    let gases = (0..GASES).map(|index| {
        let mut haff = haff(e);
        let mut stream = ChaCha8Rng::seed_from_u64(seed_of(test));
        stream.set_stream(index);
        let mut gas = Gas::new(SPHERES, haff.temperature, haff.met_per_metre, stream);
        // within eight impacts of each sphere the velocities are no longer normal, but those of the cooling state
        gas.advance(8.0 / haff.frequency(), |pair, normal| collide(pair, normal, |_| e));
        haff.temperature = gas.temperature();
        let (begun, before) = (gas.time(), gas.collisions_per_sphere());
        let end = begun + gone / haff.cooling_rate();
        gas.advance(end, |pair, normal| collide(pair, normal, |_| e));
        let rise = (haff.temperature / gas.temperature()).sqrt();
        let impacts = haff.frequency() / haff.cooling_rate() * rise.ln();
        let met = gas.collisions_per_sphere() - before;
        let risen = (rise - 1.0) / ((gas.time() - begun) * haff.cooling_rate());
        (risen, met / impacts)
    });
    let (rises, impacts) = gases.unzip();
    [rises, impacts]
}

#[test]
fn the_energy_follows_haffs_law() {
    let test = "the_energy_follows_haffs_law";
    let haff = haff(0.9);
    assert!((haff.temperature_at(1.0 / haff.cooling_rate()) - 0.25).abs() < 1e-12);
    for (e, gone) in [(0.9, 15.0), (0.8, 2.0)] {
        let [rises, impacts] = ratios(test, e, gone);
        let found = [z(&rises, 1.0), z(&impacts, 1.0)];
        assert!(found.iter().all(|z| z.abs() < 4.5), "{e}, {gone} τ: {found:?}");
        // an energy loss of 1 − e in place of 1 − e², and every impact counted for both of its spheres
        for wrong in [1.0 / (1.0 + e), 2.0].map(|wrong| z(&rises, wrong)) {
            assert!(wrong.abs() > 50.0, "{e}: {wrong}");
        }
    }
    // the first order is not enough there
    let [rises, _] = ratios(test, 0.0, 15.0);
    assert!((mean(&rises).0 - 0.99).abs() < 0.01, "{:?}", mean(&rises));
}

/// e² = e_inf² − 4 L/St with St of the effective mass and radius.
#[test]
fn a_pair_rebounds_by_its_own_stokes_number() {
    let pair = Pair::new();
    let mass = SPHERE.density * PI / 6.0 * SPHERE.diameter.powi(3);
    let stokes = |speed: f64, mass: f64, radius: f64| mass * speed / (6.0 * PI * SPHERE.viscosity * radius * radius);
    let radius = SPHERE.diameter / 2.0;
    for speed in [0.07, 0.3, 1.1] {
        let of = |stokes: f64| (pair.e_inf().powi(2) - 4.0 * LUBRICATION_LOG / stokes).sqrt();
        let of_pair = of(stokes(speed, mass / 2.0, radius / 2.0));
        assert!((pair.at(speed) - of_pair).abs() < 1e-13, "{speed}");
        let of_plate = of(stokes(speed, mass, radius));
        assert!(of_plate.is_nan() || pair.at(speed) > of_plate + 0.01);
    }
    let threshold = pair.threshold();
    assert!(pair.at(0.999 * threshold) == 0.0 && pair.at(1.001 * threshold) > 0.0);
}
