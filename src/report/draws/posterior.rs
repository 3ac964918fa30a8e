//! Gathers what ArviZ looks for: posterior, sample statistics, likelihood and predictions of each run, the runs themselves.

use std::sync::Arc;

use serde_json::{json, Map, Value};

use super::csv;
use super::every_run::EveryRun;
use super::tie::{Tie, STORE, TABLE};
use super::zarr::{chunk_path, store, Array, Group, Values, PART};
use crate::error::Error;
use crate::findings::compare::{name, MOST_DENSITIES};
use crate::findings::posterior::Posterior;
use crate::inference::nuts::Chain;
use crate::model::parameters::Kind;
use crate::report::folder::{Files, Streamed};
use crate::report::Told;
use crate::runs::Runs;
use crate::scene::{Scene, DRY};

/// An array with what it needs to live.
struct Owned {
    name: String,
    dimensions: Vec<&'static str>,
    shape: Vec<usize>,
    values: Column,
}

enum Column {
    Real(Vec<f64>),
    /// reals as they lie in the file: many enough that each copy of them is felt
    Bytes(Vec<u8>),
    /// reals that are not here
    Apart,
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

    fn has(&self, name: &str) -> bool {
        self.arrays.iter().any(|array| array.name == name)
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

/// The draws, ready to be written.
pub struct Gathered<'a> {
    groups: Vec<OwnedGroup>,
    streamed: Vec<Streamed<'a>>,
    attributes: Map<String, Value>,
    table: String,
}

/// Gathers the draws: what makes a Zarr store and a table of them.
///
/// Groups `posterior`, `sample_stats`, `log_prior`, `derived`, `observed_data` and `constant_data`, and while runs times
/// draws are at most [`MOST_DENSITIES`], `log_likelihood` and `posterior_predictive` (new runs), to f32. Runs are in the
/// order of the report.
pub fn gather<'a>(told: Told<'a>, posterior: &Posterior) -> Result<Gathered<'a>, Error> {
    let (scene, runs) = (told.scene, told.runs);
    let sampled = &posterior.sampled;
    let size = Size {
        chains: sampled.chains.len(),
        draws: sampled.chains.first().map_or(0, |chain| chain.ln_density.len()),
    };
    let every_run = || stores_every_run(runs, posterior).then(|| EveryRun::new(told, posterior));
    let rest = || {
        let groups = vec![
            parameters("posterior", scene, posterior, size, |_, values| values.to_vec()),
            sample_stats(&sampled.chains, size),
            parameters("log_prior", scene, posterior, size, |place, values| {
                let prior = &sampled.parameters.sampled[place].prior;
                let density = |x: &f64| prior.ln_density(*x).map_or(f64::NEG_INFINITY, |(value, _)| value);
                values.iter().map(density).collect()
            }),
            derived(posterior, size),
        ];
        (groups, table(posterior, size))
    };
    let (every_run, (mut groups, table)) = rayon::join(every_run, rest);
    let asked = posterior.asked;
    let mut streamed = vec![];
    if let Some(every_run) = every_run {
        groups.extend(every_run_groups(&every_run, runs.len(), size));
        streamed = every_run_files(every_run, size);
    }
    groups.push(observed(runs));
    groups.push(constant(scene, runs));
    let attributes = [
        ("title", json!(scene.title)),
        ("model", json!(name(asked.form))),
        ("creation_library", json!("wetcor")),
        ("creation_library_version", json!(told.findings.wetcor)),
        ("seed", json!(told.findings.seed)),
        ("data_sha256", json!(told.findings.data_sha256)),
        ("scene_sha256", json!(told.findings.scene_sha256)),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value));
    Ok(Gathered {
        groups,
        streamed,
        attributes: attributes.collect(),
        table: table?,
    })
}

impl<'a> Gathered<'a> {
    /// Every file of the draws, tied to the bytes of `findings.json`.
    pub fn files(mut self, findings: &[u8]) -> Result<Files<'a>, Error> {
        let table = self.table.into_bytes();
        let tie = Tie::of(findings, &table);
        self.attributes.extend(tie.attributes());
        let dimensions: Vec<Vec<Vec<&str>>> = self
            .groups
            .iter()
            .map(|group| group.arrays.iter().map(|array| array.dimensions.clone()).collect())
            .collect();
        let borrowed: Vec<Group> = self
            .groups
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
        let mut whole = store(STORE, self.attributes, borrowed)?;
        whole.push((TABLE.to_owned(), table));
        Ok(Files {
            whole,
            streamed: self.streamed,
            last: None,
        })
    }
}
/// The sampled parameters as one table.
fn table(posterior: &Posterior, size: Size) -> Result<String, Error> {
    let sampled = &posterior.sampled;
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
    csv::table(size.chains, size.draws, &columns)
}

