//! Writes shapes and lines of text as one SVG document.

use super::text::{self, decimal};

/// The first family is the widest, so that the room left for it suffices for the others.
const FONTS: &str = "DejaVu Sans, Arial, Helvetica, sans-serif";

/// A place on the page in pixels: to the right and down.
pub(super) type Pixel = (f64, f64);

/// One element of a document, written attribute by attribute.
pub(super) struct Element {
    name: &'static str,
    text: String,
    /// of a text, in pixels
    font_size: f64,
}

impl Element {
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            text: format!("<{name}"),
            font_size: 0.0,
        }
    }

    /// A line through pixels.
    pub(super) fn polyline(pixels: &[Pixel]) -> Self {
        Self::new("polyline").set("points", &corners(pixels))
    }

    /// An area with these corners.
    pub(super) fn polygon(pixels: &[Pixel]) -> Self {
        Self::new("polygon").set("points", &corners(pixels))
    }

    pub(super) fn rectangle(frame: Frame) -> Self {
        Self::new("rect")
            .number("x", frame.left)
            .number("y", frame.top)
            .number("width", frame.width)
            .number("height", frame.height)
    }

    /// A line of text from a place on, in a font of this height.
    pub(super) fn text(at: Pixel, size: f64) -> Self {
        let mut text = Self::new("text")
            .number("x", at.0)
            .number("y", at.1)
            .number("font-size", size);
        text.font_size = size;
        text
    }

    /// A line of text around a place.
    pub(super) fn centred_text(at: Pixel, size: f64) -> Self {
        Self::text(at, size).set("text-anchor", "middle")
    }

    pub(super) fn number(self, attribute: &str, value: f64) -> Self {
        self.set(attribute, &decimal(value))
    }

    /// Adds an attribute; what a user wrote never stands in one.
    pub(super) fn set(mut self, attribute: &str, value: &str) -> Self {
        self.text.push_str(&format!(" {attribute}=\"{value}\""));
        self
    }

    fn around(self, content: &str) -> String {
        format!("{}>{content}</{}>\n", self.text, self.name)
    }
}

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// What has been drawn so far, the latest on top.
#[derive(Default)]
pub(super) struct Drawing {
    elements: String,
}

impl Drawing {
    pub(super) fn add(&mut self, element: Element) {
        self.elements.push_str(&element.text);
        self.elements.push_str("/>\n");
    }

    /// Draws a line of text, see [`Element::text`].
    pub(super) fn write(&mut self, text: Element, label: &str) {
        let content = text::markup(label, text.font_size);
        self.elements.push_str(&text.around(&content));
    }

    /// Draws inside a rectangle only.
    pub(super) fn clipped(&mut self, frame: Frame, draw: impl FnOnce(&mut Drawing)) {
        // Named after its rectangle: pictures pasted into one page may then share the name without harm.
        let corner = [frame.left, frame.top, frame.width, frame.height].map(decimal);
        let id = format!("axes-{}", corner.join("-"));
        let clip = Element::new("clipPath").set("id", &id);
        let rectangle = Element::rectangle(frame).text + "/>";
        self.elements.push_str(&clip.around(&rectangle));
        let mut inside = Drawing::default();
        draw(&mut inside);
        if !inside.elements.is_empty() {
            let group = Element::new("g").set("clip-path", &format!("url(#{id})"));
            self.elements.push_str(&group.around(&inside.elements));
        }
    }

    /// The whole document on white.
    pub(super) fn document(self, width: f64, height: f64) -> String {
        // Without a viewBox a page that narrows the picture would crop it instead of scaling it;
        // without preserved space some viewers swallow the blank after a subscript.
        let root = Element::new("svg")
            .set("xmlns", "http://www.w3.org/2000/svg")
            .set("viewBox", &format!("0 0 {} {}", decimal(width), decimal(height)))
            .set("xml:space", "preserve")
            .number("width", width)
            .number("height", height)
            .set("font-family", FONTS);
        let paper = "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
        root.around(&format!("\n{paper}{}", self.elements))
    }
}

fn corners(pixels: &[Pixel]) -> String {
    let each: Vec<String> = pixels
        .iter()
        .map(|(x, y)| format!("{},{}", decimal(*x), decimal(*y)))
        .collect();
    each.join(" ")
}
