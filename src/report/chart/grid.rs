//! Draws many small charts in rows and columns as one SVG picture.

use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::legend::Legend;
use super::scale::{drawable, Scale};
use super::{document, empty, mark, words, Chart, Layer};

const TICK_SIZE: u32 = 10;
const LABEL_SIZE: u32 = 13;
/// Ticks an axis is given, or as many more as it takes to show two.
const TICKS: [f64; 4] = [3.0, 4.0, 5.0, 8.0];
/// Between neighbours, in pixels, beside what their tick labels take.
const GAP: f64 = 12.0;
const EDGE: f64 = 16.0;

/// Draws the charts in rows, each with axes of `size` pixels (width, height), and one legend below.
///
/// An axis without a label has no ticks either: neighbours with equal limits may share theirs. Filled points are drawn as
/// dots, hollow ones as markers. What lies outside the axes is not drawn; lines and bands are cut at the upper and lower
/// limit. The same charts give the same bytes.
pub fn grid(rows: &[Vec<Option<Chart>>], size: (f64, f64)) -> String {
    let cells: Vec<Cell> = rows
        .iter()
        .enumerate()
        .flat_map(|(row, charts)| {
            let placed = charts.iter().enumerate();
            placed.filter_map(move |(column, chart)| Some(Cell::new(chart.as_ref()?, row, column)))
        })
        .collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widest = |column: usize| of(&cells, |cell| cell.column == column, Cell::left);
    // a tick label at the end of an axis stands half its width beyond
    let between = GAP + 0.5 * of(&cells, |_| true, Cell::beyond);
    let lefts = starts((0..columns).map(|column| (widest(column), size.0 + between)));
    let above = |row: usize| of(&cells, |cell| cell.row == row, Cell::top);
    let below = |row: usize| of(&cells, |cell| cell.row == row, Cell::bottom);
    let tops = starts((0..rows.len()).map(|row| (above(row), size.1 + below(row) + GAP)));

    let axes_width = lefts.last().map_or(0.0, |left| left + EDGE / 2.0);
    let axes_height = tops.last().map_or(0.0, |top| top + EDGE / 2.0);
    let charts: Vec<Chart> = cells.iter().map(|cell| cell.chart.clone()).collect();
    let legend = Legend::of(&charts);
    let legend_columns = legend.columns_within(axes_width);
    let (legend_width, legend_height) = legend.extent(legend_columns);
    let width = axes_width.max(legend_width).ceil();
    let height = (axes_height + legend_height).ceil();

    let mut scene = empty(width, height);
    for cell in &cells {
        let corner = (
            lefts[cell.column] + widest(cell.column),
            tops[cell.row] + above(cell.row),
        );
        cell.draw(&mut scene, corner, size);
    }
    let spare = ((width - legend_width) / 2.0).round();
    legend.draw(&mut scene, spare, axes_height, legend_columns);
    document(&scene, width, height)
}

/// The largest of what some cells need.
fn of<'a>(cells: &[Cell<'a>], which: impl Fn(&Cell<'a>) -> bool, need: impl Fn(&Cell<'a>) -> f64) -> f64 {
    cells.iter().filter(|cell| which(cell)).map(need).fold(0.0, f64::max)
}

/// Where each begins, and after the last one where all end.
fn starts(sizes: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    let mut at = EDGE / 2.0;
    let mut starts = vec![at];
    for (before, after) in sizes {
        at += before + after;
        starts.push(at);
    }
    starts
}

/// The scale with the fewest ticks that still has two.
fn scale(values: &[f64], range: Option<(f64, f64)>) -> Scale {
    let scales = TICKS.map(|most| Scale::with_ticks(most, values, range));
    let enough = scales.into_iter().find(|scale| scale.ticks().nth(1).is_some());
    enough.unwrap_or(scales[TICKS.len() - 1])
}

/// One chart with its place.
struct Cell<'a> {
    chart: &'a Chart,
    row: usize,
    column: usize,
    x: Scale,
    y: Scale,
}

impl<'a> Cell<'a> {
    fn new(chart: &'a Chart, row: usize, column: usize) -> Self {
        let (mut xs, mut ys) = (vec![], vec![]);
        for layer in &chart.layers {
            match layer {
                Layer::Points { points, .. } => {
                    xs.extend(points.iter().map(|p| p.x));
                    ys.extend(points.iter().map(|p| p.y));
                }
                Layer::Line { xy, .. } => {
                    xs.extend(xy.iter().map(|p| p.0));
                    ys.extend(xy.iter().map(|p| p.1));
                }
                Layer::Band { edges, .. } => {
                    xs.extend(edges.iter().map(|e| e.0));
                    ys.extend(edges.iter().flat_map(|e| [e.1, e.2]));
                }
            }
        }
        Cell {
            chart,
            row,
            column,
            x: scale(&xs, chart.x.range),
            y: scale(&ys, chart.y.range),
        }
    }

    /// Width of the tick labels below.
    fn beyond(&self) -> f64 {
        if self.chart.x.label.is_empty() {
            return 0.0;
        }
        self.x.label_width(TICK_SIZE).ceil()
    }

