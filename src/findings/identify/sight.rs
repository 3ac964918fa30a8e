//! Sums what the runs say about the fit, and sets it beside the priors.

use std::collections::{HashMap, HashSet};

use nalgebra::DMatrix;

use crate::findings::balance::{block, blocks};
use crate::findings::dry::Dry;
use crate::findings::estimate::Estimate;
use crate::findings::least_squares::LeastSquares;
use crate::inference::balance::{Balance, Block};
use crate::inference::information::{Belief, Kinds, Known, Sums};
use crate::inference::least_squares::ResidualProblem;
use crate::model::parameters::{prior_of, Kind};
use crate::physics::dry::Order;
use crate::physics::impact::Form;
use crate::physics::inertia::Inertia;
use crate::runs::{Runs, Series};
use crate::scene::{Prior, Scene};

/// The parameters that runs could tell, and what they say of them.
pub(super) struct Sight {
    /// the parameters, those the scene holds left out
    pub kinds: Vec<Kind>,
    /// where the slopes were taken
    pub values: Vec<f64>,
    /// belief of each parameter
    beliefs: Vec<Belief>,
    /// their places among all parameters of the energy balance
    free: Vec<usize>,
    /// all parameters of the energy balance, L before C, δ̃0 and the k of the particles in use
    full: Vec<f64>,
    /// the particles in use
    particles: Vec<usize>,
    /// the terms of the energy balance
    form: Form,
    /// what the runs say there
    pub known: Known,
    /// whether that is where the energy balance was fitted, without priors
    pub fitted: bool,
}

impl Sight {
    /// `None` without parameters, or where a sum is not finite.
    pub fn of(scene: &Scene, runs: &Runs, least_squares: LeastSquares) -> Option<Sight> {
        let form = form(scene, least_squares);
        let inertia = form.inertia;
        let particles: Vec<usize> = (0..scene.particles.len()).filter(|p| in_use(runs, *p)).collect();
        let place = |particle: usize| particles.binary_search(&particle).ok();
        let blocks = blocks(scene, runs, place);
        let no_fit = vec![NO_FIT; particles.len()];
        let balance = law(form, &blocks, &no_fit);
        let wet = [Kind::LubricationLog, Kind::InertialPrefactor, Kind::FilmScale];
        let wet = wet.into_iter().filter(|kind| balance.names().contains(&kind.key()));
        let all: Vec<Kind> = wet.chain(particles.iter().map(|p| Kind::DryK(*p))).collect();
        let priors: Vec<Prior> = all.iter().map(|kind| prior_of(scene, *kind, inertia).0).collect();
        let free: Vec<usize> = (0..all.len())
            .filter(|j| !matches!(priors[*j], Prior::Fixed(_)))
            .filter(|j| matches!(all[*j], Kind::DryK(_)) || !runs.series.is_empty())
            .collect();
        if free.is_empty() {
            return None;
        }
        let beliefs: Vec<Belief> = free.iter().map(|j| belief(&priors[*j])).collect();
        let held: Vec<f64> = priors.iter().map(Prior::median).collect();
        let common = balance.names().len();
        let whole = |values: &[f64]| {
            let mut full = held.clone();
            free.iter().zip(values).for_each(|(j, value)| full[*j] = *value);
            full
        };
        let sums = |values: &[f64]| {
            let full = whole(values);
            let wet = balance.sums(&full);
            [wet, dry_sums(runs, place, &full, (common, form.dry))]
                .map(|sums| sums.of(&free))
                .to_vec()
        };
        let spreads = [Kind::SigmaWet, Kind::SigmaDry].map(|kind| prior_of(scene, kind, inertia).0.median());
        let evidence = Kinds {
            beliefs: &beliefs,
            spreads: &spreads,
            sums: &sums,
        };
        let kinds: Vec<Kind> = free.iter().map(|j| all[*j]).collect();
        let fits = Fits::of(least_squares);
        // an estimate less certain than the prior is no place to take slopes at
        let alone: Vec<Option<f64>> = kinds
            .iter()
            .zip(&beliefs)
            .map(|(kind, belief)| {
                let (value, se) = fits.of_kind(scene, *kind, true)?;
                (se < value * belief.ln_sd).then_some(value)
            })
            .collect();
        let (values, fitted) = match alone.into_iter().collect::<Option<Vec<f64>>>() {
            Some(values) => (values, true),
            None => {
                // a fit that ran away is no place to start from
                let near = |(kind, belief): (&Kind, &Belief)| {
                    let found = fits.of_kind(scene, *kind, false).map(|(value, _)| value);
                    let here = |value: &f64| (value / belief.median).ln().abs() < FAR * belief.ln_sd;
                    found.filter(here).unwrap_or(belief.median)
                };
                let start: Vec<f64> = kinds.iter().zip(&beliefs).map(near).collect();
                (evidence.settle(&start)?, false)
            }
        };
        let known = evidence.known(&values)?;
        Some(Sight {
            full: whole(&values),
            free: free.clone(),
            particles: particles.clone(),
            form,
            kinds,
            values,
            beliefs: beliefs.clone(),
            known,
            fitted,
        })
    }

