//! Fits lines to replicates in which no draw moves a weight or an abscissa, straight from what was drawn.

use std::ops::Range;

use super::batches::TOGETHER;
use super::kernel::{Failure, LineDesign, Sample, WeightedFit};
use super::multisets::{Multisets, MOST_SEQUENCES};
use super::wide::{widest, Wide};
use crate::inference::sums::sums;

/// Where the sums that a batch of draws moves are tabulated.
#[derive(Debug, Clone)]
pub(super) struct BatchTable {
    /// its stratum's part of the tables of Σ w (e − mean) and Σ w (e − mean)², by what is drawn
    pub(super) table: Range<usize>,
    /// node of its stratum
    pub(super) node: usize,
    /// where the multisets of its sequences start in [`Multisets::of_sequence`]; `None` where a sequence is a member
    pub(super) multisets: Option<u32>,
}

/// Sums that a draw moves.
const SUMS: usize = 3;

/// Numbers read at once, which fill a register of the machine; after the sums comes one that is of no use.
const READ: usize = 4;

/// Numbers in the rows that a multiset can name, with what is read after the last.
const IN_ROWS: usize = SUMS * u8::MAX as usize + READ;

/// Linear fits to other restitutions of the same nodes.
#[derive(Debug, Clone)]
pub(super) struct LineFits {
    design: LineDesign,
    /// restitution about which all sums are
    centre: f64,
    /// Σ w e, Σ w e (x − mean) and Σ w e² of the runs themselves, e about the centre
    own: [f64; SUMS],
    batches: Range<usize>,
    /// where the multisets and the table of each batch start
    starts: Vec<(Option<u32>, u32)>,
    multisets: &'static Multisets,
    /// what the sums grow by, by what is drawn; IN_ROWS follow every start
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
        let [n, sx, xx, se] = sums([x, e, w], |[x, e, w]| {
            let x = x - x0;
            [w, w * x, w * x * x, w * e]
        });
        let design = LineDesign::new(n, x0, sx, xx)?;
        let centre = se * design.share;
        let own = sums([x, e, w], |[x, e, w]| {
            let e = e - centre;
            [w * e, w * e * (x - design.centre), w * e * e]
        });
        let mut lines = LineFits {
            design,
            centre,
            own,
            batches,
            starts: vec![],
            multisets: Multisets::all(),
            tables: vec![],
        };
        let (mut last, mut start) = (0..0, 0);
        for BatchTable { table, node, multisets } in of_batch {
            if *table != last {
                last = table.clone();
                start = u32::try_from(lines.tables.len() / SUMS).map_err(|_| Failure::Degenerate)?;
                let (x, e) = (x[*node] - design.centre, e[*node] - centre);
                let own = tables[table.clone()].iter();
                lines.tables.extend(own.flat_map(|[s, q]| [*s, s * x, q + 2.0 * s * e]));
            }
            lines.starts.push((*multisets, start));
        }
        lines.tables.extend([0.0; IN_ROWS]);
        Ok(lines)
    }

    /// What [`super::kernel::linear`] finds in replicates drawn together, from what their batches drew.
    pub(super) fn fit(&self, drawn: &[[u32; TOGETHER]]) -> [WeightedFit; TOGETHER] {
        let mut fits = [WeightedFit::NONE; TOGETHER];
        widest(AddDrawn {
            lines: self,
            drawn: &drawn[self.batches.clone()],
            sums: &mut [[0.0; READ]; TOGETHER],
            fits: &mut fits,
        });
        fits
    }
}

/// What batches add to the sums of each replicate.
struct AddDrawn<'a> {
    lines: &'a LineFits,
    drawn: &'a [[u32; TOGETHER]],
    /// with what was read after the sums: not written anywhere, the compiler would read the others one by one
    sums: &'a mut [[f64; READ]; TOGETHER],
    fits: &'a mut [WeightedFit; TOGETHER],
}

impl Wide for AddDrawn<'_> {
    type Output = ();

    // all sums of a replicate at once
    #[inline(always)]
    fn run(self) {
        let lines = self.lines;
        let mut sums = [[0.0; READ]; TOGETHER];
        let of_sequence = &lines.multisets.of_sequence;
        for (drawn, (multisets, start)) in self.drawn.iter().zip(&lines.starts) {
            let start = SUMS * *start as usize;
            match multisets {
                // of so many that no number leads beyond
                Some(first) => {
                    let multisets = &of_sequence[*first as usize..*first as usize + MOST_SEQUENCES];
                    let table = &lines.tables[start..start + IN_ROWS];
                    for (sums, sequence) in sums.iter_mut().zip(drawn) {
                        let at = SUMS * usize::from(multisets[*sequence as usize % MOST_SEQUENCES]);
                        add(sums, &table[at..at + READ]);
                    }
                }
                None => {
                    for (sums, member) in sums.iter_mut().zip(drawn) {
                        let at = start + SUMS * *member as usize;
                        add(sums, &lines.tables[at..at + READ]);
                    }
                }
            }
        }
        *self.sums = sums;
        for (fit, [s, x, e, _]) in self.fits.iter_mut().zip(sums) {
            let [se, xe, ee] = [lines.own[0] + s, lines.own[1] + x, lines.own[2] + e];
            let me = se * lines.design.share;
            *fit = lines.design.through(lines.centre + me, xe, ee - se * me);
        }
    }
}

/// Adds what a batch drew to the sums of a replicate.
#[inline(always)] // in the registers of the caller
fn add(sums: &mut [f64; READ], more: &[f64]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum += more;
    }
}
