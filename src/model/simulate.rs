//! Draws runs from a truth by the one generative statement: e* = m(r) + σ z, stuck where e* is at or below the limit; with
//! noise on the energy kept e* = m(r + σ_r z′) + σ z; with offsets of series r + σ_series z″ stands for r, z″ one for the wet
//! runs of a series.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Exp1};

use crate::error::Error;
use crate::model::likelihood::tails::Tails;
use crate::model::likelihood::{normal_number, RunNoise};
use crate::physics::coefficient::Coefficients;
use crate::physics::{kept_energy, Parameters};
use crate::runs::{sphere_words, NewRun};
use crate::scene::{Design, LikelihoodFamily, NoiseShape, Scene, Truth};
use crate::seed::Streams;

/// A simulation ready to be drawn.
#[derive(Debug)]
pub struct Simulation<'s> {
    scene: &'s Scene,
    truth: &'s Truth,
    design: &'s Design,
    values: TrueValues,
    points: Vec<DesignPoint>,
    repeats: u64,
    /// so many of the first points get one run more
    extra: u64,
    /// combinations of diameter and film ratio the scene's own screens would leave out
    pub left_out: usize,
}

/// The truth's numbers, each of them given.
#[derive(Debug, Clone, Copy)]
struct TrueValues {
    shared: Coefficients,
    sigma_dry: f64,
    /// of wet runs; normal where its tails are of no family
    noise: RunNoise,
}

impl TrueValues {
    /// Fails with the names of the numbers that this truth needs and lacks.
    fn of(truth: &Truth) -> Result<TrueValues, Error> {
        let mut missing = vec![];
        let mut need = |name: &'static str, value: Option<f64>| {
            missing.extend(value.is_none().then(|| format!("`{name}`")));
            value.unwrap_or(f64::NAN)
        };
        let mut shared = Coefficients::default();
        for coefficient in truth.form.coefficients() {
            shared[coefficient] = need(coefficient.describe().name, truth.value(coefficient));
        }
        let (sigma_dry, sigma) = (need("sigma_dry", truth.sigma_dry), need("sigma_wet", truth.sigma_wet));
        let family = match truth.noise {
            NoiseShape::Family(family) => family,
            NoiseShape::Skewed | NoiseShape::Heteroscedastic => LikelihoodFamily::Normal,
        };
        let shape = family.shape().map_or(f64::NAN, |own| need(own.name, truth.shape));
        if !missing.is_empty() {
            return Err(Error::Usage(format!(
                "the scene's [truth] lacks {}, which simulate needs",
                missing.join(", ")
            )));
        }
        let noise = RunNoise {
            tails: Tails::of(family, shape),
            sigma,
            energy: truth.sigma_energy.unwrap_or(0.0),
        };
        Ok(TrueValues {
            shared,
            sigma_dry,
            noise,
        })
    }
}

/// One setting of a design, to be repeated.
#[derive(Debug, Clone, Copy)]
struct DesignPoint {
    particle: usize,
    diameter: f64,
    /// liquid, film ratio; `None` for a dry run
    wet: Option<(usize, f64)>,
    impact_speed: f64,
}

/// Runs of a block.
pub const BLOCK: u64 = 1 << 16;

/// The runs of a simulation under a seed, in blocks of [`BLOCK`]. Each has a stream of its own, so that they can be drawn in
/// any order and by anyone.
#[derive(Debug)]
pub struct SimulatedRuns<'a, 's> {
    simulation: &'a Simulation<'s>,
    streams: Streams,
    /// of every point
    offsets: Vec<f64>,
}

impl<'s> SimulatedRuns<'_, 's> {
    /// How many blocks there are; the last may be short.
    pub fn blocks(&self) -> u64 {
        self.simulation.runs().div_ceil(BLOCK)
    }

    /// The runs of a block.
    pub fn block(&self, block: u64) -> Vec<NewRun<'s>> {
        let mut rng = self.streams.at(block);
        if block == 0 {
            // the offsets come first
            self.simulation.offsets(&mut rng);
        }
        let start = block.saturating_mul(BLOCK);
        let end = start.saturating_add(BLOCK).min(self.simulation.runs());
        self.simulation.draw_rows(start..end, &self.offsets, rng)
    }

    /// Every run.
    pub fn all(&self) -> Vec<NewRun<'s>> {
        (0..self.blocks()).flat_map(|block| self.block(block)).collect()
    }
}

