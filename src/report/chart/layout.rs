//! Places panels in rows and columns, with one legend, and draws them as a document.

use super::data::{Chart, Extent};
use super::drawing::{document, text_line, Frame};
use super::legend::Legend;
use super::panel::{Look, Panel};

/// Panels with axes of one size, and their legend.
pub(super) struct Layout<'a> {
    /// row by row
    panels: Vec<Vec<Panel<'a>>>,
    columns: Vec<Margins>,
    rows: Vec<Margins>,
    pub(super) legend: Legend<'a>,
    look: &'static Look,
}

/// Room before and after the axes of a row or column, in pixels.
#[derive(Clone, Copy, Default)]
struct Margins {
    before: f64,
    after: f64,
}

impl Margins {
    fn at_least(self, before: f64, after: f64) -> Self {
        Self {
            before: self.before.max(before.ceil()),
            after: self.after.max(after.ceil()),
        }
    }
}

impl<'a> Layout<'a> {
    pub(super) fn new<Row: AsRef<[Chart]>>(charts: &'a [Row], look: &'static Look) -> Self {
        let charts = || charts.iter().map(Row::as_ref);
        let of_row = |row: &'a [Chart]| row.iter().map(|chart| Panel::new(chart, look)).collect();
        let panels: Vec<Vec<Panel>> = charts().map(of_row).collect();
        // the label of a tick at either end of an axis stands half its width beyond
        let beyond = panels.iter().flatten().map(Panel::beyond).fold(0.0, f64::max);
        let widest = panels.iter().map(Vec::len).max().unwrap_or(0);
        let mut columns = vec![Margins::default().at_least(beyond, beyond); widest];
        let mut rows = vec![Margins::default(); panels.len()];
        for (of_row, row) in panels.iter().zip(&mut rows) {
            for (panel, column) in of_row.iter().zip(&mut columns) {
                *column = column.at_least(panel.left(), 0.0);
                *row = row.at_least(panel.top(), panel.bottom());
            }
        }
        Self {
            panels,
            columns,
            rows,
            legend: Legend::of(charts().flatten()),
            look,
        }
    }

    /// Width of all but the axes and the legend, in pixels.
    pub(super) fn margins_width(&self) -> f64 {
        self.along(&self.columns, 0.0).1
    }

    /// Draws all panels with axes of at least this size; the legend stands beside them or below.
    ///
    /// A label longer than its axis widens all axes instead of being cut.
    pub(super) fn document(&self, axes: Extent, legend_beside: bool) -> String {
        let axes = self.panels.iter().flatten().fold(axes, |axes, panel| {
            let least = panel.least_axes();
            Extent {
                width: axes.width.max(least.width),
                height: axes.height.max(least.height),
            }
        });
        let (lefts, panels_width) = self.along(&self.columns, axes.width);
        let (tops, panels_height) = self.along(&self.rows, axes.height);
        let mut elements = String::new();
        for (of_row, top) in self.panels.iter().zip(&tops) {
            for ((panel, left), (margins, letter)) in of_row.iter().zip(&lefts).zip(self.columns.iter().zip('a'..)) {
                let frame = Frame {
                    left: *left,
                    top: *top,
                    width: axes.width,
                    height: axes.height,
                };
                elements += &panel.svg(frame);
                if self.look.letters {
                    let at = (frame.left - margins.before, frame.top - self.look.title_rise());
                    let bold = r#" font-weight="bold""#;
                    elements += &text_line(at, self.look.label_size, bold, &format!("({letter})"));
                }
            }
        }
        let (corner, columns) = if legend_beside {
            ((panels_width, tops.first().copied().unwrap_or(0.0)), 1)
        } else {
            let columns = self.legend.columns_within(panels_width);
            let spare = panels_width - self.legend.extent(columns).width;
            (((spare / 2.0).max(0.0).round(), panels_height), columns)
        };
        elements += &self.legend.svg(corner, columns);
        let legend = self.legend.extent(columns);
        let width = panels_width.max(corner.0 + legend.width).ceil();
        let height = panels_height.max(corner.1 + legend.height).ceil();
        document(width, height, &elements)
    }

    /// Where the axes of each row or column begin, and how far all of them reach.
    fn along(&self, margins: &[Margins], axes: f64) -> (Vec<f64>, f64) {
        let mut at = self.look.edge;
        let mut starts = vec![];
        for (index, margin) in margins.iter().enumerate() {
            if index > 0 {
                at += self.look.gap;
            }
            at += margin.before;
            starts.push(at);
            at += axes + margin.after;
        }
        (starts, at + self.look.edge)
    }
}
