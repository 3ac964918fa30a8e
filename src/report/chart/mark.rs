//! Draws markers, dots, lines, bands and error bars, for the axes and the legend alike.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::data::{Dash, Style};
use super::drawing::{points, Pixel};
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
pub(super) fn marker((x, y): Pixel, style: Style) -> String {
    let open = style.open != ((style.group / GROUPS) % 2 == 1);
    // A white rim keeps the shapes of crowded filled markers readable; hollow ones show those behind them.
    let (radius, fill, edge, edge_width) = if open {
        (4.0, "none", colour(style), 1.4)
    } else {
        (4.8, colour(style), "#ffffff", 0.7)
    };
    let shape = match outline(style.group) {
        None => format!(r#"circle cx="{}" cy="{}" r="{radius}""#, decimal(x), decimal(y)),
        Some(corners) => {
            let corner = |(dx, dy): &Pixel| (x + radius * dx, y + radius * dy);
            let corners: Vec<Pixel> = corners.iter().map(corner).collect();
            format!(r#"polygon points="{}""#, points(&corners))
        }
    };
    format!("<{shape} fill=\"{fill}\" stroke=\"{edge}\" stroke-width=\"{edge_width}\"/>\n")
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
pub(super) fn stroke(pixels: &[Pixel], style: Style, dash: Dash) -> String {
    let dashes = match dash {
        Dash::Solid => "",
        Dash::Dashed => r#" stroke-dasharray="7 4""#,
        Dash::Dotted => r#" stroke-dasharray="2 3""#,
    };
    let (points, colour) = (points(pixels), colour(style));
    format!("<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\"{dashes}/>\n")
}

/// Many small squares as one path: a tenth of the bytes of as many markers.
pub(super) fn dots(pixels: &[Pixel], style: Style) -> String {
    const SIDE: f64 = 2.0;
    let square = |(x, y): &Pixel| {
        let (left, top) = (decimal(x - 0.5 * SIDE), decimal(y - 0.5 * SIDE));
        format!("M{left} {top}h{SIDE}v{SIDE}h-{SIDE}z")
    };
    let (squares, colour) = (pixels.iter().map(square).collect::<String>(), colour(style));
    format!("<path d=\"{squares}\" fill=\"{colour}\" fill-opacity=\"0.6\"/>\n")
}

/// A translucent area with these corners.
pub(super) fn area(corners: &[Pixel], style: Style) -> String {
    let (points, colour) = (points(corners), colour(style));
    format!("<polygon points=\"{points}\" fill=\"{colour}\" fill-opacity=\"0.2\"/>\n")
}

/// A vertical bar with caps from one pixel height to another.
pub(super) fn error_bar((x, low): Pixel, high: f64, style: Style) -> String {
    let [left, x, right, low, high] = [x - 4.0, x, x + 4.0, low, high].map(decimal);
    let colour = colour(style);
    format!(
        "<path d=\"M{left} {low}H{right}M{x} {low}V{high}M{left} {high}H{right}\" stroke=\"{colour}\" \
         stroke-width=\"1.2\"/>\n"
    )
}
