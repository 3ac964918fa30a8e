//! Measures every formula, its slopes and the fits of the laws against the 50-digit answers of `tests/data/stability`.

use std::collections::BTreeMap;

use wetcor::inference::law::Law;
use wetcor::inference::least_squares::{Fit, Stop};
use wetcor::inference::regression::Regression;
use wetcor::model::likelihood::normal::ln_normal_cdf;
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::{ParameterKind, COMMON_SLOTS};
use wetcor::physics::balance::kept_energy_slopes;
use wetcor::physics::inertia::Inertia;
use wetcor::physics::{bridge, numbers, rebound, viscous};
use wetcor::physics::{kept_energy, Coefficient, DrySpeed, Form, Order};
use wetcor::runs::{self, NewRun};
use wetcor::scene::Scene;

use crate::common::scenes::scene_of;
use crate::common::{parameters_of, read_in_project, setting, Place};

/// Roundings a formula may make for each one that its condition number excuses.
pub const ROUNDINGS: f64 = 4.0;

/// Distance from the exact fit that is nothing, in standard errors.
pub const NOTHING: f64 = 1e-5;

/// What the lines of one formula came to.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    pub answers: usize,
    /// largest error where the condition number is 10 or less, ulp
    pub worst_of_tame: f64,
    pub largest_condition: f64,
    /// largest error over 1 + condition number, and where
    pub worst_share: f64,
    pub place: String,
}

/// What the fits of one law came to.
#[derive(Debug, Clone, Default)]
pub struct Fitted {
    pub fits: usize,
    /// largest distance from the exact parameters, standard errors
    pub distance: f64,
    /// largest relative error of a standard error
    pub of_se: f64,
}

/// A scene with one sphere and one liquid whose constants can be set.
fn scene_text() -> String {
    scene_of(
        "one run",
        &[
            "[particles.P]\nroughness_um = 5\ndensity_kg_m3 = 1000\n",
            "[liquids.W]\ndensity_kg_m3 = 1000\nviscosity_mPa_s = 1\n",
        ],
    )
}

fn form(name: &str) -> Inertia {
    *Inertia::ALL.iter().find(|form| form.name() == name).expect("a form")
}

/// Log density of a run alone with its slopes in these parameters, as the likelihood of all runs computes it.
fn alone(scene: &Scene, run: NewRun, inertia: Inertia, parameters: &[(ParameterKind, f64)]) -> Vec<f64> {
    let runs = runs::arrange(scene, &[run]);
    let likelihood = Likelihood::new(scene, &runs, Form::new(inertia, DrySpeed::Impact));
    let mut full = vec![0.0; COMMON_SLOTS + 1];
    for (kind, value) in parameters {
        full[kind.slot()] = *value;
    }
    let mut slopes = full.clone();
    let value = likelihood.ln_density(&full, &mut slopes).expect("finite");
    let of_kinds = parameters.iter().map(|(kind, _)| slopes[kind.slot()]);
    std::iter::once(value).chain(of_kinds).collect()
}

/// That of a wet run, in k, L, C, δ̃0 where the form has one, and σ.
fn run_alone(scene: &mut Scene, form: Inertia, x: &[f64]) -> Vec<f64> {
    let [rp, d, rl, eta, film, v, e, k, l, c, scale, sigma] = x.try_into().expect("twelve arguments");
    scene.particles[0].density = rp;
    scene.liquids[0].density = rl;
    scene.liquids[0].viscosity = eta;
    let run = NewRun {
        particle: "P",
        liquid: Some("W"),
        diameter: d,
        film: Some((film, film / d)),
        impact_speed: v,
        restitution: e,
    };
    let mut parameters = vec![
        (ParameterKind::DryK(0), k),
        (ParameterKind::LUBRICATION_LOG, l),
        (ParameterKind::INERTIAL_PREFACTOR, c),
    ];
    let of_form = form.has_film_scale().then_some((ParameterKind::FILM_SCALE, scale));
    parameters.extend(of_form);
    parameters.push((ParameterKind::SigmaWet, sigma));
    alone(scene, run, form, &parameters)
}

