//! Measures how each stage's cost grows with runs, replicates, groups and threads, and writes `reports/cost/`.
//!
//! `cargo bench --bench cost` takes some minutes; `-- quick` stops at 10⁵ runs and writes nothing, `-- ten-million` goes
//! on to 10⁷, where ten runs share a setting, and takes a quarter of an hour and some gigabytes. Runs are simulated in the
//! design of `datasets/mueller2016`, each at a speed of its own: no two share a setting, which is the hardest case. A cost's
//! exponent is the slope of its logarithm over the last two decades.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

use wetcor::findings;
use wetcor::findings::bootstrap::MOST_RESAMPLED;
use wetcor::findings::posterior::MethodChoice;
use wetcor::model::simulate::Simulation;
use wetcor::report::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Marks, Style};
use wetcor::runs::{self, RunWriter, Table};
use wetcor::scene::{self, Scene};

/// Every stage, each drawn in its own way in every panel.
const STAGES: [&str; 4] = ["read", "least squares", "bootstrap", "posterior"];

/// Replicates where runs or groups grow.
const REPLICATES: u64 = 1000;

fn main() {
    let quick = std::env::args().any(|word| word == "quick");
    // cargo's own test of benches
    if std::env::args().any(|word| word == "--test") {
        return;
    }
    let most = std::env::args().any(|word| word == "ten-million");
    let largest = match (quick, most) {
        (true, _) => 5,
        (_, true) => 7,
        _ => 6,
    };
    let panels = [
        of_runs("runs", largest, own_speeds),
        of_runs("runs in films of their own", largest, own_films),
        of_replicates(if quick { 4 } else { 6 }),
        of_groups(if quick { 2 } else { 3 }),
    ];
    let mut page = String::from("# What each stage costs as work grows\n\n");
    let _ = writeln!(
        page,
        "Seconds on {} threads, simulated runs in the design of `datasets/mueller2016` with a speed or a film of its own for \
         each, so that no two share a setting. The exponent is the slope of the logarithm of the time over the last two decades: \
         1 is linear. Bootstrap: {REPLICATES} replicates of every quantity, of more than {MOST_RESAMPLED} runs the sandwich \
         covariance instead; posterior: 4 chains of 1,000 + 1,000 with \
         their checks.\n\nMade by `cargo bench --bench cost`.\n\n![seconds against runs, replicates and groups](cost.svg)\n",
        rayon::current_num_threads()
    );
    for panel in &panels {
        page.push_str(&panel.table());
    }
    page.push_str(&of_threads(if quick { 4 } else { 5 }));
    print!("{page}");
    if !quick {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/cost");
        std::fs::create_dir_all(&folder).expect("reports/ is writable");
        let charts: Vec<Chart> = panels.iter().map(Panel::chart).collect();
        std::fs::write(folder.join("cost.md"), page.trim_end().to_owned() + "\n").expect("writable");
        std::fs::write(folder.join("cost.svg"), svg(&charts)).expect("writable");
    }
}

/// Times of some stages against one size.
struct Panel {
    what: &'static str,
    sizes: Vec<f64>,
    /// a name and a time for each size
    stages: Vec<(&'static str, Vec<f64>)>,
}

impl Panel {
    fn new(what: &'static str, stages: &[&'static str]) -> Panel {
        Panel {
            what,
            sizes: vec![],
            stages: stages.iter().map(|name| (*name, vec![])).collect(),
        }
    }

    fn add(&mut self, size: f64, seconds: &[f64]) {
        self.sizes.push(size);
        for ((_, times), seconds) in self.stages.iter_mut().zip(seconds) {
            times.push(*seconds);
        }
        eprintln!("{} {size}: {seconds:.3?}", self.what);
    }

    /// Slope of the logarithm over the last two decades.
    fn exponent(&self, times: &[f64]) -> f64 {
        let last = self.sizes.len() - 1;
        let first = self.sizes.iter().position(|size| *size >= 0.009 * self.sizes[last]);
        let first = first.unwrap_or(0);
        (times[last] / times[first]).ln() / (self.sizes[last] / self.sizes[first]).ln()
    }

