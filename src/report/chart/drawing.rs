//! Writes shapes and lines of text as elements of one SVG document.
//!
//! What a user wrote stands in lines of text alone, never in an attribute.

use super::text::{self, decimal};

/// The first family is the widest, so that the room left for it suffices for the others.
const FONTS: &str = "DejaVu Sans, Arial, Helvetica, sans-serif";

/// Lets a line of text stand around its place.
pub(super) const CENTRED: &str = r#" text-anchor="middle""#;

/// A place on the page in pixels: to the right and down.
pub(super) type Pixel = (f64, f64);

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// A rectangle with these attributes besides.
pub(super) fn rectangle(frame: Frame, attributes: &str) -> String {
    let [x, y, width, height] = numbers(frame);
    format!(r#"<rect x="{x}" y="{y}" width="{width}" height="{height}"{attributes}/>"#)
}

/// A straight line from one place to another.
pub(super) fn line(from: Pixel, to: Pixel, colour: &str) -> String {
    let [x1, y1, x2, y2] = [from.0, from.1, to.0, to.1].map(decimal);
    format!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke=\"{colour}\"/>\n")
}

/// A label from a place on in a font of this height, with these attributes besides.
pub(super) fn text_line((x, y): Pixel, size: f64, attributes: &str, label: &str) -> String {
    let content = text::markup(label, size);
    let [x, y, size] = [x, y, size].map(decimal);
    format!("<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{attributes}>{content}</text>\n")
}

/// Corners of a polygon, or places along a line.
pub(super) fn points(pixels: &[Pixel]) -> String {
    let each: Vec<String> = pixels
        .iter()
        .map(|(x, y)| format!("{},{}", decimal(*x), decimal(*y)))
        .collect();
    each.join(" ")
}

/// Elements of which only what lies inside a rectangle is seen.
pub(super) fn clipped(frame: Frame, inside: &str) -> String {
    // Named after its rectangle: pictures pasted into one page may then share the name without harm.
    let id = format!("axes-{}", numbers(frame).join("-"));
    let clip = format!("<clipPath id=\"{id}\">{}</clipPath>\n", rectangle(frame, ""));
    if inside.is_empty() {
        return clip;
    }
    format!("{clip}<g clip-path=\"url(#{id})\">{inside}</g>\n")
}

/// The whole document on white.
pub(super) fn document(width: f64, height: f64, elements: &str) -> String {
    let [width, height] = [width, height].map(decimal);
    // Without a viewBox a page that narrows the picture would crop it instead of scaling it;
    // without preserved space some viewers swallow the blank after a subscript.
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" xml:space=\"preserve\" \
         width=\"{width}\" height=\"{height}\" font-family=\"{FONTS}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{elements}</svg>\n"
    )
}

fn numbers(frame: Frame) -> [String; 4] {
    [frame.left, frame.top, frame.width, frame.height].map(decimal)
}
