//! Picks the main numbers, each from the one source that serves it on these runs.
//!
//! Parameters come from the posterior. e_inf and St_c of a film ratio come from the square-root law fitted there, where
//! that law describes how its runs came about and has ten degrees of freedom or more, and from the posterior for each
//! liquid. Without a posterior least squares stands in, and they are provisional.

use std::collections::HashMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::balance::{DerivedEstimate, NO_VISCOUS};
use super::constants::Sensitivity;
use super::dry::Dry;
use super::estimate::{Estimate, Quoting};
use super::fit_verdict::Verdict;
use super::least_squares::LeastSquares;
use super::posterior::{Posterior, PriorSummary, QuantitySummary};
use super::remarks::{self, BIAS};
use super::scaling::{Scaling, FEWEST_DEGREES};
use crate::distributions::{normal_quantile, student_t_quantile};
use crate::inference::diagnostics::quantile::central_interval;
use crate::model::parameters::ParameterKind;
use crate::physics::form::Term;
use crate::physics::{Coefficient, Quantity};
use crate::remark::Remark;
use crate::rounding::{positive, short, significant, with_sd, with_se, NONE};
use crate::runs::{FilmGroup, Runs, Series};
use crate::scene::{NoiseOn, Scene, WetLaw};

/// Dry runs from which on the posterior's 95 % interval of their k covers as stated where no wet run tells of it: of 3 to 6
/// it covered 97.5 to 99.8 %, of 8 it covered 96.5 % (1000 simulated sets each).
const FEW_DRY_RUNS: usize = 8;

/// How the interval of a posterior's number is made.
const POSTERIOR_QUANTILES: &str = "posterior_quantiles";

/// Where a main number comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// the posterior of all runs at once
    Posterior,
    /// the square-root law at one film ratio
    SquareRootLaw,
    /// the linear law at one film ratio
    LinearLaw,
    /// least squares over all rebounds at once
    EnergyBalance,
    /// the law of the dry runs
    DryLaw,
}

impl Source {
    /// Its name in a text.
    pub fn name(self) -> &'static str {
        match self {
            Source::Posterior => "posterior",
            Source::SquareRootLaw => "square-root law",
            Source::LinearLaw => "linear law",
            Source::EnergyBalance => "energy balance",
            Source::DryLaw => "dry law",
        }
    }
}

/// The numbers that are quoted first.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MainNumbers {
    /// whether they may be quoted
    pub verdict: Verdict,
    /// whether least squares stands in for a posterior that was not sampled
    pub provisional: bool,
    /// what was learnt, a sentence each
    pub learnt: Vec<String>,
    /// k, L, the inertial prefactor, the film scale, δc/ε
    pub parameters: Vec<MainParameter>,
    /// e_inf and St_c of each particle and film ratio
    pub at: Vec<MainPlace>,
}

/// A number with its uncertainty and its source.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MainNumber {
    /// its value: the mean of a posterior, the estimate of a fit
    pub value: Option<f64>,
    /// its uncertainty: the sd of a posterior, the standard error of a fit; of a fit with fewer than ten degrees of freedom
    /// the half-width of Student's interval over the normal quantile, of a bootstrap's interval its own, so that ± and interval
    /// agree
    pub se: Option<f64>,
    /// its central interval
    pub interval: Option<[f64; 2]>,
    /// the probability the interval was made for
    pub level: f64,
    /// how the interval was made
    pub method: &'static str,
    /// where it comes from
    pub source: Source,
    /// Monte Carlo error of the value; of a posterior only
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcse: Option<f64>,
    /// why there is no uncertainty; stands exactly then
    #[serde(rename = "reason")]
    pub why_none: Option<String>,
    /// share of its replicates that gave no number; `None` where it has no replicates
    #[serde(skip)]
    pub failed_replicates: Option<f64>,
}

