//! Estimates L, the inertial prefactor and the film scale from every rebound at once, and measures what pooling liquids of
//! different density ratio does to the square-root law beside that, without any noise.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::dry::{self, Dry};
use super::estimate::{Estimate, QuantityEstimates, Quoting};
use super::fit_columns::error_columns;
use super::fit_verdict::{f_words, one_against, uncertain, why_stopped, OwnLaw, Verdict};
use super::form_choice::{ln_prior_of_prefactor, Candidate, ChosenBy, InertiaChoice};
use super::places::WetPlace;
use super::scaling::{e_inf_and_st_c, Bias, Scaling};
use super::wet_fit::{two, FitSetup, WetRuns};
use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::{chi_squared, reweight, ErrorSummary, ErrorWeights, SpeedDependent};
use crate::inference::joint::{fit_joint, Joint, JointFit};
use crate::inference::least_squares::{Fit, ResidualProblem, Stop};
use crate::inference::nested::FTest;
use crate::inference::profile::{Limits, ProblemProfile, Region, WithSlopes};
use crate::model::parameters::ParameterKind;
use crate::physics::balance::{Balance, BalanceAtFilm};
use crate::physics::form::Term;
use crate::physics::jet::{Jet, Number};
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::{Coefficient, Form, Inertia, Viscous};
use crate::runs::Runs;
use crate::scene::{NoiseOn, Scene, WetLaw};

/// The energy balance over particles, liquids, diameters, films and speeds.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EnergyBalance {
    /// form of the inertial loss
    pub inertia: Inertia,
    /// form of the viscous loss
    pub viscous: Viscous,
    /// particles with a usable k at some diameter; the others are left out
    pub particles: Vec<String>,
    /// rebounds used
    pub runs: usize,
    /// those that particles share, as far as the form has them, and k with what the wet runs say of it
    #[serde(skip)]
    pub parameters: Vec<ParameterEstimate>,
    /// δc/ε = exp(L)
    #[serde(skip)]
    pub delta_c_over_roughness: Estimate,
    /// e_inf and St_c that follow from the parameters, for each particle and film ratio; and for each diameter where k or St_c
    /// depends on it
    pub derived: Vec<DerivedEstimate>,
    /// largest distance of a k here from that of the dry runs alone, in combined standard errors
    pub dry_k_shift_in_se: Option<f64>,
    /// spread of the restitutions about the law
    pub residual_sd: Option<f64>,
    /// how measurement errors entered; `None` where no run carries one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<ErrorSummary>,
    /// this law for all against a square-root law for each particle and film ratio
    pub lack_of_fit: Option<FTest>,
    /// how the fit ended
    pub stop: &'static str,
    /// whether it may be quoted
    pub verdict: Verdict,
    /// how its form of inertia was chosen; `None` where the scene names it
    #[serde(skip)]
    pub(super) choice: Option<InertiaChoice>,
    /// where it is linearised
    #[serde(skip)]
    pub(super) fitted_point: FittedPoint,
}

/// Where the energy balance was fitted, and how its runs were weighed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FittedPoint {
    pub(super) form: Form,
    /// the spread against which the dry runs are weighed
    pub(super) spread: f64,
    /// roots of the weights by measurement errors; empty where there are none
    pub(super) roots: Vec<f64>,
    /// where it ended
    pub(super) point: Vec<f64>,
}

/// A form, with the form of inertia that a balance took where it was left open.
pub(super) fn with_inertia_of(form: Form, balance: Option<&EnergyBalance>) -> Form {
    let inertia = balance.map_or(form.inertia, |balance| balance.inertia);
    Form { inertia, ..form }
}

impl EnergyBalance {
    /// The form that was fitted.
    pub fn form(&self) -> Form {
        self.fitted_point.form
    }

    /// The estimate of a parameter; `None` of one that is not in the fit.
    pub fn estimate(&self, kind: ParameterKind) -> Option<&Estimate> {
        let found = self.parameters.iter().find(|parameter| parameter.kind == kind);
        Some(&found?.estimate)
    }
}

/// A parameter of the energy balance.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEstimate {
    /// what it is
    pub kind: ParameterKind,
    /// its name
    pub name: String,
    /// its value
    pub estimate: Estimate,
}

