//! Writes draws as a report does, with what our diagnostics say of them, for `tests/arviz_opens_draws.py` to open.
//!
//! The report is left in the folder that Cargo keeps for tests (`target/tmp/made_up_report`).

use std::path::Path;

use rand::RngExt;
use serde_json::{json, Map, Value};
use wetcor::inference::diagnostics::energy::e_bfmi;
use wetcor::inference::diagnostics::loo;
use wetcor::inference::diagnostics::pareto::khat_threshold;
use wetcor::inference::diagnostics::summary::{summarise, Summary};
use wetcor::report::draws::arrays::{ArrayDimension, ArrayGroup, ArrayValues, DrawArray, DrawSize};
use wetcor::report::draws::csv;
use wetcor::report::draws::zarr::store;
use wetcor::report::folder::{Contents, Destination, File, Files};
use wetcor::seed;

const CHAINS: usize = 4;
const DRAWS: usize = 250;
const TITLE: &str = "Made-up draws";

/// Chains with memory about a centre, chain after chain.
fn wander(name: &str, centre: f64, sd: f64) -> Vec<f64> {
    let mut values = Vec::with_capacity(CHAINS * DRAWS);
    for chain in 0..CHAINS {
        let mut rng = seed::stream(1, name, chain as u64);
        let mut x = 0.0;
        for _ in 0..DRAWS {
            // variance 1/12 of the step, kept by 0.6² + 0.8²
            x = 0.6 * x + 0.8 * (rng.random::<f64>() - 0.5);
            values.push(centre + sd * 12f64.sqrt() * x);
        }
    }
    values
}

fn summary_of(values: &[f64]) -> Summary {
    let chains: Vec<&[f64]> = values.chunks(DRAWS).collect();
    summarise(&chains)
}

fn reals(values: &[f64]) -> ArrayValues {
    ArrayValues::reals(values.iter().copied())
}

