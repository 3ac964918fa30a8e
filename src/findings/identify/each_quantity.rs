//! Says of each quantity by itself whether the runs tell it, by counting them.

use serde::Serialize;

use crate::findings::range::range;
use crate::physics::loss::Loss;
use crate::runs::{FilmGroup, Runs, Series};
use crate::scene::Scene;

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

/// Fewest rebounds that give two parameters and a spread.
const FEWEST: usize = 3;

/// What the runs of each sphere with a k of its own can tell, parameter by parameter.
pub fn identify_each_quantity(scene: &Scene, runs: &Runs) -> Vec<Identified> {
    let mut all = vec![];
    let mut any_st_c = false;
    for (index, sphere) in runs.spheres.iter().enumerate() {
        let name = sphere.label(scene);
        let dry: usize = runs
            .dry_of(index)
            .iter()
            .map(|g| runs.measured(g.rebounds.clone()))
            .sum();
        let groups = runs.film_groups_of(index);
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
        let usable_groups = || {
            let varying = |g: &&FilmGroup| varies(scene, runs, &runs.series[g.series.clone()]);
            groups.iter().filter(varying)
        };
        let usable = usable_groups().count();
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
        // runs without a film ratio of their own have several
        let usable = usable + usable_groups().filter(|group| !group.has_one_film_ratio()).count();
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
    let viscous = scene.model.viscous.coefficients().iter();
    for coefficient in viscous.filter(|_| !runs.series.is_empty()) {
        all.push(Identified {
            quantity: coefficient.describe().name.to_owned(),
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
    let rebounds: usize = series.iter().map(|s| runs.measured(s.rebounds.clone())).sum();
    rebounds >= FEWEST && stokes_differ(scene, runs, series)
}

/// Whether the rebounds of some series of one particle have different Stokes numbers.
pub(super) fn stokes_differ(scene: &Scene, runs: &Runs, series: &[Series]) -> bool {
    let scaled = series.iter().flat_map(|s| {
        // St up to factors common to the particle
        let viscosity = scene.liquids[s.liquid].viscosity;
        s.rebounds
            .clone()
            .map(move |run| runs.diameter[run] * runs.impact_speed[run] / viscosity)
    });
    range(scaled).is_some_and(|[lo, hi]| hi > lo * (1.0 + 1e-9))
}
