//! Tests the wet law inside each particle, liquid and film: does e² bend or slope with v or 1/St as the law does not?
//!
//! Every group of one particle, liquid and film ratio has an energy of its own here, so that neither the form of the
//! inertial loss nor an offset of a series is tested, only what happens from slow to fast runs. The law is held against
//! one more column at a time: (1/St)² and v^(1/5), each with one factor for all groups; 1/St with a factor for one group
//! alone, which is a viscous loss of its own; either with one for the groups of one liquid; 1/St with one for the groups of
//! one particle, where a density is wrong; and v^(1/5) with one for the runs of one film ratio, whatever the liquid and the
//! sphere. Without energies of the groups, where no series has an offset, more is asked: the viscous loss of a liquid and of
//! a particle once again, that of a diameter, a loss that goes with the film in a liquid or a particle, and both losses times
//! the place of the run in its table, since a liquid may warm and a film dry while runs are recorded. Each p is
//! multiplied by the number of columns (Bonferroni), that of the viscous loss of a liquid by the number of such columns alone
//! where chance then does not explain it; of those beyond chance the one that moves a parameter most is told.
//!
//! Rebounds near sticking have no fair residual and are left out, single outliers as well. A table that does not say how
//! well speeds are known may have errors of a per cent, which near the threshold outweigh the rest: runs are weighed for
//! that. A film group that holds several film ratios is cut at its gaps.

use std::collections::BTreeSet;

use nalgebra::DVector;
use schemars::JsonSchema;
use serde::Serialize;

use super::outliers::OutlierSearch;
use super::rows::{group_name, Rows, RunKind};
use super::scatter::RobustFit;
use crate::findings::remarks::BEYOND_CHANCE;
use crate::inference::linearised_joint::{Inverse, LinearisedJoint};
use crate::inference::nested::{nested, FTest, Spread};
use crate::inference::sums::{along, Sums};
use crate::physics::rebound::slope_mean_restitution;
use crate::runs::sphere_words;

/// Relative error of speeds in a table that states none.
const SPEED_ERROR: f64 = 0.01;

/// What the wet law is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WetAlternative {
    /// a term in (1/St)², the same in all groups
    CurvatureInInverseStokes,
    /// a term in v^(1/5), the same in all groups
    SlopeInSpeed,
    /// one group with a term in 1/St of its own
    SlopeOfOneGroup,
    /// all groups of one liquid with one term in 1/St of their own
    SlopeOfOneLiquid,
    /// all groups of one liquid with one term in v^(1/5) of their own
    FallOfOneLiquid,
    /// all groups of one particle with one term in 1/St of their own
    SlopeOfOneParticle,
    /// all runs of one film ratio with one term in v^(1/5) of their own
    FallOfOneFilm,
    /// all runs of one diameter with one term in 1/St of their own
    SlopeOfOneDiameter,
    /// all groups of one liquid with one term in the film ratio of their own
    FilmLossOfOneLiquid,
    /// all groups of one particle with one term in the film ratio of their own
    FilmLossOfOneParticle,
    /// a term in 1/St times the place of the run in its table
    DriftOfViscousLoss,
    /// a term in the film ratio times that place
    DriftOfFilmLoss,
}

impl WetAlternative {
    /// Its name in a sentence.
    pub fn words(self) -> &'static str {
        match self {
            WetAlternative::CurvatureInInverseStokes => "a curvature of e² in 1/St",
            WetAlternative::SlopeInSpeed => "a slope of e² in v",
            WetAlternative::SlopeOfOneGroup => "a viscous loss of its own in one group",
            WetAlternative::SlopeOfOneLiquid => "a viscous loss of its own in one liquid",
            WetAlternative::FallOfOneLiquid => "a slope of e² in v in one liquid",
            WetAlternative::SlopeOfOneParticle => "a viscous loss of its own of one particle",
            WetAlternative::FallOfOneFilm => "a slope of e² in v at one film ratio",
            WetAlternative::SlopeOfOneDiameter => "a viscous loss of its own of one diameter",
            WetAlternative::FilmLossOfOneLiquid => "a loss with the film of its own in one liquid",
            WetAlternative::FilmLossOfOneParticle => "a loss with the film of its own of one particle",
            WetAlternative::DriftOfViscousLoss => "a viscous loss that drifts from the first row to the last",
            WetAlternative::DriftOfFilmLoss => "a loss with the film that drifts from the first row to the last",
        }
    }
}

