//! Fits a law of the wet restitution to the rebounds of some series of one sphere.

use super::dry::{own_dry_speed, Dry};
use super::estimate::Quoting;
use super::fit_columns::{error_columns, FitColumns, OwnDrySpeed};
use super::fit_verdict::{uncertain, why_stopped, OwnLaw};
use super::quantities::{variables, FittedLaw, LawLimits, LawOver};
use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::{ErrorColumns, ErrorWeights};
use crate::inference::law::Law;
use crate::inference::least_squares::Fit;
use crate::inference::regression::Regression;
use crate::model::parameters::ParameterKind;
use crate::physics::quantity::Quantity;
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
        let speeds = &setup.runs.impact_speed;
        WetRuns::new(setup, series, |run| Law::SQUARE_ROOT.abscissa(speeds[run]))
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

    /// Fits a law, with the profile limits of the numbers that these quantities are functions of.
    pub fn fit(&self, over: LawOver, quantities: &[Quantity]) -> WetFit {
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
        WetFit {
            over,
            limits: LawLimits::find(over, &regression, (&fit, weights.as_ref()), quantities, self.quoting),
            uncertain,
            shift_by_dry_k,
            speed_error,
            fit,
            weights,
            quoting: self.quoting,
        }
    }
}

/// A law of the wet restitution as it was fitted.
#[derive(Debug)]
pub(super) struct WetFit {
    over: LawOver,
    quoting: Quoting,
    pub fit: Fit,
    /// weights of the runs, where they carry measurement errors
    pub weights: Option<ErrorWeights>,
    /// the parameters' covariance, with what k adds to it
    pub uncertain: Uncertain,
    /// limits of the profiles, where the law is curved
    pub limits: Option<LawLimits>,
    /// how the parameters move with k, where the run's own dry speed enters
    pub shift_by_dry_k: [f64; 2],
    /// the error of v, as a share of it, that would bias β by a tenth of its standard error (square root only)
    pub speed_error: Option<f64>,
}

impl WetFit {
    /// What estimates are taken from; `undefined` says why there is none of a quantity without e_inf, and with it.
    pub fn source(&self, undefined: [&'static str; 2]) -> FittedLaw<'_> {
        FittedLaw {
            wetted: self.over.wetted(variables(two(&self.fit))),
            uncertain: &self.uncertain,
            limits: self.limits.as_ref(),
            why_none: (!self.fit.converged()).then(|| why_stopped(&self.fit)),
            undefined,
            quoting: self.quoting,
        }
    }
}

/// Both parameters of a law; NaN unless its fit converged.
pub(super) fn two(fit: &Fit) -> [f64; 2] {
    match fit.parameters.as_slice() {
        [a, b] if fit.converged() => [*a, *b],
        _ => [f64::NAN; 2],
    }
}
