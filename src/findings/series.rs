//! Estimates the square-root law of each series: α, β, e_inf and the speed below which nothing rebounds.

use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::Serialize;

use super::dry::{own_dry_speed, FittedDry};
use super::estimate::{Estimate, Quoting};
use super::film_groups::why_no_law_of_series;
use super::fit_verdict::{
    falls, square_root_verdict, uncertain, why_stopped, Verdict, ALPHA_NOT_POSITIVE, BETA_NOT_NEGATIVE,
};
use super::measurement_errors::{wet_columns, ErrorSummary};
use super::quantities::{variables, FittedLaw, LawLimits, LawOver};
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::law::Law;
use crate::inference::least_squares::Stop;
use crate::inference::regression::Regression;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// The square-root law e = √(α + β/v) of one series.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// α
    pub alpha: Estimate,
    /// β, m/s
    pub beta: Estimate,
    /// √α
    pub e_inf: Estimate,
    /// −β/α, m/s
    pub threshold_speed_m_s: Estimate,
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
        let numbers = [
            &mut self.alpha,
            &mut self.beta,
            &mut self.e_inf,
            &mut self.threshold_speed_m_s,
        ];
        for estimate in numbers {
            *estimate = quoting.none(why.as_str());
        }
        self.covariance = None;
        self.speed_error_of_a_tenth_se = None;
        self.is_withheld = true;
        self.verdict = Verdict::failed(why);
    }

    /// The estimates that replicates give an interval, with their quantities. The threshold speed keeps its delta interval:
    /// near β = 0 its replicates have no mean.
    pub(super) fn resampled_mut(&mut self) -> [(Quantity, &mut Estimate); 3] {
        [
            (Quantity::Alpha, &mut self.alpha),
            (Quantity::Beta, &mut self.beta),
            (Quantity::EInf, &mut self.e_inf),
        ]
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
pub fn fit_series(scene: &Scene, runs: &Runs, dry: &[FittedDry], quoting: Quoting) -> Vec<SeriesFit> {
    let of_place = |place: usize| {
        let mut fit = of_series(scene, runs, &runs.series[place], dry, quoting);
        if let Some(why) = why_no_law_of_series(runs, place) {
            fit.withhold(why, quoting);
        }
        fit
    };
    (0..runs.series.len()).into_par_iter().map(of_place).collect()
}

fn two_by_two(covariance: &DMatrix<f64>) -> [[f64; 2]; 2] {
    std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)]))
}

fn of_series(scene: &Scene, runs: &Runs, series: &Series, dry: &[FittedDry], quoting: Quoting) -> SeriesFit {
    let speeds = &runs.impact_speed[series.rebounds.clone()];
    let x = Law::SQUARE_ROOT.abscissae(speeds);
    let own = own_dry_speed(scene, dry, series.sphere);
    let offset = own.as_ref().map_or_else(Vec::new, |own| own.offsets(speeds));
    let errors = wet_columns(scene, runs, std::iter::once(series.rebounds.clone()), own.as_ref());
    let regression = Regression {
        offset: &offset,
        counts: runs.counts(series.rebounds.clone()),
        ..Regression::new(Law::SQUARE_ROOT, &x, &runs.restitution[series.rebounds.clone()])
    };
    let (fit, error_weights) = regression.fit_with_errors(errors.as_ref());
    let variance = error_weights.as_ref().map_or(&[][..], |weights| &weights.variance);
    let mut uncertain = uncertain(&fit);
    if let Some(own) = &own {
        own.widen(&mut uncertain, own.shift(&fit, &regression, speeds, variance));
    }
    let offset_slopes = own.as_ref().map_or_else(Vec::new, |own| own.all_offset_slopes(speeds));
    let speed_error = regression.speed_error_that_matters(&fit, &offset_slopes, variance);
    let verdict = square_root_verdict(&fit, &x);
    let converged = fit.stop == Stop::Converged;
    let (alpha, beta) = match fit.parameters.as_slice() {
        [alpha, beta] if converged => (*alpha, *beta),
        _ => (f64::NAN, f64::NAN),
    };
    let [alpha_jet, beta_jet] = variables([alpha, beta]);
    let fitted = (&fit, error_weights.as_ref());
    let limits = LawLimits::find(LawOver::Speed, &regression, fitted, &QUANTITIES, quoting);
    let source = FittedLaw {
        wetted: Wetted::of_speed(alpha_jet, beta_jet),
        uncertain: &uncertain,
        limits: limits.as_ref(),
        why_none: (!converged).then(|| why_stopped(&fit)),
        undefined: [ALPHA_NOT_POSITIVE, BETA_NOT_NEGATIVE],
        quoting,
    };
    let estimate = |quantity: Quantity| source.estimate(quantity, &Place::NONE);
    SeriesFit {
        particle: scene.particles[series.particle].name.clone(),
        liquid: scene.liquids[series.liquid].name.clone(),
        diameter_m: series.diameter,
        film_m: series.film,
        film_ratio: series.film_ratio,
        runs: runs.measured(series.rebounds.clone()),
        stuck: runs.measured(series.stuck.clone()),
        alpha: estimate(Quantity::Alpha),
        beta: estimate(Quantity::Beta),
        e_inf: estimate(Quantity::EInf),
        // a fall of e² that is rounding is none
        threshold_speed_m_s: if falls(&fit, &x) || !converged {
            estimate(Quantity::ThresholdSpeed)
        } else {
            quoting.none(source.undefined[usize::from(alpha > 0.0)])
        },
        residual_sd: fit.residual_sd,
        speed_error_of_a_tenth_se: speed_error.filter(|_| verdict.passed),
        measurement_errors: error_weights.as_ref().map(ErrorSummary::of),
        error_weights,
        covariance: uncertain.covariance.as_ref().ok().map(two_by_two),
        stop: fit.stop.as_str(),
        is_withheld: false,
        verdict,
    }
}
