//! Lists where an energy balance is told: particles at film ratios, and at diameters where its form or k tells these apart.

use crate::physics::Form;
use crate::runs::{FilmGroup, Runs, Series};
use crate::scene::Scene;

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
