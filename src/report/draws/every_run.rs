//! Makes the log likelihood of every run and a new draw of it, at every draw of a chain, while they are written.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;

use rayon::prelude::*;

use crate::findings::posterior::Posterior;
use crate::inference::diagnostics::loo::SAME;
use crate::model::likelihood::pointwise::Pointwise;
use crate::report::ReportInput;
use crate::seed::Streams;

/// Bytes written at once: they are still near the processor, and the system is asked seldom.
const BLOCK: usize = 1 << 16;

/// The law at every draw, ready for every run. Runs times draws are too many numbers to hold.
#[derive(Debug)]
pub(super) struct EveryRun {
    pointwise: Pointwise,
    /// parameters of each draw, chain after chain
    full: Vec<Vec<f64>>,
    /// the runs whose log likelihood is written, see [`informative`]
    pub informative: Vec<usize>,
    streams: Streams,
}

impl EveryRun {
    pub fn new(input: ReportInput, posterior: &Posterior) -> EveryRun {
        let form = posterior.setup.form;
        let pointwise = Pointwise::new(input.scene, input.runs, form);
        let full = posterior.sampled.full_draws();
        let informative = informative(&pointwise, &full);
        EveryRun {
            informative,
            pointwise,
            full,
            streams: Streams::new(input.findings.seed, "posterior_predictive"),
        }
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
                likely.write_all(&single(at.ln_likelihood(*run)))?;
            }
            for restitution in at.predictions(&mut self.streams.at(draw as u64)) {
                predicted.write_all(&single(restitution))?;
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

/// The runs that are not as likely under every draw.
///
/// One that stuck for certain has a log likelihood of 0 whatever the parameters: it adds nothing to any sum, and ArviZ's
/// LOO refuses the whole for it.
fn informative(pointwise: &Pointwise, full: &[Vec<f64>]) -> Vec<usize> {
    let at = pointwise.at_draws(full.iter().map(Vec::as_slice).collect());
    let differs = |run: &usize| {
        if !pointwise.is_stuck(*run) {
            return true;
        }
        let mut row = vec![0.0; at.len()];
        at.ln_likelihoods(*run..run + 1, &mut row);
        let most = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - row.iter().copied().fold(f64::INFINITY, f64::min) > SAME
    };
    (0..pointwise.len()).into_par_iter().filter(differs).collect()
}
