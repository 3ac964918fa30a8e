//! Makes scenes and simulated runs for tests, in temporary folders.

pub mod assembled;
mod chance;
mod program;
pub mod scenes;
mod told;
pub mod workbook;

use std::path::Path;

pub use chance::{assert_expected, assert_seldom, binomial_z, counts, holds, mean, normal, seed_of, study};
pub use program::{
    ask, contents, entries, in_project, is_update, kept, read_in_project, table_of, wetcor, wetcor_here, Folder, Ran,
    Says,
};
use rand::rngs::ChaCha8Rng;
pub use told::Told;
use wetcor::findings::compare::ComparedModel;
use wetcor::findings::posterior::{start, MethodChoice, Posterior};
use wetcor::findings::{self, Findings};
use wetcor::inference::importance::DrawCounts;
use wetcor::inference::nuts::{Effort, SamplingPlan};
use wetcor::inference::prepared_posterior::PreparedPosterior;
use wetcor::inference::sampling::{sample_by_importance, sample_by_nuts, Sampled};
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::ModelParameters;
use wetcor::model::simulate::Simulation;
use wetcor::physics::{Coefficient, Parameters, Setting};
use wetcor::report::{self, ReportInput};
use wetcor::runs::{self, NewRun, RunError, RunWriter, Runs, Table};
use wetcor::scene::{self, Scene};
use wetcor::seed::StreamName;

/// A scene in a folder of its own, for as long as the test needs it.
pub struct Place {
    pub folder: Folder,
    pub scene: Scene,
}

impl Place {
    pub fn new(scene_text: &str) -> Place {
        let folder = Folder::new();
        let scene = folder.scene(scene_text).unwrap_or_else(|error| panic!("{error}"));
        Place { folder, scene }
    }

    /// Runs the command beside the scene.
    pub fn run(&self, words: &str) -> Ran {
        self.folder.run(words)
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

    /// The design's runs without a file between.
    pub fn table(&self, seed: u64) -> Table {
        Table::of(runs::arrange(&self.scene, &rows(&self.scene, seed)))
    }

    /// Reads rows given as text.
    pub fn read_rows(&self, csv: &str) -> Table {
        std::fs::write(&self.scene.data.runs[0].path, csv).expect("the folder is writable");
        self.read()
    }

    /// Draws and fits.
    pub fn infer(&self, seed: u64) -> Findings {
        findings::fit_least_squares(&self.scene, &self.table(seed), seed, false)
    }

    /// Fits rows given as text.
    pub fn fit_rows(&self, csv: &str) -> Findings {
        findings::fit_least_squares(&self.scene, &self.read_rows(csv), 1, false)
    }
}

/// A scene without a folder.
pub fn parsed(text: &str) -> Scene {
    scene::parse(text, Path::new("a/scene.toml"), String::new()).unwrap_or_else(|error| panic!("{error}"))
}

/// The runs of a scene's design, as they are drawn.
pub fn rows(scene: &Scene, seed: u64) -> Vec<NewRun<'_>> {
    simulation(scene).under(seed).all()
}

/// The cells of a run up to its impact speed, under the usual header.
pub fn cells(run: &NewRun) -> String {
    let film = run.film.map_or(String::new(), |(film, _)| format!("{}", 1e6 * film));
    let liquid = run.liquid.unwrap_or("dry");
    let (diameter, speed) = (1e3 * run.diameter, run.impact_speed);
    format!("{},{liquid},{diameter},{film},{speed}", run.particle)
}

/// The same from a stream.
pub fn rows_from(scene: &Scene, rng: ChaCha8Rng) -> Vec<NewRun<'_>> {
    simulation(scene).draw_from(rng)
}

/// Gives runs the errors of their rows, which are counted from 1: sds of the impact speed and of the restitution.
pub fn add_errors(runs: &mut Runs, sds: &[[f64; 2]]) {
    let of = |row: &u32| {
        let [impact_speed_sd, restitution_sd] = sds[*row as usize - 1];
        RunError {
            impact_speed_sd,
            restitution_sd,
            speed_correlation: 0.0,
        }
    };
    runs.errors = runs.row.iter().map(of).collect();
}

fn simulation(scene: &Scene) -> Simulation<'_> {
    Simulation::new(scene, None).unwrap_or_else(|error| panic!("{error}"))
}

pub fn write(simulation: &Simulation, seed: u64, path: &Path) {
    let mut writer = RunWriter::create(path, true).unwrap_or_else(|error| panic!("{error}"));
    let runs = simulation.under(seed);
    let mut blocks = 0..runs.blocks();
    let written = blocks.try_for_each(|block| writer.write(&runs.block(block)));
    let written = written.and_then(|()| writer.finish());
    written.unwrap_or_else(|error| panic!("{error}"));
}

