//! Computes what each run contributes to the log likelihood, its expected restitution, and a new draw of it.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::normal::ln_normal_cdf;
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::model::priors::LN_ROOT_TWO_PI;
use crate::physics::impact::DrySpeed;
use crate::physics::inertia::Inertia;
use crate::physics::{numbers, rebound};
use crate::runs::Runs;
use crate::scene::Scene;

/// The runs of a scene, in the order of [`Runs`], ready for one run at a time.
#[derive(Debug)]
pub struct Pointwise<'r> {
    inertia: Inertia,
    limit: f64,
    runs: Vec<Run>,
    restitution: &'r [f64],
}

/// What a run's restitution depends on.
#[derive(Debug, Clone, Copy)]
struct Run {
    particle: usize,
    /// v^(1/5) at the dry speed in use
    dry_power: f64,
    wet: Option<Wet>,
    stuck: bool,
}

#[derive(Debug, Clone, Copy)]
struct Wet {
    density_ratio: f64,
    film_ratio: f64,
    /// 4/St
    viscous: f64,
}

/// The law at one full vector of parameters.
#[derive(Debug, Clone, Copy)]
pub struct At<'p, 'r> {
    pointwise: &'p Pointwise<'r>,
    full: &'p [f64],
}

impl<'r> Pointwise<'r> {
    /// The runs under this form of inertia and dry speed.
    pub fn new(scene: &Scene, runs: &'r Runs, inertia: Inertia, dry_speed: DrySpeed) -> Pointwise<'r> {
        let mut all = Vec::with_capacity(runs.len());
        for group in &runs.dry {
            for run in group.rebounds.start..group.stuck.end {
                all.push(Run {
                    particle: group.particle,
                    dry_power: runs.impact_speed[run].powf(0.2),
                    wet: None,
                    stuck: group.stuck.contains(&run),
                });
            }
        }
        for series in &runs.series {
            let particle = &scene.particles[series.particle];
            let liquid = &scene.liquids[series.liquid];
            for run in series.runs() {
                let (v, d) = (runs.impact_speed[run], runs.diameter[run]);
                all.push(Run {
                    particle: series.particle,
                    dry_power: dry_speed.of(v).powf(0.2),
                    wet: Some(Wet {
                        density_ratio: liquid.density / particle.density,
                        film_ratio: runs.film[run] / d,
                        viscous: 4.0 / numbers::stokes(particle.density, d, v, liquid.viscosity),
                    }),
                    stuck: series.stuck.contains(&run),
                });
            }
        }
        Pointwise {
            inertia,
            limit: scene.data.smallest_restitution,
            runs: all,
            restitution: &runs.restitution,
        }
    }

    /// Runs.
    pub fn len(&self) -> usize {
        self.runs.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Whether a run stuck.
    pub fn is_stuck(&self, run: usize) -> bool {
        self.runs[run].stuck
    }

    /// The law at a full vector of parameters.
    pub fn at<'p>(&'p self, full: &'p [f64]) -> At<'p, 'r> {
        At { pointwise: self, full }
    }
}

impl At<'_, '_> {
    /// Mean of e* and its spread: m(r) and σ_wet, or e_dry and σ_dry.
    pub fn mean_and_sigma(&self, run: usize) -> (f64, f64) {
        let run = &self.pointwise.runs[run];
        let at = |kind: Kind| self.full[kind.slot()];
        let e_dry = 1.0 - self.full[COMMON_SLOTS + run.particle] * run.dry_power;
        let Some(wet) = run.wet else {
            return (e_dry, at(Kind::SigmaDry));
        };
        let shape = self.pointwise.inertia.shape(wet.film_ratio, at(Kind::FilmScale));
        let inertial = at(Kind::InertialPrefactor) * wet.density_ratio * shape;
        let kept = e_dry * e_dry - inertial - at(Kind::LubricationLog) * wet.viscous;
        (rebound::mean_restitution(kept), at(Kind::SigmaWet))
    }

    /// Log likelihood of a run: a density where it rebounded, a probability where it stuck.
    pub fn ln_likelihood(&self, run: usize) -> f64 {
        let (mean, sigma) = self.mean_and_sigma(run);
        if self.pointwise.runs[run].stuck {
            return ln_normal_cdf((self.pointwise.limit - mean) / sigma).0;
        }
        let z = (self.pointwise.restitution[run] - mean) / sigma;
        -0.5 * z * z - LN_ROOT_TWO_PI - sigma.ln()
    }

    /// A new draw of a run's restitution; 0 where it would have stuck.
    pub fn predict<R: Rng + ?Sized>(&self, run: usize, rng: &mut R) -> f64 {
        let (mean, sigma) = self.mean_and_sigma(run);
        let z: f64 = StandardNormal.sample(rng);
        let e = mean + sigma * z;
        if e <= self.pointwise.limit {
            0.0
        } else {
            e
        }
    }
}
