//! Checks one run and says which of its cells is wrong.

use std::collections::BTreeMap;

use super::averaged::{mean_of, MeanOf};
use super::columns::HeaderRemarks;
use super::errors::{self, RunError};
use super::raw_row::{
    bad_cell, fall, refuse, stokes_scale, surface, BadCell, RawRow, IMPACTS, LARGEST_RESTITUTION, MEASUREMENT_SDS,
    REBOUNDS,
};
use super::read_run::{ReadRun, RowSetting};
use super::told_twice::{rounding_of_log, speed_ratios, SpeedRatios};
use crate::error::PROBLEMS_SHOWN;
use crate::physics::numbers::free_fall_speed;
use crate::scene::{name_expected, RunColumn, Scene, DRY};
use crate::units::{millimetres, MAGNITUDES, MAGNITUDE_EXPECTED};

/// A restitution above this may be one in per cent.
const LEAST_OF_PERCENT: f64 = 5.0;

/// Rebound speed over impact speed and a restitution given beside them must agree to this, or to what rounding explains.
const AGREEMENT: f64 = 0.002;

/// The same of a restitution and one from a height that was measured beside it, as a share.
const AGREEMENT_OF_HEIGHTS: f64 = 0.05;

/// The most that rounding of speeds and restitutions may explain, whose last zeros may not be written.
const MOST_BY_ROUNDING: f64 = 0.05;

/// What is expected of a run whose rebound is missing, which is not one that stuck.
const REBOUND_EXPECTED: &str =
    "expected what the rebound was, 0 where the run stuck; a run whose rebound was not measured \
                                is left out by a reason in a column `exclude`";

/// Columns that only runs with a liquid have a number above 0 in.
const OF_WET_RUNS: [(RunColumn, &str); 3] = [
    (RunColumn::Film, "a film"),
    (RunColumn::FilmRatio, "a film"),
    (RunColumn::Stokes, "a Stokes number"),
];

/// One run, checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CheckedRow {
    /// without its row
    pub run: ReadRun,
    /// the runs that it is the mean of; `None` of a single run
    pub mean_of: Option<MeanOf>,
    /// how columns that tell the same thing compare
    pub ratios: SpeedRatios,
}

/// What is expected where no particle of the scene stands, and where no liquid.
const NAMES: [&str; 2] = ["a name in [particles]", "a name in [liquids] or `dry`"];

/// What a row is checked against.
pub(super) struct RowChecker<'s> {
    pub scene: &'s Scene,
    /// of the names of particles and of liquids, whose columns come first in this order
    places: [BTreeMap<&'s str, u32>; 2],
    remarks: &'s HeaderRemarks,
    /// unknown names that may still be compared with every name of the scene: beyond, no message is printed
    to_compare: usize,
}

impl<'s> RowChecker<'s> {
    pub fn new(scene: &'s Scene, remarks: &'s HeaderRemarks) -> Self {
        RowChecker {
            scene,
            places: [
                scene.particles.iter().map(|p| p.name.as_str()).zip(0..).collect(),
                scene.liquids.iter().map(|l| l.name.as_str()).zip(0..).collect(),
            ],
            remarks,
            to_compare: PROBLEMS_SHOWN,
        }
    }

    /// Whether a particle or a liquid is one of the scene, by the column of it.
    pub fn knows(&self, column: RunColumn, name: Option<&str>) -> bool {
        name.is_some_and(|name| self.places[column as usize].contains_key(name))
    }

    /// The place of a particle or a liquid in the scene; a name that is none there is pushed to `problems`.
    fn find(&mut self, column: RunColumn, name: &str, problems: &mut Vec<BadCell>) -> Option<u32> {
        let (what, places) = (NAMES[column as usize], &self.places[column as usize]);
        let found = places.get(name).copied();
        if found.is_none() {
            let expected = match self.to_compare {
                0 => format!("expected {what}"),
                _ => name_expected(what, name, places.keys().copied()),
            };
            self.to_compare = self.to_compare.saturating_sub(1);
            problems.push(bad_cell(column, expected));
        }
        found
    }
}

