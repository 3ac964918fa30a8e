//! Reads the kinds of particles and the liquids of a scene.

use super::expect::{ABOVE_ZERO, SHARE};
use super::keys::{Key, Section};
use super::names::{name_is_allowed, DRY, MISSING, NAME_RULE};
use super::table::{read_nothing, Number, SceneTable};
use crate::error::quoted;
use crate::units::Dimension;

/// A kind of particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    /// its name in the runs
    pub name: String,
    /// ρp, kg/m³
    pub density: f64,
    /// sd of ρp over ρp; absent: taken as exact
    pub density_rel_sd: Option<f64>,
    /// ε, m; absent: there is no δc in metres
    pub roughness: Option<f64>,
    /// sd of ε over ε; absent: taken as exact
    pub roughness_rel_sd: Option<f64>,
}

/// A liquid.
#[derive(Debug, Clone, PartialEq)]
pub struct Liquid {
    /// its name in the runs
    pub name: String,
    /// ρl, kg/m³
    pub density: f64,
    /// sd of ρl over ρl; absent: taken as exact
    pub density_rel_sd: Option<f64>,
    /// η, Pa s
    pub viscosity: f64,
    /// sd of η over η; absent: taken as exact
    pub viscosity_rel_sd: Option<f64>,
    /// γ, N/m
    pub surface_tension: Option<f64>,
}

/// What the tables of particles stand under.
pub(super) const PARTICLES: &str = "particles";
/// What the tables of liquids stand under.
pub(super) const LIQUIDS: &str = "liquids";

const PARTICLE_DENSITY: Key<Number> = Key::of("density", Dimension::Density, Number(ABOVE_ZERO))
    .means("density ρp of the sphere")
    .example("2150");

const DENSITY_REL_SD: Key<Number> = Key::new("density_rel_sd", Number(SHARE))
    .means("sd of the density over its value")
    .example("0.005")
    .optional("taken as exact");

const ROUGHNESS: Key<Number> = Key::of("roughness", Dimension::Thickness, Number(ABOVE_ZERO))
    .means("roughness ε of its surface")
    .example("5")
    .optional("there is no δc in metres, nor viscous = \"film\"");

const ROUGHNESS_REL_SD: Key<Number> = Key::new("roughness_rel_sd", Number(SHARE))
    .means("sd of the roughness over its value")
    .example("0.3")
    .optional("taken as exact");

const LIQUID_DENSITY: Key<Number> = Key::of("density", Dimension::Density, Number(ABOVE_ZERO))
    .means("density ρl")
    .example("930");

const VISCOSITY: Key<Number> = Key::of("viscosity", Dimension::Viscosity, Number(ABOVE_ZERO))
    .means("dynamic viscosity η")
    .example("9.3");

const VISCOSITY_REL_SD: Key<Number> = Key::new("viscosity_rel_sd", Number(SHARE))
    .means("sd of the viscosity over its value")
    .example("0.02")
    .optional("taken as exact");

const SURFACE_TENSION: Key<Number> = Key::of("surface_tension", Dimension::SurfaceTension, Number(ABOVE_ZERO))
    .means("surface tension γ")
    .example("20.1")
    .optional("the bridge's rupture is neither sized nor modelled");

/// What is to be said of the tables of particles and liquids.
pub(super) fn guide() -> [Section; 2] {
    let (_, of_particle) = read_nothing(|table| particle(String::new(), table));
    let (_, of_liquid) = read_nothing(|table| liquid(String::new(), table));
    let about_particles = format!("A kind of sphere, by {NAME_RULE}");
    let about_liquids = format!("A liquid, by {NAME_RULE}; none where every run is dry");
    [
        Section::new("[particles.NAME]", about_particles, of_particle),
        Section::new("[liquids.NAME]", about_liquids, of_liquid),
    ]
}

/// Reads the particles, in the order of the file.
pub(super) fn particles(root: &SceneTable) -> Vec<Particle> {
    named_tables(root, PARTICLES, particle)
}

fn particle(name: String, table: &SceneTable) -> Option<Particle> {
    let density = table.read(&PARTICLE_DENSITY);
    let density_rel_sd = table.read(&DENSITY_REL_SD);
    let roughness = table.read(&ROUGHNESS);
    let roughness_rel_sd = table.read(&ROUGHNESS_REL_SD);
    // one that is refused is not missing
    let has_roughness = table.gives(&ROUGHNESS);
    if roughness_rel_sd.is_some() && !has_roughness {
        let key = ROUGHNESS_REL_SD.base;
        table.refuse(key, table.at(key), None, "expected roughness_um beside it");
    }
    Some(Particle {
        name,
        density: density?,
        density_rel_sd,
        roughness: if has_roughness { Some(roughness?) } else { None },
        roughness_rel_sd,
    })
}

/// Reads the liquids, in the order of the file.
pub(super) fn liquids(root: &SceneTable) -> Vec<Liquid> {
    named_tables(root, LIQUIDS, liquid)
}

fn liquid(name: String, table: &SceneTable) -> Option<Liquid> {
    if name.eq_ignore_ascii_case(DRY) {
        let expected = "expected another name: runs without liquid are marked so";
        table.refuse("", table.at(""), Some(quoted(&name)), expected);
    }
    let density = table.read(&LIQUID_DENSITY);
    let density_rel_sd = table.read(&DENSITY_REL_SD);
    let viscosity = table.read(&VISCOSITY);
    let viscosity_rel_sd = table.read(&VISCOSITY_REL_SD);
    let surface_tension = table.read(&SURFACE_TENSION);
    Some(Liquid {
        name,
        density: density?,
        density_rel_sd,
        viscosity: viscosity?,
        viscosity_rel_sd,
        surface_tension,
    })
}

/// Reads `[kind.NAME]` tables in the order of the file. A missing `[particles]` is a problem, missing liquids are not.
fn named_tables<T>(root: &SceneTable, kind: &str, read: impl Fn(String, &SceneTable) -> Option<T>) -> Vec<T> {
    let found = root.table(kind);
    let given = found.as_ref().map_or(root.has(kind), |table| !table.keys().is_empty());
    if kind == PARTICLES && !given {
        root.refuse_whole("missing table [particles.NAME]");
    }
    let Some(table) = found else {
        return vec![];
    };
    let mut found = vec![];
    for name in table.keys() {
        let Some(inner) = table.table(&name) else {
            continue;
        };
        if !name_is_allowed(&name) {
            let expected = format!("expected {NAME_RULE}");
            table.refuse("", inner.at(""), Some(quoted(&name)), expected);
        }
        if name == MISSING {
            let expected = "expected another name: a missing cell is marked so";
            table.refuse("", inner.at(""), Some(quoted(&name)), expected);
        }
        found.extend(read(name, &inner));
        inner.finish();
    }
    found
}
