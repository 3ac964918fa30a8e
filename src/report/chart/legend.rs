//! Lists the named layers with samples of their marks.

use super::data::{Chart, Extent, Layer, Marks};
use super::drawing::{text_line, Pixel};
use super::{mark, text};

const SIZE: f64 = 13.0;
const ROW: f64 = 21.0;
const SAMPLE: f64 = 34.0;
const GAP: f64 = 8.0;
const SPACING: f64 = 18.0;

/// Entries in order of first appearance, each with one sample of a band, a line and points: later panels repeat a name with the
/// same marks, and a band painted twice would look darker than it is.
pub(super) struct Legend<'a> {
    entries: Vec<(&'a str, [Option<&'a Layer>; 3])>,
}

impl<'a> Legend<'a> {
    pub(super) fn of(charts: impl Iterator<Item = &'a Chart>) -> Self {
        let mut entries: Vec<(&str, [Option<&Layer>; 3])> = vec![];
        for layer in charts.flat_map(|chart| &chart.layers) {
            let Some(name) = layer.name.as_deref() else { continue };
            let known = entries.iter().position(|(known, _)| *known == name);
            let place = known.unwrap_or(entries.len());
            if known.is_none() {
                entries.push((name, [None; 3]));
            }
            let kind = match layer.marks {
                Marks::Band(_) => 0,
                Marks::Line(..) => 1,
                Marks::Points(_) => 2,
            };
            entries[place].1[kind].get_or_insert(layer);
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

    /// Size in pixels, nothing without entries.
    pub(super) fn extent(&self, columns: usize) -> Extent {
        let rows = self.entries.len().div_ceil(columns.max(1));
        let height = if rows == 0 { 0.0 } else { rows as f64 * ROW + 12.0 };
        Extent {
            width: columns as f64 * self.column_width(),
            height,
        }
    }

    /// The entries from a corner rightwards and down, column after column.
    pub(super) fn svg(&self, (left, top): Pixel, columns: usize) -> String {
        let rows = self.entries.len().div_ceil(columns.max(1)).max(1);
        let mut elements = String::new();
        for (i, (name, samples)) in self.entries.iter().enumerate() {
            let x = left + (i / rows) as f64 * self.column_width();
            let y = top + ROW * ((i % rows) as f64 + 0.5);
            let samples = samples.iter().flatten();
            elements.extend(samples.map(|layer| sample(layer, (x, y))));
            elements += &text_line((x + SAMPLE + GAP, y + 4.7), SIZE, "", name);
        }
        elements
    }
}

/// A layer's mark, from a place to the right.
fn sample(layer: &Layer, (x, y): Pixel) -> String {
    let style = layer.style;
    match &layer.marks {
        Marks::Points(_) => mark::marker((x + SAMPLE / 2.0, y), style),
        Marks::Line(_, dash) => mark::stroke(&[(x, y), (x + SAMPLE, y)], style, *dash),
        Marks::Band(_) => {
            let (low, high) = (y + 6.0, y - 6.0);
            let corners = [(x, low), (x + SAMPLE, low), (x + SAMPLE, high), (x, high)];
            mark::area(&corners, style)
        }
    }
}
