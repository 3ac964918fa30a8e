//! Reads the truth and the design of a simulation.

use super::choices::{dry_speed, terms, viscous, ModelChoices};
use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE, NOT_NEGATIVE};
use super::materials::Liquid;
use super::table::{Located, SceneTable};
use crate::physics::balance::Balance;
use crate::physics::coefficient::Coefficients;
use crate::physics::form::Term;
use crate::physics::loss::Film;
use crate::physics::quantity::Wetted;
use crate::physics::{numbers, Coefficient, DrySpeed, Form, Inertia, Parameters, Quantity, Viscous};
use crate::units::Dimension;

/// The parameters simulated runs are drawn from. What a file leaves out is missed only when runs are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// k of each of the scene's particles; absent where the table names none
    pub dry_k: Vec<Option<f64>>,
    /// the parameters that particles share, in the order of [`Coefficient::ALL`]
    pub shared: [Option<f64>; Coefficient::COUNT],
    /// form of the inertial loss
    pub inertia: Inertia,
    /// form of the viscous loss where it is held
    pub viscous: Viscous,
    /// the speed at which e_dry enters
    pub dry_speed: DrySpeed,
    /// sd of the noise on a dry restitution
    pub sigma_dry: Option<f64>,
    /// sd of the noise on a wet restitution
    pub sigma_wet: Option<f64>,
    /// sd of the noise on the energy a wet run keeps; absent: none
    pub sigma_energy: Option<f64>,
    /// degrees of freedom of Student's noise
    pub nu: Option<f64>,
    /// shape of the noise on wet runs
    pub noise: NoiseShape,
    /// the terms the truth holds; absent: the inertial and the viscous loss
    pub terms: Option<Vec<Term>>,
}

impl Truth {
    /// The value of a parameter that particles share.
    pub fn value(&self, coefficient: Coefficient) -> Option<f64> {
        self.shared[coefficient as usize]
    }

    /// The value of a parameter, or of δc/ε that follows from one; `None` where the truth does not name it.
    pub fn of_quantity(&self, quantity: Quantity, particle: usize) -> Option<f64> {
        match quantity {
            Quantity::DryK => self.dry_k.get(particle).copied().flatten(),
            Quantity::Shared(coefficient) => self.value(coefficient).filter(|_| self.form().has(coefficient)),
            Quantity::DeltaCOverRoughness => self
                .of_quantity(Quantity::Shared(Coefficient::LubricationLog), 0)
                .map(f64::exp),
            _ => None,
        }
    }

    /// What holds at infinite speed of a particle at a film, with e_dry at a reference speed; `None` where the truth lacks a
    /// number, or where it depends on the diameter.
    pub fn wetted(&self, particle: usize, film: Film, reference_speed: f64) -> Option<Wetted<f64>> {
        let form = self.form();
        let complete = form.coefficients().all(|coefficient| self.value(coefficient).is_some());
        if form.viscous.tells_diameters_apart() || !complete {
            return None;
        }
        let parameters = Parameters {
            dry_k: self.dry_k.get(particle).copied().flatten()?,
            shared: Coefficients::first_of(&self.shared.map(|value| value.unwrap_or(f64::NAN))),
        };
        let balance = Balance::new(form, film, &parameters);
        Some(Wetted::of_balance(
            balance.e_inf(reference_speed),
            balance.lost.over_stokes,
        ))
    }

    /// The form of the truth's energy balance.
    pub fn form(&self) -> Form {
        let usual = Form {
            viscous: self.viscous,
            ..Form::new(self.inertia, self.dry_speed)
        };
        self.terms.as_deref().map_or(usual, |terms| usual.with_terms(terms))
    }
}

/// Shape of the noise on a simulated restitution; each has the truth's sd, or varies about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseShape {
    /// normal
    Normal,
    /// one minus an exponential: mean 0, sd 1, a long tail towards low restitutions
    Skewed,
    /// normal, its sd growing with 1/St: sd · (1/2 + 25/St)
    Heteroscedastic,
    /// Student's t with the truth's `nu`, on dry runs as well; 68.3 % of it within the sd, as of the normal
    Student,
}

