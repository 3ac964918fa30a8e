//! Tells what was read, the ranges it covers, and what it can identify.

use serde::Serialize;

use super::terms::SizedTerm;
use crate::notice::Notice;
use crate::physics::impact::Setting;
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
    /// runs left out, by reason
    pub screened: Vec<Screened>,
    /// one line for each particle and liquid
    pub materials: Vec<Material>,
    /// what these runs can identify
    pub identifies: Vec<Identified>,
    /// what each term of the energy balance matters for them
    pub terms: Vec<SizedTerm>,
    /// what wants a second look
    pub notices: Vec<Notice>,
}

/// The runs of one particle and one liquid.
#[derive(Debug, Clone, PartialEq, Serialize)]
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

/// Whether a quantity can be had from these runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Identified {
    /// which
    pub quantity: String,
    /// whether the runs tell it
    pub identified: bool,
    /// why, or what is missing
    pub reason: String,
}

/// Smallest and largest of some numbers; `None` without any.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, x| match range {
        None => Some([x, x]),
        Some([lo, hi]) => Some([f64::min(lo, x), f64::max(hi, x)]),
    })
}

fn join(first: Option<[f64; 2]>, second: Option<[f64; 2]>) -> Option<[f64; 2]> {
    range(first.into_iter().chain(second).flatten())
}

/// Tells what was read, with the terms as least squares sized them.
pub fn find(scene: &Scene, table: &Table, terms: &[SizedTerm]) -> Overview {
    let runs = &table.runs;
    let mut materials: Vec<Material> = vec![];
    for (index, particle) in scene.particles.iter().enumerate() {
        let dry: Vec<_> = runs.dry.iter().filter(|group| group.particle == index).collect();
        if let (Some(first), Some(last)) = (dry.first(), dry.last()) {
            let all = first.rebounds.start..last.stuck.end;
            materials.push(Material {
                particle: particle.name.clone(),
                liquid: DRY.to_owned(),
                runs: all.len(),
                stuck: dry.iter().map(|group| group.stuck.len()).sum(),
                diameters_m: dry.iter().map(|group| group.diameter).collect(),
                film_ratios: vec![],
                film_m: None,
                impact_speed_m_s: range(runs.impact_speed[all].iter().copied()).unwrap_or_default(),
                stokes: None,
                reynolds: None,
                restitution: range(
                    dry.iter()
                        .flat_map(|g| runs.restitution[g.rebounds.clone()].iter().copied()),
                ),
            });
        }
        for liquid in 0..scene.liquids.len() {
            let of = |s: &&Series| s.particle == index && s.liquid == liquid;
            let series: Vec<&Series> = runs.series.iter().filter(of).collect();
            if !series.is_empty() {
                materials.push(wet(scene, runs, &series));
            }
        }
    }
    Overview {
        scene: scene.name.clone(),
        title: scene.title.clone(),
        runs: table.rows,
        screened: table.screened.clone(),
        materials,
        identifies: identify(scene, runs),
        terms: terms.to_vec(),
        notices: table.notices.clone(),
    }
}

fn wet(scene: &Scene, runs: &Runs, series: &[&Series]) -> Material {
    let first = series[0];
    let particle = &scene.particles[first.particle];
    let liquid = &scene.liquids[first.liquid];
    let (mut film, mut speed, mut stokes, mut reynolds, mut e) = (None, None, None, None, None);
    for one in series {
        let setting = |run: usize| Setting {
            density: particle.density,
            diameter: runs.diameter[run],
            liquid_density: liquid.density,
            viscosity: liquid.viscosity,
            film: runs.film[run],
            surface_tension: liquid.surface_tension,
        };
        let v = |run: usize| runs.impact_speed[run];
        film = join(film, range(one.runs().map(|run| runs.film[run])));
        speed = join(speed, range(one.runs().map(v)));
        stokes = join(stokes, range(one.runs().map(|run| setting(run).stokes(v(run)))));
        reynolds = join(reynolds, range(one.runs().map(|run| setting(run).reynolds(v(run)))));
        e = join(e, range(one.rebounds.clone().map(|run| runs.restitution[run])));
    }
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
        runs: series.iter().map(|s| s.runs().len()).sum(),
        stuck: series.iter().map(|s| s.stuck.len()).sum(),
        diameters_m: distinct(|s| s.diameter),
        film_ratios: distinct(|s| s.film_ratio),
        film_m: film,
        impact_speed_m_s: speed.unwrap_or_default(),
        stokes,
        reynolds,
        restitution: e,
    }
}

