//! The whole way: frames of falling spheres, rendered from known parameters, to the parameters.

mod common;
mod flight;
mod render;

use common::{seed_of, wetcor, Place};
use flight::Bounces;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use render::{render, tiff, Scene};

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

#[test]
fn frames_go_to_parameters() {
    const NAME: &str = "frames_go_to_parameters";
    let place = Place::new(SCENE);
    let folder = place.folder.path();
    let mut list = "file,particle,liquid,diameter_mm,film_um,frame_rate_Hz,scale_px_per_mm\n".to_owned();
    let runs = common::rows(&place.scene, seed_of(NAME));
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
    runs.par_iter().enumerate().for_each(|(number, run)| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed_of(NAME) ^ number as u64);
        let bounces = Bounces {
            contact: rng.random_range(0.070..0.074),
            impact_speed: run.impact_speed,
            restitution: run.restitution,
        };
        let radius = 0.5 * 4.762e-3 * SCALE;
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
            seed: number as u64,
            ..Scene::default()
        };
        let centre = |frame: f64| (40.2, PLATE - radius - SCALE * bounces.height(frame / FRAME_RATE));
        let frames = ((bounces.second_contact() + 0.01) * FRAME_RATE) as usize;
        let pictures = (0..frames).map(|frame| render(&scene, centre, frame));
        tiff(&folder.join(format!("drop{number}.tif")), false, pictures);
    });
    std::fs::write(folder.join("recordings.csv"), list).expect("writable");
    let (status, stdout, stderr) = wetcor(
        folder,
        &["track", "recordings.csv", "--out", "runs.csv", "--report", "tracked"],
    );
    assert_eq!(status, Some(0), "{stderr}");
    println!("{stdout}{stderr}");
    let read = place.read();
    assert_eq!(
        (read.rows, read.runs.len()),
        (runs.len(), runs.len()),
        "{stdout}{stderr}"
    );
    let (status, _, stderr) = wetcor(
        folder,
        &[
            "fit",
            "scene.toml",
            "--out",
            "out",
            "--stages",
            "least_squares,posterior",
        ],
    );
    assert!(matches!(status, Some(0 | 1)), "{stderr}");
    let findings = std::fs::read(folder.join("out/findings.json")).expect("written");
    let findings: serde_json::Value = serde_json::from_slice(&findings).expect("JSON");
    let parameters = findings["main"]["parameters"].as_array().expect("parameters");
    for (name, truth) in [
        ("dry_k[PTFE]", 0.183),
        ("lubrication_log", 1.9),
        ("inertial_prefactor", 0.45),
    ] {
        let of = parameters.iter().find(|of| of["name"] == name);
        let of = of.unwrap_or_else(|| panic!("{name} is told"));
        let end = |place: usize| of["interval"][place].as_f64().expect("a number");
        println!("{name}: {of}");
        assert!(end(0) < truth && truth < end(1), "{name}: {of}");
    }
}