impl<'s> Simulation<'s> {
    /// A simulation of the scene's design; `runs` raises or lowers the repeats evenly to that many runs in all.
    ///
    /// Fails if the scene lacks a truth or a design, or the design has no settings.
    pub fn new(scene: &'s Scene, runs: Option<u64>) -> Result<Self, Error> {
        let usage = |text: &str| Err(Error::Usage(text.to_owned()));
        let (Some(truth), Some(design)) = (&scene.truth, &scene.design) else {
            return usage("the scene has no [truth] and [design]: simulate needs both");
        };
        let values = TrueValues::of(truth)?;
        let (points, left_out) = points(scene, truth, design)?;
        let count = points.len() as u64;
        if count == 0 {
            return usage("the scene's [design] has no settings: it needs diameters with dry speeds, or with liquids, film ratios and heights or speeds");
        }
        let (repeats, extra) = match runs {
            Some(runs) => (runs / count, runs % count),
            None => (design.repeats, 0),
        };
        let simulation = Simulation {
            scene,
            truth,
            design,
            values,
            points,
            repeats,
            extra,
            left_out,
        };
        match simulation.runs() {
            0..=MOST_RUNS => Ok(simulation),
            _ => Err(Error::Usage(format!(
                "[design] repeats: found {repeats} runs at each of {count} settings, expected at most {MOST_RUNS} runs in all"
            ))),
        }
    }

    /// How many runs will be drawn.
    pub fn runs(&self) -> u64 {
        let repeated = (self.points.len() as u64).saturating_mul(self.repeats);
        repeated.saturating_add(self.extra)
    }

    /// The runs under a seed.
    pub fn under(&self, seed: u64) -> SimulatedRuns<'_, 's> {
        let streams = Streams::new(seed, "simulate");
        SimulatedRuns {
            simulation: self,
            offsets: self.offsets(&mut streams.at(0)),
            streams,
        }
    }

    /// Every run, from one stream of the caller's.
    pub fn draw_from(&self, mut rng: ChaCha8Rng) -> Vec<NewRun<'s>> {
        let offsets = self.offsets(&mut rng);
        self.draw_rows(0..self.runs(), &offsets, rng)
    }

    /// Draws some of the runs from a stream.
    fn draw_rows(&self, rows: Range<u64>, offsets: &[f64], mut rng: ChaCha8Rng) -> Vec<NewRun<'s>> {
        let mut drawn = vec![];
        let mut row = rows.start;
        while row < rows.end {
            let (point, next) = self.point_of(row);
            let (offset, point) = (offsets[point], &self.points[point]);
            drawn.extend((row..next.min(rows.end)).map(|_| self.run(point, offset, &mut rng)));
            row = next;
        }
        drawn
    }

    /// The point that a run repeats, and the first run of the next one.
    fn point_of(&self, row: u64) -> (usize, u64) {
        let with_extra = self.extra * (self.repeats + 1);
        let (index, end) = if row < with_extra {
            let index = row / (self.repeats + 1);
            (index, (index + 1) * (self.repeats + 1))
        } else {
            let index = (row - with_extra) / self.repeats;
            (self.extra + index, with_extra + (index + 1) * self.repeats)
        };
        (usize::try_from(index).unwrap_or(usize::MAX), end)
    }

    /// The offset of the series of every point, drawn once a series.
    fn offsets(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let sigma = self.truth.sigma_series.unwrap_or(0.0);
        // points of one series follow one another
        let mut last = (None, 0.0);
        let of_point = |point: &DesignPoint| {
            let series = point.wet.map(|wet| (point.particle, point.diameter, wet));
            if series != last.0 {
                last = (series, normal_number(sigma, rng));
            }
            last.1
        };
        self.points.iter().map(of_point).collect()
    }

    /// One draw of the noise on a wet run, in units of its spread.
    fn wet_noise(&self, stokes: f64, rng: &mut ChaCha8Rng) -> f64 {
        match self.truth.noise {
            NoiseShape::Family(_) => self.values.noise.tails.draw(rng),
            NoiseShape::Skewed => {
                let wait: f64 = Exp1.sample(rng);
                1.0 - wait
            }
            NoiseShape::Heteroscedastic => normal_number(0.5 + 25.0 / stokes, rng),
        }
    }

    fn run(&self, point: &DesignPoint, offset: f64, rng: &mut ChaCha8Rng) -> NewRun<'s> {
        let k = self.truth.k(point.particle, point.diameter).unwrap_or_default();
        let particle = &self.scene.particles[point.particle];
        let v = own(point.impact_speed, self.design.impact_speed_rel_sd, rng);
        let (liquid, film, latent) = match point.wet {
            None => {
                let e_dry = self.truth.form.dry.restitution(k, v);
                // which m(e_dry²) is but for rounding
                (
                    None,
                    None,
                    e_dry + self.values.sigma_dry * self.values.noise.tails.draw(rng),
                )
            }
            Some((index, film_ratio)) => {
                let liquid = &self.scene.liquids[index];
                let film = own(film_ratio * point.diameter, self.design.film_rel_sd, rng).min(point.diameter);
                let setting = self.scene.setting(point.particle, index, point.diameter, film);
                let parameters = Parameters {
                    dry_k: k,
                    shared: self.values.shared,
                };
                let truth = self.truth;
                let kept = kept_energy(&setting, truth.form, &parameters, v);
                let (noise, of_noise) = (self.values.noise, self.wet_noise(setting.stokes(v), rng));
                let e = noise.restitution(kept + offset, normal_number(noise.energy, rng), of_noise);
                (Some(liquid.name.as_str()), Some((setting.film, film_ratio)), e)
            }
        };
        let stuck = latent <= self.scene.data.smallest_restitution;
        NewRun {
            particle: &particle.name,
            liquid,
            diameter: point.diameter,
            film,
            impact_speed: v,
            restitution: if stuck { 0.0 } else { latent },
        }
    }
}