    fn table(&self) -> String {
        let mut text = format!("## {}\n\n| {} |", self.what, self.what);
        for (name, _) in &self.stages {
            let _ = write!(text, " {name} / s |");
        }
        text.push_str("\n|");
        text.push_str(&" --- |".repeat(self.stages.len() + 1));
        for (row, size) in self.sizes.iter().enumerate() {
            let _ = write!(text, "\n| {size:.0} |");
            for (_, times) in &self.stages {
                let _ = write!(text, " {:.2e} |", times[row]);
            }
        }
        text.push_str("\n| exponent |");
        for (_, times) in &self.stages {
            let _ = write!(text, " {:.2} |", self.exponent(times));
        }
        text + "\n\n"
    }

    fn chart(&self) -> Chart {
        let layers = self.stages.iter().flat_map(|(name, times)| {
            let group = STAGES.iter().position(|stage| stage == name).unwrap_or(STAGES.len());
            let at: Vec<(f64, f64)> = self
                .sizes
                .iter()
                .zip(times)
                .map(|(x, y)| (x.log10(), y.log10()))
                .collect();
            let style = Style::group(group);
            let points = at.iter().map(|(x, y)| ChartPoint::at(*x, *y)).collect();
            [
                Layer::points(Some((*name).to_owned()), points, style),
                Layer {
                    name: None,
                    style,
                    marks: Marks::Line(at, Dash::Solid),
                },
            ]
        });
        let x = Axis::new(self.what).of_decades();
        let y = Axis::new("time / s").of_decades();
        Chart::new(x, y, layers.collect())
    }
}

fn example() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
    scene::read(&path).expect("the example's scene is good")
}

/// Writes so many runs of a scene's design to a file that is kept under `target/`.
fn simulate(scene: &mut Scene, runs: Option<u64>, name: &str) {
    let folder: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cost");
    std::fs::create_dir_all(&folder).expect("target/ is writable");
    scene.data.runs = vec![folder.join(name).into()];
    let simulation = Simulation::new(scene, runs).expect("the scene has a truth and a design");
    let mut writer = RunWriter::create(&scene.data.runs[0].path, true).expect("the table can be created");
    let drawn = simulation.under(1);
    for block in 0..drawn.blocks() {
        writer.write(&drawn.block(block)).expect("the table can be written");
    }
    writer.finish().expect("the table can be completed");
}

/// The example's scene with so many runs, each at its own speed.
fn own_speeds(runs: u64) -> Scene {
    let mut scene = example();
    scene.bootstrap.replicates = REPLICATES;
    if let Some(design) = &mut scene.design {
        // the design makes 84 combinations of everything else, and a million are the most it may make
        let count = (runs.min(1_000_000) / 84).max(2);
        let speed = |i: u64| 0.767 + 0.95 * (i as f64 + 0.5) / count as f64;
        design.speeds = (0..count).map(speed).collect();
    }
    simulate(&mut scene, Some(runs), &format!("runs-{runs}.parquet"));
    scene
}

/// The same with the speeds of the example's design, and every run in a film of its own, so that here, too, each is a setting
/// of its own.
fn own_films(runs: u64) -> Scene {
    let mut scene = example();
    scene.bootstrap.replicates = REPLICATES;
    if let Some(design) = &mut scene.design {
        design.film_rel_sd = Some(0.02);
    }
    simulate(&mut scene, Some(runs), &format!("films-{runs}.parquet"));
    scene
}

fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let began = Instant::now();
    let done = work();
    (began.elapsed().as_secs_f64(), done)
}

/// Seconds of least squares, of the bootstrap and of the posterior.
fn stages(scene: &Scene, table: &Table, with_posterior: bool) -> [f64; 3] {
    let (least_squares, mut found) = timed(|| findings::fit_least_squares(scene, table, 1, false));
    let first = OnceLock::new();
    let begins = |_| {
        first.get_or_init(Instant::now);
    };
    findings::fit_least_squares_watched(scene, table, 1, Some(&begins));
    let ended = Instant::now();
    let bootstrap = first.get().map_or(0.0, |first| (ended - *first).as_secs_f64());
    let posterior = if with_posterior {
        let sample = || found.add_posterior(scene, &table.runs, MethodChoice::Sampler, &|_, _| ());
        let (seconds, sampled) = timed(sample);
        sampled.expect("priors with room");
        seconds
    } else {
        0.0
    };
    [least_squares, bootstrap, posterior]
}