/// The wet law against one alternative: of those beyond chance the one that moves a parameter most; where none is, the one that
/// chance explains least.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct WetLawTest {
    /// what it is held against
    pub against: WetAlternative,
    /// the test; p is multiplied by the number of alternatives
    #[serde(flatten)]
    pub test: FTest,
    /// how many alternatives were tried
    pub alternatives: usize,
    /// particle, liquid and film ratio of the group that departs most from the law
    pub group: String,
    /// the parameter that the departure moves most
    pub moves: String,
    /// by how much, in its standard errors
    pub moves_in_se: f64,
}

/// Runs of one particle, liquid and film, and of one series where each has an offset of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Group {
    /// index into [`Rows::groups`]
    of: usize,
    /// index into [`Rows::parts`]; `None` where series have no offsets
    part: Option<usize>,
    /// film ratio of the thinnest film, where the group was cut since its films differ
    from: Option<f64>,
}

/// A wet rebound inside its group: every number over the sd of the run.
#[derive(Clone)]
struct WetRow {
    group: Group,
    /// index into the scene's liquids
    liquid: usize,
    /// index into the scene's particles
    particle: usize,
    /// D in whole µm
    diameter: usize,
    film_ratio: f64,
    /// which of the film ratios of all runs, the thinnest first
    film: usize,
    /// where it stands in its table, 1 at the end
    place: f64,
    restitution: f64,
    outlying: bool,
    /// residual of the law fitted inside the groups
    residual: f64,
    /// slopes in the parameters, each with its place, free of the group's own energy where each group has one
    slopes: Vec<(usize, f64)>,
    /// slope in the energy kept
    of_energy: f64,
    inverse_stokes: f64,
    speed_root: f64,
}

/// Which liquid, particle, diameter or film a run is of.
type Class = fn(&WetRow) -> usize;

/// What the energy is held against.
type Column = fn(&WetRow) -> f64;

/// A column of the energy that some of the runs have for themselves.
struct ColumnOfSome {
    against: WetAlternative,
    /// whose it is: of each liquid, particle, diameter or film in turn
    of: Class,
    column: Column,
    /// whether each group has an energy of its own beside it
    inside_groups: bool,
}

#[rustfmt::skip]
const OF_SOME: [ColumnOfSome; 9] = {
    use WetAlternative::*;
    let [of_liquid, of_particle]: [Class; 2] = [|row| row.liquid, |row| row.particle];
    let [viscous, fall, film]: [Column; 3] = [|row| row.inverse_stokes, |row| row.speed_root, |row| row.film_ratio];
    [
        ColumnOfSome { against: SlopeOfOneLiquid, of: of_liquid, column: viscous, inside_groups: true },
        ColumnOfSome { against: SlopeOfOneLiquid, of: of_liquid, column: viscous, inside_groups: false },
        ColumnOfSome { against: FallOfOneLiquid, of: of_liquid, column: fall, inside_groups: true },
        ColumnOfSome { against: SlopeOfOneParticle, of: of_particle, column: viscous, inside_groups: true },
        ColumnOfSome { against: SlopeOfOneParticle, of: of_particle, column: viscous, inside_groups: false },
        ColumnOfSome { against: SlopeOfOneDiameter, of: |row| row.diameter, column: viscous, inside_groups: false },
        ColumnOfSome { against: FallOfOneFilm, of: |row| row.film, column: fall, inside_groups: true },
        ColumnOfSome { against: FilmLossOfOneLiquid, of: of_liquid, column: film, inside_groups: false },
        ColumnOfSome { against: FilmLossOfOneParticle, of: of_particle, column: film, inside_groups: false },
    ]
};

