//! Simulates a homogeneous gas of equal smooth hard spheres by direct simulation Monte Carlo.
//!
//! Bird's scheme without a time counter (Bird 1994, Molecular Gas Dynamics and the Direct Simulation of Gas Flows, ch. 11):
//! pairs are proposed at the rate of a bound on their normal relative speed, and accepted with the share of the bound that
//! theirs is. The gas is dilute and uniform, so that a sphere is its velocity. Spheres do not spin.

use std::array::from_fn;

use rand::{rngs::ChaCha8Rng, RngExt};
use rand_distr::{Distribution, StandardNormal, UnitSphere};

/// m/s
pub type Velocity = [f64; 3];

fn dot(a: Velocity, b: Velocity) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The velocities after an impact along a unit normal: the normal relative velocity turns round and is e(v) times as large,
/// v being its size before. Where e is 0 the pair loses it and nothing else.
pub fn collide([one, other]: [Velocity; 2], normal: Velocity, law: impl FnOnce(f64) -> f64) -> [Velocity; 2] {
    let approach = dot(one, normal) - dot(other, normal);
    let change = 0.5 * (1.0 + law(approach.abs())) * approach;
    [
        from_fn(|axis| one[axis] - change * normal[axis]),
        from_fn(|axis| other[axis] + change * normal[axis]),
    ]
}

/// A gas at rest as a whole.
pub struct Gas {
    velocities: Vec<Velocity>,
    /// π D² n, the spheres met on a metre of relative path, 1/m
    met_per_metre: f64,
    /// no sphere is faster, m/s
    fastest: f64,
    /// s
    time: f64,
    collisions: u64,
    rng: ChaCha8Rng,
}

impl Gas {
    /// Normal velocities of a temperature in m²/s², met exactly, and of no momentum.
    pub fn new(spheres: usize, temperature: f64, met_per_metre: f64, mut rng: ChaCha8Rng) -> Gas {
        let draw = |_| from_fn(|_| StandardNormal.sample(&mut rng));
        let mut gas = Gas {
            velocities: (0..spheres).map(draw).collect(),
            met_per_metre,
            fastest: 0.0,
            time: 0.0,
            collisions: 0,
            rng,
        };
        let mean = gas.momentum();
        gas.velocities
            .iter_mut()
            .for_each(|v| *v = from_fn(|axis| v[axis] - mean[axis]));
        let scale = (temperature / gas.temperature()).sqrt();
        gas.velocities
            .iter_mut()
            .for_each(|v| *v = v.map(|component| component * scale));
        gas
    }

    /// Goes on to a time, s, with a rule for the velocities of a pair after an impact along a normal.
    pub fn advance(&mut self, until: f64, mut rule: impl FnMut([Velocity; 2], Velocity) -> [Velocity; 2]) {
        let spheres = self.velocities.len();
        while self.time < until {
            // the bound follows the cooling, or nearly every pair would be rejected
            self.fastest = self.velocities.iter().fold(0.0, |most, v| dot(*v, *v).max(most)).sqrt();
            for _ in 0..spheres {
                if self.time >= until {
                    break;
                }
                let bound = 2.0 * self.fastest;
                // the mean wait: a normal of either sign is drawn, so that half of the rate is of pairs that part
                self.time += 1.0 / (spheres as f64 * self.met_per_metre * bound);
                let one = self.rng.random_range(0..spheres);
                let other = (one + self.rng.random_range(1..spheres)) % spheres;
                let normal = UnitSphere.sample(&mut self.rng);
                let pair = [self.velocities[one], self.velocities[other]];
                let approach = (dot(pair[0], normal) - dot(pair[1], normal)).abs();
                if self.rng.random::<f64>() * bound < approach {
                    let [after, other_after] = rule(pair, normal);
                    self.fastest = self
                        .fastest
                        .max(dot(after, after).max(dot(other_after, other_after)).sqrt());
                    (self.velocities[one], self.velocities[other]) = (after, other_after);
                    self.collisions += 1;
                }
            }
        }
    }

    /// Time gone, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Impacts that a sphere has had in the mean; each is one of two spheres.
    pub fn collisions_per_sphere(&self) -> f64 {
        2.0 * self.collisions as f64 / self.velocities.len() as f64
    }

    /// Variance of a component of velocity, m²/s²; three of all are fixed, since the momentum is.
    pub fn temperature(&self) -> f64 {
        let square: f64 = self.velocities.iter().map(|v| dot(*v, *v)).sum();
        square / (3 * (self.velocities.len() - 1)) as f64
    }

    /// Momentum of a sphere in the mean, over its mass, m/s.
    pub fn momentum(&self) -> Velocity {
        from_fn(|axis| self.velocities.iter().map(|v| v[axis]).sum::<f64>() / self.velocities.len() as f64)
    }
}
