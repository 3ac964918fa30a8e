//! Writes the log likelihood of every run and a new draw of it, at every draw of a chain.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;

use crate::findings::posterior::run_densities::{RunDensities, MOST_DENSITIES};
use crate::findings::posterior::Posterior;
use crate::inference::diagnostics::loo::SAME;
use crate::model::likelihood::pointwise::Pointwise;
use crate::report::ReportInput;
use crate::runs::Runs;
use crate::seed::Streams;

/// Bytes written at once: they are still near the processor, and the system is asked seldom.
const BLOCK: usize = 1 << 16;

/// Whether the likelihood of each run at each draw is stored, too: not of few runs that stand for many.
pub fn stores_every_run(runs: &Runs, posterior: &Posterior) -> bool {
    runs.count.is_empty() && runs.len().saturating_mul(posterior.sampled.draws()) <= MOST_DENSITIES
}

/// The law at every draw, ready for every run: new ones are drawn while they are written.
#[derive(Debug)]
pub(super) struct EveryRun<'p> {
    pointwise: Pointwise,
    /// parameters of each draw, chain after chain
    full: Vec<Vec<f64>>,
    densities: &'p RunDensities,
    /// the runs whose log likelihood is written: not those that are as likely under every draw.
    ///
    /// One that stuck for certain has a log likelihood of 0 whatever the parameters: it adds nothing to any sum, and ArviZ's
    /// LOO refuses the whole for it.
    pub informative: Vec<usize>,
    streams: Streams,
}

impl<'p> EveryRun<'p> {
    /// `None` where runs times draws are too many to store.
    pub fn new(input: ReportInput, posterior: &'p Posterior) -> Option<EveryRun<'p>> {
        let densities =
            stores_every_run(input.runs, posterior).then(|| posterior.run_densities(input.scene, input.runs));
        let densities = densities.flatten()?;
        let pointwise = Pointwise::new(input.scene, input.runs, posterior.setup.form);
        let differs = |run: &usize| !pointwise.is_stuck(*run) || densities.spread(*run) > SAME;
        Some(EveryRun {
            informative: (0..pointwise.len()).filter(differs).collect(),
            densities,
            pointwise,
            full: posterior.sampled.full_draws(),
            streams: Streams::new(input.findings.seed, "posterior_predictive"),
        })
    }

    /// Writes some draws one after another, the runs of each as they come: log likelihoods to one file, new runs to
    /// another; both filled up with zeros to as many draws as `whole`.
    ///
    /// Numbers are f32, little end first. The digits that are left out are less than chance leaves to any sum over draws:
    /// 10⁻⁷ of a log likelihood, which Monte Carlo errors of 10⁻² hide.
    pub fn write(
        &self,
        draws: Range<usize>,
        whole: usize,
        likelihood: &mut File,
        predictive: &mut File,
    ) -> io::Result<()> {
        let mut likely = BufWriter::with_capacity(BLOCK, &*likelihood);
        let mut predicted = BufWriter::with_capacity(BLOCK, &*predictive);
        for draw in draws {
            let at = self.pointwise.at(&self.full[draw]);
            for run in &self.informative {
                likely.write_all(&single(self.densities.rows(*run..run + 1)[draw]))?;
            }
            let rng = &mut self.streams.at(draw as u64);
            for run in 0..self.pointwise.len() {
                predicted.write_all(&single(at.predict(run, rng)))?;
            }
        }
        likely.flush()?;
        predicted.flush()?;
        let size = |numbers: usize| (whole * numbers * size_of::<f32>()) as u64;
        likelihood.set_len(size(self.informative.len()))?;
        predictive.set_len(size(self.pointwise.len()))
    }
}

fn single(number: f64) -> [u8; 4] {
    (number as f32).to_le_bytes()
}
