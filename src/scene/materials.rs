//! Reads the kinds of particles and the liquids of a scene.

use super::expect::{ABOVE_ZERO, SHARE};
use super::names::{name_is_allowed, DRY, MISSING, NAME_RULE};
use super::table::values::number;
use super::table::SceneTable;
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

/// Reads the particles, in the order of the file.
pub(super) fn particles(root: &SceneTable) -> Vec<Particle> {
    named_tables(root, PARTICLES, particle)
}

pub(super) fn particle(name: String, table: &SceneTable) -> Option<Particle> {
    let density = table.required("density", number(ABOVE_ZERO).of(Dimension::Density));
    let density_rel_sd = table.read("density_rel_sd", number(SHARE));
    let roughness = table.read("roughness", number(ABOVE_ZERO).of(Dimension::Thickness));
    let roughness_rel_sd = table.read("roughness_rel_sd", number(SHARE));
    // one that is refused is not missing
    let has_roughness = table.gives("roughness", Dimension::Thickness);
    if roughness_rel_sd.is_some() && !has_roughness {
        table.refuse_key("roughness_rel_sd", "expected roughness_um beside it");
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

pub(super) fn liquid(name: String, table: &SceneTable) -> Option<Liquid> {
    if name.eq_ignore_ascii_case(DRY) {
        let expected = "expected another name: runs without liquid are marked so";
        table.refuse("", table.at(""), Some(quoted(&name)), expected);
    }
    let density = table.required("density", number(ABOVE_ZERO).of(Dimension::Density));
    let density_rel_sd = table.read("density_rel_sd", number(SHARE));
    let viscosity = table.required("viscosity", number(ABOVE_ZERO).of(Dimension::Viscosity));
    let viscosity_rel_sd = table.read("viscosity_rel_sd", number(SHARE));
    let surface_tension = table.read("surface_tension", number(ABOVE_ZERO).of(Dimension::SurfaceTension));
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
    let of_name = |table: &SceneTable, name: String| {
        let inner = table.table(&name)?;
        let refuse = |expected: &str| table.refuse("", inner.at(""), Some(quoted(&name)), expected);
        if !name_is_allowed(&name) {
            refuse(&format!("expected {NAME_RULE}"));
        }
        if name == MISSING {
            refuse("expected another name: a missing cell is marked so");
        }
        let read = read(name, &inner);
        inner.finish();
        read
    };
    found.map_or_else(Vec::new, |table| table.each(|name, _| of_name(&table, name)))
}
