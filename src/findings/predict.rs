//! Predicts the restitution at speeds of the user's choice from the draws of a posterior.
//!
//! Two questions have two answers. The curve of a simulation, √max(r, 0) of the energy balance, is uncertain as the
//! parameters are: its bands are quantiles over the draws, and narrow with more runs. A single run of an experiment
//! scatters about it as well: e* = m(r) + σ z, stuck and written 0 where e* ≤ `smallest_restitution`. Its bands are
//! quantiles of the mixture of those distributions over all draws with the probability of sticking as a mass at 0, solved for
//! to rounding instead of sampled, so that nothing here takes chance.
//!
//! Where series have offsets of r, both are of one series: of one that was measured with its own offset, of a new one with an
//! offset that σ_series spreads, the quantiles of which are dealt out evenly over the draws.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::range::range;
use crate::distributions::normal_quantile;
use crate::inference::diagnostics::quantile;
use crate::model::likelihood::tails::Tails;
use crate::model::likelihood::{BelowRestitution, Spreads};
use crate::physics::rebound::mean_restitution;
use crate::physics::restitution::Restitution;
use crate::physics::{Form, LawNumbers, Parameters, Setting};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// What a prediction needs of a scene and its runs besides the draws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Basis {
    /// a restitution at or below this counts as stuck
    pub smallest_restitution: f64,
    /// the particles of the scene
    pub particles: Vec<ParticleBasis>,
    /// the liquids of the scene
    pub liquids: Vec<LiquidBasis>,
}

/// A particle, and where its wet runs were made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParticleBasis {
    /// its name
    pub name: String,
    /// ρp
    pub density_kg_m3: f64,
    /// ε, where it is known
    pub roughness_m: Option<f64>,
    /// its diameters that have a k of their own, m; empty where one k is that of all
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dry_k_diameters_m: Vec<f64>,
    /// what its wet runs in use covered, the stuck ones with them; `None` without any
    pub covered: Option<Covered>,
    /// the same of each liquid they were made in
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covered_in: Vec<CoveredIn>,
    /// slowest and fastest of its dry runs in use, m/s; `None` without any
    #[serde(default)]
    pub dry_speeds_m_s: Option<[f64; 2]>,
}

/// Smallest and largest numbers of some runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Covered {
    /// Stokes numbers
    pub stokes: [f64; 2],
    /// film ratios
    pub film_ratio: [f64; 2],
}

/// What the wet runs of a particle in one liquid covered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoveredIn {
    /// name of the liquid
    pub liquid: String,
    /// slowest and fastest, m/s
    pub impact_speed_m_s: [f64; 2],
    /// Stokes numbers
    pub stokes: [f64; 2],
    /// film ratios
    pub film_ratio: [f64; 2],
}

/// What the runs in a liquid covered, the liquid being told by its density and viscosity as a [`Setting`] has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiquidRange {
    /// ρl, kg/m³
    pub density: f64,
    /// η, Pa s
    pub viscosity: f64,
    /// slowest and fastest, m/s
    pub impact_speed: [f64; 2],
    /// Stokes numbers and film ratios
    pub covered: Covered,
}

/// A liquid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LiquidBasis {
    /// its name
    pub name: String,
    /// ρl
    pub density_kg_m3: f64,
    /// η
    #[serde(rename = "viscosity_Pa_s")]
    pub viscosity_pa_s: f64,
    /// γ, where it is known
    #[serde(rename = "surface_tension_N_m", default, skip_serializing_if = "Option::is_none")]
    pub surface_tension_n_m: Option<f64>,
}