/// The test; `None` where no group has runs at different settings, or too few are left to tell the scatter.
pub(super) fn test_wet_law(rows: &Rows, robust: &RobustFit, sorted: &OutlierSearch) -> Option<WetLawTest> {
    let mut plain = wet_rows(rows, robust, sorted);
    // of the fit that is quoted, in which groups have no energy of their own
    let quoted = Inverse::of(&sums_of(rows, robust, &plain).information);
    let mut wet = plain.clone();
    wet.chunk_by_mut(|a, b| a.group == b.group).for_each(free_of_own_energy);
    let law = FittedLaw::new(rows, robust, &mut wet, true)?;
    // levels can be compared where none is an offset
    let by_level = FittedLaw::new(rows, robust, &mut plain, false).filter(|_| !rows.scene.model.series_offsets);
    let x = |row: &WetRow| row.inverse_stokes;
    let mut found = vec![
        law.against(WetAlternative::CurvatureInInverseStokes, &wet, |row| x(row) * x(row)),
        law.against(WetAlternative::SlopeInSpeed, &wet, |row| row.speed_root),
    ];
    let of_groups = wet.chunk_by(|a, b| a.group == b.group);
    found.extend(of_groups.map(|group| law.against(WetAlternative::SlopeOfOneGroup, group, x)));
    for own in OF_SOME {
        let (law, wet) = match &by_level {
            _ if own.inside_groups => (&law, &wet),
            Some(law) => (law, &plain),
            None => continue,
        };
        let of_one = |one: usize| move |row: &WetRow| if (own.of)(row) == one { (own.column)(row) } else { 0.0 };
        let each: BTreeSet<usize> = wet.iter().map(own.of).collect();
        let each = each.iter().filter(|_| each.len() > 1);
        found.extend(each.map(|one| law.against(own.against, wet, of_one(*one))));
    }
    if let Some(law) = by_level.as_ref().filter(|_| !is_sorted_by_restitution(&plain)) {
        found.extend([
            law.against(WetAlternative::DriftOfViscousLoss, &plain, |row| row.place * x(row)),
            law.against(WetAlternative::DriftOfFilmLoss, &plain, |row| {
                row.place * row.film_ratio
            }),
        ]);
    }
    let mut found: Vec<Departure> = found.into_iter().flatten().collect();
    let all = found.len();
    let is_of_liquid = |one: &&mut Departure| one.against == WetAlternative::SlopeOfOneLiquid;
    let of_liquids = found.iter_mut().filter(is_of_liquid).count();
    for one in &mut found {
        // one L for all liquids is a question by itself, as one k for all diameters is
        let by_itself = is_of_liquid(&one) && one.test.p * (of_liquids as f64) < BEYOND_CHANCE;
        one.tried = if by_itself { of_liquids } else { all };
        one.test.p *= one.tried as f64;
    }
    let least = found.iter().map(|one| one.test.p).reduce(f64::min)?;
    // the one that moves most of all beyond chance; where none is, of those that are the same on these runs, as a loss of the
    // one of two liquids or of the other
    let line = (least * (1.0 + 1e-6)).max(BEYOND_CHANCE);
    let as_rare = found.into_iter().filter(|one| one.test.p <= line);
    let moving = as_rare.filter_map(|one| Some((one.moves(&quoted)?, one)));
    let ((moves, moves_in_se), mut worst) =
        moving.reduce(|most, next| if next.0 .1 > most.0 .1 { next } else { most })?;
    worst.test.p = worst.test.p.min(1.0);
    let most = worst.group()?;
    let group = &rows.groups[most.of];
    let particle = sphere_words(rows.particle(group), rows.runs.spheres[group.sphere].diameter);
    let film_ratio = most.from.or(group.film_ratio);
    Some(WetLawTest {
        against: worst.against,
        test: worst.test,
        alternatives: worst.tried,
        group: group_name(&particle, rows.liquid(group), None, film_ratio),
        moves: rows.names[moves].clone(),
        moves_in_se,
    })
}

