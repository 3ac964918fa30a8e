//! Fits a law of the wet restitution to the rebounds of some series of one sphere.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Serialize;

use super::dry::{own_dry_speed, Dry};
use super::estimate::{QuantityEstimates, Quoting};
use super::fit_columns::{error_columns, FitColumns, OwnDrySpeed};
use super::fit_verdict::{falls, linear_verdict, square_root_verdict, uncertain, why_stopped, OwnLaw, Verdict};
use super::quantities::{variables, FittedLaw, LawLimits, LawOver};
use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::{ErrorColumns, ErrorSummary, ErrorWeights};
use crate::inference::law::Law;
use crate::inference::least_squares::Fit;
use crate::inference::regression::Regression;
use crate::model::parameters::ParameterKind;
use crate::physics::quantity::{Place, Quantity};
use crate::runs::{Runs, Series};
use crate::scene::{Scene, WetLaw};

/// What laws of the wet runs are fitted to.
#[derive(Debug, Clone, Copy)]
pub struct FitSetup<'a> {
    /// what was held fixed
    pub scene: &'a Scene,
    /// what was measured
    pub runs: &'a Runs,
    /// k of each sphere by its dry runs
    pub dry: &'a [Dry],
}

/// The rebounds of some series of one sphere, pooled, in the order of the table.
pub(super) struct WetRuns {
    /// over 1/St, or 1/v
    pub columns: FitColumns,
    /// how many rebounded
    pub rebounds: usize,
    /// how many stuck
    pub stuck: usize,
    pub errors: Option<ErrorColumns>,
    own: Option<OwnDrySpeed>,
    quoting: Quoting,
}

impl WetRuns {
    /// Rebounds with their 1/St.
    pub fn over_stokes(setup: FitSetup, series: &[Series]) -> WetRuns {
        WetRuns::new(setup, series, |run| setup.runs.inverse_stokes(run))
    }

    /// Rebounds with their 1/v.
    pub fn over_speed(setup: FitSetup, series: &[Series]) -> WetRuns {
        WetRuns::new(setup, series, |run| LawOver::Speed.abscissa(setup.runs, run))
    }

    fn new(setup: FitSetup, series: &[Series], abscissa: impl Fn(usize) -> f64) -> WetRuns {
        let FitSetup { scene, runs, dry } = setup;
        let sphere = series.first().map(|one| one.sphere);
        let own = sphere.and_then(|sphere| own_dry_speed(scene, dry, sphere));
        let ranges = series.iter().map(|one| one.rebounds.clone());
        WetRuns {
            columns: FitColumns::of(runs, ranges.clone().flatten(), abscissa, own.as_ref()),
            rebounds: series.iter().map(|one| runs.measured(one.rebounds.clone())).sum(),
            stuck: series.iter().map(|one| runs.measured(one.stuck.clone())).sum(),
            errors: error_columns(scene, runs, ParameterKind::SigmaWet, ranges, own.as_ref()),
            own,
            quoting: Quoting::of(scene),
        }
    }

    /// A law of these runs.
    pub fn regression(&self, law: WetLaw) -> Regression<'_> {
        self.columns.regression(Law::Wet(law))
    }

    /// A law fitted to some of these runs, with these restitutions in place of theirs; no measurement errors weigh them.
    pub fn refitted(&self, law: WetLaw, restitution: &[f64], keeps: impl Fn(usize) -> bool) -> Fit {
        let kept: Vec<usize> = (0..self.columns.x.len()).filter(|run| keeps(*run)).collect();
        let select = |column: &[f64]| -> Vec<f64> { kept.iter().filter_map(|run| column.get(*run)).copied().collect() };
        let all = self.regression(law);
        let [x, offset, counts, restitution] = [all.x, all.offset, all.counts, restitution].map(select);
        let regression = Regression {
            offset: &offset,
            counts: &counts,
            ..Regression::new(all.law, &x, &restitution)
        };
        regression.fit()
    }

    /// A law fitted to these runs by themselves.
    pub fn own_law(&self, law: WetLaw) -> OwnLaw<'_> {
        OwnLaw::new(self.regression(law), self.errors.as_ref())
    }

    /// Fits a law to these runs, of a sphere and its series of this range.
    pub fn fit(&self, over: LawOver, sphere: usize, series: Range<usize>) -> WetFit {
        let regression = self.regression(over.law());
        let (fit, weights) = regression.fit_with_errors(self.errors.as_ref());
        let variance = weights.as_ref().map_or(&[][..], |weights| &weights.variance);
        let (mut uncertain, mut shift_by_dry_k, mut speed_error) = (uncertain(&fit), [0.0; 2], None);
        if over.law() == WetLaw::Sqrt {
            let mut offset_slopes = vec![];
            if let Some(own) = &self.own {
                let speeds = &self.columns.speeds;
                shift_by_dry_k = own.shift(&fit, &regression, speeds, variance);
                own.widen(&mut uncertain, shift_by_dry_k);
                offset_slopes = speeds.iter().map(|v| own.offset_slopes(*v)).collect();
            }
            speed_error = regression.speed_error_that_matters(&fit, &offset_slopes, variance);
        }
        let verdict = match over.law() {
            WetLaw::Sqrt => square_root_verdict(&fit, &self.columns.x),
            WetLaw::Linear => linear_verdict(&fit),
        };
        let mut found = WetFit {
            estimates: QuantityEstimates::default(),
            residual_sd: fit.residual_sd,
            speed_error_of_a_tenth_se: speed_error.filter(|_| verdict.passed),
            measurement_errors: weights.as_ref().map(|weights| weights.summary),
            stop: fit.stop.as_str(),
            is_withheld: false,
            verdict,
            sphere,
            series,
            over,
            limits: LawLimits::find(over, &regression, (&fit, weights.as_ref()), self.quoting),
            uncertain,
            shift_by_dry_k,
            fit,
            weights,
            quoting: self.quoting,
        };
        let source = found.source();
        // a fall of e² that is rounding is none
        let is_level = found.fit.converged() && !falls(&found.fit, &self.columns.x);
        let estimate = |quantity: Quantity| match quantity {
            Quantity::ThresholdSpeed if is_level => {
                let has_e_inf = two(&found.fit)[0] > 0.0;
                self.quoting.none(source.undefined[usize::from(has_e_inf)])
            }
            _ => source.estimate(quantity, &Place::NONE),
        };
        found.estimates = QuantityEstimates::of(over.estimated().iter().copied(), estimate);
        found
    }
}

