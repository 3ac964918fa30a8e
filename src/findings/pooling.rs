//! Measures what pooling liquids of different density ratio does to the square-root law, without any noise.

use super::dry::{own_dry_speed, FittedDry};
use super::energy::density_ratio;
use super::own_dry_speed::reference_dry_speed;
use super::scaling::{two, Bias, FittedScaling, Pool};
use crate::inference::balance::Balance;
use crate::inference::laws::fit_square_root;
use crate::physics::viscous;
use crate::runs::{Runs, Series};
use crate::scene::{Law, Scene};

/// Fits the square-root law to the noise-free balance at the runs of each film ratio.
///
/// Liquids differ in ρ̃, and so in the inertial loss that the law takes as one; what it then gets wrong is its bias.
pub(super) fn tell_bias(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    scaling: &mut [FittedScaling],
    balance: &Balance,
    parameters: &[f64],
    known: &[(usize, (f64, f64))],
) {
    let fitted = balance.fitted(parameters);
    let (l, c, scale, dry_k) = balance.unpack(parameters);
    let mut start = 0;
    for row in scaling.iter_mut() {
        let Some(film_ratio) = row.scaling.film_ratio.filter(|_| row.law == Law::Sqrt) else {
            continue;
        };
        let Ok(place) = known.binary_search_by_key(&row.particle, |(p, _)| *p) else {
            continue;
        };
        // the balance has its runs in the order of the series, as the film ratios have theirs
        let exact = &fitted[start..start + row.scaling.runs];
        start += row.scaling.runs;
        let series = &runs.series[row.series.clone()];
        let density_ratio = density_ratio(scene, row.particle, series);
        let e_dry = balance.form.dry.restitution(dry_k[place], reference_dry_speed(scene));
        let inertial = c * density_ratio * balance.form.inertia.shape(film_ratio, scale);
        let e_inf2 = e_dry * e_dry - inertial;
        if e_inf2 > 0.0 {
            let e_inf = e_inf2.sqrt();
            row.scaling.bias = root_of_exact(scene, runs, dry, row.particle, series, exact).map(|[a, b]| Bias {
                e_inf: a - e_inf,
                st_c: b - viscous::st_c(l, e_inf),
            });
        }
    }
}

/// e_inf and St_c of the square-root law fitted to noise-free restitutions at the rebounds of some series.
fn root_of_exact(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    particle: usize,
    series: &[Series],
    exact: &[f64],
) -> Option<[f64; 2]> {
    let pool = Pool::new(scene, runs, series, true);
    let own = own_dry_speed(scene, dry, particle);
    // where the balance keeps no energy, the law is not defined and no run would have rebounded
    let kept: Vec<usize> = (0..exact.len()).filter(|run| exact[*run] > 0.0).collect();
    let pick = |column: &[f64]| -> Vec<f64> { kept.iter().map(|run| column[*run]).collect() };
    let offset = own.map_or_else(Vec::new, |own| own.offsets(&pick(&pool.speeds)));
    let fit = fit_square_root(&pick(&pool.inverse_stokes), &offset, &pick(exact));
    let [alpha, beta] = two(&fit);
    (alpha > 0.0 && beta < 0.0).then(|| [alpha.sqrt(), -beta / (2.0 * alpha)])
}
