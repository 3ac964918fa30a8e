//! Gathers what ArviZ looks for: posterior, sample statistics, likelihood and predictions of each run, the runs themselves.

use std::sync::Arc;

use serde_json::json;

use super::arrays::{ArrayGroup, ArrayValues};
use super::csv;
use super::every_run::EveryRun;
use super::zarr::{chunk_path, store, PART};
use crate::error::Error;
use crate::findings::compare::model_name;
use crate::findings::posterior::run_densities::MOST_DENSITIES;
use crate::findings::posterior::Posterior;
use crate::inference::importance::DrawCounts;
use crate::inference::nuts::Chain;
use crate::model::parameters::{ParameterKind, SERIES_OFFSET};
use crate::report::folder::{Files, Streamed};
use crate::report::ReportInput;
use crate::runs::Runs;
use crate::scene::{Scene, DRY};

/// Whether the runs themselves are stored, too.
pub fn stores_runs(runs: &Runs) -> bool {
    /// index, restitution, whether it stuck, names of particle and liquid, diameter, film and speed
    const NUMBERS_OF_A_RUN: usize = 8;
    runs.count.is_empty() && runs.len() <= MOST_DENSITIES / NUMBERS_OF_A_RUN
}

/// Where the table of draws lies in a report's folder.
pub const TABLE: &str = "draws/draws.csv";
/// Where the store lies in a report's folder.
pub const STORE: &str = "draws/draws.zarr";

/// Every file of the draws: a Zarr store and a table.
///
/// Groups `posterior`, `sample_stats`, `log_prior` and `derived`; while all numbers of the runs are at most
/// [`MOST_DENSITIES`], `observed_data` and `constant_data`; while runs times draws are, `log_likelihood` and
/// `posterior_predictive` (new runs), to f32. Runs are in the order of the report.
pub fn files<'a>(input: ReportInput<'a>, posterior: &'a Posterior) -> Result<Files<'a>, Error> {
    let (scene, runs) = (input.scene, input.runs);
    let sampled = &posterior.sampled;
    let size = DrawCounts {
        chains: sampled.chains.len(),
        draws: sampled.chains.first().map_or(0, |chain| chain.ln_density.len()),
    };
    let every_run = || EveryRun::new(input, posterior);
    let labels: Vec<String> = runs.spheres.iter().map(|sphere| sphere.label(scene)).collect();
    let series: Vec<String> = runs.series.iter().map(|series| series.label(scene)).collect();
    let rest = || {
        let mut own = parameters("posterior", &labels, posterior, size, |_, values| values.to_vec());
        let offsets: Vec<&[Vec<f64>]> = sampled.series_offsets.iter().map(Vec::as_slice).collect();
        if !offsets.is_empty() {
            own.add_labelled(SERIES_OFFSET, ("series", &series), &offsets);
        }
        let groups = vec![
            own,
            sample_stats(&sampled.chains, size),
            parameters("log_prior", &labels, posterior, size, |place, values| {
                let prior = &sampled.parameters.sampled[place].prior;
                let density = |x: &f64| prior.ln_density(*x).map_or(f64::NEG_INFINITY, |(value, _)| value);
                values.iter().map(density).collect()
            }),
            derived(posterior, size),
        ];
        (groups, table(posterior, size))
    };
    let (every_run, (mut groups, table)) = rayon::join(every_run, rest);
    let form = posterior.setup.form;
    let mut streamed = vec![];
    if let Some(every_run) = every_run {
        groups.extend(every_run_groups(&every_run, runs.len(), size));
        streamed = every_run_files(every_run, size);
    }
    if stores_runs(runs) {
        groups.extend(groups_of_runs(scene, runs));
    }
    let attributes = [
        ("title", json!(scene.title)),
        ("model", json!(model_name(form))),
        ("creation_library", json!("wetcor")),
        ("creation_library_version", json!(input.findings.wetcor)),
        ("seed", json!(input.findings.seed)),
        ("data_sha256", json!(input.findings.data_sha256)),
        ("scene_sha256", json!(input.findings.scene_sha256)),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value));
    let mut whole = store(STORE, attributes.collect(), groups)?;
    whole.push((TABLE.to_owned(), table?));
    Ok(Files {
        whole,
        streamed,
        last: None,
    })
}

/// The sampled parameters, and the offsets of series after them, as one table.
fn table(posterior: &Posterior, size: DrawCounts) -> Result<Vec<u8>, Error> {
    let sampled = &posterior.sampled;
    let parameters = sampled.parameters.sampled.iter().map(|parameter| &parameter.name);
    let names = parameters.chain(&sampled.parameters.series_offsets);
    let draws = sampled.values.iter().chain(&sampled.series_offsets);
    let columns = names.zip(draws).map(|(name, chains)| (name.as_str(), chains.concat()));
    csv::table(size, &columns.collect::<Vec<_>>())
}

/// One variable a parameter, chain after chain; the k of all spheres, of these labels, are one variable.
fn parameters(
    group: &'static str,
    labels: &[String],
    posterior: &Posterior,
    size: DrawCounts,
    of: impl Fn(usize, &[f64]) -> Vec<f64>,
) -> ArrayGroup {
    let mut group = ArrayGroup::of_draws(group, size);
    let (mut particles, mut dry_k) = (vec![], vec![]);
    let sampled = &posterior.sampled;
    for (place, parameter) in sampled.parameters.sampled.iter().enumerate() {
        let chains: Vec<Vec<f64>> = sampled.values[place].iter().map(|chain| of(place, chain)).collect();
        match parameter.kind {
            ParameterKind::DryK(sphere) => {
                particles.push(labels[sphere].clone());
                dry_k.push(chains);
            }
            _ => group.add_draws(&parameter.name, None, ArrayValues::reals(chains.concat())),
        }
    }
    if !particles.is_empty() {
        let columns: Vec<&[Vec<f64>]> = dry_k.iter().map(Vec::as_slice).collect();
        group.add_labelled("dry_k", ("particle", &particles), &columns);
    }
    group
}