/// A law of the wet restitution as it was fitted to some series, with what it estimates.
#[derive(Debug, Serialize, JsonSchema)]
pub struct WetFit {
    /// over 1/v α, β, √α and −β/α; over 1/St e_inf at the reference dry speed, St_c, of the square root the Stokes number at
    /// which it reaches zero, and, but over all film ratios, (e_dry² − e_inf²)/ρ̃, St_c e_inf² and δc
    #[serde(skip)]
    pub estimates: QuantityEstimates,
    /// spread of the restitutions about the law
    pub residual_sd: Option<f64>,
    /// the error of v, as a share of it, that would bias β by a tenth of its standard error (square root only)
    pub speed_error_of_a_tenth_se: Option<f64>,
    /// how measurement errors entered; `None` where no run carries one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<ErrorSummary>,
    /// how the fit ended
    pub stop: &'static str,
    /// whether its runs have no one film ratio, so that it has no numbers
    #[serde(skip)]
    pub is_withheld: bool,
    /// whether it may be quoted
    pub verdict: Verdict,
    /// index into [`Runs::spheres`]
    #[serde(skip)]
    pub sphere: usize,
    /// range of [`Runs::series`] it was fitted to
    #[serde(skip)]
    pub(super) series: Range<usize>,
    #[serde(skip)]
    pub(super) over: LawOver,
    #[serde(skip)]
    pub(super) fit: Fit,
    /// weights of the runs, where they carry measurement errors
    #[serde(skip)]
    pub(super) weights: Option<ErrorWeights>,
    /// the parameters' covariance, with what k adds to it
    #[serde(skip)]
    pub(super) uncertain: Uncertain,
    /// limits of the profiles, where the law is curved
    #[serde(skip)]
    limits: Option<LawLimits>,
    /// how the parameters move with k, where the run's own dry speed enters
    #[serde(skip)]
    pub(super) shift_by_dry_k: [f64; 2],
    #[serde(skip)]
    quoting: Quoting,
}

impl WetFit {
    /// What estimates are taken from.
    pub(super) fn source(&self) -> FittedLaw<'_> {
        FittedLaw {
            wetted: self.over.wetted(variables(two(&self.fit))),
            uncertain: &self.uncertain,
            limits: self.limits.as_ref(),
            why_none: match self.is_withheld {
                true => Some(self.verdict.reason.clone()),
                false => (!self.fit.converged()).then(|| why_stopped(&self.fit)),
            },
            undefined: self.over.undefined(),
            quoting: self.quoting,
        }
    }

    /// Both parameters of the law: α and its slope in 1/v or 1/St, or intercept and minus the slope of the line; `None` unless it
    /// has numbers.
    pub(super) fn parameters(&self) -> Option<[f64; 2]> {
        Some(two(&self.fit)).filter(|all| !self.is_withheld && all.iter().all(|one| one.is_finite()))
    }

    /// Their covariance; `None` where there is none.
    pub(super) fn covariance(&self) -> Option<[[f64; 2]; 2]> {
        let own = self.uncertain.covariance.as_ref().ok().filter(|_| !self.is_withheld)?;
        Some([0, 1].map(|i| [0, 1].map(|j| own[(i, j)])))
    }

    /// Takes back the numbers of a law whose runs have no one film.
    pub(super) fn withhold(&mut self, why: &str) {
        self.estimates.withhold(why, self.quoting);
        self.speed_error_of_a_tenth_se = None;
        self.is_withheld = true;
        self.verdict = Verdict::failed(why);
    }
}

/// Both parameters of a law; NaN unless its fit converged.
pub(super) fn two(fit: &Fit) -> [f64; 2] {
    match fit.parameters.as_slice() {
        [a, b] if fit.converged() => [*a, *b],
        _ => [f64::NAN; 2],
    }
}
