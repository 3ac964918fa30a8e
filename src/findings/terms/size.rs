//! Takes the sizes of terms from weighted sums over the runs.

use std::collections::HashMap;

use nalgebra::DVector;

use super::{SizedTerm, Term};
use crate::findings::balance::EnergyBalance;
use crate::findings::dry::{self, FittedDry};
use crate::findings::estimate::Estimate;
use crate::findings::scaling::FittedScaling;
use crate::inference::arrow::Arrow;
use crate::model::parameters::{prior_of, Kind, COMMON_SLOTS};
use crate::physics::impact::{kept_energy, kept_energy_slopes, Form, Parameters, Setting};
use crate::physics::inertia::Inertia;
use crate::physics::rebound::{mean_restitution, slope_mean_restitution};
use crate::runs::{Runs, Series};
use crate::scene::{Law, Prior, Scene};

/// A term with more than this many runs to see it by is sized on every so manyth of them.
const MOST_RUNS: usize = 20_000;

/// What a prior without a standard deviation says: nothing.
const WIDE: f64 = 1e6;

/// A fitted prefactor this many standard errors from zero says how large its term is; else its prior does.
const SEEN: f64 = 2.0;

/// Where the sizes are taken.
struct Point {
    /// a full vector of parameters
    full: Vec<f64>,
    /// spreads of dry and of wet restitutions; `None` where the runs leave none
    sigma: Option<[f64; 2]>,
}

impl Point {
    fn of(
        scene: &Scene,
        runs: &Runs,
        dry: &[FittedDry],
        scaling: &[FittedScaling],
        (form, balance): (Form, Option<&EnergyBalance>),
    ) -> Point {
        let mut full = vec![0.0; COMMON_SLOTS + scene.particles.len()];
        let parameters = balance.iter().flat_map(|balance| &balance.parameters);
        let in_balance: HashMap<&str, &Estimate> = parameters.map(|own| (own.name.as_str(), &own.estimate)).collect();
        let fitted = |name: &str| {
            let (value, se) = in_balance.get(name)?.pair()?;
            (value > SEEN * se).then_some(value)
        };
        for kind in [Kind::LubricationLog, Kind::InertialPrefactor, Kind::FilmScale] {
            let median = prior_of(scene, kind, form.inertia).0.median();
            full[kind.slot()] = fitted(kind.key()).unwrap_or(median);
        }
        for (particle, named) in scene.particles.iter().enumerate() {
            let kind = Kind::DryK(particle);
            let own = dry::of(dry, particle).and_then(|one| one.usable);
            let joint = fitted(&format!("dry_k[{}]", named.name)).or(own.map(|(k, _)| k));
            full[kind.slot()] = joint.unwrap_or_else(|| prior_of(scene, kind, form.inertia).0.median());
        }
        let of_laws = || {
            let laws = scaling.iter().filter(|fitted| fitted.law == Law::Sqrt);
            laws.filter_map(|fitted| fitted.scaling.residual_sd).reduce(f64::min)
        };
        let wet = balance.and_then(|balance| balance.residual_sd).or_else(of_laws);
        let of_dry = dry.iter().filter_map(|one| one.dry.residual_sd).reduce(f64::max);
        // runs of one kind have their spread stand for the other's, which then weighs nothing
        let wet = wet.or(of_dry.filter(|_| runs.series.is_empty()));
        let spread = |sd: f64| sd > 1e-12;
        let sigma = wet.map(|wet| [of_dry.filter(|sd| spread(*sd)).unwrap_or(wet), wet]);
        Point {
            full,
            sigma: sigma.filter(|[_, wet]| spread(*wet)),
        }
    }

    fn parameters(&self, particle: usize) -> Parameters {
        Parameters {
            dry_k: self.full[Kind::DryK(particle).slot()],
            lubrication_log: self.full[Kind::LubricationLog.slot()],
            inertial_prefactor: self.full[Kind::InertialPrefactor.slot()],
            film_scale: self.full[Kind::FilmScale.slot()],
        }
    }
}