/// A parameter among the main numbers.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MainParameter {
    /// its name in files
    pub name: String,
    /// what it is
    #[serde(skip)]
    pub quantity: Quantity,
    /// index into [`Runs::spheres`] of the one it is of; `None` where all share it
    #[serde(skip)]
    pub sphere: Option<usize>,
    /// the number
    #[serde(flatten)]
    pub number: MainNumber,
    /// whether the prior leads: the runs leave more than half of its sd
    pub prior_led: bool,
    /// where a k comes from that no dry run tells: `wet runs`
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<&'static str>,
}

impl MainParameter {
    fn of_fit(name: String, quantity: Quantity, estimate: &Estimate, source: Source) -> MainParameter {
        MainParameter {
            name,
            quantity,
            sphere: None,
            number: MainNumber::of_fit(estimate, source),
            prior_led: false,
            from: None,
        }
    }

    fn of_dry(dry: &Dry) -> MainParameter {
        MainParameter {
            sphere: Some(dry.sphere),
            ..MainParameter::of_fit(dry.name(), Quantity::DryK, &dry.dry_k, Source::DryLaw)
        }
    }
}

/// e_inf and St_c of a particle at a film ratio.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MainPlace {
    /// name of the particle
    pub particle: String,
    /// film ratio
    pub film_ratio: f64,
    /// name of the liquid; `None`: several liquids, taken as one
    pub liquid: Option<String>,
    /// D, m, where it stands for one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// wet restitution as St → ∞, at the reference dry speed
    pub e_inf: MainNumber,
    /// critical Stokes number
    pub st_c: MainNumber,
    /// where both come from
    pub source: Source,
}

impl MainNumber {
    /// The number with its uncertainty, or the value alone where there is none. `scale` must be a plain factor.
    pub fn rounded(&self, scale: impl Fn(f64) -> f64) -> String {
        let scaled = |x: Option<f64>| x.map(&scale);
        match (
            scaled(self.value),
            positive(scaled(self.se)),
            positive(scaled(self.mcse)),
        ) {
            (Some(mean), Some(sd), Some(mcse)) => with_sd(mean, sd, mcse),
            (Some(value), Some(se), None) => with_se(value, se),
            (Some(value), None, _) => format!("{} (no ±)", significant(value, 4)),
            (None, ..) => NONE.to_owned(),
        }
    }

    pub(super) fn of_fit(estimate: &Estimate, source: Source) -> MainNumber {
        let boot = estimate.bootstrap.as_ref().filter(|boot| boot.replicates > 0);
        MainNumber {
            value: estimate.value,
            se: se_of_interval(estimate),
            interval: estimate.interval,
            level: estimate.level,
            method: estimate.method,
            source,
            mcse: None,
            why_none: estimate.why_none.clone(),
            failed_replicates: boot.map(|boot| boot.failed as f64 / boot.replicates as f64),
        }
    }

    /// From a summary and its draws, chain by chain.
    pub(super) fn of_draws(summary: &QuantitySummary, draws: &[Vec<f64>], level: f64) -> MainNumber {
        // what follows from a parameter that the scene holds has no spread
        let mut all = draws.iter().flatten();
        let first = all.next();
        let is_held = all.all(|draw| Some(draw) == first);
        MainNumber {
            value: summary.mean,
            se: summary.sd.filter(|_| !is_held),
            interval: central_interval(draws, level).filter(|_| !is_held),
            level,
            method: POSTERIOR_QUANTILES,
            source: Source::Posterior,
            mcse: summary.mcse_mean,
            why_none: if is_held {
                Some("the scene holds what it follows from".to_owned())
            } else {
                summary.why_none.clone().filter(|_| summary.sd.is_none())
            },
            failed_replicates: None,
        }
    }

    /// None of a posterior, for a reason.
    fn withheld(why: &str, level: f64) -> MainNumber {
        MainNumber {
            method: POSTERIOR_QUANTILES,
            ..MainNumber::of_fit(&Quoting { level }.none(why), Source::Posterior)
        }
    }
}

