//! Estimates the square-root law of each series: α, β, e_inf and the speed below which nothing rebounds.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::estimate::{QuantityEstimates, Quoting};
use super::film_groups::why_no_laws;
use super::fit_verdict::{falls, square_root_verdict, Verdict, ALPHA_NOT_POSITIVE, BETA_NOT_NEGATIVE};
use super::quantities::LawOver;
use super::wet_fit::{two, FitSetup, WetRuns};
use crate::inference::effective_variance::{ErrorSummary, ErrorWeights};
use crate::physics::quantity::{Place, Quantity};
use crate::runs::Series;

/// The square-root law e = √(α + β/v) of one series.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SeriesFit {
    /// name of the particle
    pub particle: String,
    /// name of the liquid
    pub liquid: String,
    /// mean D, m
    pub diameter_m: f64,
    /// mean δ, m
    pub film_m: f64,
    /// film ratio of the group it belongs to
    pub film_ratio: f64,
    /// rebounds used
    pub runs: usize,
    /// runs that stuck, left out
    pub stuck: usize,
    /// α, β, √α and −β/α
    #[serde(skip)]
    pub estimates: QuantityEstimates,
    /// spread of the restitutions about the law
    pub residual_sd: Option<f64>,
    /// the error of v, as a share of it, that would bias β by a tenth of its standard error
    pub speed_error_of_a_tenth_se: Option<f64>,
    /// how measurement errors entered; `None` where no run carries one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<ErrorSummary>,
    /// the same for every run, for replicates
    #[serde(skip)]
    pub error_weights: Option<ErrorWeights>,
    /// covariance of α and β; `None` where there is none
    #[serde(skip)]
    pub covariance: Option<[[f64; 2]; 2]>,
    /// how the fit ended
    pub stop: &'static str,
    /// whether its runs have no one film ratio, so that it has no numbers
    #[serde(skip)]
    pub is_withheld: bool,
    /// whether it may be quoted
    pub verdict: Verdict,
}

impl SeriesFit {
    /// Takes back the numbers of a law whose runs have no one film.
    fn withhold(&mut self, why: String, quoting: Quoting) {
        self.estimates.withhold(&why, quoting);
        self.covariance = None;
        self.speed_error_of_a_tenth_se = None;
        self.is_withheld = true;
        self.verdict = Verdict::failed(why);
    }

    /// The series in words, as tables and notices name it.
    pub fn label(&self) -> String {
        let diameter = crate::units::millimetres(self.diameter_m);
        let film = crate::units::micrometres(self.film_m);
        format!(
            "{}, {}, D = {diameter:.3} mm, δ = {film:.0} µm",
            self.particle, self.liquid
        )
    }
}

/// What is estimated of a series.
const QUANTITIES: [Quantity; 4] = [
    Quantity::Alpha,
    Quantity::Beta,
    Quantity::EInf,
    Quantity::ThresholdSpeed,
];

/// The fit of every series, in the order of the runs.
pub fn fit_series(setup: FitSetup) -> Vec<SeriesFit> {
    let runs = setup.runs;
    let of_place = |place: usize| {
        let mut fit = of_series(setup, &runs.series[place]);
        if let Some(why) = runs.film_group_of(place).and_then(why_no_laws) {
            fit.withhold(why, Quoting::of(setup.scene));
        }
        fit
    };
    (0..runs.series.len()).into_par_iter().map(of_place).collect()
}

fn of_series(setup: FitSetup, series: &Series) -> SeriesFit {
    let scene = setup.scene;
    let rebounds = WetRuns::over_speed(setup, std::slice::from_ref(series));
    let law = rebounds.fit(LawOver::Speed, &QUANTITIES);
    let (fit, x) = (&law.fit, &rebounds.columns.x);
    let verdict = square_root_verdict(fit, x);
    let source = law.source([ALPHA_NOT_POSITIVE, BETA_NOT_NEGATIVE]);
    let [alpha, _] = two(fit);
    let covariance = law.uncertain.covariance.as_ref().ok();
    let estimate = |quantity: Quantity| match quantity {
        // a fall of e² that is rounding is none
        Quantity::ThresholdSpeed if fit.converged() && !falls(fit, x) => {
            source.quoting.none(source.undefined[usize::from(alpha > 0.0)])
        }
        _ => source.estimate(quantity, &Place::NONE),
    };
    SeriesFit {
        particle: scene.particles[series.particle].name.clone(),
        liquid: scene.liquids[series.liquid].name.clone(),
        diameter_m: series.diameter,
        film_m: series.film,
        film_ratio: series.film_ratio,
        runs: rebounds.rebounds,
        stuck: rebounds.stuck,
        estimates: QuantityEstimates::of(QUANTITIES, estimate),
        residual_sd: fit.residual_sd,
        speed_error_of_a_tenth_se: law.speed_error.filter(|_| verdict.passed),
        measurement_errors: law.weights.as_ref().map(|weights| weights.summary),
        covariance: covariance.map(|of| [0, 1].map(|i| [0, 1].map(|j| of[(i, j)]))),
        stop: fit.stop.as_str(),
        error_weights: law.weights,
        is_withheld: false,
        verdict,
    }
}
