//! Names the single runs that carry a main number: left out, they move it by more than one of its ±.
//!
//! A square-root law is fitted anew without each run. A run is left out of the posterior by the weights 1/p(run | draw) of
//! its draws, smoothed; where their tail is too heavy for that, by draws of the posterior without it.

use std::borrow::Cow;
use std::collections::HashSet;

use rayon::prelude::*;

use super::estimate::{Estimate, Quoting};
use super::estimates::EstimateRow;
use super::fit_verdict::{uncertain, why_stopped, NO_FALL};
use super::left_out::{ComparisonContext, Model};
use super::main_numbers::MainNumbers;
use super::moved::{Moved, Told};
use super::noise::Outlier;
use super::posterior::{derived, Posterior};
use super::quantities::{variables, FittedLaw};
use super::range::range;
use super::remarks::{self, shortened};
use super::scaling::Scaling;
use super::wet_fit::{two, FitSetup, WetRuns};
use crate::inference::diagnostics::pareto::{khat_threshold, tail_length};
use crate::inference::diagnostics::psis::psis;
use crate::inference::sampling::Sampled;
use crate::physics::quantity::{Place, Quantity};
use crate::remark::Remark;
use crate::rounding::{by_number, short};
use crate::runs::Runs;
use crate::scene::{Scene, WetLaw};

/// Share of its ± beyond which a main number may not move unsaid when one run is left out.
const CARRIED: f64 = 1.0;

/// The same share by weights with a tail heavier than this, which feign too small a shift: whether it is more than that, draws
/// without the run then say.
const PERHAPS_CARRIED: f64 = 0.6;
const HEAVY_TAIL: f64 = 0.5;

/// Of more runs none carries a number of the posterior by itself.
const MOST_RUNS: usize = 10_000;

/// Runs that are left out by draws of their own, the heaviest first.
const MOST_DRAWN: usize = 4;

/// A main number of the posterior by its name, with its draws, chain after chain.
type Number = (String, Vec<f64>);

/// A run with the main number that it moves most.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SingleRun {
    /// its place among the runs
    pub run: usize,
    /// the number with the run, and without it
    pub moved: Moved,
}

impl SingleRun {
    /// Whether the number moves by more than it may unsaid.
    pub fn carries(&self) -> bool {
        self.moved.shift() > CARRIED
    }
}

/// A run left out by the weights of draws.
struct LeftOut {
    /// the shape of their tail
    khat: f64,
    found: SingleRun,
}

/// The runs without which a main number of the posterior moves by more than one of its ±, the heaviest first.
pub(super) fn find_single_runs(context: ComparisonContext, posterior: &Posterior) -> Vec<SingleRun> {
    let ComparisonContext { scene, runs, .. } = context;
    let are_few = !runs.series.is_empty() && runs.len() <= MOST_RUNS;
    let densities = are_few.then(|| posterior.run_densities(scene, runs));
    let Some(densities) = densities.flatten() else {
        return vec![];
    };
    let line = khat_threshold(densities.draws);
    let numbers = numbers_of(&posterior.sampled, &posterior.derived, densities.step);
    let with = told(&numbers, None);
    let without = |run: usize| {
        // weights that lie within exp(±s) of one another spread by at most sinh s of their mean, and no mean of a number moves
        // by more of its sds than that
        if (0.5 * densities.spread(run)).sinh() <= PERHAPS_CARRIED {
            return None;
        }
        let ln_ratios: Vec<f64> = densities.rows(run..run + 1).iter().map(|ln| -ln).collect();
        let smoothed = psis(&ln_ratios, tail_length(densities.draws, 1.0))?;
        let khat = smoothed.khat.unwrap_or(0.0);
        let [mean, sd] = moments(&smoothed.weights, None);
        if sd <= PERHAPS_CARRIED * mean && khat <= line {
            return None;
        }
        let found = heaviest(run, &with, &told(&numbers, Some(&smoothed.weights)))?;
        Some(LeftOut { khat, found })
    };
    let mut each: Vec<LeftOut> = (0..runs.len()).into_par_iter().filter_map(without).collect();
    each.sort_by(|a, b| b.khat.total_cmp(&a.khat));
    let model = Model {
        context,
        setup: posterior.setup,
        parameters: &posterior.sampled.parameters,
        stream: "single run",
    };
    let is_unsure = |own: &&mut LeftOut| {
        let may_carry = own.found.moved.shift() > PERHAPS_CARRIED;
        own.khat > line || own.khat > HEAVY_TAIL && may_carry
    };
    for LeftOut { found, .. } in each.iter_mut().take(MOST_DRAWN).filter(is_unsure) {
        let run = found.run;
        let Ok(others) = model.draw_without(&(run..run + 1)) else {
            continue;
        };
        let derived = derived::derived_draws(scene, runs, posterior.setup.form, &others);
        let others = told(&numbers_of(&others, &derived, 1), None);
        if let Some(better) = heaviest(run, &with, &others) {
            *found = better;
        }
    }
    let mut carried: Vec<SingleRun> = each.into_iter().map(|own| own.found).collect();
    carried.retain(SingleRun::carries);
    carried
}

