//! Draws charts described by plain data as one SVG picture.
//!
//! Labels may hold subscripts and superscripts: `e_{n}`, `m s^{−1}`. An underscore or caret
//! without braces is printed as it stands, so particle names need no care.
//!
//! | file | job |
//! |---|---|
//! | `data.rs` | describes charts |
//! | `text.rs` | sets scripts in labels, estimates their width |
//! | `drawing.rs` | writes the elements of an SVG document |
//! | `scale.rs` | chooses limits, ticks and tick labels |
//! | `mark.rs` | draws markers, lines, bands and error bars |
//! | `legend.rs` | lists the named layers |
//! | `panel.rs` | draws one chart: axes, marks, labels |
//! | `layout.rs` | places panels in rows and columns, with one legend |

mod data;
mod drawing;
mod layout;
mod legend;
mod mark;
mod panel;
mod scale;
mod text;

pub use data::{Axis, Chart, ChartPoint, Dash, Extent, Layer, Marks, Style};
use layout::Layout;
use panel::Look;

const FIGURE: Look = Look {
    tick_size: 13.0,
    label_size: 15.0,
    gap: 24.0,
    edge: 12.0,
    ticks: &[6.0],
    letters: false,
    small: false,
};
const LETTERED: Look = Look {
    letters: true,
    ..FIGURE
};
const SMALL: Look = Look {
    tick_size: 10.0,
    label_size: 13.0,
    gap: 8.0,
    edge: 10.0,
    ticks: &[3.0, 4.0, 5.0, 8.0],
    letters: false,
    small: true,
};

/// Width of a picture of one chart, in pixels.
const SINGLE_WIDTH: f64 = 720.0;
/// What each of several charts adds to the width of theirs.
const PANEL_WIDTH: f64 = 550.0;
/// Share of a picture's width that a legend beside the axes may take.
const MOST_BESIDE: f64 = 0.27;

/// Draws the charts side by side in one SVG document, lettered (a), (b), … when there are
/// several, with one legend to the right or below.
///
/// The same charts give the same bytes. Any data can be drawn; an empty chart gets empty axes.
pub fn svg(charts: &[Chart]) -> String {
    let single = charts.len() < 2;
    let look = if single { &FIGURE } else { &LETTERED };
    let rows = [charts];
    let layout = Layout::new(&rows, look);
    let width = if single {
        SINGLE_WIDTH
    } else {
        charts.len() as f64 * PANEL_WIDTH
    };
    let legend_width = layout.legend.column_width();
    let beside = single && legend_width < MOST_BESIDE * width;
    let taken = layout.margins_width() + if beside { legend_width } else { 0.0 };
    let axes = Extent {
        width: ((width - taken) / charts.len().max(1) as f64).floor(),
        height: if beside { 340.0 } else { 300.0 },
    };
    layout.document(axes, beside)
}

/// Draws the charts in rows, each with axes of this size or larger, and one legend below.
///
/// An axis without a label has no ticks either: neighbours with equal limits may share theirs. Filled points are drawn as
/// dots, hollow ones as markers. What lies outside the axes is not drawn. The same charts give the same bytes.
pub fn grid(rows: &[Vec<Chart>], axes: Extent) -> String {
    Layout::new(rows, &SMALL).document(axes, false)
}

#[cfg(test)]
mod tests;
