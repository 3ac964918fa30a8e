//! Holds all findings of a fit, as `findings.json` writes it.

use serde::Serialize;

use super::balance::EnergyBalance;
use super::bootstrap::Resampling;
use super::checks::{self, Check};
use super::compare;
use super::constants::Sensitivity;
use super::dry::Dry;
use super::energy::Energy;
use super::film_groups::FilmGroupWidth;
use super::form_choice::InertiaChoice;
use super::identify::Directions;
use super::least_squares::LeastSquares;
use super::main_numbers::MainNumbers;
use super::measurement_errors::RunsWithErrors;
use super::noise::Noise;
use super::notices::{by_weight, SERIES_OFFSETS, SINGLE_RUN};
use super::posterior::PosteriorFindings;
use super::published;
use super::questions::Question;
use super::scaling::Scaling;
use super::series::SeriesFit;
use super::terms::SizedTerm;
use crate::notice::Notice;
use crate::physics::Form;
use crate::runs::{Screened, Table};

/// The name and version of the findings file's layout, which `docs/findings.schema.json` describes; the version is raised
/// where a field is removed or changes its meaning.
pub const SCHEMA: &str = "wetcor.findings/2";

/// All findings of a fit. Field names are those of `findings.json`.
#[derive(Debug, Serialize)]
pub struct Findings {
    /// always [`SCHEMA`]
    pub schema: &'static str,
    /// the scene's folder name
    pub scene: String,
    /// the scene's title
    pub title: String,
    /// version that made this
    pub wetcor: &'static str,
    /// seed of every use of chance
    pub seed: u64,
    /// SHA-256 of the table of runs
    pub data_sha256: String,
    /// SHA-256 of the scene file
    pub scene_sha256: String,
    /// what was read and used
    pub counts: Counts,
    /// the numbers that are quoted first
    pub main: MainNumbers,
    /// the form of the inertial loss that the runs chose; `None` where the scene names it
    pub inertia: Option<InertiaChoice>,
    /// the forms that were sampled to choose it
    #[serde(skip)]
    pub(super) sampled_forms: Vec<compare::EvaluatedModel>,
    /// k of each particle with dry runs
    pub dry: Vec<Dry>,
    /// the runs of each particle that belong to one film ratio
    pub film_groups: Vec<FilmGroupWidth>,
    /// the square-root law of each series
    pub series: Vec<SeriesFit>,
    /// e_inf and St_c by both laws
    pub scaling: Vec<Scaling>,
    /// L, inertial prefactor and film scale over all rebounds; `None` without a usable k
    pub energy_balance: Option<EnergyBalance>,
    /// what each term of the energy balance matters, and whether it is held
    pub terms: Vec<SizedTerm>,
    /// the energy balance that is held; its form of inertia may still be open
    #[serde(skip)]
    pub form: Form,
    /// where the energy went
    pub energy: Vec<Energy>,
    /// how results move with the constants taken as exact
    pub constants: Vec<Sensitivity>,
    /// what the scatter of the runs is like; `None` without a fit or without scatter
    pub noise: Option<Noise>,
    /// how replicates were made; `None`: a stage that was not run
    pub bootstrap: Option<Resampling>,
    /// the literature beside ours
    pub published: Vec<published::PublishedComparison>,
    /// what all runs at once say under the priors; `None` if the stage was not run
    pub posterior: Option<PosteriorFindings>,
    /// how well each form of the law predicts runs it has not seen; `None` if the stage was not run
    pub compare: Option<Vec<compare::ComparedModel>>,
    /// whether L and C are the same at every film ratio; `None` if the stage was not run
    pub questions: Option<Vec<Question>>,
    /// which parameters the runs identify; `None` without parameters, or where a sum is not finite
    pub identifies: Option<Directions>,
    /// what must hold before the numbers are quoted
    pub verdicts: Vec<Check>,
    /// what wants a second look
    pub notices: Vec<Notice>,
}

/// What was read and used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// rows of the file
    pub runs: usize,
    /// sheets of workbooks that they were read from
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sheets: Vec<String>,
    /// rebounds used by least squares
    pub used: usize,
    /// runs that stuck
    pub stuck: usize,
    /// runs left out, by reason
    pub screened: Vec<Screened>,
    /// runs in use that carry measurement errors; `None` where none does
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<RunsWithErrors>,
}

impl Counts {
    pub(super) fn of(table: &Table) -> Counts {
        let runs = &table.runs;
        Counts {
            runs: table.rows,
            sheets: table.sheets.clone(),
            used: runs.all_measured() - runs.stuck(),
            stuck: runs.stuck(),
            screened: table.screened.clone(),
            measurement_errors: RunsWithErrors::of(runs),
        }
    }
}

/// What a reader of the main numbers should look at, with what to do about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caution<'a> {
    /// what was found
    pub text: &'a str,
    /// what to do about it
    pub next_step: &'a str,
}

impl Findings {
    /// Everything that bears on a main number without forbidding to quote it: checks that failed, then notices, those
    /// that bear on it most first, without what the first lines or a failed check say already.
    pub fn cautions(&self) -> Vec<Caution<'_>> {
        let failed = self.verdicts.iter().filter(|check| check.cautions());
        let of_checks = failed.map(|check| Caution {
            text: check.found(),
            next_step: check.advice,
        });
        let fails = |check: &Check| !check.passed && check.check == checks::INDEPENDENT_RUNS.code;
        let offsets_are_told = self.verdicts.iter().any(fails);
        let is_told =
            |notice: &Notice| notice.code == SINGLE_RUN.code || offsets_are_told && notice.code == SERIES_OFFSETS.code;
        let notices = by_weight(&self.notices).into_iter();
        let notices = notices.filter(|notice| notice.cautions() && !is_told(notice));
        let of_notices = notices.map(|notice| Caution {
            text: &notice.text,
            next_step: &notice.next_step,
        });
        of_checks.chain(of_notices).collect()
    }

    /// What least squares found, for the stages that start from it.
    pub fn least_squares(&self) -> LeastSquares<'_> {
        LeastSquares {
            seed: self.seed,
            dry: &self.dry,
            series: &self.series,
            scaling: &self.scaling,
            energy: &self.energy,
            energy_balance: self.energy_balance.as_ref(),
            form: self.form,
        }
    }
}
