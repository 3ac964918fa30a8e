//! Writes predictions as CSV or JSON, at full precision.

use std::fmt::Write;

use serde::Serialize;

use super::json;
use crate::error::Error;
use crate::findings::predict::{Predicted, PredictedSeries};
use crate::physics::Setting;

/// A column's name with what of a row stands in it.
type NumberColumn = (&'static str, fn(&Predicted) -> f64);

/// The numbers of a row that are always there, in the order of [`Predicted`].
const NUMBERS: [NumberColumn; 13] = [
    ("impact_speed_m_s", |row| row.impact_speed_m_s),
    ("stokes", |row| row.stokes),
    ("reynolds", |row| row.reynolds),
    ("restitution", |row| row.restitution),
    ("restitution_q05", |row| row.restitution_q05),
    ("restitution_q25", |row| row.restitution_q25),
    ("restitution_q75", |row| row.restitution_q75),
    ("restitution_q95", |row| row.restitution_q95),
    ("run_q05", |row| row.run_q05),
    ("run_q25", |row| row.run_q25),
    ("run_q75", |row| row.run_q75),
    ("run_q95", |row| row.run_q95),
    ("stuck_probability", |row| row.stuck_probability),
];

/// Fails at the first number that is none, with its name: what was asked for is too far from anything that can be computed.
fn check(rows: &[Predicted]) -> Result<(), Error> {
    for row in rows {
        let odd = NUMBERS.iter().find(|(_, number)| !number(row).is_finite());
        if let Some((name, _)) = odd {
            let speed = row.impact_speed_m_s;
            return Err(Error::Usage(format!(
                "{name} at {speed} m/s comes out as no finite number: this sphere, film, liquid or speed is beyond what can be \
                 computed from the fit"
            )));
        }
    }
    Ok(())
}

/// A line a speed; a slope there is none of is left empty. Where series have offsets, the last column says of which it is.
///
/// Fails where a number is not finite.
pub fn csv(rows: &[Predicted], series: Option<PredictedSeries>) -> Result<String, Error> {
    check(rows)?;
    let mut text: String = NUMBERS.iter().map(|(name, _)| format!("{name},")).collect();
    text.push_str("log_slope,extrapolated");
    text.push_str(if series.is_some() { ",series\n" } else { "\n" });
    for row in rows {
        for (_, number) in NUMBERS {
            // a String takes whatever is written to it
            let _ = write!(text, "{:?},", number(row));
        }
        if let Some(slope) = row.log_slope {
            let _ = write!(text, "{slope:?}");
        }
        let series = series.map_or(String::new(), |series| format!(",{}", series.name()));
        let _ = writeln!(text, ",{}{series}", row.extrapolated);
    }
    Ok(text)
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
    /// of which series the curve and the runs are; `None` where series have no offsets
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<PredictedSeries>,
    /// draws of the posterior
    pub draws: usize,
    /// whether the numbers of the fit may be quoted
    pub quotable: bool,
}

/// An object with what the prediction was made of and `predicted`, a list of rows; a slope there is none of is null with
/// a reason.
///
/// Fails where a number is not finite.
pub fn json(origin: Origin, setting: &Setting, rows: &[Predicted]) -> Result<String, Error> {
    #[derive(Serialize)]
    struct PredictionFile<'a> {
        #[serde(flatten)]
        origin: Origin<'a>,
        diameter_m: f64,
        film_m: f64,
        film_ratio: f64,
        density_ratio: f64,
        predicted: Vec<PredictedRow<'a>>,
    }
    #[derive(Serialize)]
    struct PredictedRow<'a> {
        #[serde(flatten)]
        row: &'a Predicted,
        #[serde(skip_serializing_if = "Option::is_none")]
        why_none: Option<&'static str>,
    }
    check(rows)?;
    json::text(&PredictionFile {
        origin,
        diameter_m: setting.diameter,
        film_m: setting.film,
        film_ratio: setting.film_ratio(),
        density_ratio: setting.density_ratio(),
        predicted: rows
            .iter()
            .map(|row| PredictedRow {
                row,
                why_none: row
                    .log_slope
                    .is_none()
                    .then_some("half of the draws or more do not rebound"),
            })
            .collect(),
    })
}
