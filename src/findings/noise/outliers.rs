//! Names the runs that normal noise would hardly ever take so far from the law.
//!
//! A run is found by its deletion residual t: its distance from the fit to the others, over the sd of that difference as
//! these others show it. Were all noise normal, some |t| among n runs would exceed the line t(1 − 0.01/2n) in one table of
//! a hundred (Bonferroni). Candidates are all taken out first, and come back from the least extreme on: none hides
//! another, and none widens the spread it is held against.

use nalgebra::DVector;
use schemars::JsonSchema;
use serde::Serialize;

use super::rows::{Rows, RunAtFit, RunKind};
use super::scatter::RobustFit;
use crate::distributions::student_t_quantile;
use crate::inference::joint::Part;
use crate::inference::linearised_joint::{LinearisedJoint, RowsLeft};
use crate::inference::sums::Sums;
use crate::physics::rebound::{mean_restitution, slope_mean_restitution};
use crate::scene::Sticking;

/// Probability that normal noise makes any run of a table an outlier.
pub const FALSE_ALARM: f64 = 0.01;

/// Outliers that are described one by one.
pub const MOST_DESCRIBED: usize = 10;

/// Share of the line from which a run is a candidate: none that passes it with the final spread is missed by a scale
/// that is off by a quarter.
const CANDIDATE: f64 = 0.75;

/// Groups of fewer runs are held against the spread of their kind.
const LEAST_OF_OWN: usize = 10;

/// A run far from the law.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Outlier {
    /// row, counted over all tables below their headers from 1
    pub row: u32,
    /// where that is: file, sheet, line or row as a person sees it, and the label of the run
    pub place: String,
    /// name of the particle
    pub particle: String,
    /// name of the liquid; `None` for a dry run
    pub liquid: Option<String>,
    /// D of its series, m
    pub diameter_m: f64,
    /// film ratio; `None` for a dry run
    pub film_ratio: Option<f64>,
    /// v, m/s
    pub impact_speed_m_s: f64,
    /// e; 0: it stuck
    pub restitution: f64,
    /// what the fit without outliers expects of it
    pub expected: f64,
    /// distance from that in sds of the difference; of a stuck run from the limit of sticking
    pub sds: f64,
    /// the parameter that leaving it out moves most
    pub moves: String,
    /// by so many of its standard errors
    pub moves_in_se: f64,
}

/// The line in sds for this many runs and degrees of freedom; infinite where there are none.
fn line(runs: usize, degrees_of_freedom: f64) -> f64 {
    let tail = 0.5 * FALSE_ALARM / runs.max(1) as f64;
    student_t_quantile(tail, degrees_of_freedom).map_or(f64::INFINITY, |t| -t)
}

/// How many runs are held against the line.
pub(super) fn count_tested(rows: &Rows) -> usize {
    let censored = rows.scene.model.sticking == Sticking::Censored;
    let of = |part: &Part| part.rebounds.len() + if censored { part.stuck.len() } else { 0 };
    rows.parts.iter().map(of).sum()
}

/// Distance in sds from which a run of so many is a candidate.
pub(super) fn candidate_distance(runs: usize) -> f64 {
    /// Student's t with so many degrees of freedom is the normal
    const NORMAL: f64 = 1e9;
    CANDIDATE * line(runs, NORMAL)
}

/// Standard errors by which the energy of a run near the threshold may be off.
const OFF: f64 = 4.0;

/// A run far from the fit; one that is clear of sticking may come back into it.
struct Candidate {
    run: RunAtFit,
    /// by how much less it counts where the energy scatters, too
    stretch: f64,
    sds: f64,
}

/// The sums over all runs but the outliers, and these.
pub(super) struct OutlierSearch {
    /// of each part, in units of the sd of its kind
    pub(super) sums: Vec<Sums>,
    pub(super) outliers: Vec<Outlier>,
    /// all of them, as indices into the columns of the runs, ascending
    pub(super) outlying: Vec<usize>,
}

impl OutlierSearch {
    /// Whether a run is one of them, by its index into the columns of the runs.
    pub(super) fn is_outlying(&self, run: usize) -> bool {
        self.outlying.binary_search(&run).is_ok()
    }
}

