//! Makes the log likelihood of every run and a new draw of it, at every draw of a chain, while they are written.

use std::fs::File;
use std::io::{self, Write};
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
pub(super) struct EveryRun<'a> {
    pointwise: Pointwise<'a>,
    /// parameters of each draw, chain after chain
    full: Vec<Vec<f64>>,
    /// the runs whose log likelihood is written, see [`informative`]
    pub informative: Vec<usize>,
    streams: Streams,
}

impl<'a> EveryRun<'a> {
    pub fn new(input: ReportInput<'a>, posterior: &Posterior) -> EveryRun<'a> {
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
    pub fn write(
        &self,
        draws: Range<usize>,
        whole: usize,
        likelihood: &mut File,
        predictive: &mut File,
    ) -> io::Result<()> {
        let mut likely = Singles::new(likelihood, self.informative.len());
        let mut predicted = Singles::new(predictive, self.pointwise.len());
        for draw in draws {
            let at = self.pointwise.at(&self.full[draw]);
            let densities: Vec<f64> = self.informative.iter().map(|run| at.ln_likelihood(*run)).collect();
            likely.put(&densities)?;
            predicted.put(&at.predictions(&mut self.streams.at(draw as u64)))?;
        }
        likely.end(whole)?;
        predicted.end(whole)
    }
}

/// A file of rows of numbers as f32, little end first. The digits that are left out are less than chance leaves to any sum
/// over draws: 10⁻⁷ of a log likelihood, which Monte Carlo errors of 10⁻² hide.
struct Singles<'f> {
    file: &'f mut File,
    numbers: usize,
    /// room for as many rows as are written at once
    bytes: Vec<u8>,
    filled: usize,
}

impl<'f> Singles<'f> {
    fn new(file: &'f mut File, numbers: usize) -> Singles<'f> {
        let row = numbers * size_of::<f32>();
        let rows = BLOCK.checked_div(row).unwrap_or(0).max(1);
        Singles {
            file,
            numbers,
            bytes: vec![0; rows * row],
            filled: 0,
        }
    }

    fn put(&mut self, row: &[f64]) -> io::Result<()> {
        if self.filled == self.bytes.len() {
            self.flush()?;
        }
        let bytes = &mut self.bytes[self.filled..];
        for (bytes, number) in bytes.as_chunks_mut().0.iter_mut().zip(row) {
            *bytes = (*number as f32).to_le_bytes();
        }
        self.filled += row.len() * size_of::<f32>();
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.write_all(&self.bytes[..self.filled])?;
        self.filled = 0;
        Ok(())
    }

    /// Writes what is left, and fills up to so many rows.
    fn end(mut self, rows: usize) -> io::Result<()> {
        self.flush()?;
        self.file.set_len((rows * self.numbers * size_of::<f32>()) as u64)
    }
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
        let range = row
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi): (f64, f64), ln| {
                (lo.min(*ln), hi.max(*ln))
            });
        range.1 - range.0 > SAME
    };
    (0..pointwise.len()).into_par_iter().filter(differs).collect()
}