/// The standard error of an estimate, made to agree with its interval where that is a bootstrap's, or Student's on few degrees of
/// freedom.
fn se_of_interval(estimate: &Estimate) -> Option<f64> {
    let (value, se) = estimate.pair()?;
    let probability = 0.5 + 0.5 * estimate.level;
    let normal = normal_quantile(probability);
    let half = match (estimate.interval, estimate.method) {
        (Some([lo, hi]), "delta") => 0.5 * (hi - lo),
        (Some([lo, hi]), "delta_log") => 0.5 * value * (hi / lo).ln(),
        (Some([lo, hi]), _) => return Some(0.5 * (hi - lo) / normal),
        (None, _) => return Some(se),
    };
    let few = student_t_quantile(probability, FEWEST_DEGREES as f64)?;
    // at the very number of degrees that is enough, rounding decides nothing
    const ROUNDING: f64 = 1e-6;
    Some(if half > few * se * (1.0 + ROUNDING) {
        half / normal
    } else {
        se
    })
}

/// Whether, and why not, the numbers may be quoted.
pub(super) fn judge(checks: &[Remark]) -> Verdict {
    let failed = checks.iter().filter(|check| check.forbids());
    let failed: Vec<&str> = failed.map(|check| check.text.as_str()).collect();
    if failed.is_empty() {
        Verdict::passed("no gating check failed")
    } else {
        Verdict::failed(failed.join("; "))
    }
}

impl MainPlace {
    /// Whether its numbers are those of this law.
    pub(super) fn is_of(&self, law: &Scaling) -> bool {
        self.source == Source::SquareRootLaw
            && law.law == WetLaw::Sqrt
            && law.film_ratio == Some(self.film_ratio)
            && (&law.particle, law.diameter_m) == (&self.particle, self.diameter_m)
    }

    /// The number of a quantity here that a sensitivity is of, by the fit that it comes from or is checked by.
    pub fn of_result(&self, result: &Sensitivity) -> Option<(Quantity, &MainNumber)> {
        let both = [(Quantity::EInf, &self.e_inf), (Quantity::StC, &self.st_c)];
        let is_here = result.particle.as_ref() == Some(&self.particle)
            && result.film_ratio == Some(self.film_ratio)
            && result.diameter_m == self.diameter_m
            && result.is_of_balance() == (self.source != Source::SquareRootLaw);
        both.into_iter()
            .find(|(quantity, _)| is_here && result.result == quantity.describe().name)
    }

    /// Name of one of its numbers, as those of the posterior are named: `e_inf[PTFE,AK10,0.06]`; several liquids that are
    /// taken as one are left out of it.
    fn name_of(&self, quantity: Quantity) -> String {
        let parts = [
            Some(self.particle.clone()),
            self.liquid.clone(),
            Some(short(self.film_ratio)),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        format!("{}[{}]", quantity.describe().name, parts.join(","))
    }
}

impl MainNumbers {
    /// The main numbers that a sensitivity is of: one of a parameter, of a film ratio one for each liquid.
    pub fn of_result<'a>(&'a self, result: &'a Sensitivity) -> impl Iterator<Item = &'a MainNumber> {
        let parameters = self.parameters.iter();
        let parameters = parameters.filter(|own| result.is_of_balance() && result.result == own.name);
        let places = self.at.iter().filter_map(|place| Some(place.of_result(result)?.1));
        parameters.map(|own| &own.number).chain(places)
    }

    /// Before any is picked.
    pub(super) fn none() -> MainNumbers {
        MainNumbers {
            verdict: judge(&[]),
            provisional: true,
            learnt: vec![],
            parameters: vec![],
            at: vec![],
        }
    }

    /// Every number with its name.
    fn named(&self) -> impl Iterator<Item = (String, &MainNumber)> {
        let parameters = self.parameters.iter().map(|own| (own.name.clone(), &own.number));
        let places = self.at.iter().flat_map(|place| {
            [
                (place.name_of(Quantity::EInf), &place.e_inf),
                (place.name_of(Quantity::StC), &place.st_c),
            ]
        });
        parameters.chain(places)
    }