/// That of a dry run, in k and σ.
fn dry_run_alone(scene: &Scene, x: &[f64]) -> Vec<f64> {
    let [v, e, k, sigma] = x.try_into().expect("four arguments");
    let run = NewRun {
        particle: "P",
        liquid: None,
        diameter: 1e-3,
        film: None,
        impact_speed: v,
        restitution: e,
    };
    let parameters = [(ParameterKind::DryK(0), k), (ParameterKind::SigmaDry, sigma)];
    alone(scene, run, Inertia::None, &parameters)
}

fn kept(form: Inertia, x: &[f64]) -> Vec<f64> {
    let [density, diameter, liquid_density, viscosity, film, v, k, l, c, scale] = x.try_into().expect("ten arguments");
    let setting = setting([density, diameter], [liquid_density, viscosity], film);
    let parameters = parameters_of([k, l, c, scale]);
    let form = Form::new(form, DrySpeed::Impact);
    let slopes = kept_energy_slopes(&setting, form, &parameters, v);
    vec![
        kept_energy(&setting, form, &parameters, v),
        slopes.dry_k,
        slopes.shared[Coefficient::LubricationLog as usize],
        slopes.shared[Coefficient::InertialPrefactor as usize],
        slopes.shared[Coefficient::FilmScale as usize],
    ]
}

/// The program's own answers.
pub fn ours(scene: &mut Scene, name: &str, x: &[f64]) -> Vec<f64> {
    let shape = |form: Inertia, scale: f64| vec![form.shape(x[0], scale), form.slope_film_ratio(x[0], scale)];
    match name {
        "numbers::stokes" => vec![numbers::stokes(x[0], x[1], x[2], x[3])],
        "numbers::reynolds" => vec![numbers::reynolds(x[0], x[1], x[2], x[3])],
        "numbers::free_fall_speed" => vec![numbers::free_fall_speed(x[0])],
        "dry::restitution" => vec![
            Order::First.restitution(x[0], x[1]),
            Order::First.slope_dry_k(x[0], x[1]),
            Order::First.slope_impact_speed(x[0], x[1]),
        ],
        "dry::restitution_second_order" => vec![
            Order::Second.restitution(x[0], x[1]),
            Order::Second.slope_dry_k(x[0], x[1]),
        ],
        "dry::speed_limit" => vec![Order::First.speed_limit(x[0])],
        "inertia::stepwise" => shape(Inertia::Stepwise, 1.0),
        "inertia::cap" => shape(Inertia::Cap, 1.0),
        "inertia::saturating" => {
            let form = Inertia::Saturating;
            let mut answers = shape(form, x[1]);
            answers.push(form.slope_film_scale(x[0], x[1]));
            let (together, slope) = form.shape_and_slope_film_scale(x[0], x[1]);
            // one formula in two places: the worse of the two is measured
            assert_eq!(together, answers[0]);
            answers.push(slope);
            answers
        }
        "viscous::loss" => vec![viscous::loss(x[0], x[1]), viscous::slope_lubrication_log(x[1])],
        "viscous::beta" => vec![viscous::beta(x[0], x[1], x[2], x[3])],
        "viscous::st_c" => vec![viscous::st_c(x[0], x[1]), viscous::st_no_rebound(x[0], x[1])],
        "viscous::lubrication_log" => vec![viscous::lubrication_log(x[0], x[1])],
        "viscous::critical_separation" => vec![viscous::critical_separation(x[0], x[1])],
        "bridge::volume" => vec![bridge::volume(x[0], x[1])],
        "bridge::kappa" => vec![bridge::kappa(x[0], x[1], x[2], x[3])],
        "bridge::loss" => vec![bridge::loss(x[0], x[1]), bridge::slope_impact_speed(x[0], x[1])],
        "rebound::mean_restitution" => vec![rebound::mean_restitution(x[0]), rebound::slope_mean_restitution(x[0])],
        "rebound::kept_of_mean_restitution" => vec![rebound::kept_of_mean_restitution(x[0])],
        "rebound::square_root_law" => vec![rebound::square_root_law(x[0], x[1], x[2]).unwrap_or(f64::NAN)],
        "rebound::threshold_speed" => vec![rebound::threshold_speed(x[0], x[1])],
        "rebound::linear_law" => vec![rebound::linear_law(x[0], x[1], x[2])],
        "rebound::square_root_expansion" => rebound::square_root_expansion(x[0], x[1]).to_vec(),
        "normal::ln_normal_cdf" => {
            let (value, slope) = ln_normal_cdf(x[0]);
            vec![value, slope]
        }
        _ => match name.split('/').collect::<Vec<_>>()[..] {
            ["impact::kept_energy", inertia] => kept(form(inertia), x),
            ["likelihood", "dry", _] => dry_run_alone(scene, x),
            ["likelihood", inertia, _] => run_alone(scene, form(inertia), x),
            _ => panic!("{name} is no formula of ours"),
        },
    }
}

