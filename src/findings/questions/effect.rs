//! Says how far a trend moves what is quoted at the films of the runs.

use crate::inference::sampling::Sampled;
use crate::model::likelihood::trend::middle_film_ratio;
use crate::model::parameters::{physical, ParameterKind};
use crate::physics::balance::Balance;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::{Coefficient, Form};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// The largest change of an e_inf or a St_c at a film ratio of the runs, as a share of it, with the trend at either end of an
/// interval in place of none, the parameters at their posterior means; infinite where one of them ceases to be. `None` without
/// draws, or where what has the trend is no coefficient of the balance.
pub(super) fn largest_change(
    scene: &Scene,
    runs: &Runs,
    form: Form,
    of: ParameterKind,
    sampled: &Sampled,
    interval: [f64; 2],
) -> Option<f64> {
    let ParameterKind::Shared(of) = of else { return None };
    let mean = |values: &Vec<Vec<f64>>| {
        let draws: usize = values.iter().map(Vec::len).sum();
        values.iter().flatten().sum::<f64>() / draws as f64
    };
    let means: Vec<f64> = sampled.values.iter().map(mean).collect();
    if !means.iter().all(|mean| mean.is_finite()) {
        return None;
    }
    let (full, middle) = (sampled.parameters.full(&means), middle_film_ratio(runs));
    // e_inf and St_c
    let quoted = |series: &Series, trend: f64| {
        let f = (series.film / series.diameter / middle).ln();
        let value = full[of as usize];
        let moved = match of {
            Coefficient::LubricationLog => value + trend * f,
            _ => value * (trend * f).exp(),
        };
        let setting = series.setting(scene);
        let balance = Balance::new(form, setting.of_film(), &physical(&full, series.sphere).with(of, moved));
        let e_inf = balance.e_inf(scene.model.dry_speed.reference());
        let l = balance.lost.over_stokes + form.fixed_over_stokes(&setting);
        let wetted = Wetted::of_balance(e_inf, l);
        [Quantity::EInf, Quantity::StC].map(|quantity| quantity.value(&Place::NONE, &wetted))
    };
    let mut largest: f64 = 0.0;
    for series in &runs.series {
        let plain = quoted(series, 0.0);
        for trend in interval {
            for (moved, plain) in quoted(series, trend).into_iter().zip(plain) {
                let change = (moved / plain - 1.0).abs();
                // what is not there without the trend either cannot be moved
                if !plain.is_nan() {
                    largest = largest.max(if change.is_nan() { f64::INFINITY } else { change });
                }
            }
        }
    }
    Some(largest)
}
