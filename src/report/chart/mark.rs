//! Draws markers, dots, lines, bands and error bars, for the axes and the legend alike.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::data::{Dash, Style};
use super::drawing::{Element, Pixel};
use super::text::decimal;

/// Okabe and Ito's colours for the colour-blind (2008) without their yellow, which white
/// paper swallows; orange, sky blue and purple are darkened for the same reason.
const COLOURS: [&str; 8] = [
    "#000000", "#0072b2", "#d55e00", "#009e73", "#b5628f", "#dd9000", "#3d9fdc", "#7a7a7a",
];
const GROUPS: usize = COLOURS.len();

fn colour(style: Style) -> &'static str {
    COLOURS[style.group % GROUPS]
}

/// A marker of the style.
pub(super) fn marker((x, y): Pixel, style: Style) -> Element {
    let open = style.open != ((style.group / GROUPS) % 2 == 1);
    let white = "#ffffff";
    // A white rim keeps the shapes of crowded filled markers readable; hollow ones show those behind them.
    let (radius, fill, edge, edge_width) = if open {
        (4.0, "none", colour(style), 1.4)
    } else {
        (4.8, colour(style), white, 0.7)
    };
    let shape = match outline(style.group) {
        None => Element::new("circle")
            .number("cx", x)
            .number("cy", y)
            .number("r", radius),
        Some(corners) => {
            let corners: Vec<Pixel> = corners
                .iter()
                .map(|&(dx, dy)| (x + radius * dx, y + radius * dy))
                .collect();
            Element::polygon(&corners)
        }
    };
    shape
        .set("fill", fill)
        .set("stroke", edge)
        .number("stroke-width", edge_width)
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
pub(super) fn stroke(pixels: &[Pixel], style: Style, dash: Dash) -> Element {
    let line = Element::polyline(pixels)
        .set("fill", "none")
        .set("stroke", colour(style))
        .number("stroke-width", 1.8);
    match dash {
        Dash::Solid => line,
        Dash::Dashed => line.set("stroke-dasharray", "7 4"),
        Dash::Dotted => line.set("stroke-dasharray", "2 3"),
    }
}

/// Many small squares as one path: a tenth of the bytes of as many markers.
pub(super) fn dots(pixels: &[Pixel], style: Style) -> Element {
    const SIDE: f64 = 2.0;
    let squares: Vec<String> = pixels
        .iter()
        .map(|(x, y)| {
            let (left, top) = (decimal(x - 0.5 * SIDE), decimal(y - 0.5 * SIDE));
            format!("M{left} {top}h{SIDE}v{SIDE}h-{SIDE}z")
        })
        .collect();
    Element::new("path")
        .set("d", &squares.concat())
        .set("fill", colour(style))
        .number("fill-opacity", 0.6)
}

/// A translucent area with these corners.
pub(super) fn area(corners: &[Pixel], style: Style) -> Element {
    Element::polygon(corners)
        .set("fill", colour(style))
        .number("fill-opacity", 0.2)
}

/// A vertical bar with caps from one pixel height to another.
pub(super) fn error_bar((x, low): Pixel, high: f64, style: Style) -> Element {
    let (left, right) = (decimal(x - 4.0), decimal(x + 4.0));
    let [x, low, high] = [x, low, high].map(decimal);
    Element::new("path")
        .set(
            "d",
            &format!("M{left} {low}H{right}M{x} {low}V{high}M{left} {high}H{right}"),
        )
        .set("stroke", colour(style))
        .number("stroke-width", 1.2)
}
