//! Writes e at many speeds as CSV, for a code that reads a table and for the eye.

use super::heading::{heading, spaced};
use super::law::{Handoff, HandoffFile};
use super::numbers::{number, restitution};
use crate::error::Error;

/// What the columns are, and their names.
const COLUMNS: &str = "\
# Columns: v_m_s impact speed in m/s; St on the plate (empty if dry); e_q50 median of e, 0 where it does not rebound;
# e_q05, e_q95 ends of the curve's 90 % band; extrapolated 1 outside what the runs covered, else 0
# Lines that begin with # are comments: pandas.read_csv(path, comment=\"#\")
v_m_s,St,e_q50,e_q05,e_q95,extrapolated
";

/// Speeds of the table, besides the reference speed and the ends of the runs.
const ROWS: u32 = 61;

/// How far the table goes beyond the runs and the reference speed, as a factor.
const BEYOND: f64 = 2.0;

pub(super) fn file(handoff: &Handoff) -> Result<HandoffFile, Error> {
    let [slowest, fastest] = handoff.compared_speeds();
    let v = handoff.reference_speed;
    let mut speeds = spaced([slowest.min(v) / BEYOND, fastest.max(v) * BEYOND], ROWS);
    speeds.extend([v, slowest, fastest]);
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let mut text = format!("# Table: {}\n{COLUMNS}", heading(handoff)?);
    for speed in speeds {
        let at = (handoff.law)(speed);
        let stokes = handoff.stokes_at(speed).map_or(String::new(), number);
        let [q50, q05, q95] = [at.q50, at.q05, at.q95].map(restitution);
        let outside = u8::from(at.extrapolated);
        text += &format!("{},{stokes},{q50},{q05},{q95},{outside}\n", number(speed));
    }
    Ok(HandoffFile {
        name: "restitution_table.csv",
        text,
    })
}
