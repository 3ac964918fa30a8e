//! Draws charts described by plain data as one SVG picture.
//!
//! Labels may hold subscripts and superscripts: `e_{n}`, `m s^{−1}`. An underscore or caret
//! without braces is printed as it stands, so particle names need no care.

//!
//! | file | job |
//! |---|---|
//! | `layout.rs` | places panels in rows and columns, with one legend |
//! | `panel.rs` | draws one chart: axes, marks, labels |
//! | `scale.rs` | chooses limits, ticks and tick labels |
//! | `mark.rs` | draws markers, lines, bands and error bars |
//! | `legend.rs` | lists the named layers |
//! | `text.rs` | sets scripts, escapes labels, estimates their width |
//! | `drawing.rs` | writes SVG |

mod drawing;
mod layout;
mod legend;
mod mark;
mod panel;
mod scale;
mod text;

use layout::Layout;
use panel::Look;

/// One set of axes with what is drawn on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading above the axes.
    pub title: Option<String>,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Bands are drawn lowest, lines over them and points on top, each in this order.
    pub layers: Vec<Layer>,
}

/// An axis, linear in what it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit, e.g. `impact speed v / (m s^{−1})`.
    pub label: String,
    /// Limits (lower, upper); `None`, or limits that span nothing, fits them to the data.
    pub range: Option<(f64, f64)>,
    /// Whether it is given logarithms to base 10, which its ticks show as powers of ten.
    pub decades: bool,
}

impl Axis {
    /// An axis whose limits follow the data.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            range: None,
            decades: false,
        }
    }

    /// The same axis for logarithms to base 10.
    pub fn of_decades(self) -> Self {
        Self { decades: true, ..self }
    }

    /// The same axis with fixed limits; what lies outside is not drawn.
    pub fn between(self, lower: f64, upper: f64) -> Self {
        Self {
            range: Some((lower, upper)),
            ..self
        }
    }
}

/// One series. A `name` puts it in the legend; layers with equal names share an entry.
/// Values that are not finite are left out.
#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// Markers, with error bars where a point has a standard error.
    Points {
        /// Text of the legend.
        name: Option<String>,
        /// The points in any order.
        points: Vec<ChartPoint>,
        /// Colour and marker.
        style: Style,
    },
    /// A curve through its points, broken where a value is not finite.
    Line {
        /// Text of the legend.
        name: Option<String>,
        /// Points (x, y) along the curve.
        xy: Vec<(f64, f64)>,
        /// Colour.
        style: Style,
        /// Stroke pattern.
        dash: Dash,
    },
    /// A translucent strip between two curves, broken where a value is not finite.
    Band {
        /// Text of the legend.
        name: Option<String>,
        /// Edges (x, lower y, upper y) along the strip.
        edges: Vec<(f64, f64, f64)>,
        /// Colour.
        style: Style,
    },
}

impl Layer {
    /// The layer's text in the legend.
    pub fn name(&self) -> Option<&str> {
        match self {
            Layer::Points { name, .. } | Layer::Line { name, .. } | Layer::Band { name, .. } => name.as_deref(),
        }
    }
}

/// One marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPoint {
    /// Horizontal position.
    pub x: f64,
    /// Vertical position.
    pub y: f64,
    /// Standard error of `y`, drawn as a bar from `y − se` to `y + se`.
    pub y_se: Option<f64>,
}

/// Colour and marker of a layer.
///
/// Groups 0 to 7 differ in both, so that they stay apart in grey print and for the
/// colour-blind; from 8 on both repeat with the filling reversed. Group 0 is black.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// Number of the group.
    pub group: usize,
    /// Whether the markers are hollow.
    pub open: bool,
}

impl Style {
    /// The filled style of a group.
    pub fn group(group: usize) -> Self {
        Self { group, open: false }
    }

    /// The same style with hollow markers.
    pub fn open(self) -> Self {
        Self { open: true, ..self }
    }
}

/// Stroke pattern of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    Solid,
    /// Long strokes.
    Dashed,
    /// Dots.
    Dotted,
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

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
    let layout = Layout::new(&[charts.iter().map(Some).collect()], look);
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
pub fn grid(rows: &[Vec<Option<Chart>>], axes: Extent) -> String {
    let rows: Vec<Vec<Option<&Chart>>> = rows
        .iter()
        .map(|row| row.iter().map(Option::as_ref).collect())
        .collect();
    Layout::new(&rows, &SMALL).document(axes, false)
}

#[cfg(test)]
mod tests;
