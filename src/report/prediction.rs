//! Writes predictions as CSV or JSON, at full precision.

use std::fmt::Write;

use serde::Serialize;

use super::json;
use crate::error::Error;
use crate::findings::predict::Predicted;
use crate::physics::impact::Setting;

/// Columns of the CSV, in the order of [`Predicted`].
const COLUMNS: [&str; 15] = [
    "impact_speed_m_s",
    "stokes",
    "reynolds",
    "restitution",
    "restitution_q05",
    "restitution_q25",
    "restitution_q75",
    "restitution_q95",
    "run_q05",
    "run_q25",
    "run_q75",
    "run_q95",
    "stuck_probability",
    "log_slope",
    "extrapolated",
];

/// A line a speed; a slope there is none of is left empty.
pub fn csv(rows: &[Predicted]) -> String {
    let mut text = COLUMNS.join(",");
    text.push('\n');
    for row in rows {
        for number in [
            row.impact_speed_m_s,
            row.stokes,
            row.reynolds,
            row.restitution,
            row.restitution_q05,
            row.restitution_q25,
            row.restitution_q75,
            row.restitution_q95,
            row.run_q05,
            row.run_q25,
            row.run_q75,
            row.run_q95,
            row.stuck_probability,
        ] {
            // a String takes whatever is written to it
            let _ = write!(text, "{number:?},");
        }
        if let Some(slope) = row.log_slope {
            let _ = write!(text, "{slope:?}");
        }
        let _ = writeln!(text, ",{}", row.extrapolated);
    }
    text
}

/// What a prediction was made of.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Origin<'a> {
    /// title of the scene
    pub title: &'a str,
    /// name of the particle
    pub particle: &'a str,
    /// name of the liquid; `None`: one the scene has not
    pub liquid: Option<&'a str>,
    /// draws of the posterior
    pub draws: usize,
    /// whether the numbers of the fit may be quoted
    pub quotable: bool,
}

/// An object with what the prediction was made of and `predicted`, a list of rows; a slope there is none of is null with
/// a reason.
pub fn json(origin: Origin, setting: &Setting, rows: &[Predicted]) -> Result<String, Error> {
    #[derive(Serialize)]
    struct File<'a> {
        #[serde(flatten)]
        origin: Origin<'a>,
        diameter_m: f64,
        film_m: f64,
        film_ratio: f64,
        density_ratio: f64,
        predicted: Vec<Row<'a>>,
    }
    #[derive(Serialize)]
    struct Row<'a> {
        #[serde(flatten)]
        row: &'a Predicted,
        #[serde(skip_serializing_if = "Option::is_none")]
        why_none: Option<&'static str>,
    }
    json::text(&File {
        origin,
        diameter_m: setting.diameter,
        film_m: setting.film,
        film_ratio: setting.film_ratio(),
        density_ratio: setting.density_ratio(),
        predicted: rows
            .iter()
            .map(|row| Row {
                row,
                why_none: row
                    .log_slope
                    .is_none()
                    .then_some("half of the draws or more do not rebound"),
            })
            .collect(),
    })
}