/// e_inf and St_c of one particle at one film ratio, as they follow from the energy balance.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DerivedEstimate {
    /// name of the particle
    pub particle: String,
    /// film ratio
    pub film_ratio: f64,
    /// D, m, where k or St_c depends on it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// ρ̃, mean over the rebounds
    pub density_ratio: f64,
    /// e_inf = √(e_dry² − C ρ̃ g), at the reference dry speed, and St_c = 2 L/e_inf²
    #[serde(skip)]
    pub estimates: QuantityEstimates,
    /// their correlation
    pub correlation: Option<f64>,
    /// its place among those of the form
    #[serde(skip)]
    pub(super) place: usize,
    /// index into [`Runs::spheres`]
    #[serde(skip)]
    pub(super) sphere: usize,
}

/// Why there is no St_c and no δc.
pub(super) const NO_VISCOUS: &str = "the viscous loss is left out of the model";

/// Probability of the lack-of-fit test below which the balance does not describe the runs.
pub const MISFIT: f64 = 0.001;

/// A balance of one form that was fitted.
struct FittedBalance<'r> {
    problem: JointFit<'r>,
    /// the spread against which the dry runs were weighed
    spread: f64,
    fit: Fit,
    /// roots of the weights by measurement errors; empty where there are none
    roots: Vec<f64>,
    error_weights: Option<ErrorWeights>,
}

impl FittedBalance<'_> {
    fn joint(&self) -> &Joint<'_> {
        &self.problem.joint
    }

    /// Log density that each run would have about the fit in the mean if it had not been seen, wet ones with its own spread: each
    /// parameter of the law gains one in the sum (Akaike). `None` where the fit did not converge.
    fn expected_log_densities(&self) -> Option<Vec<f64>> {
        let sd = self.fit.residual_sd.filter(|sd| *sd > 0.0 && self.fit.converged())?;
        let mut residuals = vec![0.0; self.problem.runs()];
        self.problem.residuals(&self.fit.parameters, &mut residuals).ok()?;
        let wet = self.joint().wet_rebounds();
        let gained = self.joint().shared.len() as f64 / residuals.len() as f64;
        for (run, residual) in residuals.iter_mut().enumerate() {
            // the scatter of dry runs is no form's own
            let (scale, ln_scale) = if run < wet { (sd, sd.ln()) } else { (self.spread, 0.0) };
            *residual = -0.5 * (*residual / scale).powi(2) - ln_scale - gained;
        }
        Some(residuals)
    }
}

/// A balance that was fitted, and its squares about the minimum: what estimates are made from.
struct BalanceEstimates<'f, 'r> {
    fitted: &'f FittedBalance<'r>,
    uncertain: Uncertain,
    quoting: Quoting,
    /// `None` where there is none, or no run can bend it
    profile: Option<ProblemProfile<'f>>,
}

