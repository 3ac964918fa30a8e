//! Reads the truth and the design of a simulation.

use super::choices::{
    checked_terms, checked_viscous, dry_speed, dry_speeds, some_terms, viscous_forms, LikelihoodFamily, ModelChoices,
    SceneParameter, SIGMA_DRY, SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET,
};
use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE, NOT_NEGATIVE, SHARE};
use super::materials::{Liquid, Particle};
use super::naming::SceneNames;
use super::table::values::{count, number, one_of, texts, MOST_COUNTED};
use super::table::SceneTable;
use crate::physics::balance::Balance;
use crate::physics::coefficient::Coefficients;
use crate::physics::dry::DRY_K;
use crate::physics::loss::Film;
use crate::physics::numbers::same_diameter;
use crate::physics::quantity::Wetted;
use crate::physics::{numbers, Coefficient, Form, Inertia, Parameters, Quantity};
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
    /// the energy balance: the inertial and the viscous loss, or the terms that the table names
    pub form: Form,
    /// sd of the noise on a dry restitution
    pub sigma_dry: Option<f64>,
    /// sd of the noise on a wet restitution
    pub sigma_wet: Option<f64>,
    /// sd of the noise on the energy a wet run keeps; absent: none
    pub sigma_energy: Option<f64>,
    /// sd of the offset of the energy kept that the wet runs of a series share; absent: none
    pub sigma_series: Option<f64>,
    /// shape of the noise's family
    pub shape: Option<f64>,
    /// shape of the noise on wet runs
    pub noise: NoiseShape,
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
            Quantity::Shared(coefficient) => self.value(coefficient).filter(|_| self.form.has(coefficient)),
            Quantity::DeltaCOverRoughness => self
                .of_quantity(Quantity::Shared(Coefficient::LubricationLog))
                .map(f64::exp),
            _ => None,
        }
    }

    /// What holds at infinite speed of a sphere of this k at a film, with e_dry at a reference speed; `None` where the truth
    /// lacks a number, or where its viscous loss belongs to a diameter.
    pub fn wetted(&self, dry_k: f64, film: Film, reference_speed: f64) -> Option<Wetted<f64>> {
        let complete = self.form.coefficients().all(|own| self.value(own).is_some());
        if self.form.viscous.tells_diameters_apart() || !complete {
            return None;
        }
        let parameters = Parameters {
            dry_k,
            shared: Coefficients::first_of(&self.shared.map(|value| value.unwrap_or(f64::NAN))),
        };
        let balance = Balance::new(self.form, film, &parameters);
        Some(Wetted::of_balance(
            balance.e_inf(reference_speed),
            balance.lost.over_stokes,
        ))
    }
}

/// Shape of the noise on a simulated restitution; each has the truth's sd, or varies about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseShape {
    /// of a family that the model may have, on dry runs as well
    Family(LikelihoodFamily),
    /// one minus an exponential: mean 0, sd 1, a long tail towards low restitutions
    Skewed,
    /// normal, its sd growing with 1/St: sd · (1/2 + 25/St)
    Heteroscedastic,
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
    /// impact speeds of the wet runs, m/s
    pub speeds: Vec<f64>,
    /// impact speeds of the dry runs, m/s
    pub dry_speeds: Vec<f64>,
    /// sd of the logarithm of the wet runs' own films about that of their setting; absent: the film of the setting
    pub film_rel_sd: Option<f64>,
    /// the same of the runs' own impact speeds, dry runs' too
    pub impact_speed_rel_sd: Option<f64>,
    /// runs at each setting
    pub repeats: u64,
}

pub(super) fn truth(
    table: &SceneTable,
    names: &[String],
    (particles, liquids): (&[Particle], &[Liquid]),
    model: &ModelChoices,
) -> Truth {
    let (dry_k, dry_k_by_diameter) = true_k(table, names);
    let shared = Coefficient::ALL.map(|coefficient| {
        let own = coefficient.describe();
        table.read(own.name, number(if own.must_be_positive { ABOVE_ZERO } else { FINITE }))
    });
    let forms = Inertia::ALL.map(|form| (form.name(), form));
    let inertia = table.read("inertia", one_of(forms)).or(model.inertia);
    let viscous = table.read("viscous", viscous_forms());
    let viscous = viscous.map(|form| checked_viscous(table, form, particles));
    let terms = table.read("terms", some_terms()).flatten();
    let as_model = ModelChoices {
        inertia,
        viscous: viscous.unwrap_or(model.viscous),
        terms: checked_terms(table, terms, liquids),
        dry_speed: table.read("dry_speed", dry_speeds()).map_or(model.dry_speed, dry_speed),
        ..model.clone()
    };
    let spread = |own: &SceneParameter| table.read(own.name, number(NOT_NEGATIVE));
    let families = LikelihoodFamily::NAMED.map(|(name, family)| (name, NoiseShape::Family(family)));
    let others = [
        ("skewed", NoiseShape::Skewed),
        ("heteroscedastic", NoiseShape::Heteroscedastic),
    ];
    let shapes: Vec<_> = families.into_iter().chain(others).collect();
    let mut truth = Truth {
        dry_k,
        dry_k_by_diameter,
        shared,
        form: as_model.form(),
        sigma_dry: spread(&SIGMA_DRY),
        sigma_wet: spread(&SIGMA_WET),
        sigma_energy: spread(&SIGMA_ENERGY),
        sigma_series: spread(&SIGMA_SERIES),
        noise: table.read_or("noise", one_of(shapes), NoiseShape::Family(LikelihoodFamily::Normal)),
        shape: None,
    };
    for (_, family) in LikelihoodFamily::NAMED {
        let Some(own) = family.shape() else {
            continue;
        };
        let expect = if own.least < 0.0 { FINITE } else { ABOVE_ZERO };
        let value = table.read(own.name, number(expect));
        if truth.noise == NoiseShape::Family(family) {
            truth.shape = value;
        }
    }
    table.finish();
    truth
}