/// Whether somebody has put the runs of each group in the order of what was measured, which then goes with their place.
fn is_sorted_by_restitution(wet: &[WetRow]) -> bool {
    /// share of neighbours that stand in order
    const SORTED: f64 = 0.8;
    let mut by_place: Vec<&WetRow> = wet.iter().collect();
    by_place.sort_by(|a, b| a.group.of.cmp(&b.group.of).then(a.place.total_cmp(&b.place)));
    let groups = || by_place.chunk_by(|a, b| a.group.of == b.group.of);
    let pairs: usize = groups().map(|group| group.len() - 1).sum();
    let in_order = |column: fn(&WetRow) -> f64| {
        let neighbours = groups().flat_map(|group| group.windows(2));
        let steps = neighbours.map(|pair| column(pair[0]).total_cmp(&column(pair[1])) as i32);
        f64::from(steps.sum::<i32>().abs())
    };
    let by_restitution = in_order(|row| row.restitution);
    by_restitution > SORTED * pairs as f64 && by_restitution > in_order(|row| row.speed_root)
}

/// The rebounds clear of sticking, by group; none of a group of one.
fn wet_rows(rows: &Rows, robust: &RobustFit, sorted: &OutlierSearch) -> Vec<WetRow> {
    /// share of a group's runs
    const MISHAPS: f64 = 0.2;
    let mut wet = vec![];
    let last_row = rows.runs.row.iter().copied().max().map_or(1.0, f64::from);
    for own in &robust.runs {
        let group = rows.group_of[own.part];
        let Some(liquid) = rows.groups[group].liquid else {
            continue;
        };
        let mut own = own.clone();
        if own.row.measured == 0.0 {
            own.sd = own.sd.hypot(SPEED_ERROR * own.error_slope);
        }
        if !rows.is_clear(&own.row, own.sd) {
            continue;
        }
        let run = own.row.run;
        wet.push(WetRow {
            group: Group {
                of: group,
                part: rows.scene.model.series_offsets.then_some(own.part),
                from: None,
            },
            liquid,
            particle: rows.runs.spheres[rows.groups[group].sphere].particle,
            diameter: (1e6 * rows.parts[own.part].diameter).round() as usize,
            film_ratio: rows.runs.impacts.film_ratio[run],
            film: 0,
            place: f64::from(rows.runs.row[run]) / last_row,
            restitution: rows.runs.restitution[run],
            outlying: sorted.is_outlying(run),
            residual: own.row.residual / own.sd,
            slopes: rows.slopes(&own),
            of_energy: slope_mean_restitution(own.row.kept) / own.sd,
            inverse_stokes: rows.runs.inverse_stokes(run),
            speed_root: rows.runs.impacts.speed_root[run],
        });
    }
    wet.sort_by(|a, b| {
        let by_group = (a.group.of, a.group.part).cmp(&(b.group.of, b.group.part));
        by_group.then(a.film_ratio.total_cmp(&b.film_ratio))
    });
    wet.chunk_by_mut(|a, b| a.group == b.group).for_each(|group| {
        // in the order of their films
        if group[group.len() - 1].film_ratio > ONE_FILM * group[0].film_ratio {
            each_film(group, |row, _, from| row.group.from = Some(from));
        }
    });
    let mut by_film: Vec<&mut WetRow> = wet.iter_mut().collect();
    by_film.sort_by(|a, b| a.film_ratio.total_cmp(&b.film_ratio));
    each_film(by_film, |row, film, _| row.film = film);
    let mut left: Vec<WetRow> = vec![];
    for of_group in wet.chunk_by(|a, b| a.group == b.group) {
        // outliers that stand alone are left out; several among the runs of one film are no mishaps
        let outlying = of_group.iter().filter(|row| row.outlying).count();
        let are_mishaps = outlying < 2 || (outlying as f64) < MISHAPS * of_group.len() as f64;
        let kept = || of_group.iter().filter(move |row| !(row.outlying && are_mishaps));
        if kept().count() > 1 {
            left.extend(kept().cloned());
        }
    }
    left
}