impl Basis {
    /// What these runs leave to predict from.
    pub fn of(scene: &Scene, runs: &Runs) -> Basis {
        let particles = scene
            .particles
            .iter()
            .enumerate()
            .map(|(index, particle)| ParticleBasis {
                name: particle.name.clone(),
                density_kg_m3: particle.density,
                roughness_m: particle.roughness,
                dry_k_diameters_m: diameters_with_k(runs, index),
                covered: covered(runs, index, None),
                covered_in: (0..scene.liquids.len())
                    .filter_map(|liquid| {
                        let Covered { stokes, film_ratio } = covered(runs, index, Some(liquid))?;
                        let speeds = series_in(runs, index, Some(liquid))
                            .flat_map(|series| series.runs().map(|run| runs.impact_speed[run]));
                        Some(CoveredIn {
                            liquid: scene.liquids[liquid].name.clone(),
                            impact_speed_m_s: range(speeds)?,
                            stokes,
                            film_ratio,
                        })
                    })
                    .collect(),
                dry_speeds_m_s: range(dry_speeds(runs, index)),
            });
        let liquids = scene.liquids.iter().map(|liquid| LiquidBasis {
            name: liquid.name.clone(),
            density_kg_m3: liquid.density,
            viscosity_pa_s: liquid.viscosity,
            surface_tension_n_m: liquid.surface_tension,
        });
        Basis {
            smallest_restitution: scene.data.smallest_restitution,
            particles: particles.collect(),
            liquids: liquids.collect(),
        }
    }

    /// What the runs of one of its particles covered, liquid by liquid.
    pub fn ranges(&self, particle: &ParticleBasis) -> Vec<LiquidRange> {
        let of = |own: &CoveredIn| {
            let liquid = self.liquids.iter().find(|liquid| liquid.name == own.liquid)?;
            Some(LiquidRange {
                density: liquid.density_kg_m3,
                viscosity: liquid.viscosity_pa_s,
                impact_speed: own.impact_speed_m_s,
                covered: Covered {
                    stokes: own.stokes,
                    film_ratio: own.film_ratio,
                },
            })
        };
        particle.covered_in.iter().filter_map(of).collect()
    }
}

fn diameters_with_k(runs: &Runs, particle: usize) -> Vec<f64> {
    let spheres = &runs.spheres[runs.spheres_of(particle)];
    spheres.iter().filter_map(|sphere| sphere.diameter).collect()
}

/// The series of a particle in a liquid; `None`: in all of them.
fn series_in(runs: &Runs, particle: usize, liquid: Option<usize>) -> impl Iterator<Item = &Series> + Clone {
    let all = runs.series_in(runs.spheres_of(particle)).iter();
    all.filter(move |series| liquid.is_none_or(|liquid| series.liquid == liquid))
}

fn covered(runs: &Runs, particle: usize, liquid: Option<usize>) -> Option<Covered> {
    let numbers = |run: usize| (1.0 / runs.inverse_stokes(run), runs.impacts.film_ratio[run]);
    let all = series_in(runs, particle, liquid).flat_map(|series| series.runs().map(numbers));
    let stokes = range(all.clone().map(|(stokes, _)| stokes))?;
    let film_ratio = range(all.map(|(_, film_ratio)| film_ratio))?;
    Some(Covered { stokes, film_ratio })
}

fn dry_speeds(runs: &Runs, particle: usize) -> impl Iterator<Item = f64> + '_ {
    let groups = runs.dry_in(runs.spheres_of(particle)).iter();
    groups.flat_map(|group| &runs.impact_speed[group.runs()]).copied()
}

impl Covered {
    /// Whether a Stokes number and a film ratio lie inside, but for the rounding of units.
    pub fn holds(&self, stokes: f64, film_ratio: f64) -> bool {
        is_within(self.stokes, stokes) && is_within(self.film_ratio, film_ratio)
    }
}

/// Whether a number lies in a range, but for the rounding of units.
fn is_within([lo, hi]: [f64; 2], x: f64) -> bool {
    const ROUNDING: f64 = 1e-9;
    x >= lo * (1.0 - ROUNDING) && x <= hi * (1.0 + ROUNDING)
}

/// The law of one particle as a posterior has it.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleLaw {
    /// the terms of the energy balance
    pub form: Form,
    /// a restitution at or below this counts as stuck
    pub smallest_restitution: f64,
    /// what its wet runs covered
    pub covered: Option<Covered>,
    /// the same of each liquid they were made in; empty where that is not known
    pub ranges: Vec<LiquidRange>,
    /// slowest and fastest of its dry runs, m/s
    pub dry_speeds: Option<[f64; 2]>,
    /// the draws, at least one
    pub draws: Vec<Draw>,
}