/// The settings simulated runs are made at.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// diameters of each particle, m; empty where the table names none
    pub diameters: Vec<Vec<f64>>,
    /// indices into the scene's liquids
    pub liquids: Vec<usize>,
    /// film ratios of each particle
    pub film_ratios: Vec<Vec<f64>>,
    /// impact speeds of the wet runs
    pub speeds: DesignSpeeds,
    /// impact speeds of the dry runs, m/s
    pub dry_speeds: Vec<f64>,
    /// runs at each setting
    pub repeats: u64,
}

/// Impact speeds of a design, m/s.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignSpeeds(pub Vec<f64>);

pub(super) fn truth(root: &SceneTable, particles: &[&str], liquids: &[Liquid], model: &ModelChoices) -> Option<Truth> {
    let table = root.table("truth")?;
    let by_particle = table.table("dry_k");
    let dry_k = particles
        .iter()
        .map(|name| by_particle.as_ref().and_then(|ks| ks.number(name, NOT_NEGATIVE)))
        .collect();
    if let Some(by_particle) = by_particle {
        by_particle.finish();
    }
    let forms = Inertia::ALL.map(|form| (form.name(), form));
    let inertia = table
        .choice("inertia", &forms)
        .or(model.inertia)
        .unwrap_or(Inertia::DEFAULT);
    let noises = [
        ("normal", NoiseShape::Normal),
        ("skewed", NoiseShape::Skewed),
        ("heteroscedastic", NoiseShape::Heteroscedastic),
        ("student", NoiseShape::Student),
    ];
    let truth = Truth {
        dry_k,
        shared: Coefficient::ALL.map(|coefficient| {
            let own = coefficient.describe();
            table.number(own.name, if own.must_be_positive { ABOVE_ZERO } else { FINITE })
        }),
        inertia,
        viscous: viscous(&table).unwrap_or(model.viscous),
        dry_speed: dry_speed(&table).unwrap_or(model.dry_speed),
        sigma_dry: table.number("sigma_dry", NOT_NEGATIVE),
        sigma_wet: table.number("sigma_wet", NOT_NEGATIVE),
        sigma_energy: table.number("sigma_energy", NOT_NEGATIVE),
        nu: table.number("nu", ABOVE_ZERO),
        noise: table.choice("noise", &noises).unwrap_or(NoiseShape::Normal),
        terms: terms(&table, liquids),
    };
    table.finish();
    Some(truth)
}

pub(super) fn design(root: &SceneTable, particles: &[&str], liquids: &[Liquid]) -> Option<Design> {
    let table = root.table("design")?;
    let diameters = table.quantities_by_name("diameter", Dimension::Length, ABOVE_ZERO, particles);
    let film_ratios = table.quantities_by_name("film_ratio", Dimension::One, FILM_RATIO, particles);
    let mut used = vec![];
    for name in table.texts("liquids").unwrap_or_default() {
        match liquids.iter().position(|liquid| liquid.name == name.value) {
            Some(liquid) => used.push(liquid),
            None => {
                let names = liquids.iter().map(|liquid| liquid.name.as_str());
                let name = Located {
                    value: name.value.as_str(),
                    at: name.at,
                };
                table.refuse_name("liquids", &name, "a name in [liquids]", names);
            }
        }
    }
    let heights = table.quantities("height", Dimension::Length, ABOVE_ZERO);
    let speeds = table.quantities("impact_speed", Dimension::Speed, ABOVE_ZERO);
    if heights.is_some() && speeds.is_some() {
        let at = table.at("");
        table.refuse("", at, None, "expected either drop heights or impact speeds, not both");
    }
    let fallen = heights.map(|hs| hs.into_iter().map(numbers::free_fall_speed).collect());
    let design = Design {
        diameters: diameters.unwrap_or_else(|| vec![vec![]; particles.len()]),
        liquids: used,
        film_ratios: film_ratios.unwrap_or_else(|| vec![vec![]; particles.len()]),
        speeds: DesignSpeeds(fallen.or(speeds).unwrap_or_default()),
        dry_speeds: table
            .quantities("dry_impact_speed", Dimension::Speed, ABOVE_ZERO)
            .unwrap_or_default(),
        repeats: table.count("repeats", 1).unwrap_or(1),
    };
    table.finish();
    Some(design)
}