impl<'f, 'r> BalanceEstimates<'f, 'r> {
    fn profile(fitted: &'f FittedBalance<'r>, quoting: Quoting) -> Option<ProblemProfile<'f>> {
        /// slopes of m(r) are at most 1/τ, and a run weighs at most as 1/τ² = 10⁴ others: it pins no fit of more runs
        const MOST_RUNS: usize = 50_000;
        /// runs times film groups: each limit of the quantities of a group reads all runs
        const MOST_READ: usize = 5_000_000;
        let joint = fitted.joint();
        let read = joint.wet_rebounds() * joint.runs.film_groups.len();
        if joint.measured_rebounds() > MOST_RUNS || read > MOST_READ {
            return None;
        }
        let region = Region::of(&fitted.fit, fitted.error_weights.as_ref(), quoting.level)?;
        let bias = fitted.error_weights.as_ref().map_or(&[][..], |weights| &weights.bias);
        let squares = move |b: &[f64]| {
            let mut there = b.to_vec();
            there.iter_mut().zip(bias).for_each(|(b, bias)| *b += bias);
            fitted.problem.sums_at(&fitted.roots, &there)
        };
        ProblemProfile::new(squares, region)
    }

    /// Estimate of a quantity that is a function of one parameter, by its place.
    fn of_parameter(&self, place: usize, of: impl Fn(f64) -> Jet<1>, quantity: Quantity) -> Estimate {
        let none = || self.quoting.none(why_stopped(&self.fitted.fit));
        if !self.fitted.fit.converged() {
            return none();
        }
        let of_point = |point: &[f64]| {
            let Jet { value, slopes } = of(point[place]);
            let mut gradient = vec![0.0; point.len()];
            gradient[place] = slopes[0];
            Some((value, gradient))
        };
        self.of(of_point, quantity).unwrap_or_else(none)
    }

    /// Estimate of a quantity that is a function of all parameters; `None` where it is not defined at the fit.
    fn of(&self, of: impl Fn(&[f64]) -> Option<WithSlopes>, quantity: Quantity) -> Option<Estimate> {
        let (value, slopes) = of(&self.fitted.fit.parameters)?;
        let estimate = self.quoting.of_function(&self.uncertain, value, &slopes, quantity);
        let limits = match quantity.describe().log {
            false => self.limits(of),
            true => {
                let log = |(value, slopes): WithSlopes| {
                    let slopes: Vec<f64> = slopes.iter().map(|slope| slope / value).collect();
                    (value.ln(), slopes)
                };
                let limits = self.limits(|point| of(point).map(log));
                limits.map(|limits| limits.map(|limit| Some(limit.exp()), true))
            }
        };
        Some(estimate.with_profile(limits))
    }

    /// The profile limits of a function of all parameters; `None` where the delta method agrees, or there is none.
    fn limits(&self, of: impl Fn(&[f64]) -> Option<WithSlopes>) -> Option<Limits> {
        let profile = self.profile.as_ref()?;
        if profile.is_straight(&of) {
            return None;
        }
        profile.limits(of)
    }
}

/// Fits the balance of this form, with the form of inertia `open` or not; `None` without wet runs of a sphere whose k is
/// known.
pub fn fit_balance(setup: FitSetup, scaling: &[Scaling], form: Form, open: bool) -> Option<EnergyBalance> {
    let FitSetup { scene, runs, dry } = setup;
    let known = spheres_with_known_k(runs, dry);
    if known.is_empty() {
        return None;
    }
    let pools: Vec<WetRuns> = scaling
        .iter()
        .filter(|fitted| fitted.law == WetLaw::Sqrt && fitted.film_ratio.is_some())
        .filter(|fitted| fitted.runs > 0 && known.binary_search(&fitted.sphere).is_ok())
        .map(|fitted| WetRuns::over_stokes(setup, &runs.series[fitted.series.clone()]))
        .collect();
    let separate: Vec<OwnLaw> = pools.iter().map(|pool| pool.own_law(WetLaw::Sqrt)).collect();
    let of_form = |inertia: Inertia| {
        let joint = Joint::new(scene, runs, Form { inertia, ..form }, &known, &known);
        fit_weighed(joint, dry, pooled_sd(&separate))
    };
    let (mut fitted, choice) = if open {
        choose_form(scene, of_form)
    } else {
        (of_form(form.inertia), None)
    };
    let joint = &fitted.problem.joint;
    let wet = joint.wet_parts().map(|part| part.rebounds.clone());
    if let Some(errors) = error_columns(scene, joint.runs, ParameterKind::SigmaWet, wet, None) {
        let in_errors = problem_of(joint.clone(), dry, 1.0);
        let (fit, error_weights) = reweight(&errors, fitted.fit, |_| in_errors.clone());
        fitted.fit = fit;
        if let Some(weights) = &error_weights {
            fitted.roots = weights.variance.iter().map(|v| v.sqrt().recip()).collect();
            fitted.roots.resize(in_errors.runs(), 1.0);
            (fitted.problem, fitted.spread) = (in_errors, 1.0);
        }
        fitted.error_weights = error_weights;
    }
    let lack_of_fit = lack_of_fit(setup, &fitted, &known, &separate);
    Some(findings_of(setup, &fitted, lack_of_fit, choice))
}