/// One draw of what an impact depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draw {
    /// parameters of the energy balance
    pub parameters: Parameters,
    /// spread σ of dry restitutions
    pub sigma_dry: f64,
    /// spread σ of wet restitutions; 0 where measurement errors are all that scatters them, which a prediction has none of
    pub sigma_wet: f64,
    /// spread σ_r of the energy kept; 0 where noise acts on the restitution alone
    pub sigma_energy: f64,
    /// the distribution of the noise
    pub tails: Tails,
    /// offset of r of the series that is predicted; 0 where series have none
    pub series_offset: f64,
}

/// The series that a prediction is of, where series have offsets of r.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictedSeries {
    /// one that was not measured
    New,
    /// the one of that particle, liquid, diameter and film
    Measured,
}

impl PredictedSeries {
    /// Its word in files.
    pub fn name(self) -> &'static str {
        match self {
            PredictedSeries::New => "new",
            PredictedSeries::Measured => "measured",
        }
    }
}

/// The offset of a new series that a draw is given, by its number from 0: quantiles of the normal of this sd, as evenly
/// spread over any stretch of the draws as can be.
pub fn offset_of_new_series(draw: usize, sigma_series: f64) -> f64 {
    /// the golden section less 1: its multiples leave no gap (Kronecker's sequence)
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    sigma_series * normal_quantile(((draw as f64 + 0.5) * GOLDEN).fract())
}

/// What is to be expected at one impact speed. Field names are those of files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Predicted {
    /// v
    pub impact_speed_m_s: f64,
    /// St = ρp D v/(9 η); `None` of a dry impact
    pub stokes: Option<f64>,
    /// Re = ρl δ v/η; `None` of a dry impact
    pub reynolds: Option<f64>,
    /// posterior median of the curve √max(r, 0); 0: no rebound
    pub restitution: f64,
    /// 5 % point of the curve, from the parameters' uncertainty alone
    pub restitution_q05: f64,
    /// 25 % point of the curve
    pub restitution_q25: f64,
    /// 75 % point of the curve
    pub restitution_q75: f64,
    /// 95 % point of the curve
    pub restitution_q95: f64,
    /// 5 % point of a single run, scatter and sticking included; 0: stuck
    pub run_q05: f64,
    /// 25 % point of a single run
    pub run_q25: f64,
    /// 75 % point of a single run
    pub run_q75: f64,
    /// 95 % point of a single run
    pub run_q95: f64,
    /// probability that a single run sticks
    pub stuck_probability: f64,
    /// posterior median of d ln e/d ln v of the curve, +∞ where a draw does not rebound; `None` unless finite
    pub log_slope: Option<f64>,
    /// whether the speed, the Stokes number or the film ratio lies outside what the particle's runs in the liquid covered; of
    /// a dry impact the speed
    pub extrapolated: bool,
}

/// Between which restitutions all but 5 % on each side lie at one impact speed; below 0: 0, no rebound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedBand {
    /// v
    pub impact_speed: f64,
    /// 5 % and 95 % points of the curve, from the parameters' uncertainty alone
    pub curve: [f64; 2],
    /// 5 % and 95 % points of a single run, before the smallest restitution that is told from sticking cuts them
    pub run: [f64; 2],
}

impl ParticleLaw {
    /// Predictions at impact speeds above zero, m/s, in their order.
    pub fn predict(&self, setting: &Setting, impact_speeds: &[f64]) -> Vec<Predicted> {
        let curves = self.curves(setting);
        let speeds = impact_speeds.par_iter();
        let numbers = |v: f64| [setting.stokes(v), setting.reynolds(v)];
        let at = |v: &f64| self.at(&curves, *v, Some(numbers(*v)), self.holds(Some(setting), *v));
        speeds.map(at).collect()
    }

