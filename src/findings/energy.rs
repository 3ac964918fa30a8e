//! Estimates where the energy went: the inertial loss over the density ratio, St_c·e_inf² and δc, by both laws.

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::Serialize;

use super::dry;
use super::estimate::{Estimate, Quoting};
use super::places::WetPlace;
use super::quantities::{variables, wetted_of, FittedLaw, PARAMETERS};
use super::scaling::{Scaling, NO_FALL};
use super::wet_fit::FitSetup;
use crate::inference::delta::Uncertain;
use crate::physics::inertia::Inertia;
use crate::physics::jet::Jet;
use crate::physics::quantity::{Place, Quantity};
use crate::scene::{Scene, WetLaw};

/// The energy balance of one particle, or one diameter of it, at one film ratio, by one law.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Energy {
    /// name of the particle
    pub particle: String,
    /// D, m, where each diameter has a k of its own
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// film ratio
    pub film_ratio: f64,
    /// `linear` or `sqrt`
    pub law: WetLaw,
    /// ρ̃, mean over the rebounds used
    pub density_ratio: f64,
    /// (e_dry² − e_inf²)/ρ̃ at the reference dry speed
    #[serde(skip)]
    pub loss_over_density_ratio: Estimate,
    /// eq. Eint2 at this film ratio
    pub stepwise: f64,
    /// eq. Eint1 at this film ratio; `None` beyond 0.39, where it falls
    pub cap: Option<f64>,
    /// St_c e_inf² = 2 L
    #[serde(skip)]
    pub st_c_e_inf2: Estimate,
    /// δc = ε exp(L), m
    #[serde(skip)]
    pub delta_c_m: Estimate,
}

impl Energy {
    /// The estimates that replicates give an interval, with their quantities.
    pub(super) fn resampled_mut(&mut self) -> [(Quantity, &mut Estimate); 3] {
        [
            (Quantity::InertialLoss, &mut self.loss_over_density_ratio),
            (Quantity::StCEInf2, &mut self.st_c_e_inf2),
            (Quantity::DeltaC, &mut self.delta_c_m),
        ]
    }
}

/// The energy table, in the order of the scaling table.
pub fn estimate_energy(setup: FitSetup, scaling: &[Scaling]) -> Vec<Energy> {
    scaling.iter().filter_map(|fitted| energy_of(setup, fitted)).collect()
}

fn energy_of(setup: FitSetup, fitted: &Scaling) -> Option<Energy> {
    let FitSetup { scene, runs, .. } = setup;
    let quoting = Quoting::of(scene);
    let film_ratio = fitted.film_ratio?;
    let mut groups = runs.film_groups_of(fitted.sphere).iter();
    let place = WetPlace::of_group(runs, groups.find(|group| group.film_ratio == film_ratio)?);
    let at = Place {
        roughness: scene.particles[place.particle].roughness,
        density_ratio: place.density_ratio(scene),
    };
    let why_no_delta_c = scene.model.viscous.why_no_critical_separation().map(str::to_owned);
    let why_no_delta_c = why_no_delta_c.or_else(|| scene.why_no_roughness([place.particle]));
    let why_no_l = fitted.lubrication_log.why_none.clone();
    let source = FittedLaw {
        why_none: why_no_l.filter(|_| fitted.lubrication_log.value.is_none()),
        ..fitted.law_fit.source([NO_FALL; 2])
    };
    let cap = Inertia::Cap;
    Some(Energy {
        particle: fitted.particle.clone(),
        diameter_m: fitted.diameter_m,
        film_ratio,
        law: fitted.law,
        density_ratio: at.density_ratio,
        loss_over_density_ratio: inertial_loss(setup, fitted, &at),
        stepwise: Inertia::Stepwise.shape(film_ratio, 1.0),
        cap: (film_ratio <= cap.valid_to()).then(|| cap.shape(film_ratio, 1.0)),
        st_c_e_inf2: source.estimate(Quantity::StCEInf2, &at),
        delta_c_m: match why_no_delta_c {
            Some(why) => quoting.none(why),
            None => source.estimate(Quantity::DeltaC, &at),
        },
    })
}

/// (e_dry² − e_inf²)/ρ̃ with the uncertainties of k and of the fit, and what they share.
fn inertial_loss(FitSetup { scene, dry, .. }: FitSetup, fitted: &Scaling, at: &Place) -> Estimate {
    let quoting = Quoting::of(scene);
    let usable = dry::fit_of_sphere(dry, fitted.sphere).and_then(|dry| dry.usable);
    let Some((k, k_se)) = usable else {
        return quoting.none("the particle has no usable dry runs, so e_dry is not known");
    };
    let e_inf = &fitted.e_inf;
    let (Some(_), Some(parameters)) = (e_inf.value, fitted.parameters) else {
        return quoting.none(e_inf.why_none.clone().unwrap_or_default());
    };
    let e_dry = e_dry(scene, k);
    if e_dry.value <= 0.0 {
        return quoting.none("e_dry is not positive at the reference speed");
    }
    let (shared, own) = (fitted.law_fit.shift_by_dry_k, &fitted.law_fit.uncertain);
    let of_k = k_se * k_se;
    let with_k = |covariance: &DMatrix<f64>| {
        DMatrix::from_fn(PARAMETERS, PARAMETERS, |i, j| match (i, j) {
            (0 | 1, 0 | 1) => covariance[(i, j)],
            (2, 2) => of_k,
            (2, other) | (other, _) => shared[other] * of_k,
        })
    };
    let source = FittedLaw {
        wetted: wetted_of(fitted.law, variables(parameters)).with_e_dry(e_dry),
        uncertain: &Uncertain {
            covariance: own.covariance.as_ref().map(with_k).map_err(Clone::clone),
            degrees_of_freedom: own.degrees_of_freedom,
        },
        why_none: None,
        ..fitted.law_fit.source([NO_FALL; 2])
    };
    source.estimate(Quantity::InertialLoss, at)
}

/// e_dry at the speed at which e_inf is quoted, with its slope in k.
fn e_dry(scene: &Scene, k: f64) -> Jet<PARAMETERS> {
    let (law, v) = (scene.model.form().dry, scene.model.dry_speed.reference());
    let mut slopes = [0.0; PARAMETERS];
    slopes[2] = law.slope_dry_k(k, v);
    Jet {
        value: law.restitution(k, v),
        slopes,
    }
}