/// Largest over smallest of one film ratio recorded with an error of 4 %.
const ONE_FILM: f64 = 1.28;

/// Cuts runs in the order of their films at the gaps, and where they differ by more than one film ratio does: `say` hears of
/// each run the number of its film and the ratio of the thinnest in it.
fn each_film<'w>(rows: impl IntoIterator<Item = &'w mut WetRow>, say: impl Fn(&mut WetRow, usize, f64)) {
    /// films of one film ratio stand closer than this
    const GAP: f64 = 1.05;
    let (mut film, mut from, mut before) = (0, None, 0.0);
    for row in rows {
        let ratio = row.film_ratio;
        let start = *from.get_or_insert(ratio);
        if ratio > ONE_FILM * start || (before > 0.0 && ratio > GAP * before) {
            film += 1;
            from = Some(ratio);
        }
        before = ratio;
        say(row, film, from.unwrap_or(ratio));
    }
}

/// Takes out of residuals and slopes what an energy of the group's own explains.
fn free_of_own_energy(group: &mut [WetRow]) {
    let residuals = centred(group, |row| row.residual);
    let slope = |j: usize| centred(group, |row| row.slopes[j].1);
    let slopes: Vec<Vec<f64>> = (0..group[0].slopes.len()).map(slope).collect();
    for (i, row) in group.iter_mut().enumerate() {
        row.residual = residuals[i];
        row.slopes.iter_mut().zip(&slopes).for_each(|(own, all)| own.1 = all[i]);
    }
}

/// A column of one group without its part along an energy that all its runs share; zeros where only rounding is left.
fn centred(group: &[WetRow], column: impl Fn(&WetRow) -> f64) -> Vec<f64> {
    const ROUNDING: f64 = 1e-20;
    let values: Vec<f64> = group.iter().map(column).collect();
    let own: f64 = group.iter().map(|row| row.of_energy * row.of_energy).sum();
    let rows = || group.iter().zip(&values);
    let with: f64 = rows().map(|(row, value)| row.of_energy * value).sum();
    let left = rows().map(|(row, value)| value - row.of_energy * with / own);
    let left: Vec<f64> = left.collect();
    if square(&left) > ROUNDING * square(&values) {
        left
    } else {
        vec![0.0; left.len()]
    }
}

fn square(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum()
}

/// The law fitted to the wet runs.
struct FittedLaw {
    /// whether each group has an energy of its own
    inside_groups: bool,
    fit: LinearisedJoint,
    /// what it leaves of the wet runs
    spread: Spread,
}

/// The law against one alternative.
struct Departure<'w> {
    law: &'w FittedLaw,
    against: WetAlternative,
    test: FTest,
    /// how many alternatives were tried with it
    tried: usize,
    /// the runs that the alternative is about
    wet: &'w [WetRow],
    /// the alternative's column, beside an energy of each group's own where they have one, times its factor
    column: Vec<f64>,
    /// what the law has of it, as a step of the parameters
    taken: DVector<f64>,
    /// what it adds to the parameters' gradient
    pull: DVector<f64>,
}

impl Departure<'_> {
    /// The group in which it explains most.
    fn group(&self) -> Option<Group> {
        let explained = |group: &[(&WetRow, &f64)]| -> f64 {
            let of_row = |(row, x): &(&WetRow, &f64)| (*x - along(&row.slopes, &self.taken)) * row.residual;
            group.iter().map(of_row).sum()
        };
        let of_it = |(_, x): &(&WetRow, &f64)| **x != 0.0;
        let rows: Vec<(&WetRow, &f64)> = self.wet.iter().zip(&self.column).filter(of_it).collect();
        let groups = rows.chunk_by(|a, b| a.0.group == b.0.group);
        let most = groups.max_by(|a, b| explained(a).total_cmp(&explained(b)))?;
        Some(most[0].0.group)
    }

    /// The parameter of the quoted fit that it moves most, and by how many of its standard errors.
    fn moves(&self, quoted: &Inverse) -> Option<(usize, f64)> {
        let left = self.law.spread;
        let sd = (left.sum_of_squares / (left.runs - left.parameters) as f64).sqrt();
        let (place, in_units) = quoted.moved_most(&self.pull)?;
        Some((place, in_units / sd))
    }
}