    /// Predictions of dry impacts at speeds above zero, m/s, in their order.
    pub fn predict_dry(&self, impact_speeds: &[f64]) -> Vec<Predicted> {
        let curves = self.dry_curves();
        let at = |v: &f64| self.at(&curves, *v, None, self.holds(None, *v));
        impact_speeds.par_iter().map(at).collect()
    }

    /// What the runs in the liquid of a setting covered; `None` where none was made in it.
    pub fn range_in(&self, setting: &Setting) -> Option<&LiquidRange> {
        let is_same = |own: f64, given: f64| is_within([own; 2], given);
        let mut ranges = self.ranges.iter();
        ranges.find(|own| is_same(own.density, setting.liquid_density) && is_same(own.viscosity, setting.viscosity))
    }

    /// Whether runs of the particle, in the liquid of a setting, covered it at a speed; `None`: of dry impacts.
    fn holds(&self, wet: Option<&Setting>, v: f64) -> bool {
        let Some(setting) = wet else {
            return self.dry_speeds.is_some_and(|speeds| is_within(speeds, v));
        };
        let inside = |covered: &Covered| covered.holds(setting.stokes(v), setting.film_ratio());
        if self.ranges.is_empty() {
            return self.covered.as_ref().is_some_and(inside);
        }
        let own = self.range_in(setting);
        own.is_some_and(|own| is_within(own.impact_speed, v) && inside(&own.covered))
    }

    /// Bands at impact speeds above zero, m/s, in their order.
    pub fn bands(&self, setting: &Setting, impact_speeds: &[f64]) -> Vec<PredictedBand> {
        const ENDS: [f64; 2] = [0.05, 0.95];
        /// single runs take every so many of the draws: their noise smooths what a curve's quantile needs all draws for
        const SPARSER: usize = 8;
        let curves = self.curves(setting);
        let band = |v: &f64| {
            let e = quantile::sorted(curves.iter().map(|(curve, _)| curve.at(*v)).collect());
            let run = SingleRun::new(curves.iter().step_by(SPARSER), *v, 0.0);
            PredictedBand {
                impact_speed: *v,
                curve: ENDS.map(|probability| quantile::of_sorted(&e, probability)),
                run: ENDS.map(|probability| run.quantile(probability)),
            }
        };
        impact_speeds.par_iter().map(band).collect()
    }

    /// The curve of each draw.
    pub fn restitutions(&self, setting: &Setting) -> Vec<Restitution> {
        self.curves(setting).into_iter().map(|(curve, _)| curve).collect()
    }

    /// The curve alone, to be read at one speed after the other; `None`: of dry impacts.
    pub fn curve(&self, wet: Option<&Setting>) -> PredictedCurve<'_> {
        PredictedCurve {
            law: self,
            wet: wet.copied(),
            curves: match wet {
                Some(setting) => self.restitutions(setting),
                None => self.dry_restitutions(),
            },
        }
    }

    /// The curve of dry impacts of each draw.
    pub fn dry_restitutions(&self) -> Vec<Restitution> {
        self.dry_curves().into_iter().map(|(curve, _)| curve).collect()
    }

    /// The curve of dry impacts of each draw, with its noise.
    fn dry_curves(&self) -> Vec<(Restitution, DrawNoise)> {
        let of = |draw: &Draw| {
            let curve = LawNumbers::dry(draw.parameters.dry_k, self.form.dry).into();
            let noise = DrawNoise {
                sigma: draw.sigma_dry.max(NO_SPREAD),
                sigma_energy: 0.0,
                tails: draw.tails,
            };
            (curve, noise)
        };
        self.draws.iter().map(of).collect()
    }

    /// The curve of each draw, with its noise.
    fn curves(&self, setting: &Setting) -> Vec<(Restitution, DrawNoise)> {
        let of = |draw: &Draw| {
            let curve = Restitution::new(setting, self.form, &draw.parameters).with_offset(draw.series_offset);
            let noise = DrawNoise {
                sigma: draw.sigma_wet.max(NO_SPREAD),
                sigma_energy: draw.sigma_energy,
                tails: draw.tails,
            };
            (curve, noise)
        };
        self.draws.iter().map(of).collect()
    }

    fn at(&self, curves: &[(Restitution, DrawNoise)], v: f64, numbers: Option<[f64; 2]>, holds: bool) -> Predicted {
        let sorted = |of: &dyn Fn(&Restitution) -> f64| quantile::sorted(curves.iter().map(|(c, _)| of(c)).collect());
        let e = sorted(&|curve| curve.at(v));
        let slopes = sorted(&|curve| curve.log_slope(v).unwrap_or(f64::INFINITY));
        let run = SingleRun::new(curves.iter(), v, self.smallest_restitution);
        Predicted {
            impact_speed_m_s: v,
            stokes: numbers.map(|[stokes, _]| stokes),
            reynolds: numbers.map(|[_, reynolds]| reynolds),
            restitution: quantile::of_sorted(&e, 0.5),
            restitution_q05: quantile::of_sorted(&e, 0.05),
            restitution_q25: quantile::of_sorted(&e, 0.25),
            restitution_q75: quantile::of_sorted(&e, 0.75),
            restitution_q95: quantile::of_sorted(&e, 0.95),
            run_q05: run.quantile(0.05),
            run_q25: run.quantile(0.25),
            run_q75: run.quantile(0.75),
            run_q95: run.quantile(0.95),
            stuck_probability: run.stuck,
            log_slope: Some(quantile::of_sorted(&slopes, 0.5)).filter(|slope| slope.is_finite()),
            extrapolated: !holds,
        }
    }
}

