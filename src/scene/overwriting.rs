//! Recognises scenes and the runs of scenes, which must not be written over.

use std::path::{Path, PathBuf};

use super::contents::Scene;
use super::table_file::TableFile;
use crate::files;

/// Why nothing may be written to a file: it is a scene, or holds the runs of this scene or of one that lies beside it.
/// `None` where it belongs to no scene, or is not there.
pub fn why_not_overwritten(file: &Path, scene: &Scene) -> Option<String> {
    let scene_file = scene.file.as_path();
    let file = file.canonicalize().ok()?;
    let is_this = |other: &Path| other.canonicalize().is_ok_and(|other| other == file);
    if is_this(scene_file) || runs_of(&file).is_some() {
        return Some("is a scene; choose another file".to_owned());
    }
    let holds_runs_of = |scene: &Path| {
        let scene = scene.display();
        Some(format!(
            "holds the runs of {scene}; choose another file, or move it away first"
        ))
    };
    if scene.data.runs.iter().any(|runs| is_this(&runs.path)) {
        return holds_runs_of(scene_file);
    }
    let beside = std::fs::read_dir(file.parent()?).ok()?;
    let mut scenes = beside
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let owner = scenes.find(|path| runs_of(path).is_some_and(|all| all.iter().any(|runs| is_this(runs))))?;
    holds_runs_of(&owner)
}

/// Where the runs of a scene lie; `None` for what is no scene.
fn runs_of(path: &Path) -> Option<Vec<PathBuf>> {
    let bytes = files::read(path, files::MOST_OF_SCENE, "read").ok()?;
    let scene: toml::Table = toml::from_slice(&bytes).ok()?;
    // what every scene has, whatever else is right or wrong with it
    let names: Vec<&str> = match scene.get("data")?.get("runs")? {
        toml::Value::String(name) => vec![name],
        toml::Value::Array(names) => names.iter().map(toml::Value::as_str).collect::<Option<_>>()?,
        _ => return None,
    };
    let files = names.iter().map(|name| TableFile::named(path.parent(), name).path);
    Some(files.collect())
}
