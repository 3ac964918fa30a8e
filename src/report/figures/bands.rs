//! Draws where the posterior puts the restitution of a series, and single runs about it.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::super::chart::{Layer, Style};
use super::super::ReportInput;
use super::of_particle::series_name;
use crate::findings::predict::ParticleLaw;
use crate::findings::range::range;
use crate::physics::DrySpeed;
use crate::rounding;
use crate::runs::Series;
use crate::units::millimetres;

/// Draws a band is made of.
const DRAWS: usize = 400;
/// Speeds along a band.
const STEPS: usize = 48;
/// Share by which a band goes beyond the speeds of its runs, so that those of one speed have one too.
const BEYOND: f64 = 0.02;

/// The posterior's law of each sphere, ready for bands.
pub(super) struct Bands<'a> {
    input: ReportInput<'a>,
    laws: Vec<ParticleLaw>,
}

impl Bands<'_> {
    /// The laws of what was sampled; `None` where nothing was.
    pub(super) fn of(input: ReportInput) -> Option<Bands> {
        let laws = input.laws(DRAWS)?;
        Some(Bands { input, laws })
    }

    /// The bands of a series over its runs, the stuck ones with them; `x` places a speed on the horizontal axis.
    pub(super) fn of_series(&self, own: &Series, style: Style, x: impl Fn(f64) -> f64 + Sync) -> Vec<Layer> {
        let speeds = self.speeds(own);
        speeds.map_or(vec![], |ends| {
            self.layers(own, ends, series_name(self.input, own), style, x)
        })
    }

    /// The bands of a series between two speeds, that of single runs first.
    fn layers(
        &self,
        own: &Series,
        ends: [f64; 2],
        name: String,
        style: Style,
        x: impl Fn(f64) -> f64 + Sync,
    ) -> Vec<Layer> {
        let setting = self
            .input
            .scene
            .setting(own.particle, own.liquid, own.diameter, own.film);
        let curve = self.laws[own.sphere].curve(Some(&setting));
        let (slowest, fastest) = (ends[0] * (1.0 - BEYOND), ends[1] * (1.0 + BEYOND));
        let step = (fastest - slowest) / STEPS as f64;
        let at = |i: usize| {
            let v = slowest + step * i as f64;
            let (mean, [low, high]) = (curve.at(v), curve.single_runs(v));
            ((x(v), low, high), (x(v), mean.q05, mean.q95))
        };
        let (runs, mean): (Vec<_>, Vec<_>) = (0..=STEPS).into_par_iter().map(at).unzip();
        if runs.iter().all(|(_, _, high)| *high <= 0.0) {
            return vec![];
        }
        [runs, mean].map(|edges| Layer::band(&name, edges, style)).to_vec()
    }

    /// The bands against 1/St of the series at `place`; `inverse` is 1/St at a speed.
    ///
    /// With one dry speed every series of a liquid has the same curve, or every one of a diameter where the form tells
    /// these apart: the first of them draws it for all.
    pub(super) fn of_liquid(
        &self,
        series: &[&Series],
        place: usize,
        inverse: impl Fn(&Series, f64) -> f64 + Sync,
    ) -> Vec<Layer> {
        let own = series[place];
        let form = self.laws[own.sphere].form;
        if form.dry_speed == DrySpeed::Impact {
            return self.of_series(own, Style::group(place + 1), |v| inverse(own, v));
        }
        let by_diameter = form.viscous.tells_diameters_apart();
        let same = |other: &&&Series| other.liquid == own.liquid && (!by_diameter || other.is_as_large_as(own));
        let before = &series[..place];
        if before.iter().any(|other| same(&other)) {
            return vec![];
        }
        // no series' colour: it is that of all in the liquid
        let liquids = before
            .iter()
            .map(|other| other.liquid)
            .filter(|liquid| *liquid != own.liquid);
        let style = Style::group(series.len() + 1 + liquids.collect::<BTreeSet<usize>>().len());
        // where the runs of all these series lie on the axis, as speeds of this one
        let as_own = |other: &Series, v: f64| v * inverse(own, v) / inverse(other, v);
        let ends = series.iter().filter(same).filter_map(|other| {
            let ends = self.speeds(other)?;
            Some(ends.map(|v| as_own(other, v)))
        });
        let mut name = self.input.scene.liquids[own.liquid].name.clone();
        if by_diameter {
            name.push_str(&format!(", D = {} mm", rounding::short(millimetres(own.diameter))));
        }
        let name = format!("{name}, posterior");
        let ends = range(ends.flatten());
        ends.map_or(vec![], |ends| self.layers(own, ends, name, style, |v| inverse(own, v)))
    }

    /// Slowest and fastest run of a series, stuck ones with them.
    fn speeds(&self, series: &Series) -> Option<[f64; 2]> {
        range(self.input.runs.impact_speed[series.runs()].iter().copied())
    }
}
