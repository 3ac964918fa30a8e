//! Holds the scatter of the runs against what every interval assumes: normal, of one spread, independent run by run.
//!
//! | file | job |
//! |---|---|
//! | `rows.rs` | the point about which the joint fit is looked at, what each run leaves there, with its slopes, and sums of these |
//! | `scatter.rs` | the scatter about it, found so that outliers do not mislead |
//! | `outliers.rs` | runs that normal noise would hardly ever take so far |
//! | `standard_errors.rs` | by how much they are too small, by unequal spreads of groups and by offsets that series share |
//! | `growth.rs` | whether the noise grows with the impact speed, 1/St or the restitution |
//! | `wet_law.rs` | whether e bends or slopes with v or 1/St, inside a film, as the law does not |
//!
//! The joint fit is that of the energy balance with the dry law, linearised where least squares ended, with one spread
//! for all dry and one for all wet runs as the likelihood has them. Stuck runs, and rebounds of settings that may stick,
//! are not in it: what is left of a scatter that the limit cuts off has neither its mean nor its spread. Outliers are
//! taken out before spreads and offsets are looked at.

mod growth;
mod outliers;
mod rows;
mod scatter;
mod standard_errors;
mod wet_law;

use schemars::JsonSchema;
use serde::Serialize;

use super::balance::EnergyBalance;
use super::remarks::{self, BIAS};
use super::wet_fit::FitSetup;
use crate::error::and_more;
use crate::inference::spreads::equal_spreads;
use crate::physics::Form;
use crate::remark::Remark;
use crate::rounding::{by_number, probability};
use crate::runs::{is_in_even_share, sphere_words};
use crate::scene::{LikelihoodFamily, NoiseOn, ResamplingScheme, Scene};
use crate::units::millimetres;
pub use growth::{GrowthTest, GrowthWith, NoiseGrowth, LINE_OF_BANDS};
pub use outliers::{Outlier, FALSE_ALARM, MOST_DESCRIBED};
use rows::{group_name, linearisation_point, Rows, RunKind};
use standard_errors::{test_offsets, test_spreads, unequal_spreads, GroupVariances};
pub use standard_errors::{GroupSpread, Offsets, SpreadTest, StandardErrorRatio, LEVEL, LINE};
pub use wet_law::{WetAlternative, WetLawTest};

/// More runs than this say little new of their scatter: of longer tables the dry runs and about so many wet ones are taken.
const MOST_RUNS: usize = 200_000;

/// What the scatter of the runs is like.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Noise {
    /// runs held against the line for outliers
    pub runs: usize,
    /// outliers in all; 0 where the likelihood is Student's t, which has room for them
    pub outliers_found: usize,
    /// the furthest of them
    pub outliers: Vec<Outlier>,
    /// spreads of the groups; `None` with fewer than two groups of five runs
    pub spread: Option<SpreadTest>,
    /// offsets that series share; `None` where there are no more series than the parameters take up
    pub offsets: Option<Offsets>,
    /// whether the noise grows with what changes from run to run; `None` with fewer than twenty runs of either kind
    pub growth: Option<NoiseGrowth>,
    /// the wet law against what it does not have; `None` where no group has runs to tell
    pub wet_law: Option<WetLawTest>,
}

/// Analyses the scatter about the joint fit; `None` without a fit or without any scatter.
pub(super) fn analyse_noise(setup: FitSetup, balance: Option<&EnergyBalance>, form: Form) -> Option<Noise> {
    let FitSetup { scene, runs, .. } = setup;
    let share = MOST_RUNS as f64 / runs.len().max(1) as f64;
    let some = (share < 1.0).then(|| runs.with_runs(|run| runs.film[run] == 0.0 || is_in_even_share(run, share)));
    let runs = some.as_ref().unwrap_or(runs);
    let (joint, point) = linearisation_point(FitSetup { runs, ..setup }, balance, form);
    let rows = Rows::new(scene, joint, point);
    let tested = outliers::count_tested(&rows);
    let far = outliers::candidate_distance(tested);
    let robust = scatter::fit_robustly(&rows, far)?;
    let of_kind = |kind: RunKind| {
        let all = rows.groups.iter().zip(&robust.residuals);
        all.filter(move |(group, _)| group.kind == kind)
            .map(|(_, own)| own.clone())
    };
    let test = equal_spreads(&mut RunKind::ALL.map(|kind| of_kind(kind).collect()), far);
    let unequal = unequal_spreads(test.as_ref(), &robust.residuals);
    let sorted = outliers::find_outliers(&rows, &robust, unequal.as_deref());
    let variances = GroupVariances::new(&rows, &sorted.sums);
    // where other things scatter, too, the sds of runs without them
    let sds = robust.scatter.map(scatter::Scatter::least);
    let growth = growth::test_growth(&rows, &robust, &sorted);
    let wet_law = wet_law::test_wet_law(&rows, &robust, &sorted);
    let normal = scene.model.likelihood == LikelihoodFamily::Normal;
    let sd_wet = sds[RunKind::Wet as usize];
    Some(Noise {
        runs: tested,
        outliers_found: if normal { sorted.outlying.len() } else { 0 },
        outliers: if normal { sorted.outliers } else { vec![] },
        spread: test_spreads(&rows, &sorted.sums, &variances, test, sds),
        offsets: test_offsets(
            &rows,
            &sorted.sums,
            &variances,
            unequal.is_some(),
            sd_wet * variances.kinds[RunKind::Wet as usize].sqrt(),
        ),
        growth,
        wet_law,
    })
}

/// Outliers that a notice describes.
const SHOWN: usize = 3;

