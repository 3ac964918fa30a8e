//! Picks the main numbers, each from the one source that serves it on these runs.
//!
//! Parameters come from the posterior. e_inf and St_c of a film ratio come from the square-root law fitted there, where
//! that law describes how its runs came about and has ten degrees of freedom or more, and from the posterior for each
//! liquid. Without a posterior least squares stands in, and they are provisional.

use std::collections::HashMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::balance::{DerivedEstimate, NO_VISCOUS};
use super::dry::fit_of_sphere;
use super::estimate::Quoting;
use super::estimates::{no_draws, of_balance, of_dry_law, of_law, EstimatePlace, EstimateRow, EstimateSources, Source};
use super::fit_verdict::Verdict;
use super::posterior::Posterior;
use super::remarks::{self, BIAS};
use super::scaling::Scaling;
use crate::physics::form::Term;
use crate::physics::{Coefficient, Quantity};
use crate::remark::Remark;
use crate::runs::{FilmGroup, Runs, Series};
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

    /// Puts them in the place of their rows among all estimates; a law of several liquids has none of one.
    pub(super) fn mark(&self, rows: &mut Vec<EstimateRow>) {
        // a table may have as many film ratios as runs
        let mut at: HashMap<_, Vec<usize>> = HashMap::new();
        for (place, row) in rows.iter().enumerate() {
            at.entry(row.of.film_ratio.map(f64::to_bits)).or_default().push(place);
        }
        for own in self.rows() {
            let of = EstimatePlace {
                liquid: own.of.liquid.clone().filter(|_| own.source == Source::Posterior),
                ..own.of.clone()
            };
            let own = EstimateRow { of, ..own.clone() };
            let is_own =
                |row: &EstimateRow| (row.quantity, row.source) == (own.quantity, own.source) && row.of == own.of;
            let here = at.get(&own.of.film_ratio.map(f64::to_bits)).into_iter().flatten();
            match here.copied().find(|place| is_own(&rows[*place])) {
                Some(place) => rows[place] = own,
                None => rows.push(own),
            }
        }
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

/// Picks them, before they are judged.
pub(super) fn pick_main_numbers(from: EstimateSources) -> MainNumbers {
    let picked = match from.posterior {
        Some(posterior) => from.sampled_parameters(posterior),
        None => from.fitted_parameters(),
    };
    MainNumbers {
        provisional: from.posterior.is_none(),
        parameters: picked.into_iter().map(quoted).collect(),
        places: from.places().into_iter().map(|both| both.map(quoted)).collect(),
        ..MainNumbers::default()
    }
}

/// A row as it is quoted first.
fn quoted(mut row: EstimateRow) -> EstimateRow {
    if row.source != Source::Posterior {
        row.number.se = row.number.se_of_interval();
    }
    row.main = true;
    row
}

impl EstimateSources<'_> {
    fn sampled_parameters(self, posterior: &Posterior) -> Vec<EstimateRow> {
        let spheres = posterior.sampled.parameters.sampled.iter().map(|own| own.kind.sphere());
        let sampled = self.sampled(posterior).zip(spheres);
        let sampled = sampled.filter(|(row, _)| row.kind.is_some());
        let parameters = sampled.map(|(row, sphere)| {
            let few = sphere.and_then(|sphere| self.of_few_dry_runs(sphere));
            few.unwrap_or(row)
        });
        let mut parameters: Vec<EstimateRow> = parameters.collect();
        withhold_unreached(&mut parameters, self.runs, Quoting::of(self.scene));
        let l = Quantity::Shared(Coefficient::LubricationLog);
        let prior_led = parameters.iter().any(|own| own.is(l) && own.prior_led);
        let derived = posterior.derived.iter().zip(&posterior.findings.derived);
        let of_ratio = derived.filter(|(draws, _)| draws.quantity == Quantity::DeltaCOverRoughness);
        parameters.extend(of_ratio.map(|(draws, summary)| EstimateRow {
            prior_led,
            ..self.derived(draws, summary)
        }));
        parameters
    }

    /// k of a sphere that few dry runs alone tell: by the dry law, with Student's t. The posterior's interval knows less
    /// than they do, since the prior of their spread reaches far beyond it.
    fn of_few_dry_runs(&self, sphere: usize) -> Option<EstimateRow> {
        let dry = fit_of_sphere(self.least_squares.dry, sphere)?;
        let alone = self.runs.series_of(sphere).is_empty() && dry.runs < FEW_DRY_RUNS;
        (alone && dry.dry_k.interval.is_some()).then(|| of_dry_law(dry))
    }

    fn fitted_parameters(self) -> Vec<EstimateRow> {
        let dry = self.least_squares.dry.iter().map(of_dry_law);
        let has_delta_c = self.scene.model.viscous.why_no_critical_separation().is_none();
        let is_told = |row: &EstimateRow| match row.kind {
            Some(Quantity::Shared(_)) => true,
            kind => has_delta_c && kind == Some(Quantity::DeltaCOverRoughness),
        };
        let balance = self.least_squares.energy_balance.into_iter();
        let fitted = balance.flat_map(|balance| self.fitted(balance)).filter(is_told);
        dry.chain(fitted).collect()
    }

    /// The places in the order of the film groups: at each the law, where it serves, then the posterior for each liquid.
    fn places(&self) -> Vec<[EstimateRow; 2]> {
        let mut all = vec![];
        // both stand in the order of the film groups, and a table may have as many of these as runs
        let laws = self.least_squares.scaling.iter();
        let mut laws = laws
            .filter(|law| law.law == WetLaw::Sqrt && law.film_ratio.is_some())
            .peekable();
        let balance = self.least_squares.energy_balance.filter(|own| own.verdict.passed);
        let mut derived = balance.into_iter().flat_map(|own| &own.derived).peekable();
        for group in &self.runs.film_groups {
            let law = laws.next_if(|law| (law.sphere, law.film_ratio) == (group.sphere, Some(group.film_ratio)));
            let is_here = |own: &&DerivedEstimate| (own.sphere, own.film_ratio) == (group.sphere, group.film_ratio);
            let by_balance = std::iter::from_fn(|| derived.next_if(is_here)).map(of_balance);
            let by_balance: Vec<[EstimateRow; 2]> = by_balance.collect();
            let before = all.len();
            all.extend(
                law.filter(|law| self.law_serves(law))
                    .map(|law| self.of_law(group, law)),
            );
            if let Some(posterior) = self.posterior {
                all.extend(self.of_posterior(group, posterior));
            }
            if all.len() == before {
                all.extend(by_balance);
            }
            if all.len() == before {
                all.extend(law.map(|law| self.of_law(group, law)));
            }
        }
        all
    }

    /// Whether the square-root law at a film ratio describes how its runs came about: every one of them rebounded, with
    /// noise on the restitution alone, independent from run to run, e² is a line in 1/St, and one law for all liquids biases
    /// it by no more than it may; and whether its runs tell their spread, unless there is no posterior that would.
    fn law_serves(&self, law: &Scaling) -> bool {
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

    fn of_law(&self, group: &FilmGroup, law: &Scaling) -> [EstimateRow; 2] {
        let series = &self.runs.series[group.series.clone()];
        let is_alone = |one: &&Series| series.iter().all(|other| other.liquid == one.liquid);
        let of_one = series.first().filter(is_alone);
        let liquid = of_one.map(|one| self.scene.liquids[one.liquid].name.clone());
        let mut both = of_law(law);
        both.iter_mut().for_each(|own| own.of.liquid.clone_from(&liquid));
        both
    }

    /// e_inf and St_c by the posterior, for each liquid of a film group and each diameter where they belong to one.
    fn of_posterior(&self, group: &FilmGroup, posterior: &Posterior) -> Vec<[EstimateRow; 2]> {
        let all = || posterior.derived.iter().zip(&posterior.findings.derived);
        let of = |quantity: Quantity| all().filter(move |(draws, _)| draws.quantity == quantity);
        let here = of(Quantity::EInf).filter_map(|(draws, summary)| {
            let setting = draws.setting.as_ref()?;
            let diameter = self.runs.spheres[group.sphere].diameter;
            let is_here = setting.particle == group.particle
                && setting.film_ratio == group.film_ratio
                && (diameter.is_none() || setting.diameter == diameter);
            is_here.then(|| {
                let e_inf = self.derived(draws, summary);
                let st_c = of(Quantity::StC).find(|(other, _)| other.setting.as_ref() == Some(setting));
                let st_c = match st_c {
                    Some((draws, summary)) => self.derived(draws, summary),
                    None => {
                        let none = no_draws(Quoting::of(self.scene), NO_VISCOUS);
                        EstimateRow::new(Quantity::StC, e_inf.of.clone(), none, Source::Posterior)
                    }
                };
                [e_inf, st_c]
            })
        });
        here.collect()
    }
}

/// Takes back C and δ̃0 where the inertial loss sets in over films that are all thinner than those of the runs: where it
/// has levelled off only its size is told, by which any other loss that goes with no film is taken for it.
fn withhold_unreached(parameters: &mut [EstimateRow], runs: &Runs, quoting: Quoting) {
    const WHY: &str = "every film is thicker than δ̃0: no run tells how the loss sets in";
    let scale = Quantity::Shared(Coefficient::FilmScale);
    let ratios = runs.impacts.film_ratio.iter().copied();
    let thinnest = ratios.filter(|ratio| *ratio > 0.0).fold(f64::INFINITY, f64::min);
    let highest = |own: &EstimateRow| Some(own.number.value? + own.number.se?);
    let mut scales = parameters.iter().filter(|own| own.is(scale));
    if !scales.any(|own| highest(own).is_some_and(|highest| highest < thinnest)) {
        return;
    }
    for own in parameters {
        if own.is(scale) || own.is(Quantity::Shared(Coefficient::InertialPrefactor)) {
            own.number = no_draws(quoting, WHY);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::estimate::Estimate;
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
                EstimateRow::new(Quantity::Shared(of), place, number, Source::Posterior)
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