    /// Whether replicates of the main numbers gave numbers; `None` where none has replicates. What the replicates of other
    /// estimates did stands in their own tables.
    pub(super) fn check_replicates(&self) -> Option<Remark> {
        let with_replicates = || {
            self.named()
                .filter_map(|(name, own)| Some((own.failed_replicates?, name)))
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

/// What main numbers are picked from.
pub(super) struct MainSources<'a> {
    pub scene: &'a Scene,
    pub runs: &'a Runs,
    pub least_squares: LeastSquares<'a>,
    /// `None` if nothing was sampled
    pub posterior: Option<&'a Posterior>,
}

/// Picks them.
pub(super) fn pick_main_numbers(from: MainSources) -> MainNumbers {
    MainNumbers {
        provisional: from.posterior.is_none(),
        parameters: match from.posterior {
            Some(posterior) => from.sampled_parameters(posterior),
            None => from.fitted_parameters(),
        },
        at: from.places(),
        ..MainNumbers::none()
    }
}

impl MainSources<'_> {
    fn level(&self) -> f64 {
        self.scene.bootstrap.level
    }

    fn sampled_parameters(&self, posterior: &Posterior) -> Vec<MainParameter> {
        let found = &posterior.findings;
        let sampled = &posterior.sampled;
        let with_draws = sampled.parameters.sampled.iter().zip(&sampled.values);
        let parameters = with_draws.zip(&found.parameters).filter_map(|((own, draws), summary)| {
            let quantity = own.kind.quantity()?;
            let sphere = own.kind.sphere();
            let few = sphere.and_then(|sphere| self.of_few_dry_runs(sphere));
            few.or_else(|| {
                Some(MainParameter {
                    name: own.name.clone(),
                    quantity,
                    sphere,
                    from: summary.from,
                    number: MainNumber::of_draws(summary, draws, self.level()),
                    prior_led: summary.prior.as_ref().is_some_and(PriorSummary::leads),
                })
            })
        });
        let mut parameters: Vec<MainParameter> = parameters.collect();
        withhold_unreached(&mut parameters, self.runs, self.level());
        let led = parameters
            .iter()
            .any(|own| own.quantity == Quantity::Shared(Coefficient::LubricationLog) && own.prior_led);
        let ratio = Quantity::DeltaCOverRoughness;
        let derived = posterior.derived.iter().zip(&found.derived);
        let of_ratio = derived
            .filter(|(draws, _)| draws.quantity == ratio)
            .map(|(draws, summary)| MainParameter {
                name: draws.name.clone(),
                quantity: ratio,
                sphere: None,
                from: None,
                number: MainNumber::of_draws(summary, &draws.values, self.level()),
                prior_led: led,
            });
        parameters.extend(of_ratio);
        parameters
    }

    /// k of a sphere that few dry runs alone tell: by the dry law, with Student's t. The posterior's interval knows less
    /// than they do, since the prior of their spread reaches far beyond it.
    fn of_few_dry_runs(&self, sphere: usize) -> Option<MainParameter> {
        let dry = self.least_squares.dry.iter().find(|dry| dry.sphere == sphere)?;
        let alone = self.runs.series_of(sphere).is_empty() && dry.runs < FEW_DRY_RUNS;
        (alone && dry.dry_k.interval.is_some()).then(|| MainParameter::of_dry(dry))
    }

    fn fitted_parameters(&self) -> Vec<MainParameter> {
        let dry = self.least_squares.dry.iter().map(MainParameter::of_dry);
        let of_balance = |name: String, quantity: Quantity, estimate: &Estimate| {
            MainParameter::of_fit(name, quantity, estimate, Source::EnergyBalance)
        };
        let balance = self.least_squares.energy_balance.as_ref();
        let shared = balance.iter().flat_map(|balance| &balance.parameters);
        let shared = shared.filter_map(|own| match own.kind {
            ParameterKind::Shared(of) => Some(of_balance(own.name.clone(), Quantity::Shared(of), &own.estimate)),
            _ => None,
        });
        let has_delta_c = self.scene.model.viscous.why_no_critical_separation().is_none();
        let ratio = Quantity::DeltaCOverRoughness;
        let of_ratio = balance.iter().filter(|_| has_delta_c).map(|balance| {
            let name = ratio.describe().name.to_owned();
            of_balance(name, ratio, &balance.delta_c_over_roughness)
        });
        dry.chain(shared).chain(of_ratio).collect()
    }

    /// The places in the order of the film groups: at each the law, where it serves, then the posterior for each liquid.
    fn places(&self) -> Vec<MainPlace> {
        let mut all = vec![];
        let laws = self.least_squares.scaling.iter().filter(|row| row.law == WetLaw::Sqrt);
        let laws = by_film_ratio(laws.filter_map(|row| Some((row.film_ratio?, row))));
        let balance = self.least_squares.energy_balance.as_ref();
        let stands = balance.filter(|own| own.verdict.passed);
        let derived = stands.into_iter().flat_map(|own| &own.derived);
        let derived = by_film_ratio(derived.map(|row| (row.film_ratio, row)));
        for group in &self.runs.film_groups {
            let law = self.law_of(group, &laws);
            let before = all.len();
            all.extend(
                law.filter(|law| self.law_serves(law))
                    .map(|law| self.of_law(group, law)),
            );
            if let Some(posterior) = self.posterior {
                all.extend(self.of_posterior(group, posterior));
            }
            if all.len() == before {
                all.extend(self.of_balance(group, &derived));
            }
            if all.len() == before {
                all.extend(law.map(|law| self.of_law(group, law)));
            }
        }
        all
    }

    fn law_of<'l>(&self, group: &FilmGroup, laws: &ByFilmRatio<&'l Scaling>) -> Option<&'l Scaling> {
        let sphere = &self.runs.spheres[group.sphere];
        let mut here = laws.get(&group.film_ratio.to_bits())?.iter().copied();
        here.find(|row| sphere.owns(self.scene, &row.particle, row.diameter_m))
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

