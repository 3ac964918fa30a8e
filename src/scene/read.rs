//! Turns a scene file into a checked [`Scene`], or names every mistake in it.

use std::path::Path;

use super::contents::{Data, Scene, Screens, TableFile};
use super::document::Document;
use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE, LARGEST_FILM_RATIO, NOT_NEGATIVE, SHARE};
use super::materials::{Liquid, Particle};
use super::names::{name_is_allowed, DRY, MISSING, NAME_RULE};
use super::naming::{naming, SceneNames};
use super::published::{Published, PublishedQuantity, WetLaw};
use super::table::{Located, SceneTable};
use super::{choices, plan, table};
use crate::encoding::decode;
use crate::error::{quoted, Error};
use crate::files;
use crate::seed::sha256;
use crate::units::Dimension;

/// What the name of a table of runs ends with.
const TABLE_ENDINGS: [&str; 5] = [".csv", ".tsv", ".txt", TableFile::WORKBOOK, ".parquet"];

/// δ/D is split into groups at gaps larger than this, where the runs carry no film ratio.
const DEFAULT_FILM_RATIO_GAP: f64 = 0.004;

/// Reads and checks a scene file.
///
/// Fails with every mistake named by line, key and value.
pub fn read(path: &Path) -> Result<Scene, Error> {
    let bytes = files::read(path, files::MOST_OF_SCENE, "read")?;
    let hash = sha256(&bytes);
    let text = decode(&bytes).map_err(|problem| Error::input(path, vec![problem]))?;
    parse(text, path, hash)
}

/// Checks the text of a scene file that lies, or would lie, at `path`; `sha256` is its hash.
pub fn parse(text: &str, path: &Path, sha256: String) -> Result<Scene, Error> {
    let parsed = table::parse(text).map_err(|problem| Error::input(path, vec![problem]))?;
    let document = Document::new(text);
    let root = SceneTable::root(document.clone(), parsed.get_ref());
    let scene = assemble(&root, path, sha256);
    root.finish();
    drop(root);
    let problems = document.problems();
    match scene {
        Some(scene) if problems.is_empty() => Ok(scene),
        _ => Err(Error::input(path, problems)),
    }
}

fn assemble(root: &SceneTable, path: &Path, sha256: String) -> Option<Scene> {
    let mut unused = vec![];
    let title = root.text("title");
    let source = root.text("source");
    let particles = particles(root);
    let liquids = liquids(root);
    let data = data(root, path, &particles, &liquids);
    let names: Vec<&str> = particles.iter().map(|p| p.name.as_str()).collect();
    let model = choices::model(root, &liquids);
    let priors = choices::priors(root, &names, model.likelihood, &mut unused);
    let sampler = choices::sampler(root);
    let bootstrap = choices::bootstrap(root, &mut unused);
    let published = root
        .tables("published")
        .iter()
        .filter_map(|t| published(t, &names))
        .collect();
    let truth = plan::truth(root, &names, &liquids, &model);
    let design = plan::design(root, &names, &liquids);
    let name = scene_name(path);
    Some(Scene {
        file: path.to_path_buf(),
        title: title.unwrap_or_else(|| name.clone()),
        name,
        source,
        sha256,
        data: data?,
        particles,
        liquids,
        model,
        priors,
        sampler,
        bootstrap,
        published,
        truth,
        design,
        unused,
    })
}

/// The name of the folder the scene lies in.
fn scene_name(path: &Path) -> String {
    let folder = path
        .canonicalize()
        .ok()
        .and_then(|full| full.parent().map(Path::to_path_buf));
    folder
        .as_deref()
        .and_then(Path::file_name)
        .map_or_else(|| "scene".to_owned(), |name| name.to_string_lossy().into_owned())
}

fn data(root: &SceneTable, path: &Path, particles: &[Particle], liquids: &[Liquid]) -> Option<Data> {
    let Some(table) = root.table("data") else {
        if !root.has("data") {
            root.refuse_whole("missing table [data]");
        }
        return None;
    };
    table.require_key("runs", Dimension::One);
    let runs = runs(&table, path);
    let speed = |base: &str| table.quantity(base, Dimension::Speed, ABOVE_ZERO);
    let screens = Screens {
        min_film: table.quantity("min_film", Dimension::Thickness, ABOVE_ZERO),
        max_film_ratio: table.number("max_film_ratio", FILM_RATIO).unwrap_or(LARGEST_FILM_RATIO),
        min_impact_speed: speed("min_impact_speed"),
        max_impact_speed: speed("max_impact_speed"),
    };
    let mut film_ratios = table
        .quantities("film_ratios", Dimension::One, FILM_RATIO)
        .unwrap_or_default();
    film_ratios.sort_by(f64::total_cmp);
    film_ratios.dedup();
    let names = SceneNames {
        particles: particles.iter().map(|particle| particle.name.as_str()).collect(),
        liquids: liquids.iter().map(|liquid| liquid.name.as_str()).collect(),
    };
    let data = Data {
        naming: naming(&table, &names),
        runs,
        smallest_restitution: table.number("smallest_restitution", SHARE).unwrap_or(0.0),
        film_ratios,
        film_ratio_gap: table
            .number("film_ratio_gap", ABOVE_ZERO)
            .unwrap_or(DEFAULT_FILM_RATIO_GAP),
        film_sd: table.quantity("film_sd", Dimension::Thickness, NOT_NEGATIVE),
        speed_rel_sd: table.number("speed_rel_sd", SHARE),
        screens,
    };
    table.finish();
    Some(data)
}

