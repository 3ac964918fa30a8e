//! Picks the main numbers, each from the one source that serves it on these runs.
//!
//! Parameters come from the posterior. e_inf and St_c of a film ratio come from the square-root law fitted there, where
//! that law describes how its runs came about and has ten degrees of freedom or more, and from the posterior for each
//! liquid. Without a posterior least squares stands in, and they are provisional.

use std::collections::{HashMap, HashSet};

use schemars::JsonSchema;
use serde::Serialize;

use super::dry::fit_of_sphere;
use super::estimate::Quoting;
use super::estimates::{no_draws, EstimateRow, EstimateSources, Source};
use super::fit_verdict::Verdict;
use super::remarks::{self, BIAS};
use super::scaling::Scaling;
use crate::physics::form::Term;
use crate::physics::{Coefficient, Quantity};
use crate::remark::Remark;
use crate::runs::Runs;
use crate::scene::{NoiseOn, WetLaw};

/// Dry runs from which on the posterior's 95 % interval of their k covers as stated where no wet run tells of it: of 3 to 6
/// it covered 97.5 to 99.8 %, of 8 it covered 96.5 % (1000 simulated sets each).
const FEW_DRY_RUNS: usize = 8;

/// Whether the numbers that are quoted first, the rows marked `main` of the estimates, may be quoted, and what was learnt.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct MainNumbers {
    /// whether they may be quoted
    pub verdict: Verdict,
    /// whether least squares stands in for a posterior that was not sampled
    pub provisional: bool,
    /// what was learnt, a sentence each
    pub learnt: Vec<String>,
    /// k, L, the inertial prefactor, the film scale, δc/ε
    #[serde(skip)]
    pub parameters: Vec<EstimateRow>,
    /// e_inf and St_c of each particle and film ratio; a law of one liquid has its name
    #[serde(skip)]
    pub places: Vec<[EstimateRow; 2]>,
}

/// Whether, and why not, the numbers may be quoted.
pub(super) fn judge(checks: &[Remark]) -> Verdict {
    let failed = checks.iter().filter(|check| check.forbids());
    let failed: Vec<&str> = failed.map(|check| check.text.as_str()).collect();
    match failed.as_slice() {
        [] => Verdict::passed("no gating check failed"),
        some => Verdict::failed(some.join("; ")),
    }
}

impl MainNumbers {
    /// Every number.
    pub fn rows(&self) -> impl Iterator<Item = &EstimateRow> {
        self.parameters.iter().chain(self.places.iter().flatten())
    }

    /// Whether replicates of the main numbers gave numbers; `None` where none has replicates. What the replicates of other
    /// estimates did stands in their own tables.
    pub(super) fn check_replicates(&self) -> Option<Remark> {
        let with_replicates = || {
            self.rows()
                .filter_map(|own| Some((own.number.failed_replicates()?, own.name())))
        };
        let (worst, name) = with_replicates().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let criterion = remarks::BOOTSTRAP_FAILURES;
        let (text, concerned) = if criterion.holds(worst) {
            let text = format!("largest share of replicates without a number ({name})");
            (text, with_replicates().map(|(_, name)| name).collect::<Vec<_>>())
        } else {
            let text = format!(
                "{:.1} % of the replicates gave no number ({name}), so that its bootstrap interval is one of the others alone",
                100.0 * worst
            );
            let failed = with_replicates().filter(|(share, _)| !criterion.holds(*share));
            (text, failed.map(|(_, name)| name).collect())
        };
        Some(criterion.check(worst, text).concerning(concerned))
    }
}

