//! Draws one chart: its axes, the marks inside them and the labels around them.

use super::data::{Axis, Chart, ChartPoint, Extent, Marks, Style};
use super::drawing::{Drawing, Element, Frame, Pixel};
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

    /// Draws everything, with the axes along the frame.
    pub(super) fn draw(&self, drawing: &mut Drawing, frame: Frame) {
        if !self.look.small {
            self.draw_grid_lines(drawing, frame);
        }
        drawing.clipped(frame, |inside| {
            self.draw_bands(inside, frame);
            self.draw_lines(inside, frame);
            self.draw_error_bars(inside, frame);
        });
        drawing.add(Element::rectangle(frame).set("fill", "none").set("stroke", BLACK));
        // Not clipped, so that a marker on the edge stays whole.
        self.draw_points(drawing, frame);
        if !self.chart.x.label.is_empty() {
            self.label_x(drawing, frame);
        }
        if !self.chart.y.label.is_empty() {
            self.label_y(drawing, frame);
        }
        if let Some(title) = &self.chart.title {
            let at = (frame.left + frame.width / 2.0, frame.top - self.look.title_rise());
            drawing.write(Element::centred_text(at, self.look.label_size), title);
        }
    }

    fn draw_grid_lines(&self, drawing: &mut Drawing, frame: Frame) {
        let (right, bottom) = (frame.left + frame.width, frame.top + frame.height);
        let verticals = self.x.ticks().map(|tick| self.across(frame, tick));
        let horizontals = self.y.ticks().map(|tick| self.down(frame, tick));
        let lines = verticals
            .map(|x| ((x, frame.top), (x, bottom)))
            .chain(horizontals.map(|y| ((frame.left, y), (right, y))));
        for (from, to) in lines {
            drawing.add(line(from, to, GRID_LINES));
        }
    }

    fn draw_bands(&self, drawing: &mut Drawing, frame: Frame) {
        for layer in &self.chart.layers {
            let Marks::Band(edges) = &layer.marks else {
                continue;
            };
            for piece in edges.split(|e| !edge_drawable(e)).filter(|piece| piece.len() > 1) {
                let upper = piece.iter().map(|&(x, _, upper)| self.at(frame, x, upper));
                let lower = piece.iter().rev().map(|&(x, lower, _)| self.at(frame, x, lower));
                drawing.add(mark::area(&upper.chain(lower).collect::<Vec<_>>(), layer.style));
            }
        }
    }

    fn draw_lines(&self, drawing: &mut Drawing, frame: Frame) {
        for layer in &self.chart.layers {
            let Marks::Line(xy, dash) = &layer.marks else {
                continue;
            };
            let broken = |p: &(f64, f64)| !(drawable(p.0) && drawable(p.1));
            for piece in xy.split(broken).filter(|piece| piece.len() > 1) {
                let pixels: Vec<Pixel> = piece.iter().map(|&(x, y)| self.at(frame, x, y)).collect();
                drawing.add(mark::stroke(&pixels, layer.style, *dash));
            }
        }
    }

    fn draw_error_bars(&self, drawing: &mut Drawing, frame: Frame) {
        for (style, points) in self.points_within() {
            for p in points {
                if let Some(se) = bar(p) {
                    let high = self.at(frame, p.x, p.y + se).1;
                    drawing.add(mark::error_bar(self.at(frame, p.x, p.y - se), high, style));
                }
            }
        }
    }

    fn draw_points(&self, drawing: &mut Drawing, frame: Frame) {
        for (style, points) in self.points_within() {
            let pixels: Vec<Pixel> = points.iter().map(|p| self.at(frame, p.x, p.y)).collect();
            if !self.look.small || style.open {
                pixels.iter().for_each(|at| drawing.add(mark::marker(*at, style)));
            } else if !pixels.is_empty() {
                drawing.add(mark::dots(&pixels, style));
            }
        }
    }

    /// Points inside the axes, layer by layer, with the style of each.
    fn points_within(&self) -> impl Iterator<Item = (Style, Vec<&ChartPoint>)> + '_ {
        self.chart.layers.iter().filter_map(|layer| {
            let Marks::Points(points) = &layer.marks else {
                return None;
            };
            let within = |p: &&ChartPoint| self.x.contains(p.x) && self.y.contains(p.y);
            Some((layer.style, points.iter().filter(within).collect()))
        })
    }

    fn label_x(&self, drawing: &mut Drawing, frame: Frame) {
        let bottom = frame.top + frame.height;
        let needed = self.x.label_width(self.look.tick_size) + 4.0;
        let every = self.x.labelled_every(needed, frame.width);
        for (index, tick) in self.x.ticks().enumerate() {
            let x = self.across(frame, tick);
            drawing.add(line((x, bottom), (x, bottom + TICK), BLACK));
            if index % every == 0 {
                let at = (x, bottom + TICK + self.look.tick_size);
                drawing.write(Element::centred_text(at, self.look.tick_size), &self.x.label(tick));
            }
        }
        let at = (frame.left + frame.width / 2.0, bottom + self.look.label_drop());
        drawing.write(Element::centred_text(at, self.look.label_size), &self.chart.x.label);
    }

    fn label_y(&self, drawing: &mut Drawing, frame: Frame) {
        let every = self.y.labelled_every(1.2 * self.look.tick_size, frame.height);
        for (index, tick) in self.y.ticks().enumerate() {
            let y = self.down(frame, tick);
            drawing.add(line((frame.left, y), (frame.left - TICK, y), BLACK));
            if index % every == 0 {
                let at = (frame.left - TICK - 3.0, y + 0.36 * self.look.tick_size);
                let text = Element::text(at, self.look.tick_size).set("text-anchor", "end");
                drawing.write(text, &self.y.label(tick));
            }
        }
        let (x, y) = (frame.left - self.y_label_distance(), frame.top + frame.height / 2.0);
        let upwards = format!("rotate(-90,{},{})", text::decimal(x), text::decimal(y));
        let text = Element::centred_text((x, y), self.look.label_size).set("transform", &upwards);
        drawing.write(text, &self.chart.y.label);
    }

    fn at(&self, frame: Frame, x: f64, y: f64) -> Pixel {
        (self.across(frame, x), self.down(frame, y))
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

fn line(from: Pixel, to: Pixel, colour: &str) -> Element {
    Element::new("line")
        .number("x1", from.0)
        .number("y1", from.1)
        .number("x2", to.0)
        .number("y2", to.1)
        .set("stroke", colour)
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
