//! Times one series fit, the least-squares stage and the reading of a million runs.
//!
//! Runs are simulated in the design of `datasets/mueller2016`.

use std::path::Path;

use divan::{black_box, Bencher};
use tempfile::TempDir;
use wetcor::findings;
use wetcor::inference::law::Law;
use wetcor::inference::regression::Regression;
use wetcor::model::simulate::Simulation;
use wetcor::runs::{self, RunWriter};
use wetcor::scene::{self, Scene};

fn main() {
    divan::main();
}

/// The example's scene with so many simulated runs; they live as long as the folder.
fn simulated(runs: u64) -> (Scene, TempDir) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
    let mut scene = scene::read(&path).expect("the example's scene is good");
    let folder = TempDir::new().expect("a temporary folder can be made");
    let table = folder.path().join("runs.csv");
    let simulation = Simulation::new(&scene, Some(runs)).expect("the example has a truth and a design");
    let mut writer = RunWriter::create(&table, true).expect("the table can be created");
    let runs = simulation.under(1);
    writer.write(&runs.all()).expect("the table can be written");
    writer.finish().expect("the table can be completed");
    scene.data.runs = vec![table.into()];
    (scene, folder)
}

/// Settings of the example's design; so many times 8 runs give 8 a setting, and 40 a series of five speeds.
const SETTINGS: u64 = 300;

/// The square-root law of one series of 40 runs.
#[divan::bench]
fn series_fit(bencher: Bencher) {
    let (scene, _folder) = simulated(8 * SETTINGS);
    let runs = runs::read(&scene).expect("simulated runs are good").runs;
    let series = runs.series.iter().find(|series| series.rebounds.len() == 40);
    let range = series.expect("some series rebounds throughout").rebounds.clone();
    let x: Vec<f64> = runs.impact_speed[range.clone()].iter().map(|v| 1.0 / v).collect();
    let e = &runs.restitution[range];
    bencher.bench(|| Regression::new(Law::SQUARE_ROOT, black_box(&x), black_box(e)).fit());
}

/// Every fit and interval of 2,000 runs.
#[divan::bench]
fn least_squares_stage(bencher: Bencher) {
    let (scene, _folder) = simulated(2_000);
    let table = runs::read(&scene).expect("simulated runs are good");
    bencher.bench(|| findings::fit_least_squares(black_box(&scene), black_box(&table), 1, false));
}

/// A million runs from CSV: read, checked, screened, hashed and ordered by series.
#[divan::bench(sample_count = 15, sample_size = 1)]
fn read_million(bencher: Bencher) {
    let (scene, _folder) = simulated(1_000_000);
    bencher.bench(|| runs::read(black_box(&scene)).expect("simulated runs are good"));
}