/// Holds this law for all against a square-root law for each particle and film ratio.
fn lack_of_fit(setup: FitSetup, fitted: &FittedBalance, known: &[usize], separate: &[OwnLaw]) -> Option<FTest> {
    let FitSetup { scene, runs, dry } = setup;
    // series with offsets of their own share no law as it stands
    if !fitted.fit.converged() || scene.model.series_offsets {
        return None;
    }
    // a film that is misstated by a few per cent moves no law of its group
    let at_groups = at_group_ratios(runs);
    let (joint, sticks_at) = (fitted.joint(), scene.data.smallest_restitution);
    let expected = joint.expected(&fitted.fit.parameters);
    one_against(
        joint.shared.len(),
        &expected,
        sticks_at,
        separate,
        |mut variance, scatter| {
            let at_groups = Joint::new(scene, &at_groups, joint.form, known, known);
            let problem = problem_of(at_groups, dry, scatter);
            variance.resize(problem.runs(), 1.0);
            chi_squared(&problem, &variance, &fitted.fit.parameters) - problem.own_squares()
        },
    )
}

/// The same runs, each with the film ratio of its group where that has one.
fn at_group_ratios(runs: &Runs) -> Runs {
    let mut own = runs.clone();
    for group in runs.film_groups.iter().filter(|group| group.has_one_film_ratio()) {
        for series in &runs.series[group.series.clone()] {
            own.impacts.film_ratio[series.rebounds.clone()].fill(group.film_ratio);
        }
    }
    own
}

/// What a fit says.
fn findings_of(
    setup: FitSetup,
    fitted: &FittedBalance,
    lack_of_fit: Option<FTest>,
    choice: Option<InertiaChoice>,
) -> EnergyBalance {
    let FitSetup { scene, runs, dry } = setup;
    let quoting = Quoting::of(scene);
    let joint = fitted.joint();
    let point = &fitted.fit.parameters;
    let estimates = BalanceEstimates {
        fitted,
        uncertain: uncertain(&fitted.fit),
        quoting,
        profile: BalanceEstimates::profile(fitted, quoting),
    };
    let parameter = |(place, kind): (usize, ParameterKind)| ParameterEstimate {
        kind,
        name: kind.name(scene, runs),
        estimate: estimates.of_parameter(
            place,
            |b| Jet::variable(b, 0),
            kind.quantity().unwrap_or(Quantity::DryK),
        ),
    };
    let parameters: Vec<ParameterEstimate> = joint.kinds().enumerate().map(parameter).collect();
    let places = WetPlace::all(runs, joint.form);
    let derived = places.par_iter().enumerate().filter(|_| fitted.fit.converged());
    let derived = derived.filter_map(|(index, place)| derive(scene, index, place, &estimates));
    // from that of its dry runs alone
    let shift_of_k = |own: &ParameterEstimate| {
        let (k, se) = dry::fit_of_sphere(dry, own.kind.sphere()?)?.usable?;
        let (value, joint_se) = own.estimate.value_and_scale()?;
        Some((value - k).abs() / se.hypot(joint_se))
    };
    let l = joint.value(Coefficient::LubricationLog, point);
    EnergyBalance {
        inertia: joint.form.inertia,
        viscous: joint.form.viscous,
        particles: particles_of(scene, joint),
        runs: joint.measured_rebounds(),
        delta_c_over_roughness: match l {
            Some(_) => {
                let quantity = Quantity::DeltaCOverRoughness;
                let of_l = |l: f64| {
                    let l = Jet::<1>::variable(l, 0);
                    quantity.value(&Place::NONE, &Wetted::of_balance(l.only_if(false), l))
                };
                estimates.of_parameter(0, of_l, quantity)
            }
            None => quoting.none(joint.form.viscous.why_no_critical_separation().unwrap_or(NO_VISCOUS)),
        },
        verdict: balance_verdict(&fitted.fit, l, lack_of_fit.as_ref(), scene.model.noise),
        dry_k_shift_in_se: parameters.iter().filter_map(shift_of_k).reduce(f64::max),
        parameters,
        derived: derived.collect(),
        residual_sd: fitted.fit.residual_sd,
        measurement_errors: fitted.error_weights.as_ref().map(|weights| weights.summary),
        lack_of_fit,
        stop: fitted.fit.stop.as_str(),
        choice,
        fitted_point: FittedPoint {
            form: joint.form,
            spread: fitted.spread,
            roots: fitted.roots.clone(),
            point: point.clone(),
        },
    }
}