fn is_bad(column: RunColumn, problems: &[BadCell]) -> bool {
    problems.iter().any(|bad| bad.column == column)
}

fn positive(raw: &RawRow, column: RunColumn, what: &str, problems: &mut Vec<BadCell>) -> Option<f64> {
    positive_value(column, raw[column], what, problems)
}

fn positive_value(column: RunColumn, value: Option<f64>, what: &str, problems: &mut Vec<BadCell>) -> Option<f64> {
    let expected = match value {
        Some(x) if MAGNITUDES.contains(&x) => return value,
        // its cell was refused before
        None if is_bad(column, problems) => return None,
        Some(f64::INFINITY) => format!("expected {what} that is finite"),
        Some(x) if x > 0.0 => format!("expected {what} of {MAGNITUDE_EXPECTED}"),
        _ => format!("expected {what} above 0"),
    };
    refuse(problems, column, expected)
}

/// Checks a run. Every wrong cell is pushed to `problems`, which may hold cells of this run that were no numbers; the
/// run is `Some` only if there is none. `rounding` gives half the last digit that is written in a column, as a share of its
/// number.
pub(super) fn check_row(
    raw: &RawRow,
    checker: &mut RowChecker,
    rounding: impl Fn(RunColumn) -> f64,
    problems: &mut Vec<BadCell>,
) -> Option<CheckedRow> {
    let is_dry = raw.is_dry();
    let particle = match raw.word(RunColumn::Particle) {
        Some(name) => checker.find(RunColumn::Particle, name, problems),
        None => refuse(problems, RunColumn::Particle, "expected a name in [particles]"),
    };
    let has = |column: RunColumn| raw[column].is_some_and(|value| value > 0.0);
    let liquid = match raw.word(RunColumn::Liquid) {
        Some(name) if !is_dry => checker.find(RunColumn::Liquid, name, problems),
        // an empty cell means dry only where nothing speaks of a film: else it is a name that was left out, as of merged cells
        None => match OF_WET_RUNS
            .into_iter()
            .find(|(column, _)| checker.remarks.tells_liquid && has(*column))
        {
            Some((_, beside)) => {
                let expected = format!("expected a name in [liquids], or `{DRY}`, beside {beside}");
                refuse(problems, RunColumn::Liquid, expected)
            }
            None => None,
        },
        Some(_) => None,
    };
    let diameter = positive(raw, RunColumn::Diameter, "a diameter", problems);
    let has_speed =
        raw[RunColumn::ImpactSpeed].is_some() || raw[RunColumn::DropHeight].or(raw[RunColumn::Stokes]).is_none();
    let mut impact_speed = None;
    if has_speed {
        impact_speed = positive(raw, RunColumn::ImpactSpeed, "an impact speed", problems);
    }
    let film = if is_dry {
        Some(0.0)
    } else {
        let what = match raw[RunColumn::Film] {
            None => "`dry` as the liquid, or a film thickness",
            Some(_) => "a film thickness",
        };
        let film = positive(raw, RunColumn::Film, what, problems);
        if film.zip(diameter).is_some_and(|(film, diameter)| film > diameter) {
            problems.push(bad_cell(RunColumn::Film, "expected a film no thicker than the sphere"));
        }
        film
    };
    let film_ratio = raw[RunColumn::FilmRatio].filter(|_| !is_dry);
    if checker.remarks.has_film_ratio && !is_dry && film_ratio.is_none() && !is_bad(RunColumn::FilmRatio, problems) {
        let expected = "expected the film ratio the run belongs to, as every wet run of a file with this column has";
        problems.push(bad_cell(RunColumn::FilmRatio, expected));
    }
    if film_ratio.is_some_and(|ratio| !(ratio > 0.0 && ratio <= 1.0)) {
        let expected = "expected a film ratio above 0 and up to 1";
        problems.push(bad_cell(RunColumn::FilmRatio, expected));
    }
    let surface = surface(checker.scene, film, diameter);
    let of_stokes = stokes_scale(checker.scene, particle, liquid, diameter);
    let ratios = surface.map(|surface| speed_ratios(raw, surface, of_stokes, &rounding));
    if !has_speed {
        impact_speed = derived_speed(raw, surface, of_stokes, problems);
    }
    let rebound = rebound_speed(raw, surface, &rounding, problems);
    let restitution = restitution(raw, impact_speed, rebound, rounding, problems);
    let limit = checker.scene.data.smallest_restitution;
    let mean_of = restitution.and_then(|restitution| mean_of(raw, restitution, limit, problems));
    let sds = MEASUREMENT_SDS.map(|column| raw[column]);
    check_sds(sds, problems);
    let correlation = raw[RunColumn::SpeedCorrelation];
    if correlation.is_some_and(|rho| !(-1.0..=1.0).contains(&rho)) {
        let expected = "expected a correlation from -1 to 1";
        problems.push(bad_cell(RunColumn::SpeedCorrelation, expected));
    }
    if !problems.is_empty() {
        return None;
    }
    let (impact_speed, restitution) = (impact_speed?, restitution?);
    let setting = RowSetting {
        particle: particle?,
        liquid,
        diameter: diameter?,
        film: film?,
    };
    let errors = match sds.iter().any(Option::is_some) {
        true => errors::of_run(sds, correlation.unwrap_or(0.0), impact_speed, restitution),
        false => RunError::default(),
    };
    Some(CheckedRow {
        run: ReadRun {
            setting,
            impact_speed,
            restitution,
            film_ratio,
            errors,
            ..ReadRun::default()
        },
        mean_of,
        ratios: ratios.unwrap_or_default(),
    })
}

