//! Lists the named layers with samples of their marks.
//!
//! kuva's legend is not used: it measures names in DejaVu Sans and so lets wider fonts run
//! out of its box, its samples are too short to tell dashes from dots, and it cannot show a
//! marker on its line or a hollow one.

use kuva::render::render::{Primitive, Scene};

use super::{mark, text, words, Chart, Layer};

const SIZE: u32 = 13;
const ROW: f64 = 21.0;
const SAMPLE: f64 = 34.0;
const GAP: f64 = 8.0;
const SPACING: f64 = 18.0;

/// Entries in order of first appearance.
pub(super) struct Legend<'a> {
    entries: Vec<(&'a str, Vec<&'a Layer>)>,
}

impl<'a> Legend<'a> {
    pub(super) fn of(charts: &'a [Chart]) -> Self {
        let mut entries: Vec<(&str, Vec<&Layer>)> = Vec::new();
        for layer in charts.iter().flat_map(|c| &c.layers) {
            let Some(name) = layer.name() else { continue };
            match entries.iter_mut().find(|(known, _)| *known == name) {
                Some((_, layers)) => layers.push(layer),
                None => entries.push((name, vec![layer])),
            }
        }
        Self { entries }
    }

    /// Width one column needs, in pixels; 0 without entries.
    pub(super) fn column_width(&self) -> f64 {
        let widths = self
            .entries
            .iter()
            .map(|(name, _)| SAMPLE + GAP + text::width(name, SIZE) + SPACING);
        widths.fold(0.0, f64::max).ceil()
    }

    /// Number of columns that fit, evened out over the rows.
    pub(super) fn columns_within(&self, width: f64) -> usize {
        let fit = (width / self.column_width().max(1.0)) as usize;
        let rows = self.entries.len().div_ceil(fit.max(1));
        self.entries.len().div_ceil(rows.max(1)).max(1)
    }

    /// Width and height in pixels, (0, 0) without entries.
    pub(super) fn extent(&self, columns: usize) -> (f64, f64) {
        if self.entries.is_empty() {
            return (0.0, 0.0);
        }
        let rows = self.entries.len().div_ceil(columns.max(1));
        let width = columns as f64 * self.column_width();
        (width, rows as f64 * ROW + 12.0)
    }

    pub(super) fn draw(&self, scene: &mut Scene, left: f64, top: f64, columns: usize) {
        let rows = self.entries.len().div_ceil(columns.max(1)).max(1);
        for (i, (name, layers)) in self.entries.iter().enumerate() {
            let x = left + (i / rows) as f64 * self.column_width();
            let y = top + ROW * ((i % rows) as f64 + 0.5);
            // One sample of each kind: later panels repeat a name with the same marks, and a
            // band painted twice would look darker than it is.
            let kinds: [fn(&Layer) -> bool; 3] = [
                |l| matches!(l, Layer::Band { .. }),
                |l| matches!(l, Layer::Line { .. }),
                |l| matches!(l, Layer::Points { .. }),
            ];
            for layer in kinds.iter().filter_map(|kind| layers.iter().find(|l| kind(l))) {
                scene.add(sample(layer, x, y));
            }
            scene.add(words(name, x + SAMPLE + GAP, y + 4.7, SIZE));
        }
    }
}

fn sample(layer: &Layer, x: f64, y: f64) -> Primitive {
    match layer {
        Layer::Points { style, .. } => mark::marker(x + SAMPLE / 2.0, y, *style),
        Layer::Line { style, dash, .. } => mark::stroke(vec![(x, y), (x + SAMPLE, y)], *style, *dash),
        Layer::Band { style, .. } => {
            let (low, high) = (y + 6.0, y - 6.0);
            let corners = [(x, low), (x + SAMPLE, low), (x + SAMPLE, high), (x, high)];
            mark::area(&corners, *style)
        }
    }
}