/// A notice for outliers, one for unequal spreads, one for growing noise of dry and of wet runs and one for shared offsets,
/// each where it matters.
pub(super) fn noise_notices(scene: &Scene, noise: Option<&Noise>) -> Vec<Remark> {
    let Some(noise) = noise else {
        return vec![];
    };
    let spread = noise.spread.as_ref().and_then(unequal_spread);
    // what is in the model breaks nothing that is quoted
    let offsets = noise.offsets.as_ref().filter(|_| !scene.model.series_offsets);
    let offsets = offsets.and_then(|offsets| series_offsets(scene, offsets));
    let growth = noise.growth.iter().flat_map(|growth| growth.found());
    let growth = growth.map(|found| noise_grows(scene, found));
    let others = [outliers(noise), spread, offsets].into_iter().flatten();
    others.chain(growth).collect()
}

impl GrowthTest {
    /// Its quantity at both ends of the runs, in words.
    pub fn ends(&self) -> [String; 2] {
        self.between.map(|value| match self.with {
            GrowthWith::ImpactSpeed => format!("{value:.2} m/s"),
            GrowthWith::InverseStokes => format!("1/St = {value:.4}"),
            GrowthWith::Restitution => format!("e = {value:.2}"),
        })
    }
}

fn noise_grows(scene: &Scene, found: &GrowthTest) -> Remark {
    let [from, to] = found.ends();
    let text = format!(
        "the noise of {} runs grows with {}: their sd is {:.1} times as large at {to} as at {from} (by chance with probability \
         {}), where every interval takes one; a 90 % band of single runs would hold about {:.0} % of them at {from} and \
         {:.0} % at {to}",
        found.of,
        found.with.words(),
        found.factor,
        probability(found.p),
        100.0 * found.band_holds[0],
        100.0 * found.band_holds[1]
    );
    let kind = match found.of == RunKind::Wet.word() {
        true => remarks::NOISE_GROWS,
        false => remarks::DRY_NOISE_GROWS,
    };
    let mut notice = kind.notice(found.runs, text);
    // noise on the energy kept grows so
    if found.with == GrowthWith::InverseStokes && scene.model.noise != NoiseOn::Both {
        let both = "try [model] noise = \"both\", which scatters so; else ";
        notice.next_step.insert_str(0, both);
    }
    notice.cautioning_if(found.largest_over_one > 1.0 + BIAS)
}

fn outliers(noise: &Noise) -> Option<Remark> {
    let found = noise.outliers_found;
    if found == 0 {
        return None;
    }
    let rows = noise.outliers.iter().take(SHOWN).map(described).collect();
    let text = format!(
        "{found} {} so far from the law that normal noise would take any of {} runs there in one table of a hundred: {}",
        by_number(found, "run lies", "runs lie"),
        noise.runs,
        and_more(rows, found, "; ")
    );
    // those that are not described lie nearer, but nobody knows what they move
    let felt = found > noise.outliers.len() || noise.outliers.iter().any(|one| one.moves_in_se.abs() > BIAS);
    Some(remarks::OUTLIER.notice(found, text).cautioning_if(felt))
}

fn described(one: &Outlier) -> String {
    let diameter = format!("{:.3} mm", millimetres(one.diameter_m));
    let group = group_name(&one.particle, one.liquid.as_deref(), Some(&diameter), one.film_ratio);
    let found = match one.restitution {
        e if e > 0.0 => format!("e = {e:.3}"),
        _ => "it stuck".to_owned(),
    };
    // below the threshold the law has no restitution
    let expected = match one.expected {
        e if e > 0.0 => format!("{e:.3} was expected"),
        _ => "it should have stuck".to_owned(),
    };
    format!(
        "{}: {group}, v = {:.3} m/s, {found} where {expected}, {:.1} σ; leaving it out moves {} by {:.1} \
         of its standard errors",
        one.place,
        one.impact_speed_m_s,
        one.sds.abs(),
        remarks::in_symbols(&one.moves),
        one.moves_in_se
    )
}

impl GroupSpread {
    /// Its name in a sentence.
    pub fn label(&self) -> String {
        let particle = sphere_words(&self.particle, self.diameter_m);
        group_name(&particle, self.liquid.as_deref(), None, self.film_ratio)
    }
}

fn unequal_spread(spread: &SpreadTest) -> Option<Remark> {
    let worst = spread.affected_standard_error()?;
    let of = |group: &GroupSpread| format!("{:.4} ({}, {} runs)", group.sd, group.label(), group.runs);
    let text = format!(
        "the runs do not scatter alike: from {} to {} about the fit, where every interval takes one spread for all dry and \
         one for all wet runs; the standard error of {} is too small by a factor of {:.2}",
        of(&spread.narrowest),
        of(&spread.widest),
        remarks::in_symbols(&worst.parameter),
        worst.ratio
    );
    Some(remarks::UNEQUAL_SPREAD.notice(spread.test.df_between + 1, text))
}

fn series_offsets(scene: &Scene, offsets: &Offsets) -> Option<Remark> {
    let worst = offsets.affected_standard_error()?;
    let text = format!(
        "runs of a series share an offset: over {} series it has an sd of {:.4} in e, {:.2} of the spread of single runs; \
         taking runs as independent makes the standard error of {} too small by a factor of {:.2}. It may be the film or \
         the alignment, set once for a series, or the law itself where it does not fit",
        offsets.series, offsets.sd, offsets.share, remarks::in_symbols(&worst.parameter), worst.ratio
    );
    let mut notice = remarks::SERIES_OFFSETS.notice(offsets.series, text);
    if scene.bootstrap.scheme == ResamplingScheme::Series {
        let changes = format!(". scheme = \"series\" {}", remarks::SERIES_SCHEME_CHANGES);
        notice.next_step.push_str(&changes);
    }
    Some(notice)
}
