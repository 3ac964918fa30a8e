//! Tests of the integral over the energy kept against a rule of so many nodes that it needs no care.

use rand::rngs::ChaCha8Rng;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::*;
use crate::model::likelihood::normal::ln_normal_cdf;

/// A run with its restitution or limit.
#[derive(Debug, Clone, Copy)]
struct Case {
    e: f64,
    r: f64,
    spreads: Spreads,
}

/// Spreads over three decades each, energies at and about the turn and far from it, restitutions to five spreads off.
fn cases(name: &str, count: usize) -> Vec<Case> {
    let mut rng = crate::seed::stream(1, name, 0);
    (0..count).map(|index| case(&mut rng, index)).collect()
}

fn case(rng: &mut ChaCha8Rng, index: usize) -> Case {
    let spread = |rng: &mut ChaCha8Rng| 10f64.powf(rng.random_range(-3.7..-0.7));
    let spreads = Spreads {
        sigma: spread(rng),
        energy: spread(rng),
    };
    let r = match index % 3 {
        0 => rng.random_range(-0.2..0.9),
        1 => 10f64.powf(rng.random_range(-6.0..-1.0)) * if rng.random() { 1.0 } else { -1.0 },
        _ => spreads.energy * rng.random_range(-2.0..2.0),
    };
    let wide = [1.0, 1.0, 2.0][index % 2 + usize::from(index.is_multiple_of(7))];
    let mut z = || {
        let z: f64 = StandardNormal.sample(rng);
        wide * z
    };
    let e = mean_restitution(r + spreads.energy * z()) + spreads.sigma * z();
    Case { e, r, spreads }
}

/// ln ∫ φ(z′) f(z′) dz′, in a variable in which the turn is as wide as anything else, with 100,000 steps.
fn brute(case: &Case, ln_f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 100_000;
    const TURN2: f64 = TURN * TURN;
    let Case { r, spreads, .. } = case;
    let far = 14.0 * spreads.energy;
    // as far as where e lies, where a run is as unlikely as that
    let y = kept_and_slope(case.e).0;
    let (lo, hi) = ((r - far).min(y - far), (r + far).max(y + far));
    let (lo, hi) = ((lo / TURN2).asinh(), (hi / TURN2).asinh());
    let step = (hi - lo) / STEPS as f64;
    let ln_parts: Vec<f64> = (0..=STEPS)
        .map(|index| {
            let s = lo + step * index as f64;
            let z = (TURN2 * s.sinh() - r) / spreads.energy;
            ln_f(TURN2 * s.sinh()) - 0.5 * z * z + (TURN2 * s.cosh()).ln()
        })
        .collect();
    let most = ln_parts.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = ln_parts.iter().map(|ln| (ln - most).exp()).sum();
    most + (sum * step / spreads.energy / std::f64::consts::TAU.sqrt()).ln()
}

fn brute_density(case: &Case) -> f64 {
    let Spreads { sigma, .. } = case.spreads;
    brute(case, |y| {
        let z = (case.e - mean_restitution(y)) / sigma;
        -0.5 * z * z - sigma.ln() - 0.5 * std::f64::consts::TAU.ln()
    })
}

fn brute_probability(case: &Case, side: Side) -> f64 {
    let sign = if side == Side::Below { 1.0 } else { -1.0 };
    brute(case, |y| {
        ln_normal_cdf(sign * (case.e - mean_restitution(y)) / case.spreads.sigma).0
    })
}

/// Largest distance of a log from that of very many nodes; of logs below −1, as a share of these.
fn worst(cases: &[Case], found: impl Fn(&Case) -> f64 + Sync, expected: impl Fn(&Case) -> f64 + Sync) -> f64 {
    let gap = |case: &Case| {
        let expected = expected(case);
        let gap = (found(case) - expected).abs() / expected.abs().max(1.0);
        assert!(gap < 1e-6, "{case:?}: {} {expected}", found(case));
        gap
    };
    cases.par_iter().map(gap).reduce(|| 0.0, f64::max)
}

