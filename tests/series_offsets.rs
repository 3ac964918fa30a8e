//! Holds what is inferred to the truth where the runs of a series share an offset of the energy kept.

mod common;

use common::{rows_from, seed_of, table_of};
use rayon::prelude::*;
use std::path::Path;
use wetcor::findings;
use wetcor::findings::posterior::{effort, start};
use wetcor::inference::diagnostics::summary::summarise;
use wetcor::inference::nuts::{divergences, Effort};
use wetcor::inference::prepared_posterior::Evaluation;
use wetcor::inference::sampling::{sample_posterior, Sampled, SamplingPlan};
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::ModelParameters;
use wetcor::runs::{self, Table};
use wetcor::scene::{self, Scene};
use wetcor::seed::{stream, StreamName};

/// Three diameters, two liquids, three film ratios: 18 series of five heights.
fn scene(sigma: f64, repeats: usize, model: &str) -> Scene {
    let text = format!(
        r#"
title = "offsets of series"
[data]
runs = "runs.csv"
[particles.PTFE]
density_kg_m3 = 2150
roughness_um = 5
[liquids.thin]
density_kg_m3 = 930
viscosity_mPa_s = 9.3
[liquids.thick]
density_kg_m3 = 960
viscosity_mPa_s = 20
[model]
inertia = "stepwise"
{model}
[truth]
dry_k = {{ PTFE = 0.183 }}
lubrication_log = 1.85
inertial_prefactor = 1.2
sigma_dry = 0.01
sigma_wet = 0.02
sigma_series = {sigma}
[design]
diameter_mm = {{ PTFE = [3.175, 4.762, 8.0] }}
liquids = ["thin", "thick"]
film_ratio = {{ PTFE = [0.04, 0.07, 0.1] }}
height_mm = [30, 60, 90, 120, 150]
dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]
repeats = {repeats}
"#
    );
    scene::parse(&text, Path::new("a/scene.toml"), String::new()).unwrap_or_else(|error| panic!("{error}"))
}

fn table(scene: &Scene, seed: u64) -> Table {
    table_of(runs::arrange(scene, &rows_from(scene, stream(seed, "series offsets", 0))))
}

fn sample(scene: &Scene, table: &Table, each: [usize; 2], seed: u64) -> Sampled {
    let least_squares = findings::fit_least_squares(scene, table, 1, false);
    let form = scene.model.form();
    let parameters = ModelParameters::of(scene, &table.runs, form).expect("priors with room");
    let rows = Likelihood::of_rows(scene, &table.runs, form);
    let plan = SamplingPlan {
        effort: Effort {
            warmup: each[0],
            draws: each[1],
            ..effort(scene)
        },
        stream: StreamName::new(seed, "series offsets"),
        evaluation: Evaluation::default(),
    };
    let start = start(least_squares.least_squares());
    sample_posterior(parameters, &rows, &start, plan, &|_, _| {}).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[ignore = "prints"]
fn efficiency() {
    for (sigma, repeats) in [(0.006, 5), (0.01, 5), (0.01, 400), (0.002, 5), (0.03, 400)] {
        let scene = scene(sigma, repeats, "series_offsets = true");
        let table = table(&scene, 3);
        let began = std::time::Instant::now();
        let sampled = sample(&scene, &table, [1000, 1000], 1);
        let steps: u64 = sampled.chains.iter().flat_map(|c| &c.steps).sum();
        println!(
            "sigma {sigma} runs {} nodes {:?} prep {:.2} s, sampling {:.2}: divergences {} steps/draw {:.1} accept {}",
            table.runs.len(), sampled.compression, sampled.seconds[0], began.elapsed().as_secs_f64(), divergences(&sampled.chains),
            steps as f64 / sampled.draws() as f64, sampled.target_accept
        );
        for (p, v) in sampled.parameters.sampled.iter().zip(&sampled.values) {
            let s = summarise(&v.iter().map(Vec::as_slice).collect::<Vec<_>>());
            println!("  {} {:.5} ± {:.5} ess {:.0} {:.0} rhat {:.4}", p.name, s.mean.unwrap(), s.sd.unwrap(), s.ess_bulk.unwrap(), s.ess_tail.unwrap(), s.rhat.unwrap());
        }
        let worst = sampled.series_offsets.iter().map(|v| {
            let s = summarise(&v.iter().map(Vec::as_slice).collect::<Vec<_>>());
            s.ess_bulk.unwrap()
        }).fold(f64::INFINITY, f64::min);
        println!("  worst offset ess {worst:.0}");
    }
    let _ = (0..1).into_par_iter().count();
}
