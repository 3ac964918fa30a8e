//! Puts the fitted runs in rows: what each leaves of the joint fit of dry law and energy balance, with its slopes.

use std::ops::Range;

use super::point::Point;
use crate::findings::balance::block_of;
use crate::inference::balance::{Balance, Block};
use crate::runs::Runs;
use crate::scene::{NoiseOn, Scene};

/// Most slopes a run has: k, L, C and δ̃0.
const MOST_SLOPES: usize = 4;

/// Dry runs have one spread, wet runs another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Dry,
    Wet,
}

impl Kind {
    pub(super) const ALL: [Kind; 2] = [Kind::Dry, Kind::Wet];
}

/// Runs of one kind, particle, liquid and film ratio, over all diameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Group {
    pub(super) kind: Kind,
    pub(super) particle: usize,
    pub(super) liquid: Option<usize>,
    pub(super) film_ratio: Option<f64>,
}

/// The runs of a series, or the dry ones of a particle and diameter.
pub(super) struct Part {
    /// index into [`Rows::groups`]
    pub(super) group: usize,
    /// index into [`Runs::series`]; `None` for dry runs
    pub(super) series: Option<usize>,
    /// mean D, m
    pub(super) diameter: f64,
    pub(super) rebounds: Range<usize>,
    pub(super) stuck: Range<usize>,
    /// places of the parameters its runs have slopes in, in the order of the slopes
    pub(super) places: Vec<usize>,
}

/// What one run leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// index into the columns of [`Runs`]
    pub(super) run: usize,
    /// model less restitution
    pub(super) residual: f64,
    /// r, the energy kept; not read of dry runs
    pub(super) kept: f64,
    /// τ², what the measurement errors of the run add to the variance about the model
    pub(super) measured: f64,
    /// slopes of the model, in the order of [`Part::places`]; zeros beyond
    pub(super) slopes: [f64; MOST_SLOPES],
}

/// The runs of the joint fit, and where it ended.
pub(super) struct Rows<'a> {
    pub(super) scene: &'a Scene,
    pub(super) runs: &'a Runs,
    pub(super) point: Point,
    pub(super) parts: Vec<Part>,
    pub(super) groups: Vec<Group>,
}

impl<'a> Rows<'a> {
    /// Dry runs of every usable k, and wet runs of the particles with a place in the energy balance.
    pub(super) fn new(scene: &'a Scene, runs: &'a Runs, point: Point) -> Rows<'a> {
        let mut rows = Rows {
            scene,
            runs,
            point,
            parts: vec![],
            groups: vec![],
        };
        for dry in &runs.dry {
            if let Some(place) = rows
                .point
                .place(dry.particle)
                .filter(|_| rows.point.dried[dry.particle])
            {
                let group = Group {
                    kind: Kind::Dry,
                    particle: dry.particle,
                    liquid: None,
                    film_ratio: None,
                };
                rows.add(group, None, dry.diameter, (&dry.rebounds, &dry.stuck), vec![place]);
            }
        }
        for (index, series) in runs.series.iter().enumerate() {
            let wet = rows.point.wet;
            let place = rows
                .point
                .place(series.particle)
                .filter(|place| *place < wet + rows.point.rebounding);
            if let Some(place) = place {
                let group = Group {
                    kind: Kind::Wet,
                    particle: series.particle,
                    liquid: Some(series.liquid),
                    film_ratio: Some(series.film_ratio),
                };
                let places = std::iter::once(place).chain(0..wet).collect();
                rows.add(
                    group,
                    Some(index),
                    series.diameter,
                    (&series.rebounds, &series.stuck),
                    places,
                );
            }
        }
        rows
    }

    fn add(
        &mut self,
        group: Group,
        series: Option<usize>,
        diameter: f64,
        (rebounds, stuck): (&Range<usize>, &Range<usize>),
        places: Vec<usize>,
    ) {
        // the parts of a group come one after the other
        if self.groups.last() != Some(&group) {
            self.groups.push(group);
        }
        self.parts.push(Part {
            group: self.groups.len() - 1,
            series,
            diameter,
            rebounds: rebounds.clone(),
            stuck: stuck.clone(),
            places,
        });
    }

    pub(super) fn kind(&self, part: &Part) -> Kind {
        self.groups[part.group].kind
    }

    /// Whether the energy kept scatters, too, so that wet restitutions near the threshold scatter more.
    pub(super) fn energy_scatters(&self) -> bool {
        self.scene.model.noise == NoiseOn::Both
    }

    /// Whether a point lies where the model is defined.
    pub(super) fn holds(&self, point: &[f64]) -> bool {
        let scale = self.point.names.iter().position(|name| name == "film_scale");
        point.iter().all(|x| x.is_finite()) && scale.is_none_or(|scale| point[scale] > 0.0)
    }

    /// Tells of each of a range of a part's runs in turn, about a point.
    pub(super) fn each(&self, part: &Part, range: Range<usize>, point: &[f64], mut tell: impl FnMut(Row)) {
        let Some(errors) = &self.runs.errors else {
            return self.each_at(part, range, point, 1.0, tell);
        };
        /// a central difference this wide errs by 1e-8 of the slope
        const STEP: f64 = 1e-4;
        let first = range.start;
        let mut slopes: Vec<f64> = vec![0.0; range.len()];
        for step in [-STEP, STEP] {
            self.each_at(part, range.clone(), point, 1.0 + step, |row| {
                slopes[row.run - first] += row.residual / (2.0 * step * self.runs.impact_speed[row.run]);
            });
        }
        self.each_at(part, range, point, 1.0, |row| {
            let [of_speed, own] = errors.of(row.run);
            let model = row.residual + self.runs.restitution[row.run];
            let with_speed = of_speed * (model / self.runs.impact_speed[row.run] + slopes[row.run - first]);
            tell(Row {
                measured: own * own + with_speed * with_speed,
                ..row
            });
        });
    }

    /// The same with all impact speeds times a factor, and without measurement errors.
    fn each_at(&self, part: &Part, range: Range<usize>, point: &[f64], factor: f64, mut tell: impl FnMut(Row)) {
        let first = range.start;
        let mut slopes = [0.0; MOST_SLOPES];
        let Some(series) = part.series.map(|index| &self.runs.series[index]) else {
            let k = point[part.places[0]];
            for run in range {
                let v = factor * self.runs.impact_speed[run];
                slopes[0] = self.point.form.dry.slope_dry_k(k, v);
                tell(Row {
                    run,
                    residual: self.point.form.dry.restitution(k, v) - self.runs.restitution[run],
                    kept: 1.0,
                    measured: 0.0,
                    slopes,
                });
            }
            return;
        };
        let block = block_of(self.scene, self.runs, series, range, part.places[0] - self.point.wet);
        let moved: Vec<f64>;
        let block = if factor == 1.0 {
            block
        } else {
            moved = block.impact_speed.iter().map(|v| factor * v).collect();
            Block {
                impact_speed: &moved,
                ..block
            }
        };
        let balance = Balance {
            blocks: &[block],
            form: self.point.form,
            dry_k: &[],
            spread: 1.0,
        };
        let mut run = first;
        balance.each(point, |rebound| {
            for (own, (_, slope)) in slopes.iter_mut().zip(rebound.slopes) {
                *own = *slope;
            }
            tell(Row {
                run,
                residual: rebound.residual,
                kept: rebound.kept,
                measured: 0.0,
                slopes,
            });
            run += 1;
        });
    }
}
