//! Places one chart's axes and draws its layers on them.

use kuva::render::axis::add_axes_and_grid;
use kuva::render::layout::{AxisLabelOverlap, ComputedLayout, Layout};
use kuva::render::render::{Primitive, Scene, TextAnchor};
use kuva::render::theme::Theme;
use kuva::TickFormat;

use super::scale::{drawable, Scale};
use super::{mark, text, words, Chart, Layer, Point, Style, LABEL_SIZE};

const TICK_SIZE: u32 = 13;
const MARGIN_BOTTOM: f64 = 62.0;

/// One chart with its place worked out, in pixels from its own upper left corner.
pub(super) struct Panel<'a> {
    chart: &'a Chart,
    x: Scale,
    y: Scale,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) top: f64,
    left: f64,
    right: f64,
}

impl<'a> Panel<'a> {
    pub(super) fn new(chart: &'a Chart, lettered: bool, width: f64, height: f64) -> Self {
        let mut xs = Vec::new();
        let mut ys = Vec::new();
        for layer in &chart.layers {
            match layer {
                Layer::Points { points, .. } => {
                    for p in points.iter().filter(|p| drawable(p.x) && drawable(p.y)) {
                        let se = bar(p).unwrap_or(0.0);
                        xs.push(p.x);
                        ys.extend([p.y - se, p.y + se]);
                    }
                }
                Layer::Line { xy, .. } => {
                    for &(x, y) in xy.iter().filter(|p| drawable(p.0) && drawable(p.1)) {
                        xs.push(x);
                        ys.push(y);
                    }
                }
                Layer::Band { edges, .. } => {
                    for &(x, lo, hi) in edges.iter().filter(|e| edge_drawable(e)) {
                        xs.push(x);
                        ys.extend([lo, hi]);
                    }
                }
            }
        }
        let [x, y] = [(&chart.x, &xs), (&chart.y, &ys)].map(|(axis, values)| {
            let scale = Scale::new(values, axis.range);
            if axis.decades {
                scale.of_decades()
            } else {
                scale
            }
        });
        let top = if lettered || chart.title.is_some() { 38.0 } else { 16.0 };
        let left = (46.0 + y.label_width(TICK_SIZE)).ceil();
        // The last tick label may stand half its width beyond the axis.
        let right = (x.label_width(TICK_SIZE) / 2.0 + 8.0).max(28.0).ceil();
        let sides = left + right;
        let across = |label: &str| text::width(label, LABEL_SIZE);
        let title = chart.title.as_deref().map_or(0.0, across);
        // A label longer than its axis widens the picture instead of being cut.
        Self {
            chart,
            x,
            y,
            width: width.max(sides + across(&chart.x.label).max(title)).ceil(),
            height: height.max(top + MARGIN_BOTTOM + across(&chart.y.label)).ceil(),
            top,
            left,
            right,
        }
    }

    pub(super) fn draw(&self, scene: &mut Scene) {
        let axes = self.axes();
        let place = ComputedLayout::from_layout(&axes);
        add_axes_and_grid(scene, &place, &axes);
        let (w, h) = (place.plot_width(), place.plot_height());

        // Named after its rectangle: pictures pasted into one page may then share the name
        // without harm, and kuva's own running number would differ from call to call.
        let id = format!("plot-{}-{}-{w}-{h}", self.left, self.top);
        let clip = format!(
            r#"<clipPath id="{id}"><rect x="{}" y="{}" width="{w}" height="{h}"/></clipPath>"#,
            self.left, self.top
        );
        if !scene.defs.contains(&clip) {
            scene.defs.push(clip);
        }
        scene.add(Primitive::ClipStart {
            x: self.left,
            y: self.top,
            width: w,
            height: h,
            id,
        });
        let at = |x: f64, y: f64| (within_reach(place.map_x(x)), within_reach(place.map_y(y)));
        for layer in &self.chart.layers {
            if let Layer::Band { edges, style, .. } = layer {
                for run in edges.split(|e| !edge_drawable(e)).filter(|r| r.len() > 1) {
                    let upper = run.iter().map(|&(x, _, hi)| at(x, hi));
                    let lower = run.iter().rev().map(|&(x, lo, _)| at(x, lo));
                    scene.add(mark::area(&upper.chain(lower).collect::<Vec<_>>(), *style));
                }
            }
        }
        for layer in &self.chart.layers {
            if let Layer::Line { xy, style, dash, .. } = layer {
                let broken = |p: &(f64, f64)| !(drawable(p.0) && drawable(p.1));
                for run in xy.split(broken).filter(|r| r.len() > 1) {
                    let run = run.iter().map(|&(x, y)| at(x, y)).collect();
                    scene.add(mark::stroke(run, *style, *dash));
                }
            }
        }
        let shown: Vec<(&Point, Style)> = self.shown().collect();
        for (p, style) in &shown {
            if let Some(se) = bar(p) {
                let (x, low) = at(p.x, p.y - se);
                mark::error_bar(scene, x, low, at(p.x, p.y + se).1, *style);
            }
        }
        scene.add(Primitive::ClipEnd);
        // Outside the clip, so that a marker on the edge stays whole.
        for (p, style) in &shown {
            let (x, y) = at(p.x, p.y);
            scene.add(mark::marker(x, y, *style));
        }
        self.write_labels(scene, w, h);
    }

