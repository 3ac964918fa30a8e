//! Says which assumptions of the intervals the scatter of the runs breaks.

use super::rows::{group_name, RunKind};
use super::{GroupSpread, GrowthTest, GrowthWith, Noise, Offsets, Outlier, SpreadTest};
use crate::error::and_more;
use crate::findings::remarks::{self, BIAS};
use crate::remark::Remark;
use crate::rounding::{by_number, probability};
use crate::runs::sphere_words;
use crate::scene::{NoiseOn, ResamplingScheme, Scene};
use crate::units::millimetres;

/// Outliers that a notice describes.
const SHOWN: usize = 3;

/// A notice for outliers, one for unequal spreads, one for growing noise of dry and of wet runs and one for shared offsets,
/// each where it matters.
pub(in crate::findings) fn noise_notices(scene: &Scene, noise: Option<&Noise>) -> Vec<Remark> {
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
