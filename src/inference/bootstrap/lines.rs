//! Fits lines to replicates in which no draw moves a weight or an abscissa, straight from what was drawn.

use std::ops::Range;

use super::batches::TOGETHER;
use super::kernel::{sums, Failure, LineDesign, Sample, WeightedFit};
use super::wide::{widest, Wide};

/// Where the sums that a batch of draws moves are tabulated.
#[derive(Debug, Clone)]
pub(super) struct BatchTable {
    /// its stratum's part of the tables of Σ w (e − mean) and Σ w (e − mean)², by what is drawn
    pub(super) table: Range<usize>,
    /// node of its stratum
    pub(super) node: usize,
}

/// Sums that a draw moves.
const SUMS: usize = 3;

/// Numbers read at once, which fill a register of the machine; after the sums comes one that is of no use.
const READ: usize = 4;

/// Linear fits to other restitutions of the same nodes.
#[derive(Debug, Clone)]
pub(super) struct LineFits {
    design: LineDesign,
    /// restitution about which all sums are
    centre: f64,
    /// Σ w e, Σ w e (x − mean) and Σ w e² of the runs themselves, e about the centre
    own: [f64; SUMS],
    batches: Range<usize>,
    /// where the table of each batch starts
    starts: Vec<u32>,
    /// what the sums grow by, by what is drawn; READ at once, so that some follow the last
    tables: Vec<f64>,
}

impl LineFits {
    /// From the nodes at the means of their own runs, and the batches of draws that move them; fails as [`super::kernel::linear`] does.
    pub(super) fn new(
        sample: &Sample,
        batches: Range<usize>,
        of_batch: &[BatchTable],
        tables: &[[f64; 2]],
    ) -> Result<LineFits, Failure> {
        let (x, e, w) = (sample.x, sample.restitution, sample.weights);
        let x0 = *x.get(x.len() / 2).ok_or(Failure::Degenerate)?;
        let [n, sx, xx, se] = sums([x, x, e, w], |x, _, e, w| {
            let x = x - x0;
            [w, w * x, w * x * x, w * e]
        });
        let design = LineDesign::new(n, x0, sx, xx)?;
        let centre = se * design.share;
        let own = sums([x, x, e, w], |x, _, e, w| {
            let e = e - centre;
            [w * e, w * e * (x - design.centre), w * e * e]
        });
        let mut lines = LineFits {
            design,
            centre,
            own,
            batches,
            starts: vec![],
            tables: vec![],
        };
        let (mut last, mut start) = (0..0, 0);
        for BatchTable { table, node } in of_batch {
            if *table != last {
                last = table.clone();
                start = u32::try_from(lines.tables.len() / SUMS).map_err(|_| Failure::Degenerate)?;
                let (x, e) = (x[*node] - design.centre, e[*node] - centre);
                let own = tables[table.clone()].iter();
                lines.tables.extend(own.flat_map(|[s, q]| [*s, s * x, q + 2.0 * s * e]));
            }
            lines.starts.push(start);
        }
        lines.tables.extend([0.0; READ - SUMS]);
        Ok(lines)
    }

    /// What [`super::kernel::linear`] finds in replicates drawn together, from what their batches drew.
    pub(super) fn fit(&self, drawn: &[[u32; TOGETHER]]) -> impl Iterator<Item = WeightedFit> + use<'_> {
        let drawn = &drawn[self.batches.clone()];
        let sums = widest(AddDrawn { lines: self, drawn });
        sums.into_iter().map(|[s, x, e, _]| {
            let [se, xe, ee] = [self.own[0] + s, self.own[1] + x, self.own[2] + e];
            let me = se * self.design.share;
            self.design.through(self.centre + me, xe, ee - se * me)
        })
    }
}

/// What batches add to the sums of each replicate.
struct AddDrawn<'a> {
    lines: &'a LineFits,
    drawn: &'a [[u32; TOGETHER]],
}

impl Wide for AddDrawn<'_> {
    /// With what was read after the sums: left out here, the compiler would read them one by one.
    type Output = [[f64; READ]; TOGETHER];

    // all sums of a replicate at once
    #[inline(always)]
    fn run(self) -> [[f64; READ]; TOGETHER] {
        let mut sums = [[0.0; READ]; TOGETHER];
        for (drawn, start) in self.drawn.iter().zip(&self.lines.starts) {
            let table = &self.lines.tables[SUMS * *start as usize..];
            for (sums, drawn) in sums.iter_mut().zip(drawn) {
                let at = SUMS * *drawn as usize;
                for (sum, more) in sums.iter_mut().zip(&table[at..at + READ]) {
                    *sum += more;
                }
            }
        }
        sums
    }
}
