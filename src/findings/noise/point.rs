//! Finds the point about which the joint fit is looked at: where least squares ended, or would with the priors' k.

use crate::findings::balance::{blocks, known, EnergyBalance};
use crate::findings::dry::{self, FittedDry};
use crate::inference::balance::{fit_balance, Balance};
use crate::inference::least_squares::Stop;
use crate::model::parameters::{prior_of, Kind};
use crate::physics::impact::Form;
use crate::runs::Runs;
use crate::scene::Scene;

/// A point of the joint fit.
pub(super) struct Point {
    pub(super) form: Form,
    /// names of the parameters: those of the energy balance, then k of each particle
    pub(super) names: Vec<String>,
    /// their values
    pub(super) values: Vec<f64>,
    /// how many stand before the k
    pub(super) wet: usize,
    /// the particles, in the order of their k
    pub(super) particles: Vec<usize>,
    /// how many of them have wet runs that are looked at, the first ones
    pub(super) rebounding: usize,
    /// of each particle of the scene, whether its dry runs have a usable k
    pub(super) dried: Vec<bool>,
    /// of each particle of the scene, where it stands among those of the point
    places: Vec<Option<usize>>,
}

impl Point {
    /// The energy balance's own point where it holds every particle that rebounds; else that of a balance which takes
    /// unknown k from their priors. Particles with dry runs alone follow.
    pub(super) fn new(
        scene: &Scene,
        runs: &Runs,
        dry: &[FittedDry],
        balance: Option<&EnergyBalance>,
        form: Form,
    ) -> Point {
        let rebounds = |p: &usize| runs.series_of(*p).iter().any(|series| !series.rebounds.is_empty());
        let all: Vec<usize> = (0..scene.particles.len()).filter(rebounds).collect();
        let of_balance = balance.filter(|_| known(runs, dry).len() == all.len());
        let found = match of_balance {
            Some(balance) => Some((balance.held.form, balance.held.parameters.clone(), balance.stop)),
            None => with_priors(scene, runs, dry, form, &all).map(|(values, stop)| (form, values, stop)),
        };
        // a direction the runs cannot see is left out later, and makes the residuals no worse
        let ended = [Stop::Converged, Stop::Degenerate].map(Stop::as_str);
        let found = found.filter(|(_, values, stop)| ended.contains(stop) && values.iter().all(|x| x.is_finite()));
        let mut point = match found {
            Some((form, values, _)) => Point {
                form,
                names: vec![],
                wet: values.len() - all.len(),
                values,
                rebounding: all.len(),
                particles: all,
                dried: vec![false; scene.particles.len()],
                places: vec![None; scene.particles.len()],
            },
            None => Point {
                form,
                names: vec![],
                values: vec![],
                wet: 0,
                particles: vec![],
                rebounding: 0,
                dried: vec![false; scene.particles.len()],
                places: vec![None; scene.particles.len()],
            },
        };
        for (place, particle) in point.particles.iter().enumerate() {
            point.places[*particle] = Some(place);
        }
        for fitted in dry {
            let Some((k, _)) = fitted.usable else { continue };
            point.dried[fitted.particle] = true;
            if point.places[fitted.particle].is_none() {
                point.places[fitted.particle] = Some(point.particles.len());
                point.particles.push(fitted.particle);
                point.values.push(k);
            }
        }
        let balance = balance_of(point.form, &[]);
        let wet = balance.names().iter().take(point.wet).map(|name| (*name).to_owned());
        let k = |particle: &usize| format!("dry_k[{}]", scene.particles[*particle].name);
        point.names = wet.chain(point.particles.iter().map(k)).collect();
        point
    }

    /// Place of a particle's k; `None` without a usable one.
    pub(super) fn place(&self, particle: usize) -> Option<usize> {
        Some(self.wet + self.places[particle]?)
    }
}

/// Spread against which a prior's k is weighed: so small that it decides only what the runs leave open.
const OPEN: f64 = 1e-6;

/// Spread against which the k of dry runs are weighed, about that of wet restitutions: where a fit starts from.
const USUAL: f64 = 0.02;

fn balance_of(form: Form, dry_k: &[(f64, f64)]) -> Balance<'_> {
    Balance {
        blocks: &[],
        form,
        dry_k,
        spread: OPEN,
    }
}

/// Parameters and stop reason of a balance of all particles that rebound; `None` without any.
fn with_priors(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    form: Form,
    particles: &[usize],
) -> Option<(Vec<f64>, &'static str)> {
    if particles.is_empty() {
        return None;
    }
    let blocks = blocks(scene, runs, |particle| particles.binary_search(&particle).ok());
    let k = |particle: &usize| {
        let own = dry::of(dry, *particle);
        let prior = prior_of(scene, Kind::DryK(*particle), form.inertia).0;
        let sd = prior.sd().filter(|sd| *sd > 0.0).unwrap_or(0.01 * prior.median());
        let of_dry = own
            .and_then(|fitted| fitted.usable)
            .map(|(k, se)| (k, se * OPEN / USUAL));
        of_dry.unwrap_or((prior.median(), sd))
    };
    let dry_k: Vec<(f64, f64)> = particles.iter().map(k).collect();
    let fit = fit_balance(&Balance {
        blocks: &blocks,
        ..balance_of(form, &dry_k)
    });
    Some((fit.parameters, fit.stop.as_str()))
}
