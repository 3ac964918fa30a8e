//! Says how far a trend moves what is quoted at the films of the runs.

use crate::inference::sampling::Sampled;
use crate::model::likelihood::trend::middle_film_ratio;
use crate::model::parameters::{physical, ParameterKind};
use crate::physics::balance::Balance;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::{Coefficient, Form, Parameters};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// A law with a trend in one parameter, at the posterior's mean, over the films of the runs.
pub(super) struct TrendOverFilms<'a> {
    scene: &'a Scene,
    runs: &'a Runs,
    form: Form,
    /// what has the trend
    of: Coefficient,
    /// mean of each parameter
    full: Vec<f64>,
    /// δ̃_m
    middle: f64,
}

impl<'a> TrendOverFilms<'a> {
    /// `None` without draws, or where what has the trend is no coefficient of the balance.
    pub(super) fn new(
        scene: &'a Scene,
        runs: &'a Runs,
        form: Form,
        of: ParameterKind,
        sampled: &Sampled,
    ) -> Option<TrendOverFilms<'a>> {
        let ParameterKind::Shared(of) = of else { return None };
        let mean = |values: &Vec<Vec<f64>>| {
            let draws: usize = values.iter().map(Vec::len).sum();
            values.iter().flatten().sum::<f64>() / draws as f64
        };
        let means: Vec<f64> = sampled.values.iter().map(mean).collect();
        means.iter().all(|mean| mean.is_finite()).then(|| TrendOverFilms {
            scene,
            runs,
            form,
            of,
            full: sampled.parameters.full(&means),
            middle: middle_film_ratio(runs),
        })
    }

    /// The largest change of an e_inf or a St_c at a film ratio of the runs, as a share of it, with the trend at either
    /// end of an interval in place of none; infinite where one of them ceases to be.
    pub(super) fn largest_change(&self, interval: [f64; 2]) -> f64 {
        let mut largest: f64 = 0.0;
        for series in &self.runs.series {
            let plain = self.quoted(series, 0.0);
            for trend in interval {
                for (moved, plain) in self.quoted(series, trend).into_iter().zip(plain) {
                    let change = (moved / plain - 1.0).abs();
                    // what is not there without the trend either cannot be moved
                    if !plain.is_nan() {
                        largest = largest.max(if change.is_nan() { f64::INFINITY } else { change });
                    }
                }
            }
        }
        largest
    }

    /// e_inf and St_c.
    fn quoted(&self, series: &Series, trend: f64) -> [f64; 2] {
        let setting = series.setting(self.scene);
        let balance = Balance::new(self.form, setting.of_film(), &self.parameters(series, trend));
        let e_inf = balance.e_inf(self.scene.model.dry_speed.reference());
        let l = balance.lost.over_stokes + self.form.fixed_over_stokes(&setting);
        let wetted = Wetted::of_balance(e_inf, l);
        [Quantity::EInf, Quantity::StC].map(|quantity| quantity.value(&Place::NONE, &wetted))
    }

    fn parameters(&self, series: &Series, trend: f64) -> Parameters {
        let plain = physical(&self.full, series.sphere);
        let (value, f) = (self.full[self.of as usize], self.ln_film(series));
        let moved = match self.of {
            Coefficient::LubricationLog => value + trend * f,
            _ => value * (trend * f).exp(),
        };
        plain.with(self.of, moved)
    }

    fn ln_film(&self, series: &Series) -> f64 {
        (series.film / series.diameter / self.middle).ln()
    }
}