/// Marks them among all estimates, each as it is quoted, and gives them in the order in which they are told, before they are
/// judged.
pub(super) fn pick_main_numbers(from: EstimateSources, rows: &mut [EstimateRow]) -> MainNumbers {
    if from.posterior.is_some() {
        withhold_unreached(rows, from.runs, Quoting::of(from.scene));
    }
    // a table may have as many film ratios as runs
    let key = |sphere: usize, film_ratio: f64| (sphere, film_ratio.to_bits());
    let laws = from.least_squares.scaling.iter().filter(|law| law.law == WetLaw::Sqrt);
    let laws: HashMap<_, &Scaling> = laws
        .filter_map(|law| Some((key(law.sphere, law.film_ratio?), law)))
        .collect();
    let balance = from
        .least_squares
        .energy_balance
        .as_ref()
        .filter(|own| own.verdict.passed);
    let by_balance = balance.into_iter().flat_map(|balance| &balance.derived);
    let by_balance: HashSet<_> = by_balance.map(|own| key(own.sphere, own.film_ratio)).collect();
    let mut picked: Vec<(usize, EstimateRow)> = vec![];
    for row in rows {
        let place = row
            .sphere
            .zip(row.of.film_ratio)
            .map(|(sphere, ratio)| key(sphere, ratio));
        let law = place.and_then(|place| laws.get(&place));
        let has_balance = place.is_some_and(|place| by_balance.contains(&place));
        row.main = match law {
            Some(law) => from.is_main_at(row, law, has_balance),
            None => from.is_main_parameter(row),
        };
        if !row.main {
            continue;
        }
        if row.source == Source::SquareRootLaw {
            row.of.liquid = law.and_then(|law| from.only_liquid(law));
        }
        if row.source != Source::Posterior {
            row.number.se = row.number.se_of_interval();
        }
        // k before what spheres share
        let of_parameter = || row.sphere.unwrap_or(from.runs.spheres.len());
        picked.push((law.map_or_else(of_parameter, |law| law.series.start), row.clone()));
    }
    // the law of a film ratio before the posterior of its liquids
    picked.sort_by_key(|(order, row)| (*order, row.source == Source::Posterior));
    let picked = picked.into_iter().map(|(_, row)| row);
    let (parameters, places): (Vec<_>, Vec<_>) = picked.partition(|row| row.of.film_ratio.is_none());
    let (e_inf, st_c): (Vec<_>, Vec<_>) = places.into_iter().partition(|row| row.is(Quantity::EInf));
    MainNumbers {
        provisional: from.posterior.is_none(),
        parameters,
        places: e_inf.into_iter().zip(st_c).map(<[EstimateRow; 2]>::from).collect(),
        ..MainNumbers::default()
    }
}

impl EstimateSources<'_> {
    /// Whether a number of a film ratio is e_inf or St_c by the source that serves there: its square-root law, or, of each
    /// liquid, the posterior beside it; without a posterior the balance of all.
    fn is_main_at(self, row: &EstimateRow, law: &Scaling, has_balance: bool) -> bool {
        let (alone, has_law) = (self.posterior.is_none(), self.law_serves(law));
        let serves = match row.source {
            Source::Posterior => true,
            // of all liquids, not of a series
            Source::SquareRootLaw => row.of.liquid.is_none() && (has_law || alone && !has_balance),
            Source::EnergyBalance => alone && has_balance && !has_law,
            Source::LinearLaw | Source::DryLaw => false,
        };
        serves && (row.is(Quantity::EInf) || row.is(Quantity::StC))
    }

    /// The liquid of a law; `None` where it takes several as one.
    fn only_liquid(self, law: &Scaling) -> Option<String> {
        let (first, others) = self.runs.series[law.series.clone()].split_first()?;
        let is_alone = others.iter().all(|other| other.liquid == first.liquid);
        is_alone.then(|| self.scene.liquids[first.liquid].name.clone())
    }

    /// Whether it is a parameter, or δc/ε, by the source that serves.
    fn is_main_parameter(self, row: &EstimateRow) -> bool {
        let alone = self.posterior.is_none();
        match (row.source, row.kind) {
            (Source::Posterior, Some(quantity)) => quantity != Quantity::DeltaC && !self.is_of_few_dry_runs(row),
            (Source::DryLaw, _) => {
                let own = row.sphere.map(|sphere| self.runs.spheres[sphere].diameter);
                own == Some(row.of.diameter_m) && (alone || self.is_of_few_dry_runs(row))
            }
            (Source::EnergyBalance, Some(Quantity::Shared(_))) => alone,
            (Source::EnergyBalance, Some(Quantity::DeltaCOverRoughness)) => {
                alone && self.scene.model.viscous.why_no_critical_separation().is_none()
            }
            _ => false,
        }
    }

    /// Whether it is the k of a sphere that few dry runs alone tell: by the dry law, with Student's t. The posterior's
    /// interval knows less than they do, since the prior of their spread reaches far beyond it.
    fn is_of_few_dry_runs(self, row: &EstimateRow) -> bool {
        let sampled = self
            .posterior
            .into_iter()
            .flat_map(|own| &own.sampled.parameters.sampled);
        let mut spheres = sampled.filter_map(|own| own.kind.sphere());
        let sphere = row.sphere.filter(|own| spheres.any(|sphere| sphere == *own));
        let dry = sphere.and_then(|sphere| fit_of_sphere(&self.least_squares.dry, sphere));
        dry.is_some_and(|dry| {
            let alone = self.runs.series_of(dry.sphere).is_empty() && dry.runs < FEW_DRY_RUNS;
            alone && dry.dry_k.interval.is_some()
        })
    }

    /// Whether the square-root law at a film ratio describes how its runs came about: every one of them rebounded, with
    /// noise on the restitution alone, independent from run to run, e² is a line in 1/St, and one law for all liquids biases
    /// it by no more than it may; and whether its runs tell their spread, unless there is no posterior that would.
    fn law_serves(self, law: &Scaling) -> bool {
        let form = self.posterior.map_or(self.least_squares.form, |own| own.setup.form);
        law.verdict.passed
            && (law.tells_its_spread() || self.posterior.is_none())
            && law.stuck == 0
            && law.measurement_errors.is_none()
            && self.scene.model.noise != NoiseOn::Both
            && !self.scene.model.series_offsets
            && !form.viscous.tells_diameters_apart()
            && !Term::Bridge.is_held(form)
            && law.bias_in_se().is_none_or(|bias| bias <= BIAS)
    }
}

