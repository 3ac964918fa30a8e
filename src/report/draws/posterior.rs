//! Gathers what ArviZ looks for: posterior, sample statistics, likelihood and predictions of each run, the runs themselves.

use rayon::prelude::*;
use serde_json::{json, Map, Value};

use super::csv;
use super::zarr::{store, Array, Group, Values};
use crate::error::Error;
use crate::findings::compare::{name, MOST_DENSITIES};
use crate::findings::posterior::Posterior;
use crate::inference::diagnostics::loo::SAME;
use crate::inference::nuts::Chain;
use crate::model::likelihood::pointwise::{At, Pointwise};
use crate::model::parameters::Kind;
use crate::report::folder::File;
use crate::report::Told;
use crate::runs::Runs;
use crate::scene::{Scene, DRY};
use crate::seed::stream;

/// Where the store lies in a report's folder.
const STORE: &str = "draws/draws.zarr";

/// An array with what it needs to live.
struct Owned {
    name: String,
    dimensions: Vec<&'static str>,
    shape: Vec<usize>,
    values: Column,
}

enum Column {
    Real(Vec<f64>),
    /// reals as the bytes of the file
    Bytes(Vec<u8>),
    Whole(Vec<i64>),
    Flag(Vec<bool>),
    Text(Vec<String>),
}

/// A group with its arrays.
struct OwnedGroup {
    name: &'static str,
    arrays: Vec<Owned>,
}

impl OwnedGroup {
    fn new(name: &'static str) -> OwnedGroup {
        OwnedGroup { name, arrays: vec![] }
    }

    fn add(&mut self, name: impl Into<String>, dimensions: &[(&'static str, usize)], values: Column) {
        self.arrays.push(Owned {
            name: name.into(),
            dimensions: dimensions.iter().map(|(name, _)| *name).collect(),
            shape: dimensions.iter().map(|(_, length)| *length).collect(),
            values,
        });
    }

    /// The coordinates of chains and draws, from 0.
    fn of_draws(name: &'static str, size: Size) -> OwnedGroup {
        let mut group = OwnedGroup::new(name);
        group.count("chain", size.chains);
        group.count("draw", size.draws);
        group
    }

    fn count(&mut self, dimension: &'static str, length: usize) {
        let numbers = (0i64..).take(length).collect();
        self.add(dimension, &[(dimension, length)], Column::Whole(numbers));
    }
}

#[derive(Clone, Copy)]
struct Size {
    chains: usize,
    draws: usize,
}

impl Size {
    fn dimensions(self) -> [(&'static str, usize); 2] {
        [("chain", self.chains), ("draw", self.draws)]
    }
}

/// Whether the likelihood of each run at each draw is stored, too.
pub fn stores_every_run(runs: &Runs, posterior: &Posterior) -> bool {
    runs.len().saturating_mul(posterior.sampled.draws()) <= MOST_DENSITIES
}

/// Every file of the draws: a Zarr store and a table.
///
/// Groups `posterior`, `sample_stats`, `log_prior`, `derived`, `observed_data` and `constant_data`, and while runs times
/// draws are at most [`MOST_DENSITIES`], `log_likelihood` and `posterior_predictive`. Runs are in the order of the report.
pub fn files(told: Told, posterior: &Posterior) -> Result<Vec<File>, Error> {
    let (scene, runs) = (told.scene, told.runs);
    let sampled = &posterior.sampled;
    let size = Size {
        chains: sampled.chains.len(),
        draws: sampled.chains.first().map_or(0, |chain| chain.ln_density.len()),
    };
    let mut groups = vec![
        parameters("posterior", scene, posterior, size, |_, values| values.to_vec()),
        sample_stats(&sampled.chains, size),
        parameters("log_prior", scene, posterior, size, |place, values| {
            let prior = &sampled.parameters.sampled[place].prior;
            let density = |x: &f64| prior.ln_density(*x).map_or(f64::NEG_INFINITY, |(value, _)| value);
            values.iter().map(density).collect()
        }),
        derived(posterior, size),
    ];
    let asked = posterior.asked;
    if stores_every_run(runs, posterior) {
        let pointwise = Pointwise::new(scene, runs, asked.inertia, asked.dry_speed);
        groups.extend(every_run(&pointwise, posterior, size, told.findings.seed));
    }
    groups.push(observed(runs));
    groups.push(constant(scene, runs));
    let attributes: Map<String, Value> = [
        ("title", json!(scene.title)),
        ("model", json!(name(asked.inertia, asked.dry_speed))),
        ("creation_library", json!("wetcor")),
        ("creation_library_version", json!(told.findings.wetcor)),
        ("seed", json!(told.findings.seed)),
        ("data_sha256", json!(told.findings.data_sha256)),
        ("scene_sha256", json!(told.findings.scene_sha256)),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value))
    .collect();
    let dimensions: Vec<Vec<Vec<&str>>> = groups
        .iter()
        .map(|group| group.arrays.iter().map(|array| array.dimensions.clone()).collect())
        .collect();
    let borrowed: Vec<Group> = groups
        .iter_mut()
        .zip(&dimensions)
        .map(|(group, dimensions)| Group {
            name: group.name,
            attributes: Map::new(),
            arrays: group
                .arrays
                .iter_mut()
                .zip(dimensions)
                .map(|(array, of)| borrow(array, of))
                .collect(),
        })
        .collect();
    let mut files = store(STORE, attributes, borrowed)?;
    let columns: Vec<(&str, Vec<f64>)> = sampled
        .parameters
        .sampled
        .iter()
        .zip(&sampled.values)
        .map(|(parameter, chains)| (parameter.name.as_str(), chains.concat()))
        .collect();
    let columns: Vec<(&str, &[f64])> = columns
        .iter()
        .map(|(name, values)| (*name, values.as_slice()))
        .collect();
    let table = csv::table(size.chains, size.draws, &columns)?;
    files.push(("draws/draws.csv".to_owned(), table.into_bytes()));
    Ok(files)
}

fn borrow<'a>(array: &'a mut Owned, dimensions: &'a [&'a str]) -> Array<'a> {
    Array {
        name: &array.name,
        dimensions,
        shape: &array.shape,
        values: match &mut array.values {
            Column::Real(values) => Values::F64(values),
            Column::Bytes(bytes) => Values::Bytes(std::mem::take(bytes)),
            Column::Whole(values) => Values::I64(values),
            Column::Flag(values) => Values::Bool(values),
            Column::Text(values) => Values::Text(values),
        },
    }
}