/// The runs that carry a square-root law which is quoted.
pub(super) fn carried_laws(setup: FitSetup, main: &MainNumbers, scaling: &[Scaling]) -> Vec<SingleRun> {
    let of_place = |[e_inf, _]: &[EstimateRow; 2]| scaling.iter().find(|law| e_inf.is_of_law(law));
    let laws = main.places.iter().filter_map(of_place);
    laws.flat_map(|law| runs_that_carry(setup, law)).collect()
}

/// The runs of a square-root law without which, fitted anew, it has another e_inf or St_c.
fn runs_that_carry(setup: FitSetup, law: &Scaling) -> Vec<SingleRun> {
    /// of more runs none carries a law
    const MOST: usize = 1000;
    let series = &setup.runs.series[law.series.clone()];
    let pool = WetRuns::over_stokes(setup, series);
    let columns = &pool.columns;
    if columns.x.len() > MOST || !columns.counts.is_empty() || pool.errors.is_some() {
        return vec![];
    }
    let ratio = short(law.film_ratio.unwrap_or_default());
    let here = format!("({}, δ/D = {ratio}, square-root law)", law.words());
    let without = |(place, run): (usize, usize)| {
        let fit = pool.refitted(WetLaw::Sqrt, &columns.restitution, |own| own != place);
        let source = FittedLaw {
            wetted: law.over.wetted(variables(two(&fit))),
            uncertain: &uncertain(&fit),
            limits: None,
            why_none: (!fit.converged()).then(|| why_stopped(&fit)),
            undefined: [NO_FALL; 2],
            quoting: Quoting::of(setup.scene),
        };
        [Quantity::EInf, Quantity::StC].map(|quantity| {
            let moved = Moved {
                name: format!("{} {here}", quantity.describe().symbol),
                before: with_scale(&law.estimates[quantity]),
                after: with_scale(&source.estimate(quantity, &Place::NONE)),
            };
            SingleRun { run, moved }
        })
    };
    let rebounds = series.iter().flat_map(|one| one.rebounds.clone());
    let each = rebounds.enumerate().flat_map(without);
    each.filter(SingleRun::carries).collect()
}

/// A value and its standard error; NaN where there is none.
fn with_scale(estimate: &Estimate) -> [f64; 2] {
    [estimate.value, estimate.scale()].map(|number| number.unwrap_or(f64::NAN))
}

/// The main numbers of a posterior at every so many draws.
fn numbers_of(sampled: &Sampled, derived: &[derived::DerivedDraws], step: usize) -> Vec<Number> {
    let all = derived::main_draws(sampled, derived);
    all.map(|(name, values)| (name.clone(), values.iter().flatten().step_by(step).copied().collect()))
        .collect()
}

/// The number that a run moves most; `None` where none has a spread.
fn heaviest(run: usize, with: &[Told], without: &[Told]) -> Option<SingleRun> {
    let finite = Moved::between(with, without).filter(|moved| moved.shift().is_finite());
    let moved = finite.max_by(|a, b| a.shift().total_cmp(&b.shift()))?;
    Some(SingleRun { run, moved })
}

/// Mean and sd of each number's draws.
fn told(numbers: &[Number], weights: Option<&[f64]>) -> Vec<Told> {
    let each = numbers.iter();
    each.map(|(name, draws)| (name.clone(), moments(draws, weights)))
        .collect()
}

/// Mean and sd of draws, weighed or not.
fn moments(draws: &[f64], weights: Option<&[f64]>) -> [f64; 2] {
    let weights = weights.map_or_else(|| Cow::Owned(vec![1.0; draws.len()]), Cow::Borrowed);
    let all: f64 = weights.iter().sum();
    let weighed = || draws.iter().zip(weights.iter());
    let mean = weighed().map(|(x, w)| w * x).sum::<f64>() / all;
    let squares = weighed().map(|(x, w)| w * (x - mean) * (x - mean));
    [mean, (squares.sum::<f64>() / all).sqrt()]
}

/// Whether one of these runs is an outlier: a main number then hangs on a run that is wrong, or on noise of another kind.
pub(super) fn carrying_outlier(runs: &Runs, found: &[SingleRun], outliers: &[Outlier]) -> Option<Remark> {
    let with_outlier = |own: &SingleRun| {
        let outlier = outliers.iter().find(|outlier| outlier.row == runs.row[own.run]);
        outlier.map(|outlier| (outlier.clone(), own.moved.clone()))
    };
    let outlying = found.iter().filter_map(with_outlier);
    let (outlier, moved) = outlying.max_by(|a, b| a.1.shift().total_cmp(&b.1.shift()))?;
    let text = format!(
        "by how many of its ± an outlier moves a main number: {} lies {:.0} σ from the law of the others, and {}",
        outlier.place,
        outlier.sds.abs(),
        moved.with_and_without("it")
    );
    Some(remarks::CARRYING_OUTLIER.check(moved.shift(), text))
}

