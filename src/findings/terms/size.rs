//! Takes the sizes of terms from weighted sums over the runs.

use nalgebra::{DMatrix, DVector};

use super::sized::SizedTerm;
use crate::findings::balance::{rebounds, BalanceSetup, EnergyBalance};
use crate::findings::dry;
use crate::findings::scaling::FittedScaling;
use crate::inference::information::{add_square, scaled};
use crate::inference::joint::{Joint, JointRow, Part};
use crate::model::parameters::{prior_of, ParameterKind};
use crate::physics::coefficient::Coefficients;
use crate::physics::form::Term;
use crate::physics::rebound::mean_restitution;
use crate::physics::{kept_energy, Coefficient, Form, Parameters};
use crate::runs::Series;
use crate::scene::{Prior, Scene, WetLaw};

/// A term with more than this many runs to see it by is sized on every so manyth of them.
const MOST_RUNS: usize = 20_000;

/// Which of the rows of a joint fit is taken each time; every one of those that stand for several.
fn step(joint: &Joint, rows: usize) -> usize {
    if joint.runs.count.is_empty() {
        rows.div_ceil(MOST_RUNS).max(1)
    } else {
        1
    }
}

/// What a prior without a standard deviation says: nothing.
const WIDE: f64 = 1e6;

/// A fitted prefactor this many standard errors from zero says how large its term is; else its prior does.
const SEEN: f64 = 2.0;

/// Where the sizes are taken.
struct ReferencePoint {
    /// of every shared parameter, those of terms that are not held with them
    shared: Coefficients,
    /// k of each sphere of the runs
    dry_k: Vec<f64>,
    /// spreads of dry and of wet restitutions; `None` where the runs leave none
    sigma: Option<[f64; 2]>,
}

impl ReferencePoint {
    fn of(
        setup: BalanceSetup,
        scaling: &[FittedScaling],
        form: Form,
        balance: Option<&EnergyBalance>,
    ) -> ReferencePoint {
        let BalanceSetup { scene, runs, dry, .. } = setup;
        let fitted = |kind: ParameterKind| {
            let (value, se) = balance?.estimate(kind)?.value_and_scale()?;
            (value > SEEN * se).then_some(value)
        };
        let believed = |kind: ParameterKind| prior_of(scene, runs, kind, form).0.median();
        let mut shared = Coefficients::default();
        for coefficient in Coefficient::ALL {
            let kind = ParameterKind::Shared(coefficient);
            shared[coefficient] = fitted(kind).unwrap_or_else(|| believed(kind));
        }
        let of_sphere = |sphere: usize| {
            let kind = ParameterKind::DryK(sphere);
            let own = dry::fit_of_sphere(dry, sphere).and_then(|one| one.usable);
            let found = fitted(kind).or(own.map(|(k, _)| k));
            found.unwrap_or_else(|| believed(kind))
        };
        let of_laws = || {
            let laws = scaling.iter().filter(|fitted| fitted.law == WetLaw::Sqrt);
            laws.filter_map(|fitted| fitted.scaling.residual_sd).reduce(f64::min)
        };
        let wet = balance.and_then(|balance| balance.residual_sd).or_else(of_laws);
        let of_dry = dry.iter().filter_map(|one| one.dry.residual_sd).reduce(f64::max);
        // runs of one kind have their spread stand for the other's, which then weighs nothing
        let wet = wet.or(of_dry.filter(|_| runs.series.is_empty()));
        let spread = |sd: f64| sd > 1e-12;
        let sigma = wet.map(|wet| [of_dry.filter(|sd| spread(*sd)).unwrap_or(wet), wet]);
        ReferencePoint {
            shared,
            dry_k: (0..runs.spheres.len()).map(of_sphere).collect(),
            sigma: sigma.filter(|[_, wet]| spread(*wet)),
        }
    }

    fn parameters(&self, sphere: usize) -> Parameters {
        Parameters {
            dry_k: self.dry_k[sphere],
            shared: self.shared,
        }
    }

    /// The same as a point of a joint fit.
    fn of_joint(&self, joint: &Joint) -> Vec<f64> {
        let value = |kind: ParameterKind| match kind {
            ParameterKind::DryK(sphere) => self.dry_k[sphere],
            ParameterKind::Shared(coefficient) => self.shared[coefficient],
            // a joint fit has no other
            _ => f64::NAN,
        };
        joint.kinds().map(value).collect()
    }
}