/// One variable a parameter, chain after chain; the k of all particles are one variable.
fn parameters(
    group: &'static str,
    scene: &Scene,
    posterior: &Posterior,
    size: Size,
    of: impl Fn(usize, &[f64]) -> Vec<f64>,
) -> OwnedGroup {
    let mut group = OwnedGroup::of_draws(group, size);
    let [chain, draw] = size.dimensions();
    let (mut particles, mut dry_k) = (vec![], vec![]);
    let sampled = &posterior.sampled;
    for (place, parameter) in sampled.parameters.sampled.iter().enumerate() {
        let values = of(place, &sampled.values[place].concat());
        match parameter.kind {
            Kind::DryK(particle) => {
                particles.push(scene.particles[particle].name.clone());
                dry_k.push(values);
            }
            _ => group.add(&parameter.name, &[chain, draw], Column::Real(values)),
        }
    }
    if !particles.is_empty() {
        let count = particles.len();
        let woven = (0..size.chains * size.draws)
            .flat_map(|i| dry_k.iter().map(move |values| values[i]))
            .collect();
        group.add("particle", &[("particle", count)], Column::Text(particles));
        group.add("dry_k", &[chain, draw, ("particle", count)], Column::Real(woven));
    }
    group
}

fn sample_stats(chains: &[Chain], size: Size) -> OwnedGroup {
    let mut group = OwnedGroup::of_draws("sample_stats", size);
    let real = |of: fn(&Chain) -> &Vec<f64>| Column::Real(chains.iter().flat_map(of).copied().collect());
    let whole = |of: fn(&Chain) -> &Vec<u64>| {
        // depths and steps are far below the largest i64
        let numbers = chains
            .iter()
            .flat_map(of)
            .map(|n| i64::try_from(*n).unwrap_or(i64::MAX));
        Column::Whole(numbers.collect())
    };
    let dimensions = size.dimensions();
    group.add("lp", &dimensions, real(|chain| &chain.ln_density));
    // draws that followed no trajectory have no more to tell
    if chains.iter().all(|chain| chain.steps.is_empty()) {
        return group;
    }
    group.add("acceptance_rate", &dimensions, real(|chain| &chain.acceptance_rate));
    group.add("step_size", &dimensions, real(|chain| &chain.step_size));
    group.add("tree_depth", &dimensions, whole(|chain| &chain.tree_depth));
    group.add("n_steps", &dimensions, whole(|chain| &chain.steps));
    let diverging = chains.iter().flat_map(|chain| &chain.diverging).copied().collect();
    group.add("diverging", &dimensions, Column::Flag(diverging));
    group.add("energy", &dimensions, real(|chain| &chain.energy));
    group
}

