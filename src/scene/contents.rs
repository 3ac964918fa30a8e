//! Holds a scene: everything that does not change from run to run.

use std::path::{Path, PathBuf};

use super::choices::{Bootstrap, ModelChoices, PriorChoice, Sampler};
use super::data::Data;
use super::materials::{Liquid, Particle};
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

    /// Why nothing that reads ε is known of some of the particles, by their places; `None` where each has its roughness.
    pub fn why_no_roughness(&self, particles: impl IntoIterator<Item = usize>) -> Option<String> {
        let particles = particles.into_iter().map(|particle| &self.particles[particle]);
        let without = particles.filter(|particle| particle.roughness.is_none());
        let names: Vec<&str> = without.map(|particle| particle.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("no roughness is given for {}", names.join(", ")))
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
