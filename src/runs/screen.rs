//! Says why a checked run is left out, by the limits of the scene.

use super::read_run::ReadRun;
use crate::scene::{Scene, Sticking, LARGEST_FILM_RATIO};

const WIDEN: &str = "widen the limits in [data] to use those beyond them";

/// What would use runs that no setting of the scene leaves out.
pub(crate) const NOTHING_USES: &str =
    "nothing uses a film ratio above 0.5: where so many have one, check films and diameters";

/// Why a run may be left out, what would use such runs, and whether it is so of a run.
type Reason = (&'static str, &'static str, fn(&ReadRun, &Scene) -> bool);

/// Every reason, of which the first that holds is told.
pub(super) const REASONS: [Reason; 6] = [
    ("impact speed below min_impact_speed", WIDEN, |run, scene| {
        let least = scene.data.screens.min_impact_speed;
        least.is_some_and(|least| run.impact_speed < least)
    }),
    ("impact speed above max_impact_speed", WIDEN, |run, scene| {
        let most = scene.data.screens.max_impact_speed;
        most.is_some_and(|most| run.impact_speed > most)
    }),
    ("film thinner than min_film", WIDEN, |run, scene| {
        let least = scene.data.screens.min_film;
        run.setting.liquid.is_some() && least.is_some_and(|least| run.setting.film < least)
    }),
    (
        "film ratio above 0.5, outside every inertial form",
        NOTHING_USES,
        |run, _| run.own_film_ratio() > LARGEST_FILM_RATIO,
    ),
    ("film ratio above max_film_ratio", WIDEN, |run, scene| {
        run.own_film_ratio() > scene.data.screens.max_film_ratio
    }),
    (
        "stuck, which the scene's sticking leaves out",
        "sticking = \"censored\" in [model] uses those that stuck",
        |run, scene| {
            let has_stuck = run.restitution <= scene.data.smallest_restitution;
            has_stuck && scene.model.sticking != Sticking::Censored
        },
    ),
];

/// Why a checked run is left out, by its place among [`REASONS`]; `None` keeps it.
pub(super) fn screen(run: &ReadRun, scene: &Scene) -> Option<usize> {
    REASONS.iter().position(|(.., is_so)| is_so(run, scene))
}
