//! Holds what least squares found, for the stages that start from it.

use schemars::JsonSchema;
use serde::Serialize;

use super::balance::EnergyBalance;
use super::dry::Dry;
use super::film_groups::FilmGroupWidth;
use super::scaling::Scaling;
use super::series::SeriesFit;
use super::terms::SizedTerm;
use super::wet_fit::FitSetup;
use crate::physics::Form;
use crate::runs::Runs;
use crate::scene::Scene;

/// The fits by least squares, and the seed of whatever draws next. Field names are those of `findings.json`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LeastSquares {
    /// seed of every use of chance
    #[serde(skip)]
    pub seed: u64,
    /// k of each particle with dry runs
    pub dry: Vec<Dry>,
    /// the runs of each particle that belong to one film ratio
    pub film_groups: Vec<FilmGroupWidth>,
    /// the square-root law of each series
    pub series: Vec<SeriesFit>,
    /// e_inf and St_c by both laws, and where the energy went
    pub scaling: Vec<Scaling>,
    /// L, inertial prefactor and film scale over all rebounds; `None` without a usable k
    pub energy_balance: Option<EnergyBalance>,
    /// what each term of the energy balance matters, and whether it is held
    pub terms: Vec<SizedTerm>,
    /// the energy balance that is held; its form of inertia may still be open
    #[serde(skip)]
    pub form: Form,
}

impl LeastSquares {
    pub(super) fn setup<'a>(&'a self, scene: &'a Scene, runs: &'a Runs) -> FitSetup<'a> {
        let dry = &self.dry;
        FitSetup { scene, runs, dry }
    }
}
