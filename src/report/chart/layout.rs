//! Places panels in rows and columns, with one legend, and draws them as a document.

use super::data::{Chart, Extent};
use super::drawing::{Drawing, Element, Frame};
use super::legend::Legend;
use super::panel::{Look, Panel};

/// Panels with axes of one size, and their legend.
pub(super) struct Layout<'a> {
    cells: Vec<GridCell<'a>>,
    columns: Vec<Margins>,
    rows: Vec<Margins>,
    pub(super) legend: Legend<'a>,
    look: &'static Look,
}

/// One panel and where it stands.
struct GridCell<'a> {
    panel: Panel<'a>,
    row: usize,
    column: usize,
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
    pub(super) fn new(charts: &[Vec<Option<&'a Chart>>], look: &'static Look) -> Self {
        let mut cells = vec![];
        for (row, of_row) in charts.iter().enumerate() {
            for (column, chart) in of_row.iter().enumerate() {
                let panel = chart.map(|chart| Panel::new(chart, look));
                cells.extend(panel.map(|panel| GridCell { panel, row, column }));
            }
        }
        // the label of a tick at either end of an axis stands half its width beyond
        let beyond = cells.iter().map(|cell| cell.panel.beyond()).fold(0.0, f64::max);
        let widest = charts.iter().map(Vec::len).max().unwrap_or(0);
        let mut columns = vec![Margins::default().at_least(beyond, beyond); widest];
        let mut rows = vec![Margins::default(); charts.len()];
        for GridCell { panel, row, column } in &cells {
            columns[*column] = columns[*column].at_least(panel.left(), 0.0);
            rows[*row] = rows[*row].at_least(panel.top(), panel.bottom());
        }
        Self {
            cells,
            columns,
            rows,
            legend: Legend::of(charts.iter().flatten().copied().flatten()),
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
        let axes = self.cells.iter().fold(axes, |axes, cell| {
            let least = cell.panel.least_axes();
            Extent {
                width: axes.width.max(least.width),
                height: axes.height.max(least.height),
            }
        });
        let (lefts, panels_width) = self.along(&self.columns, axes.width);
        let (tops, panels_height) = self.along(&self.rows, axes.height);
        let mut drawing = Drawing::default();
        for cell in &self.cells {
            let frame = Frame {
                left: lefts[cell.column],
                top: tops[cell.row],
                width: axes.width,
                height: axes.height,
            };
            cell.panel.draw(&mut drawing, frame);
            if self.look.letters {
                let letter = char::from_u32('a' as u32 + cell.column as u32).unwrap_or('?');
                let outside = frame.left - self.columns[cell.column].before;
                let at = (outside, frame.top - self.look.title_rise());
                let bold = Element::text(at, self.look.label_size).set("font-weight", "bold");
                drawing.write(bold, &format!("({letter})"));
            }
        }
        let (corner, columns) = if legend_beside {
            ((panels_width, tops.first().copied().unwrap_or(0.0)), 1)
        } else {
            let columns = self.legend.columns_within(panels_width);
            let spare = panels_width - self.legend.extent(columns).width;
            (((spare / 2.0).max(0.0).round(), panels_height), columns)
        };
        self.legend.draw(&mut drawing, corner, columns);
        let legend = self.legend.extent(columns);
        drawing.document(
            panels_width.max(corner.0 + legend.width).ceil(),
            panels_height.max(corner.1 + legend.height).ceil(),
        )
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
