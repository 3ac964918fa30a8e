//! Holds a scene: everything that does not change from run to run.

use std::path::{Path, PathBuf};

use super::choices::{Bootstrap, ModelChoices, PriorChoice, Sampler};
use super::materials::{Liquid, Particle};
use super::naming::Naming;
use super::plan::{Design, Truth};
use super::published::Published;
use crate::physics::Setting;

/// A scene: everything that does not change from run to run. SI inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// the scene file, as the user named it
    pub file: PathBuf,
    /// name of the folder the scene file lies in
    pub name: String,
    /// title of the report
    pub title: String,
    /// where the runs come from, in words
    pub source: Option<String>,
    /// SHA-256 of the scene file
    pub sha256: String,
    /// which runs, and which of them are used
    pub data: Data,
    /// the particles, in the order of the file
    pub particles: Vec<Particle>,
    /// the liquids, in the order of the file
    pub liquids: Vec<Liquid>,
    /// what the model holds
    pub model: ModelChoices,
    /// priors the scene sets; every other one keeps its default
    pub priors: Vec<PriorChoice>,
    /// how a posterior is sampled
    pub sampler: Sampler,
    /// how intervals are made
    pub bootstrap: Bootstrap,
    /// numbers from the literature to set beside ours
    pub published: Vec<Published>,
    /// the truth of a simulation
    pub truth: Option<Truth>,
    /// the design of a simulation
    pub design: Option<Design>,
    /// keys the scene sets that no stage of this version reads, as `table.key`
    pub unused: Vec<String>,
}

impl Scene {
    /// The scene file and its tables, which must stay as they are.
    pub fn inputs(&self) -> Vec<&Path> {
        let tables = self.data.runs.iter().map(|table| table.path.as_path());
        std::iter::once(self.file.as_path()).chain(tables).collect()
    }

    /// Whether the stated errors of measurement are all that scatters the dry or the wet runs, by the name of their spread:
    /// it is held at 0.
    pub fn errors_are_all(&self, spread: &str) -> bool {
        self.held_at_zero(spread).is_some()
    }

    /// The prior that holds a parameter at 0, of all particles.
    pub(crate) fn held_at_zero(&self, parameter: &str) -> Option<&PriorChoice> {
        let mut set = self.priors.iter();
        set.find(|choice| choice.parameter == parameter && choice.prior == super::Prior::Fixed(0.0))
    }

    /// A particle of the scene in a liquid of it, by their places; diameter and film in m.
    pub fn setting(&self, particle: usize, liquid: usize, diameter: f64, film: f64) -> Setting {
        let (particle, liquid) = (&self.particles[particle], &self.liquids[liquid]);
        Setting {
            density: particle.density,
            diameter,
            roughness: particle.roughness,
            liquid_density: liquid.density,
            viscosity: liquid.viscosity,
            film,
            surface_tension: liquid.surface_tension,
        }
    }
}

/// Which runs, and which of them are used.
#[derive(Debug, Clone, PartialEq)]
pub struct Data {
    /// the tables of runs, at least one, whose rows follow one another
    pub runs: Vec<TableFile>,
    /// what they call their columns and their words
    pub naming: Naming,
    /// a restitution at or below this counts as stuck
    pub smallest_restitution: f64,
    /// where runs carry no film ratio: the nominal ones they were made at, in increasing order; empty where groups are to be
    /// found
    pub film_ratios: Vec<f64>,
    /// where neither names a film ratio: sorted δ/D is split at larger gaps
    pub film_ratio_gap: f64,
    /// sd of an error of the film thickness that all runs share, m; absent: the films are taken as exact
    pub film_sd: Option<f64>,
    /// sd over value of an error that all speeds share; absent: their scale is taken as exact
    pub speed_rel_sd: Option<f64>,
    /// which runs are left out
    pub screens: Screens,
}

/// A table of runs.
#[derive(Debug, Clone, PartialEq)]
pub struct TableFile {
    /// the file
    pub path: PathBuf,
    /// which sheet of a workbook; absent: the first
    pub sheet: Option<String>,
}

impl TableFile {
    /// What ends the name of a workbook.
    pub const WORKBOOK: &str = ".xlsx";

    /// The table that a scene names; the name of a sheet stands after that of its workbook.
    pub fn named(folder: Option<&Path>, name: &str) -> TableFile {
        let lower = name.to_ascii_lowercase();
        let sheet_at = lower
            .find(&format!("{}#", TableFile::WORKBOOK))
            .map(|at| at + TableFile::WORKBOOK.len());
        let (file, sheet) = match sheet_at {
            Some(at) => (&name[..at], Some(name[at + 1..].to_owned())),
            None => (name, None),
        };
        TableFile {
            path: folder.map_or_else(|| PathBuf::from(file), |folder| folder.join(file)),
            sheet,
        }
    }

    /// As the scene names it.
    pub fn shown(&self) -> PathBuf {
        match &self.sheet {
            Some(sheet) => {
                let mut name = self.path.clone().into_os_string();
                name.push(format!("#{sheet}"));
                name.into()
            }
            None => self.path.clone(),
        }
    }

    /// Whether it is a file of this ending.
    pub fn ends_with(&self, ending: &str) -> bool {
        let name = self.path.file_name().map(|name| name.to_string_lossy().to_lowercase());
        name.is_some_and(|name| name.ends_with(ending))
    }
}

impl From<PathBuf> for TableFile {
    fn from(path: PathBuf) -> TableFile {
        TableFile { path, sheet: None }
    }
}

/// Limits outside which a run is left out and counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screens {
    /// thinnest film, m
    pub min_film: Option<f64>,
    /// largest film ratio δ/D; never above [`super::LARGEST_FILM_RATIO`]
    pub max_film_ratio: f64,
    /// slowest impact, m/s
    pub min_impact_speed: Option<f64>,
    /// fastest impact, m/s
    pub max_impact_speed: Option<f64>,
}
