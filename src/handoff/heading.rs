//! Writes the lines that every file begins with: where the law comes from, and how far it may be taken.
//!
//! They are plain ASCII but for the user's own names, as some codes complain of anything else.

use super::law::{Code, Handoff, CONSTANT_WITHIN, FARTHEST};
use super::numbers::{number, restitution};
use crate::error::plain;

/// Characters of a name or title that a file repeats.
const NAME_SHOWN: usize = 200;

/// Acceleration of the drop that the heading tells a height of, m/s².
const GRAVITY: f64 = 9.81;

/// A user's text on one line, without what ends a comment, carries it on, or is looked for in one.
///
/// A backslash or `&` at the end of a line joins the next to it in C++, LAMMPS and LIGGGHTS; `??/` is a backslash in C++ before
/// C++17; `"""` opens a text of several lines and `$` a variable in LAMMPS; and a spreadsheet takes a cell that begins with
/// one of `=+-@` for a formula.
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
        if !(c == '?' && shown.ends_with('?')) {
            shown.push(c);
        }
        begins_cell = matches!(c, ',' | ';') || begins_cell && c == ' ';
    }
    shown
}

/// Lines as comments.
pub(super) fn commented(mark: &str, lines: &[String]) -> String {
    lines.iter().map(|line| format!("{mark} {line}\n")).collect()
}

/// The lines that are the same for every code, then those of this one.
pub(super) fn heading(code: Code, handoff: &Handoff, own: Vec<String>) -> Vec<String> {
    let mut lines = vec![format!(
        "{}: restitution of {} spheres on a plate, handed over by wetcor {}",
        code.name(),
        name(handoff.particle),
        env!("CARGO_PKG_VERSION")
    )];
    lines.extend(marks(handoff));
    lines.extend(provenance(handoff));
    lines.extend(reference(handoff));
    lines.extend(stokes(handoff));
    lines.extend(own);
    lines
}

/// What forbids to quote the numbers.
fn marks(handoff: &Handoff) -> Vec<String> {
    let mut lines = Vec::new();
    if !handoff.quotable {
        lines.push("NOT TO BE QUOTED: the fit failed a verdict, and what is here rests on it".to_owned());
    }
    if handoff.predicted().extrapolated {
        lines.push(
            "EXTRAPOLATED: the reference speed or the film lies outside what the runs of this particle on this plate covered"
                .to_owned(),
        );
    }
    lines
}

fn provenance(handoff: &Handoff) -> Vec<String> {
    let mut lines = vec![
        format!("Fit: {}", name(handoff.title)),
        format!("Law: {}", name(handoff.source)),
        format!(
            "Sphere: {}, density {} kg/m3, diameter {} m, mass {} kg",
            name(handoff.particle),
            number(handoff.density),
            number(handoff.diameter),
            number(handoff.mass())
        ),
    ];
    lines.push(match &handoff.wetting {
        Some(wetting) => format!(
            "Liquid on the plate: {}, density {} kg/m3, viscosity {} Pa s, film {} m",
            name(wetting.liquid),
            number(wetting.density),
            number(wetting.viscosity),
            number(wetting.film)
        ),
        None => "Dry plate".to_owned(),
    });
    lines.push(match (handoff.speeds.map(|speeds| speeds.map(number)), handoff.stokes) {
        (Some([slowest, fastest]), Some(stokes)) => {
            let [lo, hi] = stokes.map(number);
            format!(
                "Runs of this particle in this liquid covered {slowest} to {fastest} m/s, St {lo} to {hi}; outside is extrapolation"
            )
        }
        (Some([slowest, fastest]), None) => {
            format!("Dry runs of this particle covered {slowest} to {fastest} m/s; outside is extrapolation")
        }
        (None, _) => "No run of this particle was made on this plate; everything here is extrapolation".to_owned(),
    });
    lines
}

fn reference(handoff: &Handoff) -> Vec<String> {
    let v = handoff.reference_speed;
    let at = handoff.predicted();
    let end = |speed: Option<f64>, beyond: f64| match speed {
        Some(speed) => number(speed),
        None => format!("(or beyond) {}", number(v * beyond)),
    };
    let [slowest, fastest] = handoff.constant_holds();
    let height = v * v / (2.0 * GRAVITY);
    vec![
        format!(
            "Reference speed: {} m/s, normal to the plate, where e = {} (90 % band {} to {}) and d ln e/d ln v = {:.4}",
            number(v),
            restitution(at.q50),
            restitution(at.q05),
            restitution(at.q95),
            handoff.log_slope
        ),
        format!(
            "A constant e is within {} % of the law from {} to {} m/s",
            number(CONSTANT_WITHIN * 100.0),
            end(slowest, 1.0 / FARTHEST),
            end(fastest, FARTHEST)
        ),
        format!(
            "Check in one run: dropped from {} m (g = {GRAVITY} m/s2) it rises to e^2 times that, {} m",
            number(height),
            number(height * at.q50 * at.q50)
        ),
    ]
}

/// How St is counted, for a plate and for two spheres.
fn stokes(handoff: &Handoff) -> Vec<String> {
    let measured = "The law was measured for a sphere on a plate.";
    let Some(stokes) = handoff.stokes_at(handoff.reference_speed) else {
        return vec![format!(
            "{measured} Two spheres were not measured: here they have the plate's e"
        )];
    };
    let two = handoff.for_two_spheres();
    let mark = if two.extrapolated { " (extrapolated)" } else { "" };
    let spared = if two.q50 > 0.0 {
        ""
    } else {
        "; being 0, it is not used: here they have the plate's e"
    };
    vec![
        format!(
            "St = rho D v/(9 eta) = m_eff v/(6 pi eta R_eff^2). On a plate m_eff = m, R_eff = R: {} at the reference speed",
            number(stokes)
        ),
        format!(
            "Two equal spheres that meet at that speed have m_eff = m/2, R_eff = R/2: {}, twice the plate's",
            number(2.0 * stokes)
        ),
        format!(
            "{measured} If St alone decides, those two spheres have its e at {} m/s, {}{mark}{spared}",
            number(2.0 * handoff.reference_speed),
            restitution(two.q50)
        ),
    ]
}

/// A contact beside the law over the speeds of the runs, and the largest distance.
pub(super) fn beside_the_law(handoff: &Handoff, contact: &dyn Fn(f64) -> f64) -> Vec<String> {
    let [slowest, fastest] = handoff.compared_speeds();
    let mut lines = vec!["  v, m/s       e of the law  e of this contact  difference".to_owned()];
    let mut largest: f64 = 0.0;
    for speed in spaced([slowest, fastest], 9) {
        let (law, contact) = ((handoff.law)(speed), contact(speed));
        let mark = if law.extrapolated { "  extrapolated" } else { "" };
        largest = largest.max((contact - law.q50).abs());
        let (speed, off) = (number(speed), contact - law.q50);
        lines.push(format!(
            "  {speed:<12} {:<13.5} {contact:<18.5} {off:+.5}{mark}",
            law.q50
        ));
    }
    for speed in spaced([slowest, fastest], 65) {
        largest = largest.max((contact(speed) - (handoff.law)(speed).q50).abs());
    }
    let over = if handoff.speeds.is_some() {
        "over the speeds of the runs"
    } else {
        "over these speeds, there being no runs"
    };
    lines.push(format!(
        "Largest distance of this contact from the law {over}: {largest:.5}"
    ));
    lines
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
        assert_eq!(name("a ???/ ??\\"), "a ?/ ?/");
        assert_eq!(name("a,=1+1; @b, -5"), "a,'=1+1; '@b, '-5");
    }
}