/// Fewest rebounds that give two parameters and a spread.
const FEWEST: usize = 3;

fn identify(scene: &Scene, runs: &Runs) -> Vec<Identified> {
    let mut all = vec![];
    let mut any_st_c = false;
    for (index, particle) in scene.particles.iter().enumerate() {
        let name = &particle.name;
        let dry: usize = runs
            .dry
            .iter()
            .filter(|g| g.particle == index)
            .map(|g| g.rebounds.len())
            .sum();
        let groups: Vec<_> = runs.film_groups.iter().filter(|g| g.particle == index).collect();
        if dry == 0 && groups.is_empty() {
            continue;
        }
        all.push(Identified {
            quantity: format!("dry_k[{name}]"),
            identified: dry >= 2,
            reason: match dry {
                0 => "no dry runs".to_owned(),
                1 => "one dry run leaves no spread to judge it by".to_owned(),
                n => format!("{n} dry runs"),
            },
        });
        if groups.is_empty() {
            continue;
        }
        let usable = groups
            .iter()
            .filter(|g| varies(scene, runs, &runs.series[g.series.clone()]))
            .count();
        any_st_c |= usable > 0;
        all.push(Identified {
            quantity: format!("e_inf[{name}], st_c[{name}]"),
            identified: usable > 0,
            reason: format!(
                "{usable} of {} film ratios have {FEWEST} rebounds or more at different Stokes numbers",
                groups.len()
            ),
        });
        let has_dry = dry >= 2;
        all.push(Identified {
            quantity: format!("inertial_prefactor[{name}]"),
            identified: usable > 0 && (has_dry || usable > 1),
            reason: match (has_dry, usable) {
                (_, 0) => "e_inf is not known".to_owned(),
                (true, n) => format!("dry runs, and e_inf at {n} film ratios"),
                (false, 1) => "one film ratio and no dry runs: C and e_dry cannot be told apart; add dry runs or another film ratio".to_owned(),
                (false, n) => format!("no dry runs: only from how e_inf changes over {n} film ratios"),
            },
        });
        all.push(Identified {
            quantity: format!("film_scale[{name}]"),
            identified: has_dry && usable > 1 || usable > 2,
            reason: match (has_dry, usable) {
                (true, n) if n > 1 => format!("dry runs, and e_inf at {n} film ratios"),
                (_, n) => format!("e_inf at {n} film ratios; the level-off needs 2 with dry runs, 3 without"),
            },
        });
    }
    if !runs.series.is_empty() {
        all.push(Identified {
            quantity: "lubrication_log".to_owned(),
            identified: any_st_c,
            reason: if any_st_c {
                "from how the restitution falls with 1/St".to_owned()
            } else {
                "no film ratio has rebounds at different Stokes numbers".to_owned()
            },
        });
    }
    all
}

/// Whether some series have enough rebounds at different Stokes numbers.
fn varies(scene: &Scene, runs: &Runs, series: &[Series]) -> bool {
    let rebounds: usize = series.iter().map(|s| s.rebounds.len()).sum();
    let scaled = series.iter().flat_map(|s| {
        // St up to factors common to the particle
        let viscosity = scene.liquids[s.liquid].viscosity;
        s.rebounds
            .clone()
            .map(move |run| runs.diameter[run] * runs.impact_speed[run] / viscosity)
    });
    rebounds >= FEWEST && range(scaled).is_some_and(|[lo, hi]| hi > lo * (1.0 + 1e-9))
}
