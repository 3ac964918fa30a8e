//! Turns a scene file into a checked [`Scene`], or names every mistake in it.

use std::path::Path;

use super::contents::Scene;
use super::data::data;
use super::document::Document;
use super::materials::{liquids, particles, LIQUIDS, PARTICLES};
use super::naming::SceneNames;
use super::published::published;
use super::table::values::text;
use super::table::SceneTable;
use super::table_file::TableFile;
use super::{choices, plan, table};
use crate::encoding::decode;
use crate::error::{named, Error};
use crate::files;
use crate::seed::sha256;

/// Title and source.
pub(super) fn of_report(root: &SceneTable) -> [Option<String>; 2] {
    [root.read("title", text()), root.read("source", text())]
}

/// Reads and checks a scene file.
///
/// Fails with every mistake named by line, key and value.
pub fn read(path: &Path) -> Result<Scene, Error> {
    if TableFile::is_named_as_one(path) {
        let name = named(path);
        return Err(Error::Usage(format!(
            "{name}: a table, where a scene is expected; `wetcor new {name}` drafts the scene from it"
        )));
    }
    if files::is_video(path) {
        return Err(Error::Usage(format!(
            "{}: a video, where a scene is expected; `wetcor track` finds the runs of a list of recordings, and `wetcor track \
             --help` says how to make frames of a video",
            named(path)
        )));
    }
    let bytes = files::read(path, files::MOST_OF_SCENE, "read")?;
    let hash = sha256(&bytes);
    let text = decode(&bytes).map_err(|problem| Error::input(path, vec![problem]))?;
    parse(text, path, hash)
}

/// Checks the text of a scene file that lies, or would lie, at `path`; `sha256` is its hash.
pub fn parse(text: &str, path: &Path, sha256: String) -> Result<Scene, Error> {
    let parsed = table::parse(text).map_err(|problem| Error::input(path, vec![problem]))?;
    let document = Document::new(text);
    let root = SceneTable::root(&document, parsed.get_ref());
    let scene = assemble(&root, path, sha256);
    root.finish();
    let problems = document.problems();
    match scene {
        Some(scene) if problems.is_empty() => Ok(scene),
        _ => Err(Error::input(path, problems)),
    }
}

fn assemble(root: &SceneTable, path: &Path, sha256: String) -> Option<Scene> {
    let mut unused = vec![];
    let [title, source] = of_report(root);
    let particles = particles(root);
    let liquids = liquids(root);
    // also of tables that lack something: a name in one is known
    let names = SceneNames {
        particles: root.keys_of(PARTICLES),
        liquids: root.keys_of(LIQUIDS),
    };
    let data = root.table("data").map(|table| data(&table, path, &names));
    if !root.has("data") {
        root.refuse_whole("missing table [data]");
    }
    let model = choices::model(&root.table_or_empty("model"), &particles, &liquids);
    let priors = choices::priors(root, &names.particles, model.likelihood, &mut unused);
    let sampler = choices::sampler(&root.table_or_empty("sampler"));
    let bootstrap = choices::bootstrap(&root.table_or_empty("bootstrap"));
    let published = root
        .tables("published")
        .iter()
        .filter_map(|t| published(t, &names.particles))
        .collect();
    let truth = root.table("truth");
    let truth = truth.map(|table| plan::truth(&table, &names.particles, (&particles, &liquids), &model));
    let design = root.table("design").map(|table| plan::design(&table, &names));
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
    let full = path.canonicalize().unwrap_or_default();
    let name = full.parent().and_then(Path::file_name);
    name.map_or_else(|| "scene".to_owned(), |name| name.to_string_lossy().into_owned())
}
