//! Draws markers, dots, lines, bands and error bars, for the axes and the legend alike.

use std::f64::consts::{FRAC_PI_2, TAU};

use kuva::render::color::Color;
use kuva::render::render::{build_path, PathData, Primitive, Scene};

use super::{Dash, Style};

/// Okabe and Ito's colours for the colour-blind (2008) without their yellow, which white
/// paper swallows; orange, sky blue and purple are darkened for the same reason.
const COLOURS: [&str; 8] = [
    "#000000", "#0072b2", "#d55e00", "#009e73", "#b5628f", "#dd9000", "#3d9fdc", "#7a7a7a",
];
const GROUPS: usize = COLOURS.len();

fn colour(style: Style) -> Color {
    Color::from(COLOURS[style.group % GROUPS])
}

/// A marker of the style.
pub(super) fn marker(x: f64, y: f64, style: Style) -> Primitive {
    let open = style.open != ((style.group / GROUPS) % 2 == 1);
    let white = Color::from("#ffffff");
    // A white rim keeps the shapes of crowded filled markers readable.
    let (radius, fill, edge, edge_width) = if open {
        (4.0, white, colour(style), 1.4)
    } else {
        (4.8, colour(style), white, 0.7)
    };
    match outline(style.group) {
        None => Primitive::Circle {
            cx: x,
            cy: y,
            r: radius,
            fill,
            fill_opacity: None,
            stroke: Some(edge),
            stroke_width: Some(edge_width),
        },
        Some(corners) => {
            let corners: Vec<(f64, f64)> = corners
                .iter()
                .map(|&(dx, dy)| (x + radius * dx, y + radius * dy))
                .collect();
            Primitive::Path(Box::new(PathData {
                d: build_path(&corners) + "Z",
                fill: Some(fill),
                stroke: edge,
                stroke_width: edge_width,
                opacity: None,
                stroke_dasharray: None,
            }))
        }
    }
}

/// Corners of a group's marker for a circle of radius 1; `None` for the circle itself.
fn outline(group: usize) -> Option<Vec<(f64, f64)>> {
    /// Corners at the given radii in turn, evenly turned, the first one at `start`.
    fn around(n: usize, start: f64, radii: [f64; 2]) -> Vec<(f64, f64)> {
        (0..n)
            .map(|i| {
                let angle = start + TAU * i as f64 / n as f64;
                let r = radii[i % 2];
                (r * angle.cos(), r * angle.sin())
            })
            .collect()
    }
    let plus = |turn: f64| -> Vec<(f64, f64)> {
        let (arm, half) = (1.3, 0.42);
        let quarter = [(half, half), (arm, half), (arm, -half)];
        (0..12)
            .map(|i| {
                let (x, y) = quarter[i % 3];
                let (sin, cos) = (turn - FRAC_PI_2 * (i / 3) as f64).sin_cos();
                (x * cos - y * sin, x * sin + y * cos)
            })
            .collect()
    };
    match group % GROUPS {
        0 => None,
        1 => Some(around(4, FRAC_PI_2 / 2.0, [1.3; 2])),
        2 => Some(around(3, -FRAC_PI_2, [1.4; 2])),
        3 => Some(around(4, 0.0, [1.4; 2])),
        4 => Some(around(3, FRAC_PI_2, [1.4; 2])),
        5 => Some(plus(FRAC_PI_2 / 2.0)),
        6 => Some(around(10, -FRAC_PI_2, [1.6, 0.68])),
        _ => Some(plus(0.0)),
    }
}

/// A line through pixels.
pub(super) fn stroke(points: Vec<(f64, f64)>, style: Style, dash: Dash) -> Primitive {
    Primitive::PolyLine {
        points,
        stroke: colour(style),
        stroke_width: 1.8,
        stroke_dasharray: match dash {
            Dash::Solid => None,
            Dash::Dashed => Some("7 4".to_string()),
            Dash::Dotted => Some("2 3".to_string()),
        },
    }
}

/// Many small squares as one path: a tenth of the bytes of as many markers.
pub(super) fn dots(points: &[(f64, f64)], style: Style) -> Primitive {
    const SIDE: f64 = 2.0;
    let mut d = String::new();
    for (x, y) in points {
        let (left, top) = (x - 0.5 * SIDE, y - 0.5 * SIDE);
        d.push_str(&format!("M{left:.1} {top:.1}h{SIDE}v{SIDE}h-{SIDE}z"));
    }
    Primitive::Path(Box::new(PathData {
        d,
        fill: Some(colour(style)),
        stroke: Color::None,
        stroke_width: 0.0,
        opacity: Some(0.6),
        stroke_dasharray: None,
    }))
}

/// A translucent area with these corners.
pub(super) fn area(corners: &[(f64, f64)], style: Style) -> Primitive {
    Primitive::Path(Box::new(PathData {
        d: build_path(corners) + "Z",
        fill: Some(colour(style)),
        stroke: Color::None,
        stroke_width: 0.0,
        opacity: Some(0.2),
        stroke_dasharray: None,
    }))
}

/// A vertical bar with caps between two pixel heights.
pub(super) fn error_bar(scene: &mut Scene, x: f64, low: f64, high: f64, style: Style) {
    let cap = 4.0;
    for (x1, y1, x2, y2) in [
        (x, low, x, high),
        (x - cap, low, x + cap, low),
        (x - cap, high, x + cap, high),
    ] {
        scene.add(Primitive::Line {
            x1,
            y1,
            x2,
            y2,
            stroke: colour(style),
            stroke_width: 1.2,
            stroke_dasharray: None,
        });
    }
}
