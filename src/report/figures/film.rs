//! Says what the figures against the film ratio show, as the paper's figs. 4 and 5 have them.

use super::super::chart::{Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::super::quantities::in_scripts;
use super::super::ReportInput;
use super::points::{points, steps};
use crate::findings::estimate::Estimate;
use crate::findings::predict::Draw;
use crate::model::parameters::ParameterKind;
use crate::physics::balance::Balance;
use crate::physics::loss::Film;
use crate::physics::quantity::{Place, Wetted};
use crate::physics::{Inertia, Quantity};
use crate::runs::{Series, Sphere};
use crate::scene::WetLaw;

const FILM_RATIO: &str = "film ratio δ/D";

/// A layer of the points of each sphere that has any.
fn of_spheres(input: ReportInput, points_of: impl Fn(usize) -> Vec<ChartPoint>) -> Vec<Layer> {
    let spheres = input.runs.spheres.iter().enumerate();
    let layer = |(index, sphere): (usize, &Sphere)| {
        let style = Style::group(index + 1);
        points(sphere.words(input.scene), points_of(index), style)
    };
    spheres.filter_map(layer).collect()
}

fn estimate_point(film_ratio: f64, estimate: &Estimate) -> Option<ChartPoint> {
    Some(ChartPoint {
        x: film_ratio,
        y: estimate.value?,
        y_se: estimate.se,
    })
}

/// Axes of a quantity over the film ratio.
fn over_film_ratio(quantity: Quantity, layers: Vec<Layer>) -> Chart {
    let symbol = in_scripts(quantity.describe().symbol);
    Chart::new(Axis::new(FILM_RATIO), Axis::new(symbol), layers)
}

/// e_inf and St_c against the film ratio: a colour a particle or diameter with a k of its own, hollow for the linear law,
/// and the posterior's energy balance as a curve.
pub(super) fn film(input: ReportInput) -> Vec<Chart> {
    let panel = |quantity: Quantity| {
        let mut layers = vec![];
        for (index, sphere) in input.runs.spheres.iter().enumerate() {
            layers.extend(posterior_curve(input, index, quantity));
            for (law, words) in [(WetLaw::Sqrt, "square root"), (WetLaw::Linear, "linear")] {
                let rows = input.findings.scaling.iter();
                let mine = rows.filter(|r| (r.sphere, r.law) == (index, law) && r.verdict.passed);
                let all = mine.filter_map(|r| estimate_point(r.film_ratio?, &r.estimates[quantity]));
                let name = format!("{}, {words}", sphere.words(input.scene));
                let open = law == WetLaw::Linear;
                layers.extend(points(name, all.collect(), Style { group: index + 1, open }));
            }
        }
        over_film_ratio(quantity, layers)
    };
    Vec::from([Quantity::EInf, Quantity::StC].map(panel))
}

/// The posterior's mean of e_inf or St_c over the film ratios of a sphere's runs, at the mean density ratio of these; `None`
/// without a posterior, and of St_c where it depends on more than the film ratio.
fn posterior_curve(input: ReportInput, sphere: usize, quantity: Quantity) -> Option<Layer> {
    /// draws a curve is the mean of
    const DRAWS: usize = 100;
    let law = input.posterior?.law(input.scene, input.runs, sphere, DRAWS);
    if quantity == Quantity::StC && law.form.viscous.tells_diameters_apart() {
        return None;
    }
    let series = input.runs.series_of(sphere);
    let runs: usize = series.iter().map(|own| own.runs().len()).sum();
    let ratio = |own: &Series| own.runs().len() as f64 * own.density_ratio(input.scene);
    let density_ratio = series.iter().map(ratio).sum::<f64>() / runs as f64;
    let [lowest, highest] = law.particle.covered?.film_ratio;
    let reference = input.scene.model.dry_speed.reference();
    let at = |film_ratio: f64| {
        let film = Film {
            film_ratio,
            density_ratio,
        };
        let of_draw = |draw: &Draw| {
            let balance = Balance::new(law.form, film, &draw.parameters);
            let wetted = Wetted::of_balance(balance.e_inf(reference), balance.lost.over_stokes);
            quantity.value(&Place::NONE, &wetted)
        };
        law.draws.iter().map(of_draw).sum::<f64>() / law.draws.len() as f64
    };
    let points = steps(lowest, highest).map(|x| (x, at(x)));
    let points: Vec<(f64, f64)> = points.filter(|(_, y)| y.is_finite()).collect();
    let name = format!("{}, posterior", input.runs.spheres[sphere].words(input.scene));
    (lowest < highest && points.len() > 1).then(|| Layer::curve(name, points, Style::group(sphere + 1), Dash::Solid))
}

/// The inertial loss with both predictions, and St_c e_inf², against the film ratio, by the square-root law.
pub(super) fn energy(input: ReportInput) -> Vec<Chart> {
    let laws = || input.findings.scaling.iter().filter(|law| law.law == WetLaw::Sqrt);
    let of = |quantity: Quantity| {
        of_spheres(input, |sphere| {
            let mine = laws().filter(|law| law.sphere == sphere);
            mine.filter_map(|law| estimate_point(law.film_ratio?, &law.estimates[quantity]))
                .collect()
        })
    };
    let mut loss = of(Quantity::InertialLoss);
    if !loss.is_empty() {
        let ratios = laws()
            .filter(|law| law.energy.is_some())
            .filter_map(|law| law.film_ratio);
        let end = ratios.reduce(f64::max).unwrap_or(0.1) * 1.08;
        for (form, words, dash) in [
            (Inertia::Stepwise, "stepwise, eq. Eint2", Dash::Solid),
            (Inertia::Cap, "cap, eq. Eint1", Dash::Dashed),
        ] {
            let law = steps(0.0, end.min(form.valid_to())).map(|x| (x, form.shape(x, 1.0)));
            loss.push(Layer::curve(words, law.collect(), Style::group(0), dash));
        }
        loss.extend(fitted_loss(input, end));
    }
    vec![
        over_film_ratio(Quantity::InertialLoss, loss),
        over_film_ratio(Quantity::StCEInf2, of(Quantity::StCEInf2)),
    ]
}

/// Mean residual of each particle and film ratio under the scene's own model; nothing where the film was not asked about.
pub(super) fn residuals(input: ReportInput) -> Vec<Chart> {
    let Some(posterior) = input.posterior.filter(|_| input.findings.questions.is_some()) else {
        return vec![];
    };
    let groups = &posterior.findings.predictive.groups;
    let wet = groups.iter().filter_map(|group| group.film_ratio);
    let end = 1.08 * wet.reduce(f64::max).unwrap_or(0.1);
    let zero = vec![(0.0, 0.0), (end, 0.0)];
    let mut layers = vec![Layer::curve("the model", zero, Style::group(0), Dash::Dashed)];
    layers.extend(of_spheres(input, |index| {
        let sphere = input.runs.spheres[index];
        let mine = groups
            .iter()
            .filter(|group| sphere.owns(input.scene, &group.particle, group.diameter_m));
        let points = mine.filter_map(|group| {
            Some(ChartPoint {
                x: group.film_ratio?,
                y: group.mean_residual,
                y_se: group.mean_residual_se,
            })
        });
        points.collect()
    }));
    let x = Axis::new(FILM_RATIO).between(0.0, end);
    vec![Chart::new(x, Axis::new("mean residual in σ"), layers)]
}

/// The inertial loss of the energy balance with its fitted C and δ̃0, where it may be quoted.
fn fitted_loss(input: ReportInput, end: f64) -> Option<Layer> {
    let balance = input.findings.energy_balance.as_ref();
    let balance = balance.filter(|balance| balance.verdict.passed)?;
    let value = |kind: ParameterKind| balance.estimate(kind)?.value;
    let (form, scale) = (balance.form().inertia, value(ParameterKind::FILM_SCALE).unwrap_or(1.0));
    let c = value(ParameterKind::INERTIAL_PREFACTOR)?;
    let law = steps(0.0, end.min(form.valid_to())).map(|x| (x, c * form.shape(x, scale)));
    let name = format!("fitted, {}", form.name());
    Some(Layer::curve(name, law.collect(), Style::group(0), Dash::Dotted))
}