/// Takes back C and δ̃0 where the inertial loss sets in over films that are all thinner than those of the runs: where it
/// has levelled off only its size is told, by which any other loss that goes with no film is taken for it.
fn withhold_unreached(rows: &mut [EstimateRow], runs: &Runs, quoting: Quoting) {
    const WHY: &str = "every film is thicker than δ̃0: no run tells how the loss sets in";
    let scale = Quantity::Shared(Coefficient::FilmScale);
    let ratios = runs.impacts.film_ratio.iter().copied();
    let thinnest = ratios.filter(|ratio| *ratio > 0.0).fold(f64::INFINITY, f64::min);
    let highest = |own: &EstimateRow| Some(own.number.value? + own.number.se?);
    let is_of = |own: &EstimateRow, quantity| own.source == Source::Posterior && own.is(quantity);
    let mut scales = rows.iter().filter(|own| is_of(own, scale));
    if !scales.any(|own| highest(own).is_some_and(|highest| highest < thinnest)) {
        return;
    }
    for own in rows {
        if is_of(own, scale) || is_of(own, Quantity::Shared(Coefficient::InertialPrefactor)) {
            own.number = no_draws(quoting, WHY);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::estimate::Estimate;
    use crate::findings::places::EstimatePlace;
    use crate::runs::Impacts;

    #[test]
    fn a_film_scale_below_every_film_takes_back_itself_and_c() {
        let quoting = Quoting { level: 0.95 };
        let told = |scale: [f64; 2]| {
            let row = |(of, [value, se]): (Coefficient, [f64; 2])| {
                let number = Estimate {
                    se: Some(se),
                    ..quoting.without_se(Some(value), "")
                };
                let place = EstimatePlace::default();
                EstimateRow::new(Quantity::Shared(of), place, None, number, Source::Posterior)
            };
            let mut all = [
                (Coefficient::LubricationLog, [1.85, 0.1]),
                (Coefficient::InertialPrefactor, [0.4, 0.02]),
                (Coefficient::FilmScale, scale),
            ]
            .map(row);
            let runs = Runs {
                impacts: Impacts {
                    film_ratio: vec![0.0, 0.03, 0.09],
                    ..Impacts::default()
                },
                ..Runs::default()
            };
            withhold_unreached(&mut all, &runs, quoting);
            all.map(|own| own.number.value.is_some())
        };
        assert_eq!(told([0.025, 0.002]), [true, false, false]);
        assert_eq!(told([0.029, 0.002]), [true; 3]);
        assert_eq!(told([0.069, 0.002]), [true; 3]);
    }
}