    /// Points within the axes, with their style.
    fn shown(&self) -> impl Iterator<Item = (&Point, Style)> + '_ {
        self.chart.layers.iter().flat_map(move |layer| {
            let (points, style) = match layer {
                Layer::Points { points, style, .. } => (points.as_slice(), *style),
                _ => (&[][..], Style::group(0)),
            };
            points
                .iter()
                .filter(|p| self.x.contains(p.x) && self.y.contains(p.y))
                .map(move |p| (p, style))
        })
    }

    fn axes(&self) -> Layout {
        let mut theme = Theme::light();
        theme.grid_color = "#e4e4e4".to_string();
        let (x, y) = (self.x, self.y);
        // kuva drops the tick at a limit that its sum of steps misses by rounding: 6 × 0.1 > 0.6.
        let slack = 1e-6;
        let mut axes = Layout::new((x.lower, x.upper), (y.lower, y.upper))
            .with_width(self.width)
            .with_height(self.height)
            .with_theme(theme)
            .with_box_axes()
            .with_tick_size(TICK_SIZE)
            .with_x_axis_min(x.lower - slack * x.step)
            .with_x_axis_max(x.upper + slack * x.step)
            .with_y_axis_min(y.lower - slack * y.step)
            .with_y_axis_max(y.upper + slack * y.step)
            .with_x_tick_step(x.step)
            .with_y_tick_step(y.step)
            .with_x_label_overlap(self.overlap())
            .with_force_margins(self.left, self.right)
            .with_force_margins_y(self.top, MARGIN_BOTTOM);
        // kuva's own formats mix "1e-1" with "0.20" on one axis.
        axes.x_tick_format = TickFormat::Custom(std::sync::Arc::new(move |v| x.label(v)));
        axes.y_tick_format = TickFormat::Custom(std::sync::Arc::new(move |v| y.label(v)));
        axes
    }

    /// Powers of ten are few, and their markup counts as longer than it is.
    fn overlap(&self) -> AxisLabelOverlap {
        if self.chart.x.decades {
            AxisLabelOverlap::Allow
        } else {
            AxisLabelOverlap::Thin
        }
    }

    /// Writes title and axis labels; kuva would place the vertical one by DejaVu's metrics
    /// and let a wider font run into the tick labels.
    fn write_labels(&self, scene: &mut Scene, w: f64, h: f64) {
        let mut centred = |label: &str, x: f64, y: f64, turn: Option<f64>| {
            let mut text = words(label, x, y, LABEL_SIZE);
            if let Primitive::Text { anchor, rotate, .. } = &mut text {
                *anchor = TextAnchor::Middle;
                *rotate = turn;
            }
            scene.add(text);
        };
        let (middle, centre) = (self.left + w / 2.0, self.top + h / 2.0);
        if let Some(title) = &self.chart.title {
            centred(title, middle, 24.0, None);
        }
        centred(&self.chart.x.label, middle, self.height - 17.0, None);
        centred(&self.chart.y.label, 24.0, centre, Some(-90.0));
    }
}

fn edge_drawable(edge: &(f64, f64, f64)) -> bool {
    drawable(edge.0) && drawable(edge.1) && drawable(edge.2)
}

/// Half the length of a point's error bar, where it has one.
fn bar(point: &Point) -> Option<f64> {
    point.y_se.filter(|se| drawable(*se) && *se > 0.0)
}

/// Keeps pixels within what viewers can hold in single precision.
fn within_reach(pixel: f64) -> f64 {
    pixel.clamp(-1e5, 1e5)
}
