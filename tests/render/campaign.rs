//! Makes a campaign: a scene of known parameters, and frames of every run of its design, with their list.

use std::path::Path;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use wetcor::model::simulate::Simulation;
use wetcor::runs::NewRun;
use wetcor::scene;

use crate::flight::Bounces;
use crate::render::{render, tiff, Scene};

/// The paper's design, fewer settings of it.
const SCENE: &str = r#"
title = "from frames"
[data]
runs = "runs.csv"
[particles.PTFE]
density_kg_m3 = 2150
roughness_um = 5
[liquids.AK10]
density_kg_m3 = 930
viscosity_mPa_s = 9.3
[model]
inertia = "saturating"
dry_speed_m_s = "impact"
[truth]
dry_k = { PTFE = 0.183 }
lubrication_log = 1.9
inertia = "saturating"
inertial_prefactor = 0.45
film_scale = 0.07
dry_speed_m_s = "impact"
sigma_dry = 0.004
sigma_wet = 0.008
[design]
diameter_mm = { PTFE = [4.762] }
liquids = ["AK10"]
film_ratio = { PTFE = [0.04, 0.10] }
impact_speed_m_s = [0.6, 0.8, 1.0]
dry_impact_speed_m_s = [0.6, 0.8, 1.0]
repeats = 3
"#;

const FRAME_RATE: f64 = 500.0;

/// Pixels per m.
const SCALE: f64 = 7_000.0;

/// The row of the plate's near edge.
const PLATE: f64 = 400.0;

/// Writes `scene.toml`, `recordings.csv` and a TIFF a run into a folder; gives how many runs there are.
pub fn write(folder: &Path, seed: u64) -> usize {
    let path = folder.join("scene.toml");
    std::fs::write(&path, SCENE).expect("the folder is writable");
    let scene = scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let simulation = Simulation::new(&scene, None).unwrap_or_else(|error| panic!("{error}"));
    let runs = simulation.under(seed).all();
    let mut list = "file,particle,liquid,diameter_mm,film_um,frame_rate_Hz,scale_px_per_mm\n".to_owned();
    for (number, run) in runs.iter().enumerate() {
        let (liquid, film) = match run.film {
            Some((film, _)) => (run.liquid.unwrap_or_default(), format!("{}", 1e6 * film)),
            None => ("dry", String::new()),
        };
        // some scales were measured, the others are by the diameter
        let scale = if number % 2 == 0 { "7" } else { "" };
        list.push_str(&format!(
            "drop{number}.tif,PTFE,{liquid},4.762,{film},{FRAME_RATE},{scale}\n"
        ));
    }
    std::fs::write(folder.join("recordings.csv"), list).expect("the folder is writable");
    runs.par_iter().enumerate().for_each(|(number, run)| {
        frames(run, seed ^ number as u64, &folder.join(format!("drop{number}.tif")));
    });
    runs.len()
}

/// The frames of a run, until after the second contact.
fn frames(run: &NewRun, seed: u64, file: &Path) {
    let bounces = Bounces {
        contact: ChaCha8Rng::seed_from_u64(seed).random_range(0.070..0.074),
        impact_speed: run.impact_speed,
        restitution: run.restitution,
    };
    let radius = 0.5 * run.diameter * SCALE;
    let scene = Scene {
        width: 80,
        height: 430,
        radius,
        contrast: 120.0,
        gradient: 0.3,
        shading: 0.2,
        highlight: true,
        plate: Some(PLATE),
        mirror: 0.4,
        exposure: 0.1,
        seed,
        ..Scene::default()
    };
    let centre = |frame: f64| (40.2, PLATE - radius - SCALE * bounces.height(frame / FRAME_RATE));
    let frames = ((bounces.second_contact() + 0.01) * FRAME_RATE) as usize;
    tiff(file, false, (0..frames).map(|frame| render(&scene, centre, frame)));
}