/// Every term with its size in this form; the bridge only where a liquid in use has a surface tension.
pub(super) fn size(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    scaling: &[FittedScaling],
    (form, balance): (Form, Option<&EnergyBalance>),
) -> Vec<SizedTerm> {
    let inertia = balance.and_then(|balance| Inertia::ALL.into_iter().find(|form| form.name() == balance.inertia));
    let form = Form {
        inertia: inertia.unwrap_or(form.inertia),
        ..form
    };
    let point = Point::of(scene, runs, dry, scaling, (form, balance));
    let mut sums = Sums::new(scene, form, &point);
    sums.add_wet(scene, runs);
    sums.add_dry(runs);
    let tension = |series: &Series| scene.liquids[series.liquid].surface_tension.is_some();
    let wet = !runs.series.is_empty();
    let applies = |term: &Term| match term {
        Term::DrySecondOrder => true,
        Term::Bridge => runs.series.iter().any(tension),
        Term::Inertia | Term::Viscous | Term::OwnDrySpeed => wet,
    };
    let of = |term: Term| {
        let (size, moves) = sums.bias(scene, term).unzip();
        let held = term.is_held(form);
        let named = match term {
            Term::OwnDrySpeed => "scene",
            _ if scene.model.terms.is_some() => "scene",
            Term::Inertia | Term::Viscous => "auto",
            Term::Bridge | Term::DrySecondOrder => "default",
        };
        SizedTerm {
            term: term.name(),
            held,
            chosen_by: named,
            size,
            moves,
            largest_effect: sums.largest_effect[term as usize],
            widens: sums.widening(term).filter(|_| held),
        }
    };
    Term::ALL.into_iter().filter(applies).map(of).collect()
}

/// Weighted sums over the runs.
struct Sums<'p> {
    form: Form,
    point: &'p Point,
    /// the slots of a full vector that are parameters of the model, spreads apart
    slots: Vec<usize>,
    /// where each slot stands among them
    places: Vec<Option<usize>>,
    /// JᵀWJ with the priors' own
    information: Arrow,
    /// JᵀWΔe of each term
    pulls: [DVector<f64>; 5],
    largest_effect: [f64; 5],
}

