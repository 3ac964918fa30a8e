//! Says which assumptions of the intervals the scatter of the runs breaks.

use super::rows::{group_name, RunKind};
use super::{
    GroupSpread, GrowthTest, GrowthWith, Noise, Offsets, Outlier, SpreadTest, StandardErrorRatio, LEVEL, LINE,
};
use crate::findings::checks::BIAS;
use crate::findings::notices::{self, GrowingNoise, SharedOffsets, UnderstatedError};
use crate::notice::Notice;
use crate::runs::sphere_words;
use crate::scene::{NoiseOn, Scene};
use crate::units::millimetres;

/// Outliers that a notice describes.
const SHOWN: usize = 3;

/// A notice for outliers, one for unequal spreads, one for growing noise of dry and of wet runs and one for shared offsets,
/// each where it matters.
pub(in crate::findings) fn noise_notices(scene: &Scene, noise: Option<&Noise>) -> Vec<Notice> {
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

fn noise_grows(scene: &Scene, found: &GrowthTest) -> Notice {
    let [from, to] = found.ends();
    let growing = GrowingNoise {
        of_wet: found.of == RunKind::Wet.word(),
        with: found.with.words(),
        ends: [&from, &to],
        factor: found.factor,
        largest_over_one: found.largest_over_one,
        p: found.p,
        band_holds: found.band_holds,
        energy_may_scatter: found.with == GrowthWith::InverseStokes && scene.model.noise == NoiseOn::Restitution,
    };
    notices::noise_grows(found.runs, &growing)
}

impl SpreadTest {
    /// The standard error that lacks most, where spreads differ and a 95 % interval therefore covers less than 94 %.
    pub fn affected_standard_error(&self) -> Option<&StandardErrorRatio> {
        self.worst().filter(|worst| self.test.p < LEVEL && worst.ratio > LINE)
    }
}

impl Offsets {
    /// The standard error that lacks most, where there are offsets and a 95 % interval therefore covers less than 94 %.
    pub fn affected_standard_error(&self) -> Option<&StandardErrorRatio> {
        self.worst().filter(|worst| self.test.p < LEVEL && worst.ratio > LINE)
    }
}

fn outliers(noise: &Noise) -> Option<Notice> {
    let found = noise.outliers_found;
    if found == 0 {
        return None;
    }
    let first: Vec<String> = noise.outliers.iter().take(SHOWN).map(described).collect();
    // those that are not described lie nearer, but nobody knows what they move
    let felt = found > noise.outliers.len() || noise.outliers.iter().any(|one| one.moves_in_se.abs() > BIAS);
    Some(notices::outlier(found, noise.runs, &first, felt))
}

fn described(one: &Outlier) -> String {
    let diameter = format!("{:.3} mm", millimetres(one.diameter_m));
    let group = group_name(&one.particle, one.liquid.as_deref(), Some(&diameter), one.film_ratio);
    let found = if one.restitution > 0.0 {
        format!("e = {:.3}", one.restitution)
    } else {
        "it stuck".to_owned()
    };
    // below the threshold the law has no restitution
    let expected = if one.expected > 0.0 {
        format!("{:.3} was expected", one.expected)
    } else {
        "it should have stuck".to_owned()
    };
    format!(
        "{}: {group}, v = {:.3} m/s, {found} where {expected}, {:.1} σ; leaving it out moves {} by {:.1} \
         of its standard errors",
        one.place,
        one.impact_speed_m_s,
        one.sds.abs(),
        one.moves,
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

fn unequal_spread(spread: &SpreadTest) -> Option<Notice> {
    let worst = spread.affected_standard_error()?;
    let of = |group: &GroupSpread| format!("{:.4} ({}, {} runs)", group.sd, group.label(), group.runs);
    let groups = spread.test.df_between + 1;
    let (narrowest, widest) = (of(&spread.narrowest), of(&spread.widest));
    Some(notices::unequal_spread(
        groups,
        &narrowest,
        &widest,
        worst.understated(),
    ))
}

impl StandardErrorRatio {
    fn understated(&self) -> UnderstatedError<'_> {
        UnderstatedError {
            parameter: &self.parameter,
            ratio: self.ratio,
        }
    }
}

fn series_offsets(scene: &Scene, offsets: &Offsets) -> Option<Notice> {
    let worst = offsets.affected_standard_error()?;
    let found = SharedOffsets {
        series: offsets.series,
        sd: offsets.sd,
        share: offsets.share,
        worst: worst.understated(),
    };
    Some(notices::series_offsets(&found, scene.bootstrap.scheme))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_where_the_law_has_no_rebound_should_have_stuck() {
        let told = |restitution: f64, expected: f64| {
            described(&Outlier {
                row: 3,
                place: "runs.csv, line 4".to_owned(),
                particle: "PTFE".to_owned(),
                liquid: Some("AK10".to_owned()),
                diameter_m: 4e-3,
                film_ratio: Some(0.06),
                impact_speed_m_s: 0.5,
                restitution,
                expected,
                sds: 9.0,
                moves: "lubrication_log".to_owned(),
                moves_in_se: 2.0,
            })
        };
        assert!(told(0.184, -0.411).contains("e = 0.184 where it should have stuck, 9.0 σ"));
        assert!(told(0.184, 0.6).contains("e = 0.184 where 0.600 was expected"));
        assert!(told(0.0, 0.6).contains("it stuck where 0.600 was expected"));
    }
}