/// The tables of runs, each once and in a format that can be read.
fn runs(table: &SceneTable, path: &Path) -> Vec<TableFile> {
    let names = table.text_or_texts("runs").unwrap_or_default();
    let mut runs: Vec<TableFile> = vec![];
    for Located { value: name, at } in &names {
        let refuse = |expected: &str| table.refuse("runs", *at, Some(quoted(name)), expected);
        let file = TableFile::named(path.parent(), name);
        if !TABLE_ENDINGS.iter().any(|ending| file.ends_with(ending)) {
            refuse("expected a file ending in .csv, .tsv, .txt, .xlsx or .parquet");
        }
        if runs.contains(&file) {
            refuse("expected every table once");
        }
        runs.push(file);
    }
    runs
}

fn particles(root: &SceneTable) -> Vec<Particle> {
    named_tables(root, "particles", |name, table| {
        let density = table.required("density", Dimension::Density, ABOVE_ZERO);
        let roughness = table.required("roughness", Dimension::Thickness, ABOVE_ZERO);
        let density_rel_sd = table.number("density_rel_sd", SHARE);
        let roughness_rel_sd = table.number("roughness_rel_sd", SHARE);
        Some(Particle {
            name,
            density: density?,
            density_rel_sd,
            roughness: roughness?,
            roughness_rel_sd,
        })
    })
}

fn liquids(root: &SceneTable) -> Vec<Liquid> {
    named_tables(root, "liquids", |name, table| {
        if name == DRY {
            let expected = "expected another name: runs without liquid are marked so";
            table.refuse("", table.at(""), Some(quoted(&name)), expected);
        }
        let density = table.required("density", Dimension::Density, ABOVE_ZERO);
        let viscosity = table.required("viscosity", Dimension::Viscosity, ABOVE_ZERO);
        let density_rel_sd = table.number("density_rel_sd", SHARE);
        let viscosity_rel_sd = table.number("viscosity_rel_sd", SHARE);
        let surface_tension = table.quantity("surface_tension", Dimension::SurfaceTension, ABOVE_ZERO);
        Some(Liquid {
            name,
            density: density?,
            density_rel_sd,
            viscosity: viscosity?,
            viscosity_rel_sd,
            surface_tension,
        })
    })
}

/// Reads `[kind.NAME]` tables in the order of the file. A missing `[particles]` is a problem, missing liquids are not.
fn named_tables<T>(root: &SceneTable, kind: &str, read: impl Fn(String, &SceneTable) -> Option<T>) -> Vec<T> {
    let found = root.table(kind);
    let given = found.as_ref().map_or(root.has(kind), |table| !table.keys().is_empty());
    if kind == "particles" && !given {
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

fn published(table: &SceneTable, particles: &[&str]) -> Option<Published> {
    let quantities = [PublishedQuantity::EInf, PublishedQuantity::StC, PublishedQuantity::DryK]
        .map(|quantity| (quantity.name(), quantity));
    let one = Dimension::One;
    for key in ["quantity", "particle", "source"] {
        table.require_key(key, one);
    }
    let quantity = table.choice("quantity", &quantities);
    let name = table.text("particle");
    let particle = name.as_deref().and_then(|name| {
        let index = particles.iter().position(|particle| *particle == name);
        if index.is_none() {
            let names = particles.iter().copied();
            let name = Located {
                value: name,
                at: table.at("particle"),
            };
            table.refuse_name("particle", &name, "a name in [particles]", names);
        }
        index
    });
    let laws = [WetLaw::Linear, WetLaw::Sqrt].map(|law| (law.name(), law));
    let law = table.choice("law", &laws);
    let film_ratio = table.number("film_ratio", FILM_RATIO);
    let value = table.required("value", one, FINITE);
    let se = table.required("se", one, ABOVE_ZERO);
    let source = table.text("source");
    table.finish();
    let quantity = quantity?;
    Some(Published {
        quantity,
        particle: particle?,
        film_ratio,
        law: (quantity != PublishedQuantity::DryK).then(|| law.unwrap_or(WetLaw::Linear)),
        value: value?,
        se: se?,
        source: source?,
    })
}