/// A report's files: findings.json, draws.csv and the store.
fn report() -> Vec<File> {
    let particles = ["PTFE".to_owned(), "PE".to_owned()];
    let labels = ["run 1".to_owned(), "run 2 (µ)".to_owned(), "3".to_owned()];
    let observed = [0.52, 0.61, 0.0];
    let of_particle = [wander("dry_k[PTFE]", 0.18, 0.002), wander("dry_k[PE]", 0.12, 0.001)];
    let sigma = wander("sigma_wet", 0.1, 0.005);
    let centre = wander("centre", 0.4, 0.05);
    let dry_k: Vec<f64> = (0..CHAINS * DRAWS)
        .flat_map(|i| [of_particle[0][i], of_particle[1][i]])
        .collect();
    let density = |run: usize, draw: usize| {
        let z = (observed[run] - centre[draw]) / sigma[draw];
        -0.5 * z * z - sigma[draw].ln()
    };
    let runs = observed.len();
    let log_likelihood: Vec<f64> = (0..CHAINS * DRAWS)
        .flat_map(|draw| (0..runs).map(move |run| (run, draw)))
        .map(|(run, draw)| density(run, draw))
        .collect();
    let energy = wander("energy", 3.0, 1.0);
    let steps = vec![7i64; CHAINS * DRAWS];
    let mut diverging = vec![false; CHAINS * DRAWS];
    diverging[17] = true;

    let parameters = [
        ("dry_k[PTFE]", &of_particle[0]),
        ("dry_k[PE]", &of_particle[1]),
        ("sigma_wet", &sigma),
        ("centre", &centre),
    ];
    let summaries: Vec<Summary> = parameters.iter().map(|(_, values)| summary_of(values)).collect();
    let ess_of_means: Vec<f64> = summaries.iter().filter_map(|summary| summary.ess_mean).collect();
    assert_eq!(ess_of_means.len(), parameters.len());
    let r_eff = loo::relative_efficiency(&ess_of_means, CHAINS, CHAINS * DRAWS);
    let left_out = loo::loo(
        runs,
        loo::LooDraws {
            count: CHAINS * DRAWS,
            r_eff,
        },
        |some, rows| {
            for (run, row) in some.zip(rows.chunks_mut(CHAINS * DRAWS)) {
                row.iter_mut()
                    .enumerate()
                    .for_each(|(draw, value)| *value = density(run, draw));
            }
        },
    )
    .expect("finite densities");
    let said: Vec<Value> = parameters
        .iter()
        .zip(&summaries)
        .map(|((name, _), s)| json!({"name": name, "rhat": s.rhat, "ess_bulk": s.ess_bulk, "ess_tail": s.ess_tail}))
        .collect();
    let findings = json!({
        "schema": wetcor::findings::SCHEMA,
        "title": TITLE,
        "posterior": {
            "parameters": said,
            "e_bfmi": energy.chunks(DRAWS).map(e_bfmi).collect::<Vec<_>>(),
            "divergences": 1,
        },
        "compare": [{
            "model": "stepwise/2",
            "elpd_loo": left_out.elpd,
            "se": left_out.se,
            "p_loo": left_out.p_loo,
            "khat_max": left_out.worst_khat(khat_threshold(CHAINS * DRAWS)).0,
        }],
    });

    let size = DrawSize {
        chains: CHAINS,
        draws: DRAWS,
    };
    let [chain, draw] = size.dimensions();
    let (particle, run) = (ArrayDimension::new("particle", 2), ArrayDimension::new("run", runs));
    let with_draws = |name, arrays: Vec<DrawArray>| {
        let mut group = ArrayGroup::of_draws(name, size);
        group.arrays.extend(arrays);
        group
    };
    let array = |name: &str, dimensions: &[ArrayDimension], values| DrawArray::new(name, dimensions, values);
    let each = |name: &str, values: &[f64]| array(name, &[chain, draw], reals(values));
    let labels = || array("run", &[run], ArrayValues::texts(&labels));
    let each_run = |name| {
        let restitution = array("restitution", &[chain, draw, run], reals(&log_likelihood));
        with_draws(name, vec![restitution, labels()])
    };
    let dry_k = array("dry_k", &[chain, draw, particle], reals(&dry_k));
    let particles = array("particle", &[particle], ArrayValues::texts(&particles));
    let counts = |name: &str| array(name, &[chain, draw], ArrayValues::counts(steps.clone()));
    let groups = vec![
        with_draws(
            "posterior",
            vec![dry_k, particles, each("sigma_wet", &sigma), each("centre", &centre)],
        ),
        with_draws(
            "sample_stats",
            vec![
                each("lp", &energy),
                each("acceptance_rate", &sigma),
                each("step_size", &sigma),
                each("energy", &energy),
                counts("tree_depth"),
                counts("n_steps"),
                array("diverging", &[chain, draw], ArrayValues::flags(diverging)),
            ],
        ),
        each_run("log_likelihood"),
        with_draws("log_prior", vec![each("sigma_wet", &energy)]),
        each_run("posterior_predictive"),
        ArrayGroup {
            name: "observed_data",
            arrays: vec![array("restitution", &[run], reals(&observed)), labels()],
        },
        ArrayGroup {
            name: "constant_data",
            arrays: vec![array("impact_speed", &[run], reals(&[1.0, 2.0, 0.3])), labels()],
        },
    ];
    let attributes = Map::from_iter([("model".to_owned(), json!("stepwise/2"))]);
    let mut files = store("draws/draws.zarr", attributes, groups).expect("values as the shapes ask");
    let columns = parameters.map(|(name, values)| (name, values.clone()));
    let table = csv::table(size, &columns).expect("as many values as draws");
    files.push(("draws/draws.csv".to_owned(), table.into_bytes()));
    files.push(("findings.json".to_owned(), findings.to_string().into_bytes()));
    files
}

#[test]
fn a_report_with_draws_is_written_whole() {
    let files = report();
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("made_up_report");
    let written = Files {
        whole: files.clone(),
        ..Files::default()
    };
    let destination = Destination::prepare(&place, Contents::Fit, TITLE, &[]);
    destination
        .and_then(|destination| destination.write(written))
        .unwrap_or_else(|error| panic!("{error}"));
    for (name, bytes) in &files {
        let written = std::fs::read(place.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(&written, bytes, "{name}");
    }
    assert_eq!(report(), files, "the same draws give the same bytes");
}
