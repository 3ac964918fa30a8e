//! Names the runs that normal noise would hardly ever take so far from the law.
//!
//! A run is found by its deletion residual t: its distance from the fit to the others, over the sd of that difference as
//! these others show it. Were all noise normal, some |t| among n runs would exceed the line t(1 − 0.01/2n) in one table of
//! a hundred (Bonferroni). Candidates are all taken out first, and come back from the least extreme on: none hides
//! another, and none widens the spread it is held against.

use nalgebra::DVector;
use rayon::prelude::*;
use serde::Serialize;

use super::rows::{GroupedPart, Rows, RunGroup};
use super::scatter::{is_clear, RobustFit};
use crate::distributions::student_t_quantile;
use crate::inference::joint::JointRow;
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    let of = |part: &GroupedPart| part.rebounds.len() + if censored { part.stuck.len() } else { 0 };
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

#[derive(Clone)]
struct Candidate {
    part: usize,
    row: JointRow,
    /// sd of its kind at its energy
    sd: f64,
    /// by how much less it counts where the energy scatters, too
    stretch: f64,
    /// whether it may come back into the fit; runs near or below the limit of sticking are never in it
    fits: bool,
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

/// Sorts every run by whether it is an outlier.
pub(super) fn find_outliers(rows: &Rows, robust: &RobustFit, unequal: Option<&[f64]>) -> OutlierSearch {
    let runs = count_tested(rows);
    let (mut sums, mut candidates) = gather(rows, robust, unequal, candidate_distance(runs));
    candidates.sort_by(|a, b| a.sds.abs().total_cmp(&b.sds.abs()));
    let mut reference = ReferenceFit::new(rows, &sums, unequal);
    // among many runs one more moves neither fit nor spread
    let many = 1 + runs / 10_000;
    let mut back = 0;
    let mut outlying = vec![];
    for mut candidate in candidates {
        let (spread, freedom) = reference.spread(&candidate);
        candidate.sds = candidate.stretch * reference.deletion_distance(&candidate) / spread;
        if candidate.sds.abs() > line(runs, freedom) {
            outlying.push(candidate);
        } else if candidate.fits {
            let part = &rows.parts[candidate.part];
            rows.add(&mut sums[candidate.part], part, &candidate.row, candidate.sd);
            back += 1;
            if back % many == 0 {
                reference = ReferenceFit::new(rows, &sums, unequal);
            }
        }
    }
    outlying.sort_by(|a, b| b.sds.abs().total_cmp(&a.sds.abs()).then(a.row.run.cmp(&b.row.run)));
    let mut all: Vec<usize> = outlying.iter().map(|one| one.row.run).collect();
    all.sort_unstable();
    outlying.truncate(MOST_DESCRIBED);
    OutlierSearch {
        outliers: outlying.iter().map(|one| reference.describe(one)).collect(),
        outlying: all,
        sums,
    }
}

/// Sums of the runs near the fit, and those far from it.
fn gather(rows: &Rows, robust: &RobustFit, unequal: Option<&[f64]>, far: f64) -> (Vec<Sums>, Vec<Candidate>) {
    let limit = rows.scene.data.smallest_restitution;
    let censored = rows.scene.model.sticking == Sticking::Censored;
    let of_part = |(index, part): (usize, &GroupedPart)| {
        let mut sums = rows.blank();
        let mut candidates = vec![];
        let scatter = robust.scatter[rows.kind(part) as usize];
        let own = unequal.map_or(1.0, |unequal| unequal[part.group]);
        let candidate = |row: JointRow, restitution: f64, fits: bool| {
            let sd = scatter.sd(&row);
            let stretch = sd / scatter.sd_to(&row, restitution);
            Candidate {
                part: index,
                row,
                sd,
                stretch,
                fits,
                sds: -stretch * row.residual / (sd * own),
            }
        };
        rows.each(part, part.rebounds.clone(), &robust.point, |row| {
            let sd = scatter.sd(&row);
            let clear = is_clear(rows, &row, sd);
            // cheap first: nearly every run is near
            let one = (row.residual.abs() > 0.5 * far * sd * own)
                .then(|| candidate(row, rows.runs.restitution[row.run], clear))
                .filter(|one| one.sds.abs() > far);
            match one {
                Some(one) => candidates.push(one),
                None if clear => rows.add(&mut sums, part, &row, sd),
                None => {}
            }
        });
        if censored {
            rows.each(part, part.stuck.clone(), &robust.point, |mut row| {
                row.residual += rows.runs.restitution[row.run] - limit;
                let one = candidate(row, limit, false);
                if one.sds < -far {
                    candidates.push(one);
                }
            });
        }
        (sums, candidates)
    };
    let (sums, candidates): (Vec<_>, Vec<_>) = rows.parts.par_iter().enumerate().map(of_part).unzip();
    (sums, candidates.concat())
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
    fn new(rows: &'r Rows<'r>, sums: &[Sums], unequal: Option<&[f64]>) -> ReferenceFit<'r> {
        let fitted = rows.fit(sums);
        let mut kinds = [RowsLeft::default(); 2];
        let mut groups = vec![RowsLeft::default(); rows.groups.len()];
        for (part, sums) in rows.parts.iter().zip(sums) {
            let left = fitted.leaves(sums, 1.0);
            kinds[rows.kind(part) as usize].add(left);
            groups[part.group].add(left);
        }
        if unequal.is_none() {
            groups.clear();
        }
        ReferenceFit {
            rows,
            fitted,
            kinds,
            groups,
        }
    }

