//! Prepares a posterior for sampling: finds a start, chooses rows or nodes for the likelihood, and finds the mode with its curvature.

use rayon::prelude::*;

use super::laplace::{laplace, Laplace};
use super::nuts::Chain;
use crate::model::likelihood::{Compression, Likelihood};
use crate::model::parameters::{ModelParameters, ParameterKind};
use crate::model::posterior::{LogDensity, PosteriorDensity};

/// Largest error of the log density that a compression may make over the posterior's region.
pub const LARGEST_ERROR: f64 = 1e-3;

/// Draws at which the sum over all rows is held against the compressed one.
pub const CHECKED: usize = 200;

/// What stands for the runs in an evaluation of the likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evaluation {
    /// every row
    Rows,
    /// nodes, by which the log density is off by no more than this
    Compressed(f64),
}

impl Default for Evaluation {
    fn default() -> Evaluation {
        Evaluation::Compressed(LARGEST_ERROR)
    }
}

/// A posterior with what every method of sampling starts from.
#[derive(Debug, Clone)]
pub struct PreparedPosterior<'r> {
    /// the likelihood of every row
    pub rows: &'r Likelihood,
    /// the posterior, of rows or nodes
    pub posterior: PosteriorDensity,
    /// its mode and curvature
    pub about: Laplace,
    /// what was compressed; `None` if every row is used
    pub compression: Option<Compression>,
    /// the error of the log density that was allowed; `None` if every row is used
    pub bound: Option<f64>,
    /// seconds it took
    pub seconds: f64,
}

/// The posterior has no density at any start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the posterior has no density at the least-squares estimates, nor at the medians of the priors")]
pub struct NoStart;

/// Values a search for the mode may start from, by kind; what is missing starts at its prior's median.
pub type Start = Vec<(ParameterKind, f64)>;

impl<'r> PreparedPosterior<'r> {
    /// Prepares the posterior of these parameters under the likelihood of all rows.
    pub fn new(
        parameters: ModelParameters,
        rows: &'r Likelihood,
        start: &Start,
        evaluation: Evaluation,
    ) -> Result<PreparedPosterior<'r>, NoStart> {
        let began = std::time::Instant::now();
        let starts = starts(&parameters, start);
        let evaluation = if rows.needs_rows() {
            Evaluation::Rows
        } else {
            evaluation
        };
        let (posterior, about, compression) = match evaluation {
            Evaluation::Rows => {
                let posterior = PosteriorDensity::new(parameters, rows.clone());
                let reference = posterior.parameters().full(&starts[0]);
                let posterior = posterior.with_offsets_about(&reference);
                let about = highest(&posterior, &starts)?;
                let (posterior, about) = about_the_mode(posterior, about)?;
                (posterior, about, None)
            }
            Evaluation::Compressed(bound) => {
                let (posterior, about, compression) = compressed(&parameters, rows, &starts, bound)?;
                (posterior, about, Some(compression))
            }
        };
        Ok(PreparedPosterior {
            rows,
            posterior,
            about,
            compression,
            bound: match evaluation {
                Evaluation::Compressed(bound) => Some(bound),
                Evaluation::Rows => None,
            },
            seconds: began.elapsed().as_secs_f64(),
        })
    }

    /// Largest difference of the log density between all rows and the nodes, at draws spread over the chains; `None`
    /// where every row is used.
    pub fn largest_difference(&self, chains: &[Chain]) -> Option<f64> {
        self.compression?;
        let dimension = self.posterior.dimension();
        let points: Vec<&[f64]> = chains
            .iter()
            .flat_map(|chain| chain.points.chunks_exact(dimension.max(1)))
            .collect();
        let step = points.len().div_ceil(CHECKED).max(1);
        let checked: Vec<&[f64]> = points.into_iter().step_by(step).collect();
        let difference = |point: &&[f64]| {
            let full = self.posterior.parameters().full(&self.posterior.draw_at(point));
            let mut slopes = vec![0.0; full.len()];
            let exact = self.rows.ln_density(&full, &mut slopes);
            let short = self.posterior.likelihood().ln_density(&full, &mut slopes);
            match (exact, short) {
                (Ok(exact), Ok(short)) => (exact - short).abs(),
                _ => f64::INFINITY,
            }
        };
        Some(checked.par_iter().map(difference).reduce(|| 0.0, f64::max))
    }
}

/// Seconds that the log density of every row takes with its slopes, where the search for the mode starts; `None` where nodes
/// stand for the rows, which takes microseconds however many there are, or where it has no value there.
pub fn seconds_of_rows(parameters: ModelParameters, rows: Likelihood, start: &Start) -> Option<f64> {
    /// evaluations of which the quickest counts, and seconds after which one is enough
    const MOST: usize = 5;
    const ENOUGH: f64 = 0.05;
    if !rows.needs_rows() {
        return None;
    }
    let starts = starts(&parameters, start);
    let posterior = PosteriorDensity::new(parameters, rows);
    let began = std::time::Instant::now();
    let mut slopes = vec![0.0; posterior.dimension()];
    let mut least: Option<f64> = None;
    for _ in 0..MOST {
        let one = std::time::Instant::now();
        posterior
            .ln_density(&posterior.point_at(&starts[0]), &mut slopes)
            .ok()?;
        least = least.into_iter().chain([one.elapsed().as_secs_f64()]).reduce(f64::min);
        if began.elapsed().as_secs_f64() > ENOUGH {
            break;
        }
    }
    least
}

