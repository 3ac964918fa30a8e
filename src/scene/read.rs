//! Turns a scene file into a checked [`Scene`], or names every mistake in it.

use std::path::Path;

use super::contents::Scene;
use super::data::data;
use super::document::Document;
use super::keys::{guides, Key, Optional, Section};
use super::materials::{liquids, particles};
use super::naming::SceneNames;
use super::published::published;
use super::table::{SceneTable, Text};
use super::{choices, plan, table};
use crate::encoding::decode;
use crate::error::Error;
use crate::files;
use crate::seed::sha256;

const TITLE: Key<Text, Optional> = Key {
    base: "title",
    takes: Text,
    absent: Optional("the name of the scene's folder"),
    meaning: "title of the report",
    example: "\"PTFE and PE spheres on wetted glass\"",
};

const SOURCE: Key<Text, Optional> = Key {
    base: "source",
    takes: Text,
    absent: Optional("not told"),
    meaning: "where the runs come from, in words",
    example: "\"measured in May, films by weight\"",
};

/// What is to be said of the keys above all tables.
pub(super) fn guide() -> Section {
    Section {
        head: "",
        about: "What the report says of itself".to_owned(),
        keys: guides(&[&TITLE, &SOURCE]),
    }
}

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
    let title = root.read(&TITLE);
    let source = root.read(&SOURCE);
    let particles = particles(root);
    let liquids = liquids(root);
    let names: Vec<&str> = particles.iter().map(|p| p.name.as_str()).collect();
    let scene_names = SceneNames {
        particles: names.clone(),
        liquids: liquids.iter().map(|liquid| liquid.name.as_str()).collect(),
    };
    let data = data(root, path, &scene_names);
    let model = choices::model(root, &particles, &liquids);
    let priors = choices::priors(root, &names, model.likelihood, &mut unused);
    let sampler = choices::sampler(root);
    let bootstrap = choices::bootstrap(root, &mut unused);
    let published = root
        .tables("published")
        .iter()
        .filter_map(|t| published(t, &names))
        .collect();
    let truth = plan::truth(root, &particles, &liquids, &model);
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
