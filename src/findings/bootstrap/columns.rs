//! Lays the runs of all fits out as columns, in the order in which the strata are drawn.

use crate::findings::dry::FittedDry;
use crate::findings::own_dry_speed::OwnDrySpeed;
use crate::inference::bootstrap::{Law, Pool, Target};
use crate::physics::numbers::stokes;
use crate::runs::Runs;
use crate::scene::Scene;

/// The runs of all fits as columns in the order of the strata.
pub(super) struct Columns {
    pub(super) pool: Pool,
    dry_runs: usize,
    speed_root: Vec<f64>,
    dry_restitution: Vec<f64>,
    pub(super) inverse_speed: Vec<f64>,
    pub(super) inverse_stokes: Vec<f64>,
    restitution: Vec<f64>,
    offset: Vec<f64>,
}

impl Columns {
    pub(super) fn new(scene: &Scene, runs: &Runs, dry: &[FittedDry]) -> Columns {
        let mut columns = Columns {
            pool: Pool::default(),
            dry_runs: 0,
            speed_root: vec![],
            dry_restitution: vec![],
            inverse_speed: vec![],
            inverse_stokes: vec![],
            restitution: vec![],
            offset: vec![],
        };
        let mut end = 0;
        let mut stratum = |size: usize, pool: &mut Pool| {
            pool.strata.push(end..end + size);
            end += size;
        };
        for group in &runs.dry {
            stratum(group.rebounds.len(), &mut columns.pool);
            let range = group.rebounds.clone();
            columns
                .speed_root
                .extend(runs.impact_speed[range.clone()].iter().map(|v| v.powf(0.2)));
            columns.dry_restitution.extend_from_slice(&runs.restitution[range]);
        }
        columns.dry_runs = columns.dry_restitution.len();
        for series in &runs.series {
            stratum(series.rebounds.len(), &mut columns.pool);
            let range = series.rebounds.clone();
            let density = scene.particles[series.particle].density;
            let viscosity = scene.liquids[series.liquid].viscosity;
            let speeds = &runs.impact_speed[range.clone()];
            columns.inverse_speed.extend(speeds.iter().map(|v| 1.0 / v));
            let inverse = runs.diameter[range.clone()].iter().zip(speeds);
            columns
                .inverse_stokes
                .extend(inverse.map(|(d, v)| 1.0 / stokes(density, *d, *v, viscosity)));
            columns.restitution.extend_from_slice(&runs.restitution[range]);
            match OwnDrySpeed::new(scene, dry, series.particle) {
                Some(own) => columns.offset.extend(own.offsets(speeds)),
                None => columns.offset.extend(std::iter::repeat_n(0.0, speeds.len())),
            }
        }
        if columns.offset.iter().all(|offset| *offset == 0.0) {
            columns.offset.clear();
        }
        columns
    }

    fn range(&self, strata: &std::ops::Range<usize>) -> std::ops::Range<usize> {
        let strata = &self.pool.strata[strata.clone()];
        let (first, last) = (strata.first(), strata.last());
        first.map_or(0, |s| s.start)..last.map_or(0, |s| s.end)
    }

    pub(super) fn dry(&self, strata: std::ops::Range<usize>, k: f64) -> Target<'_> {
        let range = self.range(&strata);
        Target {
            law: Law::Dry,
            x: &self.speed_root[range.clone()],
            offset: &[],
            restitution: &self.dry_restitution[range],
            strata,
            fitted: [k, 0.0],
        }
    }

    pub(super) fn wet(
        &self,
        law: Law,
        x: &'_ Vec<f64>,
        strata: std::ops::Range<usize>,
        fitted: [f64; 2],
    ) -> Target<'_> {
        let range = self.range(&strata);
        let range = range.start - self.dry_runs..range.end - self.dry_runs;
        // the caller names one of our columns
        let x = if std::ptr::eq(x, &self.inverse_speed) {
            &self.inverse_speed
        } else {
            &self.inverse_stokes
        };
        let with_offset = law == Law::SquareRoot && !self.offset.is_empty();
        Target {
            law,
            x: &x[range.clone()],
            offset: if with_offset { &self.offset[range.clone()] } else { &[] },
            restitution: &self.restitution[range],
            strata,
            fitted,
        }
    }
}