/// The curve of a pair without the scatter of single runs.
#[derive(Debug)]
pub struct PredictedCurve<'a> {
    law: &'a ParticleLaw,
    wet: Option<Setting>,
    /// of each draw
    curves: Vec<Restitution>,
}

impl PredictedCurve<'_> {
    /// Median, ends of the 90 % band and whether that is extrapolated, at an impact speed above zero, m/s.
    pub fn at(&self, v: f64) -> PredictedPoint {
        let sorted = quantile::sorted(self.curves.iter().map(|curve| curve.at(v)).collect());
        let [q05, q50, q95] = [0.05, 0.5, 0.95].map(|p| quantile::of_sorted(&sorted, p));
        PredictedPoint {
            q05,
            q50,
            q95,
            extrapolated: !self.law.holds(self.wet.as_ref(), v),
        }
    }

    /// Median of d ln e/d ln v there; infinite where half of the draws or more do not rebound.
    pub fn log_slope(&self, v: f64) -> f64 {
        let slopes = self
            .curves
            .iter()
            .map(|curve| curve.log_slope(v).unwrap_or(f64::INFINITY));
        quantile::of_sorted(&quantile::sorted(slopes.collect()), 0.5)
    }
}

/// A curve at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedPoint {
    /// 5 % point of e
    pub q05: f64,
    /// its median; 0: no rebound
    pub q50: f64,
    /// its 95 % point
    pub q95: f64,
    /// whether that lies outside what the particle's runs covered
    pub extrapolated: bool,
}

/// A spread that no restitution shows, in place of none: a distribution over the draws stays one that can be solved for.
const NO_SPREAD: f64 = 1e-9;

/// The noise of single runs under one draw.
#[derive(Clone, Copy)]
struct DrawNoise {
    sigma: f64,
    sigma_energy: f64,
    tails: Tails,
}

/// The distribution of a run's restitution at one speed: a mixture over the draws, cut at the limit.
struct SingleRun {
    /// each draw's share
    shares: Vec<DrawShare>,
    /// probability of sticking
    stuck: f64,
}

/// What one draw says of a run.
#[derive(Clone, Copy)]
struct DrawShare {
    /// r
    kept: f64,
    /// m(r)
    mean: f64,
    noise: DrawNoise,
}