    fn left(&self) -> f64 {
        if self.chart.y.label.is_empty() {
            return 0.0;
        }
        (26.0 + self.y.label_width(TICK_SIZE)).ceil()
    }

    fn bottom(&self) -> f64 {
        if self.chart.x.label.is_empty() {
            0.0
        } else {
            34.0
        }
    }

    fn top(&self) -> f64 {
        if self.chart.title.is_none() {
            0.0
        } else {
            20.0
        }
    }

    fn draw(&self, scene: &mut Scene, (left, top): (f64, f64), (width, height): (f64, f64)) {
        let (x, y) = (self.x, self.y);
        let across = |value: f64| left + width * (value - x.lower) / (x.upper - x.lower);
        let up = |value: f64| top + height * (1.0 - (value - y.lower) / (y.upper - y.lower));
        let at = |a: f64, b: f64| (across(a), up(b.clamp(y.lower, y.upper)));
        let inside = |a: f64, b: f64| x.contains(a) && drawable(b);
        for layer in &self.chart.layers {
            if let Layer::Band { edges, style, .. } = layer {
                for run in edges
                    .split(|e| !(inside(e.0, e.1) && drawable(e.2)))
                    .filter(|r| r.len() > 1)
                {
                    let upper = run.iter().map(|e| at(e.0, e.2));
                    let lower = run.iter().rev().map(|e| at(e.0, e.1));
                    scene.add(mark::area(&upper.chain(lower).collect::<Vec<_>>(), *style));
                }
            }
        }
        for layer in &self.chart.layers {
            if let Layer::Line { xy, style, dash, .. } = layer {
                for run in xy.split(|p| !inside(p.0, p.1)).filter(|r| r.len() > 1) {
                    scene.add(mark::stroke(run.iter().map(|p| at(p.0, p.1)).collect(), *style, *dash));
                }
            }
        }
        for layer in &self.chart.layers {
            if let Layer::Points { points, style, .. } = layer {
                let shown = points.iter().filter(|p| x.contains(p.x) && y.contains(p.y));
                let pixels: Vec<(f64, f64)> = shown.map(|p| at(p.x, p.y)).collect();
                if style.open {
                    pixels.iter().for_each(|p| scene.add(mark::marker(p.0, p.1, *style)));
                } else if !pixels.is_empty() {
                    scene.add(mark::dots(&pixels, *style));
                }
            }
        }
        scene.add(Primitive::Rect {
            x: left,
            y: top,
            width,
            height,
            fill: Color::None,
            stroke: Some(Color::from("#000000")),
            stroke_width: Some(1.0),
            opacity: None,
        });
        self.label(scene, (left, top), (width, height), (&across, &up));
    }

    /// Writes ticks, labels and title.
    fn label(
        &self,
        scene: &mut Scene,
        (left, top): (f64, f64),
        (width, height): (f64, f64),
        (across, up): (&dyn Fn(f64) -> f64, &dyn Fn(f64) -> f64),
    ) {
        let mut write = |label: &str, x: f64, y: f64, size: u32, (to, turn): (TextAnchor, Option<f64>)| {
            let mut text = words(label, x, y, size);
            if let Primitive::Text { anchor, rotate, .. } = &mut text {
                *anchor = to;
                *rotate = turn;
            }
            scene.add(text);
        };
        let (middle, bottom) = (left + width / 2.0, top + height);
        if let Some(title) = &self.chart.title {
            write(title, middle, top - 6.0, LABEL_SIZE, (TextAnchor::Middle, None));
        }
        let mut strokes = vec![];
        if !self.chart.x.label.is_empty() {
            // crowded ticks keep every second or third label
            let room = width * self.x.step / (self.x.upper - self.x.lower);
            let every = ((self.beyond() + 4.0) / room).ceil().max(1.0) as usize;
            for (index, tick) in self.x.ticks().enumerate() {
                let x = across(tick);
                strokes.push((x, bottom, x, bottom - 4.0));
                if index % every == 0 {
                    let label = self.x.label(tick);
                    write(&label, x, bottom + 13.0, TICK_SIZE, (TextAnchor::Middle, None));
                }
            }
            write(
                &self.chart.x.label,
                middle,
                bottom + 30.0,
                LABEL_SIZE,
                (TextAnchor::Middle, None),
            );
        }
        if !self.chart.y.label.is_empty() {
            for tick in self.y.ticks() {
                let y = up(tick);
                strokes.push((left, y, left + 4.0, y));
                write(
                    &self.y.label(tick),
                    left - 5.0,
                    y + 3.5,
                    TICK_SIZE,
                    (TextAnchor::End, None),
                );
            }
            let beyond = left - 12.0 - self.y.label_width(TICK_SIZE);
            let centre = top + height / 2.0;
            write(
                &self.chart.y.label,
                beyond,
                centre,
                LABEL_SIZE,
                (TextAnchor::Middle, Some(-90.0)),
            );
        }
        for (x1, y1, x2, y2) in strokes {
            scene.add(Primitive::Line {
                x1,
                y1,
                x2,
                y2,
                stroke: Color::from("#000000"),
                stroke_width: 1.0,
                stroke_dasharray: None,
            });
        }
    }
}