#[test]
fn the_density_is_that_of_very_many_nodes() {
    let cases = cases("the_density_is_that_of_very_many_nodes", 100);
    let exact = |case: &Case| ln_density(Tails::Normal, case.e, case.r, case.spreads).value;
    let gap = worst(&cases, exact, brute_density);
    assert!(gap < 1e-7, "{gap:e}");
    // the density it stands in the place of: normal at y = m⁻¹(e), the width of σ there to first order
    let first_order = |case: &Case| {
        let (y, stretch) = kept_and_slope(case.e);
        let spread = (case.spreads.sigma * stretch).hypot(case.spreads.energy);
        let z = (y - case.r) / spread;
        -0.5 * z * z - (spread * std::f64::consts::TAU.sqrt() / stretch).ln()
    };
    let far = cases
        .iter()
        .filter(|case| (first_order(case) - exact(case)).abs() > 1e-2);
    assert!(far.count() > 30);
}

#[test]
fn the_probability_is_that_of_very_many_nodes() {
    let cases = cases("the_probability_is_that_of_very_many_nodes", 60);
    for limit in [Some(0.0), Some(0.05), None] {
        let at = |case: &Case| Case {
            e: limit.unwrap_or(case.e),
            ..*case
        };
        let cases: Vec<Case> = cases.iter().map(at).collect();
        for side in [Side::Below, Side::Above] {
            let exact = |case: &Case| ln_probability(Tails::Normal, side, case.e, case.r, case.spreads).value;
            let gap = worst(&cases, exact, |case| brute_probability(case, side));
            assert!(gap < 1e-7, "{gap:e}");
        }
    }
}

#[test]
fn several_at_a_time_are_as_one() {
    let (mut together, mut alone) = (0, 0);
    for chunk in cases("several_at_a_time_are_as_one", 200).chunks(7) {
        // rebounds of one call have their spreads in common
        for spreads in chunk.iter().map(|case| case.spreads) {
            let restitutions: Vec<f64> = chunk.iter().map(|case| case.e).collect();
            let kept: Vec<f64> = chunk.iter().map(|case| case.r).collect();
            let mut found = vec![None; chunk.len()];
            ln_densities([&restitutions, &kept], spreads, &mut found);
            for (case, found) in chunk.iter().zip(found) {
                let Some(found) = found else {
                    alone += 1;
                    continue;
                };
                together += 1;
                let expected = ln_density(Tails::Normal, case.e, case.r, spreads);
                let near = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-11 * (scale + b.abs());
                assert!(
                    near(found.value, expected.value, 1.0),
                    "{case:?} {found:?} {expected:?}"
                );
                let slopes = [
                    (found.kept, expected.kept, spreads.energy),
                    (found.sigma, expected.sigma, spreads.sigma),
                    (found.energy, expected.energy, spreads.energy),
                ];
                for (found, expected, spread) in slopes {
                    // in units of the spread slopes are of order one and more
                    let near_enough = near(found * spread, expected * spread, 1.0);
                    assert!(near_enough, "{case:?} {found} {expected}");
                }
            }
        }
    }
    assert!(together > 200 && alone > 200, "{together} {alone}");
}