impl DrawShare {
    /// Probability of an e* at or below x, and its density there.
    fn below(&self, x: f64) -> (f64, f64) {
        let DrawNoise {
            sigma,
            sigma_energy,
            tails,
        } = self.noise;
        if sigma_energy == 0.0 {
            let z = (x - self.mean) / sigma;
            return (tails.probability(z), tails.ln_unit_density(z).exp() / sigma);
        }
        let spreads = Spreads {
            sigma,
            energy: sigma_energy,
        };
        let found = BelowRestitution::of(tails, x, self.kept, spreads);
        (found.probability, found.density)
    }

    /// Between which restitutions all but the tails beyond so many spreads lie.
    fn within(&self, wide: f64) -> (f64, f64) {
        let DrawNoise {
            sigma, sigma_energy, ..
        } = self.noise;
        let on = |side: f64| mean_restitution(self.kept + side * sigma_energy) + side * sigma;
        (on(-wide), on(wide))
    }
}

impl SingleRun {
    fn new<'c>(curves: impl Iterator<Item = &'c (Restitution, DrawNoise)>, v: f64, limit: f64) -> SingleRun {
        let share = |(curve, noise): &(Restitution, DrawNoise)| {
            let kept = curve.kept_energy(v);
            DrawShare {
                kept,
                mean: mean_restitution(kept),
                noise: *noise,
            }
        };
        let mut run = SingleRun {
            shares: curves.map(share).collect(),
            stuck: 0.0,
        };
        run.stuck = run.below(limit).0;
        run
    }

    /// Probability of an e* at or below x, and its density there.
    fn below(&self, x: f64) -> (f64, f64) {
        let sum = self
            .shares
            .iter()
            .map(|share| share.below(x))
            .fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        let n = self.shares.len() as f64;
        (sum.0 / n, sum.1 / n)
    }

    /// About where a quantile lies: where it would if the mixture were normal.
    fn near(&self, probability: f64) -> f64 {
        let n = self.shares.len() as f64;
        let mean = self.shares.iter().map(|share| share.mean).sum::<f64>() / n;
        let variance = |share: &DrawShare| {
            let (low, high) = share.within(1.0);
            0.25 * (high - low).powi(2) + (share.mean - mean).powi(2)
        };
        let variance = self.shares.iter().map(variance).sum::<f64>() / n;
        mean + normal_quantile(probability) * variance.sqrt()
    }

    /// Quantile at a probability from 0.03 to 0.97; 0 where that is a stuck run.
    fn quantile(&self, probability: f64) -> f64 {
        /// spreads that hold those probabilities of each part, and so of their mixture: of the normal, and of any other
        /// family
        const WIDE: [f64; 2] = [2.0, 4.0];
        /// a bracket halved so often is down to rounding; on average five of Newton's steps do well above the threshold,
        /// eight or nine close to it
        const STEPS: usize = 60;
        /// far below what a restitution can be measured to
        const ENOUGH: f64 = 1e-13;
        if probability <= self.stuck {
            return 0.0;
        }
        let other = |share: &DrawShare| share.noise.tails != Tails::Normal;
        let wide = WIDE[usize::from(self.shares.iter().any(other))];
        let (mut lo, mut hi) = self
            .shares
            .iter()
            .map(|share| share.within(wide))
            .fold((f64::MAX, f64::MIN), |(lo, hi), (low, high)| {
                (lo.min(low), hi.max(high))
            });
        let within = |x: f64, (lo, hi): (f64, f64)| if x > lo && x < hi { x } else { 0.5 * (lo + hi) };
        let mut x = within(self.near(probability), (lo, hi));
        for _ in 0..STEPS {
            let (below, density) = self.below(x);
            if below < probability {
                lo = x;
            } else {
                hi = x;
            }
            let newton = x + (probability - below) / density;
            // a step out of the bracket, or of no length known, is replaced by half the bracket
            let next = within(newton, (lo, hi));
            let step = (next - x).abs();
            x = next;
            if step < ENOUGH {
                break;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::inertia::Inertia;
    use crate::physics::{kept_energy, Coefficient, DrySpeed};
    use crate::seed::stream;
    use rand_distr::{Distribution, StandardNormal};

    const SETTING: Setting = Setting {
        density: 2150.0,
        diameter: 4.762e-3,
        roughness: Some(5e-6),
        liquid_density: 930.0,
        viscosity: 9.3e-3,
        film: 286e-6,
        surface_tension: None,
    };
    const SPEEDS: [f64; 3] = [0.8, 1.2, 1.7];

    fn draw(lubrication_log: f64) -> Draw {
        Draw {
            parameters: Parameters::new(0.183)
                .with(Coefficient::LubricationLog, lubrication_log)
                .with(Coefficient::InertialPrefactor, 0.47)
                .with(Coefficient::FilmScale, 0.069),
            sigma_dry: 0.01,
            sigma_wet: 0.02,
            sigma_energy: 0.0,
            tails: Tails::Normal,
            series_offset: 0.0,
        }
    }

    fn law(draws: Vec<Draw>) -> ParticleLaw {
        ParticleLaw {
            form: Form::new(Inertia::Saturating, DrySpeed::Reference(2.0)),
            smallest_restitution: 0.05,
            covered: None,
            ranges: vec![],
            dry_speeds: None,
            draws,
        }
    }

    #[test]
    fn a_posterior_without_spread_leaves_the_curve_and_the_noise() {
        let law = law(vec![draw(1.85); 400]);
        for at in law.bands(&SETTING, &SPEEDS) {
            let kept = kept_energy(&SETTING, law.form, &law.draws[0].parameters, at.impact_speed);
            let mean = mean_restitution(kept);
            assert!(at.curve.iter().all(|edge| (edge - mean).abs() < 1e-6), "{at:?} {mean}");
            // 5 % and 95 % points of the normal
            let half = 1.644_853_626_951 * 0.02;
            for (edge, expected) in at.run.into_iter().zip([mean - half, mean + half]) {
                assert!((edge - expected).abs() < 1e-6 * half, "{edge} {expected}");
            }
        }
    }

    #[test]
    fn the_spread_of_a_parameter_widens_both_bands() {
        let draws = (0..400).map(|i| draw(1.0 + f64::from(i) / 200.0)).collect();
        let wide = law(draws).bands(&SETTING, &SPEEDS);
        let narrow = law(vec![draw(2.0); 400]).bands(&SETTING, &SPEEDS);
        for (wide, narrow) in wide.into_iter().zip(narrow) {
            assert!(wide.curve[0] < narrow.curve[0] && wide.curve[1] > narrow.curve[1]);
            assert!(wide.run[1] - wide.run[0] > narrow.run[1] - narrow.run[0]);
        }
    }

    /// Also where a restitution falls steeply, and σ_r makes the noise on it far from normal.
    #[test]
    fn simulated_runs_lie_below_a_band_as_often_as_it_says() {
        const RUNS: usize = 40_000;
        let mut rng = stream(1, "simulated_runs_lie_below_a_band_as_often_as_it_says", 0);
        let mut z = || -> f64 { StandardNormal.sample(&mut rng) };
        let of = |i: i32| Draw {
            sigma_dry: 0.01,
            sigma_wet: 0.01,
            sigma_energy: 0.04,
            ..draw(1.8 + f64::from(i) / 4000.0)
        };
        let law = law((0..400).map(of).collect());
        for at in law.bands(&SETTING, &[0.1, 0.12, 0.14, 0.17, 0.2, 0.3, 0.8, 1.7]) {
            let run = |i: usize| {
                let one = &law.draws[i % law.draws.len()];
                let kept = kept_energy(&SETTING, law.form, &one.parameters, at.impact_speed);
                mean_restitution(kept + one.sigma_energy * z()) + one.sigma_wet * z()
            };
            let runs: Vec<f64> = (0..RUNS).map(run).collect();
            for (edge, probability) in at.run.into_iter().zip([0.05, 0.95]) {
                let below = runs.iter().filter(|e| **e <= edge).count() as f64 / RUNS as f64;
                // an edge at 0 stands for the runs that stuck, which may be more
                let holds = (below - probability).abs() < 0.006 || edge == 0.0 && below > probability - 0.006;
                assert!(holds, "{at:?}: {below} below {edge}");
            }
        }
    }
}
