//! Describes a chart as plain data: axes, layers and their styles.

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

impl Chart {
    /// A chart without a heading.
    pub fn new(x: Axis, y: Axis, layers: Vec<Layer>) -> Self {
        Self {
            title: None,
            x,
            y,
            layers,
        }
    }
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

/// One series. Layers with equal names share an entry of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Text of the legend, in which a layer without does not stand.
    pub name: Option<String>,
    /// Colour and marker.
    pub style: Style,
    /// What is drawn.
    pub marks: Marks,
}

/// What a layer draws. Values that are not finite are left out.
#[derive(Clone, Debug, PartialEq)]
pub enum Marks {
    /// Markers in any order, with error bars where a point has a standard error.
    Points(Vec<ChartPoint>),
    /// A curve through points (x, y), broken where a value is not finite.
    Line(Vec<(f64, f64)>, Dash),
    /// A translucent strip between two curves, by edges (x, lower y, upper y), broken where a value is not finite.
    Band(Vec<(f64, f64, f64)>),
}

impl Layer {
    /// Markers.
    pub fn points(name: Option<String>, points: Vec<ChartPoint>, style: Style) -> Self {
        let marks = Marks::Points(points);
        Self { name, style, marks }
    }

    /// A curve with its text in the legend.
    pub fn curve(name: impl Into<String>, xy: Vec<(f64, f64)>, style: Style, dash: Dash) -> Self {
        let (name, marks) = (Some(name.into()), Marks::Line(xy, dash));
        Self { name, style, marks }
    }

    /// A strip with its text in the legend.
    pub fn band(name: impl Into<String>, edges: Vec<(f64, f64, f64)>, style: Style) -> Self {
        let (name, marks) = (Some(name.into()), Marks::Band(edges));
        Self { name, style, marks }
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

impl ChartPoint {
    /// A marker without an error bar.
    pub fn at(x: f64, y: f64) -> Self {
        Self { x, y, y_se: None }
    }
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
