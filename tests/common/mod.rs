//! Makes scenes and simulated runs for tests, in temporary folders.

// each test file uses its own part of this
#![allow(dead_code, unused_imports, reason = "shared by several test files")]

pub mod assembled;
mod chance;
pub mod scenes;
pub mod workbook;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

pub use chance::{binomial_z, mean, seed_of};
use rand::rngs::ChaCha8Rng;
use tempfile::TempDir;
use wetcor::error::Error;
use wetcor::findings::{self, Findings};
use wetcor::model::simulate::Simulation;
use wetcor::runs::{self, Existing, NewRun, RunWriter, Runs, Table};
use wetcor::scene::{self, Scene};

/// A scene in a folder of its own, for as long as the test needs it.
pub struct Place {
    pub folder: TempDir,
    pub scene: Scene,
}

impl Place {
    pub fn new(scene_text: &str) -> Place {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, scene_text).expect("the folder is writable");
        let scene = scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
        Place { folder, scene }
    }

    pub fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    /// Draws the scene's design and reads it back.
    pub fn draw(&self, seed: u64, runs: Option<u64>) -> Table {
        let simulation = Simulation::new(&self.scene, runs).unwrap_or_else(|error| panic!("{error}"));
        write(&simulation, seed, &self.scene.data.runs[0].path);
        self.read()
    }

    pub fn read(&self) -> Table {
        runs::read(&self.scene).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Draws, reads and fits.
    pub fn infer(&self, seed: u64) -> Findings {
        findings::fit_least_squares(&self.scene, &self.draw(seed, None), seed, false)
    }

    /// Fits rows given as text.
    pub fn fit_rows(&self, csv: &str) -> Findings {
        std::fs::write(&self.scene.data.runs[0].path, csv).expect("the folder is writable");
        findings::fit_least_squares(&self.scene, &self.read(), 1, false)
    }
}

/// The runs of a scene's design, as they are drawn.
pub fn rows(scene: &Scene, seed: u64) -> Vec<NewRun<'_>> {
    simulation(scene).under(seed).all()
}

/// The same from a stream.
pub fn rows_from(scene: &Scene, rng: ChaCha8Rng) -> Vec<NewRun<'_>> {
    simulation(scene).draw_from(rng)
}

fn simulation(scene: &Scene) -> Simulation<'_> {
    Simulation::new(scene, None).unwrap_or_else(|error| panic!("{error}"))
}

pub fn write(simulation: &Simulation, seed: u64, path: &Path) {
    let mut writer = RunWriter::create(path, Existing::Replaced).unwrap_or_else(|error| panic!("{error}"));
    let runs = simulation.under(seed);
    runs.encode(0..runs.blocks(), writer.format(), |block| writer.write(block))
        .unwrap_or_else(|error| panic!("{error}"));
    writer.finish().unwrap_or_else(|error| panic!("{error}"));
}

/// Runs the command in a folder: its exit status, and what it prints to both outputs.
pub fn wetcor(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_wetcor"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the command can be started");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("plain text");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The same in the folder of the project.
pub fn wetcor_here(arguments: &[&str]) -> (Option<i32>, String, String) {
    wetcor(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// A fit of the example with its draws, once for all tests of a file.
pub fn fitted_example() -> &'static Path {
    static FIT: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, folder) = FIT.get_or_init(|| {
        let place = tempfile::tempdir().expect("a temporary folder");
        let out = place.path().join("report");
        let text = out.to_str().expect("a plain path");
        let scene = "datasets/mueller2016/scene.toml";
        let (status, _, err) = wetcor_here(&["fit", scene, "--stages", "least_squares,posterior", "--out", text]);
        assert_eq!(status, Some(0), "{err}");
        (place, out)
    });
    folder
}