/// The names of the particles of a fit.
fn particles_of(scene: &Scene, joint: &Joint) -> Vec<String> {
    let mut particles: Vec<usize> = joint.spheres.iter().map(|s| joint.runs.spheres[*s].particle).collect();
    particles.dedup();
    particles.iter().map(|p| scene.particles[*p].name.clone()).collect()
}

/// The spheres with wet rebounds and a usable k.
pub(super) fn spheres_with_known_k(runs: &Runs, fitted_dry: &[Dry]) -> Vec<usize> {
    let usable = fitted_dry.iter().filter(|fitted| fitted.usable.is_some());
    let spheres = usable.map(|fitted| fitted.sphere);
    spheres.filter(|sphere| rebounds(runs, *sphere)).collect()
}

/// Whether a sphere has wet rebounds.
pub(super) fn rebounds(runs: &Runs, sphere: usize) -> bool {
    runs.series_of(sphere).iter().any(|series| !series.rebounds.is_empty())
}

/// The least-squares problem of a joint fit in which dry runs weigh as much as their scatter, or their own errors, let
/// them beside wet runs of this spread.
pub(super) fn problem_of<'r>(joint: Joint<'r>, dry: &[Dry], spread: f64) -> JointFit<'r> {
    let rows = |sphere: usize| {
        let own = joint.dry_parts().filter(|part| part.sphere == sphere);
        own.map(|part| part.rebounds.len()).sum()
    };
    let roots = joint
        .dry_spheres()
        .into_iter()
        .filter_map(|sphere| Some((dry::fit_of_sphere(dry, sphere)?, rows(sphere))))
        .flat_map(|(fitted, rows)| fitted.variances(rows))
        .map(|variance| spread / variance.sqrt());
    let own_k = |sphere: &usize| {
        let usable = dry::fit_of_sphere(dry, *sphere).and_then(|own| own.usable);
        usable.map_or(f64::NAN, |(k, _)| k)
    };
    JointFit {
        dry_roots: roots.collect(),
        own_k: joint.spheres.iter().map(own_k).collect(),
        known: vec![],
        joint,
    }
}

/// Fits the balance, and again with its own spread where that is far below the one that weighed the dry runs: the separate
/// laws pool liquids, and where noise is small their misfit would hold k too fast and its error too small. Says at what
/// spread it ended.
fn fit_weighed<'r>(joint: Joint<'r>, dry: &[Dry], spread: f64) -> FittedBalance<'r> {
    /// a weight this near moves no standard error that matters
    const NEAR: f64 = 0.5;
    /// each time the spread is nearer by orders of magnitude
    const TRIES: usize = 8;
    let mut spread = spread;
    let mut problem = problem_of(joint, dry, spread);
    let mut fit = fit_joint(&problem);
    for _ in 0..TRIES {
        let own = fit.residual_sd.filter(|_| fit.converged());
        match own.filter(|own| *own > 0.0 && *own < NEAR * spread) {
            Some(own) => spread = own,
            None => break,
        }
        problem = problem_of(problem.joint, dry, spread);
        fit = fit_joint(&problem);
    }
    FittedBalance {
        problem,
        spread,
        fit,
        roots: vec![],
        error_weights: None,
    }
}

/// With the form left open: the one that the runs choose by the squares that each leaves.
fn choose_form<'r>(
    scene: &Scene,
    of_form: impl Fn(Inertia) -> FittedBalance<'r>,
) -> (FittedBalance<'r>, Option<InertiaChoice>) {
    let mut fits = Vec::from(Inertia::ALL.map(|inertia| (inertia, of_form(inertia))));
    let candidate = |(inertia, fitted): &(Inertia, FittedBalance)| {
        let joint = fitted.joint();
        let c = joint.value(Coefficient::InertialPrefactor, &fitted.fit.parameters);
        Some(Candidate {
            inertia: *inertia,
            log_densities: fitted.expected_log_densities()?,
            ln_prior: c.map_or(0.0, |c| ln_prior_of_prefactor(scene, joint.runs, joint.form, c)),
            untrusted: vec![],
        })
    };
    let candidates: Vec<Candidate> = fits.iter().filter_map(candidate).collect();
    // runs that do not tell the default form are no reason for one that knows less
    let choice = InertiaChoice::among(&candidates, ChosenBy::LeastSquares);
    let inertia = choice.as_ref().map_or(Inertia::DEFAULT, |choice| choice.inertia);
    let place = fits.iter().position(|(own, _)| *own == inertia).unwrap_or(0);
    (fits.swap_remove(place).1, choice)
}