/// Every term with its size in this form; the bridge only where a liquid in use has a surface tension.
pub(super) fn term_sizes(
    setup: BalanceSetup,
    scaling: &[FittedScaling],
    form: Form,
    balance: Option<&EnergyBalance>,
) -> Vec<SizedTerm> {
    let BalanceSetup { scene, runs, .. } = setup;
    // where the form of inertia was left open, the one the balance took
    let form = Form {
        inertia: balance.map_or(form.inertia, |balance| balance.form().inertia),
        ..form
    };
    let point = ReferencePoint::of(setup, scaling, form, balance);
    let spheres = || 0..runs.spheres.len();
    let wet: Vec<usize> = spheres().filter(|s| rebounds(runs, *s)).collect();
    let dry: Vec<usize> = spheres().filter(|s| !runs.dry_of(*s).is_empty()).collect();
    let joint = Joint::new(scene, runs, form, &wet, &dry);
    let mut sums = TermSums::new(scene, &joint, &point);
    sums.add_wet(scene, &joint, &point);
    sums.add_dry(&joint, &point);
    let tension = |series: &Series| scene.liquids[series.liquid].surface_tension.is_some();
    let has_wet = !runs.series.is_empty();
    let applies = |term: &Term| match term {
        Term::DrySecondOrder => true,
        Term::Bridge => runs.series.iter().any(tension),
        Term::Inertia | Term::Viscous | Term::OwnDrySpeed => has_wet,
    };
    // elsewhere than at a fit of every parameter, what the runs have more than the model is no misfit of it
    let is_fitted = |balance: &EnergyBalance, kind: ParameterKind| {
        let fitted = balance.estimate(kind).and_then(|estimate| estimate.value_and_scale());
        fitted.is_some_and(|(value, se)| value > SEEN * se)
    };
    let at_fit = balance.is_some_and(|own| own.verdict.passed && joint.kinds().all(|kind| is_fitted(own, kind)));
    let of = |term: Term| {
        let (size, moves) = sums.bias(term).unzip();
        let held = term.is_held(form);
        let share = sums.share_shown(term).filter(|_| at_fit && !held);
        let chosen_by = match term {
            Term::OwnDrySpeed => "scene",
            _ if scene.model.terms.is_some() => "scene",
            Term::Inertia | Term::Viscous => "auto",
            Term::Bridge | Term::DrySecondOrder => "default",
        };
        SizedTerm {
            term,
            held,
            chosen_by,
            size,
            moves: moves.map(|kind| kind.name(scene, runs)),
            largest_effect: sums.largest_effect[term as usize],
            runs_show: share.map(|[share, _]| share),
            runs_show_se: share.map(|[_, se]| se),
            widens: sums.widening(term).filter(|_| held),
        }
    };
    Term::ALL.into_iter().filter(applies).map(of).collect()
}

/// Weighted sums over the runs.
struct TermSums {
    form: Form,
    /// whether the runs have a spread to weigh them by
    weighed: bool,
    /// the parameters of the fit that no prior holds
    kinds: Vec<ParameterKind>,
    /// where each parameter of the fit stands among them
    places: Vec<Option<usize>>,
    /// JᵀWJ with the priors' own
    information: DMatrix<f64>,
    /// JᵀWΔe of each term
    pulls: [DVector<f64>; Term::ALL.len()],
    /// JᵀWy, y being what the restitutions have more than the fit
    misfit: DVector<f64>,
    /// ΔeᵀWy of each term
    misfit_along: [f64; Term::ALL.len()],
    /// ΔeᵀWΔe of each term
    squares: [f64; Term::ALL.len()],
    largest_effect: [f64; Term::ALL.len()],
}

impl TermSums {
    fn new(scene: &Scene, joint: &Joint, point: &ReferencePoint) -> TermSums {
        let (mut kinds, mut precision, mut places) = (vec![], vec![], vec![]);
        for kind in joint.kinds() {
            let prior = prior_of(scene, joint.runs, kind, joint.form).0;
            // what a prior holds is no parameter
            if matches!(prior, Prior::Fixed(_)) {
                places.push(None);
                continue;
            }
            let sd = prior.sd().unwrap_or(WIDE);
            places.push(Some(kinds.len()));
            kinds.push(kind);
            precision.push(1.0 / (sd * sd));
        }
        let zeros = DVector::zeros(kinds.len());
        TermSums {
            form: joint.form,
            weighed: point.sigma.is_some(),
            information: DMatrix::from_diagonal(&DVector::from_vec(precision)),
            kinds,
            places,
            pulls: std::array::from_fn(|_| zeros.clone()),
            misfit: zeros.clone(),
            misfit_along: [0.0; Term::ALL.len()],
            squares: [0.0; Term::ALL.len()],
            largest_effect: [0.0; Term::ALL.len()],
        }
    }

    /// Adds a run's slopes, and what each term does to its restitution.
    fn add(&mut self, weight: f64, part: &Part, row: &JointRow, effects: [f64; Term::ALL.len()]) {
        let row_misfit = row.residual;
        let slopes = part.places.iter().zip(row.slopes);
        let places: Vec<(usize, f64)> = slopes
            .filter_map(|(place, slope)| Some((self.places[*place]?, slope)))
            .collect();
        add_square(&mut self.information, weight, &places);
        for (row, of_row) in &places {
            for (pull, effect) in self.pulls.iter_mut().zip(effects) {
                pull[*row] += weight * of_row * effect;
            }
            self.misfit[*row] -= weight * of_row * row_misfit;
        }
        for (place, effect) in effects.into_iter().enumerate() {
            self.misfit_along[place] -= weight * effect * row_misfit;
            self.squares[place] += weight * effect * effect;
        }
        for (largest, effect) in self.largest_effect.iter_mut().zip(effects) {
            *largest = f64::max(*largest, effect.abs());
        }
    }

