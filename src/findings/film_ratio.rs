//! Chooses the film ratio that stands for the others of a sphere.

use crate::runs::{FilmGroup, Runs};
use crate::scene::Scene;

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
