//! Writes predictions as CSV or JSON, at full precision.

use minijinja::context;
use serde::Serialize;

use super::finished::Finished;
use super::json;
use super::template::{self, serialized};
use crate::error::Error;
use crate::findings::predict::Predicted;
use crate::physics::Setting;

/// The numbers of a row, in the order of [`Predicted`].
const NUMBERS: [&str; 14] = [
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
];

/// What is predicted of a sphere on a plate. Field names are those of files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction<'a> {
    /// name of the particle
    pub particle: &'a str,
    /// name of the liquid, [`DRY`](crate::scene::DRY) with none on the plate; `None`: one the scene has not
    pub liquid: Option<&'a str>,
    /// `new`: of a series that was not measured; `None` where series have no offsets
    #[serde(skip_serializing_if = "Option::is_none")]
    pub series: Option<&'static str>,
    /// D
    pub diameter_m: f64,
    /// δ; `None` on the dry plate, as the ratios are
    pub film_m: Option<f64>,
    /// δ/D
    pub film_ratio: Option<f64>,
    /// ρl/ρp
    pub density_ratio: Option<f64>,
    /// a row a speed
    pub predicted: Vec<Predicted>,
}

impl<'a> Prediction<'a> {
    /// Of a particle of a diameter, m, on a wetted plate, or on the dry one, where series have no offsets.
    pub fn new(
        particle: &'a str,
        liquid: Option<&'a str>,
        diameter: f64,
        wet: Option<&Setting>,
        predicted: Vec<Predicted>,
    ) -> Prediction<'a> {
        Prediction {
            particle,
            liquid,
            series: None,
            diameter_m: diameter,
            film_m: wet.map(|wet| wet.film),
            film_ratio: wet.map(Setting::film_ratio),
            density_ratio: wet.map(Setting::density_ratio),
            predicted,
        }
    }
}

/// Fails at the first number that is none, with its name: what was asked for is too far from anything that can be computed.
fn check(rows: &[Predicted]) -> Result<(), Error> {
    for row in rows {
        let numbers = serialized(row);
        let number = |name: &str| f64::try_from(numbers.get_attr(name).ok()?).ok();
        let odd = NUMBERS.iter().find(|name| number(name).is_some_and(|x| !x.is_finite()));
        if let Some(name) = odd {
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
pub fn csv(predictions: &[Prediction], name_pairs: bool) -> Result<String, Error> {
    predictions
        .iter()
        .try_for_each(|prediction| check(&prediction.predicted))?;
    let values = context! {
        numbers => NUMBERS,
        predictions => serialized(predictions),
        name_pairs,
        has_series => predictions.iter().any(|prediction| prediction.series.is_some()),
    };
    template::plain("predicted.csv", &values)
}

/// An object with the fit that the predictions were made of and, of one pair, that pair with `predicted`, a list of rows;
/// of several `predictions`, a list of such. A slope there is none of is null with a reason.
///
/// Fails where a number is not finite.
pub fn json(of: &Finished, predictions: &[Prediction], one: bool) -> Result<String, Error> {
    #[derive(Serialize)]
    struct File<'a> {
        title: &'a str,
        quotable: bool,
        draws: usize,
        #[serde(flatten)]
        only: Option<&'a Prediction<'a>>,
        #[serde(skip_serializing_if = "Option::is_none")]
        predictions: Option<&'a [Prediction<'a>]>,
    }
    predictions
        .iter()
        .try_for_each(|prediction| check(&prediction.predicted))?;
    let only = predictions.first().filter(|_| one);
    json::text(&File {
        title: &of.title,
        quotable: of.failed.is_empty(),
        draws: of.basis().draws_kept(),
        only,
        predictions: only.is_none().then_some(predictions),
    })
}
