//! Lists the film groups with their width, says why some have no film ratio of their own, and chooses one that stands for the
//! others.

use schemars::JsonSchema;
use serde::Serialize;

use super::remarks::{self, shortened};
use crate::remark::Remark;
use crate::rounding::by_number;
use crate::runs::{FilmGroup, Runs, NEAR_NOMINAL, WIDEST};
use crate::scene::Scene;

/// The runs of one particle that belong to one film ratio.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FilmGroupWidth {
    /// name of the particle
    pub particle: String,
    /// nominal δ/D, or the mean of the runs' own
    pub film_ratio: f64,
    /// runs, stuck ones with them
    pub runs: usize,
    /// 5 % and 95 % quantiles of the runs' own δ/D
    pub ends: [f64; 2],
    /// their distance over the mean
    pub width: f64,
    /// why no law is fitted at its film ratio; `None` where laws are
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_no_laws: Option<String>,
}

/// Every film group, in the order of the runs.
pub fn list_film_groups(scene: &Scene, runs: &Runs) -> Vec<FilmGroupWidth> {
    let width = |group: &FilmGroup| FilmGroupWidth {
        particle: scene.particles[group.particle].name.clone(),
        film_ratio: group.film_ratio,
        runs: runs.series[group.series.clone()]
            .iter()
            .map(|one| runs.measured(one.runs()))
            .sum(),
        ends: group.ends,
        width: group.width,
        why_no_laws: why_no_laws(group),
    };
    runs.film_groups.iter().map(width).collect()
}

/// Why no law is fitted at the film ratio of a group; `None` where one is.
pub(super) fn why_no_laws(group: &FilmGroup) -> Option<String> {
    if group.outside {
        let most = 100.0 * NEAR_NOMINAL;
        Some(format!("its runs lie more than {most} % from every one of film_ratios"))
    } else if !group.has_one_film_ratio() {
        Some(format!(
            "the film ratios of its runs spread over {:.2} of their mean, more than {WIDEST}",
            group.width
        ))
    } else {
        None
    }
}

/// The check of groups without a film ratio of their own. It gates only where there is no other group, unless a fit stands
/// that uses each run's own film.
pub(super) fn check(groups: &[FilmGroupWidth], own_films_stand: bool) -> Option<Remark> {
    let without: Vec<&FilmGroupWidth> = groups.iter().filter(|one| one.why_no_laws.is_some()).collect();
    let name = |one: &&FilmGroupWidth| {
        let [from, to] = one.ends;
        format!(
            "{}: {} runs at film ratios {from:.3} to {to:.3}",
            one.particle, one.runs
        )
    };
    let names: Vec<String> = without.iter().map(name).collect();
    let text = match without.len() {
        0 => "every film group has one film ratio".to_owned(),
        n => format!(
            "{n} of {} film groups, with {} runs, {}, and no laws at one ({})",
            groups.len(),
            without.iter().map(|one| one.runs).sum::<usize>(),
            by_number(n, "has no film ratio of its own", "have no film ratio of their own"),
            shortened(&names)
        ),
    };
    let forbids = without.len() == groups.len() && !own_films_stand;
    let check = remarks::FILM_GROUPS.check(without.len() as f64, text);
    (!groups.is_empty()).then(|| check.forbidding_if(forbids))
}

/// The film ratio of a sphere that stands for the others in figures: a published one, else the one with most rebounds.
pub fn reference_film_ratio(scene: &Scene, runs: &Runs, sphere: usize) -> Option<f64> {
    let particle = runs.spheres[sphere].particle;
    let mut groups: Vec<&FilmGroup> = runs.film_groups_of(sphere).iter().collect();
    if groups.iter().any(|group| group.has_one_film_ratio()) {
        groups.retain(|group| group.has_one_film_ratio());
    }
    if groups.is_empty() {
        return None;
    }
    let mut published = scene.published.iter().filter(|p| p.particle == particle);
    let wanted = published.find_map(|p| p.film_ratio);
    let near = wanted.and_then(|wanted| {
        let distance = |ratio: f64| (ratio - wanted).abs();
        let nearest = groups
            .iter()
            .min_by(|a, b| distance(a.film_ratio).total_cmp(&distance(b.film_ratio)))?;
        (distance(nearest.film_ratio) <= scene.data.film_ratio_gap).then_some(nearest.film_ratio)
    });
    let rebounds = |group: &FilmGroup| {
        let series = &runs.series[group.series.clone()];
        series.iter().map(|s| runs.measured(s.rebounds.clone())).sum::<usize>()
    };
    near.or_else(|| Some(groups.iter().max_by_key(|g| rebounds(g))?.film_ratio))
}
