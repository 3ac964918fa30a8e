//! Writes the lines that every file begins with: where the law comes from, and how far it may be taken.
//!
//! They are plain ASCII but for the user's own names, as some codes complain of anything else.

use super::law::{Handoff, CONSTANT_WITHIN, FARTHEST};
use super::numbers::{number, restitution};
use super::template::filled;
use crate::error::plain;
use crate::physics::numbers::GRAVITY;

/// Characters of a name or title that a file repeats.
const NAME_SHOWN: usize = 200;

/// A user's text on one line, without what ends a comment, carries it on, or is looked for in one.
///
/// A backslash or `&` at the end of a line joins the next to it in LAMMPS and LIGGGHTS; `"""` opens a text of several lines
/// and `$` a variable in LAMMPS; and a spreadsheet takes a cell that begins with one of `=+-@` for a formula.
fn name(text: &str) -> String {
    let mut shown = String::new();
    let mut begins_cell = false;
    for c in plain(text, NAME_SHOWN).chars() {
        let c = match c {
            '"' | '`' => '\'',
            '\\' => '/',
            '&' => '+',
            '$' => 'S',
            c => c,
        };
        if begins_cell && matches!(c, '=' | '+' | '-' | '@') {
            shown.push('\'');
        }
        shown.push(c);
        begins_cell = matches!(c, ',' | ';') || begins_cell && c == ' ';
    }
    shown
}

/// Bars the numbers from being quoted.
const NOT_QUOTABLE: &str = "\n# NOT TO BE QUOTED: the fit failed a verdict, and what is here rests on it";
/// Warns of a reference speed or a film that no run had.
const EXTRAPOLATED: &str =
    "\n# EXTRAPOLATED: the reference speed or the film lies outside what the runs of this particle on this plate covered";

/// The lines that are the same for every code, as comments; the first stands behind the code's name.
pub(super) fn heading(handoff: &Handoff) -> String {
    let (v, at) = (handoff.reference_speed, handoff.predicted());
    let end = |speed: Option<f64>, beyond: f64| match speed {
        Some(speed) => number(speed),
        None => format!("(or beyond) {}", number(v * beyond)),
    };
    let [slowest, fastest] = handoff.constant_holds();
    let height = v * v / (2.0 * GRAVITY);
    let (stokes, two_spheres) = stokes(handoff);
    let marked = |mark: &str, holds: bool| if holds { mark.to_owned() } else { String::new() };
    let places = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("not_quotable", marked(NOT_QUOTABLE, !handoff.quotable)),
        ("extrapolated", marked(EXTRAPOLATED, at.extrapolated)),
        ("title", name(handoff.title)),
        ("source", name(handoff.source)),
        ("particle", name(handoff.particle)),
        ("density", number(handoff.density)),
        ("diameter", number(handoff.diameter)),
        ("mass", number(handoff.mass())),
        ("plate", plate(handoff)),
        ("runs", runs(handoff)),
        ("speed", number(v)),
        ("e", restitution(at.q50)),
        ("e_q05", restitution(at.q05)),
        ("e_q95", restitution(at.q95)),
        ("log_slope", format!("{:.4}", handoff.log_slope)),
        ("within", number(CONSTANT_WITHIN * 100.0)),
        ("slowest", end(slowest, 1.0 / FARTHEST)),
        ("fastest", end(fastest, FARTHEST)),
        ("height", number(height)),
        ("gravity", GRAVITY.to_string()),
        ("rise", number(height * at.q50 * at.q50)),
        ("stokes", stokes),
        ("two_spheres", two_spheres),
    ];
    filled(include_str!("templates/heading.txt").trim_end(), &places)
}

/// What wets the plate.
fn plate(handoff: &Handoff) -> String {
    let Some(wetting) = &handoff.wetting else {
        return "Dry plate".to_owned();
    };
    format!(
        "Liquid on the plate: {}, density {} kg/m3, viscosity {} Pa s, film {} m",
        name(wetting.liquid),
        number(wetting.density),
        number(wetting.viscosity),
        number(wetting.film)
    )
}

/// What the runs covered.
fn runs(handoff: &Handoff) -> String {
    let Some([slowest, fastest]) = handoff.speeds.map(|speeds| speeds.map(number)) else {
        return "No run of this particle was made on this plate; everything here is extrapolation".to_owned();
    };
    let covered = match handoff.stokes.map(|stokes| stokes.map(number)) {
        Some([lo, hi]) => {
            format!("Runs of this particle in this liquid covered {slowest} to {fastest} m/s, St {lo} to {hi}")
        }
        None => format!("Dry runs of this particle covered {slowest} to {fastest} m/s"),
    };
    format!("{covered}; outside is extrapolation")
}

/// How St is counted, for a plate and for two spheres, and which e two spheres have.
fn stokes(handoff: &Handoff) -> (String, String) {
    let Some(stokes) = handoff.stokes_at(handoff.reference_speed) else {
        let e = "Two spheres were not measured: here they have the plate's e";
        return (String::new(), e.to_owned());
    };
    let two = handoff.for_two_spheres();
    let mark = if two.extrapolated { " (extrapolated)" } else { "" };
    let spared = if two.q50 > 0.0 {
        ""
    } else {
        "; being 0, it is not used: here they have the plate's e"
    };
    let places = [("plate", number(stokes)), ("pair", number(2.0 * stokes))];
    let e = format!(
        "If St alone decides, those two spheres have its e at {} m/s, {}{mark}{spared}",
        number(2.0 * handoff.reference_speed),
        restitution(two.q50)
    );
    (filled(include_str!("templates/stokes.txt"), &places), e)
}

/// A contact beside the law over the speeds of the runs, and the largest distance, as comments.
pub(super) fn beside_the_law(handoff: &Handoff, contact: &dyn Fn(f64) -> f64) -> String {
    let ends = handoff.compared_speeds();
    let mut lines = "#   v, m/s       e of the law  e of this contact  difference\n".to_owned();
    let off = |speed: f64| contact(speed) - (handoff.law)(speed).q50;
    for speed in spaced(ends, 9) {
        let law = (handoff.law)(speed);
        let mark = if law.extrapolated { "  extrapolated" } else { "" };
        lines += &format!(
            "#   {:<12} {:<13.5} {:<18.5} {:+.5}{mark}\n",
            number(speed),
            law.q50,
            contact(speed),
            off(speed)
        );
    }
    // every eighth of these is a line above
    let largest = spaced(ends, 65).into_iter().map(|speed| off(speed).abs());
    let over = match handoff.speeds {
        Some(_) => "over the speeds of the runs",
        None => "over these speeds, there being no runs",
    };
    let largest = largest.fold(0.0, f64::max);
    lines + &format!("# Largest distance of this contact from the law {over}: {largest:.5}")
}

/// Speeds from the first to the last, both included, in equal ratios.
pub(super) fn spaced([first, last]: [f64; 2], count: u32) -> Vec<f64> {
    let ratio = (last / first).ln() / f64::from(count - 1);
    let mut speeds: Vec<f64> = (0..count).map(|i| first * (f64::from(i) * ratio).exp()).collect();
    if let Some(end) = speeds.last_mut() {
        *end = last;
    }
    speeds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_cannot_leave_its_comment() {
        assert_eq!(name("a\nvariable x \"\"\" $x \\ &"), "a/nvariable x ''' Sx / +");
        assert_eq!(name("a,=1+1; @b, -5"), "a,'=1+1; '@b, '-5");
    }
}