    /// Spread in units of the sd of the kind, and its degrees of freedom.
    fn spread(&self, candidate: &Candidate) -> (f64, f64) {
        let part = &self.rows.parts[candidate.part];
        let own = self
            .groups
            .get(part.group)
            .filter(|own| own.freedom >= LEAST_OF_OWN as f64);
        let left = own.unwrap_or(&self.kinds[self.rows.kind(part) as usize]);
        ((left.squares / left.freedom).sqrt(), left.freedom)
    }

    fn slopes(&self, candidate: &Candidate) -> Vec<(usize, f64)> {
        self.rows.parts[candidate.part].slopes(&candidate.row, 1.0 / candidate.sd)
    }

    /// Restitution less model in units of the sd of the kind, and the leverage.
    fn distance(&self, candidate: &Candidate) -> (f64, f64) {
        let slopes = self.slopes(candidate);
        let left = candidate.row.residual / candidate.sd + self.fitted.shift(&slopes);
        (-left, self.fitted.leverage(&slopes))
    }

    /// The distance over √(1 + leverage). Near the threshold m(r) bends too fast for that: there the distance counts that
    /// is left when the energy kept is off by [`OFF`] of its standard errors to the run's side.
    fn deletion_distance(&self, candidate: &Candidate) -> f64 {
        let (distance, leverage) = self.distance(candidate);
        let part = &self.rows.parts[candidate.part];
        if candidate.fits || part.series.is_none() {
            return distance / (1.0 + leverage).sqrt();
        }
        let kept = candidate.row.kept;
        let se = leverage.max(0.0).sqrt() * candidate.sd / slope_mean_restitution(kept);
        let found = mean_restitution(kept) - candidate.row.residual;
        let left = (found - mean_restitution(kept + OFF * se * distance.signum())) / candidate.sd;
        if left * distance > 0.0 {
            left
        } else {
            0.0
        }
    }

    /// The parameter that adding a run moves most, and by how many standard errors of the fit without it.
    fn moves(&self, candidate: &Candidate) -> (usize, f64) {
        let (distance, leverage) = self.distance(candidate);
        let (spread, _) = self.spread(candidate);
        let mut pull = DVector::zeros(self.rows.names.len());
        for (place, slope) in self.slopes(candidate) {
            pull[place] = slope * distance / (1.0 + leverage) / spread;
        }
        self.fitted.inverse.moved_most(&pull).unwrap_or_default()
    }

    fn describe(&self, candidate: &Candidate) -> Outlier {
        let rows = self.rows;
        let part = &rows.parts[candidate.part];
        let RunGroup {
            sphere,
            liquid,
            film_ratio,
            ..
        } = rows.groups[part.group];
        let run = candidate.row.run;
        let stuck = part.stuck.contains(&run);
        let restitution = rows.runs.restitution[run];
        let from = if stuck {
            rows.scene.data.smallest_restitution
        } else {
            restitution
        };
        let (distance, _) = self.distance(candidate);
        let (moves, moves_in_se) = self.moves(candidate);
        Outlier {
            row: rows.runs.row[run],
            place: rows.runs.places.of(rows.runs.row[run]).to_string(),
            particle: rows.scene.particles[rows.runs.spheres[sphere].particle].name.clone(),
            liquid: liquid.map(|liquid| rows.scene.liquids[liquid].name.clone()),
            diameter_m: part.diameter,
            film_ratio,
            impact_speed_m_s: rows.runs.impact_speed[run],
            restitution,
            expected: from - distance * candidate.sd,
            sds: candidate.sds,
            moves: rows.names.get(moves).cloned().unwrap_or_default(),
            moves_in_se,
        }
    }
}
