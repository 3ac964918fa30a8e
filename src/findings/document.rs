//! Holds all findings of a fit, as `findings.json` writes it.

use std::ops::Deref;

use schemars::JsonSchema;
use serde::Serialize;

use super::bootstrap::Resampling;
use super::compare;
use super::constants::Sensitivity;
use super::estimates::EstimateRow;
use super::form_choice::InertiaChoice;
use super::identify::Directions;
use super::least_squares::LeastSquares;
use super::main_numbers::MainNumbers;
use super::noise::Noise;
use super::posterior::PosteriorFindings;
use super::published;
use super::questions::Question;
use super::remarks::{self, in_order, SERIES_OFFSETS, SINGLE_RUN};
use crate::remark::Remark;
use crate::runs::{RunsWithErrors, Screened, Table};

/// The name and version of the findings file's layout, which `docs/findings.schema.json` describes; the version is raised
/// where a field is removed or changes its meaning.
pub const SCHEMA: &str = "wetcor.findings/3";

/// All findings of a fit. Field names are those of `findings.json`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Findings {
    /// name and version of the layout of this file
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
    /// whether the numbers that are quoted first, the rows marked `main` of `estimates`, may be quoted, and what was learnt
    pub main: MainNumbers,
    /// the form of the inertial loss that the runs chose; `None` where the scene names it
    pub inertia: Option<InertiaChoice>,
    /// the forms that were sampled to choose it
    #[serde(skip)]
    pub(super) sampled_forms: Vec<compare::EvaluatedModel>,
    /// what least squares found
    #[serde(flatten)]
    pub fits: LeastSquares,
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
    /// what must hold before the numbers are quoted, and what wants a second look
    pub remarks: Vec<Remark>,
    /// every estimate, one a row; a main number as it is quoted, others with the standard error of their fit
    pub estimates: Vec<EstimateRow>,
}

/// What was read and used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
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
            measurement_errors: RunsWithErrors::of(&runs.errors),
        }
    }
}

impl Findings {
    /// What was held against a line, whether it holds or not.
    pub fn checks(&self) -> impl Iterator<Item = &Remark> + Clone {
        self.remarks.iter().filter(|remark| remark.line.is_some())
    }

    /// What was only told where it was found.
    pub fn notices(&self) -> impl Iterator<Item = &Remark> + Clone {
        self.remarks.iter().filter(|remark| remark.line.is_none())
    }

    /// Everything that bears on a main number without forbidding to quote it, in the order in which it is told, without
    /// what the first lines or a failed check say already.
    pub fn cautions(&self) -> Vec<&Remark> {
        let is_apart = |remark: &Remark| remarks::INDEPENDENT_RUNS.is(remark) && !remark.passed;
        let offsets_are_told = self.remarks.iter().any(is_apart);
        let is_told = |remark: &Remark| SINGLE_RUN.is(remark) || offsets_are_told && SERIES_OFFSETS.is(remark);
        let mut told = in_order(&self.remarks);
        told.retain(|remark| remark.cautions() && !is_told(remark));
        told
    }
}

impl Deref for Findings {
    type Target = LeastSquares;

    fn deref(&self) -> &LeastSquares {
        &self.fits
    }
}