    /// Value of a parameter; `None` where the scene holds it.
    pub fn value(&self, kind: Kind) -> Option<f64> {
        let place = self.kinds.iter().position(|own| *own == kind)?;
        Some(self.values[place])
    }

    /// C g(δ̃) at a film ratio with its standard error; `None` where the scene holds C, or the runs say less of it than
    /// the priors.
    pub fn inertial_loss(&self, film_ratio: f64) -> Option<(f64, f64)> {
        let c = self.value(Kind::InertialPrefactor)?;
        // what the form lacks is not read
        let scale = self.value(Kind::FilmScale).unwrap_or(1.0);
        let value = c * self.form.inertia.shape(film_ratio, scale);
        let slope = |(kind, belief): (&Kind, &Belief)| match kind {
            Kind::InertialPrefactor => value * belief.ln_sd,
            Kind::FilmScale => c * self.form.inertia.slope_film_scale(film_ratio, scale) * scale * belief.ln_sd,
            _ => 0.0,
        };
        let in_z: Vec<f64> = self.kinds.iter().zip(&self.beliefs).map(slope).collect();
        let believed = in_z.iter().map(|slope| slope * slope).sum::<f64>().sqrt();
        let se = self.known.se(&in_z);
        // below half of the variance is where runs say more than priors
        (se > 0.0 && se * se < 0.5 * believed * believed).then_some((value, se))
    }

    /// Restitution of a series at the setting of one of its runs, with its standard error; `None` where it does not
    /// rebound, or either is not finite.
    pub fn restitution(&self, scene: &Scene, runs: &Runs, series: &Series, run: usize) -> Option<(f64, f64)> {
        let mut one = series.clone();
        (one.rebounds, one.stuck) = (run..run + 1, run + 1..run + 1);
        let place = |particle: usize| self.particles.binary_search(&particle).ok();
        let block = block(scene, runs, &one, place)?;
        let no_fit = vec![NO_FIT; self.particles.len()];
        let blocks = [block];
        let balance = law(self.form, &blocks, &no_fit);
        let value = *balance.fitted(&self.full).first()?;
        let mut slopes = DMatrix::zeros(balance.runs(), balance.parameters());
        balance.jacobian(&self.full, &mut slopes).ok()?;
        let in_z = |((j, value), belief): ((&usize, &f64), &Belief)| slopes[(0, *j)] * value * belief.ln_sd;
        let in_z: Vec<f64> = self
            .free
            .iter()
            .zip(&self.values)
            .zip(&self.beliefs)
            .map(in_z)
            .collect();
        let se = self.known.se(&in_z);
        (value > 0.0 && se > 0.0 && se.is_finite()).then_some((value, se))
    }
}

/// Prior sds beyond which a start is none.
const FAR: f64 = 10.0;

/// k of a dry fit that is not read: here every dry run enters by itself.
const NO_FIT: (f64, f64) = (f64::NAN, f64::NAN);