fn numbers_of(list: &str, separator: char) -> Vec<f64> {
    list.split(separator).map(|x| x.parse().expect("a number")).collect()
}

fn ulp(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}

fn law(name: &str, arguments: &[f64]) -> Fit {
    let x: Vec<f64> = arguments.iter().step_by(2).copied().collect();
    let e: Vec<f64> = arguments.iter().skip(1).step_by(2).copied().collect();
    match name {
        "fit_dry" => {
            let law = Law::Dry(Order::First);
            Regression::new(law, &law.abscissae(&x), &e).fit()
        }
        "fit_linear" => Regression::new(Law::LINEAR, &x, &e).fit(),
        "fit_square_root" => Regression::new(Law::SQUARE_ROOT, &x, &e).fit(),
        _ => panic!("{name} is no law of ours"),
    }
}

/// Every line of the kept answers against those of a function of the formula's name and arguments.
pub fn measure(
    mut answers_of: impl FnMut(&mut Scene, &str, &[f64]) -> Vec<f64>,
) -> (BTreeMap<String, Measured>, BTreeMap<String, Fitted>) {
    let text = read_in_project("tests/data/stability/formulas.csv");
    let mut scene = Place::new(&scene_text()).scene;
    let (mut formulas, mut laws) = (BTreeMap::new(), BTreeMap::new());
    for line in text.lines() {
        let [name, arguments, answers] = line.split(';').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let x = numbers_of(arguments, ' ');
        if name.starts_with("fit") {
            compare_fit(laws.entry(name.to_owned()).or_default(), &law(name, &x), answers);
            continue;
        }
        let found = answers_of(&mut scene, name, &x);
        let measured: &mut Measured = formulas.entry(name.to_owned()).or_default();
        let mut expected: Vec<&str> = answers.split(' ').collect();
        if name == "inertia::saturating" {
            expected.push(expected[2]);
        }
        assert_eq!(found.len(), expected.len(), "{line}");
        for (j, (found, expected)) in found.iter().zip(expected).enumerate() {
            let [nearest, rest, condition] = numbers_of(expected, ':')[..] else {
                panic!("{line}");
            };
            measured.answers += 1;
            // a NaN is as wrong as can be, and so is anything for nothing
            let error = ((found - nearest) / ulp(nearest) - rest).abs();
            let error = match nearest == 0.0 {
                true if *found == 0.0 => 0.0,
                false if !error.is_nan() => error,
                _ => f64::INFINITY,
            };
            let share = error / (1.0 + condition);
            measured.largest_condition = measured.largest_condition.max(condition);
            if condition <= 10.0 {
                measured.worst_of_tame = measured.worst_of_tame.max(error);
            }
            if share > measured.worst_share {
                measured.worst_share = share;
                measured.place = format!("answer {j} at {arguments}: {found:e} for {nearest:e}");
            }
        }
    }
    (formulas, laws)
}

fn compare_fit(fitted: &mut Fitted, fit: &Fit, answers: &str) {
    fitted.fits += 1;
    assert_eq!(fit.stop, Stop::Converged, "{fit:?}");
    assert!(fit.parameters.iter().all(|b| b.is_finite()), "{fit:?}");
    for (j, pair) in answers.split(' ').enumerate() {
        let [value, se] = numbers_of(pair, ':')[..] else {
            panic!("{pair}");
        };
        let ours = fit.se(j).expect("a standard error");
        fitted.distance = fitted.distance.max((fit.parameters[j] - value).abs() / se);
        fitted.of_se = fitted.of_se.max((ours / se - 1.0).abs());
    }
}