    fn add_wet(&mut self, scene: &Scene, joint: &Joint, point: &ReferencePoint) {
        let runs = joint.runs;
        let step = step(joint, joint.wet_rebounds());
        let weight = point.sigma.map_or(0.0, |[_, wet]| step as f64 / (wet * wet));
        let at = point.of_joint(joint);
        for part in joint.wet_parts() {
            let Some(series) = part.series.map(|index| &runs.series[index]) else {
                continue;
            };
            let (parameters, form) = (point.parameters(part.sphere), self.form);
            for run in part.rebounds.clone().step_by(step) {
                let setting = runs.setting(scene, series, run);
                let kept = |term: Term| {
                    let other = term.toggled(form);
                    kept_energy(&setting, other, &parameters, runs.impact_speed[run])
                };
                joint.each(part, run..run + 1, &at, |row| {
                    let effects = Term::ALL.map(|term| mean_restitution(kept(term)) - row.model);
                    self.add(weight * runs.count(run), part, &row, effects);
                });
            }
        }
    }

    fn add_dry(&mut self, joint: &Joint, point: &ReferencePoint) {
        let rebounds: usize = joint.dry_parts().map(|part| part.rebounds.len()).sum();
        let step = step(joint, rebounds);
        let weight = point.sigma.map_or(0.0, |[dry, _]| step as f64 / (dry * dry));
        let (runs, at) = (joint.runs, point.of_joint(joint));
        let other = Term::DrySecondOrder.toggled(self.form).dry;
        for part in joint.dry_parts() {
            let k = point.dry_k[part.sphere];
            for run in part.rebounds.clone().step_by(step) {
                joint.each(part, run..run + 1, &at, |row| {
                    let mut effects = [0.0; Term::ALL.len()];
                    let loss = k * runs.impacts.speed_root[run];
                    effects[Term::DrySecondOrder as usize] = other.of_loss(loss)[0] - row.model;
                    self.add(weight * runs.count(run), part, &row, effects);
                });
            }
        }
    }

    /// Whether a parameter is a term's own.
    fn owns(&self, term: Term, place: usize) -> bool {
        match self.kinds[place] {
            ParameterKind::Shared(coefficient) => term.owns(coefficient, self.form),
            _ => false,
        }
    }

    /// What runs and priors say of the parameters that are not this term's own; `None` where that leaves one open.
    fn without(&self, term: Option<Term>) -> Option<Others> {
        self.weighed.then_some(())?;
        let others = |place: &usize| !term.is_some_and(|term| self.owns(term, *place));
        let places: Vec<usize> = (0..self.kinds.len()).filter(others).collect();
        let information = self.information.select_rows(&places).select_columns(&places);
        // parameters have units of their own: scaled to a unit diagonal the inverse loses no digits to them
        let scale: Vec<f64> = information.diagonal().iter().map(|sum| 1.0 / sum.sqrt()).collect();
        let root = scaled(&information, &scale).cholesky()?;
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
        Some(Others {
            variance: scaled(&root.inverse(), &scale).diagonal().iter().copied().collect(),
            bias,
            places,
        })
    }

    /// The largest bias in standard errors, and whose it is.
    fn bias(&self, term: Term) -> Option<(f64, ParameterKind)> {
        let others = self.without(Some(term))?;
        let sizes = others.bias.iter().zip(&others.variance).zip(&others.places);
        let sizes = sizes.map(|((bias, variance), place)| (bias.abs() / variance.sqrt(), self.kinds[*place]));
        let (size, kind) = sizes.max_by(|a, b| a.0.total_cmp(&b.0))?;
        size.is_finite().then_some((size, kind))
    }

    /// Share of the term's full effect that the runs show, with its standard error: its coefficient in a fit that is linear
    /// about this one. `None` without a spread, or where the other parameters take up all that the term does.
    fn share_shown(&self, term: Term) -> Option<[f64; 2]> {
        /// what must be left of a term's squares beside the other parameters
        const LEAST_LEFT: f64 = 1e-6;
        let others = self.without(Some(term))?;
        let along = |sums: &DVector<f64>| {
            let taken = others
                .places
                .iter()
                .zip(&others.bias)
                .map(|(place, bias)| sums[*place] * bias);
            taken.sum::<f64>()
        };
        let index = term as usize;
        let left = self.squares[index] - along(&self.pulls[index]);
        if left.is_nan() || left <= LEAST_LEFT * self.squares[index] {
            return None;
        }
        let share = (self.misfit_along[index] - along(&self.misfit)) / left;
        Some([share, left.sqrt().recip()]).filter(|own| own.iter().all(|x| x.is_finite()))
    }

    /// Largest factor by which the term's own parameters widen another's standard error.
    fn widening(&self, term: Term) -> Option<f64> {
        if !(0..self.kinds.len()).any(|place| self.owns(term, place)) {
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
