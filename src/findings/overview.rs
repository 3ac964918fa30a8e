//! Tells what was read, the ranges it covers, and what it can identify.

use serde::Serialize;

use super::document::Findings;
use super::film_groups::FilmGroupWidth;
use super::identify::Directions;
use super::noise::{self, Noise};
use super::range::range;
use super::remarks;
use super::terms::SizedTerm;
use crate::remark::Remark;
use crate::runs::{Runs, Screened, Series, Table};
use crate::scene::{Scene, DRY};

/// What a table of runs holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Overview {
    /// the scene's folder name
    pub scene: String,
    /// the scene's title
    pub title: String,
    /// rows of the file
    pub runs: usize,
    /// sheets of workbooks that they were read from
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sheets: Vec<String>,
    /// runs left out, by reason
    pub screened: Vec<Screened>,
    /// one line for each particle and liquid
    pub materials: Vec<Material>,
    /// the runs of each particle that belong to one film ratio
    pub film_groups: Vec<FilmGroupWidth>,
    /// which parameters these runs can identify; `None` without parameters, or where a sum is not finite
    pub directions: Option<Directions>,
    /// what each term of the energy balance matters for them
    pub terms: Vec<SizedTerm>,
    /// what the scatter of the runs is like; `None` without a fit or without scatter
    pub noise: Option<Noise>,
    /// what wants a second look
    pub notices: Vec<Remark>,
}

/// The runs of one particle and one liquid.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Material {
    /// name of the particle
    pub particle: String,
    /// name of the liquid, or `dry`
    pub liquid: String,
    /// runs in use
    pub runs: usize,
    /// those that stuck
    pub stuck: usize,
    /// the diameters, m
    pub diameters_m: Vec<f64>,
    /// the film ratios; empty for dry runs
    pub film_ratios: Vec<f64>,
    /// smallest and largest film, m; `None` for dry runs
    pub film_m: Option<[f64; 2]>,
    /// smallest and largest impact speed, m/s
    pub impact_speed_m_s: [f64; 2],
    /// smallest and largest Stokes number
    pub stokes: Option<[f64; 2]>,
    /// smallest and largest Reynolds number
    pub reynolds: Option<[f64; 2]>,
    /// smallest and largest restitution of the rebounds; `None` where all stuck
    pub restitution: Option<[f64; 2]>,
}

/// The runs of every particle and liquid, dry ones first.
pub fn list_materials(scene: &Scene, runs: &Runs) -> Vec<Material> {
    let mut materials: Vec<Material> = vec![];
    for (index, particle) in scene.particles.iter().enumerate() {
        let spheres = runs.spheres_of(index);
        let dry = runs.dry_in(spheres.clone());
        if let (Some(first), Some(last)) = (dry.first(), dry.last()) {
            let all = first.rebounds.start..last.stuck.end;
            materials.push(Material {
                particle: particle.name.clone(),
                liquid: DRY.to_owned(),
                runs: runs.measured(all.clone()),
                stuck: dry.iter().map(|group| runs.measured(group.stuck.clone())).sum(),
                diameters_m: dry.iter().map(|group| group.diameter).collect(),
                impact_speed_m_s: range(runs.impact_speed[all].iter().copied()).unwrap_or_default(),
                restitution: {
                    let some = runs.sample();
                    let groups = some.dry_in(spheres.clone()).iter();
                    range(groups.flat_map(|g| some.restitution[g.rebounds.clone()].iter().copied()))
                },
                ..Material::default()
            });
        }
        let wet = runs.series_in(spheres);
        for liquid in (0..scene.liquids.len()).filter(|_| !wet.is_empty()) {
            let series: Vec<&Series> = wet.iter().filter(|series| series.liquid == liquid).collect();
            if !series.is_empty() {
                materials.push(of_wet(scene, runs, &series));
            }
        }
    }
    materials
}

/// Summarises what was read, beside what least squares found in it.
pub fn summarise_runs(scene: &Scene, table: &Table, least_squares: &Findings) -> Overview {
    Overview {
        scene: scene.name.clone(),
        title: scene.title.clone(),
        runs: table.rows,
        sheets: table.sheets.clone(),
        screened: table.screened.clone(),
        materials: list_materials(scene, &table.runs),
        film_groups: least_squares.film_groups.clone(),
        directions: least_squares.identifies.clone(),
        terms: least_squares.terms.clone(),
        notices: [
            table.notices.clone(),
            noise::noise_notices(scene, least_squares.noise.as_ref()),
            least_squares.checks().filter_map(of_table).collect(),
            least_squares
                .notices()
                .filter(|notice| remarks::COLUMNS_DISAGREE.is(notice))
                .cloned()
                .collect(),
        ]
        .concat(),
        noise: least_squares.noise.clone(),
    }
}

/// A failed check of what the table and its scene hold, as a notice: no fit has to be looked at for it.
fn of_table(check: &Remark) -> Option<Remark> {
    let of_table = [
        remarks::FILM_GROUPS,
        remarks::PLAUSIBLE_INPUT,
        remarks::PLAUSIBLE_RESULT,
        remarks::COLUMNS_AGREE,
        remarks::REPEATED_ROWS,
        remarks::MEAN_ROWS,
        remarks::SECOND_IMPACTS,
    ];
    let is_one = of_table.iter().any(|kind| kind.is(check));
    let told = || Remark::new(check.code, check.count(), check.text.as_str(), check.next_step.as_str());
    (is_one && !check.passed).then(told)
}

fn of_wet(scene: &Scene, runs: &Runs, series: &[&Series]) -> Material {
    let first = series[0];
    let particle = &scene.particles[first.particle];
    let liquid = &scene.liquids[first.liquid];
    let over = |of: &dyn Fn(&Series, usize) -> f64| {
        let each = series.iter().flat_map(|one| one.runs().map(move |run| of(one, run)));
        range(each)
    };
    // what stands for runs may lie beyond them
    let some = runs.sample();
    let is_alike = |own: &&Series| own.particle == first.particle && own.liquid == first.liquid;
    let alike = some.series.iter().filter(is_alike);
    let rebounds = alike.flat_map(|one| &some.restitution[one.rebounds.clone()]);
    let distinct = |of: fn(&Series) -> f64| {
        let mut values: Vec<f64> = series.iter().map(|s| of(s)).collect();
        values.sort_by(f64::total_cmp);
        // one diameter has as many means as it has series
        values.dedup_by(|next, kept| *next <= *kept * 1.001);
        values
    };
    Material {
        particle: particle.name.clone(),
        liquid: liquid.name.clone(),
        runs: series.iter().map(|s| runs.measured(s.runs())).sum(),
        stuck: series.iter().map(|s| runs.measured(s.stuck.clone())).sum(),
        diameters_m: distinct(|s| s.diameter),
        film_ratios: distinct(|s| s.film_ratio),
        film_m: over(&|_, run| runs.film[run]),
        impact_speed_m_s: over(&|_, run| runs.impact_speed[run]).unwrap_or_default(),
        stokes: over(&|_, run| 1.0 / runs.inverse_stokes(run)),
        reynolds: over(&|one, run| runs.setting(scene, one, run).reynolds(runs.impact_speed[run])),
        restitution: range(rebounds.copied()),
    }
}
