//! Holds the linear law of the wet restitution against the square root, by all runs together.

use std::ops::Range;

use super::fit_verdict::is_clear;
use super::form_choice::GAIN;
use super::remarks::SELDOM;
use super::wet_fit::{FitSetup, WetRuns};
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::nested::{nested, FTest, Spread};
use crate::scene::WetLaw;

/// The linear law against the square root, each with an e_inf and a St_c of its own at every film ratio of a particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineAgainstRoot {
    /// by how much the runs' log density about the linear law is above that about the square root
    pub gain: f64,
    /// spread of the runs about the linear law and about the square root
    pub residual_sds: [f64; 2],
    /// film ratios, or series where each has an offset
    pub groups: usize,
    /// the linear law against one more term in (1/St)², which all groups share; `None` of too few runs
    pub bend: Option<FTest>,
}

impl LineAgainstRoot {
    /// Compares the laws over the film ratios of each particle, or over the series where each has an offset; `None` where no
    /// runs are left to tell their spread.
    ///
    /// A lucky rebound near sticking has no fair residual: runs that either law expects within three spreads of it are left
    /// out. Where the square root holds, a gain of 4 comes by chance in less than one table of 400, however far the laws
    /// are apart: the gain is then normal with a mean of minus half its variance.
    ///
    /// Both laws are told apart by the slowest rebounds, so one wrong row there can bend a whole table: where the linear law
    /// gains little without the slowest rebound of some group, that is what it gains.
    pub fn over_all(setup: FitSetup) -> Option<LineAgainstRoot> {
        /// more runs than this hang on none
        const MANY: usize = 10_000;
        /// one run of many leaves more of a gain that all share
        const LEFT: f64 = 0.25;
        let mut found = LineAgainstRoot::of_these(setup)?;
        if found.favours_line() && setup.runs.len() <= MANY {
            let without = slowest_rebounds(setup).into_iter().filter_map(|run| {
                let runs = &setup.runs.without(&(run..run + 1));
                LineAgainstRoot::of_these(FitSetup { runs, ..setup })
            });
            let gains = without
                .map(|others| others.gain)
                .filter(|gain| *gain < LEFT * found.gain);
            found.gain = gains.reduce(f64::min).unwrap_or(found.gain);
        }
        Some(found)
    }

    /// The laws over runs as they are.
    fn of_these(setup: FitSetup) -> Option<LineAgainstRoot> {
        let FitSetup { scene, runs, .. } = setup;
        let mut all = Squares::default();
        let mut bend = Bend::default();
        let mut told = 0;
        for group in groups(setup) {
            let pool = WetRuns::over_stokes(setup, &runs.series[group]);
            if let Some(clear) = all.add(&pool, scene.data.smallest_restitution) {
                bend.add(&pool, &clear);
                told += 1;
            }
        }
        let of_spread = |squares: f64| 0.5 * all.freedom * squares.ln();
        let [of_line, of_root] = all.squares;
        let gain = if all.freedom > 0.0 {
            of_spread(of_root) - of_spread(of_line)
        } else {
            0.0
        };
        (told > 0 && gain.is_finite()).then(|| LineAgainstRoot {
            gain: gain + all.gain_by_errors,
            residual_sds: all
                .squares
                .map(|squares| (squares / all.freedom.max(all.weighed)).sqrt()),
            groups: told,
            bend: bend.test(),
        })
    }

    /// Whether it is the linear law that describes the runs.
    pub fn favours_line(&self) -> bool {
        self.gain > GAIN
    }

    /// Whether the linear law describes the runs, as far as they tell: not only better than the square root.
    pub fn line_holds(&self) -> bool {
        self.bend.is_none_or(|bend| bend.p >= SELDOM)
    }
}

/// The series that share an e_inf and a St_c: those of a film ratio, or each where it has an offset.
fn groups(FitSetup { scene, runs, .. }: FitSetup) -> Vec<Range<usize>> {
    if scene.model.series_offsets {
        return (0..runs.series.len()).map(|series| series..series + 1).collect();
    }
    let ratios = runs.film_groups.iter().filter(|group| group.has_one_film_ratio());
    ratios.map(|group| group.series.clone()).collect()
}

/// The rebound with the largest 1/St of each group.
fn slowest_rebounds(setup: FitSetup) -> Vec<usize> {
    let inverse_stokes = |run: &usize| setup.runs.inverse_stokes(*run);
    let slowest = |group: Range<usize>| {
        let rebounds = setup.runs.series[group]
            .iter()
            .flat_map(|series| series.rebounds.clone());
        rebounds.max_by(|a, b| inverse_stokes(a).total_cmp(&inverse_stokes(b)))
    };
    groups(setup).into_iter().filter_map(slowest).collect()
}

/// What a term in (1/St)² explains of what linear laws leave, each law with both its parameters free.
#[derive(Debug, Default)]
struct Bend {
    /// what the linear laws leave, of the runs' weights
    of_lines: Spread,
    /// Σ of the term's square, and of its product with the residual, beside the linear laws
    of_term: [f64; 2],
}

