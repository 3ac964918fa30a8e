//! Draws one chart: its axes, the marks inside them and the labels around them.

use super::data::{Axis, Chart, ChartPoint, Extent, Marks};
use super::drawing::{clipped, line, rectangle, text_line, Frame, Pixel, CENTRED};
use super::scale::{drawable, AxisScale};
use super::{mark, text};

/// Length of a tick, outwards, in pixels.
const TICK: f64 = 5.0;
const BLACK: &str = "#000000";
const GRID_LINES: &str = "#e4e4e4";

/// Sizes of what stands around the axes, in pixels, and how the inside is drawn.
pub(super) struct Look {
    /// Font of the tick labels.
    pub(super) tick_size: f64,
    /// Font of titles and axis labels.
    pub(super) label_size: f64,
    /// Between the margins of neighbours.
    pub(super) gap: f64,
    /// Around all panels.
    pub(super) edge: f64,
    /// Ticks an axis is given at most, or as many more as it takes to show two.
    pub(super) ticks: &'static [f64],
    /// Whether the panels are lettered (a), (b), …
    pub(super) letters: bool,
    /// Whether there are many small panels: dots for filled markers, and no lines at the ticks.
    pub(super) small: bool,
}

impl Look {
    /// Baseline of the title above the axes.
    pub(super) fn title_rise(&self) -> f64 {
        0.8 * self.label_size
    }

    /// Baseline of the horizontal axis's label below the axes.
    fn label_drop(&self) -> f64 {
        TICK + self.tick_size + 1.5 * self.label_size
    }
}

/// One chart with its scales.
pub(super) struct Panel<'a> {
    chart: &'a Chart,
    look: &'static Look,
    x: AxisScale,
    y: AxisScale,
}

impl<'a> Panel<'a> {
    pub(super) fn new(chart: &'a Chart, look: &'static Look) -> Self {
        let reached = chart.layers.iter().flat_map(|layer| reach(&layer.marks));
        let reached = reached.filter(edge_drawable);
        let (xs, ys): (Vec<f64>, Vec<[f64; 2]>) = reached.map(|(x, low, high)| (x, [low, high])).unzip();
        Self {
            chart,
            look,
            x: AxisScale::of_axis(&chart.x, &xs, look.ticks),
            y: AxisScale::of_axis(&chart.y, ys.as_flattened(), look.ticks),
        }
    }

    /// Room left of the axes.
    pub(super) fn left(&self) -> f64 {
        labelled(&self.chart.y, self.y_label_distance() + self.look.label_size)
    }

    /// How far the label of a tick at the end of the horizontal axis stands out.
    pub(super) fn beyond(&self) -> f64 {
        labelled(&self.chart.x, 0.5 * self.x.label_width(self.look.tick_size))
    }

    /// Room above the axes.
    pub(super) fn top(&self) -> f64 {
        if self.look.letters || self.chart.title.is_some() {
            self.look.title_rise() + self.look.label_size
        } else {
            0.0
        }
    }

    /// Room below the axes.
    pub(super) fn bottom(&self) -> f64 {
        labelled(&self.chart.x, self.look.label_drop() + 0.4 * self.look.label_size)
    }

    /// Axes along which no label is cut.
    pub(super) fn least_axes(&self) -> Extent {
        let across = |label: &str| text::width(label, self.look.label_size).ceil();
        let title = self.chart.title.as_deref().map_or(0.0, across);
        Extent {
            width: title.max(across(&self.chart.x.label)),
            height: across(&self.chart.y.label),
        }
    }

    /// Baseline of the vertical axis's label left of the axes.
    fn y_label_distance(&self) -> f64 {
        TICK + 3.0 + self.y.label_width(self.look.tick_size) + 0.6 * self.look.label_size
    }

    /// Everything, with the axes along the frame.
    pub(super) fn svg(&self, frame: Frame) -> String {
        let (inside, points) = self.marks(frame);
        let mut elements = String::new();
        if !self.look.small {
            elements += &self.grid_lines(frame);
        }
        elements += &clipped(frame, &inside);
        elements += &rectangle(frame, &format!(" fill=\"none\" stroke=\"{BLACK}\""));
        elements += "\n";
        elements += &points;
        if !self.chart.x.label.is_empty() {
            elements += &self.x_labels(frame);
        }
        if !self.chart.y.label.is_empty() {
            elements += &self.y_labels(frame);
        }
        if let Some(title) = &self.chart.title {
            let at = (frame.left + frame.width / 2.0, frame.top - self.look.title_rise());
            elements += &text_line(at, self.look.label_size, CENTRED, title);
        }
        elements
    }

    fn grid_lines(&self, frame: Frame) -> String {
        let (right, bottom) = (frame.left + frame.width, frame.top + frame.height);
        let verticals = self.x.ticks().map(|tick| self.across(frame, tick));
        let horizontals = self.y.ticks().map(|tick| self.down(frame, tick));
        verticals
            .map(|x| line((x, frame.top), (x, bottom), GRID_LINES))
            .chain(horizontals.map(|y| line((frame.left, y), (right, y), GRID_LINES)))
            .collect()
    }