/// Sorts every run by whether it is an outlier.
pub(super) fn find_outliers(rows: &Rows, robust: &RobustFit, unequal: Option<&[f64]>) -> OutlierSearch {
    let runs = count_tested(rows);
    let (mut sums, mut candidates) = gather(rows, robust, unequal, candidate_distance(runs));
    candidates.sort_by(|a, b| a.sds.abs().total_cmp(&b.sds.abs()));
    let groups = unequal.map_or(0, <[f64]>::len);
    let mut reference = ReferenceFit::new(rows, &sums, groups);
    let mut outlying = vec![];
    for mut candidate in candidates {
        let (spread, freedom) = reference.spread(&candidate.run);
        candidate.sds = candidate.stretch * reference.deletion_distance(&candidate.run) / spread;
        if candidate.sds.abs() > line(runs, freedom) {
            outlying.push(candidate);
        } else if candidate.run.clear {
            rows.add(&mut sums[candidate.run.part], &candidate.run);
            reference = ReferenceFit::new(rows, &sums, groups);
        }
    }
    outlying.sort_by(|a, b| {
        let by_distance = b.sds.abs().total_cmp(&a.sds.abs());
        by_distance.then(a.run.row.run.cmp(&b.run.row.run))
    });
    let mut all: Vec<usize> = outlying.iter().map(|one| one.run.row.run).collect();
    all.sort_unstable();
    outlying.truncate(MOST_DESCRIBED);
    let describe = |one: &Candidate| {
        let mut outlier = reference.describe(one);
        let others = near_in_part(robust, one.run.part, &all);
        if let Some(rival) = reference.rival(&one.run, &others, &sums) {
            let other = rows.runs.places.of(rows.runs.row[rival]);
            outlier.place += &format!(" (or {other}: the other runs do not tell which)");
        }
        outlier
    };
    OutlierSearch {
        outliers: outlying.iter().map(describe).collect(),
        outlying: all,
        sums,
    }
}

/// The rebounds of a part that the fit without outliers holds.
fn near_in_part<'f>(robust: &'f RobustFit, part: usize, outlying: &[usize]) -> Vec<&'f RunAtFit> {
    let own = robust.runs.iter().filter(|run| run.part == part && run.clear);
    own.filter(|run| outlying.binary_search(&run.row.run).is_err())
        .collect()
}

/// Sums of the runs near the fit, and those far from it.
fn gather(rows: &Rows, robust: &RobustFit, unequal: Option<&[f64]>, far: f64) -> (Vec<Sums>, Vec<Candidate>) {
    let mut sums = vec![rows.blank(); rows.parts.len()];
    let candidate = |run: RunAtFit, restitution: f64| {
        let own = unequal.map_or(1.0, |unequal| unequal[rows.group_of[run.part]]);
        let stretch = run.sd / robust.scatter[run.kind as usize].sd_to(&run.row, restitution);
        let sds = -stretch * run.row.residual / (run.sd * own);
        Candidate { run, stretch, sds }
    };
    let mut candidates = vec![];
    for run in &robust.runs {
        let one = candidate(run.clone(), rows.runs.restitution[run.row.run]);
        if one.sds.abs() > far {
            candidates.push(one);
        } else if run.clear {
            rows.add(&mut sums[run.part], run);
        }
    }
    if rows.scene.model.sticking == Sticking::Censored {
        let limit = rows.scene.data.smallest_restitution;
        for mut run in rows.at(&robust.point, |part| part.stuck.clone()) {
            run.row.residual += rows.runs.restitution[run.row.run] - limit;
            run.sd = robust.scatter[run.kind as usize].sd(&run.row);
            run.clear = false;
            candidates.extend(Some(candidate(run, limit)).filter(|one| one.sds < -far));
        }
    }
    (sums, candidates)
}

/// The fit a candidate is held against.
struct ReferenceFit<'r> {
    rows: &'r Rows<'r>,
    fitted: LinearisedJoint,
    /// what it leaves of each kind
    kinds: [RowsLeft; 2],
    /// the same of each group, where groups differ
    groups: Vec<RowsLeft>,
}

