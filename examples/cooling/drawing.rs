//! Draws curves over two logarithmic axes as an SVG.

use std::fmt::{Error, Write};

/// How a curve is drawn, with its colour.
pub enum Look {
    /// a circle at every point
    Circles(&'static str),
    /// a line
    Line(&'static str),
    /// a broken line
    Dashes(&'static str),
}

/// Points with a name for the legend.
pub struct Curve {
    /// the name
    pub name: String,
    /// how it is drawn
    pub look: Look,
    /// x and y
    pub points: Vec<[f64; 2]>,
}

/// left, right, top and bottom of the axes on the page
const FRAME: [f64; 4] = [76.0, 700.0, 20.0, 400.0];

/// The drawing over x and y from one power of ten to another, its legend at the lower left.
pub fn svg(labels: [&str; 2], powers: [[i32; 2]; 2], curves: &[Curve]) -> Result<String, Error> {
    let [left, right, top, bottom] = FRAME;
    let place = |[low, high]: [i32; 2], power: f64| (power - f64::from(low)) / f64::from(high - low);
    let x_of = |power: f64| left + (right - left) * place(powers[0], power);
    let y_of = |power: f64| bottom + (top - bottom) * place(powers[1], power);
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 720 460\" width=\"720\" height=\"460\" font-size=\"13\" \
         font-family=\"DejaVu Sans, Arial, Helvetica, sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
    );
    for power in powers[0][0]..=powers[0][1] {
        let x = x_of(f64::from(power));
        writeln!(out, "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#e4e4e4\"/>")?;
        text(&mut out, [x, bottom + 20.0], "middle", &power_of_ten(power))?;
    }
    for power in powers[1][0]..=powers[1][1] {
        let y = y_of(f64::from(power));
        writeln!(out, "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#e4e4e4\"/>")?;
        text(&mut out, [left - 8.0, y + 4.0], "end", &power_of_ten(power))?;
    }
    writeln!(
        out,
        "<path d=\"M{left} {top}V{bottom}H{right}\" fill=\"none\" stroke=\"black\"/>"
    )?;
    text(&mut out, [(left + right) / 2.0, bottom + 46.0], "middle", labels[0])?;
    writeln!(
        out,
        "<g transform=\"translate(20 {}) rotate(-90)\">",
        (top + bottom) / 2.0
    )?;
    text(&mut out, [0.0, 0.0], "middle", labels[1])?;
    writeln!(out, "</g>")?;
    for (row, curve) in curves.iter().enumerate() {
        let y = bottom - 20.0 * (curves.len() - row) as f64;
        draw(&mut out, &curve.look, &[16.0, 30.0, 44.0].map(|x| [left + x, y]))?;
        text(&mut out, [left + 54.0, y + 4.0], "start", &curve.name)?;
        let places = curve.points.iter().map(|[x, y]| [x_of(x.log10()), y_of(y.log10())]);
        draw(&mut out, &curve.look, &places.collect::<Vec<_>>())?;
    }
    writeln!(out, "</svg>")?;
    Ok(out)
}

fn power_of_ten(power: i32) -> String {
    let sign = if power < 0 { "−" } else { "" };
    format!("10<tspan dy=\"-5\" font-size=\"9\">{sign}{}</tspan>", power.abs())
}

fn text(out: &mut String, [x, y]: [f64; 2], anchor: &str, content: &str) -> Result<(), Error> {
    writeln!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{content}</text>"
    )
}

/// A curve through places on the page.
fn draw(out: &mut String, look: &Look, places: &[[f64; 2]]) -> Result<(), Error> {
    let (colour, dashes) = match look {
        Look::Circles(colour) => {
            let mut each = places.iter();
            return each.try_for_each(|[x, y]| {
                writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>")
            });
        }
        Look::Line(colour) => (colour, "none"),
        Look::Dashes(colour) => (colour, "5 4"),
    };
    let points: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
    let way = points.join("L");
    writeln!(
        out,
        "<path d=\"M{way}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" stroke-dasharray=\"{dashes}\"/>"
    )
}