    fn of_law(&self, group: &FilmGroup, law: &Scaling) -> MainPlace {
        let series = &self.runs.series[group.series.clone()];
        let is_alone = |one: &&Series| series.iter().all(|other| other.liquid == one.liquid);
        let of_one = series.first().filter(is_alone);
        let source = Source::SquareRootLaw;
        MainPlace {
            particle: law.particle.clone(),
            film_ratio: group.film_ratio,
            liquid: of_one.map(|one| self.scene.liquids[one.liquid].name.clone()),
            diameter_m: law.diameter_m,
            e_inf: MainNumber::of_fit(&law.e_inf, source),
            st_c: MainNumber::of_fit(&law.st_c, source),
            source,
        }
    }

    /// e_inf and St_c by the posterior, for each liquid of a film group and each diameter where they belong to one.
    fn of_posterior(&self, group: &FilmGroup, posterior: &Posterior) -> Vec<MainPlace> {
        let all = || posterior.derived.iter().zip(&posterior.findings.derived);
        let of = |quantity: Quantity| all().filter(move |(draws, _)| draws.quantity == quantity);
        let here = of(Quantity::EInf).filter_map(|(draws, summary)| {
            let setting = draws.setting.as_ref()?;
            let diameter = self.runs.spheres[group.sphere].diameter;
            let is_here = setting.particle == group.particle
                && setting.film_ratio == group.film_ratio
                && (diameter.is_none() || setting.diameter == diameter);
            is_here.then(|| {
                let number = |draws: &[Vec<f64>], summary| MainNumber::of_draws(summary, draws, self.level());
                let st_c = of(Quantity::StC).find(|(other, _)| other.setting.as_ref() == Some(setting));
                MainPlace {
                    particle: self.scene.particles[setting.particle].name.clone(),
                    film_ratio: setting.film_ratio,
                    liquid: Some(self.scene.liquids[setting.liquid].name.clone()),
                    diameter_m: setting.diameter,
                    e_inf: number(&draws.values, summary),
                    st_c: match st_c {
                        Some((draws, summary)) => number(&draws.values, summary),
                        None => MainNumber::withheld(NO_VISCOUS, self.level()),
                    },
                    source: Source::Posterior,
                }
            })
        });
        here.collect()
    }