/// What a joint fit's point says of a place.
pub(super) struct WetPlaceValues {
    /// ρ̃, mean over the rebounds
    pub density_ratio: f64,
    /// e_inf and L, with slopes in themselves; NaN where nothing is left for e_inf, or without a viscous loss
    wetted: Wetted<Jet<2>>,
    /// slopes of e_inf and of L in all parameters
    slopes: [Vec<f64>; 2],
}

impl WetPlaceValues {
    /// A quantity there; NaN where it is not defined.
    pub fn value(&self, quantity: Quantity) -> f64 {
        quantity.value(&Place::NONE, &self.wetted).value
    }

    /// The slopes of a quantity in all parameters.
    fn slopes(&self, quantity: Quantity) -> Vec<f64> {
        let [of_e_inf, of_l] = quantity.value(&Place::NONE, &self.wetted).slopes;
        let both = self.slopes[0].iter().zip(&self.slopes[1]);
        both.map(|(e_inf, l)| of_e_inf * e_inf + of_l * l).collect()
    }
}

/// `None` where the sphere is not in the fit.
pub(super) fn at_place(scene: &Scene, joint: &Joint, point: &[f64], wet: &WetPlace) -> Option<WetPlaceValues> {
    let place = joint.place(wet.sphere)?;
    let density_ratio = wet.density_ratio(scene);
    let parameters = joint.of_sphere(point[place], point);
    let at_film = BalanceAtFilm::new(joint.form, wet.film_ratio, &parameters.shared);
    let balance = Balance::at(joint.form, parameters.dry_k, at_film.share, density_ratio);
    let reference = scene.model.dry_speed.reference();
    let (_, of_k) = balance.e_inf_squared(reference);
    let (e_inf, has_viscous) = (balance.e_inf(reference), Term::Viscous.is_held(joint.form));
    let (mut of_e_inf, mut of_l) = (vec![0.0; point.len()], vec![0.0; point.len()]);
    of_e_inf[place] = 0.5 * of_k / e_inf;
    for (place, lost) in at_film.lost_slopes(&joint.form, density_ratio).enumerate() {
        of_e_inf[place] = -0.5 * lost.constant / e_inf;
        of_l[place] = lost.over_stokes;
    }
    let l = (balance.lost.over_stokes + wet.fixed_over_stokes(scene, joint.form)).only_if(has_viscous);
    Some(WetPlaceValues {
        density_ratio,
        wetted: Wetted::of_balance(Jet::variable(e_inf, 0), Jet::variable(l, 1)),
        slopes: [of_e_inf, of_l],
    })
}

/// e_inf and St_c of a place; `None` where none of its runs rebounded or nothing is left for e_inf.
fn derive(scene: &Scene, index: usize, place: &WetPlace, estimates: &BalanceEstimates) -> Option<DerivedEstimate> {
    let (fitted, quoting) = (estimates.fitted, estimates.quoting);
    if place.rebounds() == 0 {
        return None;
    }
    let joint = fitted.joint();
    let at = at_place(scene, joint, &fitted.fit.parameters, place)?;
    if !at.value(Quantity::EInf).is_finite() {
        return None;
    }
    let estimate = |quantity: Quantity| {
        let of = |point: &[f64]| {
            let at = at_place(scene, joint, point, place)?;
            let value = Some(at.value(quantity)).filter(|value| value.is_finite())?;
            Some((value, at.slopes(quantity)))
        };
        let found = estimates.of(of, quantity);
        found.unwrap_or_else(|| quoting.none(NO_VISCOUS))
    };
    let [of_e_inf, of_st_c] = [Quantity::EInf, Quantity::StC].map(|quantity| at.slopes(quantity));
    Some(DerivedEstimate {
        particle: scene.particles[place.particle].name.clone(),
        film_ratio: place.film_ratio,
        diameter_m: place.diameter,
        density_ratio: at.density_ratio,
        place: index,
        sphere: place.sphere,
        correlation: estimates
            .uncertain
            .correlation(&of_e_inf, &of_st_c)
            .filter(|_| at.value(Quantity::StC).is_finite()),
        estimates: QuantityEstimates::of([Quantity::EInf, Quantity::StC], estimate),
    })
}