/// What follows from the parameters, a variable each; apart from them, so that nobody counts them as parameters.
fn derived(posterior: &Posterior, size: Size) -> OwnedGroup {
    let mut group = OwnedGroup::of_draws("derived", size);
    for derived in &posterior.derived {
        group.add(&derived.name, &size.dimensions(), Column::Real(derived.values.concat()));
    }
    group
}

/// Log likelihood of each run at each draw, and a new run from each.
fn every_run(pointwise: &Pointwise, posterior: &Posterior, size: Size, seed: u64) -> [OwnedGroup; 2] {
    let full = posterior.sampled.full_draws();
    let runs = pointwise.len();
    let at: Vec<At> = full.par_iter().map(|full| pointwise.at(full)).collect();
    let telling = telling(pointwise, &at);
    let everyone: Vec<usize> = (0..runs).collect();
    let likely = in_bytes(&at, telling.len(), |_, at, row| {
        for (value, run) in row.iter_mut().zip(&telling) {
            *value = at.ln_likelihood(*run).to_le_bytes();
        }
    });
    let predicted = in_bytes(&at, runs, |draw, at, row| {
        let mut rng = stream(seed, "posterior_predictive", draw);
        for (run, value) in row.iter_mut().enumerate() {
            *value = at.predict(run, &mut rng).to_le_bytes();
        }
    });
    [
        ("log_likelihood", likely, telling),
        ("posterior_predictive", predicted, everyone),
    ]
    .map(|(name, values, of)| {
        let mut group = OwnedGroup::of_draws(name, size);
        let [chain, draw] = size.dimensions();
        // run numbers are far below the largest i64
        let numbers = of.iter().map(|run| i64::try_from(*run).unwrap_or(i64::MAX)).collect();
        group.add("run", &[("run", of.len())], Column::Whole(numbers));
        group.add("restitution", &[chain, draw, ("run", of.len())], Column::Bytes(values));
        group
    })
}

/// So many numbers for each draw, as bytes.
fn in_bytes(at: &[At], width: usize, fill: impl Fn(u64, &At, &mut [[u8; 8]]) + Sync) -> Vec<u8> {
    let mut bytes = vec![0; 8 * width * at.len()];
    let rows = bytes.par_chunks_exact_mut(8 * width.max(1)).zip(at).enumerate();
    rows.for_each(|(draw, (row, at))| fill(draw as u64, at, row.as_chunks_mut().0));
    bytes
}

/// The runs that are not as likely under every draw.
///
/// One that stuck for certain has a log likelihood of 0 whatever the parameters: it adds nothing to any sum, and ArviZ's
/// LOO refuses the whole for it.
fn telling(pointwise: &Pointwise, at: &[At]) -> Vec<usize> {
    let varies = |run: &usize| {
        if !pointwise.is_stuck(*run) {
            return true;
        }
        let values = at.iter().map(|at| at.ln_likelihood(*run));
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (lo, hi) = values.fold(start, |(lo, hi), value| (lo.min(value), hi.max(value)));
        hi - lo > SAME
    };
    (0..pointwise.len()).into_par_iter().filter(varies).collect()
}

fn observed(runs: &Runs) -> OwnedGroup {
    let mut group = OwnedGroup::new("observed_data");
    group.count("run", runs.len());
    let of_runs = [("run", runs.len())];
    group.add("restitution", &of_runs, Column::Real(runs.restitution.clone()));
    let mut stuck = vec![false; runs.len()];
    let dry = runs.dry.iter().map(|dry| dry.stuck.clone());
    for range in dry.chain(runs.series.iter().map(|series| series.stuck.clone())) {
        stuck[range].fill(true);
    }
    group.add("stuck", &of_runs, Column::Flag(stuck));
    group
}

fn constant(scene: &Scene, runs: &Runs) -> OwnedGroup {
    let mut group = OwnedGroup::new("constant_data");
    group.count("run", runs.len());
    let of_runs = [("run", runs.len())];
    let mut particle = vec![String::new(); runs.len()];
    let mut liquid = vec![DRY.to_owned(); runs.len()];
    for dry in &runs.dry {
        particle[dry.rebounds.start..dry.stuck.end].fill(scene.particles[dry.particle].name.clone());
    }
    for series in &runs.series {
        particle[series.runs()].fill(scene.particles[series.particle].name.clone());
        liquid[series.runs()].fill(scene.liquids[series.liquid].name.clone());
    }
    group.add("particle_name", &of_runs, Column::Text(particle));
    group.add("liquid_name", &of_runs, Column::Text(liquid));
    for (name, column) in [
        ("diameter_m", &runs.diameter),
        ("film_m", &runs.film),
        ("impact_speed_m_s", &runs.impact_speed),
    ] {
        group.add(name, &of_runs, Column::Real(column.clone()));
    }
    group
}