/// The least-squares start, and the medians of the priors for the case that it is no good.
fn starts(parameters: &ModelParameters, start: &Start) -> [Vec<f64>; 2] {
    let medians: Vec<f64> = parameters.sampled.iter().map(|p| p.prior.median()).collect();
    let given = parameters.sampled.iter().zip(&medians).map(|(parameter, median)| {
        let found = start.iter().find(|(kind, _)| *kind == parameter.kind);
        found.map_or(*median, |(_, value)| *value)
    });
    [given.collect(), medians]
}

/// The highest mode that the starts lead to.
fn highest(posterior: &PosteriorDensity, starts: &[Vec<f64>]) -> Result<Laplace, NoStart> {
    let modes = starts
        .iter()
        .filter_map(|start| laplace(posterior, &posterior.point_at(start)).ok());
    // the earlier start wins a tie
    let best = modes.reduce(|a, b| if b.ln_density > a.ln_density + 1e-6 { b } else { a });
    best.ok_or(NoStart)
}

/// The posterior with the offsets of series on coordinates that are round about its mode, and the mode in these.
fn about_the_mode(posterior: PosteriorDensity, about: Laplace) -> Result<(PosteriorDensity, Laplace), NoStart> {
    if posterior.parameters().series_offsets.is_empty() {
        return Ok((posterior, about));
    }
    let draw = posterior.draw_at(&about.mode);
    let full = posterior.parameters().full(&draw);
    let posterior = posterior.with_offsets_about(&full);
    let about = laplace(&posterior, &posterior.point_at(&draw)).map_err(|_| NoStart)?;
    Ok((posterior, about))
}

/// The compressed posterior with its mode: first roughly, to learn where the posterior lies, then to the bound there.
///
/// With very many runs the rough one may lie many standard deviations off; then the bound was kept in the wrong place,
/// and the rows are compressed again about the new mode until it stays.
fn compressed(
    parameters: &ModelParameters,
    rows: &Likelihood,
    starts: &[Vec<f64>],
    bound: f64,
) -> Result<(PosteriorDensity, Laplace, Compression), NoStart> {
    /// each time the mode is nearer by orders of magnitude
    const TRIES: usize = 8;
    let reference = parameters.full(&starts[0]);
    let (rough, _) = rows.compressed(&reference, &[], bound);
    let mut posterior = PosteriorDensity::new(parameters.clone(), rough).with_offsets_about(&reference);
    let mut about = highest(&posterior, starts)?;
    let mut tries = 0;
    loop {
        tries += 1;
        let full = |point: &[f64]| parameters.full(&posterior.draw_at(point));
        let offsets = parameters.series_offsets.len();
        let tests: Vec<Vec<f64>> = region(&about, offsets).iter().map(|point| full(point)).collect();
        let mode = full(&about.mode);
        let (likelihood, compression) = rows.compressed(&mode, &tests, bound);
        let next = PosteriorDensity::new(parameters.clone(), likelihood).with_offsets_about(&mode);
        let from = if offsets == 0 {
            about.mode.clone()
        } else {
            next.point_at(&posterior.draw_at(&about.mode))
        };
        posterior = next;
        let next = laplace(&posterior, &from).map_err(|_| NoStart)?;
        let stays = next.distance(&from).is_some_and(|distance| distance < 1.0);
        about = next;
        if stays || tries == TRIES {
            return Ok((posterior, about, compression));
        }
    }
}

/// How far from the mode a compression is tested, in standard deviations.
const FAR: [f64; 4] = [-6.0, -2.0, 2.0, 6.0];

/// Points two and six standard deviations from the mode, along each axis of the rounded space; with offsets of series, which
/// stand last, along the axes of the other parameters, the offsets following them, and along all offsets at once.
fn region(about: &Laplace, offsets: usize) -> Vec<Vec<f64>> {
    if offsets > 0 {
        return region_with_offsets(about, about.mode.len() - offsets);
    }
    let dimension = about.mode.len();
    let mut points = vec![];
    for axis in 0..dimension {
        for far in FAR {
            let mut z = vec![0.0; dimension];
            z[axis] = far;
            let mut point = z.clone();
            about.point(&z, &mut point);
            points.push(point);
        }
    }
    points
}

/// That of a posterior whose coordinates beyond the first so many are offsets, each read by the runs of one series alone.
fn region_with_offsets(about: &Laplace, parameters: usize) -> Vec<Vec<f64>> {
    let dimension = about.mode.len();
    let covariance = &about.scale * about.scale.transpose();
    // columns of a root that has the parameters first: what moves with one of them follows
    let root = covariance.clone().cholesky().map(|factor| factor.l());
    let axes = (0..parameters).map(|axis| {
        let column = root.as_ref().map(|root| root.column(axis).into_owned());
        column.unwrap_or_else(|| covariance.column(axis) / covariance[(axis, axis)].sqrt())
    });
    // with the parameters held an offset is told by its own runs: standard normal, but for what these coordinates lack
    let all = (0..dimension).map(|place| {
        let width = covariance[(place, place)].sqrt().min(1.0);
        if place < parameters {
            0.0
        } else {
            width
        }
    });
    let all = nalgebra::DVector::from_iterator(dimension, all);
    let directions = axes.chain(std::iter::once(all)).collect::<Vec<_>>();
    let far = |direction: &nalgebra::DVector<f64>| {
        let point = |far: f64| {
            about
                .mode
                .iter()
                .zip(direction)
                .map(|(mode, step)| mode + far * step)
                .collect()
        };
        FAR.map(point)
    };
    directions.iter().flat_map(far).collect()
}