/// Spread of the restitutions about the separate laws that could be fitted; 1 where they leave none, which holds k at
/// its dry fit.
fn pooled_sd(separate: &[OwnLaw]) -> f64 {
    let fits = separate.iter().map(|own| &own.fit);
    let fits = fits.filter(|fit| fit.residual_sum_of_squares.is_finite());
    let squares: f64 = fits.clone().map(|fit| fit.residual_sum_of_squares).sum();
    let freedom: usize = fits.map(|fit| fit.degrees_of_freedom).sum();
    if squares > 0.0 && freedom > 0 {
        (squares / freedom as f64).sqrt()
    } else {
        1.0
    }
}

fn balance_verdict(fit: &Fit, l: Option<f64>, misfit: Option<&FTest>, noise: NoiseOn) -> Verdict {
    if !fit.converged() || fit.covariance.is_err() {
        Verdict::failed(why_stopped(fit))
    } else if l.is_some_and(|l| l <= 0.0) {
        Verdict::failed("L is not positive: the restitution does not fall with 1/St")
    } else if noise == NoiseOn::Both {
        Verdict::failed("noise on the energy kept moves L and C, which only the posterior allows for")
    } else if let Some(test) = misfit.filter(|test| test.p < MISFIT) {
        Verdict::failed(format!(
            "one law does not describe all particles and film ratios (lack of fit, {})",
            f_words(test, 3)
        ))
    } else {
        Verdict::passed("converged")
    }
}

/// Fits the square-root law to the noise-free balance at the runs of each film ratio.
///
/// Liquids differ in ρ̃, and so in the inertial loss that the law takes as one; what it then gets wrong is its bias, which
/// stays unknown for spheres outside the balance and where that did not converge.
pub(super) fn add_bias_of_pooling(setup: FitSetup, scaling: &mut [Scaling], balance: &EnergyBalance) {
    if balance.stop != Stop::Converged.as_str() {
        return;
    }
    let FitSetup { scene, runs, dry } = setup;
    let known = spheres_with_known_k(runs, dry);
    let (joint, point) = (
        Joint::new(scene, runs, balance.fitted_point.form, &known, &[]),
        &balance.fitted_point.point,
    );
    // of each rebound, by its place among the runs
    let mut exact = vec![0.0; runs.len()];
    for part in joint.wet_parts() {
        joint.each(part, part.rebounds.clone(), point, |row| exact[row.run] = row.model);
    }
    let fitted = |row: &&mut Scaling| row.law == WetLaw::Sqrt && !row.is_withheld;
    for row in scaling.iter_mut().filter(fitted) {
        let mut groups = runs.film_groups_of(row.sphere).iter();
        let group = groups.find(|group| Some(group.film_ratio) == row.film_ratio);
        let place = group.map(|group| WetPlace::of_group(runs, group));
        let Some(at) = place.and_then(|place| at_place(scene, &joint, point, &place)) else {
            continue;
        };
        let both = [Quantity::EInf, Quantity::StC].map(|quantity| at.value(quantity));
        if both.iter().all(|x| x.is_finite()) {
            let series = &runs.series[row.series.clone()];
            let exact = series.iter().flat_map(|one| &exact[one.rebounds.clone()]);
            let exact: Vec<f64> = exact.copied().collect();
            // where the balance keeps no energy, the law is not defined and no run would have rebounded
            let fit = WetRuns::over_stokes(setup, series).refitted(WetLaw::Sqrt, &exact, |run| exact[run] > 0.0);
            row.bias = e_inf_and_st_c(WetLaw::Sqrt, two(&fit)).map(|of_law| Bias::of(of_law, both));
        }
    }
}
