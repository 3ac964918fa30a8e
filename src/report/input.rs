//! Holds what a report is made of.

use crate::findings::posterior::Posterior;
use crate::findings::predict::ParticleLaw;
use crate::findings::Findings;
use crate::runs::Runs;
use crate::scene::Scene;

/// What a report is made of.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// the command that makes the report again
    pub command: &'a str,
    /// what was held fixed
    pub scene: &'a Scene,
    /// what was measured
    pub runs: &'a Runs,
    /// what was found
    pub findings: &'a Findings,
    /// the posterior's draws; `None` if nothing was sampled
    pub posterior: Option<&'a Posterior>,
}

impl ReportInput<'_> {
    /// The posterior's law of each sphere, of so many draws at most; `None` where nothing was sampled.
    pub(super) fn laws(self, draws: usize) -> Option<Vec<ParticleLaw>> {
        let posterior = self.posterior?;
        let law = |sphere: usize| posterior.law(self.scene, self.runs, sphere, draws);
        Some((0..self.runs.spheres.len()).map(law).collect())
    }

    /// The same with runs as they were measured: of very many an even sample.
    pub fn of_sample(self) -> Self {
        ReportInput {
            runs: self.runs.sample(),
            ..self
        }
    }
}