/// The energy balance of some blocks, for its slopes.
fn law<'b>(form: Form, blocks: &'b [Block<'b>], no_fit: &'b [(f64, f64)]) -> Balance<'b> {
    Balance {
        blocks,
        form,
        dry_k: no_fit,
        spread: f64::NAN,
    }
}

/// The terms that are held; where the form of the inertial loss is left open, the one the energy balance took.
fn form(scene: &Scene, least_squares: LeastSquares) -> Form {
    let taken = least_squares.energy_balance.as_ref().map(|balance| balance.inertia);
    let taken = taken.and_then(|name| Inertia::ALL.into_iter().find(|form| form.name() == name));
    let taken = taken.filter(|_| scene.model.inertia_is_open());
    Form {
        inertia: taken.unwrap_or(least_squares.form.inertia),
        ..least_squares.form
    }
}

fn in_use(runs: &Runs, particle: usize) -> bool {
    !runs.dry_of(particle).is_empty() || !runs.series_of(particle).is_empty()
}

/// A prior as median and sd of the logarithm; one that is not lognormal by its sd over its median.
fn belief(prior: &Prior) -> Belief {
    let (sd, median) = match *prior {
        Prior::LogNormal(median, ln_sd) => return Belief { median, ln_sd },
        Prior::StudentT(_, location, scale) => (prior.sd().unwrap_or(scale), location),
        _ => (prior.sd().unwrap_or(1.0), prior.median()),
    };
    // parameters are positive: a prior about 0 or below believes in about its sd
    let median = if median > 0.0 { median } else { sd };
    Belief {
        median,
        ln_sd: sd / median,
    }
}

/// Where least squares found the parameters, by name.
struct Fits<'f> {
    in_balance: HashMap<&'f str, &'f Estimate>,
    dry: HashMap<&'f str, &'f Dry>,
    /// particles with wet runs
    wet: HashSet<&'f str>,
}

impl<'f> Fits<'f> {
    fn of(least_squares: LeastSquares<'f>) -> Fits<'f> {
        let parameters = least_squares
            .energy_balance
            .iter()
            .flat_map(|balance| &balance.parameters);
        Fits {
            in_balance: parameters.map(|own| (own.name.as_str(), &own.estimate)).collect(),
            dry: least_squares
                .dry
                .iter()
                .map(|dry| (dry.particle.as_str(), dry))
                .collect(),
            wet: least_squares
                .series
                .iter()
                .map(|series| series.particle.as_str())
                .collect(),
        }
    }

    /// Where least squares found a parameter: in the energy balance, or for k in the dry runs, too, unless that balance
    /// is asked for alone; with its standard error. `None` unless it is positive.
    fn of_kind(&self, scene: &Scene, kind: Kind, balance_alone: bool) -> Option<(f64, f64)> {
        let name = super::words::name(scene, kind);
        let in_balance = self.in_balance.get(name.as_str()).and_then(|estimate| estimate.pair());
        let particle = match kind {
            Kind::DryK(particle) => Some(scene.particles[particle].name.as_str()),
            _ => None,
        };
        let dry = || {
            let dry = self.dry.get(particle?)?;
            dry.dry_k.pair().filter(|_| dry.verdict.passed)
        };
        // a particle without wet runs has its k from the dry ones, and no other
        let dry_only = particle.is_some_and(|particle| !self.wet.contains(particle));
        let alone = balance_alone && !dry_only;
        let value = if alone { in_balance } else { in_balance.or_else(dry) };
        value.filter(|(value, _)| *value > 0.0)
    }
}

/// What every dry rebound says of k; k of the first particle stands at `common`.
fn dry_sums(runs: &Runs, place: impl Fn(usize) -> Option<usize>, full: &[f64], (common, law): (usize, Order)) -> Sums {
    let mut sums = Sums::new(common, full.len() - common);
    for group in &runs.dry {
        let Some(place) = place(group.particle) else { continue };
        let k = full[common + place];
        for run in group.rebounds.clone() {
            let v = runs.impact_speed[run];
            let residual = law.restitution(k, v) - runs.restitution[run];
            sums.add(residual, &[(common + place, law.slope_dry_k(k, v))]);
        }
    }
    sums
}
