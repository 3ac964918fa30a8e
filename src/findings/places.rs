//! Says what an estimate is of, and lists where an energy balance is told: particles at film ratios, and at diameters where its
//! form or k tells these apart.

use schemars::JsonSchema;
use serde::Serialize;

use crate::physics::Form;
use crate::rounding::short;
use crate::runs::{FilmGroup, Runs, Series};
use crate::scene::Scene;
use crate::units::millimetres;

/// What an estimate is of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct EstimatePlace {
    /// name of the particle; `None` of what particles share
    pub particle: Option<String>,
    /// name of the liquid; `None` of what liquids share, and of several that are taken as one
    pub liquid: Option<String>,
    /// D, m; `None` of what diameters share
    pub diameter_m: Option<f64>,
    /// δ/D; `None` of what films share
    pub film_ratio: Option<f64>,
}

impl EstimatePlace {
    pub(super) fn of_particle(particle: &str, diameter_m: Option<f64>) -> EstimatePlace {
        EstimatePlace {
            particle: Some(particle.to_owned()),
            diameter_m,
            ..EstimatePlace::default()
        }
    }

    pub(super) fn at(self, film_ratio: Option<f64>) -> EstimatePlace {
        EstimatePlace { film_ratio, ..self }
    }

    /// The same of all liquids.
    pub fn of_all_liquids(&self) -> EstimatePlace {
        EstimatePlace {
            liquid: None,
            ..self.clone()
        }
    }

    /// Its words in a sentence, as far as it has them: particle, film ratio, diameter; and others after them.
    pub fn words(&self, more: Option<&str>) -> String {
        let ratio = self.film_ratio.map(|ratio| format!("δ/D = {}", short(ratio)));
        let diameter = self.diameter_m.map(|d| format!("D = {} mm", short(millimetres(d))));
        let all = [self.particle.clone(), ratio, diameter, more.map(str::to_owned)];
        all.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// A particle at a film ratio, and at one diameter where the form of the balance or k tells diameters apart.
#[derive(Debug, Clone)]
pub(super) struct WetPlace<'r> {
    /// index into the scene's particles
    pub particle: usize,
    /// index into [`Runs::spheres`]: its k
    pub sphere: usize,
    /// δ/D
    pub film_ratio: f64,
    /// D, m; `None` where it stands for all
    pub diameter: Option<f64>,
    /// its series
    pub series: Vec<&'r Series>,
    runs: &'r Runs,
}

impl<'r> WetPlace<'r> {
    /// A film group with all its diameters.
    pub fn of_group(runs: &'r Runs, group: &FilmGroup) -> WetPlace<'r> {
        WetPlace {
            particle: group.particle,
            sphere: group.sphere,
            film_ratio: group.film_ratio,
            diameter: runs.spheres[group.sphere].diameter,
            series: runs.series[group.series.clone()].iter().collect(),
            runs,
        }
    }

    /// Every place of a form, in the order of the film groups.
    pub fn all(runs: &'r Runs, form: Form) -> Vec<WetPlace<'r>> {
        let groups = runs.film_groups.iter().map(|group| WetPlace::of_group(runs, group));
        if form.viscous.tells_diameters_apart() {
            groups.flat_map(WetPlace::by_diameter).collect()
        } else {
            groups.collect()
        }
    }

    /// One place for each diameter, the smallest first.
    fn by_diameter(mut self) -> Vec<WetPlace<'r>> {
        self.series.sort_by(|a, b| a.diameter.total_cmp(&b.diameter));
        let of_one = self.series.chunk_by(|a, b| a.is_as_large_as(b));
        of_one
            .map(|series| WetPlace {
                diameter: self.diameter.or(Some(series[0].diameter)),
                series: series.to_vec(),
                ..self
            })
            .collect()
    }

    /// How many runs rebounded there.
    pub fn rebounds(&self) -> usize {
        self.series.iter().map(|series| self.rebounds_of(series)).sum()
    }

    fn rebounds_of(&self, series: &Series) -> usize {
        self.runs.measured(series.rebounds.clone())
    }

    /// The mean of a number over the rebounds; over the series where none rebounded.
    fn mean(&self, of: impl Fn(&Series) -> f64) -> f64 {
        let rebounds = self.rebounds();
        if rebounds == 0 {
            return self.series.iter().map(|one| of(one)).sum::<f64>() / self.series.len() as f64;
        }
        let weighted = self.series.iter().map(|one| self.rebounds_of(one) as f64 * of(one));
        weighted.sum::<f64>() / rebounds as f64
    }

    /// ρ̃, mean over the rebounds.
    pub fn density_ratio(&self, scene: &Scene) -> f64 {
        self.mean(|series| series.density_ratio(scene))
    }

    /// The part of L that no parameter of a form moves, mean over the rebounds.
    pub fn fixed_over_stokes(&self, scene: &Scene, form: Form) -> f64 {
        self.mean(|series| form.fixed_over_stokes(&series.setting(scene)))
    }
}
