//! Finds where the posterior puts the mean restitution of a series, and single runs about it.

use super::super::super::chart::{Layer, Style};
use super::super::super::Told;
use super::super::of_particle::series_name;
use crate::distributions::{gamma_quantile, normal_quantile};
use crate::model::likelihood::tails::Tails;
use crate::model::parameters::{physical, Kind};
use crate::physics::rebound::mean_restitution;
use crate::physics::{kept_energy, DrySpeed, Form, Setting};
use crate::runs::Series;
use crate::scene::{Likelihood, NoiseOn};

/// Draws a band is made of.
const DRAWS: usize = 400;
/// Speeds along a band.
const STEPS: usize = 48;
/// Probability on each side of a band.
const TAIL: f64 = 0.05;
/// Share by which a band goes beyond the speeds of its runs, so that those of one speed have one too.
const BEYOND: f64 = 0.02;

/// Draws of the posterior, ready for curves.
pub(in super::super) struct Bands {
    /// the terms of the energy balance
    pub(in super::super) form: Form,
    /// full vectors of parameters
    draws: Vec<Vec<f64>>,
    /// a standard normal number for each of them: evenly spread, whatever the order of the draws
    normal: Vec<f64>,
    /// another, where noise acts on the energy kept, too
    energy: Option<Vec<f64>>,
    /// what both are multiplied by, where noise has Student's tails
    wide: Option<Vec<f64>>,
}

/// What the bands of a series are drawn for.
pub(in super::super) struct SeriesBands<'a> {
    pub(in super::super) series: &'a Series,
    /// slowest and fastest
    pub(in super::super) speeds: (f64, f64),
    /// text of the legend
    pub(in super::super) name: String,
    pub(in super::super) style: Style,
}

/// Edges of a band at a speed.
struct Edges {
    speed: f64,
    mean: (f64, f64),
    single: (f64, f64),
}

impl Bands {
    /// The draws of what was sampled; `None` where nothing was.
    pub(in super::super) fn of(told: Told) -> Option<Bands> {
        let posterior = told.posterior?;
        let all = posterior.sampled.full_draws();
        let step = all.len().div_ceil(DRAWS).max(1);
        let draws: Vec<Vec<f64>> = all.into_iter().step_by(step).collect();
        Some(Bands {
            form: posterior.asked.form,
            normal: spread_normal(draws.len(), GOLDEN),
            energy: (told.scene.model.noise == NoiseOn::Both).then(|| spread_normal(draws.len(), SILVER)),
            wide: (told.scene.model.likelihood == Likelihood::Student).then(|| spread_scales(&draws)),
            draws,
        })
    }

    /// The bands of a series, that of single runs first; `x` places a speed on the horizontal axis.
    pub(in super::super) fn layers(&self, told: Told, drawn: SeriesBands, x: impl Fn(f64) -> f64) -> Vec<Layer> {
        let SeriesBands { series, speeds, .. } = drawn;
        let particle = &told.scene.particles[series.particle];
        let liquid = &told.scene.liquids[series.liquid];
        let setting = Setting {
            density: particle.density,
            diameter: series.diameter,
            liquid_density: liquid.density,
            viscosity: liquid.viscosity,
            film: series.film,
            surface_tension: liquid.surface_tension,
        };
        let edges = self.edges(&setting, series.particle, speeds);
        let band = |of: fn(&Edges) -> (f64, f64)| Layer::Band {
            name: Some(drawn.name.clone()),
            // a run below zero stuck
            edges: edges
                .iter()
                .map(|at| (x(at.speed), of(at).0.max(0.0), of(at).1.max(0.0)))
                .collect(),
            style: drawn.style,
        };
        if edges.iter().all(|at| at.single.1 <= 0.0) {
            return vec![];
        }
        vec![band(|at| at.single), band(|at| at.mean)]
    }

    /// The bands against 1/St of the series at `place`; `inverse` is 1/St at a speed.
    ///
    /// With one dry speed every series of a liquid has the same curve: the first of them draws it for all.
    pub(in super::super) fn of_liquid(
        &self,
        told: Told,
        series: &[&Series],
        place: usize,
        inverse: impl Fn(&Series, f64) -> f64,
    ) -> Vec<Layer> {
        let own = series[place];
        let style = Style::group(place + 1);
        let along = |v: f64| inverse(own, v);
        let drawn = |speeds: (f64, f64), name: String| SeriesBands {
            series: own,
            speeds,
            name,
            style,
        };
        if self.form.dry_speed == DrySpeed::Impact {
            let ends = speeds(told, own);
            let name = series_name(told, own);
            return ends.map_or(vec![], |speeds| self.layers(told, drawn(speeds, name), along));
        }
        let same = |other: &&&Series| other.liquid == own.liquid;
        if series[..place].iter().any(|other| same(&other)) {
            return vec![];
        }
        // where the runs of all these series lie on the axis, as speeds of this one
        let as_own = |other: &Series, v: f64| v * inverse(own, v) / inverse(other, v);
        let each = series.iter().filter(same).filter_map(|other| {
            let (slowest, fastest) = speeds(told, other)?;
            Some((as_own(other, slowest), as_own(other, fastest)))
        });
        let ends = each.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let name = format!("{}, posterior", told.scene.liquids[own.liquid].name);
        ends.map_or(vec![], |speeds| self.layers(told, drawn(speeds, name), along))
    }