fn borrow<'a>(array: &'a mut Owned, dimensions: &'a [&'a str]) -> Array<'a> {
    Array {
        name: &array.name,
        dimensions,
        shape: &array.shape,
        values: match &mut array.values {
            Column::Real(values) => Values::F64(values),
            Column::Bytes(bytes) => Values::F64Bytes(std::mem::take(bytes)),
            Column::Apart => Values::Apart,
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
                dry_k.push(vec![values]);
            }
            _ => group.add(&parameter.name, &[chain, draw], Column::Real(values)),
        }
    }
    if !particles.is_empty() {
        let count = particles.len();
        group.add("particle", &[("particle", count)], Column::Text(particles));
        group.add(
            "dry_k",
            &[chain, draw, ("particle", count)],
            Column::Bytes(woven(&dry_k.iter().collect::<Vec<_>>())),
        );
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

/// What follows from the parameters, one variable for all particles or settings; apart from them, so that nobody counts
/// them as parameters.
fn derived(posterior: &Posterior, size: Size) -> OwnedGroup {
    let mut group = OwnedGroup::of_draws("derived", size);
    let [chain, draw] = size.dimensions();
    for of_one in posterior.derived.chunk_by(|a, b| a.quantity == b.quantity) {
        let labels: Vec<String> = of_one.iter().filter_map(|derived| derived.label.clone()).collect();
        let values: Vec<&Vec<Vec<f64>>> = of_one.iter().map(|derived| &derived.values).collect();
        let of = (
            if of_one[0].setting.is_some() {
                "setting"
            } else {
                "particle"
            },
            of_one.len(),
        );
        let dimensions = if labels.is_empty() {
            vec![chain, draw]
        } else {
            vec![chain, draw, of]
        };
        group.add(of_one[0].quantity, &dimensions, Column::Bytes(woven(&values)));
        if !labels.is_empty() && !group.has(of.0) {
            group.add(of.0, &[of], Column::Text(labels));
        }
    }
    group
}

/// Every column's value at the first draw of the first chain, then at the next; columns have their draws by chain.
fn woven(columns: &[&Vec<Vec<f64>>]) -> Vec<u8> {
    let lengths = columns
        .first()
        .map_or(vec![], |first| first.iter().map(Vec::len).collect());
    let numbers = columns.len() * lengths.iter().sum::<usize>();
    let mut bytes = Vec::with_capacity(size_of::<f64>() * numbers);
    for (chain, draws) in lengths.into_iter().enumerate() {
        for draw in 0..draws {
            for column in columns {
                bytes.extend_from_slice(&column[chain][draw].to_le_bytes());
            }
        }
    }
    bytes
}

/// Log likelihood of each run at each draw, and a new run from each; the numbers themselves are written apart.
fn every_run_groups(every_run: &EveryRun, runs: usize, size: Size) -> [OwnedGroup; 2] {
    let everyone: Vec<usize> = (0..runs).collect();
    [
        ("log_likelihood", &every_run.telling),
        ("posterior_predictive", &everyone),
    ]
    .map(|(name, of)| {
        let mut group = OwnedGroup::of_draws(name, size);
        let [chain, draw] = size.dimensions();
        // run numbers are far below the largest i64
        let numbers = of.iter().map(|run| i64::try_from(*run).unwrap_or(i64::MAX)).collect();
        group.add("run", &[("run", of.len())], Column::Whole(numbers));
        group.add("restitution", &[chain, draw, ("run", of.len())], Column::Apart);
        group
    })
}

/// The files of those numbers, pairs of the same draws.
fn every_run_files(every_run: EveryRun, size: Size) -> Vec<Streamed> {
    let every_run = Arc::new(every_run);
    let parts = (0..size.chains).flat_map(|chain| (0..size.draws.div_ceil(PART)).map(move |part| (chain, part)));
    let of_part = |(chain, part): (usize, usize)| {
        let every_run = every_run.clone();
        let first = chain * size.draws;
        let draws = first + part * PART..first + size.draws.min((part + 1) * PART);
        let whole = PART.min(size.draws);
        Streamed {
            names: ["log_likelihood", "posterior_predictive"]
                .map(|group| chunk_path(STORE, group, "restitution", &[chain, part, 0])),
            fill: Box::new(move |[likelihood, predictive]| {
                every_run.write(draws.clone(), whole, likelihood, predictive)
            }),
        }
    };
    parts.map(of_part).collect()
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