impl Bend {
    /// Adds some runs of one group.
    fn add(&mut self, pool: &WetRuns, clear: &[(usize, f64)]) {
        /// a term with less than this share of its square beside the law is not told from it, as of runs at two settings
        const NEW: f64 = 1e-9;
        let own = &pool.columns;
        let x = |run: usize| own.x[run];
        let columns: [&dyn Fn(usize) -> f64; 4] = [&|_| 1.0, &x, &|run| x(run) * x(run), &|run| own.restitution[run]];
        let mut columns = columns.map(|column| clear.iter().map(|(run, _)| column(*run)).collect::<Vec<f64>>());
        let product = |a: &[f64], b: &[f64]| -> f64 {
            let runs = clear.iter().zip(a.iter().zip(b));
            runs.map(|((_, weight), (a, b))| weight * a * b).sum()
        };
        let whole = product(&columns[2], &columns[2]);
        // each is freed of those before it, twice, so that rounding leaves nothing (Gram and Schmidt)
        for place in 1..columns.len() {
            let (before, rest) = columns.split_at_mut(place);
            for base in before.iter().take(2).chain(before.iter().take(2)) {
                let share = product(base, &rest[0]) / product(base, base);
                for (own, base) in rest[0].iter_mut().zip(base) {
                    *own -= share * base;
                }
            }
        }
        let [_, slope, term, residual] = &columns;
        if product(slope, slope) > 0.0 && product(term, term) > NEW * whole {
            self.of_lines.sum_of_squares += product(residual, residual);
            self.of_lines.runs += clear.len();
            self.of_lines.parameters += 2;
            self.of_term[0] += product(term, term);
            self.of_term[1] += product(term, residual);
        }
    }

    fn test(&self) -> Option<FTest> {
        let [own, with] = self.of_term;
        let wide = Spread {
            sum_of_squares: self.of_lines.sum_of_squares - with * with / own,
            parameters: self.of_lines.parameters + 1,
            ..self.of_lines
        };
        nested(self.of_lines, wide)
    }
}

/// What both laws leave of some runs.
#[derive(Debug, Default)]
struct Squares {
    /// Σ residual² about the linear law and about the square root
    squares: [f64; 2],
    /// runs that tell the spread, less the parameters of either law
    freedom: f64,
    /// runs whose spread is known by their measurement errors
    weighed: f64,
    /// what the linear law gains by these
    gain_by_errors: f64,
}

impl Squares {
    /// Adds the runs of one group; says which of them are told, with their weights. `None`, and nothing added, where a law could
    /// not be fitted.
    fn add(&mut self, pool: &WetRuns, limit: f64) -> Option<Vec<(usize, f64)>> {
        /// of either law
        const PARAMETERS: f64 = 2.0;
        let own = &pool.columns;
        let fits = [WetLaw::Linear, WetLaw::Sqrt].map(|law| {
            let regression = pool.regression(law);
            let (fit, weights) = regression.fit_with_errors(pool.errors.as_ref());
            let fitted = regression.fitted(&fit);
            (fitted, fit.residual_sd.unwrap_or(f64::NAN), weights)
        });
        let clear = |run: &usize| fits.iter().all(|(fitted, sd, _)| is_clear(fitted[*run], limit, *sd));
        let clear: Vec<usize> = (0..own.x.len()).filter(clear).collect();
        let count = |run: usize| own.counts.get(run).copied().unwrap_or(1.0);
        let runs: f64 = clear.iter().map(|run| count(*run)).sum();
        let square = |fitted: &[f64], run: usize| count(run) * (own.restitution[run] - fitted[run]).powi(2);
        let by_errors = |(fitted, _, weights): &(Vec<f64>, f64, Option<ErrorWeights>)| -> Option<f64> {
            let weights = weights.as_ref()?;
            let of_run = |run: &usize| match weights.variance[*run] {
                variance if variance.is_finite() => {
                    -0.5 * (square(fitted, *run) / variance + count(*run) * variance.ln())
                }
                _ => 0.0,
            };
            Some(clear.iter().map(of_run).sum())
        };
        if runs <= PARAMETERS {
            return None;
        }
        for (squares, (fitted, ..)) in self.squares.iter_mut().zip(&fits) {
            *squares += clear.iter().map(|run| square(fitted, *run)).sum::<f64>();
        }
        match by_errors(&fits[0]).zip(by_errors(&fits[1])) {
            Some((of_line, of_root)) => {
                self.weighed += runs;
                self.gain_by_errors += of_line - of_root;
            }
            None => self.freedom += runs - PARAMETERS,
        }
        let weight = |run: usize| match &fits[0].2 {
            Some(weights) => count(run) / weights.variance[run],
            None => count(run),
        };
        Some(clear.into_iter().map(|run| (run, weight(run))).collect())
    }
}