/// Student's tails: their scale is drawn once for both noises, so that the density is a mixture of normal ones.
#[test]
fn students_tails_are_a_mixture_over_the_scale_that_both_noises_share() {
    const STEPS: usize = 3000;
    for case in cases("students_tails_are_a_mixture", 40) {
        for nu in [2.3, 6.0, 40.0] {
            let tails = Tails::of(Some(nu));
            // χ² over ν in its logarithm
            let (lo, hi) = (-30.0, 3.0);
            let step = (hi - lo) / STEPS as f64;
            let constant = 0.5 * nu * (0.5 * nu).ln() - libm::lgamma(0.5 * nu);
            let mixed = |ln_of: &dyn Fn(Spreads) -> f64| {
                let part = |index: usize| {
                    let u: f64 = lo + step * (index as f64 + 0.5);
                    let wide = tails.scale(nu * u.exp());
                    let spreads = Spreads {
                        sigma: case.spreads.sigma * wide,
                        energy: case.spreads.energy * wide,
                    };
                    (ln_of(spreads) + 0.5 * nu * (u - u.exp()) + constant).exp() * step
                };
                (0..STEPS).map(part).sum::<f64>().ln()
            };
            let found = ln_density(tails, case.e, case.r, case.spreads).value;
            let expected = mixed(&|spreads| ln_density(Tails::Normal, case.e, case.r, spreads).value);
            assert!((found - expected).abs() < 1e-6, "{case:?} {nu}: {found} {expected}");
            for side in [Side::Below, Side::Above] {
                let found = ln_probability(tails, side, case.e, case.r, case.spreads).value;
                let expected = mixed(&|spreads| ln_probability(Tails::Normal, side, case.e, case.r, spreads).value);
                assert!(
                    (found - expected).abs() < 1e-6,
                    "{case:?} {nu} {side:?}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn slopes_agree_with_differences() {
    for case in cases("slopes_of_the_convolution_agree_with_differences", 60) {
        for nu in [None, Some(3.0)] {
            for which in [None, Some(Side::Below), Some(Side::Above)] {
                let at = |place: usize, step: f64| {
                    let mut of = [case.r, case.spreads.sigma, case.spreads.energy, nu.unwrap_or(1.0)];
                    of[place] += step;
                    let spreads = Spreads {
                        sigma: of[1],
                        energy: of[2],
                    };
                    let tails = Tails::of(nu.map(|_| of[3]));
                    match which {
                        None => ln_density(tails, case.e, of[0], spreads),
                        Some(side) => ln_probability(tails, side, case.e, of[0], spreads),
                    }
                };
                let found = at(0, 0.0);
                let slopes = [found.kept, found.sigma, found.energy, found.nu];
                let smallest = case.spreads.sigma.min(case.spreads.energy);
                let scales = [smallest, case.spreads.sigma, case.spreads.energy, nu.unwrap_or(1.0)];
                for (place, (slope, scale)) in slopes.into_iter().zip(scales).enumerate() {
                    if place == 3 && nu.is_none() {
                        assert_eq!(slope, 0.0);
                        continue;
                    }
                    let h = 2e-3 * scale;
                    let of = |step: f64| at(place, step * h).value;
                    // the fifth order is left out
                    let difference = (8.0 * (of(1.0) - of(-1.0)) - (of(2.0) - of(-2.0))) / (12.0 * h);
                    let gap = (slope - difference).abs() * scale / (1.0 + (difference * scale).abs());
                    assert!(gap < 1e-6, "{case:?} {nu:?} {which:?} {place}: {slope} {difference}");
                }
            }
        }
    }
}

/// Where a search for the mode may try them: nothing is returned that could pass for a density, and nothing panics.
#[test]
fn parameters_beyond_all_numbers_have_no_density() {
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for tails in [Tails::Normal, Tails::of(Some(4.0))] {
            for (r, sigma, energy) in [(odd, 0.01, 0.02), (0.3, odd, 0.02), (0.3, 0.01, odd), (odd, odd, odd)] {
                let spreads = Spreads { sigma, energy };
                let density = ln_density(tails, 0.4, r, spreads);
                let finite = density.value.is_finite() && density.kept.is_finite();
                assert!(!finite, "{tails:?} {r} {spreads:?} {density:?}");
                for side in [Side::Below, Side::Above] {
                    ln_probability(tails, side, 0.05, r, spreads);
                }
            }
        }
    }
}

/// A sum over the panels that were reached would pass for the integral.
#[test]
fn an_integral_that_does_not_reach_its_end_is_none() {
    let length = |sigma: f64| {
        let spreads = Spreads { sigma, energy: 0.02 };
        let curve = Curve::new(Tails::Normal, 0.4, 0.3, spreads);
        let nearest = Nearest { x: 0.4, square: 0.0 };
        let mut sum = 0.0;
        let range = Range { lo: -1.0, hi: 1.0 };
        curve.over_panels(range, nearest, WIDTHS, &mut |_, weight| sum += weight);
        sum
    };
    assert!((length(0.01) - 2.0).abs() < 1e-9);
    assert!(length(1e-6).is_nan());
}