/// k of each particle, as [`Truth`] has it: one for every diameter, or where the file has a table of them by diameter, each
/// of these.
fn true_k(table: &SceneTable, particles: &[String]) -> (Vec<Option<f64>>, Vec<Vec<KOfDiameter>>) {
    let (mut of_all, mut of_each) = (vec![None; particles.len()], vec![vec![]; particles.len()]);
    let takes = "a table of particles, each with a number of 0 or more or a table by diameter in mm";
    let Some(by_particle) = table.inner_table(DRY_K.name, takes) else {
        return (of_all, of_each);
    };
    for (particle, name) in particles.iter().enumerate() {
        if !by_particle.holds_table(name) {
            of_all[particle] = by_particle.number(name, NOT_NEGATIVE);
        } else if let Some(table) = by_particle.table(name) {
            of_each[particle] = by_diameter(&table);
        }
    }
    by_particle.finish();
    (of_all, of_each)
}

/// The k of a table whose keys are diameters in mm.
fn by_diameter(table: &SceneTable) -> Vec<KOfDiameter> {
    table.each(|key, before: &[KOfDiameter]| {
        let in_mm = key.parse::<f64>().ok().filter(|mm| (ABOVE_ZERO.holds)(*mm));
        // without quotes TOML takes the point of 4.762 for a table in a table
        let in_quotes = !table.holds_table(&key);
        let Some(diameter) = in_mm.filter(|_| in_quotes).map(|mm| Dimension::Length.usual_to_si(mm)) else {
            table.refuse_key(&key, "expected diameters in mm, in quotes: { \"4.762\" = 0.18 }");
            return None;
        };
        let dry_k = table.number(&key, NOT_NEGATIVE);
        if before.iter().any(|other| same_diameter(other.diameter, diameter)) {
            table.refuse_key(&key, "expected diameters that differ by more than 0.1 %");
        }
        let dry_k = dry_k?;
        Some(KOfDiameter { diameter, dry_k })
    })
}

pub(super) fn design(table: &SceneTable, names: &SceneNames) -> Design {
    let diameters = table.by_particle("diameter", Dimension::Length, ABOVE_ZERO, &names.particles);
    let liquids = table.read("liquids", texts()).unwrap_or_default();
    let of_name =
        |(name, at): &(String, usize)| table.place_of("liquids", (name, *at), "a name in [liquids]", &names.liquids);
    let liquids = liquids.iter().filter_map(of_name).collect();
    let film_ratios = table.by_particle("film_ratio", Dimension::One, FILM_RATIO, &names.particles);
    let heights = table.list("height", Dimension::Length, ABOVE_ZERO);
    let speeds = table.list("impact_speed", Dimension::Speed, ABOVE_ZERO);
    if heights.is_some() && speeds.is_some() {
        let at = table.at("");
        table.refuse("", at, None, "expected either drop heights or impact speeds, not both");
    }
    let dry_speeds = table.list("dry_impact_speed", Dimension::Speed, ABOVE_ZERO);
    let fallen = heights.map(|hs| hs.into_iter().map(numbers::free_fall_speed).collect());
    let design = Design {
        diameters,
        liquids,
        film_ratios,
        speeds: fallen.or(speeds).unwrap_or_default(),
        dry_speeds: dry_speeds.unwrap_or_default(),
        film_rel_sd: table.read("film_rel_sd", number(SHARE)),
        impact_speed_rel_sd: table.read("impact_speed_rel_sd", number(SHARE)),
        repeats: table.read_or("repeats", count(1, MOST_COUNTED), 1),
    };
    table.finish();
    design
}