fn sample_stats(chains: &[Chain], size: DrawCounts) -> ArrayGroup {
    let mut group = ArrayGroup::of_draws("sample_stats", size);
    let reals = |of: fn(&Chain) -> &Vec<f64>| ArrayValues::reals(chains.iter().flat_map(of).copied());
    let counts = |of: fn(&Chain) -> &Vec<u64>| {
        // depths and steps are far below the largest i64
        let count = |n: &u64| i64::try_from(*n).unwrap_or(i64::MAX);
        ArrayValues::counts(chains.iter().flat_map(of).map(count))
    };
    group.add_draws("lp", None, reals(|chain| &chain.ln_density));
    // draws that followed no trajectory have no more of these
    if chains.iter().all(|chain| chain.steps.is_empty()) {
        return group;
    }
    group.add_draws("acceptance_rate", None, reals(|chain| &chain.acceptance_rate));
    group.add_draws("step_size", None, reals(|chain| &chain.step_size));
    group.add_draws("tree_depth", None, counts(|chain| &chain.tree_depth));
    group.add_draws("n_steps", None, counts(|chain| &chain.steps));
    let diverging = chains.iter().flat_map(|chain| &chain.diverging).copied();
    group.add_draws("diverging", None, ArrayValues::flags(diverging));
    group.add_draws("energy", None, reals(|chain| &chain.energy));
    group
}

/// What follows from the parameters, one variable for all particles or settings; apart from them, so that nobody counts
/// them as parameters.
fn derived(posterior: &Posterior, size: DrawCounts) -> ArrayGroup {
    let mut group = ArrayGroup::of_draws("derived", size);
    for of_one in posterior.derived.chunk_by(|a, b| a.quantity == b.quantity) {
        let labels: Vec<String> = of_one.iter().filter_map(|derived| derived.label.clone()).collect();
        let columns: Vec<&[Vec<f64>]> = of_one.iter().map(|derived| derived.values.as_slice()).collect();
        let (name, by_setting) = (of_one[0].quantity.describe().name, of_one[0].of.film_ratio.is_some());
        if labels.is_empty() {
            group.add_draws(name, None, ArrayValues::interleaved(&columns));
        } else {
            let by = if by_setting { "setting" } else { "particle" };
            group.add_labelled(name, (by, &labels), &columns);
        }
    }
    group
}

/// Log likelihood of each run at each draw, and a new run from each; the numbers themselves are streamed.
fn every_run_groups(every_run: &EveryRun, runs: usize, size: DrawCounts) -> [ArrayGroup; 2] {
    let everyone: Vec<usize> = (0..runs).collect();
    [
        ("log_likelihood", &every_run.informative),
        ("posterior_predictive", &everyone),
    ]
    .map(|(name, of)| {
        let mut group = ArrayGroup::of_draws(name, size);
        let run = ("run", of.len());
        // run numbers are far below the largest i64
        let numbers = of.iter().map(|run| i64::try_from(*run).unwrap_or(i64::MAX));
        group.add("run", &[run], ArrayValues::counts(numbers));
        group.add_draws("restitution", Some(run), ArrayValues::streamed());
        group
    })
}

/// The files of those numbers, pairs of the same draws.
fn every_run_files(every_run: EveryRun<'_>, size: DrawCounts) -> Vec<Streamed<'_>> {
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

/// What was measured, and at which settings.
fn groups_of_runs(scene: &Scene, runs: &Runs) -> [ArrayGroup; 2] {
    let run = ("run", runs.len());
    let mut stuck = vec![false; runs.len()];
    let mut particle = vec![String::new(); runs.len()];
    let mut liquid = vec![DRY.to_owned(); runs.len()];
    for dry in &runs.dry {
        stuck[dry.stuck.clone()].fill(true);
        particle[dry.runs()].fill(scene.particles[dry.particle].name.clone());
    }
    for series in &runs.series {
        stuck[series.stuck.clone()].fill(true);
        particle[series.runs()].fill(scene.particles[series.particle].name.clone());
        liquid[series.runs()].fill(scene.liquids[series.liquid].name.clone());
    }
    let reals = |column: &[f64]| ArrayValues::reals(column.iter().copied());
    let mut observed = ArrayGroup::new("observed_data");
    observed.add_indices(run);
    observed.add("restitution", &[run], reals(&runs.restitution));
    observed.add("stuck", &[run], ArrayValues::flags(stuck));
    let mut constant = ArrayGroup::new("constant_data");
    constant.add_indices(run);
    constant.add("particle_name", &[run], ArrayValues::texts(&particle));
    constant.add("liquid_name", &[run], ArrayValues::texts(&liquid));
    constant.add("diameter_m", &[run], reals(&runs.diameter));
    constant.add("film_m", &[run], reals(&runs.film));
    constant.add("impact_speed_m_s", &[run], reals(&runs.impact_speed));
    [observed, constant]
}
