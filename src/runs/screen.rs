//! Says why a checked run is left out, by the limits of the scene.

use super::read_run::ReadRun;
use crate::scene::{Scene, Sticking, LARGEST_FILM_RATIO};

/// Why a run is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    TooSlow,
    TooFast,
    FilmTooThin,
    FilmRatioInvalid,
    FilmRatioTooLarge,
    Stuck,
}

const WIDEN: &str = "widen the limits in [data] to use those beyond them";

/// What would use runs that no setting of the scene leaves out.
pub(crate) const NOTHING_USES: &str =
    "nothing uses a film ratio above 0.5: where so many have one, check films and diameters";

/// Each [`Reason`] in words, in their order, and what would use such runs.
pub(super) const REASONS: [[&str; 2]; 6] = [
    ["impact speed below min_impact_speed", WIDEN],
    ["impact speed above max_impact_speed", WIDEN],
    ["film thinner than min_film", WIDEN],
    ["film ratio above 0.5, outside every inertial form", NOTHING_USES],
    ["film ratio above max_film_ratio", WIDEN],
    [
        "stuck, which the scene's sticking leaves out",
        "sticking = \"censored\" in [model] uses those that stuck",
    ],
];

/// Why a checked run is left out; `None` keeps it.
pub(super) fn screen(run: &ReadRun, scene: &Scene) -> Option<Reason> {
    let screens = &scene.data.screens;
    if screens.min_impact_speed.is_some_and(|least| run.impact_speed < least) {
        return Some(Reason::TooSlow);
    }
    if screens.max_impact_speed.is_some_and(|most| run.impact_speed > most) {
        return Some(Reason::TooFast);
    }
    let stuck = run.restitution <= scene.data.smallest_restitution && scene.model.sticking != Sticking::Censored;
    let of_stuck = stuck.then_some(Reason::Stuck);
    if run.setting.liquid.is_none() {
        return of_stuck;
    }
    let film_ratio = run.own_film_ratio();
    if screens.min_film.is_some_and(|least| run.setting.film < least) {
        Some(Reason::FilmTooThin)
    } else if film_ratio > LARGEST_FILM_RATIO {
        Some(Reason::FilmRatioInvalid)
    } else if film_ratio > screens.max_film_ratio {
        Some(Reason::FilmRatioTooLarge)
    } else {
        of_stuck
    }
}