impl<'p> Sums<'p> {
    fn new(scene: &Scene, form: Form, point: &'p Point) -> Sums<'p> {
        let kinds = [Kind::LubricationLog, Kind::InertialPrefactor, Kind::FilmScale];
        let ks = (0..scene.particles.len()).map(Kind::DryK);
        let in_form = |kind: &Kind| match kind {
            Kind::LubricationLog => form.viscous,
            Kind::InertialPrefactor => form.inertia != Inertia::None,
            Kind::FilmScale => form.inertia.has_film_scale(),
            _ => true,
        };
        let mut slots = vec![];
        let mut precision = vec![];
        for kind in kinds.into_iter().chain(ks).filter(in_form) {
            let prior = prior_of(scene, kind, form.inertia).0;
            // what a prior holds is no parameter
            if !matches!(prior, Prior::Fixed(_)) {
                let sd = prior.sd().unwrap_or(WIDE);
                slots.push(kind.slot());
                precision.push(1.0 / (sd * sd));
            }
        }
        let zeros = DVector::zeros(slots.len());
        let shared = slots.partition_point(|slot| *slot < COMMON_SLOTS);
        let mut information = Arrow::zeros(shared, slots.len() - shared);
        for (place, precision) in precision.into_iter().enumerate() {
            information.add((place, place), precision);
        }
        let mut places = vec![None; point.full.len()];
        for (place, slot) in slots.iter().enumerate() {
            places[*slot] = Some(place);
        }
        Sums {
            form,
            point,
            information,
            slots,
            places,
            pulls: std::array::from_fn(|_| zeros.clone()),
            largest_effect: [0.0; 5],
        }
    }

    /// Adds a restitution's slopes, few of them, and what each term does to it.
    fn add(&mut self, weight: f64, slopes: &[(usize, f64)], effects: [f64; 5]) {
        let places: Vec<(usize, f64)> = slopes
            .iter()
            .filter_map(|(slot, slope)| Some((self.places[*slot]?, *slope)))
            .collect();
        self.information.add_square(weight, &places);
        for (row, of_row) in &places {
            for (pull, effect) in self.pulls.iter_mut().zip(effects) {
                pull[*row] += weight * of_row * effect;
            }
        }
        for (largest, effect) in self.largest_effect.iter_mut().zip(effects) {
            *largest = f64::max(*largest, effect.abs());
        }
    }

    fn add_wet(&mut self, scene: &Scene, runs: &Runs) {
        let rebounds: usize = runs.series.iter().map(|series| series.rebounds.len()).sum();
        let step = rebounds.div_ceil(MOST_RUNS).max(1);
        let weight = self.point.sigma.map_or(0.0, |[_, wet]| step as f64 / (wet * wet));
        for series in &runs.series {
            let (particle, liquid) = (&scene.particles[series.particle], &scene.liquids[series.liquid]);
            let parameters = self.point.parameters(series.particle);
            for run in series.rebounds.clone().step_by(step) {
                let setting = Setting {
                    density: particle.density,
                    diameter: runs.diameter[run],
                    liquid_density: liquid.density,
                    viscosity: liquid.viscosity,
                    film: runs.film[run],
                    surface_tension: liquid.surface_tension,
                };
                let v = runs.impact_speed[run];
                let kept = |form: Form| kept_energy(&setting, form, &parameters, v);
                let r = kept(self.form);
                let slope = slope_mean_restitution(r);
                let of = kept_energy_slopes(&setting, self.form, &parameters, v);
                let slopes = [
                    (Kind::LubricationLog.slot(), slope * of.lubrication_log),
                    (Kind::InertialPrefactor.slot(), slope * of.inertial_prefactor),
                    (Kind::FilmScale.slot(), slope * of.film_scale),
                    (Kind::DryK(series.particle).slot(), slope * of.dry_k),
                ];
                let e = mean_restitution(r);
                let effects = Term::ALL.map(|term| mean_restitution(kept(term.toggled(self.form))) - e);
                self.add(weight, &slopes, effects);
            }
        }
    }

    fn add_dry(&mut self, runs: &Runs) {
        let rebounds: usize = runs.dry.iter().map(|group| group.rebounds.len()).sum();
        let step = rebounds.div_ceil(MOST_RUNS).max(1);
        let weight = self.point.sigma.map_or(0.0, |[dry, _]| step as f64 / (dry * dry));
        for group in &runs.dry {
            let slot = Kind::DryK(group.particle).slot();
            let k = self.point.full[slot];
            let other = Term::DrySecondOrder.toggled(self.form).dry;
            for run in group.rebounds.clone().step_by(step) {
                let v = runs.impact_speed[run];
                let mut effects = [0.0; 5];
                effects[Term::DrySecondOrder as usize] = other.restitution(k, v) - self.form.dry.restitution(k, v);
                self.add(weight, &[(slot, self.form.dry.slope_dry_k(k, v))], effects);
            }
        }
    }

    /// What runs and priors say of the parameters that are not this term's own; `None` where that leaves one open.
    fn without(&self, term: Option<Term>) -> Option<Others> {
        self.point.sigma?;
        let others = |place: &usize| !term.is_some_and(|term| term.owns(self.slots[*place]));
        let places: Vec<usize> = (0..self.slots.len()).filter(others).collect();
        let information = self.information.select(&places);
        // parameters have units of their own: scaled to a unit diagonal the inverse loses no digits to them
        let scale: Vec<f64> = information.diagonal().map(|sum| 1.0 / sum.sqrt()).collect();
        let scaled = information.scaled(&scale);
        let root = scaled.root()?;
        let pull = |term: Term| {
            let scaled = places
                .iter()
                .zip(&scale)
                .map(|(place, scale)| self.pulls[term as usize][*place] * scale);
            DVector::from_iterator(places.len(), scaled)
        };
        let bias = term.map(|term| root.solve(&pull(term)));
        let bias = bias
            .iter()
            .flat_map(|bias| bias.iter().zip(&scale).map(|(x, scale)| x * scale))
            .collect();
        let variance = root
            .inverse_diagonal()
            .into_iter()
            .zip(&scale)
            .map(|(x, scale)| x * scale * scale);
        Some(Others {
            variance: variance.collect(),
            bias,
            places,
        })
    }

    /// The largest bias in standard errors, and whose it is.
    fn bias(&self, scene: &Scene, term: Term) -> Option<(f64, String)> {
        let others = self.without(Some(term))?;
        let sizes = others.bias.iter().zip(&others.variance).zip(&others.places);
        let sizes = sizes.map(|((bias, variance), place)| (bias.abs() / variance.sqrt(), self.slots[*place]));
        let (size, slot) = sizes.max_by(|a, b| a.0.total_cmp(&b.0))?;
        size.is_finite().then(|| (size, name_of(scene, slot)))
    }

    /// Largest factor by which the term's own parameters widen another's standard error.
    fn widening(&self, term: Term) -> Option<f64> {
        if !self.slots.iter().any(|slot| term.owns(*slot)) {
            return None;
        }
        let (with, without) = (self.without(None)?, self.without(Some(term))?);
        // of all the parameters, none is left out
        let ratio = |(variance, place): (&f64, &usize)| (with.variance[*place] / variance).sqrt();
        without.variance.iter().zip(&without.places).map(ratio).reduce(f64::max)
    }
}

/// Parameters of the model without a term.
struct Others {
    /// their places among all of them
    places: Vec<usize>,
    variance: Vec<f64>,
    /// what leaving the term out does to each; empty without a term
    bias: Vec<f64>,
}

fn name_of(scene: &Scene, slot: usize) -> String {
    match slot.checked_sub(COMMON_SLOTS) {
        Some(particle) => format!("dry_k[{}]", scene.particles[particle].name),
        None => {
            let kinds = [Kind::LubricationLog, Kind::InertialPrefactor, Kind::FilmScale];
            let kind = kinds.into_iter().find(|kind| kind.slot() == slot);
            kind.map_or_else(String::new, |kind| kind.key().to_owned())
        }
    }
}