    /// e_inf and St_c by least squares over all rebounds at once, at the mean density ratio.
    fn of_balance(&self, group: &FilmGroup, derived: &ByFilmRatio<&DerivedEstimate>) -> Vec<MainPlace> {
        let source = Source::EnergyBalance;
        let of_row = |row: &DerivedEstimate| MainPlace {
            particle: row.particle.clone(),
            film_ratio: row.film_ratio,
            liquid: None,
            diameter_m: row.diameter_m,
            e_inf: MainNumber::of_fit(&row.e_inf, source),
            st_c: MainNumber::of_fit(&row.st_c, source),
            source,
        };
        let here = derived.get(&group.film_ratio.to_bits()).into_iter().flatten();
        here.filter(|row| row.sphere == group.sphere)
            .map(|row| of_row(row))
            .collect()
    }
}

/// What stands at each film ratio, by its bits: a table may have as many as runs.
type ByFilmRatio<T> = HashMap<u64, Vec<T>>;

fn by_film_ratio<T>(rows: impl Iterator<Item = (f64, T)>) -> ByFilmRatio<T> {
    let mut all = ByFilmRatio::new();
    for (film_ratio, row) in rows {
        all.entry(film_ratio.to_bits()).or_insert_with(Vec::new).push(row);
    }
    all
}

/// Takes back C and δ̃0 where the inertial loss sets in over films that are all thinner than those of the runs: where it
/// has levelled off only its size is told, by which any other loss that goes with no film is taken for it.
fn withhold_unreached(parameters: &mut [MainParameter], runs: &Runs, level: f64) {
    const WHY: &str = "every film is thicker than δ̃0: no run tells how the loss sets in";
    let scale = Quantity::Shared(Coefficient::FilmScale);
    let ratios = runs.impacts.film_ratio.iter().copied();
    let thinnest = ratios.filter(|ratio| *ratio > 0.0).fold(f64::INFINITY, f64::min);
    let highest = |own: &MainParameter| Some(own.number.value? + own.number.se?);
    let mut scales = parameters.iter().filter(|own| own.quantity == scale);
    if !scales.any(|own| highest(own).is_some_and(|highest| highest < thinnest)) {
        return;
    }
    for own in parameters {
        if own.quantity == scale || own.quantity == Quantity::Shared(Coefficient::InertialPrefactor) {
            own.number = MainNumber::withheld(WHY, level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::Impacts;

    #[test]
    fn a_film_scale_below_every_film_takes_back_itself_and_c() {
        let shared = [
            Coefficient::LubricationLog,
            Coefficient::InertialPrefactor,
            Coefficient::FilmScale,
        ];
        let told = |scale: [f64; 2]| {
            let number = |[value, se]: [f64; 2]| Estimate {
                se: Some(se),
                ..Quoting { level: 0.95 }.without_se(Some(value), "")
            };
            let of = |(of, pair): (Coefficient, [f64; 2])| {
                let name = of.describe().name.to_owned();
                MainParameter::of_fit(name, Quantity::Shared(of), &number(pair), Source::Posterior)
            };
            let mut all: Vec<MainParameter> = shared
                .into_iter()
                .zip([[1.85, 0.1], [0.4, 0.02], scale])
                .map(of)
                .collect();
            for own in &mut all {
                own.number.se = Some(0.002);
            }
            let runs = Runs {
                impacts: Impacts {
                    film_ratio: vec![0.0, 0.03, 0.09],
                    ..Impacts::default()
                },
                ..Runs::default()
            };
            withhold_unreached(&mut all, &runs, 0.95);
            all.iter().map(|own| own.number.value.is_some()).collect::<Vec<bool>>()
        };
        assert_eq!(told([0.025, 0.002]), [true, false, false]);
        assert_eq!(told([0.029, 0.002]), [true; 3]);
        assert_eq!(told([0.069, 0.002]), [true; 3]);
    }
}
