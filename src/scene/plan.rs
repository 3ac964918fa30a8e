//! Reads the truth and the design of a simulation.

use super::choices::{dry_speed, terms, viscous, ModelChoices};
use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE, NOT_NEGATIVE};
use super::materials::Liquid;
use super::table::{Located, SceneTable};
use crate::physics::balance::Balance;
use crate::physics::coefficient::Coefficients;
use crate::physics::form::Term;
use crate::physics::loss::Film;
use crate::physics::numbers::same_diameter;
use crate::physics::quantity::Wetted;
use crate::physics::{numbers, Coefficient, DrySpeed, Form, Inertia, Parameters, Quantity, Viscous};
use crate::units::Dimension;

/// The parameters simulated runs are drawn from. What a file leaves out is missed only when runs are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// k of each of the scene's particles at every diameter; absent where the table names none
    pub dry_k: Vec<Option<f64>>,
    /// k of each of the scene's particles by diameter; empty where the table names none
    pub dry_k_by_diameter: Vec<Vec<KOfDiameter>>,
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
    /// sd of the offset of the energy kept that the wet runs of a series share; absent: none
    pub sigma_series: Option<f64>,
    /// degrees of freedom of Student's noise
    pub nu: Option<f64>,
    /// shape of the noise on wet runs
    pub noise: NoiseShape,
    /// the terms the truth holds; absent: the inertial and the viscous loss
    pub terms: Option<Vec<Term>>,
}

/// k of a particle at one diameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KOfDiameter {
    /// D, m
    pub diameter: f64,
    /// k, (m/s)^(-1/5)
    pub dry_k: f64,
}

impl Truth {
    /// k of a particle at a diameter, m; `None` where the table names none.
    pub fn k(&self, particle: usize, diameter: f64) -> Option<f64> {
        let mut each = self.dry_k_by_diameter[particle].iter();
        let own = each.find(|own| same_diameter(own.diameter, diameter));
        own.map(|own| own.dry_k).or(self.dry_k[particle])
    }

    /// The value of a parameter that particles share.
    pub fn value(&self, coefficient: Coefficient) -> Option<f64> {
        self.shared[coefficient as usize]
    }

    /// The value of a parameter that particles share, or of δc/ε that follows from one; `None` where the truth does not name
    /// it.
    pub fn of_quantity(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Shared(coefficient) => self.value(coefficient).filter(|_| self.form().has(coefficient)),
            Quantity::DeltaCOverRoughness => self
                .of_quantity(Quantity::Shared(Coefficient::LubricationLog))
                .map(f64::exp),
            _ => None,
        }
    }

    /// What holds at infinite speed of a sphere of this k at a film, with e_dry at a reference speed; `None` where the truth
    /// lacks a number, or where its viscous loss belongs to a diameter.
    pub fn wetted(&self, dry_k: f64, film: Film, reference_speed: f64) -> Option<Wetted<f64>> {
        let form = self.form();
        let complete = form.coefficients().all(|coefficient| self.value(coefficient).is_some());
        if form.viscous.tells_diameters_apart() || !complete {
            return None;
        }
        let parameters = Parameters {
            dry_k,
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
    let TrueK {
        dry_k,
        dry_k_by_diameter,
    } = true_k(&table, particles);
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
        dry_k_by_diameter,
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
        sigma_series: table.number("sigma_series", NOT_NEGATIVE),
        nu: table.number("nu", ABOVE_ZERO),
        noise: table.choice("noise", &noises).unwrap_or(NoiseShape::Normal),
        terms: terms(&table, liquids),
    };
    table.finish();
    Some(truth)
}

/// k of each particle, as [`Truth`] has it.
struct TrueK {
    dry_k: Vec<Option<f64>>,
    dry_k_by_diameter: Vec<Vec<KOfDiameter>>,
}

/// k of each particle: one for every diameter, or where the file has a table of them by diameter, each of these.
fn true_k(table: &SceneTable, particles: &[&str]) -> TrueK {
    let mut found = TrueK {
        dry_k: vec![None; particles.len()],
        dry_k_by_diameter: vec![vec![]; particles.len()],
    };
    let Some(by_particle) = table.table("dry_k") else {
        return found;
    };
    for (particle, name) in particles.iter().enumerate() {
        if !by_particle.holds_table(name) {
            found.dry_k[particle] = by_particle.number(name, NOT_NEGATIVE);
        } else if let Some(table) = by_particle.table(name) {
            found.dry_k_by_diameter[particle] = by_diameter(&table);
        }
    }
    by_particle.finish();
    found
}

/// The k of a table whose keys are diameters in mm.
fn by_diameter(table: &SceneTable) -> Vec<KOfDiameter> {
    let mut all: Vec<KOfDiameter> = vec![];
    for key in table.keys() {
        let in_mm = key.parse::<f64>().ok().filter(|mm| (ABOVE_ZERO.holds)(*mm));
        // without quotes TOML takes the point of 4.762 for a table in a table
        let in_quotes = !table.holds_table(&key);
        let Some(diameter) = in_mm.filter(|_| in_quotes).map(|mm| Dimension::Length.usual_to_si(mm)) else {
            let expected = "expected diameters in mm, in quotes: { \"4.762\" = 0.18 }";
            table.refuse_key(&key, expected);
            continue;
        };
        let dry_k = table.number(&key, NOT_NEGATIVE);
        if all.iter().any(|other| same_diameter(other.diameter, diameter)) {
            let expected = "expected diameters that differ by more than 0.1 %";
            table.refuse(&key, table.at(&key), None, expected);
        }
        all.extend(dry_k.map(|dry_k| KOfDiameter { diameter, dry_k }));
    }
    table.finish();
    all
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