/// A notice of these runs, the heaviest first, each once; `None` without any.
pub(super) fn single_run_notice(scene: &Scene, runs: &Runs, mut found: Vec<SingleRun>) -> Option<Remark> {
    found.sort_by(|a, b| b.moved.shift().total_cmp(&a.moved.shift()));
    let mut seen = HashSet::new();
    found.retain(|own| seen.insert(own.run));
    let told = found.iter().map(|SingleRun { run, moved }| {
        let run = run_words(scene, runs, *run);
        format!("{run}: {}", moved.with_and_without("it"))
    });
    let told: Vec<String> = told.collect();
    (!told.is_empty()).then(|| {
        let one = "one run carries a main number, which moves by more than its ± without it";
        let several = "single runs carry main numbers, which move by more than their ± without them";
        let text = format!("{}: {}", by_number(told.len(), one, several), shortened(&told));
        remarks::SINGLE_RUN.notice(told.len(), text)
    })
}

/// Whether a run that stuck contradicts those that rebound, none of which is slow, as where a camera does not see small
/// rebounds; nothing where the scene says which it sees.
pub(super) fn unseen_rebounds(scene: &Scene, runs: &Runs, found: &[SingleRun]) -> Option<Remark> {
    /// a law falls from here to nothing over a tenth of the speed or more
    const SEEN: f64 = 0.15;
    let rebounds = runs.series.iter().flat_map(|series| series.rebounds.clone());
    let [slowest, _] = range(rebounds.map(|run| runs.restitution[run]))?;
    if slowest < SEEN || scene.data.smallest_restitution > 0.0 {
        return None;
    }
    let is_stuck = |own: &&SingleRun| runs.series.iter().any(|series| series.stuck.contains(&own.run));
    let stuck = found.iter().filter(is_stuck);
    let shift = |own: &SingleRun| own.moved.shift_in_larger();
    let worst = stuck.max_by(|a, b| shift(a).total_cmp(&shift(b)))?;
    let text = format!(
        "{} stuck by the table, which the runs that rebound contradict: without it {} moves by {:.1} of its ±, and no rebound \
         is below e = {slowest:.3}",
        run_words(scene, runs, worst.run),
        remarks::in_symbols(&worst.moved.name),
        shift(worst),
    );
    let check = remarks::UNSEEN_REBOUNDS.check(shift(worst), text);
    (!check.passed).then_some(check)
}

/// A run by where it stands, what it was made with, and its e.
pub(super) fn run_words(scene: &Scene, runs: &Runs, run: usize) -> String {
    let series = runs.series.iter().find(|series| series.runs().contains(&run));
    let of = match series {
        Some(series) => series.label(scene),
        None => "dry".to_owned(),
    };
    let place = runs.places.of(runs.row[run]);
    format!("{place} ({of}, e = {:.3})", runs.restitution[run])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::tests::read_plain;
    use crate::runs::Table;

    fn carried(run: usize, without: f64) -> SingleRun {
        SingleRun {
            run,
            moved: Moved {
                name: "st_c[PTFE,AK10,0.06]".to_owned(),
                before: [6.0, 0.03],
                after: [without, 0.06],
            },
        }
    }

    #[test]
    fn of_outliers_that_carry_a_number_the_one_that_moves_it_most_is_named() {
        let (_, Table { runs, .. }) = read_plain();
        let outlier = |run: usize| Outlier {
            row: runs.row[run],
            place: format!("line {run}"),
            particle: "PTFE".to_owned(),
            liquid: None,
            diameter_m: 4e-3,
            film_ratio: None,
            impact_speed_m_s: 1.0,
            restitution: 0.5,
            expected: 0.8,
            sds: 9.0,
            moves: "dry_k[PTFE]".to_owned(),
            moves_in_se: 1.0,
        };
        let found = [carried(0, 5.9), carried(1, 5.5), carried(2, 5.0)];
        let told = carrying_outlier(&runs, &found, &[0, 1].map(outlier)).expect("one carries it");
        assert!(told.forbids() && told.text.contains("line 1 lies"), "{}", told.text);
    }

    #[test]
    fn a_stuck_run_that_contradicts_the_rebounds_asks_what_is_seen() {
        let (mut scene, Table { runs, .. }) = read_plain();
        let stuck = runs.series.iter().find_map(|series| series.stuck.clone().next());
        let stuck = stuck.expect("one run stuck");
        let rebound = runs.series[0].rebounds.start;
        let asked = |scene: &Scene, found| unseen_rebounds(scene, &runs, &[found]);
        let check = asked(&scene, carried(stuck, 5.8)).expect("it is asked");
        assert!(check.forbids() && check.next_step.contains("smallest_restitution"));
        assert!(check.text.contains("moves by 3.3 of its ±"), "{}", check.text);
        // by no more than its ±, and a run that rebounds
        assert_eq!(asked(&scene, carried(stuck, 5.9)), None);
        assert_eq!(asked(&scene, carried(rebound, 5.8)), None);
        scene.data.smallest_restitution = 0.2;
        assert_eq!(asked(&scene, carried(stuck, 5.8)), None);
    }
}
