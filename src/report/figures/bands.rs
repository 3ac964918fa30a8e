//! Draws where the posterior puts the restitution of a series, and single runs about it.

use super::super::chart::{Layer, Style};
use super::super::{numbers, ReportInput};
use super::of_particle::series_name;
use crate::findings::predict::{ParticleLaw, PredictedBand};
use crate::physics::DrySpeed;
use crate::runs::Series;
use crate::units::millimetres;

/// Draws a band is made of.
const DRAWS: usize = 400;
/// Speeds along a band.
const STEPS: usize = 48;
/// Share by which a band goes beyond the speeds of its runs, so that those of one speed have one too.
const BEYOND: f64 = 0.02;

/// The posterior's law of each sphere, ready for bands.
pub(super) struct Bands {
    laws: Vec<ParticleLaw>,
}

/// What the bands of a series are drawn for.
pub(super) struct SeriesBands<'a> {
    pub(super) series: &'a Series,
    /// slowest and fastest
    pub(super) speeds: (f64, f64),
    /// text of the legend
    pub(super) name: String,
    pub(super) style: Style,
}

impl Bands {
    /// The laws of what was sampled; `None` where nothing was.
    pub(super) fn of(input: ReportInput) -> Option<Bands> {
        let posterior = input.posterior?;
        let spheres = 0..input.runs.spheres.len();
        Some(Bands {
            laws: spheres
                .map(|sphere| posterior.law(input.scene, input.runs, sphere, DRAWS))
                .collect(),
        })
    }

    /// The bands of a series, that of single runs first; `x` places a speed on the horizontal axis.
    pub(super) fn layers(&self, input: ReportInput, drawn: SeriesBands, x: impl Fn(f64) -> f64) -> Vec<Layer> {
        let SeriesBands { series, .. } = drawn;
        let setting = input
            .scene
            .setting(series.particle, series.liquid, series.diameter, series.film);
        let (slowest, fastest) = (drawn.speeds.0 * (1.0 - BEYOND), drawn.speeds.1 * (1.0 + BEYOND));
        let step = (fastest - slowest) / STEPS as f64;
        let speeds: Vec<f64> = (0..=STEPS).map(|i| slowest + step * i as f64).collect();
        let bands = self.laws[series.sphere].bands(&setting, &speeds);
        let band = |of: fn(&PredictedBand) -> [f64; 2]| Layer::Band {
            name: Some(drawn.name.clone()),
            edges: bands
                .iter()
                .map(|at| (x(at.impact_speed), of(at)[0], of(at)[1]))
                .collect(),
            style: drawn.style,
        };
        if bands.iter().all(|at| at.run[1] <= 0.0) {
            return vec![];
        }
        vec![band(|at| at.run), band(|at| at.curve)]
    }

    /// The bands against 1/St of the series at `place`; `inverse` is 1/St at a speed.
    ///
    /// With one dry speed every series of a liquid has the same curve, or every one of a diameter where the form tells
    /// these apart: the first of them draws it for all.
    pub(super) fn of_liquid(
        &self,
        input: ReportInput,
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
        if self.laws[own.sphere].form.dry_speed == DrySpeed::Impact {
            let ends = speeds(input, own);
            let name = series_name(input, own);
            return ends.map_or(vec![], |speeds| self.layers(input, drawn(speeds, name), along));
        }
        let by_diameter = self.laws[own.sphere].form.viscous.tells_diameters_apart();
        let same = |other: &&&Series| other.liquid == own.liquid && (!by_diameter || other.is_as_large_as(own));
        if series[..place].iter().any(|other| same(&other)) {
            return vec![];
        }
        // no series' colour: it is that of all in the liquid
        let before = series[..place].iter().filter(|other| other.liquid != own.liquid);
        let mut liquids: Vec<usize> = before.map(|other| other.liquid).collect();
        liquids.sort_unstable();
        liquids.dedup();
        let style = Style::group(series.len() + 1 + liquids.len());
        let drawn = |speeds: (f64, f64), name: String| SeriesBands {
            style,
            ..drawn(speeds, name)
        };
        // where the runs of all these series lie on the axis, as speeds of this one
        let as_own = |other: &Series, v: f64| v * inverse(own, v) / inverse(other, v);
        let each = series.iter().filter(same).filter_map(|other| {
            let (slowest, fastest) = speeds(input, other)?;
            Some((as_own(other, slowest), as_own(other, fastest)))
        });
        let ends = each.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let mut name = input.scene.liquids[own.liquid].name.clone();
        if by_diameter {
            name.push_str(&format!(", D = {} mm", numbers::short(millimetres(own.diameter))));
        }
        let name = format!("{name}, posterior");
        ends.map_or(vec![], |speeds| self.layers(input, drawn(speeds, name), along))
    }
}

/// Slowest and fastest run of a series, stuck ones with them.
pub(super) fn speeds(input: ReportInput, series: &Series) -> Option<(f64, f64)> {
    let all = input.runs.impact_speed[series.runs()].iter();
    all.fold(None, |ends, v| {
        let (slowest, fastest) = ends.unwrap_or((*v, *v));
        Some((v.min(slowest), v.max(fastest)))
    })
}