fn of_runs(what: &'static str, largest: u32, simulated: fn(u64) -> Scene) -> Panel {
    let mut panel = Panel::new(what, &STAGES);
    for decade in 2..=largest {
        let scene = simulated(10u64.pow(decade));
        let (read, table) = timed(|| runs::read(&scene).expect("simulated runs are good"));
        let [least_squares, bootstrap, posterior] = stages(&scene, &table, true);
        panel.add(10f64.powi(decade as i32), &[read, least_squares, bootstrap, posterior]);
    }
    panel
}

fn of_replicates(largest: u32) -> Panel {
    let mut panel = Panel::new("replicates", &STAGES[2..3]);
    let mut scene = example();
    let table = runs::read(&scene).expect("the example's runs are good");
    for decade in 2..=largest {
        scene.bootstrap.replicates = 10u64.pow(decade);
        panel.add(10f64.powi(decade as i32), &stages(&scene, &table, false)[1..2]);
    }
    panel
}

/// Groups of six runs: a particle has up to 48 film ratios.
fn of_groups(largest: u32) -> Panel {
    const FILMS: u64 = 48;
    let mut panel = Panel::new("groups", &STAGES[1..]);
    for decade in 0..=largest {
        let groups = 10u64.pow(decade);
        let particles = groups.div_ceil(FILMS);
        let names: Vec<String> = (0..particles).map(|i| format!("P{i}")).collect();
        let all = |of: &dyn Fn(&str) -> String| {
            let each: Vec<String> = names.iter().map(|name| of(name)).collect();
            each.join(", ")
        };
        let films = |name: &str| {
            let index: u64 = name[1..].parse().unwrap_or(0);
            let count = FILMS.min(groups - index * FILMS);
            let ratios: Vec<String> = (0..count).map(|i| format!("{:.3}", 0.02 + 0.005 * i as f64)).collect();
            format!("{name} = [{}]", ratios.join(", "))
        };
        let tables: String = names
            .iter()
            .map(|name| format!("[particles.{name}]\ndensity_kg_m3 = 2150\nroughness_um = 5\n"))
            .collect();
        let text = format!(
            "title = \"groups\"\n[data]\nruns = \"runs.csv\"\n{tables}[liquids.M50]\ndensity_kg_m3 = 965\n\
             viscosity_mPa_s = 48.3\n[bootstrap]\nreplicates = {REPLICATES}\n[truth]\ndry_k = {{ {} }}\n\
             lubrication_log = 1.85\ninertia = \"stepwise\"\ninertial_prefactor = 0.4\nsigma_dry = 0.01\n\
             sigma_wet = 0.02\n[design]\ndiameter_mm = {{ {} }}\nliquids = [\"M50\"]\nfilm_ratio = {{ {} }}\n\
             impact_speed_m_s = [1.2, 1.5, 2.0]\ndry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 2\n",
            all(&|name| format!("{name} = 0.15")),
            all(&|name| format!("{name} = [8.0]")),
            all(&films),
        );
        let mut scene = scene::parse(&text, Path::new("groups/scene.toml"), String::new()).expect("a good scene");
        simulate(&mut scene, None, &format!("groups-{groups}.parquet"));
        let table = runs::read(&scene).expect("simulated runs are good");
        panel.add(groups as f64, &stages(&scene, &table, true));
    }
    panel
}

fn of_threads(decade: u32) -> String {
    let runs = 10u64.pow(decade);
    let scene = own_speeds(runs);
    let table = runs::read(&scene).expect("simulated runs are good");
    let mut text = format!(
        "## threads\n\n{runs} runs, shortest of three.\n\n| threads | least squares / s | bootstrap / s | posterior / s |\n\
         | --- | --- | --- | --- |\n"
    );
    let mut rows = vec![];
    for threads in 1..=2 {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut shortest = [f64::INFINITY; 3];
        for _ in 0..3 {
            let seconds = pool.install(|| stages(&scene, &table, true));
            for (shortest, seconds) in shortest.iter_mut().zip(seconds) {
                *shortest = shortest.min(seconds);
            }
        }
        eprintln!("threads {threads}: {shortest:.3?}");
        let _ = writeln!(
            text,
            "| {threads} | {:.2e} | {:.2e} | {:.2e} |",
            shortest[0], shortest[1], shortest[2]
        );
        rows.push(shortest);
    }
    let gain = |stage: usize| rows[0][stage] / rows[1][stage];
    let _ = writeln!(text, "| gain | {:.2} | {:.2} | {:.2} |", gain(0), gain(1), gain(2));
    text
}