/// Adds the posterior by the sampler.
pub fn sample(findings: &mut Findings, scene: &Scene, runs: &Runs) -> Option<Posterior> {
    let sampled = findings.add_posterior(scene, runs, MethodChoice::Sampler, &|_, _| ());
    sampled.unwrap_or_else(|error| panic!("{error}"))
}

/// Adds the posterior by the method that is taken where none is asked for; there must be one.
pub fn sample_as_usual(findings: &mut Findings, scene: &Scene, runs: &Runs) -> Posterior {
    let sampled = findings.add_posterior(scene, runs, MethodChoice::default(), &|_, _| ());
    let sampled = sampled.unwrap_or_else(|error| panic!("{error}"));
    sampled.expect("runs that tell")
}

/// Adds the comparison of forms; these, best first.
pub fn compare(findings: &mut Findings, scene: &Scene, runs: &Runs, posterior: &Posterior) -> Vec<ComparedModel> {
    let compared = findings.add_comparison(scene, runs, posterior, &|_, _| ());
    compared.unwrap_or_else(|error| panic!("{error}"));
    findings.compare.clone().unwrap_or_default()
}

/// Least squares, and the posterior before it is sampled, where there is one.
fn prepared(scene: &Scene, table: &Table) -> (Findings, Option<PreparedPosterior>) {
    let least_squares = findings::fit_least_squares(scene, table, 1, false);
    let form = scene.model.form();
    let rows = Likelihood::new(scene, &table.runs, form);
    let begin = start(&least_squares.fits);
    let parameters = ModelParameters::of(scene, &table.runs, form).ok();
    let prepared = parameters.and_then(|parameters| PreparedPosterior::new(parameters, &rows, &begin).ok());
    (least_squares, prepared)
}

/// Least squares, and draws of the posterior beside it.
pub fn sampled(scene: &Scene, table: &Table, effort: Effort, stream: StreamName) -> (Findings, Sampled) {
    let (least_squares, prepared) = prepared(scene, table);
    let prepared = prepared.expect("priors with room, and a start");
    let sampled = sample_by_nuts(&prepared, SamplingPlan::new(effort, stream), &mut |_| 0);
    (least_squares, sampled.unwrap_or_else(|error| panic!("{error}")))
}

/// Draws by importance where their largest shape is below a line, else trajectories; `None` where there is no start.
pub fn weighed_or_sampled(
    (scene, table): (&Scene, &Table),
    (counts, line): (DrawCounts, f64),
    effort: Effort,
    stream: StreamName,
) -> Option<Sampled> {
    let prepared = prepared(scene, table).1?;
    let weighed = sample_by_importance(&prepared, counts, stream);
    weighed
        .filter(|sampled| sampled.khat.is_some_and(|khat| khat < line))
        .or_else(|| sample_by_nuts(&prepared, SamplingPlan::new(effort, stream), &mut |_| 0).ok())
}

/// All draws of a parameter.
pub fn draws_of(sampled: &Sampled, name: &str) -> Vec<f64> {
    let mut all = sampled.parameters.sampled.iter().zip(&sampled.values);
    let (_, chains) = all.find(|(own, _)| own.name == name).expect("sampled");
    chains.concat()
}

/// The report of findings, and the names of all its files.
pub fn report_of(
    scene: &Scene,
    table: &Table,
    findings: &Findings,
    posterior: Option<&Posterior>,
) -> (String, Vec<String>) {
    let input = ReportInput {
        command: "wetcor fit scene.toml",
        scene,
        runs: &table.runs,
        findings,
        posterior,
    };
    let files = report::files(input, true).unwrap_or_else(|error| panic!("{error}"));
    let whole = files.whole;
    let (_, text) = whole.iter().find(|(name, _)| name == "report.md").expect("a report");
    let text = String::from_utf8(text.clone()).expect("text");
    (text, whole.into_iter().map(|(name, _)| name).collect())
}

/// k, L, C and δ̃0.
pub fn parameters_of([k, l, c, film_scale]: [f64; 4]) -> Parameters {
    Parameters::new(k)
        .with(Coefficient::LubricationLog, l)
        .with(Coefficient::InertialPrefactor, c)
        .with(Coefficient::FilmScale, film_scale)
}

/// A sphere of 5 µm roughness above a wetted plate: density and diameter, density and viscosity of the liquid, film.
pub const fn setting([density, diameter]: [f64; 2], [liquid_density, viscosity]: [f64; 2], film: f64) -> Setting {
    Setting {
        density,
        diameter,
        roughness: Some(5e-6),
        liquid_density,
        viscosity,
        film,
        surface_tension: None,
    }
}

/// The fit of the example in the repository, which `mueller2016` holds to be what the command writes.
pub fn fitted_example() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/reports/mueller2016"))
}