    /// Bands, lines over them and error bars, to be clipped; and the points, which are not, so that a marker on the edge
    /// stays whole.
    fn marks(&self, frame: Frame) -> (String, String) {
        let at = |x: f64, y: f64| (self.across(frame, x), self.down(frame, y));
        let [mut bands, mut lines, mut bars, mut points] = [const { String::new() }; 4];
        for layer in &self.chart.layers {
            let style = layer.style;
            match &layer.marks {
                Marks::Band(edges) => {
                    let pieces = edges.split(|edge| !edge_drawable(edge));
                    for piece in pieces.filter(|piece| piece.len() > 1) {
                        let upper = piece.iter().map(|&(x, _, upper)| at(x, upper));
                        let lower = piece.iter().rev().map(|&(x, lower, _)| at(x, lower));
                        let corners: Vec<Pixel> = upper.chain(lower).collect();
                        bands += &mark::area(&corners, style);
                    }
                }
                Marks::Line(xy, dash) => {
                    let pieces = xy.split(|(x, y)| !(drawable(*x) && drawable(*y)));
                    for piece in pieces.filter(|piece| piece.len() > 1) {
                        let pixels: Vec<Pixel> = piece.iter().map(|&(x, y)| at(x, y)).collect();
                        lines += &mark::stroke(&pixels, style, *dash);
                    }
                }
                Marks::Points(all) => {
                    let within = |p: &&ChartPoint| self.x.contains(p.x) && self.y.contains(p.y);
                    let mut pixels = vec![];
                    for point in all.iter().filter(within) {
                        pixels.push(at(point.x, point.y));
                        if let Some(se) = bar(point) {
                            let high = at(point.x, point.y + se).1;
                            bars += &mark::error_bar(at(point.x, point.y - se), high, style);
                        }
                    }
                    if !self.look.small || style.open {
                        points.extend(pixels.into_iter().map(|at| mark::marker(at, style)));
                    } else if !pixels.is_empty() {
                        points += &mark::dots(&pixels, style);
                    }
                }
            }
        }
        (bands + &lines + &bars, points)
    }

    /// Ticks and labels below the axes.
    fn x_labels(&self, frame: Frame) -> String {
        let (tick_size, label_size) = (self.look.tick_size, self.look.label_size);
        let bottom = frame.top + frame.height;
        let every = self.x.labelled_every(self.x.label_width(tick_size) + 4.0, frame.width);
        let mut elements = String::new();
        for (index, tick) in self.x.ticks().enumerate() {
            let x = self.across(frame, tick);
            elements += &line((x, bottom), (x, bottom + TICK), BLACK);
            if index % every == 0 {
                elements += &text_line((x, bottom + TICK + tick_size), tick_size, CENTRED, &self.x.label(tick));
            }
        }
        let at = (frame.left + frame.width / 2.0, bottom + self.look.label_drop());
        elements + &text_line(at, label_size, CENTRED, &self.chart.x.label)
    }

    /// Ticks and labels left of the axes.
    fn y_labels(&self, frame: Frame) -> String {
        let (tick_size, label_size) = (self.look.tick_size, self.look.label_size);
        let every = self.y.labelled_every(1.2 * tick_size, frame.height);
        let mut elements = String::new();
        for (index, tick) in self.y.ticks().enumerate() {
            let y = self.down(frame, tick);
            elements += &line((frame.left, y), (frame.left - TICK, y), BLACK);
            if index % every == 0 {
                let at = (frame.left - TICK - 3.0, y + 0.36 * tick_size);
                elements += &text_line(at, tick_size, r#" text-anchor="end""#, &self.y.label(tick));
            }
        }
        let (x, y) = (frame.left - self.y_label_distance(), frame.top + frame.height / 2.0);
        let upwards = format!(
            "{CENTRED} transform=\"rotate(-90,{},{})\"",
            text::decimal(x),
            text::decimal(y)
        );
        elements + &text_line((x, y), label_size, &upwards, &self.chart.y.label)
    }

    fn across(&self, frame: Frame, x: f64) -> f64 {
        within_reach(frame.left + frame.width * self.x.share(x))
    }

    fn down(&self, frame: Frame, y: f64) -> f64 {
        within_reach(frame.top + frame.height * (1.0 - self.y.share(y)))
    }
}

/// What an axis needs where it has a label; without one it has no ticks either.
fn labelled(axis: &Axis, room: f64) -> f64 {
    if axis.label.is_empty() {
        0.0
    } else {
        room
    }
}

/// How far marks reach: x, lowest and highest y.
fn reach(marks: &Marks) -> Vec<(f64, f64, f64)> {
    let of_point = |p: &ChartPoint| {
        let se = bar(p).unwrap_or(0.0);
        (p.x, p.y - se, p.y + se)
    };
    match marks {
        Marks::Points(points) => points.iter().map(of_point).collect(),
        Marks::Line(xy, _) => xy.iter().map(|&(x, y)| (x, y, y)).collect(),
        Marks::Band(edges) => edges.clone(),
    }
}

fn edge_drawable(edge: &(f64, f64, f64)) -> bool {
    drawable(edge.0) && drawable(edge.1) && drawable(edge.2)
}

/// Half the length of a point's error bar, where it has one.
fn bar(point: &ChartPoint) -> Option<f64> {
    point.y_se.filter(|se| drawable(*se) && *se > 0.0)
}

/// Keeps pixels within what viewers can hold in single precision.
fn within_reach(pixel: f64) -> f64 {
    pixel.clamp(-1e5, 1e5)
}