/// Checks a run's standard deviations. One far below its quantity is no mistake; one beyond every magnitude would
/// overflow.
fn check_sds(sds: [Option<f64>; 3], problems: &mut Vec<BadCell>) {
    for (column, sd) in MEASUREMENT_SDS.into_iter().zip(sds) {
        if sd.is_some_and(|sd| !(sd >= 0.0 && sd.is_finite())) {
            problems.push(bad_cell(column, "expected a finite standard deviation of 0 or more"));
        } else if sd.is_some_and(|sd| sd > *MAGNITUDES.end()) {
            let most = MAGNITUDES.end();
            let expected = format!("expected a standard deviation of at most {most:e} in SI units");
            problems.push(bad_cell(column, expected));
        }
    }
}

/// The impact speed of a run that has a drop height or a Stokes number in its place.
fn derived_speed(
    raw: &RawRow,
    surface: Option<f64>,
    of_stokes: Option<f64>,
    problems: &mut Vec<BadCell>,
) -> Option<f64> {
    let (column, speed) = if raw[RunColumn::DropHeight].is_some() {
        let height = positive(raw, RunColumn::DropHeight, "a drop height", problems)?;
        let surface = surface?;
        let Some(fall) = fall(height, surface) else {
            let expected = format!(
                "expected a drop height above {:.4} mm, where the fall ends",
                millimetres(surface)
            );
            return refuse(problems, RunColumn::DropHeight, expected);
        };
        (RunColumn::DropHeight, free_fall_speed(fall))
    } else {
        let stokes = positive(raw, RunColumn::Stokes, "a Stokes number", problems)?;
        let Some(scale) = of_stokes else {
            let wanted = [RunColumn::Particle, RunColumn::Liquid, RunColumn::Diameter];
            if wanted.into_iter().any(|column| is_bad(column, problems)) {
                return None;
            }
            let expected = "expected a drop height or an impact speed: without a liquid there is no Stokes number";
            return refuse(problems, RunColumn::Stokes, expected);
        };
        (RunColumn::Stokes, stokes * scale)
    };
    positive_value(column, Some(speed), "an impact speed", problems)
}

/// A rebound as it was read.
struct Rebound {
    /// the column it stands in
    column: RunColumn,
    speed: f64,
    /// whether the sphere may have turned below the surface of the film, by the digits of its height
    may_have_stuck: bool,
}