impl<'r> ReferenceFit<'r> {
    fn new(rows: &'r Rows<'r>, sums: &[Sums], groups: usize) -> ReferenceFit<'r> {
        let fitted = rows.fit(sums);
        let mut kinds = [RowsLeft::default(); 2];
        let mut groups = vec![RowsLeft::default(); groups];
        for (part, sums) in sums.iter().enumerate() {
            let left = fitted.leaves(sums, 1.0);
            kinds[rows.kind(part) as usize].add(left);
            if let Some(own) = groups.get_mut(rows.group_of[part]) {
                own.add(left);
            }
        }
        ReferenceFit {
            rows,
            fitted,
            kinds,
            groups,
        }
    }

    /// Spread in units of the sd of the kind, and its degrees of freedom.
    fn spread(&self, run: &RunAtFit) -> (f64, f64) {
        let own = self.groups.get(self.rows.group_of[run.part]);
        let own = own.filter(|own| own.freedom >= LEAST_OF_OWN as f64);
        let left = own.unwrap_or(&self.kinds[run.kind as usize]);
        ((left.squares / left.freedom).sqrt(), left.freedom)
    }

    /// Restitution less model in units of the sd of the kind, and the leverage.
    fn distance(&self, run: &RunAtFit) -> (f64, f64) {
        let slopes = self.rows.slopes(run);
        let left = run.row.residual / run.sd + self.fitted.shift(&slopes);
        (-left, self.fitted.leverage(&slopes))
    }

    /// The distance over √(1 + leverage). Near the threshold m(r) bends too fast for that: there the distance counts that
    /// is left when the energy kept is off by [`OFF`] of its standard errors to the run's side.
    fn deletion_distance(&self, run: &RunAtFit) -> f64 {
        let (distance, leverage) = self.distance(run);
        if run.clear || run.kind == RunKind::Dry {
            return distance / (1.0 + leverage).sqrt();
        }
        let kept = run.row.kept;
        let se = leverage.max(0.0).sqrt() * run.sd / slope_mean_restitution(kept);
        let found = mean_restitution(kept) - run.row.residual;
        let left = (found - mean_restitution(kept + OFF * se * distance.signum())) / run.sd;
        if left * distance > 0.0 {
            left
        } else {
            0.0
        }
    }

    /// The run among those that stand beside an outlier which may be the wrong one: where two runs tell a parameter nearly by
    /// themselves and disagree, the others may not say which of them it is.
    fn rival(&self, outlier: &RunAtFit, beside: &[&RunAtFit], sums: &[Sums]) -> Option<usize> {
        /// leverage of a run that tells a parameter nearly by itself
        const TELLS: f64 = 0.2;
        /// squares by which the one lies farther from the fit without both, where it is twenty times as likely the wrong one
        const CLEAR: f64 = 6.0;
        let is_rival = |rival: &&&RunAtFit| {
            if self.fitted.leverage(&self.rows.slopes(rival)) < TELLS {
                return false;
            }
            let mut others = sums.to_vec();
            others[rival.part] = self.rows.blank();
            let left = beside.iter().filter(|run| run.row.run != rival.row.run);
            left.for_each(|run| self.rows.add(&mut others[rival.part], run));
            let without = ReferenceFit::new(self.rows, &others, self.groups.len());
            let [own, other] =
                [outlier, rival].map(|run| (without.deletion_distance(run) / without.spread(run).0).powi(2));
            without.fitted.inverse.rank < self.fitted.inverse.rank || own - other < CLEAR
        };
        Some(beside.iter().find(is_rival)?.row.run)
    }

    /// The parameter that adding a run moves most, and by how many standard errors of the fit without it.
    fn moves(&self, run: &RunAtFit) -> (usize, f64) {
        let (distance, leverage) = self.distance(run);
        let (spread, _) = self.spread(run);
        let mut pull = DVector::zeros(self.rows.names.len());
        for (place, slope) in self.rows.slopes(run) {
            pull[place] = slope * distance / (1.0 + leverage) / spread;
        }
        self.fitted.inverse.moved_most(&pull).unwrap_or_default()
    }

    fn describe(&self, candidate: &Candidate) -> Outlier {
        let rows = self.rows;
        let part = &rows.parts[candidate.run.part];
        let group = &rows.groups[rows.group_of[candidate.run.part]];
        let run = candidate.run.row.run;
        let restitution = rows.runs.restitution[run];
        let from = match part.stuck.contains(&run) {
            true => rows.scene.data.smallest_restitution,
            false => restitution,
        };
        let (distance, _) = self.distance(&candidate.run);
        let (moves, moves_in_se) = self.moves(&candidate.run);
        Outlier {
            row: rows.runs.row[run],
            place: rows.runs.places.of(rows.runs.row[run]).to_string(),
            particle: rows.particle(group).to_owned(),
            liquid: rows.liquid(group).map(str::to_owned),
            diameter_m: part.diameter,
            film_ratio: group.film_ratio,
            impact_speed_m_s: rows.runs.impact_speed[run],
            restitution,
            expected: from - distance * candidate.run.sd,
            sds: candidate.sds,
            moves: rows.names.get(moves).cloned().unwrap_or_default(),
            moves_in_se,
        }
    }
}
