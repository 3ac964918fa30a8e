//! Makes the log likelihood of every run and a new draw of it, at every draw of a chain, while they are written.

use std::fs::File;
use std::io::{self, Write};
use std::ops::Range;

use rayon::prelude::*;

use crate::findings::posterior::Posterior;
use crate::inference::diagnostics::loo::SAME;
use crate::model::likelihood::pointwise::Pointwise;
use crate::model::normals::Normals;
use crate::report::Told;
use crate::seed::Streams;

/// Bytes written at once: they are still near the processor, and the system is asked seldom.
const BLOCK: usize = 1 << 18;

/// The law at every draw, ready for every run. Runs times draws are too many numbers to hold.
#[derive(Debug)]
pub(super) struct EveryRun<'a> {
    pointwise: Pointwise<'a>,
    /// parameters of each draw, chain after chain
    full: Vec<Vec<f64>>,
    /// the runs whose log likelihood is written, see [`telling`]
    pub telling: Vec<usize>,
    streams: Streams,
    normals: Normals,
}

impl<'a> EveryRun<'a> {
    pub fn new(told: Told<'a>, posterior: &Posterior) -> EveryRun<'a> {
        let asked = posterior.asked;
        let pointwise = Pointwise::new(told.scene, told.runs, asked.form);
        let full = posterior.sampled.full_draws();
        EveryRun {
            telling: telling(&pointwise, &full),
            pointwise,
            full,
            streams: Streams::new(told.findings.seed, "posterior_predictive"),
            normals: Normals::new(),
        }
    }

    /// Writes some draws one after another, the runs of each as they come: log likelihoods as f64 to one file, new runs
    /// as f32 to another, little end first.
    pub fn write(&self, draws: Range<usize>, likelihood: &mut File, predictive: &mut File) -> io::Result<()> {
        let (mut likely, mut predicted) = (vec![], vec![]);
        let mut densities = vec![0.0; self.telling.len()];
        let mut new = vec![];
        for draw in draws {
            let at = self.pointwise.at(&self.full[draw]);
            at.ln_likelihoods(&self.telling, &mut densities);
            extend(&mut likely, &densities, f64::to_le_bytes);
            at.predictions(&self.normals, &mut self.streams.at(draw as u64), &mut new);
            // the digits that f32 leaves out are noise
            extend(&mut predicted, &new, |e| (e as f32).to_le_bytes());
            flush(&mut likely, likelihood, BLOCK)?;
            flush(&mut predicted, predictive, BLOCK)?;
        }
        flush(&mut likely, likelihood, 0)?;
        flush(&mut predicted, predictive, 0)
    }
}

/// Adds the bytes of some numbers.
fn extend<const N: usize>(bytes: &mut Vec<u8>, numbers: &[f64], of: impl Fn(f64) -> [u8; N]) {
    let begin = bytes.len();
    bytes.resize(begin + N * numbers.len(), 0);
    // room is made once for all: a check for each number would cost more than the number
    for (bytes, number) in bytes[begin..].chunks_exact_mut(N).zip(numbers) {
        bytes.copy_from_slice(&of(*number));
    }
}

/// Writes the bytes if there are so many.
fn flush(bytes: &mut Vec<u8>, file: &mut File, least: usize) -> io::Result<()> {
    if bytes.len() >= least {
        file.write_all(bytes)?;
        bytes.clear();
    }
    Ok(())
}

/// The runs that are not as likely under every draw.
///
/// One that stuck for certain has a log likelihood of 0 whatever the parameters: it adds nothing to any sum, and ArviZ's
/// LOO refuses the whole for it.
fn telling(pointwise: &Pointwise, full: &[Vec<f64>]) -> Vec<usize> {
    let stuck: Vec<usize> = (0..pointwise.len()).filter(|run| pointwise.is_stuck(*run)).collect();
    let none = || vec![(f64::INFINITY, f64::NEG_INFINITY); stuck.len()];
    // smallest and largest are the same in any order
    let ranges = full
        .par_iter()
        .fold(none, |mut ranges, full| {
            for ((lo, hi), z) in ranges.iter_mut().zip(pointwise.limits(full, &stuck)) {
                (*lo, *hi) = (lo.min(z), hi.max(z));
            }
            ranges
        })
        .reduce(none, |a, b| {
            let both = a.iter().zip(&b);
            both.map(|(a, b)| (a.0.min(b.0), a.1.max(b.1))).collect()
        });
    let mut tells = vec![true; pointwise.len()];
    for (run, range) in stuck.iter().zip(&ranges) {
        tells[*run] = !pointwise.is_certain(*range, SAME);
    }
    (0..pointwise.len()).filter(|run| tells[*run]).collect()
}
