//! Writes the lines that every file begins with: where the law comes from, and how far it may be taken.
//!
//! They are plain ASCII but for the user's own names, as some codes complain of anything else.

use minijinja::context;

use super::law::{Handoff, CONSTANT_WITHIN, FARTHEST};
use super::numbers::number;
use super::template::filled;
use crate::error::{plain, Error};
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

/// The lines that are the same for every code, as comments; the first stands behind the code's name.
pub(super) fn heading(handoff: &Handoff) -> Result<String, Error> {
    let (v, at) = (handoff.reference_speed, handoff.predicted());
    let end = |speed: Option<f64>, beyond: f64| match speed {
        Some(speed) => number(speed),
        None => format!("(or beyond) {}", number(v * beyond)),
    };
    let [slowest, fastest] = handoff.constant_holds();
    let height = v * v / (2.0 * GRAVITY);
    let wetting = handoff.wet.map(|own| {
        let liquid = name(handoff.liquid);
        context! { liquid, density => own.liquid_density, viscosity => own.viscosity, film => own.film }
    });
    let stokes = handoff.stokes_at(v);
    let two = stokes.map(|stokes| {
        let law = handoff.for_two_spheres();
        context! {
            stokes => 2.0 * stokes,
            speed => 2.0 * v,
            e => law.q50,
            extrapolated => law.extrapolated,
            rebound => law.q50 > 0.0,
        }
    });
    let values = context! {
        version => env!("CARGO_PKG_VERSION"),
        quotable => handoff.quotable,
        extrapolated => at.extrapolated,
        title => name(handoff.title),
        source => name(handoff.source),
        particle => name(handoff.particle),
        density => handoff.density,
        diameter => handoff.diameter,
        mass => handoff.mass(),
        wetting,
        speeds => handoff.speeds,
        covered => handoff.stokes,
        speed => v,
        e => at.q50,
        e_q05 => at.q05,
        e_q95 => at.q95,
        log_slope => format!("{:.4}", handoff.log_slope),
        within => CONSTANT_WITHIN * 100.0,
        slowest => end(slowest, 1.0 / FARTHEST),
        fastest => end(fastest, FARTHEST),
        height,
        gravity => GRAVITY,
        rise => height * at.q50 * at.q50,
        stokes,
        two,
    };
    filled(include_str!("templates/heading.txt"), values)
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
