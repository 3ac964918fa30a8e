//! Writes predictions as CSV or JSON, at full precision.

use std::fmt::Write;

use serde::Serialize;

use super::finished::DrawnFrom;
use super::json;
use crate::error::Error;
use crate::findings::predict::{Predicted, PredictedSeries};
use crate::physics::Setting;
use crate::scene::DRY;

/// A column's name with what of a row stands in it.
type NumberColumn = (&'static str, fn(&Predicted) -> Option<f64>);

/// The numbers of a row, in the order of [`Predicted`].
const NUMBERS: [NumberColumn; 14] = [
    ("impact_speed_m_s", |row| Some(row.impact_speed_m_s)),
    ("stokes", |row| row.stokes),
    ("reynolds", |row| row.reynolds),
    ("restitution", |row| Some(row.restitution)),
    ("restitution_q05", |row| Some(row.restitution_q05)),
    ("restitution_q25", |row| Some(row.restitution_q25)),
    ("restitution_q75", |row| Some(row.restitution_q75)),
    ("restitution_q95", |row| Some(row.restitution_q95)),
    ("run_q05", |row| Some(row.run_q05)),
    ("run_q25", |row| Some(row.run_q25)),
    ("run_q75", |row| Some(row.run_q75)),
    ("run_q95", |row| Some(row.run_q95)),
    ("stuck_probability", |row| Some(row.stuck_probability)),
    ("log_slope", |row| row.log_slope),
];

/// The fit that predictions were made of.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Origin<'a> {
    /// title of the scene
    pub title: &'a str,
    /// whether the numbers of the fit may be quoted
    pub quotable: bool,
    /// what the draws were drawn from
    pub drawn_from: DrawnFrom,
    /// draws of the parameters
    pub draws: usize,
}

/// A sphere and what it falls on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<'a> {
    /// name of the particle
    pub particle: &'a str,
    /// name of the liquid, [`DRY`] with none on the plate; `None`: one the scene has not
    pub liquid: Option<&'a str>,
    /// D, m
    pub diameter: f64,
    /// the wetted plate; `None`: a dry one
    pub wet: Option<Setting>,
    /// of which series the curve and the runs are; `None` where series have no offsets
    pub series: Option<PredictedSeries>,
}

/// What is predicted of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction<'a> {
    /// the pair
    pub pair: Pair<'a>,
    /// a row a speed
    pub rows: Vec<Predicted>,
}

/// Fails at the first number that is none, with its name: what was asked for is too far from anything that can be computed.
fn check(rows: &[Predicted]) -> Result<(), Error> {
    for row in rows {
        let odd = NUMBERS
            .iter()
            .find(|(_, number)| number(row).is_some_and(|x| !x.is_finite()));
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

/// A line a speed, a number there is none of left empty; with `name_pairs` each begins with its pair. Where series have
/// offsets, the last column says of which the line is.
///
/// Fails where a number is not finite.
pub fn csv(predictions: &[Prediction], drawn_from: DrawnFrom, name_pairs: bool) -> Result<String, Error> {
    let has_series = predictions.iter().any(|prediction| prediction.pair.series.is_some());
    let mut text = String::new();
    if name_pairs {
        text.push_str("particle,liquid,diameter_m,film_m,");
    }
    text.extend(NUMBERS.iter().map(|(name, _)| format!("{name},")));
    text.push_str("extrapolated,drawn_from");
    text.push_str(if has_series { ",series\n" } else { "\n" });
    for Prediction { pair, rows } in predictions {
        check(rows)?;
        let start = if name_pairs { start(pair) } else { String::new() };
        let series = match (has_series, pair.series) {
            (false, _) => String::new(),
            (true, series) => format!(",{}", series.map_or("", PredictedSeries::name)),
        };
        for row in rows {
            text.push_str(&start);
            for (_, number) in NUMBERS {
                // a String takes whatever is written to it
                let _ = match number(row) {
                    Some(number) => write!(text, "{number:?},"),
                    None => write!(text, ","),
                };
            }
            let _ = writeln!(text, "{},{}{series}", row.extrapolated, drawn_from.name());
        }
    }
    Ok(text)
}

/// The cells of a pair; its names have no comma.
fn start(pair: &Pair) -> String {
    let film = pair.wet.map_or(String::new(), |wet| format!("{:?}", wet.film));
    let liquid = pair.liquid.unwrap_or_default();
    format!("{},{liquid},{:?},{film},", pair.particle, pair.diameter)
}

/// An object with the fit that the predictions were made of and, of one pair, that pair with `predicted`, a list of rows;
/// of several `predictions`, a list of such. A slope there is none of is null with a reason.
///
/// Fails where a number is not finite.
pub fn json(origin: Origin, predictions: &[Prediction], one: bool) -> Result<String, Error> {
    #[derive(Serialize)]
    struct One<'a> {
        #[serde(flatten)]
        origin: Origin<'a>,
        #[serde(flatten)]
        prediction: PairFile<'a>,
    }
    #[derive(Serialize)]
    struct Several<'a> {
        #[serde(flatten)]
        origin: Origin<'a>,
        predictions: Vec<PairFile<'a>>,
    }
    for prediction in predictions {
        check(&prediction.rows)?;
    }
    let mut files = predictions.iter().map(PairFile::of);
    match files.next() {
        Some(prediction) if one => json::text(&One { origin, prediction }),
        first => json::text(&Several {
            origin,
            predictions: first.into_iter().chain(files).collect(),
        }),
    }
}

#[derive(Serialize)]
struct PairFile<'a> {
    particle: &'a str,
    liquid: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    series: Option<PredictedSeries>,
    diameter_m: f64,
    film_m: Option<f64>,
    film_ratio: Option<f64>,
    density_ratio: Option<f64>,
    predicted: Vec<PredictedRow<'a>>,
}

#[derive(Serialize)]
struct PredictedRow<'a> {
    #[serde(flatten)]
    row: &'a Predicted,
    #[serde(skip_serializing_if = "Option::is_none")]
    why_none: Option<&'static str>,
}

impl<'a> PairFile<'a> {
    fn of(prediction: &'a Prediction<'a>) -> PairFile<'a> {
        let Prediction { pair, rows } = prediction;
        let predicted = rows.iter().map(|row| PredictedRow {
            row,
            why_none: match (row.log_slope, pair.liquid) {
                (None, _) => Some("half of the draws or more do not rebound"),
                (_, Some(DRY)) => Some("a dry impact has no Stokes and no Reynolds number"),
                _ => None,
            },
        });
        PairFile {
            particle: pair.particle,
            liquid: pair.liquid,
            series: pair.series,
            diameter_m: pair.diameter,
            film_m: pair.wet.map(|wet| wet.film),
            film_ratio: pair.wet.map(|wet| wet.film_ratio()),
            density_ratio: pair.wet.map(|wet| wet.density_ratio()),
            predicted: predicted.collect(),
        }
    }
}