/// A run's own film or speed about that of its setting.
fn own(of_setting: f64, rel_sd: Option<f64>, rng: &mut ChaCha8Rng) -> f64 {
    of_setting * normal_number(rel_sd.unwrap_or(0.0), rng).exp()
}

/// Runs of the largest simulation: some forty terabytes.
pub const MOST_RUNS: u64 = 1_000_000_000_000;

/// Settings of the largest design.
pub const MOST_SETTINGS: usize = 1_000_000;

/// Checks how many settings the lists of a design make, before any of them is made.
fn check_settings(design: &Design) -> Result<(), Error> {
    let films = design.liquids.len().max(1).saturating_mul(design.speeds.len().max(1));
    let of_particle = |(diameters, film_ratios): (&Vec<f64>, &Vec<f64>)| {
        let of_diameter = film_ratios
            .len()
            .saturating_mul(films)
            .saturating_add(design.dry_speeds.len());
        diameters.len().saturating_mul(of_diameter)
    };
    let each = design.diameters.iter().zip(&design.film_ratios).map(of_particle);
    let all = each.fold(0, usize::saturating_add);
    if all <= MOST_SETTINGS {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "[design]: found {all} combinations of particle, diameter, film ratio, liquid and speed, expected at most \
         {MOST_SETTINGS}; repeats makes more runs of them"
    )))
}

/// Every setting of a design in order: dry runs, then film ratio by liquid by diameter by speed, for each particle.
///
/// A film the scene's own screens would leave out is not made; such combinations are counted.
fn points(scene: &Scene, truth: &Truth, design: &Design) -> Result<(Vec<DesignPoint>, usize), Error> {
    let screens = &scene.data.screens;
    check_settings(design)?;
    let mut points = vec![];
    let mut left_out = 0;
    for particle in 0..scene.particles.len() {
        let diameters = &design.diameters[particle];
        if let Some(missing) = diameters.iter().find(|d| truth.k(particle, **d).is_none()) {
            let by_diameter = Some(*missing).filter(|_| !truth.dry_k_by_diameter[particle].is_empty());
            let name = sphere_words(&scene.particles[particle].name, by_diameter);
            let text = format!("[truth] dry_k has no value for {name}, which [design] uses");
            return Err(Error::Usage(text));
        }
        let mut add = |diameter: f64, wet: Option<(usize, f64)>, speeds: &[f64]| {
            points.extend(speeds.iter().map(|&impact_speed| DesignPoint {
                particle,
                diameter,
                wet,
                impact_speed,
            }));
        };
        for &diameter in diameters {
            add(diameter, None, &design.dry_speeds);
        }
        for &film_ratio in &design.film_ratios[particle] {
            let is_made = |diameter: &f64| {
                let thin = screens.min_film.is_some_and(|least| film_ratio * diameter < least);
                !thin && film_ratio <= screens.max_film_ratio
            };
            let made: Vec<f64> = diameters.iter().copied().filter(is_made).collect();
            left_out += diameters.len() - made.len();
            for &liquid in &design.liquids {
                for &diameter in &made {
                    add(diameter, Some((liquid, film_ratio)), &design.speeds);
                }
            }
        }
    }
    Ok((points, left_out))
}