/// Sums over the wet runs, and over the dry ones about their law.
fn sums_of(rows: &Rows, robust: &RobustFit, wet: &[WetRow]) -> Sums {
    let mut sums = Sums::new(rows.names.len());
    wet.iter().for_each(|row| sums.add(row.residual, &row.slopes));
    for dry in robust.runs.iter().filter(|run| run.kind == RunKind::Dry) {
        sums.add(dry.row.residual / dry.sd, &rows.slopes(dry));
    }
    sums
}

impl FittedLaw {
    fn new(rows: &Rows, robust: &RobustFit, wet: &mut [WetRow], inside_groups: bool) -> Option<FittedLaw> {
        let fit = LinearisedJoint::new(&sums_of(rows, robust, wet));
        for row in wet.iter_mut() {
            row.residual += fit.shift(&row.slopes);
        }
        let spent: f64 = wet.iter().map(|row| fit.leverage(&row.slopes)).sum();
        let groups = match inside_groups {
            true => wet.chunk_by(|a, b| a.group == b.group).count(),
            false => 0,
        };
        let spread = Spread {
            sum_of_squares: wet.iter().map(|row| row.residual * row.residual).sum(),
            runs: wet.len(),
            // a parameter that the runs hold only in part counts as one
            parameters: groups + (spent - 1e-6).max(0.0).ceil() as usize,
        };
        (spread.parameters + 1 < spread.runs).then_some(FittedLaw {
            inside_groups,
            fit,
            spread,
        })
    }

    /// Holds the law against one more column of the energy in some groups; `None` where the law has it already.
    fn against<'g>(
        &'g self,
        against: WetAlternative,
        wet: &'g [WetRow],
        column: impl Fn(&WetRow) -> f64,
    ) -> Option<Departure<'g>> {
        /// a column with less than this share of its square beside the law is not told from it: the place of a run goes with
        /// its speed where rows are sorted by that
        const NEW: f64 = 1e-6;
        const NEW_OF_PLACE: f64 = 0.05;
        let groups = wet.chunk_by(|a, b| a.group == b.group);
        let of_energy = |row: &WetRow| row.of_energy * column(row);
        let mut column: Vec<f64> = match self.inside_groups {
            true => groups.flat_map(|group| centred(group, of_energy)).collect(),
            false => wet.iter().map(of_energy).collect(),
        };
        let mut pull = DVector::zeros(self.fit.step.len());
        let mut product = 0.0;
        for (row, x) in wet.iter().zip(&column) {
            row.slopes.iter().for_each(|(j, slope)| pull[*j] += slope * x);
            product += x * row.residual;
        }
        let taken = &self.fit.inverse.matrix * &pull;
        let own = square(&column) - pull.dot(&taken);
        let least = match against {
            WetAlternative::DriftOfViscousLoss | WetAlternative::DriftOfFilmLoss => NEW_OF_PLACE,
            _ => NEW,
        };
        if own.is_nan() || own <= least * square(&column) {
            return None;
        }
        let factor = product / own;
        let wide = Spread {
            sum_of_squares: self.spread.sum_of_squares - factor * factor * own,
            parameters: self.spread.parameters + 1,
            ..self.spread
        };
        column.iter_mut().for_each(|x| *x *= factor);
        Some(Departure {
            law: self,
            against,
            test: nested(self.spread, wide)?,
            tried: 1,
            wet,
            column,
            taken: taken * factor,
            pull: pull * factor,
        })
    }
}
