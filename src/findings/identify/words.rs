//! Says in the field's words why a direction is not seen, and which runs would show it.

use crate::findings::range::range;
use crate::model::parameters::ParameterKind;
use crate::rounding::to_digits;
use crate::runs::{FilmGroup, Runs, Series};
use crate::scene::Scene;

/// What a parameter is called in a sentence.
pub(super) fn word(scene: &Scene, runs: &Runs, kind: ParameterKind) -> String {
    match kind {
        ParameterKind::DryK(_) if runs.spheres.len() == 1 => "e_dry".to_owned(),
        ParameterKind::DryK(sphere) => format!("e_dry of {}", runs.spheres[sphere].words(scene)),
        ParameterKind::Shared(coefficient) => coefficient.describe().words.to_owned(),
        // a joint fit has no other
        _ => kind.key().to_owned(),
    }
}

/// Why some parameters cannot be told in so many directions, and what to add.
pub(super) fn why(
    scene: &Scene,
    runs: &Runs,
    film_scale: Option<f64>,
    kinds: &[ParameterKind],
    directions: usize,
) -> (String, String) {
    let causes = causes(scene, runs, film_scale, kinds);
    let reasons: Vec<&str> = causes.iter().map(|(why, _)| why.as_str()).collect();
    let reasons = match reasons.as_slice() {
        [] => "the runs say less than the priors".to_owned(),
        some => listed(some, "and"),
    };
    // the losses before what they are told from
    let (k, mut losses): (Vec<ParameterKind>, Vec<ParameterKind>) =
        kinds.iter().partition(|kind| kind.sphere().is_some());
    losses.sort_by_key(|kind| *kind == ParameterKind::LUBRICATION_LOG);
    let names: Vec<String> = losses.iter().chain(&k).map(|kind| word(scene, runs, *kind)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let apart = if names.len() > 1 { "told apart" } else { "told" };
    let mut add: Vec<&str> = causes.iter().map(|(_, add)| *add).collect();
    add.dedup();
    let add = match add.len() {
        0 => "more runs, or runs that differ more in film ratio and speed".to_owned(),
        // each removes one direction
        n if n > directions && directions > 1 => format!("{directions} of: {}", add.join(", ")),
        n if n > directions => listed(&add, "or"),
        _ => listed(&add, "and"),
    };
    (
        format!("{reasons}: {} cannot be {apart}", listed(&names, "and")),
        format!("add {add}"),
    )
}

/// `a, b and c`.
fn listed(words: &[&str], last: &str) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// Known reasons, each with the runs that would remove it.
fn causes(scene: &Scene, runs: &Runs, film_scale: Option<f64>, kinds: &[ParameterKind]) -> Vec<(String, &'static str)> {
    let mut causes = vec![];
    let mut because = |why: String, add: &'static str| causes.push((why, add));
    let losses = kinds.iter().any(|kind| kind.sphere().is_none());
    let rebounding: Vec<&FilmGroup> = runs.film_groups.iter().filter(|group| rebounds(runs, group)).collect();
    if losses && rebounding.is_empty() {
        because("no wet run rebounded".to_owned(), "faster runs");
        return causes;
    }
    let films = film_ratios(scene, &rebounding);
    let inertial = kinds.contains(&ParameterKind::INERTIAL_PREFACTOR) || kinds.contains(&ParameterKind::FILM_SCALE);
    let of_k = kinds.iter().filter_map(|kind| kind.sphere());
    let without_dry: Vec<String> = of_k
        .filter(|s| runs.dry_of(*s).iter().all(|group| group.rebounds.is_empty()))
        .map(|s| runs.spheres[s].words(scene))
        .collect();
    let shared = inertial || kinds.contains(&ParameterKind::LUBRICATION_LOG);
    let level = film_scale.filter(|_| kinds.contains(&ParameterKind::FILM_SCALE));
    let series_of = |group: &FilmGroup| &runs.series[group.series.clone()];
    let differ = |group: &&FilmGroup| stokes_differ(scene, runs, series_of(group));
    let speeds_differ = rebounding.iter().any(differ);
    // at one film ratio inertia takes as much at every speed, the viscous loss less at a higher one
    let is_loss =
        |kind: &ParameterKind| [ParameterKind::LUBRICATION_LOG, ParameterKind::INERTIAL_PREFACTOR].contains(kind);
    let told_by_speed = inertial && kinds.iter().all(is_loss);
    match (films.as_slice(), level) {
        ([_], _) if speeds_differ && told_by_speed => {
            let series = rebounding.iter().flat_map(|group| series_of(group));
            let all: Vec<usize> = series.flat_map(|series| series.rebounds.clone()).collect();
            let stokes = range(all.iter().map(|run| 1.0 / runs.inverse_stokes(*run))).unwrap_or_default();
            let [least, most] = stokes.map(|stokes| to_digits(stokes, 3));
            let rebounds = all.len();
            because(
                format!(
                    "one film ratio, where only the speed tells inertia from the viscous loss, and {rebounds} rebounds at \
                     St {least} to {most} are too few"
                ),
                "runs at faster and slower speeds, or at another film ratio",
            );
        }
        ([_], _) if inertial => because("one film ratio".to_owned(), "another film ratio"),
        ([_, _], Some(_)) if !without_dry.is_empty() => because("two film ratios".to_owned(), "a third film ratio"),
        ([thinnest, .., thickest], Some(level)) => {
            if *thinnest > level {
                because("every film is beyond the level-off".to_owned(), "thinner films");
            } else if *thickest < level {
                because("every film is below the level-off".to_owned(), "thicker films");
            }
        }
        _ => {}
    }
    if kinds.contains(&ParameterKind::LUBRICATION_LOG) && !speeds_differ {
        because("one Stokes number".to_owned(), "runs at other speeds");
    }
    if shared && !without_dry.is_empty() {
        let why = if runs.dry.iter().all(|group| group.rebounds.is_empty()) {
            "no dry runs".to_owned()
        } else {
            let names: Vec<&str> = without_dry.iter().map(String::as_str).collect();
            format!("no dry runs of {}", listed(&names, "and"))
        };
        because(why, "dry runs");
    }
    causes
}

/// Whether the rebounds of some series of one particle have different Stokes numbers.
fn stokes_differ(scene: &Scene, runs: &Runs, series: &[Series]) -> bool {
    let scaled = series.iter().flat_map(|s| {
        // St up to factors common to the particle
        let viscosity = scene.liquids[s.liquid].viscosity;
        let of_run = move |run: usize| runs.diameter[run] * runs.impact_speed[run] / viscosity;
        s.rebounds.clone().map(of_run)
    });
    range(scaled).is_some_and(|[lo, hi]| hi > lo * (1.0 + 1e-9))
}

fn rebounds(runs: &Runs, group: &FilmGroup) -> bool {
    let mut series = runs.series[group.series.clone()].iter();
    series.any(|series| !series.rebounds.is_empty())
}

/// Film ratios that differ by more than the gap at which groups are split, ascending.
fn film_ratios(scene: &Scene, groups: &[&FilmGroup]) -> Vec<f64> {
    let of_group = |group: &&FilmGroup| match group.has_one_film_ratio() {
        true => [group.film_ratio; 2],
        false => group.ends,
    };
    let mut ratios: Vec<f64> = groups.iter().flat_map(of_group).collect();
    ratios.sort_by(f64::total_cmp);
    // as long as neighbours are near, they are one
    let mut last = f64::NEG_INFINITY;
    ratios.retain(|ratio| {
        let apart = ratio - last > scene.data.film_ratio_gap;
        last = *ratio;
        apart
    });
    ratios
}
