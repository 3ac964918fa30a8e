//! Finds the point about which the joint fit is looked at: where least squares ended, or would with the priors' k.

use crate::findings::balance::{problem_of, rebounds, spheres_with_known_k, EnergyBalance};
use crate::findings::wet_fit::FitSetup;
use crate::inference::joint::{fit_joint, Joint, Known};
use crate::inference::least_squares::Stop;
use crate::model::parameters::{prior_of, ParameterKind};
use crate::physics::Form;

/// The joint fit, and the values of its parameters: the energy balance's own where it holds every sphere that rebounds;
/// else those of a balance which takes unknown k from their priors. Spheres with dry runs alone follow.
pub(super) fn linearisation_point<'r>(
    setup: FitSetup<'r>,
    balance: Option<&EnergyBalance>,
    form: Form,
) -> (Joint<'r>, Vec<f64>) {
    let FitSetup { scene, runs, dry } = setup;
    let all: Vec<usize> = (0..runs.spheres.len()).filter(|s| rebounds(runs, *s)).collect();
    let of_balance = balance.filter(|_| spheres_with_known_k(runs, dry).len() == all.len());
    let found = match of_balance {
        Some(balance) => Some((balance.form(), balance.fitted_point.point.clone(), balance.stop)),
        None => with_priors(setup, form, &all),
    };
    // a direction the runs cannot see is left out later, and makes the residuals no worse
    let ended = [Stop::Converged, Stop::Degenerate].map(Stop::as_str);
    let found = found.filter(|(_, values, stop)| ended.contains(stop) && values.iter().all(|x| x.is_finite()));
    let (form, mut values, wet) = match found {
        Some((form, values, _)) => (form, values, all),
        None => (form, vec![], vec![]),
    };
    let usable = || dry.iter().filter_map(|fitted| Some((fitted.sphere, fitted.usable?)));
    let dried: Vec<usize> = usable().map(|(sphere, _)| sphere).collect();
    let joint = Joint::new(scene, runs, form, &wet, &dried);
    let alone = usable().filter(|(sphere, _)| wet.binary_search(sphere).is_err());
    values.extend(alone.map(|(_, (k, _))| k));
    (joint, values)
}

/// Spread against which a prior's k is weighed: so small that it decides only what the runs leave open.
const OPEN: f64 = 1e-6;

/// Spread against which dry runs are weighed, about that of wet restitutions: where a fit starts from.
const USUAL: f64 = 0.02;

/// Form, parameters and stop reason of a balance of all spheres that rebound; `None` without any.
fn with_priors(setup: FitSetup, form: Form, spheres: &[usize]) -> Option<(Form, Vec<f64>, &'static str)> {
    let FitSetup { scene, runs, dry } = setup;
    if spheres.is_empty() {
        return None;
    }
    let with_dry = spheres_with_known_k(runs, dry);
    let joint = Joint::new(scene, runs, form, spheres, &with_dry);
    let mut problem = problem_of(joint, dry, USUAL);
    for (index, sphere) in spheres.iter().enumerate() {
        if with_dry.binary_search(sphere).is_ok() {
            continue;
        }
        let prior = prior_of(scene, runs, ParameterKind::DryK(*sphere), form).0;
        let sd = prior.sd().filter(|sd| *sd > 0.0).unwrap_or(0.01 * prior.median());
        problem.own_k[index] = prior.median();
        problem.known.push(Known {
            place: problem.joint.shared.len() + index,
            value: prior.median(),
            root: OPEN / sd,
        });
    }
    let fit = fit_joint(&problem);
    Some((form, fit.parameters, fit.stop.as_str()))
}