/// The rebound with its speed; that of a rebound height at the surface of the film, which a sphere that turned below it did not
/// reach.
fn rebound_speed(
    raw: &RawRow,
    surface: Option<f64>,
    rounding: impl Fn(RunColumn) -> f64,
    problems: &mut Vec<BadCell>,
) -> Option<Rebound> {
    if let Some(speed) = raw[RunColumn::ReboundSpeed] {
        return Some(Rebound {
            column: RunColumn::ReboundSpeed,
            speed,
            may_have_stuck: false,
        });
    }
    let column = RunColumn::ReboundHeight;
    let height = raw[column]?;
    if height.is_nan() || height < 0.0 {
        return refuse(problems, column, "expected a rebound height of 0 or more");
    }
    let surface = surface?;
    Some(Rebound {
        column,
        speed: fall(height, surface).map_or(0.0, free_fall_speed),
        may_have_stuck: fall(height * (1.0 - rounding(column)), surface).is_none(),
    })
}

/// The run's restitution from either or both of its columns.
fn restitution(
    raw: &RawRow,
    impact_speed: Option<f64>,
    rebound: Option<Rebound>,
    rounding: impl Fn(RunColumn) -> f64,
    problems: &mut Vec<BadCell>,
) -> Option<f64> {
    let in_range = |e: f64| (0.0..=LARGEST_RESTITUTION).contains(&e);
    let given = raw[RunColumn::Restitution];
    if let Some(e) = given.filter(|e| !in_range(*e)) {
        let is_percent = e > LEAST_OF_PERCENT && in_range(e / 100.0);
        let hint = if is_percent {
            "; per cent stand in a column `restitution_percent`"
        } else {
            ""
        };
        let expected = format!("expected a restitution from 0 to {LARGEST_RESTITUTION}{hint}");
        return refuse(problems, RunColumn::Restitution, expected);
    }
    let Some(rebound) = rebound else {
        let is_any_bad = || REBOUNDS.into_iter().any(|column| is_bad(column, problems));
        // a height that says nothing was refused, or what it is counted from
        let refused = raw[RunColumn::ReboundHeight].is_some() || is_any_bad();
        if given.is_none() && !refused {
            problems.push(bad_cell(RunColumn::Restitution, REBOUND_EXPECTED));
        }
        return given;
    };
    let column = rebound.column;
    if rebound.speed.is_nan() || rebound.speed < 0.0 {
        return refuse(problems, column, "expected a rebound speed of 0 or more");
    }
    let quotient = rebound.speed / impact_speed?;
    if !in_range(quotient) {
        let expected =
            format!("expected at most {LARGEST_RESTITUTION} times the impact speed (restitution {quotient:.3})");
        return refuse(problems, column, expected);
    }
    // a height is a measurement of its own, beside a restitution from a camera
    let agreement = match (column, given) {
        (RunColumn::ReboundHeight, Some(e)) => (AGREEMENT_OF_HEIGHTS * e).max(AGREEMENT),
        _ => AGREEMENT,
    };
    let by_rounding = |e: f64| {
        let impact = IMPACTS.into_iter().find(|column| raw[*column].is_some());
        let columns = [Some(RunColumn::Restitution), Some(column), impact];
        let by = |heights: bool| {
            let is_height = |column: &RunColumn| matches!(column, RunColumn::DropHeight | RunColumn::ReboundHeight);
            let own = columns
                .into_iter()
                .flatten()
                .filter(|column| is_height(column) == heights);
            e * own
                .map(|column| rounding_of_log(raw, column, &rounding))
                .sum::<f64>()
                .exp_m1()
        };
        (by(true) + by(false).min(MOST_BY_ROUNDING)).max(agreement) * (1.0 + 1e-9)
    };
    match given {
        Some(0.0) if rebound.may_have_stuck => given,
        // what is within needs no look at the digits
        Some(e) if (e - quotient).abs() > agreement && (e - quotient).abs() > by_rounding(e) => {
            let agreement = (1e3 * by_rounding(e)).round() / 1e3;
            let expected = format!("expected agreement with rebound over impact speed ({quotient:.4}) to {agreement}");
            refuse(problems, RunColumn::Restitution, expected)
        }
        Some(e) => Some(e),
        None => Some(quotient),
    }
}