    fn edges(&self, setting: &Setting, particle: usize, (slowest, fastest): (f64, f64)) -> Vec<Edges> {
        let (slowest, fastest) = (slowest * (1.0 - BEYOND), fastest * (1.0 + BEYOND));
        let speeds = (0..=STEPS).map(|i| slowest + (fastest - slowest) * i as f64 / STEPS as f64);
        speeds
            .map(|speed| {
                let kept = |full: &Vec<f64>| kept_energy(setting, self.form, &physical(full, particle), speed);
                let kept: Vec<f64> = self.draws.iter().map(kept).collect();
                let means: Vec<f64> = kept.iter().map(|r| mean_restitution(*r)).collect();
                let single = |draw: usize| {
                    let full = &self.draws[draw];
                    let wide = self.wide.as_ref().map_or(1.0, |wide| wide[draw]);
                    let energy_noise = self
                        .energy
                        .as_ref()
                        .map(|z| wide * full[Kind::SigmaEnergy.slot()] * z[draw]);
                    let mean = energy_noise.map_or(means[draw], |noise| mean_restitution(kept[draw] + noise));
                    mean + wide * full[Kind::SigmaWet.slot()] * self.normal[draw]
                };
                let single = (0..self.draws.len()).map(single).collect();
                Edges {
                    speed,
                    mean: central(means),
                    single: central(single),
                }
            })
            .collect()
    }
}

/// (√5 − 1)/2 and √2 − 1: steps round a circle whose places are even for long, and together fill a square.
const GOLDEN: f64 = 0.618_033_988_749_894_8;
const SILVER: f64 = std::f64::consts::SQRT_2 - 1.0;
/// √3 − 1, for a third
const BRONZE: f64 = 0.732_050_807_568_877_2;

/// So many numbers that lie as a standard normal has them; none is near the next one in the list.
fn spread_normal(count: usize, step: f64) -> Vec<f64> {
    let even = (0..count).map(|i| (0.5 + step * i as f64).fract());
    even.map(normal_quantile).collect()
}

/// √(ν/χ²)/c of each draw's ν: what makes a standard normal number noise with Student's tails.
fn spread_scales(draws: &[Vec<f64>]) -> Vec<f64> {
    let even = (0..draws.len()).map(|i| (0.5 + BRONZE * i as f64).fract());
    let scale = |(full, p): (&Vec<f64>, f64)| {
        let nu = full[Kind::Nu.slot()];
        // χ² is twice a gamma of half its degrees of freedom
        gamma_quantile(p, 0.5 * nu).map_or(1.0, |half| Tails::of(Some(nu)).scale(2.0 * half))
    };
    draws.iter().zip(even).map(scale).collect()
}

/// The numbers between which all but the tails lie.
fn central(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_unstable_by(f64::total_cmp);
    let at = |probability: f64| {
        let place = probability * values.len().saturating_sub(1) as f64;
        values.get(place.round() as usize).copied().unwrap_or(f64::NAN)
    };
    (at(TAIL), at(1.0 - TAIL))
}

/// Slowest and fastest run of a series, stuck ones with them.
pub(in super::super) fn speeds(told: Told, series: &Series) -> Option<(f64, f64)> {
    let all = told.runs.impact_speed[series.runs()].iter();
    all.fold(None, |ends, v| {
        let (slowest, fastest) = ends.unwrap_or((*v, *v));
        Some((v.min(slowest), v.max(fastest)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::parameters::COMMON_SLOTS;
    use crate::physics::inertia::Inertia;

    const SETTING: Setting = Setting {
        density: 2150.0,
        diameter: 4.762e-3,
        liquid_density: 930.0,
        viscosity: 9.3e-3,
        film: 286e-6,
        surface_tension: None,
    };

    fn bands(draws: Vec<Vec<f64>>) -> Bands {
        Bands {
            form: Form::new(Inertia::Saturating, DrySpeed::Reference(2.0)),
            normal: spread_normal(draws.len(), GOLDEN),
            energy: None,
            wide: None,
            draws,
        }
    }

    /// A full vector of one particle's parameters.
    fn full(lubrication_log: f64) -> Vec<f64> {
        let mut full = vec![0.0; COMMON_SLOTS + 1];
        for (kind, value) in [
            (Kind::LUBRICATION_LOG, lubrication_log),
            (Kind::INERTIAL_PREFACTOR, 0.47),
            (Kind::FILM_SCALE, 0.069),
            (Kind::SigmaWet, 0.02),
            (Kind::DryK(0), 0.183),
        ] {
            full[kind.slot()] = value;
        }
        full
    }

    #[test]
    fn a_posterior_without_spread_leaves_the_curve_and_the_noise() {
        let parameters = physical(&full(1.85), 0);
        for at in bands(vec![full(1.85); 400]).edges(&SETTING, 0, (0.8, 1.7)) {
            let form = Form::new(Inertia::Saturating, DrySpeed::Reference(2.0));
            let kept = kept_energy(&SETTING, form, &parameters, at.speed);
            let mean = mean_restitution(kept);
            assert_eq!(at.mean, (mean, mean));
            // 5 % and 95 % points of the normal; 400 numbers resolve a probability to 1/400
            let half = 1.644_853_626_951 * 0.02;
            for (edge, expected) in [(at.single.0, mean - half), (at.single.1, mean + half)] {
                assert!((edge - expected).abs() < 0.03 * half, "{edge} {expected}");
            }
        }
    }

    #[test]
    fn the_spread_of_a_parameter_widens_both_bands() {
        let draws = (0..400).map(|i| full(1.0 + f64::from(i) / 200.0)).collect();
        let (wide, narrow) = (bands(draws), bands(vec![full(2.0); 400]));
        let both = wide
            .edges(&SETTING, 0, (0.8, 1.7))
            .into_iter()
            .zip(narrow.edges(&SETTING, 0, (0.8, 1.7)));
        for (wide, narrow) in both {
            assert!(wide.mean.0 < narrow.mean.0 && wide.mean.1 > narrow.mean.1);
            assert!(wide.single.1 - wide.single.0 > narrow.single.1 - narrow.single.0);
        }
    }
}
