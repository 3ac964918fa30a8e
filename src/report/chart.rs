//! Draws charts described by plain data as one SVG picture.
//!
//! Labels may hold subscripts and superscripts: `e_{n}`, `m s^{−1}`. An underscore or caret
//! without braces is printed as it stands, so particle names need no care.

mod grid;
mod legend;
mod mark;
mod panel;
mod scale;
mod text;

use kuva::backend::svg::SvgBackend;
use kuva::render::render::{Primitive, Scene, TextAnchor};

pub use grid::grid;
use legend::Legend;
use panel::Panel;

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
        points: Vec<Point>,
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
pub struct Point {
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

/// The first family is the widest, so that the room left for it suffices for the others.
const FONTS: &str = "DejaVu Sans, Arial, Helvetica, sans-serif";
const LABEL_SIZE: u32 = 15;
const SINGLE_WIDTH: f64 = 720.0;
const PANEL_WIDTH: f64 = 550.0;

/// Draws the charts side by side in one SVG document, lettered (a), (b), … when there are
/// several, with one legend to the right or below.
///
/// The same charts give the same bytes. Any data can be drawn; an empty chart gets empty axes.
pub fn svg(charts: &[Chart]) -> String {
    let legend = Legend::of(charts);
    let full_width = match charts.len() {
        0 | 1 => SINGLE_WIDTH,
        n => n as f64 * PANEL_WIDTH,
    };
    let beside = charts.len() < 2 && legend.column_width() < 0.27 * full_width;
    let (room, height) = if beside {
        (full_width - legend.column_width(), 440.0)
    } else {
        (full_width, 400.0)
    };
    let panels: Vec<Panel> = charts
        .iter()
        .map(|chart| Panel::new(chart, charts.len() > 1, room / charts.len() as f64, height))
        .collect();
    let axes_width = panels.iter().map(|p| p.width).sum::<f64>().max(room);
    let axes_height = panels.iter().map(|p| p.height).fold(height, f64::max);

    let (legend_x, legend_y, columns) = if beside {
        (axes_width, panels.first().map_or(0.0, |p| p.top), 1)
    } else {
        let columns = legend.columns_within(axes_width);
        let spare = axes_width - columns as f64 * legend.column_width();
        ((spare / 2.0).max(0.0).round(), axes_height, columns)
    };
    let (legend_width, legend_height) = legend.extent(columns);
    let width = axes_width.max(legend_x + legend_width).ceil();
    let height = axes_height.max(legend_y + legend_height).ceil();

    let mut scene = empty(width, height);
    let mut left = 0.0;
    for (i, panel) in panels.iter().enumerate() {
        scene.add(Primitive::GroupStart {
            transform: Some(format!("translate({left},0)")),
            title: None,
            extra_attrs: None,
        });
        if panels.len() > 1 {
            let letter = char::from_u32('a' as u32 + i as u32).unwrap_or('?');
            let mut text = words(&format!("({letter})"), 12.0, 24.0, LABEL_SIZE);
            if let Primitive::Text { bold, .. } = &mut text {
                *bold = true;
            }
            scene.add(text);
        }
        panel.draw(&mut scene);
        scene.add(Primitive::GroupEnd);
        left += panel.width;
    }
    legend.draw(&mut scene, legend_x, legend_y, columns);
    document(&scene, width, height)
}

/// A scene with nothing in it.
fn empty(width: f64, height: f64) -> Scene {
    let mut scene = Scene::new(width, height);
    scene.font_family = Some(FONTS.to_string());
    scene.text_color = Some("black".to_string());
    scene
}

/// A finished scene as an SVG document.
fn document(scene: &Scene, width: f64, height: f64) -> String {
    let document = text::finish(&SvgBackend::new().render_scene(scene));
    // Without a viewBox a page that narrows the picture would crop it instead of scaling it;
    // without preserved space some viewers swallow the blank after a subscript.
    document.replacen(
        " width=",
        &format!(" viewBox=\"0 0 {width} {height}\" xml:space=\"preserve\" width="),
        1,
    )
}

/// A line of text that starts at the position.
fn words(label: &str, x: f64, y: f64, size: u32) -> Primitive {
    Primitive::Text {
        x,
        y,
        content: text::markup(label),
        size,
        anchor: TextAnchor::Start,
        rotate: None,
        bold: false,
        color: None,
    }
}

#[cfg(test)]
mod tests;
